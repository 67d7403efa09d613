//! Pure delay beside dynamics: one fit for both.

use std::f64::consts::TAU;

use super::input::{InputError, check_lines, line_sd};
use super::{DelayError, Includes};
use crate::frf::{C64, Line};
use crate::goodness::Goodness;
use crate::nonlinear::NonlinearFit;

/// Starts tried with the full fit.
const STARTS: usize = 4;

/// Dynamics beside the delay: a real gain, times a first-order lag 1/(1 + sT), times ω₀²/(s² + 2ζω₀s + ω₀²).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dynamics {
    /// With the lag.
    pub lag: bool,
    /// With the second order.
    pub second_order: bool,
}

/// Delay and dynamics of a response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointDelay {
    /// Pure delay, s.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`, s.
    pub u_s: f64,
    /// Static gain, signed, in the units of the response.
    pub gain: f64,
    /// Time constant and its standard uncertainty, s.
    pub lag_s: Option<[f64; 2]>,
    /// Natural frequency and its standard uncertainty, Hz.
    pub natural_hz: Option<[f64; 2]>,
    /// Damping ratio and its standard uncertainty.
    pub damping: Option<[f64; 2]>,
    /// Correlation of the delay with the lag.
    pub lag_correlation: Option<f64>,
    /// Largest correlation of the delay with a parameter of the dynamics, by size.
    pub correlation: f64,
    /// How well these dynamics describe the lines.
    pub goodness: Goodness,
    /// What the delay holds.
    pub includes: Includes,
}

/// Parameters in the order of the fit: gain, delay in units of the scale, then ln T, ln ω₀ and ln ζ where they are fitted:
/// positive by construction.
struct Model<'a> {
    lines: &'a [Line],
    dynamics: Dynamics,
}

impl Model<'_> {
    /// Dynamics and delay without gain.
    fn shape(&self, s: C64, p: &[f64]) -> C64 {
        let mut rest = p[2..].iter();
        let mut value = (-s * p[1]).exp();
        if self.dynamics.lag {
            value /= 1.0 + s * rest.next().map_or(0.0, |t| t.exp());
        }
        if let (true, Some(omega), Some(zeta)) = (self.dynamics.second_order, rest.next(), rest.next()) {
            let q = s / omega.exp();
            value /= q * q + 2.0 * zeta.exp() * q + 1.0;
        }
        value
    }

    fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let weighed = |line: &Line| {
            let model = p[0] * self.shape(C64::new(0.0, TAU * line.frequency_hz), p);
            let error = (line.value - model) / line_sd(line);
            [error.re, error.im]
        };
        self.lines.iter().flat_map(weighed).collect()
    }

    /// The best real gain for the rest, and what remains.
    fn with_gain(&self, rest: &[f64]) -> (f64, Vec<f64>) {
        let mut p = [&[1.0], rest].concat();
        let mut above = 0.0;
        let mut below = 0.0;
        for line in self.lines {
            let w = line_sd(line).powi(-2);
            let shape = self.shape(C64::new(0.0, TAU * line.frequency_hz), &p);
            above += w * (shape.conj() * line.value).re;
            below += w * shape.norm_sqr();
        }
        p[0] = above / below;
        (self.residuals(&p).iter().map(|r| r * r).sum(), p)
    }

    /// A grid over delay and dynamics, the best first.
    fn starts(&self, most_delay_s: f64) -> Vec<Vec<f64>> {
        let [low, high] = [self.lines[0], self.lines[self.lines.len() - 1]].map(|l| TAU * l.frequency_hz);
        // A step of a quarter turn at the highest line finds every valley.
        let count = (most_delay_s * high / TAU * 4.0).ceil().clamp(4.0, 400.0) as usize;
        let delays = (0..=count).map(|k| most_delay_s * k as f64 / count as f64);
        let lags: Vec<Vec<f64>> = if self.dynamics.lag {
            [0.15, 0.5, 1.5, 5.0].map(|x: f64| vec![(x / high).ln()]).to_vec()
        } else {
            vec![Vec::new()]
        };
        let modes: Vec<Vec<f64>> = if self.dynamics.second_order {
            let omega = (0..12).map(|k| low.ln() + (1.5 * high / low).ln() * f64::from(k) / 11.0);
            omega.flat_map(|w| [0.03_f64, 0.3, 1.0].map(|z| vec![w, z.ln()])).collect()
        } else {
            vec![Vec::new()]
        };
        let mut all: Vec<(f64, Vec<f64>)> = delays
            .flat_map(|d| lags.iter().map(move |l| [&[d], l.as_slice()].concat()))
            .flat_map(|dl| modes.iter().map(move |m| [dl.as_slice(), m].concat()))
            .map(|rest| self.with_gain(&rest))
            .filter(|(cost, _)| cost.is_finite())
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().take(STARTS).map(|(_, p)| p).collect()
    }

    fn best(&self, most_delay_s: f64) -> Option<NonlinearFit> {
        let unit_s = 1.0 / (TAU * self.lines[self.lines.len() - 1].frequency_hz);
        let fits = self.starts(most_delay_s).into_iter().filter_map(|start| {
            let mut scale = vec![1.0; start.len()];
            (scale[0], scale[1]) = (start[0].abs().max(f64::MIN_POSITIVE), unit_s);
            NonlinearFit::new(|p| self.residuals(p), &start, &scale)
        });
        fits.min_by(|a, b| a.residual_variance.total_cmp(&b.residual_variance))
    }
}

