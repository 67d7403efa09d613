//! One record: what happened before and after its trigger.

use std::collections::VecDeque;
use std::time::Duration;

use crate::physics::current_loop::Lag;

/// Steps kept beyond what a record needs, on either side.
const SPARE_STEPS: usize = 2;

/// A record under way or done.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// From here on a trigger counts: what lies before it is there.
    armed: Duration,
    pub(super) before_s: f64,
    pub(super) after_s: f64,
    step_rate_hz: f64,
    /// Currents of both drives, step by step, and which step the first one is.
    steps: VecDeque<[Lag; 2]>,
    first_step: u64,
    kept_before: usize,
    trigger: Option<Duration>,
    /// Voltage of the synchronisation signal at the start, and its changes.
    syncs: Vec<(Duration, f64)>,
    first_sync_v: f64,
}

impl Record {
    /// Starts now; the synchronisation signal has this voltage.
    pub(super) fn new(now: Duration, before_s: f64, after_s: f64, step_rate_hz: f64, sync_v: f64) -> Self {
        Self {
            armed: now + Duration::from_secs_f64(before_s),
            before_s,
            after_s,
            step_rate_hz,
            steps: VecDeque::new(),
            first_step: 0,
            kept_before: (before_s * step_rate_hz).ceil() as usize + SPARE_STEPS,
            trigger: None,
            syncs: Vec::new(),
            first_sync_v: sync_v,
        }
    }

    /// Whether it waits for its trigger.
    pub(super) fn is_armed(&self, now: Duration) -> bool {
        now >= self.armed
    }

    /// Whether more steps are needed.
    pub(super) fn observes(&self) -> bool {
        self.trigger.is_none_or(|trigger| {
            let last_s = trigger.as_secs_f64() + self.after_s;
            let end_step = self.first_step + self.steps.len() as u64;
            (end_step as f64) < last_s * self.step_rate_hz + 1.0
        })
    }

    /// Whether it is not done yet.
    pub(super) fn runs(&self, now: Duration) -> bool {
        let done = |trigger: Duration| {
            let spare_s = SPARE_STEPS as f64 / self.step_rate_hz;
            now >= trigger + Duration::from_secs_f64(self.after_s + spare_s)
        };
        !self.trigger.is_some_and(done)
    }

    /// The time of the trigger, if there was one.
    pub(super) fn trigger(&self) -> Option<Duration> {
        self.trigger
    }

    pub(super) fn observe(&mut self, step: u64, currents: [Lag; 2]) {
        if self.steps.is_empty() {
            self.first_step = step;
        }
        self.steps.push_back(currents);
        if self.trigger.is_none() && self.steps.len() > self.kept_before {
            self.steps.pop_front();
            self.first_step += 1;
        }
    }

    /// It triggers now, without an edge, once what lies before a trigger is there.
    pub(super) fn force(&mut self, now: Duration) {
        if self.is_armed(now) {
            self.trigger.get_or_insert(now);
        }
    }

    pub(super) fn sync(&mut self, now: Duration, volts: f64, triggers: bool) {
        if self.trigger.is_none() && triggers && self.is_armed(now) {
            self.trigger = Some(now);
        }
        self.syncs.push((now, volts));
    }

    /// Current of a drive at a time, by the exact course of its current loop inside the step.
    pub(super) fn current_a(&self, drive: usize, bandwidth_hz: f64, time_s: f64) -> f64 {
        let steps = (time_s * self.step_rate_hz).max(0.0);
        let step = steps.floor() as u64;
        let place = step.saturating_sub(self.first_step) as usize;
        let within_s = (steps - step as f64) / self.step_rate_hz;
        let lag = self.steps.get(place).or(self.steps.back());
        lag.map_or(0.0, |lags| lags[drive].at(bandwidth_hz, within_s))
    }

    /// Synchronisation signal at a time.
    pub(super) fn sync_v(&self, time_s: f64) -> f64 {
        let last = self.syncs.iter().rev().find(|(at, _)| at.as_secs_f64() <= time_s);
        last.map_or(self.first_sync_v, |(_, volts)| *volts)
    }
}
