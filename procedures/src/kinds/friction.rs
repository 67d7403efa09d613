//! Friction: while sliding, at breakaway, against a force gauge, against a model.

pub(in crate::kinds) mod breakaway;
pub(in crate::kinds) mod hysteresis;
pub(in crate::kinds) mod model_check;
pub(in crate::kinds) mod torque_constant;
