//! The loop of one point: wait, exchange, check, decide, command, record.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Duration;

use drivers::device::DeviceError;
use procedures::case::Case;
use procedures::log::{EndedBy, StopManner};
use procedures::quantity::Limit;

use crate::clock::Clock;
use crate::cycle::axis_loop::AxisLoop;
use crate::cycle::dither::Dither;
use crate::cycle::gate;
use crate::cycle::interlock::{self, Trip, per_axis};
use crate::cycle::progress::Progress;
use crate::cycle::prompt::Question;
use crate::cycle::recorder::{LoopEvent, Recorder};
use crate::cycle::safe::{Exit, Safe, make_safe};
use crate::cycle::sequence::{PointOrder, Sequencer};
use crate::cycle::stops::Stops;
use crate::cycle::velocity_loop::LawFault;
use crate::rig::ArmedRig;
use crate::rig::instruments::Tasks;

mod between;
mod means;
mod outcome;
mod row;
mod ticks;

pub use between::Between;
use outcome::Ending;
pub use outcome::{PointError, PointOutcome};
use ticks::Ticks;

/// Bits of [`Conditions::stop`] that order a controlled stop: the exit code of whoever ordered it first; 0 for nobody.
pub const STOP_CODE: u16 = 0x00FF;
/// Bit of [`Conditions::stop`] that orders the quick stop: no controlled stop.
pub const STOP_AT_ONCE: u16 = 0x0100;

/// What a loop needs beside its rig.
#[derive(Clone)]
pub struct Conditions<'a> {
    /// Index of the point.
    pub point: usize,
    /// The plan of the point.
    pub case: &'a Case,
    /// Index of the axis that the case moves.
    pub moving: usize,
    /// Log time of the point's start.
    pub log_start_ns: u64,
    /// Loop rate.
    pub loop_rate_hz: f64,
    /// Ticks for each row, which is the mean over them.
    pub log_every: u64,
    /// Rows for each row of the devices on the gimbal.
    pub log_payload_every: u64,
    /// Longest tolerated run of missed periods.
    pub max_missed_periods: u32,
    /// What must hold before anything moves.
    pub gates: &'a [(String, Limit)],
    /// What the operator is asked before it begins.
    pub questions: Arc<[Question]>,
    /// Whether the axes are parked after it, where the rig says so.
    pub parks: bool,
    /// Orders to stop: [`STOP_CODE`], [`STOP_AT_ONCE`].
    pub stop: &'a AtomicU16,
    /// Time source.
    pub clock: Clock,
    /// Where whoever watches sees how far the point is.
    pub progress: Arc<Progress>,
}

/// Runs one point on a rig that was opened for it and leaves the rig safe, whatever happens in between.
pub fn run_point(
    rig: &mut ArmedRig,
    loops: Vec<AxisLoop>,
    conditions: Conditions<'_>,
    dither: Dither,
    recorder: &mut Recorder,
) -> PointOutcome {
    let tasks = rig.ready_tasks(conditions.case);
    let start = rig.ready();
    PointRun::new(conditions, loops, dither, tasks).run(rig, start, recorder)
}

/// A point that is ready to be run: all that it needs is allocated.
pub struct PointRun<'a> {
    ticks: Ticks<'a>,
    sequencer: Sequencer<'a>,
    dither: Dither,
    tasks: Result<Tasks, DeviceError>,
}

impl<'a> PointRun<'a> {
    /// Readies a point.
    pub fn new(
        conditions: Conditions<'a>,
        loops: Vec<AxisLoop>,
        dither: Dither,
        tasks: Result<Tasks, DeviceError>,
    ) -> Self {
        let Conditions { point, case, moving, parks, loop_rate_hz, .. } = conditions;
        let questions = Arc::clone(&conditions.questions);
        let order = PointOrder { case, point, moving, questions, parks, loop_rate_hz };
        let ticks = Ticks::new(conditions, loops.len());
        Self { ticks, sequencer: Sequencer::new(order, loops), dither, tasks }
    }

