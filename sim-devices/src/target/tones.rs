//! Coloured random motion as a sum of tones with addressed phases: a pure, smooth function.

use std::f64::consts::TAU;

use crate::physics::noise::{Noise, SeedAddress};

/// Tones of one source.
const COUNT: u32 = 16;

#[derive(Clone, Copy, Debug)]
struct Tone {
    per_unit_rad: f64,
    phase_rad: f64,
    amplitude: f64,
}

/// A random function of time or place. Its rate has equal power in equal ratios of frequency (PSD ∝ 1/f).
#[derive(Clone, Debug)]
pub(super) struct Tones(Vec<Tone>);

impl Tones {
    /// Tones within a band in cycles per unit of the argument; `deviation` is the standard deviation of the *rate*.
    pub(super) fn new(address: &SeedAddress, source: &str, band: [f64; 2], deviation: f64) -> Self {
        let mut draw = uniform(address, source);
        let ratio = band[1] / band[0];
        let rate_amplitude = deviation * (2.0 / f64::from(COUNT)).sqrt();
        let tones = (0..COUNT).map(|k| {
            // One tone anywhere in each of equal ratios: lines that never fall together.
            let place = (f64::from(k) + draw(2 * u64::from(k))) / f64::from(COUNT);
            let per_unit_rad = TAU * band[0] * ratio.powf(place);
            let phase_rad = TAU * draw(2 * u64::from(k) + 1);
            Tone { per_unit_rad, phase_rad, amplitude: rate_amplitude / per_unit_rad }
        });
        Self(tones.collect())
    }

    /// Value and rate at a place or time.
    pub(super) fn at(&self, argument: f64) -> (f64, f64) {
        self.0.iter().fold((0.0, 0.0), |(value, rate), tone| {
            let (sine, cosine) = (tone.per_unit_rad * argument + tone.phase_rad).sin_cos();
            (value + tone.amplitude * sine, rate + tone.amplitude * tone.per_unit_rad * cosine)
        })
    }
}

/// Uniform in 0 to 1: the angle of two independent Gaussians.
fn uniform(address: &SeedAddress, source: &str) -> impl FnMut(u64) -> f64 + use<> {
    let mut noise = Noise::new(address, source, 1.0);
    move |index| 0.5 + noise.at(2 * index).atan2(noise.at(2 * index + 1)) / TAU
}
