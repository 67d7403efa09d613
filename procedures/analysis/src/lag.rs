//! The current loop as a sampled system: held command in, sampled current out; its lag, its delay and its hold apart.

use std::f64::consts::TAU;

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::delay::{InputError, check_lines, chi2_scale, line_sd};
use super::frf::{C64, Line};
use super::nonlinear::NonlinearFit;

mod known;
#[cfg(test)]
mod tests;

pub use known::{KnownLag, transport_at_known_corner};

/// Corners tried first, Hz.
const CORNERS_HZ: [f64; 8] = [150.0, 300.0, 500.0, 750.0, 1000.0, 1400.0, 2000.0, 4000.0];
/// Starts fitted in full.
const STARTS: usize = 4;
/// A corner this factor up and down must fit worse, or it is not determined.
const PROFILE_FACTOR: f64 = 1.25;
/// By so much in χ²: three standard deviations.
const PROFILE_CHI2: f64 = 9.0;
/// Largest relative uncertainty of a corner that is determined.
const MOST_U_RATIO: f64 = 0.1;
/// Probability of the residuals below which the model does not fit.
const LEAST_PROBABILITY: f64 = 1e-3;
/// Residual rms over |G| above which lines without variance do not fit.
const MOST_EXACT_RATIO: f64 = 1e-4;

/// Form of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// 1/(1 + s/(2πf_c)).
    First,
    /// ω₀²/(s² + 2ζω₀s + ω₀²), ζ fitted; f_c is still the −3 dB frequency.
    Second,
}

/// How the response was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Period of hold and samples, s.
    pub period_s: f64,
    /// Form of the loop.
    pub order: Order,
    /// Largest delay looked for, s.
    pub most_delay_s: f64,
}

/// What a current loop is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagFit {
    /// −3 dB bandwidth of the loop itself, hold and delay removed, Hz.
    pub corner_hz: f64,
    /// Standard uncertainty of `corner_hz`, Hz.
    pub corner_u_hz: f64,
    /// Pure delay from the tick whose row holds the command to the sample: transport and computing, neither lag nor
    /// hold, s.
    pub transport_s: f64,
    /// Standard uncertainty of `transport_s`, s.
    pub transport_u_s: f64,
    /// Static gain, measured over commanded.
    pub gain: f64,
    /// Standard uncertainty of `gain`.
    pub gain_u: f64,
    /// Correlation of corner and delay.
    pub correlation: f64,
    /// Slope of the loop's own phase at 0 Hz: 1/(2πf_c) of the first order, 2ζ/ω₀ of the second, s.
    pub lag_s: f64,
    /// Delay of the hold at low frequency, half a period, s.
    pub hold_s: f64,
    /// Damping ratio of the second order and its standard uncertainty.
    pub damping: Option<[f64; 2]>,
    /// χ² over degrees of freedom.
    pub misfit_ratio: f64,
    /// The form does not fit the lines: the numbers describe something else.
    pub misfit: bool,
}

/// Why there are no numbers.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LagError {
    /// Lines that are none.
    #[error(transparent)]
    Input(#[from] InputError),
    /// No convergence.
    #[error("no fit: the response is not a lag behind a hold with a delay up to {most_delay_s} s")]
    NoFit {
        /// Largest delay looked for, s.
        most_delay_s: f64,
    },
    /// The lines do not hold the corner.
    #[error(
        "the corner is not determined (relative uncertainty {u_ratio}, correlation with the delay {correlation}): sample faster and excite up to the corner"
    )]
    NotDetermined {
        /// Relative standard uncertainty of the corner by linear theory; infinite where not even that exists.
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

/// Poles p and coefficients c of the step response 1 + Σ c·e^{p·t}.
struct Poles([[C64; 2]; 2]);

impl Poles {
    fn new(corner_hz: f64, damping: Option<f64>) -> Self {
        let Some(zeta) = damping else {
            let pole = C64::from(-TAU * corner_hz);
            return Self([[pole, C64::from(-1.0)], [pole, C64::default()]]);
        };
        let omega = natural_rad_per_s(corner_hz, zeta);
        // Equal poles have no partial fractions; 1e-7 beside them nothing can be told.
        let zeta = if (zeta - 1.0).abs() < 1e-7 { 1.0 + 1e-7 } else { zeta };
        let root = C64::from(zeta * zeta - 1.0).sqrt();
        let [one, two] = [-zeta + root, -zeta - root].map(|p| p * omega);
        Self([[one, two / (one - two)], [two, -one / (one - two)]])
    }

    fn sampled(&self, angle: f64, period_s: f64, delay_s: f64) -> C64 {
        let whole = (delay_s / period_s).ceil();
        let rest = whole * period_s - delay_s;
        let back = C64::from_polar(1.0, -angle);
        let term = |[pole, c]: &[C64; 2]| c * (pole * rest).exp() / (1.0 - (pole * period_s).exp() * back);
        C64::from_polar(1.0, -angle * whole) * (1.0 + (1.0 - back) * self.0.iter().map(term).sum::<C64>())
    }
}

/// ω₀ of a second order with its −3 dB point at the corner: f_c = f₀·√(1 − 2ζ² + √((1 − 2ζ²)² + 1)).
fn natural_rad_per_s(corner_hz: f64, zeta: f64) -> f64 {
    let flat = 1.0 - 2.0 * zeta * zeta;
    TAU * corner_hz / (flat + (flat * flat + 1.0).sqrt()).sqrt()
}

/// Parameters: gain, delay, ln corner, and ln ζ of the second order.
struct Model<'a> {
    lines: &'a [Line],
    settings: Settings,
    /// A corner that is held, for the profile.
    corner_hz: Option<f64>,
}

