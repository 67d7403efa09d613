//! What kinds have in common that send an axis from place to place: segments, refusals, rows, measurements.

use std::collections::BTreeMap;

use crate::axis::{Axes, Axis, AxisLimits, Gimbal};
use crate::case::{Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::log::Window;
use crate::measurement::{Condition, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::Reason;
use crate::stimulus::{ProfileLimits, Stimulus};

mod record;
#[cfg(test)]
pub(in crate::kinds) mod tests;

pub(in crate::kinds) use record::{Record, mean_rad};

/// Condition of a point: its elevation.
pub(in crate::kinds) const ELEVATION: &str = "elevation";
/// Label of the rest before a point moves.
const REST: &str = "rest";
/// A target keeps this far from a soft limit: an axis is not exactly where its command is, and the interlock trips on
/// where it is.
pub(in crate::kinds) const CLEARANCE_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Below this nothing is called an overshoot (director.md, POS-OVS).
pub(in crate::kinds) const FLOOR_RAD: f64 = 3e-6;

/// The limits of an axis, or that the rig lacks it.
pub(in crate::kinds) fn limits_of<'a>(axis: &str, axes: &'a Axes) -> Result<&'a AxisLimits, Vec<Diagnostic>> {
    axes.get(axis).ok_or_else(|| {
        let known = axes.names().collect::<Vec<_>>().join(", ");
        vec![Diagnostic::new(format!("the rig has no axis `{axis}`")).help(format!("it has {known}"))]
    })
}

/// The profile of an axis at its limits, slower where asked.
pub(in crate::kinds) fn profile(
    limits: &AxisLimits,
    velocity_rad_per_s: f64,
    acceleration: f64,
) -> ProfileLimits {
    ProfileLimits {
        velocity_rad_per_s: velocity_rad_per_s.min(limits.max_velocity_rad_per_s),
        acceleration_rad_per_s2: acceleration.min(limits.max_acceleration_rad_per_s2),
        jerk_rad_per_s3: limits.max_jerk_rad_per_s3,
    }
}

/// A move from a place where the command stands.
pub(in crate::kinds) fn move_to(
    label: &str,
    from_rad: f64,
    target_rad: f64,
    limits: ProfileLimits,
) -> Segment {
    let stimulus = Stimulus::Move { target_rad, limits };
    // The stimulus ends by itself; a millisecond more keeps rounding from cutting it.
    let at_most_s = stimulus.duration_s(from_rad).unwrap_or(0.0) + 1e-3;
    Segment { stimulus, ..Segment::hold(label, Mode::Position, at_most_s) }
}

/// To where the point begins, slowly, and rest: enabled axes sag under their loads, and commands begin where the axis stands.
pub(in crate::kinds) fn take_place(at_rad: f64, rest_s: f64) -> [Segment; 2] {
    const LIMITS: ProfileLimits =
        ProfileLimits { velocity_rad_per_s: 0.02, acceleration_rad_per_s2: 0.05, jerk_rad_per_s3: 0.5 };
    /// More than a degree at that rate.
    const AT_MOST_S: f64 = 2.0;
    let stimulus = Stimulus::Move { target_rad: at_rad, limits: LIMITS };
    let there = Segment { stimulus, ..Segment::hold("take place", Mode::Position, AT_MOST_S) };
    [there, stay(REST, rest_s)]
}

/// The axis stays.
pub(in crate::kinds) fn stay(label: &str, for_s: f64) -> Segment {
    Segment::hold(label, Mode::Position, for_s)
}

/// The last segment ends the point.
pub(in crate::kinds) fn ended(mut segments: Vec<Segment>) -> Vec<Segment> {
    if let Some(last) = segments.last_mut() {
        last.then = Then::Stop;
    }
    segments
}

