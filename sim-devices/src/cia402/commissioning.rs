//! The drive as its commissioning left it, and the limits that follow from its dictionary.

use super::dictionary::{Dictionary, at};
use super::motion::SoftLimits;
use crate::physics::encoder::Encoder;
use crate::unit::AxisSettings;

/// One unit of the watchdog object 2F00h.
const WATCHDOG_UNIT_S: f64 = 100e-6;

/// What limits the drive, taken from the dictionary when it changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) current_a: f64,
    /// What the drive believes: rated torque per rated current.
    pub(super) torque_nm_per_a: f64,
    pub(super) speed_rad_per_s: f64,
    pub(super) soft: SoftLimits,
    pub(super) braking_rad_per_s2: f64,
    pub(super) watchdog_steps: u64,
}

/// The dictionary of a drive that was commissioned for its motor.
pub(super) fn commissioned(settings: &AxisSettings, encoder: &Encoder, serial: u32) -> Dictionary {
    let mut dictionary = Dictionary::new();
    let permille = (settings.current_limit_a / settings.rated_current_a * 1000.0).floor() as i64;
    let quarter_turn_per_s2 = encoder.counts_per_rev() / 4;
    let commissioned = [
        (at::SERIAL, i64::from(serial)),
        (at::RATED_CURRENT, (settings.rated_current_a * 1e3).round() as i64),
        (at::RATED_TORQUE, (settings.rated_torque_nm * 1e3).round() as i64),
        (at::ENCODER_COUNTS, encoder.counts_per_rev()),
        (at::MAX_TORQUE, permille),
        (at::MAX_CURRENT, permille),
        (at::QUICK_STOP_DECELERATION, quarter_turn_per_s2),
        (at::SLOW_DOWN_DECELERATION, quarter_turn_per_s2),
        (at::MODE_DISPLAY, dictionary.get(at::MODE)),
    ];
    commissioned.into_iter().for_each(|(slot, value)| dictionary.put(slot, value));
    dictionary
}

/// What the dictionary and the unit allow.
pub(super) fn limits(
    dictionary: &Dictionary,
    settings: &AxisSettings,
    encoder: &Encoder,
    step_s: f64,
) -> Limits {
    let value = |slot| dictionary.get(slot) as f64;
    let rated_a = value(at::RATED_CURRENT) / 1e3;
    let rated_nm = value(at::RATED_TORQUE) / 1e3;
    let torque_nm_per_a = rated_nm / rated_a;
    let by_current_a = value(at::MAX_CURRENT) / 1e3 * rated_a;
    let by_torque_a = value(at::MAX_TORQUE) / 1e3 * rated_nm / torque_nm_per_a;
    // As the drive believes, whatever the encoder really counts.
    let rad_per_count = std::f64::consts::TAU / encoder.counts_per_rev() as f64;
    Limits {
        current_a: by_current_a.min(by_torque_a).min(settings.current_limit_a),
        torque_nm_per_a,
        speed_rad_per_s: value(at::MAX_SPEED) * rad_per_count,
        soft: SoftLimits::new(
            dictionary.get(at::SOFT_LIMIT_MIN),
            dictionary.get(at::SOFT_LIMIT_MAX),
            encoder.counts_per_rev(),
        ),
        braking_rad_per_s2: value(at::QUICK_STOP_DECELERATION) * rad_per_count,
        watchdog_steps: steps(value(at::WATCHDOG) * WATCHDOG_UNIT_S, step_s),
    }
}

/// World steps of a duration.
pub(super) fn steps(duration_s: f64, step_s: f64) -> u64 {
    crate::physics::delay::steps(duration_s, step_s) as u64
}
