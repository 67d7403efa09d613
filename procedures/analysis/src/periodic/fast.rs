//! Odd and even distortion from one realisation, at lines that are not excited.

use super::error::{PeriodicError, ascending, within_range};
use super::ratio::{self, mean, rectangular};
use super::windows::enough;
use crate::frf::C64;

/// What a line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// Excited.
    Excited,
    /// Odd, left out: shows odd distortion.
    Odd,
    /// Even: shows even distortion.
    Even,
}

/// Output at a line that is not excited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionLine {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Odd or even.
    pub kind: LineKind,
    /// Mean output less G times the mean input there (an actuator that distorts excites such lines a little), in the
    /// unit of the output.
    pub level: C64,
    /// Variance of the level, E|·|², from the scatter between windows.
    pub variance: f64,
    /// Probability of such a level from noise alone: (1 + |level|²/(ν·var))^(−ν), ν = P − 1, the tail of F(2, 2ν).
    pub noise_probability: f64,
}

/// Distortion of a plant in one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct Distortion {
    /// All detection lines, ascending.
    pub lines: Vec<DetectionLine>,
    /// Odd distortion: rms of the odd lines' levels (noise taken off) over rms of the linear output at the excited
    /// lines, dB; −∞ if none stands out of the noise, `None` without such lines.
    pub odd_db: Option<f64>,
    /// Even distortion over the response, dB; `None` where no line shows it.
    pub even_db: Option<f64>,
    /// Noise of the mean, the same way, dB; −∞ if all windows agree.
    pub noise_db: f64,
}

impl DetectionLine {
    /// Whether the line stands out of the noise, at 1 % of false alarms.
    pub fn is_distorted(&self) -> bool {
        self.noise_probability < 0.01
    }
}

/// The fast method (Pintelon & Schoukens, *System Identification*, 2nd ed., §4.3.2): `lines` say what each column of
/// `u` and `y` (windows × lines, phases to one time: [`super::spectra`]) is for. G at a detection line is interpolated
/// between the excited neighbours.
///
/// # Errors
/// [`PeriodicError::TooFew`] below two windows, one excited or one detection line; [`PeriodicError::Length`],
/// [`PeriodicError::NotFinite`], [`PeriodicError::NotAscending`], [`PeriodicError::MissingReference`] where an excited
/// line has no input, [`PeriodicError::Silent`] where none has an output, [`PeriodicError::TooLarge`].
pub fn fast(lines: &[(f64, LineKind)], u: &[Vec<C64>], y: &[Vec<C64>]) -> Result<Distortion, PeriodicError> {
    enough(u.len())?;
    rectangular("input", lines.len(), u.len(), u)?;
    rectangular("output", lines.len(), u.len(), y)?;
    ascending(lines.iter().map(|l| l.0))?;
    let excited = excited_responses(lines, u, y)?;
    let detected: Vec<DetectionLine> = lines
        .iter()
        .enumerate()
        .filter(|(_, line)| line.1 != LineKind::Excited)
        .map(|(l, &(frequency_hz, kind))| {
            let g = interpolated(&excited, frequency_hz);
            let rests: Vec<C64> = (0..u.len()).map(|w| y[w][l] - g * u[w][l]).collect();
            detection_line(frequency_hz, kind, &rests)
        })
        .collect();
    if detected.is_empty() {
        return Err(PeriodicError::TooFew { what: "detection lines", expected: 1, found: 0 });
    }
    let linear = excited.iter().map(|e| e.2).sum::<f64>() / excited.len() as f64;
    let noise = detected.iter().map(|d| d.variance).sum::<f64>() / detected.len() as f64;
    let levels: f64 = detected.iter().map(|d| d.level.norm_sqr()).sum();
    within_range("output", linear + noise + levels)?;
    if linear <= 0.0 {
        return Err(PeriodicError::Silent);
    }
    Ok(Distortion {
        odd_db: ratio_db(&detected, LineKind::Odd, linear),
        even_db: ratio_db(&detected, LineKind::Even, linear),
        noise_db: 10.0 * (noise / linear).log10(),
        lines: detected,
    })
}

/// Frequency, response and power of the output at the excited lines.
fn excited_responses(
    lines: &[(f64, LineKind)],
    u: &[Vec<C64>],
    y: &[Vec<C64>],
) -> Result<Vec<(f64, C64, f64)>, PeriodicError> {
    let mut excited = vec![];
    for (l, &(frequency_hz, kind)) in lines.iter().enumerate() {
        if kind != LineKind::Excited {
            continue;
        }
        let input = mean(u, l);
        let output = mean(y, l);
        ratio::excited(frequency_hz, input)?;
        excited.push((frequency_hz, output / input, output.norm_sqr()));
    }
    if excited.is_empty() {
        return Err(PeriodicError::TooFew { what: "excited lines", expected: 1, found: 0 });
    }
    Ok(excited)
}

/// Response between excited lines, straight in the complex plane; the nearest beyond them.
fn interpolated(excited: &[(f64, C64, f64)], frequency_hz: f64) -> C64 {
    let above = excited.partition_point(|e| e.0 < frequency_hz);
    let high = excited[above.min(excited.len() - 1)];
    let low = excited[above.saturating_sub(1)];
    let span = high.0 - low.0;
    if span <= 0.0 {
        return high.1;
    }
    let part = ((frequency_hz - low.0) / span).clamp(0.0, 1.0);
    low.1 + (high.1 - low.1) * part
}

fn detection_line(frequency_hz: f64, kind: LineKind, rests: &[C64]) -> DetectionLine {
    let p = rests.len() as f64;
    let level = rests.iter().sum::<C64>() / p;
    let variance = rests.iter().map(|r| (r - level).norm_sqr()).sum::<f64>() / (p * (p - 1.0));
    let noise_probability = tail(level.norm_sqr(), variance, p - 1.0);
    DetectionLine { frequency_hz, kind, level, variance, noise_probability }
}

/// P(F > power/variance) for F(2, 2ν), in closed form.
pub(super) fn tail(power: f64, variance: f64, dof: f64) -> f64 {
    if variance > 0.0 {
        (1.0 + power / (variance * dof)).powf(-dof)
    } else if power > 0.0 {
        0.0
    } else {
        1.0
    }
}

fn ratio_db(lines: &[DetectionLine], kind: LineKind, linear: f64) -> Option<f64> {
    let own: Vec<f64> =
        lines.iter().filter(|l| l.kind == kind).map(|l| l.level.norm_sqr() - l.variance).collect();
    let power = own.iter().sum::<f64>() / own.len() as f64;
    (!own.is_empty()).then(|| 10.0 * (power.max(0.0) / linear).log10())
}
