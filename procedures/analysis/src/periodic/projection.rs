//! Complex amplitudes of known lines in one window, by exact least squares.

use std::f64::consts::TAU;
use std::sync::Arc;

use fourier::RealToComplex;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::error::{PeriodicError, alive, positive};
use crate::excitation::HIGHEST_RATIO;
use crate::frf::C64;

/// How far a line may lie from its place on the grid, in periods a window.
const OFF_GRID: f64 = 1e-6;
/// Smallest part of a nuisance column (norm²) that must be left beside lines and earlier columns.
const LEAST_LEFT: f64 = 1e-9;

/// A recorded channel.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'a> {
    /// Name of the signal, for messages.
    pub name: &'a str,
    /// Samples of the signal.
    pub samples: &'a [f64],
}

/// What slow motion below the lines is taken for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drift {
    /// An offset and a slope: right where the motion under the lines is even, as between two turn-rounds.
    #[default]
    Slope,
    /// An offset alone, which lines on the grid of the window (φ = 0) do not see: each window's plain discrete Fourier
    /// transform. Right for a record of whole periods in which slow content wanders: see [`amplitudes`].
    Level,
}

/// Projects windows of one length onto one set of lines.
pub struct Projection {
    length: usize,
    bins: Vec<usize>,
    /// e^(−j2πφi/N): moves the lines onto the bins of the transform; empty at φ = 0.
    shift: Vec<C64>,
    plan: Arc<dyn RealToComplex<f64>>,
    gram: Gram,
}

/// Inner products of the lines' cosines and sines.
enum Gram {
    /// 2·φ whole: all orthogonal, each of norm² N/2.
    Diagonal(f64),
    /// Cosines and sines of different lines couple.
    Full(Cholesky<f64, Dyn>),
}

impl Projection {
    /// Windows of `length` samples, lines at `grid_hz`.
    ///
    /// # Errors
    /// [`PeriodicError::NotOnGrid`] unless all lines are (whole number + φ)/T_w with one φ, [`PeriodicError::TooFast`],
    /// [`PeriodicError::TooShort`], [`PeriodicError::NotPositive`].
    pub fn new(sample_rate_hz: f64, length: usize, grid_hz: &[f64]) -> Result<Self, PeriodicError> {
        positive("sample rate, Hz", sample_rate_hz)?;
        let unknowns = 2 * grid_hz.len() + 2;
        if length <= unknowns {
            return Err(PeriodicError::TooShort {
                what: "samples a window",
                expected: unknowns,
                found: length,
            });
        }
        let (bins, offset) = bins(sample_rate_hz, length, grid_hz)?;
        let turn = |i: usize| C64::from_polar(1.0, -TAU * offset * i as f64 / length as f64);
        let shift = if offset > 0.0 { (0..length).map(turn).collect() } else { vec![] };
        let plan = fourier::forward(length);
        let doubled = 2.0 * offset;
        let gram = if doubled.fract() < OFF_GRID {
            Gram::Diagonal(0.5 * length as f64)
        } else {
            let matrix = coupled(&bins, doubled, length);
            let cholesky = Cholesky::new(matrix);
            Gram::Full(cholesky.ok_or(PeriodicError::Dependent { column: 0 })?)
        };
        Ok(Self { length, bins, shift, plan, gram })
    }

