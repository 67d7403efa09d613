//! What is added to a command in order to see a response: a pure function of time since its start.

use std::f64::consts::TAU;

pub use analysis::excitation::Sine;
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

/// A signal over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Signal {
    /// A sum of cosines.
    Multisine {
        /// After this time all of it repeats; a whole number of ticks.
        period_s: f64,
        /// Lines of the sum, each a multiple of 1/period.
        lines: Vec<Sine>,
    },
    /// A sine whose frequency moves from one end to the other, again and again.
    Sweep {
        /// Frequency at the start.
        from_hz: f64,
        /// Frequency at the end.
        to_hz: f64,
        /// Time that it takes; then it starts again.
        duration_s: f64,
        /// Whether frequency grows exponentially with time.
        logarithmic: bool,
        /// Amplitude.
        amplitude: f64,
    },
    /// Sines one after the other.
    Stepped {
        /// The sines, with the time that each lasts.
        steps: Vec<Step>,
    },
    /// A square wave: 0, then the amplitude, half a period each.
    Square {
        /// Amplitude of the upper half.
        amplitude: f64,
        /// Period.
        period_s: f64,
    },
}

/// A sine of a stepped signal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Frequency.
    pub frequency_hz: f64,
    /// Amplitude.
    pub amplitude: f64,
    /// How long it lasts.
    pub for_s: f64,
}

/// Where a signal is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Injection {
    /// To the motor torque behind the velocity loop, N·m.
    Torque,
    /// To the command of the velocity loop, rad/s.
    Velocity,
    /// To the tilt command of the mirror about azimuth, rad.
    MirrorAz,
    /// To the tilt command of the mirror about elevation, rad.
    MirrorEl,
}

/// A signal with the place where it is added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Excitation {
    /// Where.
    pub into: Injection,
    /// What.
    pub signal: Signal,
    /// Over this time after its start it grows linearly to its full size.
    pub fade_s: f64,
    /// Only every so many ticks it takes a new value, as a slower computer would; 1 for every tick.
    pub every_ticks: u32,
}

impl Excitation {
    /// Value at `t_s` after its start, in the unit of its place; 0 before.
    pub fn at(&self, t_s: f64) -> f64 {
        if t_s < 0.0 {
            return 0.0;
        }
        let fade = if self.fade_s > 0.0 { (t_s / self.fade_s).min(1.0) } else { 1.0 };
        fade * self.signal.at(t_s)
    }

    /// Most that the signal can reach.
    pub fn peak(&self) -> f64 {
        self.signal.peak()
    }
}

impl Signal {
    /// Value at a time from 0 on.
    pub fn at(&self, t_s: f64) -> f64 {
        match self {
            Self::Multisine { lines, .. } => {
                lines.iter().map(|l| l.amplitude * (TAU * l.frequency_hz * t_s + l.phase_rad).cos()).sum()
            }
            Self::Sweep { from_hz, to_hz, duration_s, logarithmic, amplitude } => {
                let t_s = t_s % duration_s;
                let turns = if *logarithmic {
                    let octaves = (to_hz / from_hz).ln();
                    from_hz * duration_s / octaves * ((octaves * t_s / duration_s).exp() - 1.0)
                } else {
                    from_hz * t_s + 0.5 * (to_hz - from_hz) * t_s * t_s / duration_s
                };
                amplitude * (TAU * turns).sin()
            }
            Self::Stepped { steps } => {
                let mut rest_s = t_s;
                for step in steps {
                    if rest_s < step.for_s {
                        return step.amplitude * (TAU * step.frequency_hz * rest_s).sin();
                    }
                    rest_s -= step.for_s;
                }
                0.0
            }
            Self::Square { amplitude, period_s } => {
                if (t_s / period_s).fract() < 0.5 {
                    0.0
                } else {
                    *amplitude
                }
            }
        }
    }

    /// Upper bound of its magnitude.
    pub fn peak(&self) -> f64 {
        match self {
            Self::Multisine { period_s, lines } => multisine_peak(*period_s, lines),
            Self::Sweep { amplitude, .. } | Self::Square { amplitude, .. } => amplitude.abs(),
            Self::Stepped { steps } => steps.iter().map(|s| s.amplitude.abs()).fold(0.0, f64::max),
        }
    }

