//! Points: one a velocity (and pose), ascending, each from where the one before ends.

use std::f64::consts::{PI, TAU};

use super::sweep::{Reach, Sweep};
use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Profile, ProfileLimits, Stimulus};

/// Label of the segment that goes to the start of the strokes.
pub(super) const APPROACH: &str = "approach";
/// Label of the segment with all strokes.
pub(super) const STROKES: &str = "strokes";
/// Time that a stroke gets to settle on its plateau, where each velocity gets the span it needs.
const SETTLE_S: f64 = 0.5;
/// The same in cogging periods, for slow strokes.
const SETTLE_PERIODS: f64 = 1.0;
/// Approaches use this share of the largest velocity.
const APPROACH_SHARE: f64 = 0.5;
/// Static friction over torque quantum that friction needs (director study, settings of the drive scaling).
const QUANTA_IN_FRICTION: f64 = 300.0;

/// The points of a sweep on an axis.
pub(super) fn plan(sweep: &Sweep, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let Some(limits) = axes.get(axis) else {
        let known = axes.names().collect::<Vec<_>>().join(", ");
        return Err(vec![
            Diagnostic::new(format!("the rig has no axis `{axis}`")).help(format!("it has {known}")),
        ]);
    };
    let refused = refuse(sweep, limits);
    if !refused.is_empty() {
        return Err(refused);
    }
    let mut pose = axes.pose(|own| rest(sweep, &own.limits, own.name == axis));
    let mut cases = Vec::new();
    for (pose_rad, opposite) in poses(sweep) {
        for &velocity in &sweep.velocities_rad_per_s {
            let profile = profile(sweep, limits, velocity);
            let [from, to] = ends(sweep, limits, &profile, opposite);
            let start = pose.get(axis).copied().unwrap_or(0.0);
            cases.push(Case {
                point: name(velocity, pose_rad),
                axis: axis.to_owned(),
                requested: requests(velocity, pose_rad),
                start_pose_rad: pose.clone(),
                segments: segments(limits, start, [from, to], profile, sweep.cycles),
                ..Case::default()
            });
            pose.insert(axis.to_owned(), from);
        }
    }
    Ok(cases)
}

/// Poses to run: none named, or 0 and half a turn with the opposite span.
fn poses(sweep: &Sweep) -> Vec<(Option<f64>, Option<[f64; 2]>)> {
    match sweep.opposite_span_rad {
        None => vec![(None, None)],
        Some(opposite) => vec![(Some(0.0), None), (Some(PI), Some(opposite))],
    }
}

fn name(velocity: f64, pose_rad: Option<f64>) -> String {
    let velocity = format!("velocity={}", Q::AngularVelocity.format(velocity));
    match pose_rad {
        Some(pose) => format!("{velocity}, pose={}", Q::Angle.format(pose)),
        None => velocity,
    }
}

fn requests(velocity: f64, pose_rad: Option<f64>) -> Vec<Request> {
    let mut all = vec![Request { name: "velocity".into(), value: velocity, kind: Q::AngularVelocity }];
    all.extend(pose_rad.map(|value| Request { name: "pose".into(), value, kind: Q::Angle }));
    all
}

/// Where an axis rests before the first point: 0, or as asked for the other axes, inside its soft limits.
fn rest(sweep: &Sweep, limits: &AxisLimits, moves: bool) -> f64 {
    let [low, high] = limits.soft_limits_rad;
    let wanted = if moves { 0.0 } else { sweep.other_axis_pose_rad.unwrap_or(0.0) };
    wanted.max(low).min(high)
}

fn profile(sweep: &Sweep, limits: &AxisLimits, velocity_rad_per_s: f64) -> ProfileLimits {
    ProfileLimits {
        velocity_rad_per_s,
        acceleration_rad_per_s2: sweep.acceleration_rad_per_s2.unwrap_or(limits.max_acceleration_rad_per_s2),
        jerk_rad_per_s3: sweep.jerk_rad_per_s3.unwrap_or(limits.max_jerk_rad_per_s3),
    }
}

/// Strokes that are fitted into the soft limits keep this far from them: a real axis is not exactly where its command
/// is, and the interlock trips on where it is.
const CLEARANCE_RAD: f64 = 0.1 * PI / 180.0;

/// Where the strokes of one velocity turn.
///
/// With `periods`: ramps, settling at both ends (each end is the start of one direction) and the whole periods,
/// about the centre, moved and cut where the soft limits are near. What a cut leaves is run and judged.
fn ends(sweep: &Sweep, limits: &AxisLimits, profile: &ProfileLimits, opposite: Option<[f64; 2]>) -> [f64; 2] {
    let (count, centre) = match sweep.reach {
        Reach::Span(span) => return opposite.unwrap_or(span),
        Reach::Periods { count, centre_rad } => (f64::from(count), centre_rad),
        Reach::Imported => (1.0, 0.0),
    };
    let period = TAU / limits.cogging_orders_per_rev;
    let settle = (SETTLE_S * profile.velocity_rad_per_s).max(SETTLE_PERIODS * period);
    let half = ramp_rad(profile) + settle + count * period / 2.0;
    let [low, high] = limits.soft_limits_rad;
    let (low, high) = (low + CLEARANCE_RAD, high - CLEARANCE_RAD);
    let half = half.min((high - low) / 2.0);
    let centre = centre.max(low + half).min(high - half);
    [(centre - half).max(low), (centre + half).min(high)]
}

