//! White noise into coloured noise: poles and zeros in a row approximate a broken slope, run as parallel lags.
//!
//! A slope of −α in amplitude is a pole at each of equal ratios r of frequency with a zero r^α above it (Oustaloup's
//! approximation of a fractional integrator). Below the knee α = 1/3, which is f^(−2/3) in power; above it one whole
//! pole and α = 5/6, together f^(−11/3). Partial fractions turn the cascade into first-order lags that share their
//! input: one multiplication each, and their joint stationary distribution is known.

use std::f64::consts::TAU;

/// Below this the PSD is flat (ours); with the knee at 8 Hz a tenth of the variance lies lower.
const LOWEST_HZ: f64 = 0.005;
/// Above this nothing more bends, in units of the sampling rate.
const HIGHEST: f64 = 0.2;
/// Largest ratio of one pole to the next.
const RATIO: f64 = 3.0;
/// Lags there can be.
const CAPACITY: usize = 16;

/// Coloured noise, driven by unit white noise at a fixed rate.
#[derive(Clone, Debug)]
pub(super) struct Shaping {
    poles: [f64; CAPACITY],
    residues: [f64; CAPACITY],
    states: [f64; CAPACITY],
}

/// Poles and zeros in the z-plane, equally many.
struct Cascade {
    poles: Vec<f64>,
    zeros: Vec<f64>,
}

impl Shaping {
    /// Noise whose one-sided PSD follows `psd` (unit²/Hz) around `knee_hz`.
    ///
    /// A knee above a tenth of the rate is taken for one there: what is faster, no camera here can see.
    pub(super) fn new(knee_hz: f64, rate_hz: f64, psd: impl Fn(f64) -> f64) -> Self {
        let knee_hz = knee_hz.min(0.1 * rate_hz);
        let cascade = Cascade::new(knee_hz, rate_hz);
        let gain = cascade.level(knee_hz, rate_hz, psd);
        let mut shaping = Self { poles: [0.0; CAPACITY], residues: [0.0; CAPACITY], states: [0.0; CAPACITY] };
        for (k, &pole) in cascade.poles.iter().enumerate().take(CAPACITY) {
            shaping.poles[k] = pole;
            shaping.residues[k] = gain * cascade.residue(k);
        }
        shaping
    }

    /// Draws the states of a process that has run for ever from unit normal numbers by index; returns the output.
    ///
    /// Lags that share a unit white input have the covariance `1/(1 − a_i·a_j)`; its Cholesky factor colours the draw.
    pub(super) fn settle(&mut self, mut normal: impl FnMut(u64) -> f64) -> f64 {
        let mut factor = [[0.0; CAPACITY]; CAPACITY];
        let draws: [f64; CAPACITY] = std::array::from_fn(|k| normal(k as u64));
        for i in 0..CAPACITY {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let rest = 1.0 / (1.0 - self.poles[i] * self.poles[j]) - known;
                factor[i][j] = match (i == j, factor[j][j]) {
                    (true, _) => rest.max(0.0).sqrt(),
                    // A lag that is nearly a sum of others adds nothing of its own.
                    (false, 0.0) => 0.0,
                    (false, pivot) => rest / pivot,
                };
            }
            self.states[i] = (0..=i).map(|k| factor[i][k] * draws[k]).sum();
        }
        self.output()
    }

    /// One tick with unit white noise.
    pub(super) fn step(&mut self, white: f64) -> f64 {
        for (state, pole) in self.states.iter_mut().zip(&self.poles) {
            *state = pole * *state + white;
        }
        self.output()
    }

    fn output(&self) -> f64 {
        self.states.iter().zip(&self.residues).map(|(state, residue)| state * residue).sum()
    }
}

impl Cascade {
    fn new(knee_hz: f64, rate_hz: f64) -> Self {
        let z = |frequency_hz: f64| (-TAU * frequency_hz / rate_hz).exp();
        let mut poles = vec![];
        let mut zeros = vec![];
        let mut slope = |from_hz: f64, to_hz: f64, alpha: f64| {
            let count = ((to_hz / from_hz).ln() / RATIO.ln()).ceil().max(1.0);
            let ratio = (to_hz / from_hz).powf(1.0 / count);
            for k in 0..count as u32 {
                // Symmetric within its interval: the approximation is then unbiased at both ends.
                let centre_hz = from_hz * ratio.powf(f64::from(k) + 0.5);
                poles.push(z(centre_hz * ratio.powf(-0.5 * alpha)));
                zeros.push(z(centre_hz * ratio.powf(0.5 * alpha)));
            }
        };
        let highest_hz = HIGHEST * rate_hz;
        slope(LOWEST_HZ.min(0.1 * knee_hz), knee_hz, 1.0 / 3.0);
        slope(knee_hz, highest_hz.max(2.0 * knee_hz), 5.0 / 6.0);
        poles.push(z(knee_hz));
        zeros.push(0.0);
        Self { poles, zeros }
    }

    /// `|H|²` at a frequency.
    fn power_gain(&self, frequency_hz: f64, rate_hz: f64) -> f64 {
        let cosine = (TAU * frequency_hz / rate_hz).cos();
        let square = |root: f64| 1.0 - 2.0 * root * cosine + root * root;
        let factor = |(zero, pole): (&f64, &f64)| square(*zero) / square(*pole);
        self.zeros.iter().zip(&self.poles).map(factor).product()
    }

    /// Gain that brings the PSD of the output to the wanted one, in the mean over three decades of the logarithm.
    fn level(&self, knee_hz: f64, rate_hz: f64, psd: impl Fn(f64) -> f64) -> f64 {
        const POINTS: i32 = 60;
        if psd(knee_hz) == 0.0 {
            return 0.0;
        }
        let sum: f64 = (0..POINTS)
            .map(|k| knee_hz * 10.0_f64.powf(f64::from(k - 40) / 20.0))
            .map(|f| (psd(f) / (self.power_gain(f, rate_hz) * 2.0 / rate_hz)).ln())
            .sum();
        (0.5 * sum / f64::from(POINTS)).exp()
    }

    /// Residue of `Π (1 − z_k/z)/(1 − p_k/z)` at its pole; as many zeros as poles, so the direct path is one lag of
    /// pole 0: here the zero at 0 takes it away.
    fn residue(&self, k: usize) -> f64 {
        let pole = self.poles[k];
        let above: f64 = self.zeros.iter().map(|zero| 1.0 - zero / pole).product();
        let others = self.poles.iter().enumerate().filter(|(other, _)| *other != k);
        above / others.map(|(_, other)| 1.0 - other / pole).product::<f64>()
    }
}