    /// The run of a move between points that no plan has: of its events only what goes wrong is told.
    #[must_use]
    pub fn untold(mut self) -> Self {
        self.ticks.leave_untold();
        self
    }

    /// Log time of the first tick, where only the loop knows when that is.
    pub fn set_log_start(&mut self, log_start_ns: u64) {
        self.ticks.set_log_start(log_start_ns);
    }

    /// When the tick after the last one is due.
    pub fn next_due(&self) -> Duration {
        self.ticks.due + self.ticks.period
    }

    /// Runs the point, its first tick due at `start`, and leaves the rig safe, whatever happens in between.
    pub fn run(&mut self, rig: &mut ArmedRig, start: Duration, recorder: &mut Recorder) -> PointOutcome {
        let Self { ticks, sequencer, dither, tasks } = self;
        ticks.begin(start);
        sequencer.begin(start);
        let point = ticks.conditions.point;
        let error = match tasks {
            Ok(tasks) => {
                rig.take_tasks(tasks);
                None
            }
            Err(error) => Some(PointError::Bench(error.to_string())),
        };
        let mut ending = Ending { error, ..Ending::default() };
        if ending.stops() {
            sequencer.abandon();
        }
        ticks.tell(recorder, LoopEvent::PointStarted { point });
        rig.devices_mut().begin_listening(start);
        let panic = catch_unwind(AssertUnwindSafe(|| {
            while !sequencer.finished() {
                ticks.next();
                tick(rig, sequencer, ticks, &mut ending, dither, recorder);
            }
        }));
        if panic.is_err() {
            ending.error = Some(PointError::Internal("the control loop panicked"));
        }
        if !survives(|| rig.stop_instruments(ticks.now)) {
            ending.error.get_or_insert(PointError::Internal("stopping the instruments panicked"));
        }
        let safe = leave_safe(rig, ticks, &mut ending, recorder);
        survives(|| ticks.tell_losses(rig, recorder));
        ended(ticks, ending, safe, recorder)
    }
}

/// Tells how a point ended, each part whatever becomes of the others.
fn ended(ticks: &Ticks<'_>, ending: Ending, safe: Safe, recorder: &mut Recorder) -> PointOutcome {
    let point = ticks.conditions.point;
    let status = ending.status();
    let mut close = |event| survives(|| ticks.tell(recorder, event));
    for stop in ticks.stops.all() {
        close(LoopEvent::Stopped { point, stop });
    }
    for &left in &safe.axes {
        close(LoopEvent::Left { point, left });
    }
    survives(|| ticks.tell_lateness(recorder));
    survives(|| ticks.tell(recorder, LoopEvent::PointEnded { point, status }));
    let Ending { trip, cause, refused, error, signal, expected } = ending;
    let trip = trip.filter(|_| !expected);
    let loop_s = (ticks.now - ticks.start).as_secs_f64();
    let stops = ticks.stops.all().collect();
    PointOutcome { status, trip, cause, refused, error, signal, loop_s, safe, stops }
}

/// Does a part of an ending that must not keep the other parts from being done: whether it went without a panic.
fn survives(part: impl FnOnce()) -> bool {
    catch_unwind(AssertUnwindSafe(part)).is_ok()
}

/// A stop that panics is begun anew so often; then no frame is sent any more, and the drives stop by their watchdogs.
const STOPS_TRIED: usize = 3;

