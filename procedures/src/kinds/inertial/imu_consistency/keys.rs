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
        "Elevations at which azimuth moves, one point each.",
    ),
    Field::required("velocity", Shape::Quantity(Q::AngularVelocity), "Velocity of the strokes."),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "20 deg/s^2",
        "Acceleration at the reversals.",
    ),
    Field::required("span", Shape::Range(Q::Angle), "Angles at which azimuth reverses."),
    Field::optional(
        "elevation-span",
        Shape::Range(Q::Angle),
        "Angles at which elevation reverses; without it elevation is not moved.",
    ),
    Field::default("cycles", Shape::Integer, "2", "Full cycles at each elevation."),
    Field::optional(
        "encoder-pitches",
        Shape::Quantity(Q::SpatialOrder),
        "Pitches per revolution of the encoders' scales, to measure errors within a pitch; without it they \
         are not measured.",
    ),
    Field::default(
        "slow-velocity",
        Shape::Quantity(Q::AngularVelocity),
        "0.1 deg/s",
        "Velocity of the slow stroke over the pitches.",
    ),
    Field::default(
        "slow-span",
        Shape::Quantity(Q::Angle),
        "1 deg",
        "Length of the slow stroke, once out and back.",
    ),
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
    pub(super) slow: Option<Slow>,
}

/// A stroke over the pitches of an encoder, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Slow {
    pub(super) pitches_per_rev: f64,
    pub(super) velocity_rad_per_s: f64,
    pub(super) span_rad: f64,
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
        let has_pitches = table.has("encoder-pitches");
        let pitches = if has_pitches { Some(table.positive("encoder-pitches")?) } else { None };
        let slow_velocity = table.positive("slow-velocity");
        let slow_span = table.positive("slow-span");
        let slow = Slow {
            pitches_per_rev: pitches.unwrap_or(0.0),
            velocity_rad_per_s: slow_velocity?,
            span_rad: slow_span?,
        };
        Some(Self {
            elevations_rad: elevations_rad?,
            velocity_rad_per_s: velocity?,
            acceleration_rad_per_s2: acceleration?,
            span_rad: span_rad?,
            elevation_span_rad,
            cycles: cycles?,
            slow: has_pitches.then_some(slow),
        })
    }
}

/// Label of the segment that is evaluated.
pub(super) const SPIN: &str = "spin";
/// Label of the segment in which the axis passes the pitches of its encoder.
pub(super) const SLOW: &str = "slow";
/// Label of the rest before each stroke, in which the accelerometers feel gravity alone.
pub(super) const SETTLE: &str = "settle";
const SETTLE_S: f64 = 5.0;
/// The acceleration of a turn grows within this time: slow against the first modes of the structure.
const RISE_S: f64 = 0.2;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    limits_of(axis, axes)?;
    let [outer, inner] = gimbal_for("imu-consistency", axes)?.names();
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
    let stroke = Stroke {
        label: SPIN,
        velocity_rad_per_s: keys.velocity_rad_per_s,
        acceleration_rad_per_s2: keys.acceleration_rad_per_s2,
        cycles: keys.cycles,
    };
    let mut cases: Vec<Case> = keys
        .elevations_rad
        .iter()
        .map(|&elevation| {
            let point = format!("azimuth, elevation={}", Q::Angle.format(elevation));
            let asked = Request { name: "elevation".to_owned(), value: elevation, kind: Q::Angle };
            let poses = [keys.span_rad[0], elevation];
            Case { requested: vec![asked], ..stroke.case(axes, &point, outer, keys.span_rad, poses) }
        })
        .collect();
    if let Some(span) = keys.elevation_span_rad {
        let poses = [middle(keys.span_rad), span[0]];
        cases.push(stroke.case(axes, "elevation", inner, span, poses));
    }
    if let Some(slow) = &keys.slow {
        let stroke = Stroke { label: SLOW, velocity_rad_per_s: slow.velocity_rad_per_s, cycles: 1, ..stroke };
        let azimuth = middle(keys.span_rad);
        let elevation = keys.elevations_rad.first().copied().unwrap_or(0.0);
        let span = [azimuth, azimuth + slow.span_rad];
        cases.push(stroke.case(axes, "azimuth, slow", outer, span, [azimuth, elevation]));
        // As far from the other rests as may be: zero and biases are told from gravity by elevations.
        let top = keys.elevation_span_rad.map_or(elevation, |[_, top]| top);
        let span = [top - slow.span_rad, top];
        cases.push(stroke.case(axes, "elevation, slow", inner, span, [azimuth, span[0]]));
    }
    Ok(cases)
}

/// How an axis goes back and forth.
struct Stroke {
    label: &'static str,
    velocity_rad_per_s: f64,
    acceleration_rad_per_s2: f64,
    cycles: u32,
}

impl Stroke {
    /// Strokes of an axis over a span, with azimuth and elevation at these poses before.
    fn case(
        &self,
        axes: &Axes,
        point: &str,
        axis: &str,
        [from_rad, to_rad]: [f64; 2],
        gimbal_rad: [f64; 2],
    ) -> Case {
        let most = axes.get(axis).map_or(f64::INFINITY, |limits| limits.max_acceleration_rad_per_s2);
        let acceleration_rad_per_s2 = self.acceleration_rad_per_s2.min(most);
        let most = axes.get(axis).map_or(f64::INFINITY, |limits| limits.max_jerk_rad_per_s3);
        let limits = ProfileLimits {
            velocity_rad_per_s: self.velocity_rad_per_s,
            acceleration_rad_per_s2,
            jerk_rad_per_s3: (acceleration_rad_per_s2 / RISE_S).min(most),
        };
        let stimulus = Stimulus::Reversals { from_rad, to_rad, limits, cycles: self.cycles };
        let lasts_s = stimulus.duration_s(from_rad).unwrap_or(0.0);
        let most_s = 1.05 * lasts_s + 1.0;
        let stroke =
            Segment { stimulus, then: Then::Stop, ..Segment::hold(self.label, Mode::Position, most_s) };
        Case {
            point: point.to_owned(),
            axis: axis.to_owned(),
            start_pose_rad: positioned::poses(axes, gimbal_rad),
            segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), stroke],
            ..Case::default()
        }
    }
}
