//! A segment while it runs.

use std::time::Duration;

use drivers::cia402::Actuals;
use procedures::case::{Condition, Segment};
use procedures::log::EndedBy;
use procedures::stimulus::{Prepared, Setpoint};

use crate::rig::ArmedRig;

/// A running segment.
#[derive(Debug)]
pub struct Running<'c> {
    /// Its plan.
    pub segment: &'c Segment,
    /// Its index in the case.
    pub index: usize,
    prepared: Prepared<'c>,
    duration_s: f64,
    from_rad: f64,
    started: Duration,
    slow_since: Option<Duration>,
}

impl<'c> Running<'c> {
    /// Starts at `start_rad` of the command; the axis itself was at `from_rad`.
    pub(super) fn new(
        segment: &'c Segment,
        index: usize,
        start_rad: f64,
        from_rad: f64,
        started: Duration,
    ) -> Self {
        let duration_s = segment.stimulus.duration_s(start_rad).filter(|_| segment.task.is_none());
        let duration_s = duration_s.unwrap_or(segment.at_most_s);
        Self {
            segment,
            index,
            prepared: segment.stimulus.prepare(start_rad),
            duration_s: duration_s.min(segment.at_most_s),
            from_rad,
            started,
            slow_since: None,
        }
    }

    /// The setpoint at `now`.
    pub(super) fn setpoint(&self, now: Duration) -> Setpoint {
        self.prepared.at((now - self.started).as_secs_f64())
    }

    /// Whether and why the segment is over.
    pub(super) fn ends(&mut self, now: Duration, rig: &ArmedRig, moving: usize) -> Option<EndedBy> {
        if self.condition_met(now, rig.actuals(moving), rig.tracking().locked_since()) {
            return Some(EndedBy::Condition);
        }
        let over = (now - self.started).as_secs_f64() >= self.duration_s;
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
