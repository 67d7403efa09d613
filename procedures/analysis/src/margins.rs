//! Margins of a loop from its measured open loop: all crossings, the distance to −1, the disk, each with uncertainty.
//!
//! Sign convention: unity negative feedback, so −1 is the critical point. Between the lines L is read from local fits of
//! complex L, never from the nearest line.

use super::frf::{C64, Frf, Line};

mod certify;
mod check;
mod closed;
mod crossing;
mod curve;
mod local;
mod nearest;
mod peak;
mod solve;
mod stability;
#[cfg(test)]
mod tests;

pub use certify::Doubt;
pub use closed::{Bandwidth, bandwidth, open_loop_from_closed};
pub use crossing::{Kind, NoCrossing};
pub use nearest::{DiskMargin, Nearest};
pub use peak::{Peak, peak};

/// Fewest lines of an open loop.
pub const LEAST_LINES: usize = 5;

/// What must be known beside the lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Poles of the open loop at s = 0.
    pub integrators_count: u32,
    /// Poles of the open loop in the right half plane.
    pub unstable_poles_count: u32,
    /// Probability of the circles that must not reach −1.
    pub probability: f64,
    /// Least coherence of the lines on both sides of a crossing.
    pub least_coherence: f64,
}

impl Default for Settings {
    /// One integrator, no unstable pole, circles of 95 %, coherence 0.8 (u of one average about 0.35 in |L|).
    fn default() -> Self {
        Self { integrators_count: 1, unstable_poles_count: 0, probability: 0.95, least_coherence: 0.8 }
    }
}

/// Why there are no margins.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MarginError {
    /// Too few lines to fit anything.
    #[error("{found} lines; at least {LEAST_LINES} are needed: excite more frequencies")]
    TooFewLines {
        /// Lines given.
        found: usize,
    },
    /// A number that is none.
    #[error(
        "line {line}: frequency, value, variance, degrees of freedom or coherence is not a number in its range"
    )]
    NotFinite {
        /// Index of the line.
        line: usize,
    },
    /// The frequencies must ascend and be positive.
    #[error(
        "line {line}: {found_hz} Hz, expected more than {before_hz} Hz: sort the lines and keep each frequency once"
    )]
    NotAscending {
        /// Index of the line.
        line: usize,
        /// Frequency of the line before, 0 at the first, Hz.
        before_hz: f64,
        /// Frequency of the line, Hz.
        found_hz: f64,
    },
    /// A line without response: its logarithm does not exist.
    #[error("line {line}: the response is 0: leave out lines without excitation")]
    NoResponse {
        /// Index of the line.
        line: usize,
    },
    /// Some lines exact, some not.
    #[error(
        "line {line}: variance {found}, but other lines have a variance: either all lines must be exact or none"
    )]
    MixedVariance {
        /// First line of variance 0.
        line: usize,
        /// Variance of the line.
        found: f64,
    },
    /// A setting outside its range.
    #[error(
        "probability {probability} and least coherence {least_coherence}: expected 0 < p < 1 and 0 ≤ γ² ≤ 1"
    )]
    Settings {
        /// Given probability.
        probability: f64,
        /// Given least coherence.
        least_coherence: f64,
    },
    /// The closed loop has poles in the right half plane: margins of it mean nothing.
    #[error("unstable: the closed loop has {poles_count} poles in the right half plane (Nyquist count)")]
    Unstable {
        /// Number of such poles.
        poles_count: u32,
    },
    /// The locus does not close inside the band, so nothing can be counted.
    #[error(
        "stability not decided: |L| is {gain} at the last line, {at_hz} Hz: extend the measurement until \
         it is below 1"
    )]
    BandTooShort {
        /// |L| at the last line.
        gain: f64,
        /// Frequency of the line, Hz.
        at_hz: f64,
    },
    /// Encirclements that no loop with these open-loop poles can have.
    #[error(
        "the locus turns {turns} times around −1, impossible with the given integrators and unstable poles: check these, the sign of L and the lowest lines"
    )]
    Count {
        /// Turns of 1 + L from 0 to ∞, counter-clockwise, in half turns.
        turns: f64,
    },
    /// A static gain that is none.
    #[error("static gain {found}: expected a positive number")]
    StaticGain {
        /// Given gain.
        found: f64,
    },
    /// There is no crossing, so there is no number.
    #[error(transparent)]
    NoCrossing(#[from] NoCrossing),
    /// T = 1 makes L infinite.
    #[error("line {line}: closed loop of exactly 1: L = T/(1 − T) does not exist")]
    NoOpenLoop {
        /// Index of the line.
        line: usize,
    },
}

