//! Lines of a response: from whole periods, with what is known against each of them, and with a resonance of what the
//! mirror stands on as a local feature on an otherwise smooth response.

use std::f64::consts::TAU;

use analysis::frf::{C64, Line, unwrapped_rad};

use super::response::decibel;
use crate::measurement::Exclusion;

/// Degree of the polynomial over ln f that stands for the smooth response: a loop with a damping ratio of 0.35 or more
/// leaves 0.01 dB over two octaves (its pole lies 0.36 off the real axis of ln f).
const DEGREE: usize = 10;
/// Damping ratios that are tried: a support is lightly damped, and anything wider is the mirror itself.
const DAMPINGS: [f64; 4] = [0.005, 0.01, 0.02, 0.035];
/// Least variance ratio of the feature over what is left: −ln(10⁻⁹), so that the best of some hundred trials on mere
/// noise passes once in 10⁷.
const LEAST_RATIO: f64 = 20.0;
/// Least bend of the response that says something about a support, dB.
const LEAST_DB: f64 = 0.05;
/// Part of the range at each end in which no resonance is tried: there a polynomial is least bound.
const EDGE_RATIO: f64 = 1.1;
/// Lines nearer than this many half-power half widths belong to the feature.
const HALF_WIDTHS: f64 = 2.0;

/// Complex amplitudes X of X·e^(jωt) (t from the first sample) at whole numbers of periods in `samples`.
///
/// X = (2/N)·Σ x·e^(−j2πkn/N): exact for a record that holds whole periods only.
pub(super) fn amplitudes(samples: &[f64], orders: &[usize]) -> Vec<C64> {
    let n = samples.len();
    let mean = samples.iter().sum::<f64>() / n.max(1) as f64;
    let turns: Vec<C64> =
        (0..n).map(|k| C64::from_polar(2.0 / n as f64, -TAU * k as f64 / n as f64)).collect();
    let line = |&order: &usize| {
        samples.iter().enumerate().map(|(k, x)| turns[order * k % n] * (x - mean)).sum::<C64>()
    };
    orders.iter().map(line).collect()
}

/// Whether a line counts, or why not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LineQuality {
    /// The line counts.
    Counts,
    /// The mean of the line does not stand out of its own scatter.
    Noise,
    /// Above 0.4 of the row rate: images of the hold fold back.
    Fast,
    /// Next to a resonance of the support: the line belongs to what the mirror stands on.
    Reaction,
}

impl LineQuality {
    /// All reasons for which a line does not count, in the order of the report.
    const LEFT_OUT: [(Self, &'static str); 3] = [
        (Self::Noise, "signal too small compared with its scatter"),
        (Self::Fast, "above 0.4 of the row rate"),
        (Self::Reaction, "next to the resonance of the support"),
    ];
}

/// A line of the mirror's response, and whether it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MirrorLine {
    pub(super) line: Line,
    pub(super) quality: LineQuality,
}

impl MirrorLine {
    pub(super) fn counts(&self) -> bool {
        self.quality == LineQuality::Counts
    }
}

/// What was left out, by reason.
pub(super) fn exclusions(lines: &[MirrorLine]) -> Vec<Exclusion> {
    let mut all = Vec::new();
    for (quality, reason) in LineQuality::LEFT_OUT {
        let count = lines.iter().filter(|l| l.quality == quality).count();
        if count > 0 {
            all.push(Exclusion { count, of: "lines".to_owned(), reason: reason.to_owned() });
        }
    }
    all
}

/// A resonance of the support.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reaction {
    pub(super) frequency_hz: f64,
    /// Half of the distance between trials, and of the half-power width over the signal: type B.
    pub(super) u_hz: f64,
    pub(super) damping_ratio: f64,
    /// How far it bends the response at most, dB.
    pub(super) size_db: f64,
}

/// A resonance that was tried, and the power of ln G that it explains.
struct Trial {
    explained: f64,
    reaction: Reaction,
}

