//! A lightly damped mode, sampled exactly, and seeded noise. Shared with the example `recovery_responses`.

use std::f64::consts::TAU;

use nalgebra::Complex;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Seeded random numbers.
pub(crate) struct Noise(ChaCha8Rng);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// 0…1, without the ends.
    pub(crate) fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Normal of sd 1, by Box and Muller.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

/// ω²/(s² + 2ζωs + ω²).
#[derive(Clone, Copy)]
pub(crate) struct Mode {
    pub(crate) natural_hz: f64,
    pub(crate) zeta: f64,
}

impl Mode {
    /// Continuous response.
    pub(crate) fn at(self, frequency_hz: f64) -> Complex<f64> {
        let r = frequency_hz / self.natural_hz;
        Complex::new(1.0 - r * r, 2.0 * self.zeta * r).inv()
    }
}