/// The end of every point: standstill, final state, and what trips on the way there.
fn leave_safe(
    rig: &mut ArmedRig,
    ticks: &mut Ticks<'_>,
    ending: &mut Ending,
    recorder: &mut Recorder,
) -> Safe {
    // What was gathered of the loop is a row of its own, not a part of one of the stop.
    ticks.conditions.progress.note_make_safe();
    let mut sound = survives(|| ticks.axis_rows(0..rig.axes().len(), recorder));
    let clock = ticks.conditions.clock.clone();
    let period = ticks.period;
    let open_loop = ticks.conditions.case.open_loop;
    let mut stops = std::mem::replace(&mut ticks.stops, Stops::new(0));
    ticks.moved = stops.all().next().is_some().then_some(ticks.now);
    let mut left = Safe { standstill: false, axes: Vec::new(), ticks: 0 };
    for _ in 0..STOPS_TRIED {
        ticks.due += period;
        let exit = Exit { clock: &clock, from: ticks.due, period, open_loop };
        let stop = || left = stop_under_watch(rig, &exit, &mut stops, ticks, ending, recorder, &mut sound);
        if survives(stop) {
            break;
        }
        ending.error.get_or_insert(PointError::Internal("the stop panicked"));
    }
    let _ = survives(|| ticks.axis_rows(0..rig.axes().len(), recorder));
    ticks.stops = stops;
    if !left.standstill {
        ending.fail("the rig is NOT at standstill in its safe state");
    }
    left
}

/// `make_safe` under the interlocks. What panics among them, and in the log, is left out from then on: it must not end the
/// stop.
fn stop_under_watch(
    rig: &mut ArmedRig,
    exit: &Exit<'_>,
    stops: &mut Stops,
    ticks: &mut Ticks<'_>,
    ending: &mut Ending,
    recorder: &mut Recorder,
    sound: &mut bool,
) -> Safe {
    make_safe(rig, exit, stops, |rig, woken| {
        ticks.take(woken);
        ticks.count += 1;
        if !*sound {
            return;
        }
        *sound = survives(|| {
            if let Some(trip) = ticks.first_out(rig, None, recorder, ending.trip.as_ref()) {
                ending.expected = false;
                ending.trip.get_or_insert(trip);
                ticks.tell_trip(recorder, trip);
            }
            ticks.row(rig, None, recorder);
        });
    })
}

/// One tick of the loop proper.
fn tick(
    rig: &mut ArmedRig,
    sequencer: &mut Sequencer<'_>,
    ticks: &mut Ticks<'_>,
    ending: &mut Ending,
    dither: &mut Dither,
    recorder: &mut Recorder,
) {
    rig.exchange(ticks.now);
    ticks.count += 1;
    ticks.stops.observe(ticks.now, rig);
    guard(rig, sequencer, ticks, ending, recorder);
    if ending.stops() {
        rig.rest_mirror();
        rig.stop_instruments(ticks.now);
    }
    let now = ticks.now;
    let mut told = [None, None];
    let count = ticks.count;
    let dither_nm = &mut || dither.at(count);
    let stepped = sequencer.step(now, rig, dither_nm, &mut |event| {
        // At most two events fall into one tick: a segment's end and the next one's start.
        let free = told.iter_mut().find(|t: &&mut Option<LoopEvent>| t.is_none());
        if let Some(free) = free {
            *free = Some(event);
        }
    });
    for event in told.into_iter().flatten() {
        ticks.tell(recorder, event);
    }
    if let Err(error) = stepped {
        ending.fail(error);
        halt(rig, sequencer, ticks, recorder);
    }
    if let Some((axis, fault)) = sequencer.take_law_fault() {
        stop_without_law(axis, fault, rig, sequencer, ticks, ending, recorder);
    }
    ticks.conditions.progress.note(ticks.now.saturating_sub(ticks.start), sequencer.state());
    ticks.row(rig, Some(sequencer), recorder);
    ticks.instrument_rows(rig, recorder);
}

/// An external law has failed: the built-in laws stop all axes, and the frame of this very tick has the commands of that
/// stop.
fn stop_without_law(
    axis: usize,
    fault: LawFault,
    rig: &mut ArmedRig,
    sequencer: &mut Sequencer<'_>,
    ticks: &mut Ticks<'_>,
    ending: &mut Ending,
    recorder: &mut Recorder,
) {
    let stopping = ending.stops();
    let trip = fault.trip(axis);
    ticks.tell_trip(recorder, trip);
    ending.take_trip(trip, || Some(fault.to_string()));
    if !stopping {
        halt(rig, sequencer, ticks, recorder);
    }
    if let Err(error) = sequencer.command_stop(ticks.now, rig) {
        ending.fail(error);
    }
}

