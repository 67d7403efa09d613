//! `make_safe`: the one exit path. However a run ends, whoever owns the loop calls it last.

use std::time::Duration;

use drivers::cia402::{Actuals, PowerState, PowerTarget};
use drivers::wire::BusState;
use procedures::log::{Event, FinalState, StopManner};

use crate::clock::Clock;
use crate::cycle::stops::Stops;
use crate::model::axis::RigAxis;
use crate::model::safety::SafeState;
use crate::model::stopping::Swing;
use crate::realtime::{Woken, wake};
use crate::rig::ArmedRig;

/// Standing still counts after this long without a break.
const STANDSTILL_S: f64 = 2.0;
/// Time beyond the computed stop that is waited for at the most.
const GRACE_S: f64 = 3.0;

/// No axis coasts or swings for longer.
pub(crate) const COASTING_AT_MOST: Duration = Duration::from_secs(120);

/// How an axis was left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeAxis {
    /// Index of the axis.
    pub axis: usize,
    /// Final power state.
    pub state: PowerState,
    /// Whether its torque holds it.
    pub held: bool,
    /// Where it is.
    pub position_rad: f64,
    /// Where it goes if its torque is lost there (computed); `None` where friction keeps it.
    pub swing: Option<Swing>,
}

/// How the rig was left.
#[derive(Clone, Debug, PartialEq)]
pub struct Safe {
    /// Whether every axis stood still for 2 s in its final drive state.
    pub standstill: bool,
    /// Per axis.
    pub axes: Vec<SafeAxis>,
    /// Ticks that it took.
    pub ticks: u64,
}

impl SafeAxis {
    /// The event for the log.
    pub fn spelled_out(self, point: usize, axes: &[String]) -> Event {
        Event::Left(FinalState {
            point,
            axis: axes.get(self.axis).cloned().unwrap_or_default(),
            state: self.state.name().to_owned(),
            held: self.held,
            position_rad: self.position_rad,
            swing_to_rad: self.swing.map(|s| s.to_rad),
            swing_rad_per_s: self.swing.map(|s| s.speed_rad_per_s),
        })
    }
}

impl Safe {
    /// One line for the journal.
    pub fn text(&self, axes: &[String]) -> String {
        let axis = |left: &SafeAxis| {
            let name = axes.get(left.axis).map_or("", String::as_str);
            let swing = left.swing.map_or(String::new(), |swing| {
                let to = swing.to_rad.to_degrees();
                let speed = swing.speed_rad_per_s.to_degrees();
                format!(" (without torque it swings to {to:.1} deg at up to {speed:.1} deg/s, computed)")
            });
            format!("{name} {:?} at {:.4} deg{swing}", left.state, left.position_rad.to_degrees())
        };
        let axes: Vec<String> = self.axes.iter().map(axis).collect();
        let still = if self.standstill { "standstill" } else { "NOT at standstill" };
        format!("{still}: {}", axes.join(", "))
    }
}

/// Time and manner of an exit.
pub struct Exit<'a> {
    /// Time source.
    pub clock: &'a Clock,
    /// The next due time.
    pub from: Duration,
    /// The tick.
    pub period: Duration,
    /// No loop may be closed, not even the drive's own: torque off, friction stops.
    pub open_loop: bool,
}

