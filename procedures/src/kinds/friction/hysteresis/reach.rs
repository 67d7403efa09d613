//! How far strokes go: what whole cogging periods need, and what the soft limits leave of it.

use std::f64::consts::{PI, TAU};

use super::sweep::{Reach, Sweep, profile};
use crate::axis::{Axes, AxisLimits};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Profile, ProfileLimits};

/// Time that a stroke gets to settle on its plateau, where each velocity gets the span it needs.
const SETTLE_S: f64 = 0.5;
/// Cogging periods that a slow stroke gets to settle on its plateau, where they last longer than [`SETTLE_S`].
const SETTLE_PERIODS: f64 = 1.0;
/// Strokes that are fitted into the soft limits keep this far from them: a real axis is not exactly where its command
/// is, and the interlock trips on where it is.
const CLEARANCE_RAD: f64 = 0.1 * PI / 180.0;

/// Where the strokes of one velocity turn.
///
/// With `periods`: ramps, settling at both ends (each end is the start of one direction) and the whole periods,
/// about the centre, moved and cut where the soft limits are near. What a cut leaves is run and judged.
pub(super) fn span(sweep: &Sweep, limits: &AxisLimits, profile: &ProfileLimits) -> [f64; 2] {
    let (count, centre_rad) = match sweep.reach {
        Reach::Span(span_rad) => return span_rad,
        Reach::Periods { count, centre_rad } => (f64::from(count), centre_rad),
        Reach::Imported => (1.0, 0.0),
    };
    let [low_rad, high_rad] = usable(limits);
    let half_rad = needed_rad(count, limits, profile).min((high_rad - low_rad) / 2.0);
    let centre_rad = centre_rad.max(low_rad + half_rad).min(high_rad - half_rad);
    [(centre_rad - half_rad).max(low_rad), (centre_rad + half_rad).min(high_rad)]
}

/// Half of what strokes need for whole periods: a ramp, settling, and half of the periods.
fn needed_rad(count: f64, limits: &AxisLimits, profile: &ProfileLimits) -> f64 {
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let settle_rad = (SETTLE_S * profile.velocity_rad_per_s).max(SETTLE_PERIODS * period_rad);
    ramp_rad(profile) + settle_rad + count * period_rad / 2.0
}

/// Where strokes may turn that are fitted into the soft limits.
fn usable(limits: &AxisLimits) -> [f64; 2] {
    let [low_rad, high_rad] = limits.soft_limits_rad;
    [low_rad + CLEARANCE_RAD, high_rad - CLEARANCE_RAD]
}

/// Velocities whose periods do not fit between the soft limits, a sentence each.
pub(super) fn cuts(sweep: &Sweep, axis: &str, axes: &Axes) -> Vec<String> {
    let (Some(limits), Reach::Periods { count, .. }) = (axes.get(axis), sweep.reach) else {
        return Vec::new();
    };
    let [low_rad, high_rad] = usable(limits);
    let room_rad = high_rad - low_rad;
    let needed = sweep.velocities_rad_per_s.iter().map(|&velocity| {
        let needed_rad = 2.0 * needed_rad(f64::from(count), limits, &profile(sweep, limits, velocity));
        (velocity, needed_rad)
    });
    needed
        .filter(|(_, needed_rad)| *needed_rad > room_rad)
        .map(|(velocity, needed_rad)| {
            format!(
                "velocity {}: {count} periods need {}, the soft limits leave {}: fewer periods are measured",
                Q::AngularVelocity.format(velocity),
                Q::Angle.format(needed_rad),
                Q::Angle.format(room_rad)
            )
        })
        .collect()
}

/// Way from rest to the plateau velocity.
pub(super) fn ramp_rad(profile: &ProfileLimits) -> f64 {
    // Long enough to cruise: a ramp within these limits is shorter than v²/a + v·a/j + its own jerk phases.
    let v = profile.velocity_rad_per_s;
    let a = profile.acceleration_rad_per_s2;
    let j = profile.jerk_rad_per_s3;
    let long = 4.0 * (v * v / a + v * a / j + v * (v / j).sqrt());
    let whole = Profile::new(long, profile);
    (long - v * whole.cruise_s()) / 2.0
}
