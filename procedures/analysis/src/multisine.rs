//! Multisines: design, and the presliding stiffness and damping that one shows.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::goodness::Goodness;
use super::nonlinear::NonlinearFit;
use super::presliding::bristle;

#[cfg(test)]
mod tests;

/// Fewest periods that are averaged, after the one that is dropped.
pub const FEWEST_PERIODS: usize = 3;
/// Scale on which the delay between torque and angle moves.
const DELAY_SCALE_S: f64 = 1e-4;

/// A multisine of equal amplitudes on whole multiples of one base frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Multiples of the base frequency, ascending, none twice.
    pub orders: Vec<u32>,
    /// Phase of each cosine, rad.
    pub phases_rad: Vec<f64>,
    /// Largest |sum| of the unit cosines: what the amplitude is divided by to reach a wanted peak.
    pub peak_ratio: f64,
}

impl Design {
    /// About `count` lines, log-spaced from multiple 1 to `last`, with the phases of Schroeder (*IEEE Trans. Inf.
    /// Theory* 16, 85, 1970): φ_k = −π·k(k−1)/n, which spread the peaks of n equal lines.
    pub fn log_spaced(last: u32, count: usize) -> Self {
        let steps = count.saturating_sub(1).max(1) as f64;
        let mut orders: Vec<u32> =
            (0..count).map(|k| f64::from(last).powf(k as f64 / steps).round().max(1.0) as u32).collect();
        orders.dedup();
        let n = orders.len() as f64;
        let phases_rad: Vec<f64> = (0..orders.len()).map(|k| -PI * (k * (k + 1)) as f64 / n).collect();
        let samples = 64 * last;
        let sum = |i: u32| -> f64 {
            let turn = TAU * f64::from(i) / f64::from(samples);
            orders.iter().zip(&phases_rad).map(|(&k, p)| (f64::from(k) * turn + p).cos()).sum()
        };
        let peak_ratio = (0..samples).map(|i| sum(i).abs()).fold(0.0, f64::max);
        Self { orders, phases_rad, peak_ratio }
    }
}

/// One line of the measured presliding response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseLine {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Friction torque over displacement, N·m/rad, complex: real part stiffness, imaginary part ω·damping.
    pub stiffness: Complex<f64>,
    /// Response of the fitted model at the line.
    pub model: Complex<f64>,
    /// Standard uncertainty of its modulus from the scatter between periods.
    pub u: f64,
}

/// Stiffness and damping in presliding.
#[derive(Clone, Debug, PartialEq)]
pub struct Presliding {
    /// Bristle stiffness σ0, N·m/rad.
    pub sigma0: f64,
    /// Standard uncertainty of `sigma0`.
    pub sigma0_u: f64,
    /// σ1 + σ2, N·m·s/rad.
    pub damping: f64,
    /// Standard uncertainty of `damping`.
    pub damping_u: f64,
    /// Displacement over which the bristle bends, rad: from the hysteresis of the small loops.
    pub z_ss_rad: f64,
    /// Time by which the recorded torque runs ahead of the recorded angle, s (half a sample of hold, current loop).
    pub delay_s: f64,
    /// Degrees of freedom.
    pub dof: f64,
    /// How well the model describes the lines, by the scatter between periods.
    pub goodness: Goodness,
    /// Periods averaged.
    pub periods: usize,
    /// Lines.
    pub lines: Vec<ResponseLine>,
}

/// A record of a presliding multisine in blocks, with what is known of it.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    /// Displacement, rad, from rest at the start of the multisine.
    pub x_rad: &'a [f64],
    /// Motor torque less load (inertia still in it), N·m.
    pub torque_nm: &'a [f64],
    /// Blocks a period.
    pub period_blocks: usize,
    /// Period, s.
    pub period_s: f64,
    /// Excited multiples of 1/period.
    pub orders: &'a [u32],
    /// Inertia, kg·m².
    pub inertia: f64,
    /// Bristle torque at rest before the start, N·m.
    pub start_nm: f64,
}

