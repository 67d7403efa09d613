//! A mode whose input is held between the samples.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::plant::Mode;

impl Mode {
    /// Numerator and denominator in z⁻¹ behind a zero-order hold (Åström & Wittenmark, *Computer-Controlled
    /// Systems*, table 2.1).
    fn sampled(self, sample_rate_hz: f64) -> [[f64; 2]; 2] {
        let w = TAU * self.natural_hz / sample_rate_hz;
        let root = (1.0 - self.zeta * self.zeta).sqrt();
        let decay = (-self.zeta * w).exp();
        let (sin, cos) = (w * root).sin_cos();
        let slow = self.zeta / root * sin;
        let b = [1.0 - decay * (cos + slow), decay * decay + decay * (slow - cos)];
        [b, [-2.0 * decay * cos, decay * decay]]
    }

    /// Response of the sampled mode, exact.
    pub(crate) fn sampled_at(self, frequency_hz: f64, sample_rate_hz: f64) -> Complex<f64> {
        let [b, a] = self.sampled(sample_rate_hz);
        let z = Complex::from_polar(1.0, -TAU * frequency_hz / sample_rate_hz);
        (z * b[0] + z * z * b[1]) / (Complex::new(1.0, 0.0) + z * a[0] + z * z * a[1])
    }

    /// Output at the samples for an input that is held, from rest.
    pub(crate) fn run(self, input: &[f64], sample_rate_hz: f64) -> Vec<f64> {
        let [b, a] = self.sampled(sample_rate_hz);
        let mut u = [0.0; 2];
        let mut y = [0.0; 2];
        input
            .iter()
            .map(|&now| {
                let out = b[0] * u[0] + b[1] * u[1] - a[0] * y[0] - a[1] * y[1];
                u = [now, u[0]];
                y = [out, y[0]];
                out
            })
            .collect()
    }
}
