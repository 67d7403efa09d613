//! Local polynomial and local rational models of a response, for excitation that does not repeat.

use std::ops::RangeInclusive;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::error::{PeriodicError, alive, positive, within_range};
use crate::frf::{C64, Frf, Line};

/// Smallest diagonal of R (columns scaled to norm 1) that still counts as independent.
const LEAST_INDEPENDENCE: f64 = 1e-9;

/// What is fitted around each line of the transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LocalModel {
    /// Order R of the polynomials of G (its numerator) and of the transient.
    pub order: usize,
    /// Order of the common denominator: 0 is the local polynomial model.
    pub denominator_order: usize,
    /// Lines n taken on each side.
    pub half_width: usize,
}

impl LocalModel {
    /// Local polynomial model of order 2: its bias at a resonance grows with (n·Δf/B_3dB)³, so the 3 dB bandwidth
    /// should hold much more than the 2n + 1 lines.
    pub fn polynomial(half_width: usize) -> Self {
        Self { order: 2, denominator_order: 0, half_width }
    }

    /// Local rational model of orders 2/2: a resonance is rational, so few lines in its bandwidth suffice. For signal
    /// to noise of 20 dB or more on each line (the denominator multiplies the measured output).
    pub fn rational(half_width: usize) -> Self {
        Self { order: 2, denominator_order: 2, half_width }
    }

    /// Complex unknowns for a number of segments that share G.
    fn unknowns(&self, segments: usize) -> usize {
        let polynomials = self.order.saturating_add(1).saturating_mul(segments.saturating_add(1));
        polynomials.saturating_add(self.denominator_order)
    }

    /// Lines of one segment in a neighbourhood.
    fn width(&self) -> usize {
        self.half_width.saturating_mul(2).saturating_add(1)
    }
}

/// A stretch of a record.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a> {
    /// Input.
    pub input: &'a [f64],
    /// Output, as long.
    pub output: &'a [f64],
}

/// Response by a local model at all lines of the transform in a band: [`lpm_segments`] with one segment.
///
/// # Errors
/// As [`lpm_segments`].
pub fn lpm(
    input: &[f64],
    output: &[f64],
    sample_rate_hz: f64,
    band_hz: &RangeInclusive<f64>,
    model: LocalModel,
) -> Result<Frf, PeriodicError> {
    lpm_segments(&[Segment { input, output }], sample_rate_hz, band_hz, model)
}

