//! Between open and closed loop.

use super::crossing::{Kind, NoCrossing, gain};
use super::{Frf, Line, MarginError, check};

/// Where a closed loop falls below its static gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth {
    /// −3 dB frequency (1/√2 of the static gain), Hz.
    pub frequency_hz: f64,
    /// Standard uncertainty of `frequency_hz`, Hz; that of a measured static gain is in it.
    pub u_hz: f64,
    /// Static gain it refers to.
    pub static_gain: f64,
}

/// First frequency where |T| falls to 1/√2 of its static gain: of `static_gain`, or of the first line if `None` (then
/// the first line must lie far below the bandwidth; its uncertainty counts).
///
/// # Errors
/// Lines that are none, a static gain that is not positive, or no such frequency in the band.
pub fn bandwidth(closed: &[Line], static_gain: Option<f64>) -> Result<Bandwidth, MarginError> {
    check::lines(closed)?;
    let first = &closed[0];
    let (gain_ratio, relative_u) =
        static_gain.map_or((first.value.norm(), first.relative_sd()), |g| (g, 0.0));
    if !(gain_ratio.is_finite() && gain_ratio > 0.0) {
        return Err(MarginError::StaticGain { found: gain_ratio });
    }
    let level = gain_ratio * std::f64::consts::FRAC_1_SQRT_2;
    let scaled = |l: &Line| Line { value: l.value / level, variance: l.variance / (level * level), ..*l };
    let scaled: Vec<Line> = closed.iter().map(scaled).collect();
    let crossings = gain(&scaled);
    let found = crossings.iter().find(|c| c.falling).ok_or(NoCrossing {
        kind: Kind::Level,
        from_hz: first.frequency_hz,
        to_hz: closed[closed.len() - 1].frequency_hz,
    })?;
    let of_gain = relative_u * found.frequency_hz / found.slope.abs();
    let u_hz = found.frequency_u_hz.hypot(of_gain);
    Ok(Bandwidth { frequency_hz: found.frequency_hz, u_hz, static_gain: gain_ratio })
}

/// L = T/(1 − T) of a unity-feedback closed loop, variance |1/(1 − T)²|²·var (the study prints its inverse).
///
/// # Errors
/// Lines that are none, or T = 1.
pub fn open_loop_from_closed(closed: &[Line]) -> Result<Frf, MarginError> {
    check::lines(closed)?;
    let open = |(k, line): (usize, &Line)| {
        let apart = 1.0 - line.value;
        if apart.norm() <= 0.0 {
            return Err(MarginError::NoOpenLoop { line: k });
        }
        let variance = line.variance / apart.norm_sqr().powi(2);
        Ok(Line { value: line.value / apart, variance, ..*line })
    };
    closed.iter().enumerate().map(open).collect()
}
