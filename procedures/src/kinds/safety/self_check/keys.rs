//! What a procedure says, and the one point, in which nothing moves.

use super::channels::MEASURANDS;
use crate::axis::Axes;
use crate::case::{Case, Mode, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned::{self, limits_of};
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader, suggestion};

pub(super) const FIELDS: &[Field] = &[
    Field::default("duration", Shape::Quantity(Q::Time), "3 s", "Time for which all channels are recorded."),
    Field::default("azimuth", Shape::Quantity(Q::Angle), "0 deg", "Azimuth of the director meanwhile."),
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Elevation of the director meanwhile."),
    Field::optional(
        "drift",
        Shape::Map(&Shape::Text),
        "Largest allowed change since the earlier self-check, by measurand: `gyro-offset = \"0.002 deg/s\"`.",
    ),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) duration_s: f64,
    pub(super) azimuth_rad: f64,
    pub(super) elevation_rad: f64,
    /// Allowed changes by measurand, in the SI unit of its kind.
    pub(super) drift: Vec<(&'static str, f64)>,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let duration_s = table.positive("duration");
        let azimuth_rad = table.quantity("azimuth");
        let elevation_rad = table.quantity("elevation");
        let written = if table.has("drift") { table.map("drift")? } else { Vec::new() };
        let mut drift = Vec::new();
        for (name, text, span) in written {
            let Some(known) = MEASURANDS.iter().find(|m| m.name == name) else {
                let help = suggestion(&name, MEASURANDS.iter().map(|m| m.name));
                table.mistake_at(span, format!("a self-check has no measurand `{name}`"), Some(help));
                continue;
            };
            match known.kind.parse(&text) {
                Ok(allowed) if allowed > 0.0 => drift.push((known.name, allowed)),
                Ok(_) => table.mistake_at(span, format!("`{name}` must be above zero"), None),
                Err(error) => table.mistake_at(span, error.to_string(), None),
            }
        }
        Some(Self {
            duration_s: duration_s?,
            azimuth_rad: azimuth_rad?,
            elevation_rad: elevation_rad?,
            drift,
        })
    }
}

/// Label of the stretch that is evaluated.
pub(super) const REST: &str = "rest";
/// An axis whose drive was just enabled may still sag under its load.
const SETTLE_S: f64 = 1.5;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    limits_of(axis, axes)?;
    let rest = Segment { then: Then::Stop, ..Segment::hold(REST, Mode::Torque, keys.duration_s) };
    Ok(vec![Case {
        point: REST.to_owned(),
        axis: axis.to_owned(),
        start_pose_rad: positioned::poses(axes, [keys.azimuth_rad, keys.elevation_rad]),
        segments: vec![Segment::hold("settle", Mode::Torque, SETTLE_S), rest],
        open_loop: true,
        logs_payload_fully: true,
        ..Case::default()
    }])
}