impl Model<'_> {
    fn shape(&self, p: &[f64]) -> impl Fn(&Line) -> C64 + use<> {
        let period_s = self.settings.period_s;
        let (corner, rest) = self.corner_hz.map_or_else(|| (p[2].exp(), 3), |hz| (hz, 2));
        let poles = Poles::new(corner, p.get(rest).map(|z| z.exp()));
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

    /// The best gain for the rest, with χ².
    fn with_gain(&self, rest: Vec<f64>) -> (f64, Vec<f64>) {
        let mut p = [vec![1.0], rest].concat();
        let shape = self.shape(&p);
        let mut above = 0.0;
        let mut below = 0.0;
        for line in self.lines {
            let w = line_sd(line).powi(-2);
            let g = shape(line);
            above += w * (g.conj() * line.value).re;
            below += w * g.norm_sqr();
        }
        p[0] = above / below;
        (self.residuals(&p).iter().map(|r| r * r).sum(), p)
    }

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
        // Off the whole periods: there the derivative by the delay has a kink.
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

    fn best(&self, starts: Vec<Vec<f64>>) -> Option<NonlinearFit> {
        let fits = starts.into_iter().filter_map(|start| {
            let mut scale = vec![1.0; start.len()];
            (scale[0], scale[1]) = (start[0].abs().max(f64::MIN_POSITIVE), self.settings.period_s);
            NonlinearFit::new(|p| self.residuals(p), &start, &scale)
        });
        fits.min_by(|a, b| a.residual_variance.total_cmp(&b.residual_variance))
    }
}

/// Fits gain, corner and delay (and damping) by maximum likelihood to a response from the command row of a tick to the
/// current row of the same tick.
///
/// # Errors
/// Lines that are none; no fit; a corner that the lines do not hold: refused, not guessed.
pub fn current_loop(lines: &[Line], settings: &Settings) -> Result<LagFit, LagError> {
    check(lines, settings)?;
    let model = Model { lines, settings: *settings, corner_hz: None };
    let most_delay_s = settings.most_delay_s;
    let fit = model.best(model.starts());
    let Some(fit) = fit else {
        // Where nothing converges because the corner is free, it is held: then it is the corner's fault.
        let held = Model { corner_hz: Some(1000.0), ..model };
        let settles = held.best(held.starts()).is_some();
        let loose = LagError::NotDetermined { u_ratio: f64::INFINITY, correlation: 1.0 };
        return Err(if settles { loose } else { LagError::NoFit { most_delay_s } });
    };
    let scale = chi2_scale(lines, fit.residual_variance);
    let covariance = &fit.unscaled_covariance;
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
        misfit_ratio: fit.residual_variance,
        misfit: misfits(lines, &fit),
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
    let expected = "lines below half the sampling rate";
    (highest < 0.5).then_some(()).ok_or(InputError::Setting {
        name: "period_s",
        found: settings.period_s,
        expected,
    })
}

/// Whether corners beside the found one fit worse with everything else fitted anew.
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

fn misfits(lines: &[Line], fit: &NonlinearFit) -> bool {
    if lines.iter().all(|l| l.variance <= 0.0) {
        return fit.residual_variance.sqrt() > MOST_EXACT_RATIO;
    }
    let d = (lines.len() as f64 / lines.iter().map(|l| 1.0 / l.dof.max(1e-3)).sum::<f64>()).max(2.5);
    let (mean, widening) = if d.is_finite() { (d / (d - 1.0), d / (d - 2.0)) } else { (1.0, 1.0) };
    let dof = fit.dof as f64 / widening;
    let chi2 = fit.residual_variance / mean * dof;
    ChiSquared::new(dof).map_or(true, |distribution| distribution.sf(chi2) < LEAST_PROBABILITY)
}
