//! A record: evenly spaced phases, checked once.

use rayon::prelude::*;

use super::AllanError;

/// Rates of one stretch of the running sum.
const STRETCH: usize = 1 << 14;
/// Fewest rates that have an Allan deviation.
const LEAST_RATES: usize = 2;

/// Evenly spaced phases x₀ … x_N without gap, in parts of the size of the rates, a straight line taken off: no statistic of
/// second or higher differences sees one, and what stays is small enough for double precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    phase: Vec<f64>,
    period_s: f64,
    unit: f64,
}

impl Series {
    /// From N rates (any unit), each the mean over a period of `period_s`.
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
            let apart = |y: &f64| !(y - rate[0]).is_finite();
            return Err(AllanError::NotFinite { index: rate.iter().position(apart).unwrap_or(0) });
        }
        let first = rate[0];
        let sums: Vec<f64> =
            rate.par_chunks(STRETCH).map(|part| part.iter().map(|y| (y - first) / unit).sum()).collect();
        let mean = compensated(&sums) / rate.len() as f64;
        let mut start = Vec::with_capacity(sums.len());
        let mut before = Compensated::default();
        for (sum, part) in sums.iter().zip(rate.chunks(STRETCH)) {
            start.push(before.value());
            before.add(sum - mean * part.len() as f64);
        }
        let mut phase = vec![0.0; rate.len() + 1];
        let fill = |((x, y), start): ((&mut [f64], &[f64]), &f64)| {
            let mut sum = *start;
            for (x, y) in x.iter_mut().zip(y) {
                sum += (y - first) / unit - mean;
                *x = sum * period_s;
            }
        };
        phase[1..].par_chunks_mut(STRETCH).zip(rate.par_chunks(STRETCH)).zip(&start).for_each(fill);
        Ok(Self { phase, period_s, unit })
    }

    /// Phases, unit of the rate times s over [`Series::unit`].
    pub(super) fn phase(&self) -> &[f64] {
        &self.phase
    }

    /// What the phases are measured in: keeps squares of very small and very large rates in range.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// Differences of neighbouring phases, rates times the period.
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

fn check(values: &[f64], rates: usize, period_s: f64) -> Result<(), AllanError> {
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(AllanError::Period { period_s });
    }
    if rates < LEAST_RATES {
        return Err(AllanError::TooShort { found: rates, least: LEAST_RATES });
    }
    let bad = |part: &[f64]| part.iter().map(|v| v * 0.0).sum::<f64>() != 0.0;
    let found = values.par_chunks(STRETCH).position_first(bad);
    match found.and_then(|part| (part * STRETCH..values.len()).find(|&k| !values[k].is_finite())) {
        Some(index) => Err(AllanError::NotFinite { index }),
        None => Ok(()),
    }
}

/// Largest distance from the first value.
fn largest_change(rate: &[f64]) -> f64 {
    let first = rate[0];
    let most = |part: &[f64]| part.iter().fold(0.0_f64, |most, y| most.max((y - first).abs()));
    rate.par_chunks(STRETCH).map(most).reduce(|| 0.0, f64::max)
}

/// Running sum of Kahan and Neumaier (*ZAMM* 54, 39, 1974).
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

pub(super) fn compensated(values: &[f64]) -> f64 {
    let mut sum = Compensated::default();
    values.iter().for_each(|&value| sum.add(value));
    sum.value()
}
