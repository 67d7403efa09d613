//! The rational function as a sum of sections: what is nonlinear in it, what is linear, and the slopes of both.

use super::super::frf::C64;

/// Number of sections and terms of a rational function
/// `e^(−sτ)·(Σ (c·s + d)/(s² + a·s + b) + Σ c/(s + q) + Σ t·s^k)`, s in units of a scale of frequency.
///
/// Sections of second order hold a complex pair or two real poles alike, so that a fit may pass from one to the
/// other; residues are linear, which leaves a, b, q and τ to be searched.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    /// Sections of second order.
    pub(crate) pairs: usize,
    /// Sections of first order.
    pub(crate) singles: usize,
    /// Powers k of s beside the poles.
    pub(crate) terms: Vec<i32>,
    /// Whether the delay is fitted.
    pub(crate) delay: bool,
}

impl Shape {
    /// Nonlinear parameters: a, b of each pair, then q of each single, then τ.
    pub(crate) fn nonlinear_count(&self) -> usize {
        2 * self.pairs + self.singles + usize::from(self.delay)
    }

    /// Linear parameters of one response: c, d of each pair, then c of each single, then the terms.
    pub(crate) fn linear_count(&self) -> usize {
        2 * self.pairs + self.singles + self.terms.len()
    }

    fn turn(&self, theta: &[f64], s: C64) -> C64 {
        if self.delay { (-s * theta[self.nonlinear_count() - 1]).exp() } else { C64::new(1.0, 0.0) }
    }

    /// What each linear parameter contributes at `s`.
    pub(crate) fn columns(&self, theta: &[f64], s: C64, out: &mut [C64]) {
        let turn = self.turn(theta, s);
        let (sections, rest) = theta.split_at(2 * self.pairs);
        for (k, ab) in sections.chunks_exact(2).enumerate() {
            let inverse = turn / (s * (s + ab[0]) + ab[1]);
            out[2 * k] = s * inverse;
            out[2 * k + 1] = inverse;
        }
        let after = 2 * self.pairs + self.singles;
        for (slot, q) in out[2 * self.pairs..after].iter_mut().zip(rest) {
            *slot = turn / (s + q);
        }
        for (slot, power) in out[after..].iter_mut().zip(&self.terms) {
            *slot = turn * s.powi(*power);
        }
    }

    /// Slope of the response at `s` over each nonlinear parameter, for linear parameters `c`.
    pub(crate) fn slopes(&self, theta: &[f64], c: &[f64], s: C64, out: &mut [C64]) {
        let turn = self.turn(theta, s);
        let (sections, rest) = theta.split_at(2 * self.pairs);
        for (k, ab) in sections.chunks_exact(2).enumerate() {
            let inverse = (s * (s + ab[0]) + ab[1]).inv();
            let slope = -turn * (s * c[2 * k] + c[2 * k + 1]) * inverse * inverse;
            out[2 * k] = slope * s;
            out[2 * k + 1] = slope;
        }
        for (k, q) in rest[..self.singles].iter().enumerate() {
            let inverse = (s + q).inv();
            out[2 * self.pairs + k] = -turn * c[2 * self.pairs + k] * inverse * inverse;
        }
        if self.delay {
            let last = self.nonlinear_count() - 1;
            out[last] = -s * self.at(theta, c, s);
        }
    }

    /// The response at `s`.
    pub(crate) fn at(&self, theta: &[f64], c: &[f64], s: C64) -> C64 {
        let mut columns = vec![C64::default(); self.linear_count()];
        self.columns(theta, s, &mut columns);
        columns.iter().zip(c).map(|(column, c)| column * *c).sum()
    }

    /// Physical unit of each nonlinear parameter in terms of the scale of frequency.
    pub(crate) fn nonlinear_units(&self, scale: f64) -> Vec<f64> {
        let pairs = (0..self.pairs).flat_map(|_| [scale, scale * scale]);
        let singles = std::iter::repeat_n(scale, self.singles);
        pairs.chain(singles).chain(self.delay.then(|| scale.recip())).collect()
    }

    /// Unit of each linear parameter.
    pub(crate) fn linear_units(&self, scale: f64) -> Vec<f64> {
        let pairs = (0..self.pairs).flat_map(|_| [scale, scale * scale]);
        let singles = std::iter::repeat_n(scale, self.singles);
        pairs.chain(singles).chain(self.terms.iter().map(|k| scale.powi(-k))).collect()
    }
}
