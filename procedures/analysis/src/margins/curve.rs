//! One smooth curve through a window of lines: complex L between the lines, with its variance.

use super::solve::{Solution, least_squares};
use super::{C64, Line};

/// Iterations of Sanathanan & Koerner (*IEEE Trans. Autom. Control* 8, 56, 1963) before the last refinement.
const REWEIGHTINGS: usize = 7;
/// Gauss–Newton steps that turn it into the maximum-likelihood fit.
const REFINEMENTS: usize = 4;
/// Most refinements where a delay is fitted, too.
const DELAYED_REFINEMENTS: usize = 10;
/// Shares of the slope of the phase that a delay begins at.
const DELAY_STARTS: [f64; 4] = [0.0, 0.3, 0.6, 0.9];

/// Form of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// ln L as a polynomial of ln f, complex coefficients: slopes, delays, everything without resonance.
    LogPolynomial {
        /// Number of coefficients.
        terms: usize,
    },
    /// L as a ratio of polynomials of f, complex coefficients: a window away from 0 Hz has no symmetry to use, and one
    /// complex pole is a whole resonance there.
    Rational {
        /// Degree above.
        above: usize,
        /// Degree below.
        below: usize,
    },
    /// L as a ratio of polynomials of 1/s, real coefficients: what integrators, rigid bodies, lags and delays are made of.
    /// Half the coefficients of the others, so it knows more where it fits.
    Physical {
        /// Degree above.
        above: usize,
        /// Degree below.
        below: usize,
    },
    /// A polynomial behind a delay that is fitted with it: a controller, a rigid body and the way out and back are e^(−sτ) times
    /// a polynomial of 1/s of two degrees.
    Delayed {
        /// Degree above.
        above: usize,
        /// Degree below.
        below: usize,
    },
}

impl Shape {
    /// Complex coefficients; a real one is half of one.
    pub(super) fn coefficients(self) -> f64 {
        match self {
            Self::LogPolynomial { terms } => terms as f64,
            Self::Rational { above, below } => (above + below + 1) as f64,
            Self::Physical { above, below } => 0.5 * (above + below + 1) as f64,
            Self::Delayed { above, below } => 0.5 * (above + below + 2) as f64,
        }
    }

    fn degrees(self) -> [usize; 2] {
        match self {
            Self::LogPolynomial { terms } => [terms - 1, 0],
            Self::Rational { above, below }
            | Self::Physical { above, below }
            | Self::Delayed { above, below } => [above, below],
        }
    }

    /// Whether its coefficients are real, so that each line counts with its mirror at −f.
    pub(super) fn is_real(self) -> bool {
        matches!(self, Self::Physical { .. } | Self::Delayed { .. })
    }
}

/// Variances and covariance of the errors of ln|L| and of the phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    /// Variance of ln|L|.
    pub(super) gain: f64,
    /// Variance of the phase, rad².
    pub(super) phase: f64,
    /// Covariance of the two; 0 for complex coefficients, whose errors are circular.
    pub(super) both: f64,
}

/// A fitted curve.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    shape: Shape,
    centre_hz: f64,
    width: f64,
    coefficients: Vec<C64>,
    root: Vec<Vec<C64>>,
    /// Σ|residual|²/variance.
    pub(super) chi2: f64,
    /// Factor on the variance that linear theory gives.
    pub(super) scale: f64,
}

