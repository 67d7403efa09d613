//! One smooth curve through a window of lines: complex L between the lines, with its variance.

use super::solve::least_squares;
use super::{C64, Line};

/// Iterations of Sanathanan & Koerner (*IEEE Trans. Autom. Control* 8, 56, 1963) before the last refinement.
const REWEIGHTINGS: usize = 7;
/// Gauss–Newton steps that turn it into the maximum-likelihood fit.
const REFINEMENTS: usize = 4;

/// Form of a curve. All coefficients are complex: a window away from zero frequency has no symmetry to use, and one
/// complex pole is a whole resonance there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// ln L as a polynomial of ln f: slopes, delays, everything without resonance.
    LogPolynomial {
        /// Number of coefficients.
        terms: usize,
    },
    /// L as a ratio of polynomials of f: resonances.
    Rational {
        /// Degree above.
        above: usize,
        /// Degree below.
        below: usize,
    },
}

impl Shape {
    /// Complex coefficients.
    pub(super) fn coefficients(self) -> usize {
        match self {
            Self::LogPolynomial { terms } => terms,
            Self::Rational { above, below } => above + below + 1,
        }
    }
}

/// A fitted curve.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    shape: Shape,
    centre_hz: f64,
    half_width: f64,
    coefficients: Vec<C64>,
    root: Vec<Vec<C64>>,
    /// Σ|residual|²/variance.
    pub(super) chi2: f64,
    /// Factor on the variance that linear theory gives.
    pub(super) scale: f64,
}

impl Curve {
    /// Fits lines around a frequency; `sd` is the standard deviation of each (any common factor if all are exact).
    pub(super) fn new(
        shape: Shape,
        centre_hz: f64,
        lines: &[Line],
        phase: &[f64],
        sd: &[f64],
    ) -> Option<Self> {
        let abscissa = |f: f64| match shape {
            Shape::LogPolynomial { .. } => (f / centre_hz).ln(),
            Shape::Rational { .. } => f - centre_hz,
        };
        let half_width = lines.iter().map(|l| abscissa(l.frequency_hz).abs()).fold(0.0, f64::max);
        let x: Vec<f64> = lines.iter().map(|l| abscissa(l.frequency_hz) / half_width).collect();
        let mut curve = Self {
            shape,
            centre_hz,
            half_width,
            coefficients: Vec::new(),
            root: Vec::new(),
            chi2: 0.0,
            scale: 1.0,
        };
        match shape {
            Shape::LogPolynomial { terms } => curve.fit_logarithm(terms, &x, lines, phase, sd)?,
            Shape::Rational { above, below } => curve.fit_ratio([above, below], &x, lines, sd)?,
        }
        (curve.chi2.is_finite() && curve.coefficients.iter().all(|c| c.norm().is_finite())).then_some(curve)
    }

    fn fit_logarithm(
        &mut self,
        terms: usize,
        x: &[f64],
        lines: &[Line],
        phase: &[f64],
        sd: &[f64],
    ) -> Option<()> {
        let weight: Vec<f64> = lines.iter().zip(sd).map(|(l, s)| l.value.norm() / s).collect();
        let columns: Vec<Vec<C64>> = (0..terms)
            .map(|k| x.iter().zip(&weight).map(|(x, w)| C64::from(x.powi(k as i32) * w)).collect())
            .collect();
        let rhs: Vec<C64> = lines
            .iter()
            .zip(phase)
            .zip(&weight)
            .map(|((l, p), w)| C64::new(l.value.norm().ln(), *p) * *w)
            .collect();
        let solved = least_squares(columns.clone(), rhs.clone())?;
        let modelled = |i: usize| -> C64 { (0..terms).map(|k| columns[k][i] * solved.coefficients[k]).sum() };
        self.chi2 = rhs.iter().enumerate().map(|(i, y)| (y - modelled(i)).norm_sqr()).sum();
        (self.coefficients, self.root) = (solved.coefficients, solved.root);
        Some(())
    }

    fn fit_ratio(&mut self, [above, below]: [usize; 2], x: &[f64], lines: &[Line], sd: &[f64]) -> Option<()> {
        let measured: Vec<C64> = lines.iter().map(|l| l.value).collect();
        let mut denominator = vec![C64::from(1.0); x.len()];
        for _ in 0..REWEIGHTINGS {
            let columns = ratio_columns(above, below, x, &measured, &denominator, sd);
            let rhs = (0..x.len()).map(|i| measured[i] / (denominator[i] * sd[i])).collect();
            self.coefficients = least_squares(columns, rhs)?.coefficients;
            denominator = x.iter().map(|x| self.denominator(above, *x)).collect();
        }
        let mut cost = self.cost(x, lines, sd);
        for _ in 0..REFINEMENTS {
            let step = self.linearised(above, below, x, lines, sd)?.coefficients;
            let Some((better, less)) = self.along(&step, cost, x, lines, sd) else { break };
            let done = cost - less <= 1e-9 * cost;
            (self.coefficients, cost) = (better, less);
            if done {
                break;
            }
        }
        self.chi2 = cost;
        self.root = self.linearised(above, below, x, lines, sd)?.root;
        Some(())
    }

