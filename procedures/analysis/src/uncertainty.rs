//! Components of an uncertainty and how they add up.

/// A standard uncertainty with its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Standard uncertainty.
    pub u: f64,
    /// Degrees of freedom; infinite for type B.
    pub dof: f64,
}

impl Component {
    /// A type B component: known, not estimated.
    pub fn known(u: f64) -> Self {
        Self { u, dof: f64::INFINITY }
    }

    /// A type B component that is known by its bounds only, this far on either side.
    pub fn rectangular(half_width: f64) -> Self {
        Self::known(rectangular_u(half_width))
    }
}

/// Standard uncertainty of what lies anywhere within this half-width of its estimate, all places alike (GUM, JCGM 100:2008, 4.3.7).
pub fn rectangular_u(half_width: f64) -> f64 {
    half_width / 3_f64.sqrt()
}

/// Root sum of squares, degrees of freedom by Welch–Satterthwaite (GUM, JCGM 100:2008, G.4).
pub fn combine(components: &[Component]) -> Component {
    let variance: f64 = components.iter().map(|c| c.u * c.u).sum();
    let quotient: f64 = components.iter().map(|c| c.u.powi(4) / c.dof).sum();
    let dof = if quotient > 0.0 { variance * variance / quotient } else { f64::INFINITY };
    Component { u: variance.sqrt(), dof }
}

/// One mean, two views of its spread: `within` from the noise of each repeat, `between` from the scatter of the
/// repeats' means.
///
/// What the repeats scatter beyond their noise is a component of its own (with the degrees of freedom of the
/// repeats); where they scatter less, their noise alone counts.
pub fn within_and_between(within: Component, between: Component) -> Component {
    let excess = between.u * between.u - within.u * within.u;
    if excess <= 0.0 || between.dof <= 0.0 {
        return within;
    }
    combine(&[within, Component { u: excess.sqrt(), dof: between.dof }])
}

/// Mean of `values` with the standard uncertainty of that mean from their scatter; `None` for fewer than two.
pub fn mean_of_repeats(values: &[f64]) -> Option<(f64, Component)> {
    let n = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let spread: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    Some((mean, Component { u: (spread / (n - 1.0) / n).sqrt(), dof: n - 1.0 }))
}

/// Factor by which the variance of the mean of a sequence exceeds that of as many independent values, ≥ 1.
///
/// 1 + 2·Σρ over lags, summed in pairs that must fall and stay positive: the initial monotone sequence (Geyer,
/// *Statistical Science* 7, 473, 1992).
/// `residuals` are in order, free of mean and model.
pub fn correlation_factor(residuals: &[f64]) -> f64 {
    let n = residuals.len();
    let power: f64 = residuals.iter().map(|r| r * r).sum();
    if n < 4 || power <= 0.0 {
        return 1.0;
    }
    let rho = |lag: usize| -> f64 {
        residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum::<f64>() / power
    };
    let mut last = 1.0 + rho(1);
    let mut sum = last;
    for lag in (2..n / 2).step_by(2) {
        last = last.min(rho(lag) + rho(lag + 1));
        if last <= 0.0 {
            break;
        }
        sum += last;
    }
    (2.0 * sum - 1.0).max(1.0)
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    use super::*;

    #[test]
    fn welch_satterthwaite_of_equal_components_adds_their_freedom() {
        let one = Component { u: 3.0, dof: 5.0 };
        let both = combine(&[one, one]);
        assert!((both.u - 18.0_f64.sqrt()).abs() < 1e-12 && (both.dof - 10.0).abs() < 1e-12);
        let with_known = combine(&[one, Component::known(4.0)]);
        assert!((with_known.u - 5.0).abs() < 1e-12 && (with_known.dof - 5.0 * 625.0 / 81.0).abs() < 1e-9);
        assert!(combine(&[Component::known(1.0)]).dof.is_infinite());
    }

    #[test]
    fn repeats_that_scatter_more_than_their_noise_cost_freedom() {
        let within = Component { u: 1.0, dof: 100.0 };
        assert_eq!(within_and_between(within, Component { u: 0.5, dof: 2.0 }), within);
        let wide = within_and_between(within, Component { u: 10.0, dof: 2.0 });
        assert!((wide.u - 10.0).abs() < 1e-9 && wide.dof < 2.1);
    }

    #[test]
    fn a_first_order_process_has_the_textbook_factor() {
        let factors = (0..20).map(|seed| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
            let mut x = 0.0;
            let series: Vec<f64> = (0..2000)
                .map(|_| {
                    x = 0.6 * x + uniform() + uniform();
                    x
                })
                .collect();
            correlation_factor(&series)
        });
        let factor = factors.sum::<f64>() / 20.0;
        assert!((factor - 4.0).abs() < 0.4, "(1 + 0.6)/(1 − 0.6) = 4, found {factor}");
    }
}
