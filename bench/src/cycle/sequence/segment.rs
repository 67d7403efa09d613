//! A segment while it runs.

use std::time::Duration;

use drivers::cia402::Actuals;
use procedures::case::{Condition, Segment};
use procedures::log::EndedBy;
use procedures::stimulus::{Prepared, Setpoint, Stimulus};

use crate::rig::ArmedRig;

/// A running segment.
#[derive(Debug)]
pub struct Running<'c> {
    /// Plan of the segment.
    pub segment: &'c Segment,
    /// Index of the segment in the case.
    pub index: usize,
    prepared: Prepared<'c>,
    duration_s: f64,
    from_rad: f64,
    along: Option<Along<'c>>,
    started: Duration,
    slow_since: Option<Duration>,
    /// The tick before.
    last: Duration,
    /// Time for which the command has waited for a motor at its limit.
    waited: Duration,
}

/// Another axis that moves meanwhile.
#[derive(Debug)]
pub(super) struct Along<'c> {
    /// Index of the axis.
    pub(super) axis: usize,
    prepared: Prepared<'c>,
    duration_s: f64,
}

impl<'c> Along<'c> {
    /// Starts at `start_rad` of its own command.
    pub(super) fn new(axis: usize, stimulus: &'c Stimulus, start_rad: f64) -> Self {
        let duration_s = stimulus.duration_s(start_rad).unwrap_or(0.0);
        Self { axis, prepared: stimulus.prepare(start_rad), duration_s }
    }
}

impl<'c> Running<'c> {
    /// Starts at `start_rad` of the command; the axis itself was at `from_rad`.
    pub(super) fn new(
        segment: &'c Segment,
        index: usize,
        start_rad: f64,
        from_rad: f64,
        along: Option<Along<'c>>,
        started: Duration,
    ) -> Self {
        let own_s = segment.stimulus.duration_s(start_rad).filter(|_| segment.task.is_none());
        let along_s = along.as_ref().map_or(0.0, |along| along.duration_s);
        let duration_s = own_s.map_or(segment.at_most_s, |own_s| own_s.max(along_s));
        Self {
            segment,
            index,
            prepared: segment.stimulus.prepare(start_rad),
            duration_s: duration_s.min(segment.at_most_s),
            from_rad,
            along,
            started,
            slow_since: None,
            last: started,
            waited: Duration::ZERO,
        }
    }

    /// Once a tick, before the setpoint is asked for: the share of the time since the tick before by which the command
    /// goes on. A segment that waits is as much longer, up to its time limit.
    pub(super) fn go_on(&mut self, now: Duration, pace: f64) {
        let passed = now - self.last;
        self.last = now;
        if pace < 1.0 {
            self.waited += passed.mul_f64(1.0 - pace);
        }
    }

    /// Time on the command's own axis, s.
    fn command_s(&self, now: Duration) -> f64 {
        (now - self.started - self.waited).as_secs_f64()
    }

    /// The setpoint at `now`.
    pub(super) fn setpoint(&self, now: Duration) -> Setpoint {
        self.prepared.at(self.command_s(now))
    }

    /// Index of the axis that moves meanwhile.
    pub(super) fn companion(&self) -> Option<usize> {
        self.along.as_ref().map(|along| along.axis)
    }

    /// The setpoint at `now` of an axis that moves meanwhile.
    pub(super) fn setpoint_along(&self, axis: usize, now: Duration) -> Option<Setpoint> {
        let along = self.along.as_ref().filter(|along| along.axis == axis)?;
        Some(along.prepared.at(self.command_s(now)))
    }

    /// Whether and why the segment is over.
    pub(super) fn ends(&mut self, now: Duration, rig: &ArmedRig, moving: usize) -> Option<EndedBy> {
        if self.condition_met(now, rig.actuals(moving), rig.tracking().locked_since()) {
            return Some(EndedBy::Condition);
        }
        let lasted_s = (now - self.started).as_secs_f64();
        let over = self.command_s(now) >= self.duration_s || lasted_s >= self.segment.at_most_s;
        over.then_some(if self.segment.until.is_some() { EndedBy::Timeout } else { EndedBy::Completed })
    }

    fn condition_met(&mut self, now: Duration, actuals: &Actuals, locked_since: Option<Duration>) -> bool {
        match self.segment.until {
            None => false,
            Some(Condition::Displacement { above_rad }) => {
                (actuals.position_rad - self.from_rad).abs() > above_rad
            }
            Some(Condition::Speed { above_rad_per_s }) => actuals.velocity_rad_per_s.abs() > above_rad_per_s,
            Some(Condition::Settled { below_rad_per_s, for_s }) => {
                if actuals.velocity_rad_per_s.abs() >= below_rad_per_s {
                    self.slow_since = None;
                    return false;
                }
                let since = *self.slow_since.get_or_insert(now);
                (now - since).as_secs_f64() >= for_s
            }
            // Only of loops that this segment has closed: the lock of another one is older than the segment.
            Some(Condition::Locked { for_s }) => locked_since
                .is_some_and(|since| now.saturating_sub(since.max(self.started)).as_secs_f64() >= for_s),
        }
    }
}
