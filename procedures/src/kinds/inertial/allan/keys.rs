//! What a procedure says, and the points: one at rest, one for each axis that creeps.

use std::collections::BTreeMap;

use crate::axis::Axes;
use crate::case::{Case, Mode, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned::{self, gimbal_for};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "duration",
        Shape::Quantity(Q::Time),
        "Time for which the director stands still, at least 20 s.",
    ),
    Field::default("azimuth", Shape::Quantity(Q::Angle), "0 deg", "Azimuth of the director."),
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Elevation of the director."),
    Field::optional(
        "latitude",
        Shape::Quantity(Q::Angle),
        "Latitude of the site; the bias is the mean rate less that of the Earth.",
    ),
    Field::default(
        "heading",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Heading of azimuth zero, clockwise from north.",
    ),
    Field::default("creep", Shape::Texts, "az, el", "Axes whose encoder resolution is measured."),
];

/// Shorter records hold no six averaging times.
const LEAST_DURATION_S: f64 = 20.0;

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) duration_s: f64,
    pub(super) azimuth_rad: f64,
    pub(super) elevation_rad: f64,
    pub(super) latitude_rad: Option<f64>,
    pub(super) heading_rad: f64,
    pub(super) creep: Vec<String>,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let duration_s = table.positive("duration");
        let azimuth_rad = table.quantity("azimuth");
        let elevation_rad = table.quantity("elevation");
        let latitude_rad = if table.has("latitude") { Some(table.quantity("latitude")?) } else { None };
        let heading_rad = table.quantity("heading");
        let creep = table.texts("creep");
        if duration_s.is_some_and(|s| s < LEAST_DURATION_S) {
            table.mistake("duration", format!("`duration` must be {LEAST_DURATION_S} s or more"), None);
        }
        if latitude_rad.is_some_and(|l| l.abs() > std::f64::consts::FRAC_PI_2) {
            table.mistake("latitude", "a latitude lies between -90 deg and 90 deg", None);
        }
        Some(Self {
            duration_s: duration_s?,
            azimuth_rad: azimuth_rad?,
            elevation_rad: elevation_rad?,
            latitude_rad,
            heading_rad: heading_rad?,
            creep: creep?,
        })
    }
}

/// Label of the segment that is evaluated.
pub(super) const STILL: &str = "still";
pub(super) const CREEP: &str = "creep";
const SETTLE: &str = "settle";
const SETTLE_S: f64 = 2.0;
/// Way and time of a creep: 50 counts of 26 bit a second.
const CREEP_RAD: f64 = 50e-6;
const CREEP_S: f64 = 10.0;
/// The creep reaches its velocity within this time.
const RISE_S: f64 = 1.0;
/// The way to where the creep begins: friction and play leave an axis that came to its pose some 60 urad beside it, which is more than
/// the creep is long.
const APPROACH: ProfileLimits =
    ProfileLimits { velocity_rad_per_s: 1e-3, acceleration_rad_per_s2: 1e-2, jerk_rad_per_s3: 1e-1 };

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    gimbal_for("allan", axes)?;
    let unknown = |name: &str| {
        let known = axes.names().collect::<Vec<_>>().join(", ");
        Diagnostic::new(format!("the rig has no axis `{name}` (it has {known})"))
    };
    let named = keys.creep.iter().map(String::as_str).chain([axis]);
    let mistakes: Vec<Diagnostic> = named.filter(|name| axes.get(name).is_none()).map(unknown).collect();
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let still = Segment { then: Then::Stop, ..Segment::hold(STILL, Mode::Position, keys.duration_s) };
    let settle = Segment::hold(SETTLE, Mode::Position, SETTLE_S);
    let rest = case(keys, axes, axis, STILL.to_owned(), vec![settle, still]);
    let pose_rad = pose(keys, axes);
    let pose = |name: &str| pose_rad.get(name).copied().unwrap_or(0.0);
    let creeps =
        keys.creep.iter().map(|name| case(keys, axes, name, format!("{CREEP} {name}"), creep(pose(name))));
    Ok([rest].into_iter().chain(creeps).collect())
}

/// Whether a case is there for its encoder.
pub(super) fn is_creep(case: &Case) -> bool {
    case.segments.last().is_some_and(|segment| segment.label == CREEP)
}

fn pose(keys: &Keys, axes: &Axes) -> BTreeMap<String, f64> {
    positioned::poses(axes, [keys.azimuth_rad, keys.elevation_rad])
}

fn case(keys: &Keys, axes: &Axes, axis: &str, point: String, segments: Vec<Segment>) -> Case {
    Case {
        point,
        axis: axis.to_owned(),
        start_pose_rad: pose(keys, axes),
        segments,
        logs_payload_fully: true,
        ..Case::default()
    }
}

/// To the pose, and from there over a few counts a row.
fn creep(from_rad: f64) -> Vec<Segment> {
    let settle = Segment {
        stimulus: Stimulus::Move { target_rad: from_rad, limits: APPROACH },
        ..Segment::hold(SETTLE, Mode::Position, SETTLE_S)
    };
    let velocity = CREEP_RAD / CREEP_S;
    let limits = ProfileLimits {
        velocity_rad_per_s: velocity,
        acceleration_rad_per_s2: velocity / RISE_S,
        jerk_rad_per_s3: velocity / RISE_S / RISE_S,
    };
    let creep = Segment {
        stimulus: Stimulus::Move { target_rad: from_rad + CREEP_RAD, limits },
        then: Then::Stop,
        ..Segment::hold(CREEP, Mode::Position, CREEP_S + 4.0 * RISE_S)
    };
    vec![settle, creep]
}
