//! How many units a comparison needs: the probability of the right call, from the scatter of a pilot.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use statrs::function::gamma::ln_gamma;

use super::{smallest_count, t_quantile};

/// The call that a plan is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlannedCall {
    /// The interval lies above zero and not inside the margins.
    Worse,
    /// The interval lies inside the margins.
    Equivalent,
}

/// What is supposed of a comparison. Effect, margin and scatter have one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The call that is right.
    pub call: PlannedCall,
    /// True mean of the differences, + is worse.
    pub effect: f64,
    /// Margin of equivalence, ≥ 0.
    pub margin: f64,
    /// Standard deviation of a single difference, ≥ 0; see [`scatter_at_most`].
    pub scatter: f64,
    /// Two-sided level of the interval. For a criterion that must stand in a family of m by Holm, 1 − 0.1/m is on the safe side
    /// of a one-sided 0.05.
    pub level: f64,
}

/// Pieces of each smooth stretch of the integral.
const PIECES: u32 = 2000;
/// How far the integral goes to both sides of the mean, in standard deviations of the estimated scatter.
const REACH: f64 = 10.0;

impl Plan {
    /// Probability of the call with this many pairs, for normal differences; 0 for fewer than two.
    ///
    /// Integral over the estimated scatter, whose square follows χ²; for `Worse` and a margin of 0 it is the upper tail of the
    /// noncentral t distribution. For a margin, it is the power of two one-sided tests (Phillips, *J. Pharmacokin. Biopharm.* 18,
    /// 137, 1990).
    pub fn probability(&self, pairs: u64) -> f64 {
        if pairs < 2 {
            return 0.0;
        }
        if self.scatter <= 0.0 {
            return f64::from(u8::from(self.is_right()));
        }
        let dof = (pairs - 1) as f64;
        let u = self.scatter / (pairs as f64).sqrt();
        let t = t_quantile(self.level, dof);
        let Self { effect, margin, .. } = *self;
        let normal = Normal::standard();
        // `ratio` is the estimated scatter over the true one. Beyond the kink no interval lies inside the margins.
        let kink = margin / (t * u);
        let spread = 1.0 / (2.0 * dof).sqrt();
        let range = [(1.0 - REACH * spread).max(0.0), 1.0 + REACH * spread];
        let density = |ratio: f64| density_of_ratio(ratio, dof);
        match self.call {
            PlannedCall::Equivalent => {
                let inside = |ratio: f64| {
                    let room = margin - t * ratio * u;
                    let [low, high] = [(-room - effect) / u, (room - effect) / u];
                    (normal.cdf(high) - normal.cdf(low)).max(0.0) * density(ratio)
                };
                integral([range[0], kink.clamp(range[0], range[1])], inside)
            }
            PlannedCall::Worse => {
                let above = |ratio: f64| {
                    let half = t * ratio * u;
                    normal.sf((half.max(margin - half) - effect) / u) * density(ratio)
                };
                let kink = (0.5 * kink).clamp(range[0], range[1]);
                integral([range[0], kink], above) + integral([kink, range[1]], above)
            }
        }
    }

    /// The smallest number of pairs with which the call has this probability; `None` where a thousand million do not suffice, as
    /// for an effect on the wrong side of the margin.
    pub fn pairs(&self, power: f64) -> Option<u64> {
        if !self.is_right() {
            return None;
        }
        smallest_count(|pairs| self.probability(pairs) >= power)
    }

    /// Whether the effect is on the side of the margin where the call belongs.
    fn is_right(&self) -> bool {
        match self.call {
            PlannedCall::Worse => self.effect > self.margin,
            PlannedCall::Equivalent => self.effect.abs() < self.margin,
        }
    }
}

/// Upper confidence limit of the true scatter, by a pilot's standard deviation with `dof` degrees of freedom (χ²).
///
/// With probability `confidence` it lies above the true scatter. A plan that takes the pilot's standard deviation itself is too
/// small in half of all cases. `None` for a pilot without a degree of freedom or a confidence that is not between 0 and 1.
pub fn scatter_at_most(scatter: f64, dof: f64, confidence: f64) -> Option<f64> {
    if !(confidence > 0.0 && confidence < 1.0) {
        return None;
    }
    let chi2 = ChiSquared::new(dof).ok()?;
    let largest = scatter * (dof / chi2.inverse_cdf(1.0 - confidence)).sqrt();
    largest.is_finite().then_some(largest)
}

/// Density of √(χ²/ν).
fn density_of_ratio(ratio: f64, dof: f64) -> f64 {
    let half = 0.5 * dof;
    let power = if dof == 1.0 { 0.0 } else { (dof - 1.0) * ratio.ln() };
    (2.0_f64.ln() + half * half.ln() - ln_gamma(half) + power - half * ratio * ratio).exp()
}

/// Simpson's rule.
fn integral([from, to]: [f64; 2], function: impl Fn(f64) -> f64) -> f64 {
    let step = (to - from) / f64::from(2 * PIECES);
    if step <= 0.0 {
        return 0.0;
    }
    let inner = |k: u32| {
        let weight = if k % 2 == 1 { 4.0 } else { 2.0 };
        weight * function(from + step * f64::from(k))
    };
    let sum = function(from) + (1..2 * PIECES).map(inner).sum::<f64>() + function(to);
    sum * step / 3.0
}