    /// Linear problem of a Gauss–Newton step: the model is holomorphic, so the step is complex.
    fn linearised(
        &self,
        above: usize,
        below: usize,
        x: &[f64],
        lines: &[Line],
        sd: &[f64],
    ) -> Option<super::solve::Solution> {
        let value: Vec<C64> = x.iter().map(|x| self.at(*x)).collect();
        let denominator: Vec<C64> = x.iter().map(|x| self.denominator(above, *x)).collect();
        let columns = ratio_columns(above, below, x, &value, &denominator, sd);
        least_squares(columns, (0..x.len()).map(|i| (lines[i].value - value[i]) / sd[i]).collect())
    }

    /// The longest of four steps that does not cost more.
    fn along(
        &self,
        step: &[C64],
        cost: f64,
        x: &[f64],
        lines: &[Line],
        sd: &[f64],
    ) -> Option<(Vec<C64>, f64)> {
        [1.0, 0.5, 0.25, 0.1].iter().find_map(|part| {
            let mut trial = self.clone();
            trial.coefficients.iter_mut().zip(step).for_each(|(c, s)| *c += s * *part);
            let less = trial.cost(x, lines, sd);
            (less <= cost).then_some((trial.coefficients, less))
        })
    }

    fn cost(&self, x: &[f64], lines: &[Line], sd: &[f64]) -> f64 {
        x.iter().zip(lines).zip(sd).map(|((x, l), s)| ((l.value - self.at(*x)) / *s).norm_sqr()).sum()
    }

    fn denominator(&self, above: usize, x: f64) -> C64 {
        1.0 + self.coefficients[above + 1..].iter().rev().fold(C64::default(), |sum, c| (sum + c) * x)
    }

    /// Value at a scaled abscissa.
    fn at(&self, x: f64) -> C64 {
        let polynomial = |c: &[C64]| c.iter().rev().fold(C64::default(), |sum, c| sum * x + c);
        match self.shape {
            Shape::LogPolynomial { .. } => polynomial(&self.coefficients).exp(),
            Shape::Rational { above, .. } => {
                polynomial(&self.coefficients[..=above]) / self.denominator(above, x)
            }
        }
    }

    /// Derivatives by the coefficients at a scaled abscissa.
    fn gradient(&self, x: f64) -> Vec<C64> {
        let value = self.at(x);
        let power = |k: usize| C64::from(x.powi(k as i32));
        match self.shape {
            Shape::LogPolynomial { terms } => (0..terms).map(|k| value * power(k)).collect(),
            Shape::Rational { above, below } => {
                let under = self.denominator(above, x);
                let up = (0..=above).map(|k| power(k) / under);
                up.chain((1..=below).map(|k| -value * power(k) / under)).collect()
            }
        }
    }

    /// L at a frequency.
    pub(super) fn value(&self, frequency_hz: f64) -> C64 {
        self.at(self.abscissa(frequency_hz))
    }

    fn abscissa(&self, frequency_hz: f64) -> f64 {
        let x = match self.shape {
            Shape::LogPolynomial { .. } => (frequency_hz / self.centre_hz).ln(),
            Shape::Rational { .. } => frequency_hz - self.centre_hz,
        };
        x / self.half_width
    }

    /// Variance of L at a frequency, E|ΔL|².
    pub(super) fn variance(&self, frequency_hz: f64) -> f64 {
        let gradient = self.gradient(self.abscissa(frequency_hz));
        let along =
            |column: &Vec<C64>| column.iter().zip(&gradient).map(|(r, g)| r * g).sum::<C64>().norm_sqr();
        self.scale * self.root.iter().map(along).sum::<f64>()
    }

    /// dln L/dln f: the real part is the slope of ln|L|, the imaginary that of the phase.
    pub(super) fn slope(&self, frequency_hz: f64) -> C64 {
        let step = 1e-5;
        let [high, low] = [1.0 + step, 1.0 - step].map(|q| self.value(q * frequency_hz));
        (high / low).ln() / ((1.0 + step) / (1.0 - step)).ln()
    }
}

/// Columns of the linearised ratio: xᵏ/D above, −G·xᵏ/D below, over sd.
fn ratio_columns(
    above: usize,
    below: usize,
    x: &[f64],
    value: &[C64],
    denominator: &[C64],
    sd: &[f64],
) -> Vec<Vec<C64>> {
    let next = |column: &[C64]| column.iter().zip(x).map(|(c, x)| c * *x).collect::<Vec<C64>>();
    let first: Vec<C64> = denominator.iter().zip(sd).map(|(d, s)| 1.0 / (d * *s)).collect();
    let mut under: Vec<C64> = first.iter().zip(value).map(|(f, v)| -v * f).collect();
    let mut columns = vec![first];
    for k in 0..above {
        columns.push(next(&columns[k]));
    }
    for _ in 0..below {
        under = next(&under);
        columns.push(under.clone());
    }
    columns
}