/// Brings every axis to rest and into its declared final state; ends after the computed stop + 3 s at the latest.
///
/// Each tick sends one frame; `after` sees the rig after each. An axis that becomes faster under its drive's stop, or
/// whose torque is forbidden, loses its torque.
pub fn make_safe(
    rig: &mut ArmedRig,
    exit: &Exit<'_>,
    stops: &mut Stops,
    mut after: impl FnMut(&mut ArmedRig, &Woken),
) -> Safe {
    rig.rest_mirror();
    let wait = |stop_s: f64| Duration::from_secs_f64(stop_s + STANDSTILL_S + GRACE_S);
    let mut until = exit.from + wait(stop_time_s(rig));
    let mut due = exit.from;
    let mut still_since = None;
    let mut ticks = 0;
    let mut standstill = false;
    let mut keeper = Keeper::begun(rig, exit.open_loop);
    while due < until {
        let woken = wake(exit.clock, due, exit.period);
        let at = woken.now;
        rig.exchange(at);
        let still = keeper.tick(rig, at, exit.period);
        for axis in 0..rig.axes().len() {
            let brakes = keeper.brakes(rig, axis);
            let manner = if brakes { StopManner::QuickStop } else { StopManner::TorqueOff };
            let deceleration = rig.axes()[axis].guard.stop.deceleration_rad_per_s2;
            stops.begin_axis(axis, manner, at, rig, deceleration);
            // Without torque an axis coasts, and may swing back: that takes the time it takes.
            if !brakes && !rig.believed(axis).stands() {
                until = until.max(at + wait(0.0)).min(exit.from + COASTING_AT_MOST);
            }
        }
        stops.observe(at, rig);
        after(rig, &woken);
        ticks += 1;
        still_since = if still { still_since.or(Some(at)) } else { None };
        if still_since.is_some_and(|since| (at - since).as_secs_f64() >= STANDSTILL_S) {
            standstill = true;
            break;
        }
        due = woken.due + exit.period;
    }
    Safe { standstill, axes: (0..rig.axes().len()).map(|axis| left(rig, axis)).collect(), ticks }
}

/// Brings every axis to its declared final state and keeps it there, a tick after the other.
pub struct Keeper {
    brakes: Vec<Brake>,
}

impl Keeper {
    /// Begins now. With `open_loop` no loop may be closed, not even the drives' own: torque off, friction stops.
    pub fn begun(rig: &ArmedRig, open_loop: bool) -> Self {
        Self { brakes: (0..rig.axes().len()).map(|axis| Brake::begun(rig, axis, open_loop)).collect() }
    }

    /// One tick, after its exchange: a command for every axis. Gives whether all stand still in their final states.
    pub fn tick(&mut self, rig: &mut ArmedRig, at: Duration, period: Duration) -> bool {
        let mut still = true;
        for (axis, brake) in self.brakes.iter_mut().enumerate() {
            brake.watch(rig, axis, period * rig.passed_periods());
            still &= settle(rig, axis, at, brake.off);
        }
        still
    }

    /// Whether the drive of an axis stops or holds it, instead of friction alone.
    fn brakes(&self, rig: &ArmedRig, axis: usize) -> bool {
        !self.brakes[axis].off && !PowerState::of(rig.actuals(axis).statusword).is_without_torque()
    }
}

fn left(rig: &ArmedRig, axis: usize) -> SafeAxis {
    let actuals = rig.actuals(axis);
    let rig_axis = &rig.axes()[axis];
    let state = PowerState::of(actuals.statusword);
    SafeAxis {
        axis,
        state,
        held: !state.is_without_torque(),
        position_rad: rig.believed(axis).position_rad,
        swing: rig_axis.guard.stop.swing(rig.believed(axis).position_rad),
    }
}

/// A stop that makes an axis faster than this beyond where it began is no stop.
const RUNAWAY_RAD_PER_S: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// Whether the drive's own stop brakes an axis, or drives it (a wrong encoder sign does).
struct Brake {
    begun_rad_per_s: f64,
    /// How long the drive has pushed the axis on instead of braking it.
    pushed: Duration,
    /// Whether the drive's torque is taken away.
    off: bool,
}

impl Brake {
    fn begun(rig: &ArmedRig, axis: usize, off: bool) -> Self {
        Self { begun_rad_per_s: rig.believed(axis).rate_rad_per_s.abs(), pushed: Duration::ZERO, off }
    }

    fn watch(&mut self, rig: &ArmedRig, axis: usize, passed: Duration) {
        self.pushed = if pushes(rig, axis) { self.pushed + passed } else { Duration::ZERO };
        self.off |= self.pushed > PUSHED;
        self.off |= rig.torque_is_forbidden(axis);
        // The drive's quick stop would feed a DC link that is full.
        self.off |= rig.braking_share(axis) < 1.0 && !rig.believed(axis).stands();
        self.off |= runs_away(rig.believed(axis).rate_rad_per_s, self.begun_rad_per_s);
    }
}

