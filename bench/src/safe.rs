//! `make_safe`: the one exit path. However a run ends, whoever owns the loop calls it last.

use std::time::Duration;

use drivers::cia402::{Actuals, PowerState, PowerTarget};

use crate::clock::Clock;
use crate::files::rig::SafeState;
use crate::rig::ArmedRig;

/// Slower than this is standing still (safety.md: standstill).
const STANDSTILL_RAD_PER_S: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// For this long without a break.
const STANDSTILL_S: f64 = 2.0;
/// Time beyond the computed stop that is waited for at the most.
const GRACE_S: f64 = 3.0;

/// How the rig was left.
#[derive(Clone, Debug, PartialEq)]
pub struct Safe {
    /// Whether every axis stood still for 2 s in its final drive state.
    pub standstill: bool,
    /// Per axis: final power state and angle, for the journal.
    pub axes: Vec<(String, String, f64)>,
    /// Ticks that it took.
    pub ticks: u64,
}

/// Brings every axis to rest and into its declared final state; ends after the computed stop + 3 s at the latest.
///
/// `now` is the next due time, `period` the tick. Each tick sends one frame; `after` sees the rig after each.
pub fn make_safe(
    rig: &mut ArmedRig,
    clock: &Clock,
    now: Duration,
    period: Duration,
    mut after: impl FnMut(&mut ArmedRig, Duration),
) -> Safe {
    rig.rest_mirror();
    let limit = Duration::from_secs_f64(stop_time_s(rig) + STANDSTILL_S + GRACE_S);
    let (mut due, mut still_since, mut ticks, mut standstill) = (now, None, 0, false);
    let mut brakes: Vec<Brake> = (0..rig.axes().len()).map(|axis| Brake::begun(rig, axis)).collect();
    while due.saturating_sub(now) < limit {
        let at = clock.wait_until(due);
        rig.exchange(at);
        let mut still = true;
        for (axis, brake) in brakes.iter_mut().enumerate() {
            brake.watch(rig, axis);
            still &= settle_with(rig, axis, at, brake.runs_away);
        }
        after(rig, at);
        ticks += 1;
        still_since = if still { still_since.or(Some(at)) } else { None };
        if still_since.is_some_and(|since| (at - since).as_secs_f64() >= STANDSTILL_S) {
            standstill = true;
            break;
        }
        due = at.max(due) + period;
    }
    let axes = (0..rig.axes().len())
        .map(|axis| {
            let actuals = rig.actuals(axis);
            let state = format!("{:?}", PowerState::of(actuals.statusword));
            (rig.axes()[axis].name.clone(), state, actuals.position_rad)
        })
        .collect();
    Safe { standstill, axes, ticks }
}

/// A stop that makes an axis faster than this beyond where it began is no stop.
const RUNAWAY_RAD_PER_S: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// Whether the drive's own stop brakes an axis, or drives it (a wrong encoder sign does).
struct Brake {
    begun_rad_per_s: f64,
    runs_away: bool,
}

impl Brake {
    fn begun(rig: &ArmedRig, axis: usize) -> Self {
        Self { begun_rad_per_s: rig.actuals(axis).velocity_rad_per_s.abs(), runs_away: false }
    }

    fn watch(&mut self, rig: &ArmedRig, axis: usize) {
        self.runs_away |= runs_away(rig.actuals(axis), self.begun_rad_per_s);
    }
}

/// Whether an axis that is being stopped has become clearly faster than when that began.
pub(crate) fn runs_away(actuals: &Actuals, begun_rad_per_s: f64) -> bool {
    actuals.velocity_rad_per_s.abs() > begun_rad_per_s + RUNAWAY_RAD_PER_S
}

/// One axis in one tick; whether it stands still in its final state, as a fresh sample shows.
///
/// Quick stop while there is (or may be) power, then the declared final state; never an enabling command, never torque.
pub(crate) fn settle(rig: &mut ArmedRig, axis: usize, now: Duration) -> bool {
    settle_with(rig, axis, now, false)
}

/// The same; an axis that runs away under its drive's stop loses its torque, and friction stops it.
fn settle_with(rig: &mut ArmedRig, axis: usize, now: Duration, runs_away: bool) -> bool {
    let actuals = *rig.actuals(axis);
    let slow = actuals.velocity_rad_per_s.abs() < STANDSTILL_RAD_PER_S;
    let state = PowerState::of(actuals.statusword);
    // Only a state that is known to be without torque counts as such: an unknown one may be moving.
    let dead = matches!(
        state,
        PowerState::SwitchOnDisabled
            | PowerState::ReadyToSwitchOn
            | PowerState::SwitchedOn
            | PowerState::Fault
            | PowerState::FaultReactionActive
    );
    let release = rig.axes()[axis].safe_state == SafeState::Release;
    // Without power there is nothing left to command; with power, first the quick stop.
    let off = dead || runs_away || (release && slow);
    let target = if off { PowerTarget::Disabled } else { PowerTarget::QuickStop };
    // A drive that does not follow must not keep the other axis from being stopped, nor lose its own quick stop.
    const QUICK_STOP: u16 = 0x0002;
    const DISABLE_VOLTAGE: u16 = 0x0000;
    let otherwise = if target == PowerTarget::QuickStop { QUICK_STOP } else { DISABLE_VOLTAGE };
    let controlword = rig.controlword(axis, target, now).unwrap_or(otherwise);
    rig.command(axis, controlword, 0.0);
    // Held means quick stop active (or already without power); released means without power.
    let finally = match state {
        PowerState::OperationEnabled => false,
        PowerState::QuickStopActive => !release,
        _ => dead,
    };
    slow && finally && rig.is_fresh(axis)
}

/// Longest time that any axis needs to stop from its present rate with the deceleration its rig file relies on.
fn stop_time_s(rig: &ArmedRig) -> f64 {
    (0..rig.axes().len())
        .map(|axis| {
            rig.actuals(axis).velocity_rad_per_s.abs() / rig.axes()[axis].guard.stop.deceleration_rad_per_s2
        })
        .fold(0.0, f64::max)
}
