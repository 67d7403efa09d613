//! What a procedure says, and the points: azimuth at each elevation, then elevation.

use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned::{self, gimbal_for, limits_of};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "elevation",
        Shape::Quantities(Q::Angle),
        "Elevations at which azimuth spins, a point each.",
    ),
    Field::required("velocity", Shape::Quantity(Q::AngularVelocity), "Velocity of the strokes."),
    Field::default("acceleration", Shape::Quantity(Q::AngularAcceleration), "20 deg/s^2", "At the turns."),
    Field::required("span", Shape::Range(Q::Angle), "Where azimuth turns back."),
    Field::optional(
        "elevation-span",
        Shape::Range(Q::Angle),
        "Where elevation does; no elevation spin without it.",
    ),
    Field::default("cycles", Shape::Integer, "2", "Full cycles of each spin."),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) elevations_rad: Vec<f64>,
    pub(super) velocity_rad_per_s: f64,
    pub(super) acceleration_rad_per_s2: f64,
    pub(super) span_rad: [f64; 2],
    pub(super) elevation_span_rad: Option<[f64; 2]>,
    pub(super) cycles: u32,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let elevations_rad = table.quantities("elevation");
        let velocity = table.positive("velocity");
        let acceleration = table.positive("acceleration");
        let span_rad = table.range("span");
        let elevation_span_rad =
            if table.has("elevation-span") { Some(table.range("elevation-span")?) } else { None };
        let cycles = table.count("cycles", 1);
        Some(Self {
            elevations_rad: elevations_rad?,
            velocity_rad_per_s: velocity?,
            acceleration_rad_per_s2: acceleration?,
            span_rad: span_rad?,
            elevation_span_rad,
            cycles: cycles?,
        })
    }
}

/// Label of the segment that is evaluated.
pub(super) const SPIN: &str = "spin";
const SETTLE: &str = "settle";
const SETTLE_S: f64 = 1.0;
/// The acceleration of a turn grows within this time: slow against the first modes of the structure.
const RISE_S: f64 = 0.2;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    limits_of(axis, axes)?;
    let [outer, inner] = gimbal_for("imu-consistency", axes)?.names();
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
    let mut cases: Vec<Case> = keys
        .elevations_rad
        .iter()
        .map(|&elevation| {
            let point = format!("azimuth, elevation={}", Q::Angle.format(elevation));
            let asked = Request { name: "elevation".to_owned(), value: elevation, kind: Q::Angle };
            let poses = [keys.span_rad[0], elevation];
            Case { requested: vec![asked], ..case(keys, axes, point, (outer, keys.span_rad), poses) }
        })
        .collect();
    if let Some(span) = keys.elevation_span_rad {
        let poses = [middle(keys.span_rad), span[0]];
        cases.push(case(keys, axes, "elevation".to_owned(), (inner, span), poses));
    }
    Ok(cases)
}

/// Strokes of an axis over a span, with azimuth and elevation at these poses before.
fn case(
    keys: &Keys,
    axes: &Axes,
    point: String,
    (axis, [from_rad, to_rad]): (&str, [f64; 2]),
    gimbal_rad: [f64; 2],
) -> Case {
    let most = axes.get(axis).map_or(f64::INFINITY, |limits| limits.max_acceleration_rad_per_s2);
    let acceleration_rad_per_s2 = keys.acceleration_rad_per_s2.min(most);
    let most = axes.get(axis).map_or(f64::INFINITY, |limits| limits.max_jerk_rad_per_s3);
    let limits = ProfileLimits {
        velocity_rad_per_s: keys.velocity_rad_per_s,
        acceleration_rad_per_s2,
        jerk_rad_per_s3: (acceleration_rad_per_s2 / RISE_S).min(most),
    };
    let stimulus = Stimulus::Reversals { from_rad, to_rad, limits, cycles: keys.cycles };
    let lasts_s = stimulus.duration_s(from_rad).unwrap_or(0.0);
    let spin =
        Segment { stimulus, then: Then::Stop, ..Segment::hold(SPIN, Mode::Position, 1.05 * lasts_s + 1.0) };
    Case {
        point,
        axis: axis.to_owned(),
        start_pose_rad: positioned::poses(axes, gimbal_rad),
        segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), spin],
        ..Case::default()
    }
}