/// Outer and inner axis of the rig, for a kind that cannot do without them.
pub(in crate::kinds) fn gimbal_for<'a>(kind: &str, axes: &'a Axes) -> Result<Gimbal<'a>, Vec<Diagnostic>> {
    axes.gimbal().map_err(|lacking| {
        let message =
            format!("kind `{kind}` needs two axes, one carrying the other; the rig has {}", lacking.axes);
        let help = "set `carried-by` in the rig file, in the table of the carried axis";
        vec![Diagnostic::new(message).help(help)]
    })
}

/// Whose angle the elevation of a point is.
#[derive(Clone, Copy, Debug)]
pub(in crate::kinds) enum Elevation<'a> {
    /// The elevation is the angle of this axis, which the moved one carries.
    Carried(&'a Axis),
    /// The elevation is the angle of the moved axis itself, which another one carries.
    Own(&'a Axis),
    /// The rig has no axis whose angle would be an elevation for the moved one.
    Nobody,
}

impl<'a> Elevation<'a> {
    /// Whose it is when this axis moves.
    pub(in crate::kinds) fn of(axis: &str, axes: &'a Axes) -> Self {
        let own = axes.axis(axis).filter(|own| own.carried_by.is_some());
        match (axes.carries(axis), own) {
            (Some(carried), _) => Self::Carried(carried),
            (None, Some(own)) => Self::Own(own),
            (None, None) => Self::Nobody,
        }
    }

    /// The axis whose angle it is.
    pub(in crate::kinds) fn axis(self) -> Option<&'a Axis> {
        match self {
            Self::Carried(axis) | Self::Own(axis) => Some(axis),
            Self::Nobody => None,
        }
    }

    /// Whether the moved axis itself has the elevation.
    pub(in crate::kinds) fn is_own(self) -> bool {
        matches!(self, Self::Own(_))
    }

    /// The axis that holds the elevation while another one moves.
    pub(in crate::kinds) fn held(self) -> Option<&'a Axis> {
        match self {
            Self::Carried(axis) => Some(axis),
            Self::Own(_) | Self::Nobody => None,
        }
    }

    /// Mistake of a held elevation that lies outside the soft limits of its axis, or on one.
    pub(in crate::kinds) fn held_outside(self, elevation_rad: f64) -> Option<Diagnostic> {
        let held = self.held()?;
        outside(ELEVATION, elevation_rad, &held.name, &held.limits)
    }

    /// The condition of a point with a held elevation.
    pub(in crate::kinds) fn held_request(self, elevation_rad: f64) -> Option<Request> {
        self.held().map(|_| request(ELEVATION, elevation_rad, Q::Angle))
    }
}

/// Where all axes rest at the start: the moved one at a place, the one that it carries where asked, the others near zero.
pub(in crate::kinds) fn start_pose(
    axes: &Axes,
    axis: &str,
    at_rad: f64,
    elevation_rad: f64,
) -> BTreeMap<String, f64> {
    let held = Elevation::of(axis, axes).held().map(|held| held.name.as_str());
    axes.pose(|own| match own.name.as_str() {
        name if name == axis => at_rad,
        name if held == Some(name) => elevation_rad,
        _ => rest_rad(&own.limits),
    })
}

/// Angle 0, or the nearest one inside the soft limits.
pub(in crate::kinds) fn rest_rad(limits: &AxisLimits) -> f64 {
    let [low, high] = limits.soft_limits_rad;
    0.0_f64.max(low + CLEARANCE_RAD).min(high - CLEARANCE_RAD)
}

/// Mistake of a place that lies outside the soft limits of an axis, or on one.
pub(in crate::kinds) fn outside(
    what: &str,
    at_rad: f64,
    axis: &str,
    limits: &AxisLimits,
) -> Option<Diagnostic> {
    let [low, high] = limits.soft_limits_rad;
    let inner_low = low + CLEARANCE_RAD;
    let inner_high = high - CLEARANCE_RAD;
    // Written so that a place that is no number is outside.
    if at_rad >= inner_low - 1e-9 && at_rad <= inner_high + 1e-9 {
        return None;
    }
    let [at, low, high] = [at_rad, low, high].map(|rad| Q::Angle.format(rad));
    let message = format!("{what} {at} is on or outside the soft limits {low} .. {high} of axis `{axis}`");
    let room = Q::Angle.format(CLEARANCE_RAD);
    Some(Diagnostic::new(message).help(format!("stay at least {room} inside them")))
}

