//! Effort over angle: samples in time become means over equal angle bins, whole cogging periods of them.

/// A uniform grid of angle bins over a whole number of periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Lower edge of the first bin.
    pub low_rad: f64,
    /// Length of a period.
    pub period_rad: f64,
    /// Whole periods.
    pub periods_count: usize,
    /// Bins in each period.
    pub bins_per_period_count: usize,
}

/// Most bins in a period.
const MOST_BINS: usize = 64;
/// Least bins in a period.
const LEAST_BINS: usize = 2;

impl Grid {
    /// The whole periods that lie in all `ranges_rad` (low, high), in their middle.
    ///
    /// A period gets the largest power of two of bins, at most 64, that leaves two samples in a bin. `None` if not
    /// one period lies in all ranges, or if a period has fewer samples than its two bins: such a grid says nothing, and a
    /// stray angle would make it as large as it likes.
    pub fn common(ranges_rad: &[[f64; 2]], period_rad: f64, samples_per_period_count: f64) -> Option<Self> {
        let low = ranges_rad.iter().map(|r| r[0]).fold(f64::NEG_INFINITY, f64::max);
        let high = ranges_rad.iter().map(|r| r[1]).fold(f64::INFINITY, f64::min);
        let periods = ((high - low) / period_rad * (1.0 + 1e-9)).floor();
        let is_filled = samples_per_period_count >= LEAST_BINS as f64;
        if !(periods >= 1.0 && periods.is_finite() && is_filled) {
            return None;
        }
        let mut bins = MOST_BINS;
        while bins > LEAST_BINS && 2.0 * bins as f64 > samples_per_period_count {
            bins /= 2;
        }
        Some(Self {
            low_rad: (low + high - periods * period_rad) / 2.0,
            period_rad,
            periods_count: periods as usize,
            bins_per_period_count: bins,
        })
    }

    /// Bins in all.
    pub fn bins_count(&self) -> usize {
        self.periods_count * self.bins_per_period_count
    }

    /// Width of a bin.
    pub fn width_rad(&self) -> f64 {
        self.period_rad / self.bins_per_period_count as f64
    }

    /// Lower edge of bin `k`.
    pub fn edge_rad(&self, k: usize) -> f64 {
        self.low_rad + k as f64 * self.width_rad()
    }

    /// Middle of each bin.
    pub fn centres_rad(&self) -> Vec<f64> {
        (0..self.bins_count()).map(|k| self.edge_rad(k) + self.width_rad() / 2.0).collect()
    }

    /// Length of the whole grid.
    pub fn span_rad(&self) -> f64 {
        self.periods_count as f64 * self.period_rad
    }
}

/// Mean over angle of `value` in each bin: work done in the bin over its width.
///
/// `angle_rad` may run either way, with jitter; the work is summed along the path by the trapezoid rule and read
/// where the path first reaches each edge, so uneven speed inside a bin weighs nothing. `None` if the path does not
/// cover the grid or the lengths differ.
pub fn bin_means(angle_rad: &[f64], value: &[f64], grid: &Grid) -> Option<Vec<f64>> {
    let n = angle_rad.len();
    if n < 2 || value.len() != n {
        return None;
    }
    let rising = angle_rad[n - 1] > angle_rad[0];
    let along = |a: f64| if rising { a } else { -a };
    let bins = grid.bins_count();
    let edge = |k: usize| along(grid.edge_rad(if rising { k } else { bins - k }));
    if along(angle_rad[0]) > edge(0) {
        return None;
    }
    let mut at_edges = Vec::with_capacity(bins + 1);
    let mut work = 0.0;
    for i in 1..n {
        let from = along(angle_rad[i - 1]);
        let to = along(angle_rad[i]);
        let mean = (value[i - 1] + value[i]) / 2.0;
        while at_edges.len() <= bins && edge(at_edges.len()) <= to {
            at_edges.push(work + mean * (edge(at_edges.len()) - from));
        }
        work += mean * (to - from);
    }
    if at_edges.len() <= bins {
        return None;
    }
    let mut means: Vec<f64> = at_edges.windows(2).map(|w| (w[1] - w[0]) / grid.width_rad()).collect();
    if !rising {
        means.reverse();
    }
    Some(means)
}

/// Mean of each period of a binned map.
pub fn period_means(map: &[f64], bins_per_period_count: usize) -> Vec<f64> {
    map.chunks_exact(bins_per_period_count).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn grid() -> Grid {
        Grid::common(&[[-1.0, 1.1], [-1.2, 1.0]], 0.25, 1000.0).expect("eight periods")
    }

    #[test]
    fn whole_periods_lie_in_the_middle_of_what_all_strokes_cover() {
        let grid = grid();
        assert_eq!((grid.periods_count, grid.bins_per_period_count), (8, 64));
        assert!((grid.low_rad + 1.0).abs() < 1e-12 && (grid.span_rad() - 2.0).abs() < 1e-12);
        assert_eq!(Grid::common(&[[0.0, 0.2]], 0.25, 1000.0), None);
        assert_eq!(Grid::common(&[[0.0, 0.3]], 0.25, 33.0).map(|g| g.bins_per_period_count), Some(16));
    }

    #[test]
    fn a_grid_with_fewer_than_two_samples_a_period_is_none_however_many_periods_there_are() {
        assert!(Grid::common(&[[0.0, 100.0]], 1.0, 2.0).is_some());
        assert_eq!(Grid::common(&[[0.0, 100.0]], 1.0, 1.99), None);
        assert_eq!(Grid::common(&[[0.0, 1e300]], 1.0, 1e-290), None);
        assert_eq!(Grid::common(&[[0.0, 100.0]], 1.0, f64::NAN), None);
    }

    #[test]
    fn a_path_that_stops_short_is_none() {
        let angle: Vec<f64> = (0..100).map(|i| -1.0 + 0.01 * f64::from(i)).collect();
        assert_eq!(bin_means(&angle, &vec![1.0; 100], &grid()), None);
    }

    proptest! {
        /// Uneven speed and direction do not change a mean over angle; cogging cancels over whole periods.
        #[test]
        fn uneven_speed_weighs_nothing(wobble in 0.0..0.8_f64, reverse: bool, offset in -9.0..9.0_f64) {
            let angle: Vec<f64> = (0..=20_000)
                .map(|i| f64::from(i) / 20_000.0)
                .map(|s| -1.1 + 2.2 * s + wobble * 0.25 / 6.3 * (s * 55.0).sin())
                .map(|a| if reverse { -a } else { a })
                .collect();
            let value: Vec<f64> =
                angle.iter().map(|a| offset + a + 5.0 * (a * std::f64::consts::TAU / 0.25).sin()).collect();
            let grid = grid();
            let map = bin_means(&angle, &value, &grid).expect("the path covers the grid");
            for (k, mean) in period_means(&map, 64).iter().enumerate() {
                let middle = grid.edge_rad(64 * k) + 0.125;
                prop_assert!((mean - offset - middle).abs() < 1e-5, "period {k}: {mean}");
            }
        }
    }
}
