//! Rows of the axes at a lower rate than the loop's: means over their ticks, so that nothing above half that rate folds
//! into them. Counts and states are those of the last tick; that a limit of the drive was active in any of them stays.

use procedures::axis::{INTERNAL_LIMIT, MAX_AXES};

use crate::cycle::channels;
use crate::cycle::recorder::MAX_CHANNELS;

/// What was gathered since the last row, for each axis.
pub(super) struct Means {
    /// Which channels are analog quantities, and where the statusword is: known before the first tick.
    analog: [bool; MAX_CHANNELS],
    statusword: Option<usize>,
    axes: [Gathered; MAX_AXES],
    /// Ticks since the last row of any axis.
    ticks: u64,
    time_ns: u64,
    /// Excited segment of the last tick.
    pub(super) segment: Option<usize>,
}

#[derive(Clone, Copy, Default)]
struct Gathered {
    sums: [f64; MAX_CHANNELS],
    last: [f64; MAX_CHANNELS],
    limited: u16,
    ticks: u64,
}

impl Default for Means {
    fn default() -> Self {
        let mut analog = [false; MAX_CHANNELS];
        analog.iter_mut().zip(channels::analog_of_axis()).for_each(|(is, analog)| *is = analog);
        let statusword = channels::statusword_of_axis();
        Self { analog, statusword, axes: Default::default(), ticks: 0, time_ns: 0, segment: None }
    }
}

impl Means {
    /// Takes a tick of an axis.
    pub(super) fn add(&mut self, axis: usize, values: &[f64; MAX_CHANNELS]) {
        let Some(gathered) = self.axes.get_mut(axis) else { return };
        gathered.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        gathered.last = *values;
        gathered.limited |= self.statusword.map_or(0, |k| values[k] as u16 & INTERNAL_LIMIT);
        gathered.ticks += 1;
    }

    /// Ends a tick.
    pub(super) fn ends(&mut self, time_ns: u64) {
        (self.ticks, self.time_ns) = (self.ticks + 1, time_ns);
    }

    /// Ticks gathered.
    pub(super) fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Takes the row of an axis over the ticks gathered, at the time of the last of them; `None` where there are none. The
    /// next row of that axis begins.
    pub(super) fn take(&mut self, axis: usize) -> Option<(u64, [f64; MAX_CHANNELS])> {
        let gathered = self.axes.get_mut(axis).filter(|gathered| gathered.ticks > 0)?;
        let Gathered { sums, last: mut values, limited, ticks } = std::mem::take(gathered);
        // One tick is itself, to the bit.
        if ticks > 1 {
            let analog = values.iter_mut().zip(sums).zip(self.analog).filter(|(_, analog)| *analog);
            analog.for_each(|((value, sum), _)| *value = sum / ticks as f64);
        }
        if let Some(k) = self.statusword {
            values[k] = f64::from(values[k] as u16 | limited);
        }
        Some((self.time_ns, values))
    }

    /// Ends a row, whichever axes it has taken.
    pub(super) fn clear(&mut self) {
        self.ticks = 0;
    }
}

#[cfg(test)]
mod tests {
    use procedures::log::Width;

    use super::*;

    fn tick(value: f64) -> [f64; MAX_CHANNELS] {
        let mut values = [0.0; MAX_CHANNELS];
        let channels = channels::of_axis().count();
        values[..channels].fill(value);
        values
    }

    #[test]
    fn analog_channels_are_means_and_counts_are_the_last() {
        let mut means = Means::default();
        for (k, value) in [1.0, 2.0, 6.0].into_iter().enumerate() {
            means.add(0, &tick(value));
            means.ends(k as u64);
        }
        assert_eq!(means.ticks(), 3);
        let (time_ns, row) = means.take(0).expect("three ticks");
        assert_eq!(time_ns, 2);
        for (value, channel) in row.iter().zip(channels::of_axis()) {
            let analog = matches!(channel.width, Width::F64 | Width::F32);
            assert_eq!(*value, if analog { 3.0 } else { 6.0 }, "{}", channel.name);
        }
        means.clear();
        means.add(0, &tick(0.1));
        means.ends(3);
        assert_eq!(means.take(0).expect("one tick").1[0].to_bits(), 0.1_f64.to_bits());
        assert_eq!(means.take(0), None);
    }

    #[test]
    fn a_limit_that_was_active_in_one_tick_shows_in_the_row() {
        let at = channels::statusword_of_axis().expect("drives have a statusword");
        let mut means = Means::default();
        for word in [0x1237_u16, 0x1A37, 0x1227] {
            let mut values = tick(0.0);
            values[at] = f64::from(word);
            means.add(0, &values);
        }
        assert_eq!(means.take(0).map(|(_, row)| row[at] as u16), Some(0x1A27));
        means.add(0, &tick(0.0));
        assert_eq!(means.take(0).map(|(_, row)| row[at]), Some(0.0), "the next row begins without");
    }

    #[test]
    fn an_axis_that_is_taken_more_seldom_is_a_mean_over_all_its_ticks() {
        let mut means = Means::default();
        for value in [1.0, 3.0] {
            for axis in 0..2 {
                means.add(axis, &tick(value));
            }
            means.ends(0);
            assert!(means.take(0).is_some());
            means.clear();
        }
        assert_eq!(means.take(1).map(|(_, row)| row[0]), Some(2.0));
    }
}
