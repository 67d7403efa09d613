//! Excitations of a point, ready to be played tick by tick.

use std::time::Duration;

use procedures::excitation::{Excitation, Injection, Signal};

/// Longest period that is computed beforehand: beyond, every tick computes its own value.
const MOST_TICKS: f64 = 300_000.0;

/// An excitation with its table, and since when it plays.
#[derive(Clone, Debug)]
pub(super) struct Playback<'c> {
    excitation: &'c Excitation,
    rate_hz: f64,
    /// One period of a signal that repeats after whole ticks, without its fade-in.
    table: Vec<f64>,
    started: Option<Duration>,
}

impl<'c> Playback<'c> {
    /// Computes the table: nothing of it is left to do in a tick.
    pub(super) fn new(excitation: &'c Excitation, rate_hz: f64) -> Self {
        let period = match &excitation.signal {
            Signal::Multisine { period_s, .. } => period_s * rate_hz,
            Signal::Sweep { .. } | Signal::Stepped { .. } | Signal::Square { .. } => 0.0,
        };
        let ticks =
            if (period - period.round()).abs() < 1e-6 && period < MOST_TICKS { period.round() } else { 0.0 };
        let table = (0..ticks as u32).map(|k| excitation.signal.at(f64::from(k) / rate_hz)).collect();
        Self { excitation, rate_hz, table, started: None }
    }

    /// Where it is added, and its value at `now`; the first call starts it.
    pub(super) fn at(&mut self, now: Duration) -> (Injection, f64) {
        let started = *self.started.get_or_insert(now);
        let every = f64::from(self.excitation.every_ticks.max(1));
        // In real time a tick may come a little less late than the first one: it is the nearest that is played.
        let tick = (now.saturating_sub(started).as_secs_f64() * self.rate_hz).round();
        let tick = (tick / every).floor() * every;
        let value = match self.table.len() {
            0 => self.excitation.at(tick / self.rate_hz),
            length => {
                let fade_s = self.excitation.fade_s;
                let fade = if fade_s > 0.0 { (tick / self.rate_hz / fade_s).min(1.0) } else { 1.0 };
                fade * self.table[tick as usize % length]
            }
        };
        (self.excitation.into, value)
    }
}

#[cfg(test)]
mod tests {
    use procedures::excitation::Sine;

    use super::*;

    fn excitation(every_ticks: u32) -> Excitation {
        let lines = vec![Sine { frequency_hz: 2.5, amplitude: 3.0, phase_rad: 0.4 }];
        let signal = Signal::Multisine { period_s: 2.0, lines };
        Excitation { into: Injection::Torque, signal, fade_s: 1.0, every_ticks }
    }

    #[test]
    fn the_table_plays_what_the_signal_says_from_its_first_tick_on() {
        let plan = excitation(1);
        let mut playback = Playback::new(&plan, 4000.0);
        let start = Duration::from_secs(7);
        for k in 0..20_000_u32 {
            let (into, value) = playback.at(start + k * Duration::from_micros(250));
            assert_eq!(into, Injection::Torque);
            assert!((value - plan.at(f64::from(k) / 4000.0)).abs() < 1e-9, "{k}");
        }
    }

    #[test]
    fn ticks_that_come_early_or_late_by_less_than_half_a_period_play_their_own_values() {
        let plan = excitation(1);
        let mut playback = Playback::new(&plan, 4000.0);
        let start = Duration::from_secs(7);
        for k in 0..20_000_u32 {
            let late = Duration::from_micros([100, 0, 60, 190][k as usize % 4]);
            let (_, value) = playback.at(start + k * Duration::from_micros(250) + late);
            assert!((value - plan.at(f64::from(k) / 4000.0)).abs() < 1e-9, "{k}");
        }
    }

    #[test]
    fn a_slower_computer_holds_each_value_for_its_own_period() {
        let plan = excitation(4);
        let mut playback = Playback::new(&plan, 4000.0);
        for k in 0..4000_u32 {
            let (_, value) = playback.at(k * Duration::from_micros(250));
            assert!((value - plan.at(f64::from(k / 4 * 4) / 4000.0)).abs() < 1e-9, "{k}");
        }
    }
}
