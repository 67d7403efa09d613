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
    speed: Option<Speed>,
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
            speed: None,
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
                let speed = self.speed.get_or_insert_with(|| Speed::new(actuals.velocity_rad_per_s, now));
                speed.slow_for_s(actuals.velocity_rad_per_s, now, below_rad_per_s) >= for_s
            }
            // Only of loops that this segment has closed: the lock of another one is older than the segment.
            Some(Condition::Locked { for_s }) => locked_since
                .is_some_and(|since| now.saturating_sub(since.max(self.started)).as_secs_f64() >= for_s),
        }
    }
}

/// How fast an axis is, and since when it has been slow.
#[derive(Debug)]
struct Speed {
    /// Mean over the last few milliseconds, first order.
    mean_rad_per_s: f64,
    at: Duration,
    slow_since: Option<Duration>,
}

/// Time constant of the mean. The velocity of a drive is the difference of two angles a millisecond apart: 0.3 µrad of noise, as much
/// as ENC-NOISE allows, would be half of the speed below which an axis counts as settled, and now and then more than all of it.
const MEAN_S: f64 = 5e-3;

impl Speed {
    fn new(velocity_rad_per_s: f64, now: Duration) -> Self {
        Self { mean_rad_per_s: velocity_rad_per_s, at: now, slow_since: None }
    }

    /// For how long the axis has been slower than a threshold, s; 0 while it is not. Once a tick.
    fn slow_for_s(&mut self, velocity_rad_per_s: f64, now: Duration, below_rad_per_s: f64) -> f64 {
        let passed_s = (now - self.at).as_secs_f64();
        self.at = now;
        self.mean_rad_per_s += (velocity_rad_per_s - self.mean_rad_per_s) * passed_s / (MEAN_S + passed_s);
        if self.mean_rad_per_s.abs() >= below_rad_per_s {
            self.slow_since = None;
            return 0.0;
        }
        (now - *self.slow_since.get_or_insert(now)).as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use sim_devices::physics::noise::{Noise, SeedAddress};

    use super::*;

    /// An axis at rest whose encoder has this noise, for two seconds: for how long it has been slow at the end.
    fn slow_for_s(noise_rad: f64) -> f64 {
        let address = SeedAddress { seed: 7, procedure: String::new(), point: String::new() };
        let mut noise = Noise::new(&address, "encoder", noise_rad);
        let tick = Duration::from_micros(250);
        let mut velocity = |k: u64| (noise.at(k + 4) - noise.at(k)) / 1e-3;
        let mut speed = Speed::new(0.0, Duration::ZERO);
        (1..=8000_u32).fold(0.0, |_, k| speed.slow_for_s(velocity(u64::from(k)), tick * k, 8.7e-4))
    }

    #[test]
    fn an_axis_at_rest_has_settled_whatever_noise_its_encoder_may_have() {
        assert!((slow_for_s(0.3e-6) - 2.0).abs() < 1e-3, "{} s", slow_for_s(0.3e-6));
        // Thirty times what ENC-NOISE allows shows as motion.
        assert!(slow_for_s(9e-6) < 0.1, "{} s", slow_for_s(9e-6));
    }

    #[test]
    fn an_axis_that_creeps_has_not_settled() {
        let mut speed = Speed::new(1e-3, Duration::ZERO);
        let slow = (1..=8000_u32).map(|k| speed.slow_for_s(1e-3, Duration::from_micros(250) * k, 8.7e-4));
        assert!(slow.into_iter().all(|slow_s| slow_s == 0.0));
    }
}