/// A stop that pushes for this long is no stop.
const PUSHED: Duration = Duration::from_millis(20);
/// Slower than this an axis may be pushed back to where it is held.
const PUSHED_RAD_PER_S: f64 = 1.0 * std::f64::consts::PI / 180.0;
/// Torque that no hold and no settling needs, as a share of the largest.
const PUSHED_SHARE: f64 = 0.1;

/// Whether the drive of an axis that is being stopped gives torque in the direction of its motion.
fn pushes(rig: &ArmedRig, axis: usize) -> bool {
    let believed = rig.believed(axis);
    let guard = &rig.axes()[axis].guard;
    let torque_nm = rig.actuals(axis).torque_nm;
    let needed_nm = guard.stop.loads.at(believed.position_rad).abs() + PUSHED_SHARE * guard.max_torque_nm;
    torque_nm * believed.rate_rad_per_s > 0.0
        && torque_nm.abs() > needed_nm
        && believed.rate_rad_per_s.abs() > PUSHED_RAD_PER_S
}

/// Whether an axis that is being stopped has become clearly faster than when that began.
pub(crate) fn runs_away(rate_rad_per_s: f64, begun_rad_per_s: f64) -> bool {
    rate_rad_per_s.abs() > begun_rad_per_s + RUNAWAY_RAD_PER_S
}

/// Holding torque above what friction and load explain, by which an undeclared load shows.
const UNDECLARED_RATIO: f64 = 1.2;

/// Whether an axis may be left without torque where it stands: the rig says so, friction holds what pulls at it there
/// with a margin, and the torque that the drive shows does not contradict that.
pub(crate) fn may_release(axis: &RigAxis, actuals: &Actuals) -> bool {
    let stop = &axis.guard.stop;
    // A held axis shows its load and up to the whole of its friction; more than that is a load that nobody declared.
    let explained_nm = UNDECLARED_RATIO
        * (axis.limits.expected_static_friction_nm + stop.loads.at(actuals.position_rad).abs());
    axis.guard.safety.safe_state == SafeState::Release
        && stop.holds_without_torque(actuals.position_rad)
        && (PowerState::of(actuals.statusword).is_without_torque() || actuals.torque_nm.abs() < explained_nm)
}

/// One axis in one tick; whether it stands still in its final state, as a fresh sample shows.
///
/// Quick stop while there is (or may be) power, then the declared final state; never an enabling command, never torque.
/// With `off` it loses its torque at once, and friction stops it.
pub(crate) fn settle(rig: &mut ArmedRig, axis: usize, now: Duration, off: bool) -> bool {
    let off = off || rig.torque_is_forbidden(axis);
    let actuals = *rig.actuals(axis);
    let slow = rig.believed(axis).stands();
    let state = PowerState::of(actuals.statusword);
    let dead = state.is_without_torque();
    let release = off || may_release(&rig.axes()[axis], &actuals);
    // Without power there is nothing left to command; with power, first the quick stop.
    let target =
        if dead || off || (release && slow) { PowerTarget::Disabled } else { PowerTarget::QuickStop };
    // A drive that does not follow must not keep the other axis from being stopped, nor lose its own quick stop.
    const QUICK_STOP: u16 = 0x0002;
    const DISABLE_VOLTAGE: u16 = 0x0000;
    let otherwise = if target == PowerTarget::QuickStop { QUICK_STOP } else { DISABLE_VOLTAGE };
    let controlword = rig.controlword(axis, target, now).unwrap_or(otherwise);
    rig.command(axis, controlword, 0.0);
    // Held means quick stop active (or already without power); released means without power.
    let finally = match state {
        PowerState::OperationEnabled => false,
        // A drive whose watchdog has bitten is in SAFE-OP: it holds, and nobody can release it.
        PowerState::QuickStopActive => !release || rig.bus_state() < BusState::Op,
        _ => dead,
    };
    slow && finally && rig.is_fresh(axis)
}

/// Longest time that any axis needs to stop from its present rate with the deceleration its rig file relies on.
fn stop_time_s(rig: &ArmedRig) -> f64 {
    (0..rig.axes().len())
        .map(|axis| {
            let rate = rig.believed(axis).rate_rad_per_s;
            rig.axes()[axis].guard.stop.controlled(rate).time_s
        })
        .fold(0.0, f64::max)
}