/// Interlocks, gates and orders to stop.
fn guard(
    rig: &mut ArmedRig,
    sequencer: &mut Sequencer<'_>,
    ticks: &mut Ticks<'_>,
    ending: &mut Ending,
    recorder: &mut Recorder,
) {
    let stopping = ending.stops();
    if let Some(trip) = ticks.first_out(rig, Some(sequencer), recorder, ending.trip.as_ref()) {
        ticks.tell_trip(recorder, trip);
        ending.expected = ending.trip.is_none() && !stopping && holds_a_fence(sequencer, ticks, rig, &trip);
        ending.take_trip(trip, || ticks.cause(&trip, rig).map(|error| error.to_string()));
        if OF_THE_BENCH.contains(&trip.interlock) {
            ending.fail(format_args!("the bench failed: {}", trip.interlock));
        }
        let learned = LEARNED_WHILE_STOPPING.contains(&trip.interlock)
            || trip.interlock == interlock::BUS_VOLTAGE.name && rig.link_is_full();
        if (stopping && !learned) || !trip.steerable {
            abandon(rig, sequencer, ticks);
        } else if !stopping || ticks.learned {
            halt(rig, sequencer, ticks, recorder);
        }
    }
    if sequencer.expects_operation() && let_go(rig) {
        abandon(rig, sequencer, ticks);
    }
    let orders = ticks.conditions.stop.load(Ordering::Relaxed);
    if orders & STOP_AT_ONCE != 0 {
        ending.signal = Some((orders & STOP_CODE) as u8);
        abandon(rig, sequencer, ticks);
        return;
    }
    if stopping || ending.trip.is_some() {
        return;
    }
    let signal = (orders & STOP_CODE) as u8;
    if signal != 0 {
        ending.signal = Some(signal);
        halt(rig, sequencer, ticks, recorder);
    } else if let Some(error) = rig.failure() {
        ending.fail(error);
        halt(rig, sequencer, ticks, recorder);
    } else if recorder.failed() {
        ending.fail("the log can no longer be written");
        halt(rig, sequencer, ticks, recorder);
    } else if sequencer.refused() {
        ending.refused = Some("the operator refused".to_owned());
        halt(rig, sequencer, ticks, recorder);
    } else if ticks.overrun(sequencer) {
        ending.fail("the point took longer than planned");
        halt(rig, sequencer, ticks, recorder);
    } else if cools_down(sequencer, ticks, rig) {
        // The axes stay as they were left, under all interlocks.
    } else if sequencer.before_motion()
        && let Some(reason) = gate::closed(ticks.conditions.gates, ticks.conditions.case, rig)
    {
        ending.refused = Some(reason);
        halt(rig, sequencer, ticks, recorder);
    }
}

/// Whether the point waits for a heat sink before anything has torque.
fn cools_down(sequencer: &mut Sequencer<'_>, ticks: &Ticks<'_>, rig: &ArmedRig) -> bool {
    let limit_s = ticks.conditions.case.cool_down_s.unwrap_or(0.0);
    let waits = sequencer.before_motion()
        && sequencer.off_plan_s(ticks.now) < limit_s
        && gate::is_too_warm(ticks.conditions.gates, rig);
    sequencer.cool(waits, ticks.now);
    waits
}