/// Fits gain, dynamics and delay together by maximum likelihood (weights from the variances), delays 0…`most_delay_s`.
///
/// # Errors
/// Lines that are none; no convergence; a correlation of the delay with the dynamics above
/// `most_correlation`; dynamics that do not describe the lines.
pub fn joint(
    lines: &[Line],
    dynamics: Dynamics,
    most_delay_s: f64,
    most_correlation: f64,
) -> Result<JointDelay, DelayError> {
    check_lines(lines, 5)?;
    let positive = |name, found: f64| {
        let fine = found.is_finite() && found > 0.0;
        fine.then_some(()).ok_or(InputError::Setting { name, found, expected: "a positive number" })
    };
    positive("most_delay_s", most_delay_s)?;
    positive("most_correlation", most_correlation)?;
    let fit = Model { lines, dynamics }.best(most_delay_s).ok_or(DelayError::NoFit)?;
    let goodness = Goodness::of_lines(lines, fit.residual_variance, fit.dof);
    goodness.check()?;
    let covariance = &fit.unscaled_covariance;
    let u = |k: usize| covariance[(k, k)].sqrt() * goodness.widening();
    let with_delay = |k: usize| covariance[(1, k)] / (covariance[(1, 1)] * covariance[(k, k)]).sqrt();
    let count = fit.parameters.len();
    let correlation =
        (2..count).map(with_delay).fold(0.0, |most: f64, c| if c.abs() > most.abs() { c } else { most });
    // A parameter that nothing holds runs away; its uncertainty tells.
    let loose = (2..count).any(|k| u(k).is_nan() || u(k) >= 1.0);
    if correlation.abs() > most_correlation || loose {
        return Err(DelayError::NotSeparable { correlation, most: most_correlation });
    }
    let positive =
        |k: usize, unit: f64| [fit.parameters[k].exp() * unit, fit.parameters[k].exp() * unit * u(k)];
    let mode = 2 + usize::from(dynamics.lag);
    Ok(JointDelay {
        delay_s: fit.parameters[1],
        u_s: u(1),
        gain: fit.parameters[0],
        lag_s: dynamics.lag.then(|| positive(2, 1.0)),
        natural_hz: dynamics.second_order.then(|| positive(mode, 1.0 / TAU)),
        damping: dynamics.second_order.then(|| positive(mode + 1, 1.0)),
        lag_correlation: dynamics.lag.then(|| with_delay(2)),
        correlation,
        goodness,
        includes: Includes::TransportAndHold,
    })
}
