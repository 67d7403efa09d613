//! What a planned point asks of the axes, against what the rig allows.

use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Mode, Segment};
use crate::diagnostic::Diagnostic;
use crate::quantity::QuantityKind;
use crate::stimulus::Stimulus;
use crate::table::suggestion;

/// A value may lie above its limit by this part of it: both went through unit conversion.
const ROUNDING: f64 = 1e-9;

/// Longest point: nobody waits longer for one number, and a typing mistake in a velocity soon asks for years.
const LONGEST_S: f64 = 24.0 * 3600.0;

/// Longest time in a point for which moves are sampled to find their worst instants.
const LONGEST_MOTION_S: f64 = 4.0 * 3600.0;

/// Longest time in all points of a procedure.
const LONGEST_PROCEDURE_S: f64 = 24.0 * 3600.0;

/// Most segments of all points of a procedure.
const MOST_SEGMENTS: usize = 100_000;

/// Samples times lines of all multisines of a procedure: twice the largest shipped one.
const MOST_PEAK_WORK: f64 = 5e8;

/// Every limit that the case would cross, with the point, what it asks and what is allowed.
pub(super) fn excesses(case: &Case, axes: &Axes) -> Vec<Diagnostic> {
    let mut all = excesses_of_own(case, axes);
    for axis in case.moved_axes().into_iter().skip(1) {
        // Where the others stand was looked at already.
        let start_pose_rad = case.start_pose_rad.iter().filter(|(name, _)| *name == axis);
        let start_pose_rad = start_pose_rad.map(|(name, &rad)| (name.clone(), rad)).collect();
        all.extend(excesses_of_own(&Case { start_pose_rad, ..case.seen_from(axis) }, axes));
    }
    all.extend(unaccompanied(case));
    all
}

/// Why all points together are too many or too long to be looked at one by one.
pub(super) fn too_long(cases: &[Case]) -> Option<Diagnostic> {
    let steps: usize = cases.iter().map(|case| case.segments.len()).sum();
    if steps > MOST_SEGMENTS {
        let message = format!("the procedure has {steps} segments; expected at most {MOST_SEGMENTS}");
        return Some(Diagnostic::new(message).help("split it into several procedures"));
    }
    let signals = cases.iter().flat_map(|case| &case.excitations);
    let work: f64 = signals.map(|excitation| excitation.signal.peak_work()).sum();
    if work > MOST_PEAK_WORK {
        let message = format!(
            "the multisines of the procedure have {work:.1e} samples times lines to be searched for their peaks; expected at most {MOST_PEAK_WORK:.0e}"
        );
        let help = "use fewer levels, elevations, realisations or lines, or split it into several procedures";
        return Some(Diagnostic::new(message).help(help));
    }
    let moving_s: f64 = cases.iter().map(motion_s).sum();
    let is_long = moving_s > LONGEST_PROCEDURE_S;
    let message = format!(
        "the points of the procedure move for {} together; expected at most {}",
        QuantityKind::Time.format(moving_s),
        QuantityKind::Time.format(LONGEST_PROCEDURE_S)
    );
    is_long.then(|| Diagnostic::new(message).help("use fewer points, or faster ones"))
}

/// Time of all moves, of strokes that repeat only once.
fn motion_s(case: &Case) -> f64 {
    let lasts_s = |segment: &Segment| match &segment.stimulus {
        Stimulus::Move { .. }
        | Stimulus::Step { .. }
        | Stimulus::Sine { .. }
        | Stimulus::Trajectory { .. } => segment.at_most_s,
        Stimulus::Reversals { cycles, .. } => segment.at_most_s / f64::from((*cycles).max(1)),
        _ => 0.0,
    };
    case.segments.iter().map(lasts_s).sum()
}

/// Segments in which another axis cannot move along.
fn unaccompanied(case: &Case) -> Option<Diagnostic> {
    let wrong = |s: &&Segment| {
        let alone = s.mode != Mode::Position || s.until.is_some() || s.task.is_some() || case.open_loop;
        s.companion.as_ref().is_some_and(|c| alone || c.axis == case.axis || !is_place(&c.stimulus))
    };
    let segment = case.segments.iter().find(wrong)?;
    let message =
        format!("point `{}`: no other axis can move along in segment `{}`", case.point, segment.label);
    let help = "both axes need position commands, and the segment must end by its time alone";
    Some(Diagnostic::new(message).help(help))
}

/// Nothing can be added to what a drive's own loop does.
fn excited_in_the_drive(case: &Case) -> Option<Diagnostic> {
    let wrong = |s: &&Segment| s.mode == Mode::DriveVelocity && s.excited.is_some();
    let segment = case.segments.iter().find(wrong)?;
    let message = format!(
        "point `{}`, segment `{}`: an excitation cannot be added where the drive closes the velocity loop",
        case.point, segment.label
    );
    Some(Diagnostic::new(message).help("use the velocity mode of the bench"))
}

fn is_place(stimulus: &Stimulus) -> bool {
    matches!(stimulus, Stimulus::Hold { .. } | Stimulus::Move { .. } | Stimulus::Reversals { .. })
}