/// Whether a trip is a point's own limit that was ordered past, and held: limits of this very axis, inside the rig's own.
/// Wider ones are for creeping to the ends of the travel; nothing is ordered past them.
fn holds_a_fence(sequencer: &Sequencer<'_>, ticks: &Ticks<'_>, rig: &ArmedRig, trip: &Trip) -> bool {
    let Some(fence) = &ticks.conditions.case.fence else { return false };
    let inside = |axis: usize| {
        let axis = &rig.axes()[axis];
        let [low, high] = axis.limits.soft_limits_rad;
        fence.bench_rad.get(&axis.name).is_some_and(|own| own[0] >= low && own[1] <= high)
    };
    let held = match trip.interlock {
        name if name == interlock::RESTRICTED_ZONE.name => !fence.zones.is_empty(),
        name if name == interlock::POSITION.name || name == interlock::BRAKING_CURVE.name => {
            trip.axis.is_some_and(inside)
        }
        _ => false,
    };
    held && sequencer.runs_segment()
}

/// Trips that only say which sensor a stop must not use: it goes on with the other one.
const LEARNED_WHILE_STOPPING: [&str; 3] =
    [interlock::FROZEN_ENCODER.name, interlock::FROZEN_GYRO.name, interlock::RATE_FEEDBACK.name];

/// Trips that say nothing about the unit: the bench itself failed.
const OF_THE_BENCH: [&str; 2] = [interlock::LIVENESS.name, interlock::LOG_RING.name];

/// A stop under control, as far as the axes are under control.
fn halt(rig: &ArmedRig, sequencer: &mut Sequencer<'_>, ticks: &mut Ticks<'_>, recorder: &mut Recorder) {
    let manner = match (sequencer.expects_operation(), ticks.conditions.case.open_loop) {
        (_, true) => StopManner::TorqueOff,
        (true, false) if rig.link_is_full() => StopManner::LinkLimited,
        (true, false) => StopManner::Controlled,
        (false, false) => StopManner::QuickStop,
    };
    let decelerations = per_axis(rig.axes().len(), |axis| executed(rig, axis, ticks));
    ticks.stops(manner, rig, |axis| decelerations[axis]);
    let event = sequencer.stop(ticks.now, rig, |axis| decelerations[axis]);
    if let Some(event) = event {
        debug_assert!(matches!(event, LoopEvent::SegmentEnded { by: EndedBy::Stopped, .. }));
        ticks.tell(recorder, event);
    }
}

/// Deceleration with which an axis is stopped: what the motor has shown, or more where there is less room than that
/// takes, up to what the rig file says.
fn executed(rig: &ArmedRig, axis: usize, ticks: &Ticks<'_>) -> f64 {
    const RESERVE: f64 = 1.1;
    let believed = rig.believed(axis);
    let stop = &rig.axes()[axis].guard.stop;
    let shown = shown(rig, axis, ticks);
    let rate = believed.rate_rad_per_s;
    let needed = RESERVE * rate * rate / (2.0 * stop.room_rad(believed.position_rad, rate)).max(1e-9);
    needed.clamp(shown.min(stop.deceleration_rad_per_s2), stop.deceleration_rad_per_s2)
}

/// Deceleration that the motor of an axis has shown, at the most that of the rig file.
fn shown(rig: &ArmedRig, axis: usize, ticks: &Ticks<'_>) -> f64 {
    ticks.watch.deceleration_rad_per_s2(rig, axis)
}

/// Takes the torque from an axis of which neither sensor can be believed: there is nothing left to steer by. Whether any
/// axis is without torque.
fn let_go(rig: &mut ArmedRig) -> bool {
    let mut any = false;
    for axis in 0..rig.axes().len() {
        if rig.believed(axis).speed_rad_per_s.is_infinite() {
            rig.forbid_torque(axis);
        }
        any |= rig.torque_is_forbidden(axis);
    }
    any
}

/// Leaves the rest to the drives' own quick stops.
fn abandon(rig: &ArmedRig, sequencer: &mut Sequencer<'_>, ticks: &mut Ticks<'_>) {
    let open_loop = ticks.conditions.case.open_loop;
    let shown = per_axis(rig.axes().len(), |axis| shown(rig, axis, ticks));
    ticks.stops(if open_loop { StopManner::TorqueOff } else { StopManner::QuickStop }, rig, |axis| {
        shown[axis]
    });
    sequencer.abandon();
}

#[cfg(test)]
mod tests;
