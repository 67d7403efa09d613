//! Which averaging factors.

use super::{Series, Statistic};

/// How averaging factors follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// 1, 2, 4, 8, …
    Octave,
    /// 1, 2, 4, 10, 20, 40, …
    Decade,
    /// About this many a decade, evenly on a logarithmic scale, none twice.
    PerDecade(u32),
    /// All: only for short records.
    All,
}

impl Series {
    /// Averaging factors that this record allows for a statistic, ascending.
    pub fn factors(&self, spacing: Spacing, statistic: Statistic) -> Vec<usize> {
        let most = statistic.largest_factor(self.rates());
        let mut factors: Vec<usize> = match spacing {
            Spacing::Octave => {
                std::iter::successors(Some(1), |m| Some(2 * m)).take_while(|m| *m <= most).collect()
            }
            Spacing::Decade => std::iter::successors(Some(1), |m| Some(10 * m))
                .take_while(|m| *m <= most)
                .flat_map(|m| [m, 2 * m, 4 * m])
                .filter(|m| *m <= most)
                .collect(),
            Spacing::PerDecade(count) => {
                let step = 10.0_f64.powf(1.0 / f64::from(count.max(1)));
                std::iter::successors(Some(1.0), |m| Some(m * step))
                    .map(|m: f64| m.round() as usize)
                    .take_while(|m| *m <= most)
                    .collect()
            }
            Spacing::All => (1..=most).collect(),
        };
        factors.dedup();
        if statistic == Statistic::Theo1 {
            factors.retain(|m| *m >= 10 && m.is_multiple_of(2));
        }
        factors
    }
}
