//! The input of every statistic: evenly spaced phases, checked once.

use rayon::prelude::*;

use super::AllanError;

/// Number of rates that one parallel task sums.
const STRETCH: usize = 1 << 14;
/// Fewest rates that have an Allan deviation.
const LEAST_RATES: usize = 2;

/// Evenly spaced phases x₀ … x_N without gaps, divided by `unit` and with a straight line removed.
///
/// The line does not matter: all statistics use second or higher differences. Without it the phases stay small enough for
/// double precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    phase: Vec<f64>,
    period_s: f64,
    unit: f64,
}

impl Series {
    /// Integrates N rates (any unit), each the mean over one period of `period_s`, to N + 1 phases. The first is 0.
    ///
    /// # Errors
    /// [`AllanError::TooShort`] for fewer than two, [`AllanError::NotFinite`], [`AllanError::Constant`],
    /// [`AllanError::Period`].
    pub fn from_rate(rate: &[f64], period_s: f64) -> Result<Self, AllanError> {
        check(rate, rate.len(), period_s)?;
        let unit = largest_change(rate);
        if unit <= 0.0 {
            return Err(AllanError::Constant);
        }
        if !unit.is_finite() {
            // Finite rates, but their difference overflows.
            let overflows = |y: &f64| !(y - rate[0]).is_finite();
            return Err(AllanError::NotFinite { index: rate.iter().position(overflows).unwrap_or(0) });
        }
        let first = rate[0];
        let sums: Vec<f64> =
            rate.par_chunks(STRETCH).map(|chunk| chunk.iter().map(|y| (y - first) / unit).sum()).collect();
        let mean = compensated(&sums) / rate.len() as f64;
        // Sum of all centred rates before each chunk: the chunks can then be integrated in parallel.
        let mut offsets = Vec::with_capacity(sums.len());
        let mut running = Compensated::default();
        for (sum, chunk) in sums.iter().zip(rate.chunks(STRETCH)) {
            offsets.push(running.value());
            running.add(sum - mean * chunk.len() as f64);
        }
        let mut phase = vec![0.0; rate.len() + 1];
        let integrate = |((phases, rates), offset): ((&mut [f64], &[f64]), &f64)| {
            let mut sum = *offset;
            for (x, y) in phases.iter_mut().zip(rates) {
                sum += (y - first) / unit - mean;
                *x = sum * period_s;
            }
        };
        phase[1..].par_chunks_mut(STRETCH).zip(rate.par_chunks(STRETCH)).zip(&offsets).for_each(integrate);
        Ok(Self { phase, period_s, unit })
    }

    /// Phases, in the unit of the rate times s, divided by [`Series::unit`].
    pub(super) fn phase(&self) -> &[f64] {
        &self.phase
    }

    /// Divisor of the phases, in the unit of the rate: the largest distance of a rate from the first one. It keeps squares
    /// of very small and very large rates in the range of f64.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// First differences of the phases: centred rates times the period, divided by [`Series::unit`].
    pub(super) fn differences(&self) -> Vec<f64> {
        self.phase.windows(2).map(|x| x[1] - x[0]).collect()
    }

    /// Number of rates N.
    pub fn rates(&self) -> usize {
        self.phase.len() - 1
    }

    /// Sampling period, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Duration of the record, s.
    pub fn duration_s(&self) -> f64 {
        self.rates() as f64 * self.period_s
    }
}

/// All values finite, enough rates, a positive period.
fn check(values: &[f64], rates: usize, period_s: f64) -> Result<(), AllanError> {
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(AllanError::Period { period_s });
    }
    if rates < LEAST_RATES {
        return Err(AllanError::TooShort { found: rates, least: LEAST_RATES });
    }
    // Zero times a value that is not finite is NaN, which spreads to the sum: one test per chunk instead of per value.
    let has_bad = |chunk: &[f64]| chunk.iter().map(|v| v * 0.0).sum::<f64>() != 0.0;
    let bad_chunk = values.par_chunks(STRETCH).position_first(has_bad);
    match bad_chunk.and_then(|chunk| (chunk * STRETCH..values.len()).find(|&k| !values[k].is_finite())) {
        Some(index) => Err(AllanError::NotFinite { index }),
        None => Ok(()),
    }
}

/// Largest absolute difference from the first rate.
fn largest_change(rate: &[f64]) -> f64 {
    let first = rate[0];
    let largest = |chunk: &[f64]| chunk.iter().fold(0.0_f64, |largest, y| largest.max((y - first).abs()));
    rate.par_chunks(STRETCH).map(largest).reduce(|| 0.0, f64::max)
}

/// Compensated running sum after Kahan and Neumaier (*ZAMM* 54, 39, 1974); `lost` collects the rounding errors.
#[derive(Clone, Copy, Default)]
pub(super) struct Compensated {
    sum: f64,
    lost: f64,
}

impl Compensated {
    pub(super) fn add(&mut self, value: f64) {
        let sum = self.sum + value;
        self.lost +=
            if self.sum.abs() >= value.abs() { (self.sum - sum) + value } else { (value - sum) + self.sum };
        self.sum = sum;
    }

    pub(super) fn value(&self) -> f64 {
        self.sum + self.lost
    }
}

/// Compensated sum of all values.
pub(super) fn compensated(values: &[f64]) -> f64 {
    let mut sum = Compensated::default();
    values.iter().for_each(|&value| sum.add(value));
    sum.value()
}
