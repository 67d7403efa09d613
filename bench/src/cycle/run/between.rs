//! The loop between points: nothing moves, everything is watched.

use std::time::Duration;

use super::Conditions;
use super::ticks::Ticks;
use crate::cycle::interlock::Trip;
use crate::cycle::recorder::{LoopEvent, Recorder};
use crate::cycle::safe::Keeper;
use crate::realtime::Woken;
use crate::rig::ArmedRig;

/// The loop while no point is run: every axis is kept in its declared final state, under all interlocks.
pub struct Between<'a> {
    ticks: Ticks<'a>,
    keeper: Keeper,
    trip: Option<Trip>,
}

impl<'a> Between<'a> {
    /// Begins at the first tick of a session.
    pub fn begin(conditions: Conditions<'a>, rig: &ArmedRig, recorder: &mut Recorder) -> Self {
        let mut ticks = Ticks::new(conditions, rig.axes().len());
        ticks.begin(rig.ready());
        ticks.tell(recorder, LoopEvent::PointStarted { point: 0 });
        Self { ticks, keeper: Keeper::begun(rig, false), trip: None }
    }

    /// One tick: waits for it, exchanges, watches, keeps, records.
    pub fn tick(&mut self, rig: &mut ArmedRig, recorder: &mut Recorder) {
        self.ticks.next();
        rig.exchange(self.ticks.now);
        self.ticks.count += 1;
        if let Some(trip) = self.ticks.first_out(rig, None, recorder, self.trip.as_ref()) {
            self.trip.get_or_insert(trip);
            self.ticks.tell_trip(recorder, trip);
        }
        self.keeper.tick(rig, self.ticks.now, self.ticks.period);
        self.ticks.row(rig, None, recorder);
    }

    /// What was gathered becomes a row: others have the rig from the next tick on.
    pub fn pause(&mut self, rig: &ArmedRig, recorder: &mut Recorder) {
        self.ticks.axis_rows(0..rig.axes().len(), recorder);
    }

    /// Goes on after a point, whose last tick was the one before `due`.
    pub fn resume(&mut self, rig: &ArmedRig, due: Duration, open_loop: bool) {
        self.ticks.resume(due);
        self.ticks.forget_trips();
        (self.keeper, self.trip) = (Keeper::begun(rig, open_loop), None);
    }

    /// When the next tick is due.
    pub fn next_due(&self) -> Duration {
        self.ticks.due + self.ticks.period
    }

    /// Log time of an instant of the session.
    pub fn log_time_ns(&self, at: Duration) -> u64 {
        let since_start = at.saturating_sub(self.ticks.start).as_nanos();
        self.ticks.conditions.log_start_ns + u64::try_from(since_start).unwrap_or(u64::MAX)
    }

    /// What tripped first since the last point.
    pub fn trip(&self) -> Option<&Trip> {
        self.trip.as_ref()
    }

    /// Time of the last tick.
    pub fn now(&self) -> Duration {
        self.ticks.now
    }

    /// Notes how late a tick of the last stop of a session came.
    pub fn note(&mut self, woken: &Woken) {
        self.ticks.take(woken);
    }

    /// Tells how the session was left.
    pub fn end(&mut self, safe: &crate::cycle::safe::Safe, recorder: &mut Recorder) {
        for &left in &safe.axes {
            self.ticks.tell(recorder, LoopEvent::Left { point: 0, left });
        }
        self.ticks.tell_lateness(recorder);
        let status = procedures::log::PointStatus::Completed;
        self.ticks.tell(recorder, LoopEvent::PointEnded { point: 0, status });
    }
}
