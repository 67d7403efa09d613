//! The loop of one point: wait, exchange, check, decide, command, record.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Duration;

use procedures::case::Case;
use procedures::log::{EndedBy, PointStatus};
use procedures::quantity::Limit;

use crate::axis_loop::AxisLoop;
use crate::clock::Clock;
use crate::dither::Dither;
use crate::gate;
use crate::interlock::{Situation, Trip, Watch};
use crate::recorder::{Item, LoopEvent, MAX_CHANNELS, Recorder};
use crate::rig::ArmedRig;
use crate::safe::{Safe, make_safe};
use crate::sequence::Sequencer;

mod row;

/// What a loop needs beside its rig.
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
    /// Every how many ticks a row is logged.
    pub log_every: u64,
    /// Every how many ticks the devices on the gimbal are logged, a multiple of `log_every`.
    pub log_payload_every: u64,
    /// Longest tolerated run of missed periods.
    pub max_missed_periods: u32,
    /// What must hold before anything moves.
    pub gates: &'a [(String, Limit)],
    /// Set by signals, see [`crate::signals`].
    pub stop: &'a AtomicU16,
    /// Time source.
    pub clock: Clock,
}

/// How a point ended.
#[derive(Clone, Debug, PartialEq)]
pub struct PointOutcome {
    /// Status for the log.
    pub status: PointStatus,
    /// What tripped first.
    pub trip: Option<Trip>,
    /// A gate that refused before motion.
    pub refused: Option<String>,
    /// What failed in the bench.
    pub error: Option<String>,
    /// Exit code of the signal that stopped it.
    pub signal: Option<u8>,
    /// Loop time that passed, `make_safe` included.
    pub loop_s: f64,
    /// How the rig was left.
    pub safe: Safe,
}

/// Why the loop proper ended.
#[derive(Debug, Default)]
struct Ending {
    trip: Option<Trip>,
    refused: Option<String>,
    error: Option<String>,
    signal: Option<u8>,
}

/// Runs one point on an armed rig and leaves the rig safe, whatever happens in between.
pub fn run_point(
    rig: &mut ArmedRig,
    loops: Vec<AxisLoop>,
    conditions: &Conditions<'_>,
    dither: &mut Dither,
    recorder: &mut Recorder,
) -> PointOutcome {
    let mut ticks = Ticks::new(conditions, rig.ready());
    let moving = conditions.moving;
    let mut sequencer = Sequencer::new(conditions.case, conditions.point, moving, loops, rig.ready());
    let mut ending = Ending::default();
    ticks.tell(recorder, LoopEvent::PointStarted { point: conditions.point });
    let panic = catch_unwind(AssertUnwindSafe(|| {
        while !sequencer.finished() {
            ticks.next();
            tick(rig, &mut sequencer, &mut ticks, &mut ending, dither, recorder);
        }
    }));
    if panic.is_err() {
        ending.error = Some("internal error: the loop panicked".to_owned());
    }
    let (clock, period) = (conditions.clock, ticks.period);
    let from = ticks.due + period;
    let mut recording = true;
    let safe = make_safe(rig, &clock, from, period, |rig, now| {
        (ticks.now, ticks.due) = (now, now);
        ticks.count += 1;
        // What panicked in the loop may panic again: it must not end the stop.
        let row = AssertUnwindSafe(|| ticks.row(rig, None, recorder));
        recording = recording && catch_unwind(row).is_ok();
    });
    if !safe.standstill {
        ending.error.get_or_insert_with(|| "the rig is NOT at standstill in its safe state".to_owned());
    }
    let status = status(&ending);
    ticks.tell(recorder, LoopEvent::PointEnded { point: conditions.point, status });
    let Ending { trip, refused, error, signal } = ending;
    PointOutcome {
        status,
        trip,
        refused,
        error,
        signal,
        loop_s: (ticks.now - ticks.start).as_secs_f64(),
        safe,
    }
}

fn status(ending: &Ending) -> PointStatus {
    if ending.error.is_some() {
        PointStatus::Errored
    } else if ending.trip.is_some() || ending.refused.is_some() || ending.signal.is_some() {
        PointStatus::Aborted
    } else {
        PointStatus::Completed
    }
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
    guard(rig, sequencer, ticks, ending, recorder);
    if ending.trip.is_some() || ending.error.is_some() || ending.signal.is_some() {
        rig.rest_mirror();
    }
    let now = ticks.now;
    let (mut told, count) = ([None; 2], ticks.count);
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
        ending.error.get_or_insert_with(|| error.to_string());
        halt(rig, sequencer, ticks, recorder);
    }
    ticks.row(rig, Some(sequencer), recorder);
}

