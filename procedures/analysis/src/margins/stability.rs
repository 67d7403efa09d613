//! Nyquist count over the measured band.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{C64, Line, MarginError, Settings};

/// Distance of the count from a whole number that is still one.
const WHOLE: f64 = 0.1;

/// Counts the closed loop's poles in the right half plane.
///
/// From ω = 0⁺ to ∞ arg(1 + L) turns by π·(P − Z) + (π/2)·n with P unstable open-loop poles, Z unstable closed-loop ones
/// and n integrators (argument principle, the contour passing the origin on the right). Below the band L is taken to
/// go on the shorter way to −n·90° − P·180°, its start where the rest of its gain is positive (without integrator: to
/// the nearer side of the real axis), above it to 0 without another turn.
pub(super) fn check(lines: &[Line], settings: &Settings) -> Result<(), MarginError> {
    let last = lines[lines.len() - 1];
    if last.value.norm() >= 1.0 {
        return Err(MarginError::BandTooShort { gain: last.value.norm(), at_hz: last.frequency_hz });
    }
    let integrators = f64::from(settings.integrators_count);
    let unstable = f64::from(settings.unstable_poles_count);
    let first = (1.0 + lines[0].value).arg();
    let start = match settings.integrators_count {
        0 if first.abs() > FRAC_PI_2 => PI,
        0 => 0.0,
        _ => -integrators * FRAC_PI_2 - unstable * PI,
    };
    let turned = wrapped(first - start) + inside(lines) - (1.0 + last.value).arg();
    let poles = unstable + 0.5 * integrators - turned / PI;
    if (poles - poles.round()).abs() > WHOLE || poles < -WHOLE {
        return Err(MarginError::Count { turns: turned / PI });
    }
    match poles.round() as u32 {
        0 => Ok(()),
        poles_count => Err(MarginError::Unstable { poles_count }),
    }
}

fn inside(lines: &[Line]) -> f64 {
    lines
        .windows(2)
        .map(|pair| ((1.0 + pair[1].value) / (1.0 + pair[0].value)).arg())
        .filter(|a| !a.is_nan())
        .sum()
}

/// Into −π…π.
fn wrapped(angle: f64) -> f64 {
    angle - (angle / TAU).round() * TAU
}

/// Angle between two lines as seen from a point.
pub(super) fn step_seen_from(point: C64, pair: &[Line]) -> f64 {
    let angle = ((pair[1].value - point) / (pair[0].value - point)).arg().abs();
    if angle.is_nan() { PI } else { angle }
}
