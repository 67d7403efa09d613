//! What a polarity procedure says, and how it is read.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// Keys of the poses of azimuth and elevation.
pub(super) const POSE_KEYS: [&str; 2] = ["pose-az", "pose-el"];

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default(
        POSE_KEYS[0],
        Shape::Quantity(Q::Angle),
        "20 deg",
        "Azimuth, or the first axis of a rig without gimbal: at least 30 deg from its soft limits, and not where the encoder counts \
         zero. An axis that no gyro sees is proven by its encoder alone: signs and torque scale, not counts per turn.",
    ),
    Field::default(
        POSE_KEYS[1],
        Shape::Quantity(Q::Angle),
        "40 deg",
        "Elevation: at least 30 deg from its soft limits, where friction holds the load (near the spring's rest).",
    ),
];

/// A polarity procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) pose_az_rad: f64,
    pub(super) pose_el_rad: f64,
}

impl Keys {
    /// Reads the kind's keys; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let pose_az_rad = table.quantity(POSE_KEYS[0]);
        let pose_el_rad = table.quantity(POSE_KEYS[1]);
        Some(Self { pose_az_rad: pose_az_rad?, pose_el_rad: pose_el_rad? })
    }

    /// Where azimuth and elevation stand.
    pub(super) fn gimbal_rad(&self) -> [f64; 2] {
        [self.pose_az_rad, self.pose_el_rad]
    }
}