/// Response by a local model from segments of one length that share G, each with a transient of its own.
///
/// Around line k: Y(k + r)·(1 + Σ d_s·r^s) = (Σ g_s·r^s)·U(k + r) + Σ t_s·r^s, r = −n…n (cut at the ends of the
/// spectrum), linear least squares; G = g₀. The smooth polynomial t is the leakage (initial less final state).
/// Polynomial: Schoukens, Vandersteen, Barbé & Pintelon, *IFAC SYSID* 2009, and Pintelon & Schoukens, *System
/// Identification*, 2nd ed., ch. 7; rational: McKelvey & Guérin, *IFAC SYSID* 2012.
/// The variance is that of the residual, with (2n + 1)·segments − unknowns complex degrees of freedom. The input is
/// taken as exact. Neighbouring lines share data, so their errors are correlated over 2n lines.
///
/// # Errors
/// [`PeriodicError::NoFreedom`] with too few lines for the unknowns, [`PeriodicError::Indistinct`] where the input
/// does not tell them apart, [`PeriodicError::Length`], [`PeriodicError::Constant`], [`PeriodicError::NotFinite`],
/// [`PeriodicError::TooShort`], [`PeriodicError::NotPositive`], [`PeriodicError::TooLarge`].
pub fn lpm_segments(
    segments: &[Segment<'_>],
    sample_rate_hz: f64,
    band_hz: &RangeInclusive<f64>,
    model: LocalModel,
) -> Result<Frf, PeriodicError> {
    positive("sample rate, Hz", sample_rate_hz)?;
    let length = check(segments, model)?;
    let spectra: Vec<[Vec<C64>; 2]> =
        segments.iter().map(|s| [transform(s.input), transform(s.output)]).collect();
    let step_hz = sample_rate_hz / length as f64;
    let lines: Vec<usize> =
        (1..length.div_ceil(2)).filter(|&k| band_hz.contains(&(k as f64 * step_hz))).collect();
    if lines.is_empty() {
        return Err(PeriodicError::TooFew { what: "lines in the band", expected: 1, found: 0 });
    }
    lines.par_iter().map(|&k| line(&spectra, k, k as f64 * step_hz, length.div_ceil(2), model)).collect()
}

/// Length that all segments share.
fn check(segments: &[Segment<'_>], model: LocalModel) -> Result<usize, PeriodicError> {
    let expected = segments.first().map_or(0, |s| s.input.len());
    for (i, segment) in segments.iter().enumerate() {
        for (name, values) in [("input", segment.input), ("output", segment.output)] {
            let channel = format!("{name} of segment {i}");
            if values.len() != expected {
                return Err(PeriodicError::Length { channel, expected, found: values.len() });
            }
            alive(&channel, values, 0)?;
        }
    }
    let lines = model.width().saturating_mul(segments.len());
    let unknowns = model.unknowns(segments.len());
    if lines <= unknowns {
        return Err(PeriodicError::NoFreedom { unknowns, lines });
    }
    let least = model.width().saturating_mul(2).saturating_add(1);
    if expected <= least {
        return Err(PeriodicError::TooShort { what: "samples a segment", expected: least, found: expected });
    }
    Ok(expected)
}

/// Transform scaled by 1/√N, so that noise keeps its size.
fn transform(values: &[f64]) -> Vec<C64> {
    let plan = fourier::forward(values.len());
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut values.to_vec(), &mut spectrum).expect("the plan has the segment's length");
    let scale = 1.0 / (values.len() as f64).sqrt();
    spectrum.iter_mut().for_each(|v| *v *= scale);
    spectrum
}

fn line(
    spectra: &[[Vec<C64>; 2]],
    k: usize,
    frequency_hz: f64,
    end: usize,
    model: LocalModel,
) -> Result<Line, PeriodicError> {
    let width = model.width();
    let first = k.saturating_sub(model.half_width).clamp(1, end - width);
    let unknowns = model.unknowns(spectra.len());
    let mut design = DMatrix::<C64>::zeros(width * spectra.len(), unknowns);
    let mut wanted = DVector::<C64>::zeros(width * spectra.len());
    for (s, [input, output]) in spectra.iter().enumerate() {
        for i in 0..width {
            let row = s * width + i;
            let bin = first + i;
            let r = (bin as f64 - k as f64) / model.half_width as f64;
            wanted[row] = output[bin];
            fill(&mut design, row, s, model, r, [input[bin], output[bin]]);
        }
    }
    let solved = match first_coefficient(design, &wanted) {
        Err(column) => {
            let denominator = model.order + 1..model.order + 1 + model.denominator_order;
            if denominator.contains(&column) {
                // Without noise the output of a static plant is no column of its own: there is no denominator.
                let polynomial = LocalModel { denominator_order: 0, ..model };
                return line(spectra, k, frequency_hz, end, polynomial);
            }
            return Err(PeriodicError::Indistinct { frequency_hz });
        }
        Ok(solved) => solved,
    };
    let dof = (width * spectra.len() - unknowns) as f64;
    let value = solved.0;
    let variance = solved.1 / dof;
    within_range("spectrum", value.norm_sqr() + variance)?;
    Ok(Line { frequency_hz, value, variance, dof, coherence: None })
}

/// One equation: G's powers, the denominator's, then a block of transients a segment.
fn fill(design: &mut DMatrix<C64>, row: usize, segment: usize, model: LocalModel, r: f64, [u, y]: [C64; 2]) {
    let powers = model.order + 1;
    let transients = powers + model.denominator_order + segment * powers;
    let mut power = 1.0;
    for p in 0..powers.max(model.denominator_order + 1) {
        if p < powers {
            design[(row, p)] = u * power;
            design[(row, transients + p)] = C64::new(power, 0.0);
        }
        if (1..=model.denominator_order).contains(&p) {
            design[(row, powers + p - 1)] = -y * power;
        }
        power *= r;
    }
}

/// Least squares by QR: the first coefficient, and its variance for a sum of squared residuals of dof times 1; or the
/// first column that is a combination of those before it.
fn first_coefficient(mut design: DMatrix<C64>, wanted: &DVector<C64>) -> Result<(C64, f64), usize> {
    let n = design.ncols();
    let mut first_scale = 1.0;
    for (k, mut column) in design.column_iter_mut().enumerate() {
        let norm = column.norm();
        if norm <= 0.0 {
            return Err(k);
        }
        column /= C64::new(norm, 0.0);
        if k == 0 {
            first_scale = norm;
        }
    }
    let qr = design.qr();
    let q = qr.q();
    let r = qr.r();
    if let Some(k) = (0..n).find(|&k| r[(k, k)].norm() < LEAST_INDEPENDENCE) {
        return Err(k);
    }
    let projected = q.adjoint() * wanted;
    let rest = (wanted - &q * &projected).norm_squared();
    let coefficients = r.solve_upper_triangular(&projected).ok_or(0_usize)?;
    let inverse = r.solve_upper_triangular(&DMatrix::identity(n, n)).ok_or(0_usize)?;
    let gain = inverse.row(0).iter().map(|v| v.norm_sqr()).sum::<f64>();
    Ok((coefficients[0] / first_scale, rest * gain / (first_scale * first_scale)))
}