    /// Takes up the columns that are fitted beside the lines: an offset, a slope, and those given.
    ///
    /// # Errors
    /// As [`Projection::prepare_with`].
    pub fn prepare(&self, nuisance: &[&[f64]]) -> Result<Prepared<'_>, PeriodicError> {
        self.prepare_with(Drift::Slope, nuisance)
    }

    /// Projection with a choice of what drift is taken for.
    ///
    /// # Errors
    /// [`PeriodicError::Length`], [`PeriodicError::NotFinite`], [`PeriodicError::Dependent`].
    pub fn prepare_with(&self, drift: Drift, nuisance: &[&[f64]]) -> Result<Prepared<'_>, PeriodicError> {
        let n = self.length;
        let half = 0.5 * (n - 1) as f64;
        let mut columns: Vec<Vec<f64>> = vec![vec![1.0; n]];
        if drift == Drift::Slope {
            columns.push((0..n).map(|i| i as f64 / half - 1.0).collect());
        }
        let own = columns.len();
        for (k, given) in nuisance.iter().enumerate() {
            if given.len() != n {
                let channel = format!("nuisance column {k}");
                return Err(PeriodicError::Length { channel, expected: n, found: given.len() });
            }
            if let Some(sample) = given.iter().position(|v| !v.is_finite()) {
                return Err(PeriodicError::NotFinite { channel: format!("nuisance column {k}"), sample });
            }
            columns.push(centred(given).ok_or(PeriodicError::Dependent { column: k })?);
        }
        let products: Vec<DVector<f64>> = columns.iter().map(|c| self.products(c)).collect();
        let solved: Vec<DVector<f64>> = products.iter().map(|p| self.solve(p)).collect();
        let schur = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
            dot(&columns[i], &columns[j]) - products[i].dot(&solved[j])
        });
        let bound = |k: usize| schur[(k, k)] > LEAST_LEFT * dot(&columns[k], &columns[k]);
        let at_fault = |k: usize| PeriodicError::Dependent { column: k.saturating_sub(own) };
        if let Some(k) = (0..columns.len()).find(|&k| !bound(k)) {
            return Err(at_fault(k));
        }
        let last = columns.len() - 1;
        let schur = Cholesky::new(schur).ok_or_else(|| at_fault(last))?;
        for (k, column) in columns.iter().enumerate() {
            if schur.l_dirty()[(k, k)].powi(2) <= LEAST_LEFT * dot(column, column) {
                return Err(at_fault(k));
            }
        }
        Ok(Prepared { projection: self, drift, columns, solved, schur })
    }

    /// Inner products with the cosines and sines of the lines: (Re, Im) of Σ v·e^(jωt), line by line.
    fn products(&self, values: &[f64]) -> DVector<f64> {
        let sums: Vec<C64> = if self.shift.is_empty() {
            let spectrum = self.transform(values.to_vec());
            self.bins.iter().map(|&k| spectrum[k]).collect()
        } else {
            let real = self.transform(values.iter().zip(&self.shift).map(|(v, s)| v * s.re).collect());
            let imaginary = self.transform(values.iter().zip(&self.shift).map(|(v, s)| v * s.im).collect());
            self.bins.iter().map(|&k| real[k] + imaginary[k] * C64::i()).collect()
        };
        DVector::from_iterator(2 * sums.len(), sums.iter().flat_map(|s| [s.re, -s.im]))
    }

    fn transform(&self, mut values: Vec<f64>) -> Vec<C64> {
        let mut spectrum = self.plan.make_output_vec();
        self.plan.process(&mut values, &mut spectrum).expect("the plan has the window's length");
        spectrum
    }

    fn solve(&self, products: &DVector<f64>) -> DVector<f64> {
        match &self.gram {
            Gram::Diagonal(norm) => products / *norm,
            Gram::Full(cholesky) => cholesky.solve(products),
        }
    }
}

/// A projection with its nuisance columns.
pub struct Prepared<'a> {
    projection: &'a Projection,
    drift: Drift,
    columns: Vec<Vec<f64>>,
    /// What the lines take of each column.
    solved: Vec<DVector<f64>>,
    /// Inner products of what the lines leave of the columns.
    schur: Cholesky<f64, Dyn>,
}

impl Prepared<'_> {
    /// Amplitudes of the lines in one window; `from` is its place in the record, for messages. Phases refer to the
    /// window's first sample.
    ///
    /// # Errors
    /// [`PeriodicError::Length`], [`PeriodicError::NotFinite`], [`PeriodicError::Constant`].
    pub fn amplitudes(&self, window: Channel<'_>, from: usize) -> Result<Vec<C64>, PeriodicError> {
        let n = self.projection.length;
        if window.samples.len() != n {
            let channel = window.name.to_owned();
            return Err(PeriodicError::Length { channel, expected: n, found: window.samples.len() });
        }
        alive(window.name, window.samples, from)?;
        let level = flattened(window.samples, self.drift);
        let products = self.projection.products(&level);
        let mut lines = self.projection.solve(&products);
        let left = DVector::from_iterator(
            self.columns.len(),
            self.columns.iter().zip(&self.solved).map(|(c, s)| dot(c, &level) - s.dot(&products)),
        );
        let nuisance = self.schur.solve(&left);
        for (solved, b) in self.solved.iter().zip(nuisance.iter()) {
            lines -= solved * *b;
        }
        Ok((0..lines.len() / 2).map(|k| C64::new(lines[2 * k], -lines[2 * k + 1])).collect())
    }
}

