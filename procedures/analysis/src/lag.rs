//! Identifies the current loop as a sampled system, from the held command to the sampled current.
//!
//! The fit separates three contributions to the phase: the lag of the loop, the transport delay and the zero-order hold.

use std::f64::consts::TAU;

use super::delay::{InputError, check_lines, line_sd};
use super::frf::pooled::with_pooled_variances;
use super::frf::{C64, Line};
use super::goodness::{Goodness, Hopeless};
use super::nonlinear::NonlinearFit;

mod known;
#[cfg(test)]
mod tests;

pub use known::{KnownLag, transport_at_known_corner};

/// Start values of the corner frequency on the coarse grid, Hz.
const CORNERS_HZ: [f64; 8] = [150.0, 300.0, 500.0, 750.0, 1000.0, 1400.0, 2000.0, 4000.0];
/// Number of best grid points from which the full fit starts.
const STARTS: usize = 4;
/// Profile-likelihood test: the fit must get worse where the corner is held at this factor above and below the best one.
/// Otherwise the corner is not determined.
const PROFILE_FACTOR: f64 = 1.25;
/// Increase of χ² that counts as worse: three standard deviations.
const PROFILE_CHI2: f64 = 9.0;
/// Fall of χ² from which a loop is of second order: four standard deviations of a parameter that is not there.
const ORDER_CHI2: f64 = 16.0;
/// Largest relative standard uncertainty of a corner that counts as determined.
const MOST_U_RATIO: f64 = 0.1;
/// For lines without variance: residual rms relative to |G| above which the model does not fit.
const MOST_EXACT_RATIO: f64 = 1e-4;

/// Order of the model of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// 1/(1 + s/(2πf_c)).
    First,
    /// ω₀²/(s² + 2ζω₀s + ω₀²), ζ fitted; f_c is still the −3 dB frequency.
    Second,
}

/// Sampling of the response, and which model to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Period of the hold and of the samples, s.
    pub period_s: f64,
    /// Order of the model.
    pub order: Order,
    /// Largest delay on the grid of start values, s.
    pub most_delay_s: f64,
}

/// Fitted model of a current loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagFit {
    /// −3 dB bandwidth of the loop itself, hold and delay removed, Hz.
    pub corner_hz: f64,
    /// Standard uncertainty of `corner_hz`, Hz.
    pub corner_u_hz: f64,
    /// Pure delay of transport and computing, s: from the tick in whose log row the command stands to the sample. It
    /// contains neither the lag nor the hold.
    pub transport_s: f64,
    /// Standard uncertainty of `transport_s`, s.
    pub transport_u_s: f64,
    /// DC gain, measured over commanded current.
    pub gain: f64,
    /// Standard uncertainty of `gain`.
    pub gain_u: f64,
    /// Correlation coefficient of corner and delay.
    pub correlation: f64,
    /// Group delay of the loop itself at 0 Hz, s: 1/(2πf_c) for first order, 2ζ/ω₀ for second order.
    pub lag_s: f64,
    /// Delay of the hold at low frequency, half a period, s.
    pub hold_s: f64,
    /// Damping ratio and its standard uncertainty; `None` for first order.
    pub damping: Option<[f64; 2]>,
    /// How well the model describes the lines.
    pub goodness: Goodness,
    /// χ² by the uncertainties of the lines.
    pub chi2: f64,
    /// The model does not fit the lines, so its parameters do not describe this loop.
    pub misfit: bool,
}

impl LagFit {
    /// Whether its further parameter pays: χ² falls by more than [`ORDER_CHI2`] in units of its own scatter. Where it does
    /// not, a second pole is fitted to noise, and the delay is short by the lag of that pole.
    pub fn is_clearly_better_than(&self, simpler: &Self) -> bool {
        self.chi2 + ORDER_CHI2 * self.goodness.variance_factor() < simpler.chi2
    }
}