fn excesses_of_own(case: &Case, axes: &Axes) -> Vec<Diagnostic> {
    let Some(limits) = axes.get(&case.axis) else { return vec![no_axis(case, &case.axis, axes)] };
    let envelope = case.envelope();
    let mut all = Vec::new();
    all.extend(travel(case, &case.axis, envelope.position_rad, limits));
    all.extend(beyond_travel(case, limits));
    all.extend(excited_in_the_drive(case));
    all.extend(too_fast_outside(case, limits).filter(|_| case.fence.is_some()));
    let magnitudes = [
        (
            "turns at",
            QuantityKind::AngularVelocity,
            envelope.velocity_rad_per_s,
            limits.max_velocity_rad_per_s,
        ),
        (
            "accelerates at",
            QuantityKind::AngularAcceleration,
            envelope.acceleration_rad_per_s2,
            limits.max_acceleration_rad_per_s2,
        ),
        ("drives with", QuantityKind::Torque, envelope.torque_nm, limits.max_torque_nm),
    ];
    for (does, kind, asked, allowed) in magnitudes {
        all.extend(excess(case, does, kind, asked, allowed));
    }
    all.extend(excess(case, "lasts", QuantityKind::Time, case.planned_s(), LONGEST_S));
    all.extend(excess(case, "moves for", QuantityKind::Time, motion_s(case), LONGEST_MOTION_S));
    for (axis, &pose_rad) in case.start_pose_rad.iter().filter(|(axis, _)| **axis != case.axis) {
        match axes.get(axis) {
            Some(limits) => all.extend(travel(case, axis, [pose_rad, pose_rad], limits)),
            None => all.push(no_axis(case, axis, axes)),
        }
    }
    all
}

fn excess(case: &Case, does: &str, kind: QuantityKind, asked: f64, allowed: f64) -> Option<Diagnostic> {
    if asked <= allowed * (1.0 + ROUNDING) {
        return None;
    }
    let message = format!(
        "point `{}` {does} {}: axis `{}` allows {}",
        case.point,
        kind.format(asked),
        case.axis,
        kind.format(allowed)
    );
    Some(Diagnostic::new(message).help(format!("use at most {}", kind.format(allowed))))
}

/// Rate at which an axis may move outside the rig's own soft limits, where a fence is wider: what stops it is never more
/// than a tenth of a degree away.
const CREEP_RAD_PER_S: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Rate between the rig's own soft limits, on the way there: as fast as homing.
const NEAR_RAD_PER_S: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// A move outside the rig's own soft limits that is no creeping.
fn too_fast_outside(case: &Case, limits: &AxisLimits) -> Option<Diagnostic> {
    let [low, high] = limits.soft_limits_rad;
    let slack = ROUNDING * (high - low).abs();
    let outside = |angle: f64| angle < low - slack || angle > high + slack;
    // Where the fence is wider, nothing of the bench stops the axis at its soft limits in the whole point.
    let [fence_low, fence_high] = case.soft_limits_rad(&case.axis, limits.soft_limits_rad);
    let wider = outside(fence_low) || outside(fence_high);
    let mut here = case.start_pose_rad.get(&case.axis).copied().unwrap_or(0.0);
    let mut wrong = |segment: &&Segment| match &segment.stimulus {
        Stimulus::Move { target_rad, limits } => {
            let leaves = outside(here) || outside(*target_rad);
            here = *target_rad;
            let most = if leaves { CREEP_RAD_PER_S } else { NEAR_RAD_PER_S };
            limits.velocity_rad_per_s > most * (1.0 + ROUNDING)
        }
        Stimulus::Hold { .. } => segment.mode != Mode::Position,
        _ => true,
    };
    if !wider {
        return None;
    }
    let segment = case.segments.iter().find(|segment| wrong(segment))?;
    let message = format!(
        "point `{}`, segment `{}`: where the limits of the point are wider than the rig's soft limits {}, \
         axis `{}` may only be positioned, at {} or slower",
        case.point,
        segment.label,
        range(limits.soft_limits_rad),
        case.axis,
        QuantityKind::AngularVelocity.format(CREEP_RAD_PER_S)
    );
    Some(Diagnostic::new(message).help(
        "move slowly there, at 5 deg/s or slower inside, and faster only in a point without the wider limits",
    ))
}

/// No soft limits, whoever asks for them, lie outside the travel.
fn beyond_travel(case: &Case, limits: &AxisLimits) -> Option<Diagnostic> {
    let [low, high] = case.soft_limits_rad(&case.axis, limits.soft_limits_rad);
    let [least, most] = limits.travel_rad;
    let asked = range([low, high]);
    let allowed = range(limits.travel_rad);
    let message = format!(
        "point `{}`: soft limits {asked} of axis `{}` exceed its travel {allowed}",
        case.point, case.axis
    );
    (low < least || high > most).then(|| Diagnostic::new(message).help(format!("stay inside {allowed}")))
}

fn range([a, b]: [f64; 2]) -> String {
    match (QuantityKind::Angle.format(a), QuantityKind::Angle.format(b)) {
        (a, b) if a == b => a,
        (a, b) => format!("{a} .. {b}"),
    }
}

fn travel(case: &Case, axis: &str, reach_rad: [f64; 2], limits: &AxisLimits) -> Option<Diagnostic> {
    let [low, high] = case.soft_limits_rad(axis, limits.soft_limits_rad);
    let slack = ROUNDING * (high - low).abs();
    if reach_rad[0] >= low - slack && reach_rad[1] <= high + slack {
        return None;
    }
    let allowed = range([low, high]);
    let message = format!(
        "point `{}` moves axis `{axis}` over {}: its soft limits are {allowed}",
        case.point,
        range(reach_rad)
    );
    Some(
        Diagnostic::new(message)
            .help(format!("stay inside {allowed}, with room for acceleration and braking")),
    )
}

fn no_axis(case: &Case, axis: &str, axes: &Axes) -> Diagnostic {
    Diagnostic::new(format!("point `{}` needs axis `{axis}`, which the rig does not have", case.point))
        .help(suggestion(axis, axes.names().collect::<Vec<_>>()))
}
