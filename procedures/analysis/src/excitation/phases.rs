//! Phases of a multisine, and its values over a period.

use std::f64::consts::TAU;
use std::sync::Arc;

use fourier::{ComplexToReal, RealToComplex};

use super::Multisine;
use crate::frf::C64;

/// Rounds of clipping.
const ROUNDS: usize = 400;
/// First and last clip level, as a part of the peak: the peak creeps down, so the clip must get gentler.
const CLIP: [f64; 2] = [0.80, 0.995];

/// How the phases are chosen.
pub enum Phases<'a> {
    /// Uniform, from random numbers 0…1: what the robust method needs, one draw a realisation.
    Random(&'a mut dyn FnMut() -> f64),
    /// Phases that spread the power of the lines evenly over the period (Schroeder, *IEEE Trans. Inf. Theory* 16,
    /// 85, 1970).
    Schroeder,
    /// From Schroeder's on, rounds of clipping in time and restoring the amplitudes (Van der Ouderaa, Schoukens &
    /// Renneboog, *IEEE Trans. Instrum. Meas.* 37, 145, 1988); the round with the lowest peak counts.
    Compressed,
}

/// Sets the phases of all lines.
pub(super) fn set(multisine: &mut Multisine, phases: Phases<'_>) {
    match phases {
        Phases::Random(random) => multisine.lines.iter_mut().for_each(|l| l.phase_rad = TAU * random()),
        Phases::Schroeder => schroeder(multisine),
        Phases::Compressed => {
            schroeder(multisine);
            compress(multisine);
        }
    }
}

/// The group delay of a line is the part of the power below it, in periods: φ falls from line to line by
/// 2π·(power so far)·(lines between), lines counted in the largest step that all share.
fn schroeder(multisine: &mut Multisine) {
    let harmonics = harmonics(multisine);
    let first = harmonics.first().copied().unwrap_or(0);
    let step = harmonics.iter().fold(0, |g, h| gcd(g, h - first)).max(1);
    let total: f64 = multisine.lines.iter().map(|l| l.amplitude * l.amplitude).sum();
    let mut phase = 0.0;
    let mut power = 0.0;
    let mut last = first;
    for (line, h) in multisine.lines.iter_mut().zip(harmonics) {
        phase -= TAU * power * ((h - last) / step) as f64;
        line.phase_rad = phase.rem_euclid(TAU);
        power += line.amplitude * line.amplitude / total;
        last = h;
    }
}

fn compress(multisine: &mut Multisine) {
    // With 4 points a period the peaks fall between the samples, and 60 flat lines end at 1.69 instead of 1.48.
    let synthesis = Synthesis::new(multisine, 8);
    let mut best = (f64::INFINITY, multisine.clone());
    for round in 0..ROUNDS {
        let mut values = synthesis.period(multisine);
        let peak = values.iter().fold(0.0_f64, |p, v| p.max(v.abs()));
        if peak < best.0 {
            best = (peak, multisine.clone());
        }
        let part = round as f64 / (ROUNDS - 1) as f64;
        let limit = peak * (CLIP[0] + (CLIP[1] - CLIP[0]) * part);
        values.iter_mut().for_each(|v| *v = v.clamp(-limit, limit));
        let spectrum = synthesis.spectrum(&mut values);
        for (line, &bin) in multisine.lines.iter_mut().zip(&synthesis.bins) {
            line.phase_rad = spectrum[bin].arg().rem_euclid(TAU);
        }
    }
    *multisine = best.1;
}

/// Harmonics of one over the period.
fn harmonics(multisine: &Multisine) -> Vec<usize> {
    multisine.lines.iter().map(|l| (l.frequency_hz * multisine.period_s).round() as usize).collect()
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Transforms between the lines and one sampled period.
pub(super) struct Synthesis {
    bins: Vec<usize>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    forward: Arc<dyn RealToComplex<f64>>,
}

impl Synthesis {
    /// With at least `points` samples a period of the highest line.
    pub(super) fn new(multisine: &Multisine, points: usize) -> Self {
        let bins = harmonics(multisine);
        let length = (points * (bins.last().copied().unwrap_or(0) + 1)).next_power_of_two();
        Self { bins, inverse: fourier::inverse(length), forward: fourier::forward(length) }
    }

    /// Values over one period.
    pub(super) fn period(&self, multisine: &Multisine) -> Vec<f64> {
        let mut spectrum = self.inverse.make_input_vec();
        for (line, &bin) in multisine.lines.iter().zip(&self.bins) {
            spectrum[bin] += C64::from_polar(0.5 * line.amplitude, line.phase_rad);
        }
        // The transform reads only the real part of the line at 0.
        spectrum[0] = C64::new(2.0 * spectrum[0].re, 0.0);
        let mut values = self.inverse.make_output_vec();
        self.inverse.process(&mut spectrum, &mut values).expect("both lengths come from the plan");
        values
    }

    fn spectrum(&self, values: &mut [f64]) -> Vec<C64> {
        let mut spectrum = self.forward.make_output_vec();
        self.forward.process(values, &mut spectrum).expect("both lengths come from the plan");
        spectrum
    }
}