/// Why the fit gives no result.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LagError {
    /// Lines or settings that cannot be used.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The fit does not converge, even with the corner held.
    #[error("no fit: the response is not a lag behind a hold with a delay up to {most_delay_s} s")]
    NoFit {
        /// Largest delay looked for, s.
        most_delay_s: f64,
    },
    /// The model does not describe the lines.
    #[error(transparent)]
    Hopeless(#[from] Hopeless),
    /// The lines do not determine the corner.
    #[error(
        "the corner is not determined (uncertain by {:.0} %, correlation with the delay {correlation:.2}): \
         jitter of the delay smears it, or the lines do not reach up to it",
        100.0 * u_ratio
    )]
    NotDetermined {
        /// Relative standard uncertainty of the corner by linear theory; infinite where no fit with a free corner
        /// converges.
        u_ratio: f64,
        /// Correlation of corner and delay.
        correlation: f64,
    },
}

/// Response of the sampled loop at a frequency: a zero-order hold of `period_s`, a unit-gain loop, a delay of any length.
/// Period, corner and damping must be positive, the frequency not a multiple of the sampling rate.
///
/// The step response after the delay is 1 + Σ c_i·e^{p_i·t}. With d = ⌈τ/Ts⌉ and ε = d·Ts − τ the samples give
/// `G(z) = z^−d·(1 + (1 − z^−1)·Σ c_i·e^{p_i·ε}/(1 − e^{p_i·Ts}·z^−1))`, the modified z-transform (Jury, *Theory and
/// Application of the z-Transform Method*, ch. 1; Åström & Wittenmark, *Computer-Controlled Systems*, §2.3).
pub fn sampled_response(
    frequency_hz: f64,
    period_s: f64,
    corner_hz: f64,
    damping: Option<f64>,
    delay_s: f64,
) -> C64 {
    Poles::new(corner_hz, damping).sampled(TAU * frequency_hz * period_s, period_s, delay_s)
}

/// Pairs [p, c] of pole and coefficient of the step response 1 + Σ c·e^{p·t}. In first order the second c is 0.
struct Poles([[C64; 2]; 2]);

impl Poles {
    fn new(corner_hz: f64, damping: Option<f64>) -> Self {
        let Some(zeta) = damping else {
            let pole = C64::from(-TAU * corner_hz);
            return Self([[pole, C64::from(-1.0)], [pole, C64::default()]]);
        };
        let omega = natural_rad_per_s(corner_hz, zeta);
        // A double pole has no such partial fractions. Moving ζ by 1e-7 separates the poles without a visible effect.
        let zeta = if (zeta - 1.0).abs() < 1e-7 { 1.0 + 1e-7 } else { zeta };
        let root = C64::from(zeta * zeta - 1.0).sqrt();
        let [one, two] = [-zeta + root, -zeta - root].map(|p| p * omega);
        Self([[one, two / (one - two)], [two, -one / (one - two)]])
    }

    /// G(z) of [`sampled_response`] at z = e^(j·`angle_rad`), with d = `periods` and ε = `lead_s`.
    fn sampled(&self, angle_rad: f64, period_s: f64, delay_s: f64) -> C64 {
        let periods = (delay_s / period_s).ceil();
        let lead_s = periods * period_s - delay_s;
        let z_inverse = C64::from_polar(1.0, -angle_rad);
        let term =
            |[pole, c]: &[C64; 2]| c * (pole * lead_s).exp() / (1.0 - (pole * period_s).exp() * z_inverse);
        let sum = self.0.iter().map(term).sum::<C64>();
        C64::from_polar(1.0, -angle_rad * periods) * (1.0 + (1.0 - z_inverse) * sum)
    }
}

/// ω₀ of a second-order system whose −3 dB frequency is the corner, rad/s: f_c = f₀·√(1 − 2ζ² + √((1 − 2ζ²)² + 1)).
fn natural_rad_per_s(corner_hz: f64, zeta: f64) -> f64 {
    let b = 1.0 - 2.0 * zeta * zeta;
    TAU * corner_hz / (b + (b * b + 1.0).sqrt()).sqrt()
}

