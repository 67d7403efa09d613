//! Equivalent degrees of freedom of a variance.

use super::{Noise, Statistic};

/// Longest sum that is done term by term; beyond it the grid of lags is coarser.
const MOST_LAGS: usize = 4096;
/// Most lags of flicker phase noise, whose correlation has peaks as narrow as a sample.
const MOST_LAGS_OF_PEAKS: usize = 1 << 16;

/// Equivalent degrees of freedom of a statistic at averaging factor `m` of `rates` rates, so that dof·σ̂²/σ² is about
/// χ² with them; `None` where none is published (Pdev; noises that the statistic does not converge for) or no term left.
///
/// Differences (`Adev` to `Ohdev`): Greenhall & Riley, *Proc. 35th PTTI*, 2003 (NIST SP 1065, 5.4.2), with their sums
/// done on a coarser grid of lags where they take tables. Total ones and Thêo1: NIST SP 1065, 5.4.3–5.4.5.
pub fn freedom(statistic: Statistic, noise: Noise, m: usize, rates: usize) -> Option<f64> {
    use Statistic as S;
    if m == 0 || m > statistic.largest_factor(rates) {
        return None;
    }
    let found = match statistic {
        S::Adev => differences(2, false, false, noise, m, rates),
        S::Oadev => differences(2, false, true, noise, m, rates),
        S::Mdev | S::Tdev => differences(2, true, true, noise, m, rates),
        S::Hdev => differences(3, false, false, noise, m, rates),
        S::Ohdev => differences(3, false, true, noise, m, rates),
        S::Totdev | S::Mtotdev | S::Ttotdev => of_total(statistic, noise, m, rates),
        S::Htotdev if m == 1 => differences(3, false, true, noise, m, rates),
        S::Htotdev => of_hadamard_total(noise, m, rates),
        S::Theo1 => of_theo1(noise, m, rates),
        S::Pdev => None,
    };
    found.filter(|dof| dof.is_finite() && *dof > 0.0)
}

/// `order` 2 (Allan) or 3 (Hadamard); modified: averaged phases; overlap: starts one sample apart.
fn differences(
    order: usize,
    modified: bool,
    overlap: bool,
    noise: Noise,
    m: usize,
    rates: usize,
) -> Option<f64> {
    let alpha = noise.exponent();
    if alpha + 2 * (order as i32) <= 1 {
        return None;
    }
    let points = rates + 1;
    let span = if modified { m + m * order } else { 1 + m * order };
    let stride = if overlap { m } else { 1 };
    let terms = 1 + stride * points.checked_sub(span)? / m;
    let filter = if modified { 1.0 } else { m as f64 };
    if noise == Noise::WhitePhase && !modified {
        return Some(white_phase(order, stride, terms));
    }
    let lags = terms.min((order + 1) * stride);
    let core = Core { alpha, order, filter };
    let most = if noise == Noise::FlickerPhase { MOST_LAGS_OF_PEAKS } else { MOST_LAGS };
    if lags <= most {
        return Some(core.freedom(lags, terms as f64, stride as f64));
    }
    // The same ratio of terms to stride on a coarser grid; the filter's own width no longer matters.
    let ratio = terms as f64 / stride as f64;
    let stride = most as f64 / ratio.min((order + 1) as f64);
    let filter = if modified { 1.0 } else { stride.round() };
    Some(Core { filter, ..core }.freedom(most, ratio * stride, stride))
}

/// White phase is correlated only where phases coincide, at whole multiples of the averaging time.
fn white_phase(order: usize, stride: usize, terms: usize) -> f64 {
    let binomial = |k: usize| (0..k).fold(1.0, |b, i| b * (2 * order - i) as f64 / (i + 1) as f64);
    let correlation = |k: usize| binomial(order - k) / binomial(order);
    let m = terms as f64;
    let more = (1..=order).filter(|k| k * stride < terms);
    let sum: f64 = more.map(|k| 2.0 * (1.0 - (k * stride) as f64 / m) * correlation(k).powi(2)).sum();
    m / (1.0 + sum)
}

/// Generalised autocovariance of the differences.
#[derive(Clone, Copy)]
struct Core {
    alpha: i32,
    order: usize,
    /// Samples of a mean: m, 1 for the modified.
    filter: f64,
}

