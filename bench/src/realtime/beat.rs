//! The beat of a loop: the next tick, and the periods that were missed before it.

use std::time::Duration;

use crate::clock::Clock;

/// A tick that has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Woken {
    /// When it came.
    pub now: Duration,
    /// The last instant of the loop's grid that is not after `now`: the one that the tick stands for.
    pub due: Duration,
    /// How long after the instant that was waited for it came.
    pub late: Duration,
    /// Periods that were missed before it.
    pub missed_periods: u32,
}

/// Waits for the tick that is due. Missed periods are skipped, never caught up: the grid of the loop stays where it is.
pub fn wake(clock: &Clock, due: Duration, period: Duration) -> Woken {
    let now = clock.wait_until(due);
    let late = now.saturating_sub(due);
    let missed = late.as_nanos().checked_div(period.as_nanos()).unwrap_or(0);
    let missed_periods = u32::try_from(missed).unwrap_or(u32::MAX);
    Woken { now, due: due + period * missed_periods, late, missed_periods }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Lateness;

    const PERIOD: Duration = Duration::from_micros(250);

    #[test]
    fn a_virtual_tick_comes_when_it_is_due() {
        let due = 40 * PERIOD;
        let woken = Woken { now: due, due, late: Duration::ZERO, missed_periods: 0 };
        assert_eq!(wake(&Clock::Virtual, due, PERIOD), woken);
    }

    #[test]
    fn a_late_tick_stands_for_the_last_instant_of_the_grid_and_says_how_many_it_missed() {
        let from = Duration::from_secs(1);
        let until = from + PERIOD;
        let lateness = Lateness { seed: 1, period: PERIOD, from, until, one_in: 1, periods: [7; 2] };
        let woken = wake(&Clock::Late(lateness), from, PERIOD);
        let (late, due) = (7 * PERIOD, from + 7 * PERIOD);
        assert_eq!(woken, Woken { now: due, due, late, missed_periods: 7 });
    }
}