/// Least-squares model. Its parameters are gain, delay in s, ln of the corner in Hz (unless held), and ln ζ in second order.
struct Model<'a> {
    lines: &'a [Line],
    settings: Settings,
    /// Corner to be held fixed, Hz: then it is no parameter. `None` fits it.
    corner_hz: Option<f64>,
}

impl Model<'_> {
    /// The modelled response at unit gain.
    fn shape(&self, p: &[f64]) -> impl Fn(&Line) -> C64 + use<> {
        let period_s = self.settings.period_s;
        let (corner_hz, damping_index) = self.corner_hz.map_or_else(|| (p[2].exp(), 3), |hz| (hz, 2));
        let poles = Poles::new(corner_hz, p.get(damping_index).map(|ln_zeta| ln_zeta.exp()));
        let delay_s = p[1];
        move |line| poles.sampled(TAU * line.frequency_hz * period_s, period_s, delay_s)
    }

    fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let shape = self.shape(p);
        let weighed = |line: &Line| {
            let error = (line.value - p[0] * shape(line)) / line_sd(line);
            [error.re, error.im]
        };
        self.lines.iter().flat_map(weighed).collect()
    }

    /// χ² at the best gain for these other parameters, and all parameters with this gain in front.
    fn with_gain(&self, rest: Vec<f64>) -> (f64, Vec<f64>) {
        let mut p = [vec![1.0], rest].concat();
        let shape = self.shape(&p);
        // Weighted linear least squares in the gain alone.
        let mut numerator = 0.0;
        let mut denominator = 0.0;
        for line in self.lines {
            let w = line_sd(line).powi(-2);
            let g = shape(line);
            numerator += w * (g.conj() * line.value).re;
            denominator += w * g.norm_sqr();
        }
        p[0] = numerator / denominator;
        (self.residuals(&p).iter().map(|r| r * r).sum(), p)
    }

    /// The best points of a coarse grid over delay, corner and damping, as start values.
    fn starts(&self) -> Vec<Vec<f64>> {
        let Settings { period_s, order, most_delay_s } = self.settings;
        let count = (4.0 * most_delay_s / period_s).ceil() as usize;
        let corners: Vec<Vec<f64>> = if self.corner_hz.is_some() {
            vec![Vec::new()]
        } else {
            CORNERS_HZ.map(|hz| vec![hz.ln()]).to_vec()
        };
        let dampings: Vec<Vec<f64>> = match order {
            Order::First => vec![Vec::new()],
            Order::Second => [0.4_f64, 0.8, 1.5].map(|z| vec![z.ln()]).to_vec(),
        };
        // Never a whole number of periods: there the response is not differentiable in the delay.
        let delays = (0..=count).map(|k| (k as f64 + 0.4) * period_s / 4.0);
        let mut all: Vec<(f64, Vec<f64>)> = delays
            .flat_map(|d| corners.iter().map(move |c| [&[d], c.as_slice()].concat()))
            .flat_map(|dc| dampings.iter().map(move |z| [dc.as_slice(), z].concat()))
            .map(|rest| self.with_gain(rest))
            .filter(|(cost, _)| cost.is_finite())
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().take(STARTS).map(|(_, p)| p).collect()
    }

    /// The fit with the smallest residual of all that converge from these starts.
    fn best(&self, starts: Vec<Vec<f64>>) -> Option<NonlinearFit> {
        let fits = starts.into_iter().filter_map(|start| {
            let mut scale = vec![1.0; start.len()];
            (scale[0], scale[1]) = (start[0].abs().max(f64::MIN_POSITIVE), self.settings.period_s);
            NonlinearFit::new(|p| self.residuals(p), &start, &scale)
        });
        fits.min_by(|a, b| a.residual_variance.total_cmp(&b.residual_variance))
    }
}