impl Presliding {
    /// Fits T·e^(jωτ) + J·ω²·X = (σ0 + jω(σ1+σ2))·Z on the excited lines, τ a delay between the two records, where Z is the bristle that the measured path
    /// bends (rate-independent, [`bristle`]): so the hysteresis of the loops, which at 0.1 T_S makes a secant of
    /// 0.95 σ0 on the virgin curve and looks like a damping of 4 % of σ0/ω, is modelled, not averaged into the result.
    ///
    /// The first period is dropped (fade-in, transient). Weights and uncertainty come from the scatter of the
    /// residual between periods, pooled over the lines. `None` with fewer than three periods left or when the fit
    /// does not converge.
    pub fn new(record: &Record<'_>) -> Option<Self> {
        let periods =
            (record.x_rad.len().min(record.torque_nm.len()) / record.period_blocks.max(1)).checked_sub(1)?;
        if periods < FEWEST_PERIODS || record.orders.is_empty() {
            return None;
        }
        let x = Spectra::new(record.x_rad, record, periods);
        let torque = Spectra::new(record.torque_nm, record, periods);
        let start = first_guess(&x, &torque, record)?;
        let sd = scatter(&x, &torque, record, start[0], start[2], periods);
        let residuals = |p: &[f64]| -> Vec<f64> {
            let Some(z) = bent(record, p[0], p[1].exp(), periods) else {
                return vec![f64::NAN; 2 * record.orders.len()];
            };
            (0..record.orders.len())
                .flat_map(|l| {
                    let w = record.omega(l);
                    let inertial = x.closed[l] * (-record.inertia * w * w);
                    let asked = z.mean[l] * p[0] + z.closed[l] * Complex::new(0.0, w * p[2]) + inertial;
                    let rest = torque.mean[l] * turn(w * p[3]) - asked;
                    [rest.re / sd, rest.im / sd]
                })
                .collect()
        };
        // The bending length by its logarithm: from a start that is far off a step of the fit would make it negative.
        let start = [start[0], start[1].ln(), start[2], start[3]];
        let fit = NonlinearFit::new(residuals, &start, &[start[0], 1.0, start[0] * 0.1, DELAY_SCALE_S])?;
        let [sigma0, ln_z_ss, damping, delay_s] = fit.parameters[..] else { return None };
        let z_ss_rad = ln_z_ss.exp();
        let z = bent(record, sigma0, z_ss_rad, periods)?;
        let bristle_power: f64 = z.mean.iter().map(|z| (z * sigma0).norm_sqr()).sum();
        let left_power = fit.residual_variance * fit.dof as f64 * sd * sd;
        let scatter_dof = (2 * record.orders.len() * (periods - 1)) as f64;
        let goodness = Goodness::of_known(fit.residual_variance, fit.dof)
            .stated_with(scatter_dof)
            .with_share((left_power / bristle_power).sqrt());
        let u = |k: usize| fit.unscaled_covariance[(k, k)].max(0.0).sqrt() * goodness.widening();
        Some(Self {
            sigma0,
            sigma0_u: u(0),
            damping,
            damping_u: u(2),
            z_ss_rad,
            delay_s,
            dof: goodness.dof(),
            goodness,
            periods,
            lines: response(record, &x, &torque, &z, [sigma0, damping, delay_s], sd),
        })
    }
}

/// The measured lines beside the model's, for parameters [σ0, damping, delay].
fn response(
    record: &Record<'_>,
    x: &Spectra,
    torque: &Spectra,
    z: &Spectra,
    [sigma0, damping, delay_s]: [f64; 3],
    sd: f64,
) -> Vec<ResponseLine> {
    (0..record.orders.len())
        .map(|l| {
            let w = record.omega(l);
            let torque = torque.mean[l] * turn(w * delay_s);
            let stiffness = (torque + x.closed[l] * (record.inertia * w * w)) / x.mean[l];
            let bristle = z.mean[l] * sigma0 + z.closed[l] * Complex::new(0.0, w * damping);
            let model = bristle / x.mean[l];
            ResponseLine { frequency_hz: w / TAU, stiffness, model, u: sd / x.mean[l].norm() }
        })
        .collect()
}

impl Record<'_> {
    fn omega(&self, line: usize) -> f64 {
        TAU * f64::from(self.orders[line]) / self.period_s
    }
}

/// Complex amplitudes of the excited lines, a period each and their mean.
///
/// `closed` are those of the same record with each period's drift taken off as a straight line: jω times them is the
/// spectrum of the derivative, which jω times the plain lines is not when a period does not end where it began (the
/// bristle creeps, and at high lines ω²·X would be all creep).
struct Spectra {
    each: Vec<Vec<Complex<f64>>>,
    each_closed: Vec<Vec<Complex<f64>>>,
    mean: Vec<Complex<f64>>,
    closed: Vec<Complex<f64>>,
}

