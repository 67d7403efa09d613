//! Synthetic responses with noise of known variance.

use std::f64::consts::TAU;

use analysis::frf::{C64, Frf, Line};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Gaussian numbers by Box and Muller from a seeded stream.
pub(crate) struct Gauss(ChaCha8Rng);

impl Gauss {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn next(&mut self) -> f64 {
        let mut uniform = || (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0;
        (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
    }

    /// Circular complex with E|x|² = variance.
    pub(crate) fn complex(&mut self, variance: f64) -> C64 {
        C64::new(self.next(), self.next()) * (0.5 * variance).sqrt()
    }
}

/// A mode of the truth.
#[derive(Clone, Copy)]
pub(crate) struct TrueMode {
    pub(crate) frequency_hz: f64,
    pub(crate) damping: f64,
    /// R of R/(s − p) + R*/(s − p*).
    pub(crate) residue: C64,
}

impl TrueMode {
    /// c/(s² + 2ζω_n·s + ω_n²): displacement over force.
    pub(crate) fn displacement(frequency_hz: f64, damping: f64, c: f64) -> Self {
        let mode = Self { frequency_hz, damping, residue: C64::default() };
        Self { residue: C64::new(c, 0.0) / C64::new(0.0, 2.0 * mode.pole().im), ..mode }
    }

    /// c·s/(s² + 2ζω_n·s + ω_n²): velocity over force.
    pub(crate) fn velocity(frequency_hz: f64, damping: f64, c: f64) -> Self {
        let mode = Self { frequency_hz, damping, residue: C64::default() };
        Self { residue: mode.pole() * c / C64::new(0.0, 2.0 * mode.pole().im), ..mode }
    }

    fn pole(&self) -> C64 {
        let omega = TAU * self.frequency_hz;
        C64::new(-self.damping, (1.0 - self.damping * self.damping).sqrt()) * omega
    }

    pub(crate) fn at(&self, frequency_hz: f64) -> C64 {
        let s = C64::new(0.0, TAU * frequency_hz);
        self.residue / (s - self.pole()) + self.residue.conj() / (s - self.pole().conj())
    }
}

/// Evenly spaced frequencies.
pub(crate) fn grid(from_hz: f64, to_hz: f64, count: usize) -> Vec<f64> {
    let step = (to_hz - from_hz) / (count - 1) as f64;
    (0..count).map(|k| from_hz + step * k as f64).collect()
}

/// Values with noise of `variance(value)` on each line.
pub(crate) fn noisy(
    grid: &[f64],
    at: &dyn Fn(f64) -> C64,
    variance: &dyn Fn(C64) -> f64,
    random: &mut Gauss,
) -> Frf {
    grid.iter()
        .map(|&hz| {
            let value = at(hz);
            let variance = variance(value);
            Line { variance, ..Line::exact(hz, value + random.complex(variance)) }
        })
        .collect()
}