impl Core {
    /// s_w: of the phase.
    fn phase(alpha: i32, t: f64) -> f64 {
        let t = t.abs();
        let log = |t: f64| if t > 0.0 { t.ln() } else { 0.0 };
        match alpha {
            2 => -t,
            1 => t * t * log(t),
            0 => t.powi(3),
            -1 => -t.powi(4) * log(t),
            -2 => -t.powi(5),
            -3 => t.powi(6) * log(t),
            _ => t.powi(7),
        }
    }

    /// s_x: of the averaged phase.
    fn averaged(&self, t: f64) -> f64 {
        let f = self.filter;
        f * f
            * (2.0 * Self::phase(self.alpha, t)
                - Self::phase(self.alpha, t - 1.0 / f)
                - Self::phase(self.alpha, t + 1.0 / f))
    }

    /// s_z: of its differences.
    fn difference(&self, t: f64) -> f64 {
        let around = |k: f64| self.averaged(t - k) + self.averaged(t + k);
        if self.order == 2 {
            6.0 * self.averaged(t) - 4.0 * around(1.0) + around(2.0)
        } else {
            20.0 * self.averaged(t) - 15.0 * around(1.0) + 6.0 * around(2.0) - around(3.0)
        }
    }

    /// BasicSum: M over the sum of squared correlations, each lag with the share of terms that have it.
    fn freedom(&self, lags: usize, terms: f64, stride: f64) -> f64 {
        let zero = self.difference(0.0);
        let square = |j: usize| (self.difference(j as f64 / stride) / zero).powi(2);
        let inner: f64 = (1..lags).map(|j| (1.0 - j as f64 / terms) * square(j)).sum();
        let end = (1.0 - lags as f64 / terms).max(0.0) * square(lags);
        terms / (1.0 + end + 2.0 * inner)
    }
}

fn of_total(statistic: Statistic, noise: Noise, m: usize, rates: usize) -> Option<f64> {
    let ratio = rates as f64 / m as f64;
    let (b, c) = match (statistic, noise) {
        (Statistic::Totdev, Noise::WhiteRate) => (1.50, 0.0),
        (Statistic::Totdev, Noise::FlickerRate) => (1.17, 0.22),
        (Statistic::Totdev, Noise::WalkRate) => (0.93, 0.36),
        (Statistic::Totdev, _) => return None,
        (_, Noise::WhitePhase) => (1.90, 2.10),
        (_, Noise::FlickerPhase) => (1.20, 1.40),
        (_, Noise::WhiteRate) => (1.10, 1.20),
        (_, Noise::FlickerRate) => (0.85, 0.50),
        (_, Noise::WalkRate) => (0.75, 0.31),
        _ => return None,
    };
    Some(b * ratio - c)
}

fn of_hadamard_total(noise: Noise, m: usize, rates: usize) -> Option<f64> {
    let ratio = rates as f64 / m as f64;
    let (b0, b1) = match noise {
        Noise::WhiteRate => (0.559, 1.004),
        Noise::FlickerRate => (0.868, 1.140),
        Noise::WalkRate => (0.938, 1.696),
        Noise::FlickerWalk => (0.974, 2.554),
        Noise::RunRate => (1.276, 3.149),
        _ => return None,
    };
    Some(ratio / (b0 + b1 / ratio))
}

fn of_theo1(noise: Noise, m: usize, rates: usize) -> Option<f64> {
    let n = (rates + 1) as f64;
    let tau = 0.75 * m as f64;
    Some(match noise {
        Noise::WhitePhase => 0.86 * (n + 1.0) * (n - 4.0 / 3.0 * tau) / (n - tau) * (tau / (tau + 1.14)),
        Noise::FlickerPhase => {
            (4.798 * n * n - 6.374 * n * tau + 12.387 * tau) / ((tau + 36.6).sqrt() * (n - tau))
                * (tau / (tau + 0.3))
        }
        Noise::WhiteRate => {
            ((4.1 * n + 0.8) / tau - (3.1 * n + 6.5) / n) * (tau.powf(1.5) / (tau.powf(1.5) + 5.2))
        }
        Noise::FlickerRate => {
            (2.0 * n * n - 1.3 * n * tau - 3.5 * tau) / (n * tau) * (tau.powi(3) / (tau.powi(3) + 2.3))
        }
        Noise::WalkRate => {
            let a = 4.4 * n;
            (a - 2.0) / (2.9 * tau) * ((a - 1.0).powi(2) - 8.6 * tau * (a - 1.0) + 11.4 * tau * tau)
                / (a - 3.0).powi(2)
        }
        _ => return None,
    })
}
