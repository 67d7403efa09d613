//! What a polarity procedure says, and how it is read.

use std::collections::BTreeMap;

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
    Field::optional(
        "pose",
        Shape::Map(&Shape::Text),
        "Poses of axes by name, `{ roll = \"20 deg\" }`, before those of the other two keys; every axis beyond the second has one.",
    ),
];

/// A polarity procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    /// Poses by name of the axis.
    pub(super) poses_rad: BTreeMap<String, f64>,
    pub(super) pose_az_rad: f64,
    pub(super) pose_el_rad: f64,
}

impl Keys {
    /// Reads the kind's keys; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let pose_az_rad = table.quantity(POSE_KEYS[0]);
        let pose_el_rad = table.quantity(POSE_KEYS[1]);
        let mut poses_rad = BTreeMap::new();
        let written = if table.has("pose") { table.map("pose")? } else { Vec::new() };
        for (axis, text, span) in written {
            match Q::Angle.parse(&text) {
                Ok(pose_rad) => drop(poses_rad.insert(axis, pose_rad)),
                Err(error) => table.mistake_at(span, error.to_string(), None),
            }
        }
        Some(Self { poses_rad, pose_az_rad: pose_az_rad?, pose_el_rad: pose_el_rad? })
    }

    /// Where azimuth and elevation stand.
    pub(super) fn gimbal_rad(&self) -> [f64; 2] {
        [self.pose_az_rad, self.pose_el_rad]
    }

    /// Where an axis stands, and the key that says it; `place` is its place in the pair of axes that have keys of their own.
    pub(super) fn pose(&self, name: &str, place: Option<usize>) -> Option<(String, f64)> {
        match (self.poses_rad.get(name), place) {
            (Some(&pose_rad), _) => Some((format!("pose.{name}"), pose_rad)),
            (None, Some(place)) => Some((POSE_KEYS[place].to_owned(), self.gimbal_rad()[place])),
            (None, None) => None,
        }
    }
}
