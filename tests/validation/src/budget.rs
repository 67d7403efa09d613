//! What the fine tracker must leave: rejection times spectrum of what disturbs it, and its own camera's noise.
//!
//! One integrator per camera frame, its command held until the next: with τ from true motion to obeyed command, Ts the
//! frame, K the gain and n the whole frames that τ needs (what a frame shows of the mirror is n commands old),
//! `S(jω) = 1 − (K/jω)·e^(−jωτ)/(1 + L)`, `L = K·Ts·z^(−n)/(1 − z^(−1))`, `z = e^(jωTs)`,
//! exact for inputs below half the frame rate. For slow ones it is `1/(1 + K·e^(−jωτ)/jω)`: the half frame of hold is
//! made up for by the integrator, which counts the newest frame in full.

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use sim_devices::unit::CameraSettings;

use crate::spectrum::Spectrum;

/// Fine track loop as designed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorLoop {
    /// K, 1/s.
    pub gain_per_s: f64,
    /// τ: message, command and mirror, without any hold.
    pub delay_s: f64,
    /// Ts.
    pub frame_s: f64,
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
    /// The loop whose rejection crosses 0 dB at a frequency below that of the delay's half turn.
    pub fn crossing(frequency_hz: f64, delay_s: f64, frame_s: f64) -> Self {
        let with = |gain_per_s| Self { gain_per_s, delay_s, frame_s };
        // More gain rejects more below the crossing; `2ω·sin ωτ` is the answer without sampling.
        let omega = TAU * frequency_hz;
        let continuous = 2.0 * omega * (omega * delay_s).sin();
        let mut low = 0.3 * continuous;
        let mut high = 1.5 * continuous;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if with(middle).rejection(frequency_hz) > 1.0 { low = middle } else { high = middle }
        }
        with(low)
    }

    /// |S|² at a frequency above 0.
    pub fn rejection(&self, frequency_hz: f64) -> f64 {
        let half_turn = 0.5 * TAU * frequency_hz * self.frame_s;
        let [re, im] = self.closed(frequency_hz);
        // (K/jω)(1 − z⁻¹) = K·Ts·e^(−jωTs/2)·sin(ωTs/2)/(ωTs/2)
        let size = half_turn.sin() / half_turn;
        let (sine, cosine) = (TAU * frequency_hz * self.delay_s + half_turn).sin_cos();
        let corrected = [size * (re * cosine + im * sine), size * (im * cosine - re * sine)];
        (1.0 - corrected[0]).powi(2) + corrected[1].powi(2)
    }

    /// Power gain from a frame's error to the correction made.
    pub fn transmission(&self, frequency_hz: f64) -> f64 {
        let [re, im] = self.closed(frequency_hz);
        re * re + im * im
    }

    /// `K·Ts/(1 − z⁻¹ + K·Ts·z⁻ⁿ)`, real and imaginary part.
    fn closed(&self, frequency_hz: f64) -> [f64; 2] {
        let gain = self.gain_per_s * self.frame_s;
        let turn = TAU * frequency_hz * self.frame_s;
        // A hair less, so that rounding does not cost a frame.
        let frames = (self.delay_s / self.frame_s - 1e-9).ceil();
        let ((sine, cosine), (late_sine, late_cosine)) = (turn.sin_cos(), (frames * turn).sin_cos());
        let [re, im] = [1.0 - cosine + gain * late_cosine, sine - gain * late_sine];
        let size = gain / (re * re + im * im);
        [size * re, -size * im]
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
        let rate_hz = 1.0 / self.frame_s;
        // White up to half the frame rate; that the mirror holds each command leaves its mean square as it is.
        let noise_psd = 2.0 * centroid_variance_px2(camera) * ifov_rad * ifov_rad / rate_hz;
        let width_hz = 0.01;
        let bins = (0.5 * rate_hz / width_hz) as u32;
        let power: f64 = (1..=bins).map(|k| self.transmission(width_hz * f64::from(k))).sum();
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