/// Looks for ln G = smooth + A·2ζ·jω·ω_r/(ω_r² − ω² + 2jζω_rω) between two frequencies: the trial that explains most,
/// if it explains far more than chance would. The smooth part is a polynomial with complex coefficients over ln f.
pub(super) fn find_reaction(lines: &[MirrorLine], range_hz: [f64; 2]) -> Option<Reaction> {
    let inside = |l: &&MirrorLine| {
        l.quality == LineQuality::Counts && (range_hz[0]..=range_hz[1]).contains(&l.line.frequency_hz)
    };
    let lines: Vec<&MirrorLine> = lines.iter().filter(inside).collect();
    let frequencies: Vec<f64> = lines.iter().map(|l| l.line.frequency_hz).collect();
    if frequencies.len() < 2 * DEGREE + 4 {
        return None;
    }
    let basis = polynomials(&frequencies);
    let whole = without(&basis, &logarithms(&lines));
    let total: f64 = whole.iter().map(C64::norm_sqr).sum();
    let mut best: Option<Trial> = None;
    let low_hz = range_hz[0] * EDGE_RATIO;
    let high_hz = range_hz[1] / EDGE_RATIO;
    for pair in frequencies.windows(2).filter(|pair| pair[0] >= low_hz && pair[1] <= high_hz) {
        for frequency_hz in [pair[0], 0.5 * (pair[0] + pair[1])] {
            for damping_ratio in DAMPINGS {
                let trial = without(&basis, &bend(&frequencies, frequency_hz, damping_ratio));
                let power: f64 = trial.iter().map(C64::norm_sqr).sum();
                let size = trial.iter().zip(&whole).map(|(t, w)| t.conj() * w).sum::<C64>() / power;
                let explained = size.norm_sqr() * power;
                if best.as_ref().is_none_or(|best| explained > best.explained) {
                    let u_hz = (0.25 * (pair[1] - pair[0])).hypot(0.1 * damping_ratio * frequency_hz);
                    let size_db = decibel(size.norm());
                    let reaction = Reaction { frequency_hz, u_hz, damping_ratio, size_db };
                    best = Some(Trial { explained, reaction });
                }
            }
        }
    }
    let Trial { explained, reaction } = best?;
    let dof = (frequencies.len() - DEGREE - 2) as f64;
    let left = (total - explained).max(f64::MIN_POSITIVE) / dof;
    (explained / left > LEAST_RATIO && reaction.size_db > LEAST_DB).then_some(reaction)
}

/// Takes the lines next to the resonance out of what counts.
pub(super) fn mark_reaction(lines: &mut [MirrorLine], reaction: &Reaction) {
    let reach_hz = HALF_WIDTHS * reaction.damping_ratio * reaction.frequency_hz;
    for line in lines.iter_mut().filter(|l| l.counts()) {
        if (line.line.frequency_hz - reaction.frequency_hz).abs() <= reach_hz {
            line.quality = LineQuality::Reaction;
        }
    }
}

/// ln G with its phase unwrapped.
fn logarithms(lines: &[&MirrorLine]) -> Vec<C64> {
    let plain: Vec<_> = lines.iter().map(|l| l.line).collect();
    let phases = unwrapped_rad(&plain);
    plain.iter().zip(phases).map(|(l, phase)| C64::new(l.value.norm().ln(), phase)).collect()
}

/// Orthonormal polynomials over ln f on the lines (Gram–Schmidt, twice for rounding).
fn polynomials(frequencies_hz: &[f64]) -> Vec<Vec<f64>> {
    let first = frequencies_hz[0].ln();
    let last = frequencies_hz[frequencies_hz.len() - 1].ln();
    let x = |f: &f64| 2.0 * (f.ln() - first) / (last - first) - 1.0;
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(DEGREE + 1);
    for degree in 0..=DEGREE {
        let mut column: Vec<f64> = frequencies_hz.iter().map(|f| x(f).powi(degree as i32)).collect();
        for _ in 0..2 {
            for q in &basis {
                let part: f64 = q.iter().zip(&column).map(|(q, c)| q * c).sum();
                column.iter_mut().zip(q).for_each(|(c, q)| *c -= part * q);
            }
        }
        let norm = column.iter().map(|c| c * c).sum::<f64>().sqrt();
        column.iter_mut().for_each(|c| *c /= norm);
        basis.push(column);
    }
    basis
}

/// What the polynomials leave.
fn without(basis: &[Vec<f64>], values: &[C64]) -> Vec<C64> {
    let mut rest = values.to_vec();
    for q in basis {
        let part: C64 = q.iter().zip(&rest).map(|(q, r)| r * *q).sum();
        rest.iter_mut().zip(q).for_each(|(r, q)| *r -= part * *q);
    }
    rest
}

/// The bend of a resonance, 1 at its peak.
fn bend(frequencies_hz: &[f64], resonance_hz: f64, damping_ratio: f64) -> Vec<C64> {
    let bend = |f: &f64| {
        let damped = C64::new(0.0, 2.0 * damping_ratio * f * resonance_hz);
        damped / (C64::new(resonance_hz * resonance_hz - f * f, 0.0) + damped)
    };
    frequencies_hz.iter().map(bend).collect()
}
