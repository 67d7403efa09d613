//! Zero-phase smoothing and differentiation of a uniformly sampled record.

use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

#[cfg(test)]
mod tests;

/// Degree of the local polynomial.
const DEGREE: usize = 5;
/// Half width of the window times the flat bandwidth: there the acceleration gain has fallen to 0.99 (computed for
/// the continuous quintic kernel; the discrete one differs by less than 2 % from 10 samples half width on).
const HALF_WIDTH_CYCLES: f64 = 0.272;

/// A local quintic least-squares fit that slides over a record (Savitzky & Golay, *Anal. Chem.* 36, 1627, 1964).
///
/// The window is symmetric, so there is no phase shift at any frequency. Up to [`Differentiator::flat_hz`] the gain
/// of position, velocity and acceleration is within 1 % of true; above, it falls. Near the ends the polynomial of
/// the first or last whole window is read off its centre.
#[derive(Clone, Debug)]
pub struct Differentiator {
    sample_rate_hz: f64,
    half: usize,
    /// Polynomial coefficients (in units of the half width) of a window's samples, one row a power.
    projection: DMatrix<f64>,
}

impl Differentiator {
    /// A differentiator that is flat to 1 % up to `flat_hz` on a record of `sample_rate_hz`.
    ///
    /// `None` if the rate is below 16 × `flat_hz` or a figure is not positive: the window would be too short.
    pub fn new(sample_rate_hz: f64, flat_hz: f64) -> Option<Self> {
        let positive = sample_rate_hz > 0.0 && flat_hz > 0.0 && sample_rate_hz.is_finite();
        if !positive || sample_rate_hz < 16.0 * flat_hz {
            return None;
        }
        let half = (HALF_WIDTH_CYCLES * sample_rate_hz / flat_hz).floor().clamp(3.0, 1e6) as usize;
        let offset = |i: usize| (i as f64 - half as f64) / half as f64;
        let design = DMatrix::from_fn(2 * half + 1, DEGREE + 1, |i, k| offset(i).powi(k as i32));
        let inverse = (design.transpose() * &design).try_inverse()?;
        Some(Self { sample_rate_hz, half, projection: inverse * design.transpose() })
    }

    /// Frequency up to which every gain is within 1 % of true.
    pub fn flat_hz(&self) -> f64 {
        HALF_WIDTH_CYCLES * self.sample_rate_hz / self.half as f64
    }

    /// Samples in the window.
    pub fn window(&self) -> usize {
        2 * self.half + 1
    }

    /// The record without what is faster than the window; `None` if it is shorter than one.
    pub fn smooth(&self, record: &[f64]) -> Option<Vec<f64>> {
        self.derive(record, 0)
    }

    /// First derivative per second; `None` if the record is shorter than one window.
    pub fn velocity(&self, record: &[f64]) -> Option<Vec<f64>> {
        self.derive(record, 1)
    }

    /// Second derivative per s²; `None` if the record is shorter than one window.
    pub fn acceleration(&self, record: &[f64]) -> Option<Vec<f64>> {
        self.derive(record, 2)
    }

    /// Gain of [`Differentiator::acceleration`] on a sine, relative to the true second derivative.
    pub fn acceleration_gain_ratio(&self, frequency_hz: f64) -> f64 {
        let step = TAU * frequency_hz / self.sample_rate_hz;
        if step.abs() < 1e-9 {
            return 1.0;
        }
        let weights = self.weights(0.0, 2);
        let response: f64 =
            weights.iter().enumerate().map(|(i, c)| c * (step * (i as f64 - self.half as f64)).cos()).sum();
        -response / (TAU * frequency_hz).powi(2)
    }

    fn derive(&self, record: &[f64], order: usize) -> Option<Vec<f64>> {
        let n = record.len();
        let width = self.window();
        if n < width {
            return None;
        }
        let mut out = vec![0.0; n];
        let centre = self.weights(0.0, order);
        for (window, value) in record.windows(width).zip(&mut out[self.half..]) {
            *value = about(window, &centre, order);
        }
        self.end(&record[..width], order, 0..self.half, &mut out[..self.half]);
        self.end(&record[n - width..], order, self.half + 1..width, &mut out[n - self.half..]);
        Some(out)
    }

    /// Reads one window's polynomial at samples off its centre.
    fn end(&self, window: &[f64], order: usize, at: Range<usize>, out: &mut [f64]) {
        for (i, value) in at.zip(out) {
            let place = (i as f64 - self.half as f64) / self.half as f64;
            *value = about(window, &self.weights(place, order), order);
        }
    }

    /// Weights of a window's samples for a derivative at `place` (−1 … 1 in the window).
    fn weights(&self, place: f64, order: usize) -> DVector<f64> {
        let per_unit = (self.sample_rate_hz / self.half as f64).powi(order as i32);
        let powers = DVector::from_fn(DEGREE + 1, |k, _| {
            let falling: f64 = (0..order).map(|j| k as f64 - j as f64).product();
            if k < order { 0.0 } else { falling * place.powi((k - order) as i32) * per_unit }
        });
        self.projection.tr_mul(&powers)
    }
}

/// Σ weights·window, with the middle sample taken off (and put back where the weights add up to 1) so that large
/// offsets cost no digits.
fn about(window: &[f64], weights: &DVector<f64>, order: usize) -> f64 {
    let middle = window[window.len() / 2];
    let change: f64 = window.iter().zip(weights.iter()).map(|(p, c)| c * (p - middle)).sum();
    if order == 0 { change + middle } else { change }
}
