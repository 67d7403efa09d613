//! How much time really passes from tick to tick: a loop that missed periods must not count its ticks for time.

use std::time::Duration;

use crate::model::rig::Rig;

/// Periods from one tick to the next, on the grid of the loop: a tick that comes late by less than a period belongs to the
/// instant at which it was due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    period: Duration,
    /// When the present tick was due.
    due: Option<Duration>,
    passed: u32,
    most_steps: u32,
}

impl Pace {
    /// The pace of a rig before its first tick.
    pub(super) fn new(rig: &Rig) -> Self {
        let watchdog_s = rig.axes.iter().map(|axis| axis.drive.watchdog_s).fold(0.0, f64::max);
        Self {
            period: Duration::from_secs_f64(1.0 / rig.loop_rate_hz),
            due: None,
            passed: 1,
            most_steps: (watchdog_s * rig.loop_rate_hz).ceil().max(1.0) as u32,
        }
    }

    /// A tick at `now`.
    pub(super) fn tick(&mut self, now: Duration) {
        let Some(due) = self.due else {
            self.due = Some(now);
            return;
        };
        let periods = now.saturating_sub(due).as_nanos() / self.period.as_nanos().max(1);
        self.passed = u32::try_from(periods).unwrap_or(u32::MAX).max(1);
        self.due = Some(due + self.period * self.passed);
    }

    /// Periods since the tick before this one, at least 1.
    pub(super) fn passed(&self) -> u32 {
        self.passed
    }

    /// Steps that a control law takes in this tick: one for every period that has passed, and no more than the longest
    /// watchdog of the drives lets pass. After a longer gap the drives have stopped the axes by themselves, and what an
    /// integral would make of that time means nothing.
    pub(super) fn steps(&self) -> u32 {
        self.passed.min(self.most_steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_micros(250);

    fn passed(quarters_of_a_period: &[u32]) -> Vec<u32> {
        let mut pace = Pace { period: PERIOD, due: None, passed: 1, most_steps: 80 };
        let mut tick = |quarters: &u32| {
            pace.tick(Duration::from_secs(3) + *quarters * PERIOD / 4);
            pace.passed()
        };
        quarters_of_a_period.iter().map(&mut tick).collect()
    }

    #[test]
    fn every_period_counts_once_whether_its_tick_came_or_was_missed() {
        assert_eq!(passed(&[0, 4, 8, 12]), [1, 1, 1, 1]);
        assert_eq!(passed(&[0, 4, 136, 140]), [1, 1, 33, 1]);
    }

    #[test]
    fn a_tick_that_is_late_by_less_than_a_period_counts_as_one_on_time() {
        assert_eq!(passed(&[0, 7, 8, 15, 17]), [1, 1, 1, 1, 1]);
    }

    #[test]
    fn laws_take_no_more_steps_than_the_watchdog_of_the_drives_lets_pass() {
        let mut pace = Pace { period: PERIOD, due: None, passed: 1, most_steps: 80 };
        pace.tick(Duration::ZERO);
        pace.tick(33 * PERIOD);
        assert_eq!((pace.passed(), pace.steps()), (33, 33));
        pace.tick(4033 * PERIOD);
        assert_eq!((pace.passed(), pace.steps()), (4000, 80));
    }
}