impl Spectra {
    fn new(values: &[f64], record: &Record<'_>, periods: usize) -> Self {
        let n = record.period_blocks;
        let of_period = |p: usize| -> Vec<Complex<f64>> {
            record.orders.iter().map(|&k| line(&values[p * n..(p + 1) * n], k)).collect()
        };
        let each: Vec<Vec<Complex<f64>>> = (1..=periods).map(of_period).collect();
        let each_closed: Vec<Vec<Complex<f64>>> = (1..=periods)
            .zip(&each)
            .map(|(p, lines)| {
                let drift = rise(values, p * n, n);
                record.orders.iter().zip(lines).map(|(&k, v)| v - unit_ramp(k, n) * drift).collect()
            })
            .collect();
        let mean = mean_over_periods(&each);
        let closed = mean_over_periods(&each_closed);
        Self { each, each_closed, mean, closed }
    }
}

fn mean_over_periods(each: &[Vec<Complex<f64>>]) -> Vec<Complex<f64>> {
    let lines = each.first().map_or(0, Vec::len);
    (0..lines).map(|l| each.iter().map(|e| e[l]).sum::<Complex<f64>>() / each.len() as f64).collect()
}

/// Line `order` of a ramp that rises from 0 by 1/n a block: (2/n)/(e^(−j2πk/n) − 1), about j/(πk).
fn unit_ramp(order: u32, n: usize) -> Complex<f64> {
    (turn(-TAU * f64::from(order) / n as f64) - 1.0).inv() * (2.0 / n as f64)
}

/// By how much a record rises over the period of `n` blocks that starts at `from`; where the record ends with the
/// period, its last step goes on.
fn rise(values: &[f64], from: usize, n: usize) -> f64 {
    let end = from + n;
    let after = values.get(end).copied().unwrap_or(2.0 * values[end - 1] - values[end - 2]);
    after - values[from]
}

/// e^(jφ).
fn turn(phase_rad: f64) -> Complex<f64> {
    Complex::from_polar(1.0, phase_rad)
}

/// Amplitude of one line of one period: (2/n)·Σ v·e^(−j2πki/n).
fn line(values: &[f64], order: u32) -> Complex<f64> {
    let n = values.len() as u64;
    let sum: Complex<f64> = values
        .iter()
        .enumerate()
        .map(|(i, v)| {
            let turn = (u64::from(order) * i as u64 % n) as f64 / n as f64;
            Complex::from_polar(*v, -TAU * turn)
        })
        .sum();
    sum * (2.0 / n as f64)
}

/// The bristle's lines for a stiffness and a bending length; `None` for parameters without meaning.
fn bent(record: &Record<'_>, sigma0: f64, z_ss: f64, periods: usize) -> Option<Spectra> {
    if !(sigma0 > 0.0 && z_ss > 0.0) {
        return None;
    }
    let z = bristle(record.x_rad, z_ss, record.start_nm / sigma0);
    Some(Spectra::new(&z, record, periods))
}

/// σ0, z_ss, damping and delay to start from: lines as if the contact were linear.
fn first_guess(x: &Spectra, torque: &Spectra, record: &Record<'_>) -> Option<[f64; 4]> {
    let mut real = 0.0;
    let mut imaginary = 0.0;
    let mut square = 0.0;
    let mut rate = 0.0;
    for l in 0..record.orders.len() {
        let w = record.omega(l);
        let friction = torque.mean[l] + x.mean[l] * (record.inertia * w * w);
        let projected = friction * x.mean[l].conj();
        real += projected.re;
        square += x.mean[l].norm_sqr();
        imaginary += w * projected.im;
        rate += w * w * x.mean[l].norm_sqr();
    }
    let sigma0 = real / square;
    let reach = record.x_rad.iter().map(|v| v.abs()).fold(0.0, f64::max);
    (sigma0 > 0.0 && reach > 0.0).then_some([sigma0, 10.0 * reach, imaginary / rate, 0.0])
}

/// Standard deviation of one real part of a line's mean residual, from the scatter between periods.
fn scatter(
    x: &Spectra,
    torque: &Spectra,
    record: &Record<'_>,
    sigma0: f64,
    damping: f64,
    periods: usize,
) -> f64 {
    let mut sum = 0.0;
    for l in 0..record.orders.len() {
        let w = record.omega(l);
        let moving = Complex::new(-record.inertia * w * w, w * damping);
        let mean = torque.mean[l] - x.mean[l] * sigma0 - x.closed[l] * moving;
        for p in 0..periods {
            let rest = torque.each[p][l] - x.each[p][l] * sigma0 - x.each_closed[p][l] * moving;
            sum += (rest - mean).norm_sqr();
        }
    }
    let dof = 2 * record.orders.len() * (periods - 1);
    (sum / dof as f64 / periods as f64).sqrt()
}