/// Complex amplitudes X = a − j·b of a·cos ωt + b·sin ωt (t from the first sample) of all lines in one window, beside
/// an offset, a slope and the `nuisance` columns: exact joint least squares.
///
/// The lines are orthogonal on the window, so two transforms give their inner products; offset, slope and nuisance
/// are solved for by the Schur complement (at φ = ¼, ¾ the lines couple, and their Gram matrix is solved). The window
/// is the whole signal, T_w = length/f_s.
///
/// The slope is only as good as the model: slow content that no column holds (friction that wanders, even distortion
/// below the first line) is taken for a slope, whose saw-tooth then sits on **all** lines. On the motor bench of
/// tests/data/motorbench (full record, angle) this made 0.0975 rad/s/A of 0.0262 at the anti-resonance. Give cosine and
/// sine of the places of the grid below the first line as nuisance columns, or list them in `grid_hz` where no
/// reference is divided by: the same record then gives 0.0265, with 0.38 instead of 0.62 % of spread. Or leave the
/// slope out ([`Drift::Level`]): 0.0262, as plain transforms give.
///
/// # Errors
/// As [`Projection::new`], [`Projection::prepare`], [`Prepared::amplitudes`].
pub fn amplitudes(
    signal: &[f64],
    sample_rate_hz: f64,
    grid_hz: &[f64],
    nuisance: &[&[f64]],
) -> Result<Vec<C64>, PeriodicError> {
    let projection = Projection::new(sample_rate_hz, signal.len(), grid_hz)?;
    projection.prepare(nuisance)?.amplitudes(Channel { name: "signal", samples: signal }, 0)
}

/// Bins of the lines and their common offset.
fn bins(sample_rate_hz: f64, length: usize, grid_hz: &[f64]) -> Result<(Vec<usize>, f64), PeriodicError> {
    let turns = |f: f64| f * length as f64 / sample_rate_hz;
    let first = grid_hz.first().map_or(0.0, |&f| turns(f));
    // Rounding must not make 0 of 1 or lose the orthogonality of a half.
    let quarters = (4.0 * first).round() / 4.0;
    let exact = if (first - quarters).abs() < OFF_GRID { quarters } else { first };
    let offset = exact - exact.floor();
    let limit_hz = HIGHEST_RATIO * sample_rate_hz;
    let mut bins: Vec<usize> = Vec::with_capacity(grid_hz.len());
    for &frequency_hz in grid_hz {
        positive("line frequency, Hz", frequency_hz)?;
        if frequency_hz > limit_hz {
            return Err(PeriodicError::TooFast { frequency_hz, limit_hz });
        }
        let found = turns(frequency_hz);
        let bin = (found - offset).round();
        let twice = bins.last().is_some_and(|&last| bin <= last as f64);
        if (found - offset - bin).abs() > OFF_GRID || twice {
            return Err(PeriodicError::NotOnGrid { frequency_hz, offset, turns: found, samples: length });
        }
        bins.push(bin as usize);
    }
    Ok((bins, offset))
}

/// Gram matrix of cosines and sines where sum frequencies are no whole number of periods: with
/// E = Σ e^(j2πsi/N), s = k + l + 2φ: cos·cos = (Nδ + Re E)/2, sin·sin = (Nδ − Re E)/2, cos·sin = Im E/2.
fn coupled(bins: &[usize], doubled: f64, length: usize) -> DMatrix<f64> {
    let n = length as f64;
    let sum = |k: usize, l: usize| {
        let s = (bins[k] + bins[l]) as f64 + doubled;
        let one = C64::new(1.0, 0.0);
        (one - C64::from_polar(1.0, TAU * s.fract())) / (one - C64::from_polar(1.0, TAU * s / n))
    };
    DMatrix::from_fn(2 * bins.len(), 2 * bins.len(), |i, j| {
        let k = i / 2;
        let l = j / 2;
        let own = if k == l { n } else { 0.0 };
        match (i % 2, j % 2) {
            (0, 0) => 0.5 * (own + sum(k, l).re),
            (1, 1) => 0.5 * (own - sum(k, l).re),
            _ => 0.5 * sum(k, l).im,
        }
    })
}

/// The window less the straight line through its ends (its first value, if no slope is fitted): what is in the model
/// changes nothing, but large angles no longer eat digits.
fn flattened(values: &[f64], drift: Drift) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (values.first(), values.last()) else { return vec![] };
    let rise = match drift {
        Drift::Slope => (last - first) / (values.len().max(2) - 1) as f64,
        Drift::Level => 0.0,
    };
    values.iter().enumerate().map(|(i, v)| v - first - rise * i as f64).collect()
}

/// A column less its mean, scaled to rms 1; `None` if it is constant.
fn centred(values: &[f64]) -> Option<Vec<f64>> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let rms = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    (rms > 1e-12 * mean.abs() && rms > 0.0).then(|| values.iter().map(|v| (v - mean) / rms).collect())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
