//! Reasons not to certify margins.

use super::stability::step_seen_from;
use super::{C64, Line, Settings};

/// Turn between neighbouring lines, seen from −1, from which something may lie between them unseen, rad.
const MOST_STEP_RAD: f64 = 1.2;

/// Why margins are numbers but not certified.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Doubt {
    /// The confidence circle of a line reaches −1: the loop may be unstable.
    #[error("the confidence circle at {frequency_hz} Hz, radius {radius}, reaches −1 ({distance} away)")]
    CircleReachesCritical {
        /// Line, Hz.
        frequency_hz: f64,
        /// Radius of the circle.
        radius: f64,
        /// |1 + L|.
        distance: f64,
    },
    /// The coherence beside a crossing is too low.
    #[error("coherence {coherence} at {frequency_hz} Hz beside a crossing, at least {least} is needed")]
    Coherence {
        /// Line, Hz.
        frequency_hz: f64,
        /// Coherence of the line.
        coherence: f64,
        /// The least that is taken.
        least: f64,
    },
    /// Between two lines the locus turns far around −1: a resonance may hide between them.
    #[error(
        "L turns {step_rad} rad around −1 between {from_hz} and {to_hz} Hz: use more closely spaced lines there"
    )]
    Coarse {
        /// Line before, Hz.
        from_hz: f64,
        /// Line after, Hz.
        to_hz: f64,
        /// Turn, rad.
        step_rad: f64,
    },
}

/// All doubts, by kind and frequency.
pub(super) fn doubts(lines: &[Line], settings: &Settings, crossings_hz: &[f64]) -> Vec<Doubt> {
    let critical = C64::from(-1.0);
    let circles = lines.iter().filter_map(|line| {
        let radius = line.circle_radius(settings.probability);
        let distance = (line.value - critical).norm();
        let reaches = line.variance > 0.0 && (radius.is_nan() || radius >= distance);
        let doubt = Doubt::CircleReachesCritical { frequency_hz: line.frequency_hz, radius, distance };
        reaches.then_some(doubt)
    });
    let coherences = lines.iter().enumerate().filter_map(|(k, line)| {
        let coherence = line.coherence.filter(|c| *c < settings.least_coherence)?;
        let low = lines[k.saturating_sub(1)].frequency_hz;
        let high = lines[(k + 1).min(lines.len() - 1)].frequency_hz;
        let beside = crossings_hz.iter().any(|hz| (low..=high).contains(hz));
        let least = settings.least_coherence;
        beside.then_some(Doubt::Coherence { frequency_hz: line.frequency_hz, coherence, least })
    });
    let steps = lines.windows(2).filter_map(|pair| {
        let step_rad = step_seen_from(critical, pair);
        let from_hz = pair[0].frequency_hz;
        let to_hz = pair[1].frequency_hz;
        (step_rad > MOST_STEP_RAD).then_some(Doubt::Coarse { from_hz, to_hz, step_rad })
    });
    circles.chain(coherences).chain(steps).collect()
}
