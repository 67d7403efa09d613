//! What the fine tracker must leave: rejection times spectrum of what disturbs it, and its own camera's noise.
//!
//! One integrator per camera frame behind a pure delay: `L = K·e^(−sT)/s`, `S = 1/(1 + L)`, complementary `1 − S`.
//! T is the time from true motion to message, the mirror's delay and half a frame of hold (director.md §8: 11 ms).

use std::f64::consts::{PI, TAU};

use super::spectrum::Spectrum;
use crate::unit::CameraSettings;

/// Fine track loop as designed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorLoop {
    /// K, 1/s.
    pub gain_per_s: f64,
    /// T.
    pub delay_s: f64,
}

/// Parts of the fine error, one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FineBudget {
    /// What is left of the input.
    pub input_rad: f64,
    /// What the camera's own noise moves.
    pub camera_rad: f64,
}

/// What a rejection must show (ATM-REJ), in dB and Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rejection {
    /// |S| at 1 Hz.
    pub at_1_hz_db: f64,
    /// |S| at 3 Hz.
    pub at_3_hz_db: f64,
    /// Lowest frequency at which |S| is 1.
    pub crossing_hz: f64,
    /// Largest |S|.
    pub amplification_db: f64,
}

impl IntegratorLoop {
    /// The loop whose rejection crosses 0 dB at a frequency: `|S| = 1` where `K = 2ω·sin ωT`.
    pub fn crossing(frequency_hz: f64, delay_s: f64) -> Self {
        let omega = TAU * frequency_hz;
        Self { gain_per_s: 2.0 * omega * (omega * delay_s).sin(), delay_s }
    }

    /// |S|² at a frequency above 0.
    pub fn rejection(&self, frequency_hz: f64) -> f64 {
        let omega = TAU * frequency_hz;
        omega * omega / self.denominator(omega)
    }

    /// |1 − S|² at a frequency above 0.
    pub fn transmission(&self, frequency_hz: f64) -> f64 {
        self.gain_per_s * self.gain_per_s / self.denominator(TAU * frequency_hz)
    }

    /// `|jω + K·e^(−jωT)|²`.
    fn denominator(&self, omega: f64) -> f64 {
        let (sine, cosine) = (omega * self.delay_s).sin_cos();
        (self.gain_per_s * cosine).powi(2) + (omega - self.gain_per_s * sine).powi(2)
    }

    /// The figures of ATM-REJ.
    pub fn figures(&self) -> Rejection {
        let db = |frequency_hz: f64| 10.0 * self.rejection(frequency_hz).log10();
        let grid = (1..=20_000).map(|k| 0.005 * f64::from(k));
        let first = grid.clone().find(|f| self.rejection(*f) >= 1.0);
        Rejection {
            at_1_hz_db: db(1.0),
            at_3_hz_db: db(3.0),
            crossing_hz: first.unwrap_or(f64::INFINITY),
            amplification_db: grid.map(db).fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Fine error to expect from the spectrum of target minus frame plus atmosphere, and a camera.
    pub fn budget(&self, input: &Spectrum, camera: &CameraSettings, ifov_rad: f64) -> FineBudget {
        let rate_hz = camera.frame_rate_hz;
        // Each frame's error is held for a frame: in the mean over all instants white up to half the frame rate.
        let noise_psd = 2.0 * centroid_variance_px2(camera) * ifov_rad * ifov_rad / rate_hz;
        let width_hz = 0.01;
        let bins = (0.5 * rate_hz / width_hz) as u32;
        let frequencies = (1..=bins).map(|k| width_hz * f64::from(k));
        // The mirror holds each command for a frame, which averages what is fast.
        let held = |f: f64| (PI * f / rate_hz).sin() / (PI * f / rate_hz);
        let power: f64 = frequencies.map(|f| self.transmission(f) * held(f).powi(2)).sum();
        FineBudget {
            input_rad: input.filtered(|f| self.rejection(f)).sqrt(),
            camera_rad: (noise_psd * power * width_hz).sqrt(),
        }
    }
}

impl FineBudget {
    /// Both together, independent: 1σ RMS.
    pub fn total_rad(&self) -> f64 {
        self.input_rad.hypot(self.camera_rad)
    }
}

/// Variance of one frame's pixel: uniform jitter and uniform rounding.
pub fn centroid_variance_px2(camera: &CameraSettings) -> f64 {
    (camera.jitter_px.powi(2) + camera.centroid_step_px.powi(2)) / 12.0
}