/// Fits gain, delay, corner (and damping) by maximum likelihood. The response is from the command to the current in the
/// same row of the log.
///
/// # Errors
/// Lines or settings that cannot be used, no convergence, or a corner that the lines do not determine.
pub fn current_loop(lines: &[Line], settings: &Settings) -> Result<LagFit, LagError> {
    check(lines, settings)?;
    let lines = &with_pooled_variances(lines);
    let model = Model { lines, settings: *settings, corner_hz: None };
    let most_delay_s = settings.most_delay_s;
    let fit = model.best(model.starts());
    let Some(fit) = fit else {
        // If the fit converges with the corner held, the free corner is what prevents convergence.
        let held = Model { corner_hz: Some(1000.0), ..model };
        let converges = held.best(held.starts()).is_some();
        let not_determined = LagError::NotDetermined { u_ratio: f64::INFINITY, correlation: 1.0 };
        return Err(if converges { not_determined } else { LagError::NoFit { most_delay_s } });
    };
    let goodness = Goodness::of_lines(lines, fit.residual_variance, fit.dof);
    let scale = goodness.variance_factor();
    let covariance = &fit.unscaled_covariance;
    // Standard uncertainty of parameter k: 0 gain, 1 delay, 2 ln corner, 3 ln ζ. Of a logarithm it is a relative one.
    let u = |k: usize| (covariance[(k, k)] * scale).sqrt();
    let correlation = covariance[(1, 2)] / (covariance[(1, 1)] * covariance[(2, 2)]).sqrt();
    if !(u(2) < MOST_U_RATIO && profiled(&model, &fit, scale)) {
        return Err(LagError::NotDetermined { u_ratio: u(2), correlation });
    }
    let corner_hz = fit.parameters[2].exp();
    let zeta = fit.parameters.get(3).map(|z| z.exp());
    Ok(LagFit {
        corner_hz,
        corner_u_hz: corner_hz * u(2),
        transport_s: fit.parameters[1],
        transport_u_s: u(1),
        gain: fit.parameters[0],
        gain_u: u(0),
        correlation,
        lag_s: zeta.map_or(1.0 / (TAU * corner_hz), |z| 2.0 * z / natural_rad_per_s(corner_hz, z)),
        hold_s: 0.5 * settings.period_s,
        damping: zeta.map(|z| [z, z * u(3)]),
        goodness,
        chi2: fit.residual_variance * fit.dof as f64,
        misfit: goodness.is_misfit() || is_inexact(&goodness, &fit),
    })
}

fn check(lines: &[Line], settings: &Settings) -> Result<(), InputError> {
    check_lines(lines, 5)?;
    for (name, found) in [("period_s", settings.period_s), ("most_delay_s", settings.most_delay_s)] {
        if !(found.is_finite() && found > 0.0) {
            return Err(InputError::Setting { name, found, expected: "a positive number" });
        }
    }
    let highest = lines[lines.len() - 1].frequency_hz * settings.period_s;
    if highest < 0.5 {
        return Ok(());
    }
    let expected = "lines below half the sampling rate";
    Err(InputError::Setting { name: "period_s", found: settings.period_s, expected })
}

/// Whether the profile likelihood bounds the corner: held above and below its best value, with all other parameters
/// fitted again, it fits clearly worse. A fit that does not converge there counts as worse.
fn profiled(model: &Model<'_>, fit: &NonlinearFit, scale: f64) -> bool {
    let chi2 = fit.residual_variance * fit.dof as f64;
    [PROFILE_FACTOR, 1.0 / PROFILE_FACTOR].iter().all(|factor| {
        let corner_hz = fit.parameters[2].exp() * factor;
        let held = Model { corner_hz: Some(corner_hz), ..*model };
        let mut start = fit.parameters.clone();
        start.remove(2);
        let cost = held.best(held.starts().into_iter().chain([start]).collect());
        cost.is_none_or(|c| c.residual_variance * c.dof as f64 - chi2 > PROFILE_CHI2 * scale)
    })
}

/// Whether exact lines, which have only their residuals, lie off the model.
fn is_inexact(goodness: &Goodness, fit: &NonlinearFit) -> bool {
    goodness.ratio().is_none() && fit.residual_variance.sqrt() > MOST_EXACT_RATIO
}