/// Way from rest to the plateau velocity.
fn ramp_rad(profile: &ProfileLimits) -> f64 {
    // Long enough to cruise: a ramp within these limits is shorter than v²/a + v·a/j + its own jerk phases.
    let (v, a, j) = (profile.velocity_rad_per_s, profile.acceleration_rad_per_s2, profile.jerk_rad_per_s3);
    let long = 4.0 * (v * v / a + v * a / j + v * (v / j).sqrt());
    let whole = Profile::new(long, profile);
    (long - v * whole.cruise_s()) / 2.0
}

fn segments(
    limits: &AxisLimits,
    start: f64,
    ends: [f64; 2],
    profile: ProfileLimits,
    cycles: u32,
) -> Vec<Segment> {
    let approach = ProfileLimits {
        velocity_rad_per_s: APPROACH_SHARE * limits.max_velocity_rad_per_s,
        acceleration_rad_per_s2: profile.acceleration_rad_per_s2,
        jerk_rad_per_s3: profile.jerk_rad_per_s3,
    };
    let [from_rad, to_rad] = ends;
    vec![
        segment(APPROACH, Stimulus::Move { target_rad: from_rad, limits: approach }, start, Then::Hold),
        segment(
            STROKES,
            Stimulus::Reversals { from_rad, to_rad, limits: profile, cycles },
            from_rad,
            Then::Stop,
        ),
    ]
}

fn segment(label: &str, stimulus: Stimulus, start: f64, then: Then) -> Segment {
    Segment {
        label: label.to_owned(),
        mode: Mode::Position,
        at_most_s: stimulus.duration_s(start).unwrap_or(0.0) * 1.05 + 1.0,
        stimulus,
        until: None,
        then,
        dithered: false,
        ..Segment::default()
    }
}

/// What the axis cannot do.
fn refuse(sweep: &Sweep, limits: &AxisLimits) -> Vec<Diagnostic> {
    if sweep.imported() {
        let help = "add `[sweep]` with velocities and a span to run it";
        let message = "the procedure has no `[sweep]`: it judges imported records only";
        return vec![Diagnostic::new(message).help(help)];
    }
    let mut found = too_much(sweep, limits);
    let spans = match sweep.reach {
        Reach::Span(span) => [("span", Some(span)), ("opposite-span", sweep.opposite_span_rad)],
        Reach::Periods { centre_rad, .. } => [("centre", Some([centre_rad; 2])), ("opposite-span", None)],
        Reach::Imported => [("span", None), ("opposite-span", None)],
    };
    for (name, span) in spans {
        found.extend(span.and_then(|span| outside(name, span, limits)));
    }
    let quantum = limits.torque_quantum_nm;
    let finest = limits.expected_static_friction_nm / QUANTA_IN_FRICTION;
    if quantum > finest {
        let message = format!(
            "torque quantum {} is coarser than 1/300 of the expected static friction, {}",
            Q::Torque.format(quantum),
            Q::Torque.format(finest)
        );
        found.push(Diagnostic::new(message).help("scale the drive's rated torque (6076h) down"));
    }
    found
}

/// Velocities, acceleration and jerk above those of the axis.
fn too_much(sweep: &Sweep, limits: &AxisLimits) -> Vec<Diagnostic> {
    let velocities = sweep
        .velocities_rad_per_s
        .iter()
        .map(|&v| ("velocity", Q::AngularVelocity, Some(v), limits.max_velocity_rad_per_s));
    let (a, j) = (sweep.acceleration_rad_per_s2, sweep.jerk_rad_per_s3);
    velocities
        .chain([
            ("acceleration", Q::AngularAcceleration, a, limits.max_acceleration_rad_per_s2),
            ("jerk", Q::AngularJerk, j, limits.max_jerk_rad_per_s3),
        ])
        .filter_map(|(name, kind, asked, most)| {
            let asked = asked.filter(|a| *a > most * (1.0 + 1e-9))?;
            Some(excess(name, kind, asked, most))
        })
        .collect()
}

fn excess(name: &str, kind: Q, asked: f64, most: f64) -> Diagnostic {
    let (asked, most) = (kind.format(asked), kind.format(most));
    Diagnostic::new(format!("{name} {asked} is above the axis' {most}")).help(format!("at most {most}"))
}

fn outside(name: &str, span: [f64; 2], limits: &AxisLimits) -> Option<Diagnostic> {
    let [low, high] = limits.soft_limits_rad;
    if span[0] >= low - 1e-9 && span[1] <= high + 1e-9 {
        return None;
    }
    let text = |range: [f64; 2]| format!("{} .. {}", Q::Angle.format(range[0]), Q::Angle.format(range[1]));
    let soft = text(limits.soft_limits_rad);
    let message = format!("{name} {} leaves the axis' soft limits {soft}", text(span));
    Some(Diagnostic::new(message).help(format!("stay inside {soft}")))
}