/// Mistake of a place that an axis cannot reach at all: beyond the ends of its travel.
pub(in crate::kinds) fn beyond_travel(what: &str, at_rad: f64, axis: &Axis) -> Option<Diagnostic> {
    let [low, high] = axis.limits.travel_rad;
    // Written so that a place that is no number is beyond.
    if at_rad >= low - 1e-9 && at_rad <= high + 1e-9 {
        return None;
    }
    let [at, low, high] = [at_rad, low, high].map(|rad| Q::Angle.format(rad));
    let message = format!("{what} {at} is outside the travel {low} .. {high} of axis `{}`", axis.name);
    Some(Diagnostic::new(message).help(format!("stay inside {low} .. {high}")))
}

/// A condition that was asked for.
pub(in crate::kinds) fn request(name: &str, value: f64, kind: Q) -> Request {
    Request { name: name.to_owned(), value, kind }
}

/// Names of the conditions with their values, as the name of a point.
pub(in crate::kinds) fn point_name(requested: &[Request]) -> String {
    requested.iter().map(|r| format!("{}={}", r.name, r.kind.format(r.value))).collect::<Vec<_>>().join(", ")
}

/// The conditions of a point as they were asked for.
pub(in crate::kinds) fn asked(case: &Case) -> Vec<Condition> {
    Condition::reached(case, |request| Some(request.value))
}

/// The conditions of a point with the elevation that its log holds; a kind sets what else it reached of them.
pub(in crate::kinds) fn conditions(case: &Case, window: &Window, axes: &Axes) -> Vec<Condition> {
    Condition::reached(case, |request| match request.name.as_str() {
        ELEVATION => elevation_rad(case, window, axes),
        _ => Some(request.value),
    })
}

/// Mean elevation of a point by the encoder: over all its segments where another axis moves, over the rest before the motion where
/// the elevation axis moves itself (`step`). `None` if the log has no such rows.
fn elevation_rad(case: &Case, window: &Window, axes: &Axes) -> Option<f64> {
    let elevation = Elevation::of(&case.axis, axes);
    let counted_s = match elevation.is_own() {
        true => Record::spans(case, window, REST).first().map(|span| [span.start_s, span.end_s])?,
        false => [window.segments.first()?.start_s, window.segments.last()?.end_s],
    };
    mean_rad(window, &elevation.axis()?.name, counted_s)
}

/// A measurand of a kind: name and kind of quantity.
pub(in crate::kinds) type Named = (&'static str, Q);

/// A point without numbers, and why.
pub(in crate::kinds) fn without(
    case: &Case,
    measurands: &[Named],
    estimator: &str,
    reason: &Reason,
) -> PointResult {
    PointResult::without(case, measurands, estimator, reason.clone()).under(&asked(case))
}

/// Whether a procedure of this kind can hold the gimbal on an axis that the rig has.
///
/// # Errors
/// A diagnostic with the axes that there are.
pub(in crate::kinds) fn check_axes(kind: &str, axis: &str, axes: &Axes) -> Result<(), Vec<Diagnostic>> {
    limits_of(axis, axes)?;
    gimbal_for(kind, axes).map(|_| ())
}

/// Where all axes stand: the gimbal at this azimuth and elevation, other axes near zero.
pub(in crate::kinds) fn poses(axes: &Axes, gimbal_rad: [f64; 2]) -> BTreeMap<String, f64> {
    axes.pose(|axis| match axes.gimbal_index(&axis.name) {
        Some(index) => gimbal_rad[index],
        None => rest_rad(&axis.limits),
    })
}
