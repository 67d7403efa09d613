//! A sine of the position that begins and ends at rest.

use std::f64::consts::TAU;

use super::Setpoint;

/// Largest slope and curvature of the fade 6x⁵ − 15x⁴ + 10x³ over 0…1: 15/8 and 10/√3.
const FADE_SLOPE: f64 = 1.875;
const FADE_CURVATURE: f64 = 5.773_502_691_896_258;

/// Largest rate and acceleration, an upper bound: those of the sine and of the fade added up.
pub(super) fn peaks(amplitude_rad: f64, frequency_hz: f64, fade_s: f64) -> [f64; 2] {
    let amplitude = amplitude_rad.abs();
    let omega = TAU * frequency_hz;
    let slope = FADE_SLOPE / fade_s;
    let curvature = FADE_CURVATURE / (fade_s * fade_s);
    [amplitude * (omega + slope), amplitude * (omega * omega + 2.0 * slope * omega + curvature)]
}

/// The sine at a time, relative to its middle; it lasts and fades for as long as `[lasts_s, fade_s]` say.
pub(super) fn at(amplitude_rad: f64, frequency_hz: f64, [lasts_s, fade_s]: [f64; 2], t_s: f64) -> Setpoint {
    if t_s <= 0.0 || t_s >= lasts_s {
        return Setpoint::default();
    }
    let rising = t_s / fade_s;
    let falling = (lasts_s - t_s) / fade_s;
    // Of two fades the one that is farther from full size counts; both at once only where they do not fit.
    let (x, sign) = if rising <= falling { (rising.min(1.0), 1.0) } else { (falling.min(1.0), -1.0) };
    let w = x * x * x * (10.0 + x * (6.0 * x - 15.0));
    let slope = sign * 30.0 * x * x * (1.0 - x) * (1.0 - x) / fade_s;
    let curvature = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (fade_s * fade_s);
    let omega = TAU * frequency_hz;
    let (sin, cos) = (omega * t_s).sin_cos();
    Setpoint {
        position_rad: amplitude_rad * w * sin,
        velocity_rad_per_s: amplitude_rad * (slope * sin + w * omega * cos),
        acceleration_rad_per_s2: amplitude_rad
            * (curvature * sin + 2.0 * slope * omega * cos - w * omega * omega * sin),
        torque_nm: 0.0,
    }
}