/// |L| = 1: a 0 dB crossing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainCrossing {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Standard uncertainty of `frequency_hz`, Hz.
    pub frequency_u_hz: f64,
    /// Angle of L above −180°, rad, −π…π.
    pub phase_margin_rad: f64,
    /// Standard uncertainty of `phase_margin_rad`, rad: √(var φ + (dφ/dln|L|)²·var ln|L|), and what the fits differ in.
    pub phase_margin_u_rad: f64,
    /// Delay that brings L to −1 here, s: margin (of a whole turn if it is negative) over angular frequency.
    pub delay_margin_s: f64,
    /// Standard uncertainty of `delay_margin_s`, s.
    pub delay_margin_u_s: f64,
    /// d ln|L|/d ln f: negative where |L| falls.
    pub slope: f64,
    /// |L| falls with frequency.
    pub falling: bool,
}

/// ∠L = −180°.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseCrossing {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Standard uncertainty of `frequency_hz`, Hz.
    pub frequency_u_hz: f64,
    /// −20·log₁₀|L|, dB: positive is the gain that may be added, negative the gain that may be taken away.
    pub gain_margin_db: f64,
    /// Standard uncertainty of `gain_margin_db`, dB.
    pub gain_margin_u_db: f64,
    /// Im L rises through 0 with frequency: the phase falls through −180°.
    pub upwards: bool,
}

/// What a closed loop has in reserve.
#[derive(Clone, Debug, PartialEq)]
pub struct Margins {
    /// First and last frequency looked at, Hz.
    pub band_hz: [f64; 2],
    /// All 0 dB crossings, ascending.
    pub gain_crossings: Vec<GainCrossing>,
    /// All −180° crossings, ascending.
    pub phase_crossings: Vec<PhaseCrossing>,
    /// Least |1 + L|: the modulus margin.
    pub modulus: Nearest,
    /// The disk margin of balanced skew.
    pub disk: DiskMargin,
    /// Why the margins are not certified; empty if they are.
    pub doubts: Vec<Doubt>,
}

impl Margins {
    /// The smallest phase margin.
    ///
    /// # Errors
    /// Nothing crosses 0 dB in the band.
    pub fn phase_margin(&self) -> Result<&GainCrossing, NoCrossing> {
        let size = |c: &&GainCrossing| c.phase_margin_rad.abs();
        let least = self.gain_crossings.iter().min_by(|a, b| size(a).total_cmp(&size(b)));
        least.ok_or_else(|| self.none(Kind::Gain))
    }

    /// The lowest 0 dB crossing at which |L| falls: the open-loop bandwidth.
    ///
    /// # Errors
    /// Nothing falls through 0 dB in the band.
    pub fn bandwidth(&self) -> Result<&GainCrossing, NoCrossing> {
        self.gain_crossings.iter().find(|c| c.falling).ok_or_else(|| self.none(Kind::Gain))
    }

    /// The smallest delay margin.
    ///
    /// # Errors
    /// Nothing crosses 0 dB in the band.
    pub fn delay_margin(&self) -> Result<&GainCrossing, NoCrossing> {
        let least = self.gain_crossings.iter().min_by(|a, b| a.delay_margin_s.total_cmp(&b.delay_margin_s));
        least.ok_or_else(|| self.none(Kind::Gain))
    }

    /// The smallest increasing gain margin (positive dB).
    ///
    /// # Errors
    /// No −180° crossing with |L| < 1 in the band.
    pub fn gain_margin(&self) -> Result<&PhaseCrossing, NoCrossing> {
        let above = self.phase_crossings.iter().filter(|c| c.gain_margin_db > 0.0);
        let least = above.min_by(|a, b| a.gain_margin_db.total_cmp(&b.gain_margin_db));
        least.ok_or_else(|| self.none(Kind::Phase))
    }

    fn none(&self, kind: Kind) -> NoCrossing {
        NoCrossing { kind, from_hz: self.band_hz[0], to_hz: self.band_hz[1] }
    }
}

/// Margins of the closed loop whose open loop was measured: `loop_` in ascending frequency, 20 to 300 lines.
///
/// Definitions: Åström & Murray, *Feedback Systems*, §10.3; disk margin: Seiler, Packard & Gahinet, *IEEE Control
/// Systems* 40(5), 2020. The uncertainties hold for variances that are right; lines of variance 0 are taken as exact.
///
/// # Errors
/// Input that is no open loop, or a closed loop that is not stable; see [`MarginError`].
pub fn margins(loop_: &[Line], settings: &Settings) -> Result<Margins, MarginError> {
    check::lines(loop_)?;
    check::settings(settings)?;
    stability::check(loop_, settings)?;
    let gain_crossings = crossing::gain(loop_);
    let phase_crossings = crossing::phase(loop_);
    let found =
        gain_crossings.iter().map(|c| c.frequency_hz).chain(phase_crossings.iter().map(|c| c.frequency_hz));
    let doubts = certify::doubts(loop_, settings, &found.collect::<Vec<_>>());
    Ok(Margins {
        band_hz: [loop_[0].frequency_hz, loop_[loop_.len() - 1].frequency_hz],
        gain_crossings,
        phase_crossings,
        modulus: nearest::modulus(loop_),
        disk: nearest::disk(loop_),
        doubts,
    })
}
