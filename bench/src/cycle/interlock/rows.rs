//! The list of interlocks. A new one is a row in the file of its theme, its name here, and a test.

use super::{Interlock, data, electrical, motion};

/// Every interlock, in the order of first-out among those that trip in the same tick: what explains the others first.
pub const INTERLOCKS: &[Interlock] = &[
    data::BUS,
    data::STALE_DATA,
    electrical::EMERGENCY_STOP,
    data::MISSED_CYCLES,
    electrical::DRIVE_STATE,
    data::FROZEN_ENCODER,
    data::RATE_FEEDBACK,
    data::FROZEN_GYRO,
    data::RATE_DISAGREEMENT,
    data::TRACKER_LOST,
    electrical::UNCOMMANDED_TORQUE,
    motion::RUNAWAY,
    motion::BOUNDS_OF_DISPLACEMENT,
    motion::BOUNDS_OF_SPEED,
    motion::POSITION,
    motion::BRAKING_CURVE,
    motion::RESTRICTED_ZONE,
    motion::COAST_CURVE,
    motion::VELOCITY,
    motion::ACCELERATION,
    motion::FOLLOWING_ERROR,
    electrical::TORQUE,
    electrical::MEAN_TORQUE,
    electrical::TEMPERATURE,
    electrical::BUS_VOLTAGE,
    electrical::ENABLING_SWITCH,
    data::LIVENESS,
    data::LOG_RING,
];
