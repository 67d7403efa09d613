//! What a polarity procedure says, and how it is read.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default(
        "pose-az",
        Shape::Quantity(Q::Angle),
        "20 deg",
        "Azimuth: at least 30 deg from its soft limits, and not where the encoder counts zero.",
    ),
    Field::default(
        "pose-el",
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
        let pose_az_rad = table.quantity("pose-az");
        let pose_el_rad = table.quantity("pose-el");
        Some(Self { pose_az_rad: pose_az_rad?, pose_el_rad: pose_el_rad? })
    }

    /// Where an axis stands; 0 for one that is neither azimuth nor elevation.
    pub(super) fn pose_rad(&self, axis: &str) -> f64 {
        match axis {
            "az" => self.pose_az_rad,
            "el" => self.pose_el_rad,
            _ => 0.0,
        }
    }
}