/// Interlocks, gates and orders to stop.
fn guard(
    rig: &ArmedRig,
    sequencer: &mut Sequencer<'_>,
    ticks: &mut Ticks<'_>,
    ending: &mut Ending,
    recorder: &mut Recorder,
) {
    let stopping = ending.trip.is_some() || ending.error.is_some() || ending.signal.is_some();
    let situation = ticks.situation(sequencer);
    if let Some(trip) = ticks.watch.tick(rig, &situation, ending.trip.as_ref()) {
        ticks.tell(recorder, LoopEvent::Tripped { point: ticks.conditions.point, trip });
        ending.trip.get_or_insert(trip);
        if stopping || !trip.steerable {
            sequencer.abandon();
        } else {
            halt(rig, sequencer, ticks, recorder);
        }
    }
    let orders = ticks.conditions.stop.load(Ordering::Relaxed);
    if orders & crate::signals::AT_ONCE != 0 {
        ending.signal = Some((orders & crate::signals::CODE) as u8);
        sequencer.abandon();
        return;
    }
    if stopping || ending.trip.is_some() {
        return;
    }
    let signal = (orders & crate::signals::CODE) as u8;
    if signal != 0 {
        ending.signal = Some(signal);
        halt(rig, sequencer, ticks, recorder);
    } else if let Some(error) = rig.payload().failure() {
        ending.error = Some(error.to_string());
        halt(rig, sequencer, ticks, recorder);
    } else if recorder.failed() {
        ending.error = Some("the log cannot be written any more".to_owned());
        halt(rig, sequencer, ticks, recorder);
    } else if ticks.overrun() {
        ending.error = Some("the point took longer than planned".to_owned());
        halt(rig, sequencer, ticks, recorder);
    } else if sequencer.before_motion()
        && let Some(reason) = gate::closed(ticks.conditions.gates, ticks.conditions.case, rig)
    {
        ending.refused = Some(reason);
        halt(rig, sequencer, ticks, recorder);
    }
}

fn halt(rig: &ArmedRig, sequencer: &mut Sequencer<'_>, ticks: &mut Ticks<'_>, recorder: &mut Recorder) {
    if let Some(event) = sequencer.stop(ticks.now, rig) {
        debug_assert!(matches!(event, LoopEvent::SegmentEnded { by: EndedBy::Stopped, .. }));
        ticks.tell(recorder, event);
    }
}

/// Time in the loop, and what goes into the log with it.
struct Ticks<'a> {
    conditions: &'a Conditions<'a>,
    watch: Watch,
    period: Duration,
    start: Duration,
    due: Duration,
    now: Duration,
    count: u64,
    started: bool,
    missed: u32,
    missed_since_row: u32,
}

impl<'a> Ticks<'a> {
    fn new(conditions: &'a Conditions<'a>, start: Duration) -> Self {
        let period = Duration::from_secs_f64(1.0 / conditions.loop_rate_hz);
        Self {
            conditions,
            watch: Watch::new(period.as_secs_f64()),
            period,
            start,
            due: start,
            now: start,
            count: 0,
            started: false,
            missed: 0,
            missed_since_row: 0,
        }
    }

    /// Waits for the next tick. Missed periods are skipped, never caught up.
    fn next(&mut self) {
        if self.started {
            self.due += self.period;
        }
        self.started = true;
        self.now = self.conditions.clock.wait_until(self.due);
        self.missed = 0;
        while self.now >= self.due + self.period {
            self.due += self.period;
            self.missed += 1;
        }
        self.missed_since_row += self.missed;
    }

    /// A point that lasts longer than everything planned for it hangs somewhere.
    fn overrun(&self) -> bool {
        const POWER_UP_AND_STOPS_S: f64 = 30.0;
        (self.now - self.start).as_secs_f64() > self.conditions.case.planned_s() + POWER_UP_AND_STOPS_S
    }

    /// What the interlocks must know of the loop.
    fn situation(&self, sequencer: &Sequencer<'_>) -> Situation {
        Situation {
            waits_for_inputs: sequencer.waits_for_inputs(),
            expects_operation: sequencer.expects_operation(),
            bounds: self.conditions.case.bounds,
            missed_periods: self.missed,
            max_missed_periods: self.conditions.max_missed_periods,
            ..Situation::default()
        }
    }

    fn time_ns(&self) -> u64 {
        self.conditions.log_start_ns + u64::try_from((self.now - self.start).as_nanos()).unwrap_or(u64::MAX)
    }

    fn tell(&self, recorder: &mut Recorder, event: LoopEvent) {
        recorder.push(Item::Event { time_ns: self.time_ns(), event });
    }

    fn row(&mut self, rig: &mut ArmedRig, sequencer: Option<&Sequencer<'_>>, recorder: &mut Recorder) {
        let off = sequencer.is_some() && !self.count.is_multiple_of(self.conditions.log_every);
        if off || !recorder.keeps() {
            return;
        }
        let mut values = [0.0; MAX_CHANNELS];
        for axis in 0..rig.axes().len() {
            row::axis(rig, axis, sequencer, &mut values);
            recorder.push(Item::Row { topic: axis as u8, time_ns: self.time_ns(), values });
        }
        row::of_loop(rig, sequencer, self, &mut values);
        let (time_ns, mut topic) = (self.time_ns(), rig.axes().len() as u8);
        recorder.push(Item::Row { topic, time_ns, values });
        if self.count.is_multiple_of(self.conditions.log_payload_every) {
            rig.payload_mut().rows(&mut values, |values| {
                topic += 1;
                recorder.push(Item::Row { topic, time_ns, values: *values });
            });
        }
        self.missed_since_row = 0;
    }
}

#[cfg(test)]
mod tests;