/// What is fitted: abscissa, value, standard deviation.
struct Rows {
    x: Vec<C64>,
    value: Vec<C64>,
    sd: Vec<f64>,
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
        let empty = Vec::new;
        let mut curve = Self {
            shape,
            centre_hz,
            width: 1.0,
            coefficients: empty(),
            root: Vec::new(),
            chi2: 0.0,
            scale: 1.0,
        };
        let size = |l: &Line| curve.abscissa(l.frequency_hz).norm();
        curve.width = lines.iter().map(size).fold(0.0, f64::max);
        let mut rows = Rows {
            x: lines.iter().map(|l| curve.abscissa(l.frequency_hz)).collect(),
            value: lines.iter().map(|l| l.value).collect(),
            sd: sd.to_vec(),
        };
        match shape {
            Shape::LogPolynomial { .. } => curve.fit_logarithm(&rows, phase)?,
            Shape::Rational { .. } => curve.fit_ratio(&rows)?,
            Shape::Physical { .. } | Shape::Delayed { .. } => {
                // With each line's mirror at −f the complex fit is the real one, and (JᴴJ)⁻¹ the covariance of its
                // coefficients.
                rows.x.extend_from_within(..);
                rows.value.extend_from_within(..);
                rows.sd.extend_from_within(..);
                let mirrored = rows.x.iter_mut().zip(&mut rows.value).skip(lines.len());
                mirrored.for_each(|(x, v)| (*x, *v) = (x.conj(), v.conj()));
                match shape {
                    Shape::Delayed { .. } => curve.fit_delayed(&rows, phase)?,
                    _ => curve.fit_ratio(&rows)?,
                }
                curve.chi2 *= 0.5;
            }
        }
        (curve.chi2.is_finite() && curve.coefficients.iter().all(|c| c.norm().is_finite())).then_some(curve)
    }

    fn fit_logarithm(&mut self, rows: &Rows, phase: &[f64]) -> Option<()> {
        let [degree, _] = self.shape.degrees();
        let weight: Vec<f64> = rows.value.iter().zip(&rows.sd).map(|(v, s)| v.norm() / s).collect();
        let columns: Vec<Vec<C64>> = (0..=degree)
            .map(|k| rows.x.iter().zip(&weight).map(|(x, w)| x.powu(k as u32) * *w).collect())
            .collect();
        let logarithm = |(v, p): (&C64, &f64)| C64::new(v.norm().ln(), *p);
        let rhs: Vec<C64> =
            rows.value.iter().zip(phase).map(logarithm).zip(&weight).map(|(l, w)| l * *w).collect();
        let solved = least_squares(columns.clone(), rhs.clone())?;
        let modelled =
            |i: usize| -> C64 { (0..=degree).map(|k| columns[k][i] * solved.coefficients[k]).sum() };
        self.chi2 = rhs.iter().enumerate().map(|(i, y)| (y - modelled(i)).norm_sqr()).sum();
        (self.coefficients, self.root) = (solved.coefficients, solved.root);
        Some(())
    }

    /// The delay begins at a share of the slope of the phase (the rest of which is lags), whichever fits best.
    fn fit_delayed(&mut self, rows: &Rows, phase: &[f64]) -> Option<()> {
        // 1/x is the frequency, and all of it lies on the imaginary axis.
        let abscissa = |k: usize| rows.x[k].inv().im;
        let first = phase.len() / 2;
        let last = phase.len() - 1;
        let slope = ((phase[first] - phase[last]) / (abscissa(last) - abscissa(first))).max(0.0);
        let starts = DELAY_STARTS.iter().filter_map(|share| {
            let delay = share * slope;
            let value = rows.value.iter().zip(&rows.x).map(|(v, x)| v * (delay / x).exp()).collect();
            let mut trial = self.clone();
            trial.reweighted(&Rows { x: rows.x.clone(), value, sd: rows.sd.clone() })?;
            trial.coefficients.push(C64::from(delay));
            Some((trial.cost(rows), trial.coefficients))
        });
        (_, self.coefficients) = starts.min_by(|a, b| a.0.total_cmp(&b.0))?;
        self.refined(rows)
    }

    fn fit_ratio(&mut self, rows: &Rows) -> Option<()> {
        self.reweighted(rows)?;
        self.refined(rows)
    }

    /// Iterated linear fits, no delay.
    fn reweighted(&mut self, rows: &Rows) -> Option<()> {
        let mut denominator = vec![C64::from(1.0); rows.x.len()];
        for _ in 0..REWEIGHTINGS {
            let columns = self.columns(rows, &rows.value, &denominator);
            let rhs = (0..rows.x.len()).map(|i| rows.value[i] / (denominator[i] * rows.sd[i])).collect();
            self.coefficients = least_squares(columns, rhs)?.coefficients;
            denominator = rows.x.iter().map(|x| self.denominator(*x)).collect();
        }
        Some(())
    }

    /// Maximum likelihood from there.
    fn refined(&mut self, rows: &Rows) -> Option<()> {
        let mut cost = self.cost(rows);
        let steps = if self.delay().is_some() { DELAYED_REFINEMENTS } else { REFINEMENTS };
        for _ in 0..steps {
            let step = self.linearised(rows)?.coefficients;
            let Some((better, less)) = self.along(&step, cost, rows) else { break };
            let done = cost - less <= 1e-9 * cost;
            (self.coefficients, cost) = (better, less);
            if done {
                break;
            }
        }
        self.chi2 = cost;
        self.root = self.linearised(rows)?.root;
        Some(())
    }

    /// Linear problem of a Gauss–Newton step: the model is holomorphic, so the step is complex.
    fn linearised(&self, rows: &Rows) -> Option<Solution> {
        let value: Vec<C64> = rows.x.iter().map(|x| self.at(*x)).collect();
        let denominator: Vec<C64> = rows.x.iter().map(|x| self.denominator(*x)).collect();
        let rhs = (0..rows.x.len()).map(|i| (rows.value[i] - value[i]) / rows.sd[i]).collect();
        let mut columns = self.columns(rows, &value, &denominator);
        if let Some(delay) = self.delay() {
            // What the columns say of the ratio is late by the delay; and the delay itself, −L/x.
            let late = |column: &mut Vec<C64>| {
                column.iter_mut().zip(&rows.x).for_each(|(c, x)| *c *= (-delay / x).exp());
            };
            let [above, _] = self.shape.degrees();
            columns.iter_mut().take(above + 1).for_each(late);
            let own = (0..rows.x.len()).map(|i| -value[i] / (rows.x[i] * rows.sd[i]));
            columns.push(own.collect());
        }
        least_squares(columns, rhs)
    }

    /// Columns of the linearised ratio: xᵏ/D above, −G·xᵏ/D below, over sd.
    fn columns(&self, rows: &Rows, value: &[C64], denominator: &[C64]) -> Vec<Vec<C64>> {
        let [above, below] = self.shape.degrees();
        let next = |column: &[C64]| column.iter().zip(&rows.x).map(|(c, x)| c * x).collect::<Vec<C64>>();
        let first: Vec<C64> = denominator.iter().zip(&rows.sd).map(|(d, s)| 1.0 / (d * *s)).collect();
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

    /// The longest of four steps that does not cost more.
    fn along(&self, step: &[C64], cost: f64, rows: &Rows) -> Option<(Vec<C64>, f64)> {
        [1.0, 0.5, 0.25, 0.1].iter().find_map(|part| {
            let mut trial = self.clone();
            trial.coefficients.iter_mut().zip(step).for_each(|(c, s)| *c += s * *part);
            let less = trial.cost(rows);
            (less <= cost).then_some((trial.coefficients, less))
        })
    }

    fn cost(&self, rows: &Rows) -> f64 {
        let error = |i: usize| ((rows.value[i] - self.at(rows.x[i])) / rows.sd[i]).norm_sqr();
        (0..rows.x.len()).map(error).sum()
    }

    /// Delay, scaled as 1/x is; the last coefficient where there is one.
    fn delay(&self) -> Option<f64> {
        let [above, below] = self.shape.degrees();
        let is = matches!(self.shape, Shape::Delayed { .. });
        self.coefficients.get(above + below + 1).filter(|_| is).map(|c| c.re)
    }

    fn denominator(&self, x: C64) -> C64 {
        let [above, below] = self.shape.degrees();
        1.0 + self.coefficients[above + 1..=above + below]
            .iter()
            .rev()
            .fold(C64::default(), |sum, c| (sum + c) * x)
    }

    /// Value at a scaled abscissa.
    fn at(&self, x: C64) -> C64 {
        let [above, _] = self.shape.degrees();
        let over = self.coefficients[..=above].iter().rev().fold(C64::default(), |sum, c| sum * x + c);
        match self.shape {
            Shape::LogPolynomial { .. } => over.exp(),
            Shape::Rational { .. } | Shape::Physical { .. } => over / self.denominator(x),
            Shape::Delayed { .. } => over / self.denominator(x) * (-self.delay().unwrap_or(0.0) / x).exp(),
        }
    }

    /// Derivatives of ln L by the coefficients at a scaled abscissa.
    fn gradient(&self, x: C64) -> Vec<C64> {
        let [above, below] = self.shape.degrees();
        if matches!(self.shape, Shape::LogPolynomial { .. }) {
            return (0..=above).map(|k| x.powu(k as u32)).collect();
        }
        let under = self.denominator(x);
        let over = self.coefficients[..=above].iter().rev().fold(C64::default(), |sum, c| sum * x + c);
        let up = (0..=above).map(|k| x.powu(k as u32) / over);
        let down = (1..=below).map(|k| -x.powu(k as u32) / under);
        up.chain(down).chain(self.delay().map(|_| -x.inv())).collect()
    }

    /// L at a frequency.
    pub(super) fn value(&self, frequency_hz: f64) -> C64 {
        self.at(self.abscissa(frequency_hz))
    }

    /// What the polynomials are of, near 1 in size or below.
    fn abscissa(&self, frequency_hz: f64) -> C64 {
        match self.shape {
            Shape::LogPolynomial { .. } => C64::from((frequency_hz / self.centre_hz).ln() / self.width),
            Shape::Rational { .. } => C64::from((frequency_hz - self.centre_hz) / self.width),
            Shape::Physical { .. } | Shape::Delayed { .. } => {
                C64::new(0.0, -self.centre_hz / (frequency_hz * self.width))
            }
        }
    }

    /// Errors of ln|L| and phase at a frequency.
    pub(super) fn errors(&self, frequency_hz: f64) -> Errors {
        let gradient = self.gradient(self.abscissa(frequency_hz));
        let along = |part: fn(&C64) -> C64| -> Vec<C64> {
            let product = |column: &Vec<C64>| column.iter().zip(&gradient).map(|(r, g)| r * part(g)).sum();
            self.root.iter().map(product).collect()
        };
        let power = |v: &[C64]| self.scale * v.iter().map(|c| c.norm_sqr()).sum::<f64>();
        if !self.shape.is_real() {
            let each = 0.5 * power(&along(|g| *g));
            return Errors { gain: each, phase: each, both: 0.0 };
        }
        let gain = along(|g| C64::from(g.re));
        let phase = along(|g| C64::from(g.im));
        let both = self.scale * gain.iter().zip(&phase).map(|(a, b)| (a * b.conj()).re).sum::<f64>();
        Errors { gain: power(&gain), phase: power(&phase), both }
    }

    /// dln L/dln f: the real part is the slope of ln|L|, the imaginary that of the phase.
    pub(super) fn slope(&self, frequency_hz: f64) -> C64 {
        let step = 1e-5;
        let [high, low] = [1.0 + step, 1.0 - step].map(|q| self.value(q * frequency_hz));
        (high / low).ln() / ((1.0 + step) / (1.0 - step)).ln()
    }
}
