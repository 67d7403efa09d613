//! The mirror by itself: impedance of its actuators, response of its servo.

pub(in crate::kinds) mod fsm_impedance;
pub(in crate::kinds) mod fsm_response;
