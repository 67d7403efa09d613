//! Rows of the axes at a lower rate than the loop's: means over their ticks, so that nothing above half that rate folds
//! into them. Counts and states are those of the last tick.

use std::sync::LazyLock;

use procedures::log::Width;

use crate::channels;
use crate::recorder::MAX_CHANNELS;

/// Which channels of an axis are analog quantities.
static ANALOG: LazyLock<[bool; MAX_CHANNELS]> = LazyLock::new(|| {
    let mut all = [false; MAX_CHANNELS];
    let analog = |width: Width| matches!(width, Width::F64 | Width::F32);
    all.iter_mut().zip(channels::of_axis()).for_each(|(is, channel)| *is = analog(channel.width));
    all
});

/// What was gathered since the last row, for each axis.
#[derive(Default)]
pub(super) struct Means {
    axes: [Gathered; 2],
    ticks: u64,
    time_ns: u64,
    /// Excited segment of the last tick.
    pub(super) segment: Option<usize>,
}

#[derive(Default)]
struct Gathered {
    sums: [f64; MAX_CHANNELS],
    last: [f64; MAX_CHANNELS],
}

impl Means {
    /// Takes a tick of an axis.
    pub(super) fn add(&mut self, axis: usize, values: &[f64; MAX_CHANNELS]) {
        let Some(gathered) = self.axes.get_mut(axis) else { return };
        gathered.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        gathered.last = *values;
    }

    /// Ends a tick.
    pub(super) fn ends(&mut self, time_ns: u64) {
        (self.ticks, self.time_ns) = (self.ticks + 1, time_ns);
    }

    /// Ticks gathered.
    pub(super) fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The row of an axis over the ticks gathered, at the time of the last of them.
    pub(super) fn row(&self, axis: usize) -> (u64, [f64; MAX_CHANNELS]) {
        let mut values = [0.0; MAX_CHANNELS];
        if let Some(gathered) = self.axes.get(axis) {
            values = gathered.last;
            // One tick is itself, to the bit.
            if self.ticks > 1 {
                for ((value, sum), _) in
                    values.iter_mut().zip(gathered.sums).zip(*ANALOG).filter(|(_, analog)| *analog)
                {
                    *value = sum / self.ticks as f64;
                }
            }
        }
        (self.time_ns, values)
    }

    /// Begins the next row.
    pub(super) fn clear(&mut self) {
        self.ticks = 0;
        self.axes.iter_mut().for_each(|gathered| gathered.sums = [0.0; MAX_CHANNELS]);
    }
}

#[cfg(test)]
mod tests {
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
        let (time_ns, row) = means.row(0);
        assert_eq!((time_ns, means.ticks()), (2, 3));
        for (value, channel) in row.iter().zip(channels::of_axis()) {
            let analog = matches!(channel.width, Width::F64 | Width::F32);
            assert_eq!(*value, if analog { 3.0 } else { 6.0 }, "{}", channel.name);
        }
        means.clear();
        means.add(0, &tick(0.1));
        means.ends(3);
        assert_eq!(means.row(0).1[0].to_bits(), 0.1_f64.to_bits());
    }
}