    /// What the search for its peak costs: samples times lines.
    pub fn peak_work(&self) -> f64 {
        match self {
            Self::Multisine { period_s, lines } => grid_samples(*period_s, lines) * lines.len() as f64,
            _ => 0.0,
        }
    }

    /// Upper bound of the magnitude of its integral over time, less its mean.
    pub fn integral_peak(&self) -> f64 {
        let integrated =
            |s: &Sine| Sine { amplitude: s.amplitude / (TAU * s.frequency_hz), phase_rad: s.phase_rad, ..*s };
        let sines = self.sines();
        match self {
            Self::Multisine { period_s, .. } => {
                multisine_peak(*period_s, &sines.iter().map(integrated).collect::<Vec<_>>())
            }
            _ => sines.iter().map(|s| integrated(s).amplitude.abs()).fold(0.0, f64::max),
        }
    }

    /// Root mean square while it lasts.
    pub fn rms(&self) -> f64 {
        match self {
            Self::Multisine { lines, .. } => {
                lines.iter().map(|l| 0.5 * l.amplitude * l.amplitude).sum::<f64>().sqrt()
            }
            _ => self.peak() / 2.0_f64.sqrt(),
        }
    }

    /// Amplitudes with their frequencies, the lowest frequency of each where it moves.
    pub fn sines(&self) -> Vec<Sine> {
        let sine = |frequency_hz, amplitude| Sine { frequency_hz, amplitude, phase_rad: 0.0 };
        match self {
            Self::Multisine { lines, .. } => lines.clone(),
            Self::Sweep { from_hz, to_hz, amplitude, .. } => vec![sine(from_hz.min(*to_hz), *amplitude)],
            Self::Stepped { steps } => steps.iter().map(|s| sine(s.frequency_hz, s.amplitude)).collect(),
            Self::Square { amplitude, period_s } => vec![sine(1.0 / period_s, *amplitude)],
        }
    }
}

/// Samples of the grid on which a peak is searched, sixteen per period of the highest line; 0 where the grid would be too
/// large for a search.
fn grid_samples(period_s: f64, lines: &[Sine]) -> f64 {
    const PER_PERIOD: f64 = 16.0;
    // Enough for every plan.
    const MOST: f64 = 2e5;
    const MOST_WORK: f64 = 4e8;
    let highest_hz = lines.iter().map(|l| l.frequency_hz).fold(0.0, f64::max);
    let samples = (PER_PERIOD * highest_hz * period_s).ceil();
    let searched = (1.0..=MOST).contains(&samples) && samples * lines.len() as f64 <= MOST_WORK;
    if searched { samples } else { 0.0 }
}

/// Largest magnitude on a grid of sixteen samples per period of the highest line, and what may lie between two samples:
/// by Bernstein's inequality |x''| ≤ ω²·peak, so at most a share (ωh/2)²/2 of the peak, 1.9 %. Where the grid is too large
/// the sum of the amplitudes bounds it, too.
fn multisine_peak(period_s: f64, lines: &[Sine]) -> f64 {
    const BETWEEN: f64 = 1.02;
    let sum: f64 = lines.iter().map(|l| l.amplitude.abs()).sum();
    let samples = grid_samples(period_s, lines);
    if samples == 0.0 {
        return sum;
    }
    // Phasors that turn from sample to sample: a cosine each would be most of the time that planning takes.
    let mut turning: Vec<[Complex<f64>; 2]> = lines
        .iter()
        .map(|l| {
            let step_rad = TAU * l.frequency_hz * period_s / samples;
            [Complex::from_polar(l.amplitude, l.phase_rad), Complex::from_polar(1.0, step_rad)]
        })
        .collect();
    let mut next = || -> f64 {
        let sum: f64 = turning.iter().map(|[now, _]| now.re).sum();
        turning.iter_mut().for_each(|[now, step]| *now *= *step);
        sum.abs()
    };
    (BETWEEN * (0..samples as u32).map(|_| next()).fold(0.0, f64::max)).min(sum)
}

#[cfg(test)]
mod tests;
