//! Between SI units and the drive's counts.

use std::f64::consts::TAU;

use super::DriveSettings;
use super::profile::TorqueScale;
use crate::device::DeviceError;

/// Scales and limits in the drive's counts, derived once from checked settings.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    counts_per_rev: i64,
    sign: f64,
    rad_per_count: f64,
    offset_rad: f64,
    nm_per_permille: f64,
    a_per_permille: f64,
    max_torque_permille: f64,
    max_speed_counts: f64,
}

/// A limit in ‰ never exceeds the setting; the slack takes up the rounding of the division only.
const ROUNDING_SLACK_PERMILLE: f64 = 1e-6;

impl Scale {
    /// Derives the scales.
    ///
    /// # Errors
    /// The first setting that is out of its range.
    pub(super) fn new(settings: &DriveSettings) -> Result<Self, DeviceError> {
        check(settings)?;
        let counts_per_rev = settings.encoder_counts_per_rev;
        let rad_per_count = TAU / f64::from(counts_per_rev);
        let nm_per_permille = settings.torque_quantum_nm();
        Ok(Self {
            counts_per_rev: i64::from(counts_per_rev),
            sign: settings.encoder_sign,
            rad_per_count,
            offset_rad: settings.encoder_offset_rad,
            nm_per_permille,
            a_per_permille: settings.rated_current_a / 1000.0,
            max_torque_permille: (settings.max_torque_nm / nm_per_permille + ROUNDING_SLACK_PERMILLE).floor(),
            max_speed_counts: (settings.max_velocity_rad_per_s / rad_per_count).round(),
        })
    }

    /// Torque limit for 6072, ‰ of the rated torque, rounded down.
    pub(super) fn max_torque_permille(&self) -> f64 {
        self.max_torque_permille
    }

    /// An unsigned rate of any order, e.g. rad/s or rad/s², in counts.
    pub(super) fn counts(&self, value_rad: f64) -> f64 {
        (value_rad / self.rad_per_count).round_ties_even()
    }

    /// An angle as encoder count, signed and without wrap.
    pub(super) fn position_counts(&self, angle_rad: f64) -> f64 {
        self.counts((angle_rad - self.offset_rad) * self.sign)
    }

    /// Unwraps: the count in the sense of the angle, nearest to `previous`, or to 0 if there is none.
    pub(super) fn unwrap(&self, raw_count: i32, previous: Option<i64>) -> i64 {
        let grown = if self.sign < 0.0 { -i64::from(raw_count) } else { i64::from(raw_count) };
        let origin = previous.unwrap_or(0);
        let ahead = (grown - origin).rem_euclid(self.counts_per_rev);
        let step = if 2 * ahead > self.counts_per_rev { ahead - self.counts_per_rev } else { ahead };
        origin + step
    }

    /// The angle of an unwrapped count.
    pub(super) fn angle_rad(&self, unwrapped: i64) -> f64 {
        self.offset_rad + unwrapped as f64 * self.rad_per_count
    }

    /// Rate of a velocity count.
    pub(super) fn velocity_rad_per_s(&self, counts_per_s: i32) -> f64 {
        f64::from(counts_per_s) * self.sign * self.rad_per_count
    }

    /// Current of a ‰ count.
    pub(super) fn current_a(&self, permille: i16) -> f64 {
        f64::from(permille) * self.a_per_permille
    }

    /// Torque of a ‰ count.
    pub(super) fn torque_nm(&self, permille: i16) -> f64 {
        f64::from(permille) * self.nm_per_permille
    }

    /// Torque demand in ‰, nearest, saturated at the torque limit and at what the word holds. Not a number gives 0.
    pub(super) fn torque_permille(&self, torque_nm: f64) -> i16 {
        let limit = self.max_torque_permille.min(f64::from(i16::MAX));
        (torque_nm / self.nm_per_permille).round_ties_even().clamp(-limit, limit) as i16
    }

    /// Velocity demand in counts/s, nearest, saturated at the speed limit. Not a number gives 0.
    pub(super) fn velocity_counts(&self, velocity_rad_per_s: f64) -> i32 {
        let limit = self.max_speed_counts.min(f64::from(i32::MAX));
        (velocity_rad_per_s * self.sign / self.rad_per_count).round_ties_even().clamp(-limit, limit) as i32
    }
}

impl DriveSettings {
    /// Torque of one count of the torque objects: a thousandth of what the type of the drive scales them by.
    pub fn torque_quantum_nm(&self) -> f64 {
        match self.profile.torque_scale {
            TorqueScale::RatedTorque => self.rated_torque_nm / 1000.0,
            TorqueScale::RatedCurrent => self.rated_current_a * self.torque_constant_nm_per_a / 1000.0,
        }
    }
}

/// Refuses settings that would make a scale meaningless.
fn check(settings: &DriveSettings) -> Result<(), DeviceError> {
    let positive = [
        ("torque_constant_nm_per_a", settings.torque_constant_nm_per_a),
        ("rated_current_a", settings.rated_current_a),
        ("rated_torque_nm", settings.rated_torque_nm),
        ("max_torque_nm", settings.max_torque_nm),
        ("max_velocity_rad_per_s", settings.max_velocity_rad_per_s),
        ("quick_stop_deceleration_rad_per_s2", settings.quick_stop_deceleration_rad_per_s2),
        ("watchdog_s", settings.watchdog_s),
        ("cycle_s", settings.cycle_s),
        ("transition_timeout_s", settings.transition_timeout_s),
    ];
    for (setting, value) in positive {
        let valid = value.is_finite() && value > 0.0;
        require(settings, valid, setting, value, "it must be a number above 0")?;
    }
    let counts = settings.encoder_counts_per_rev;
    require(settings, counts >= 2, "encoder_counts_per_rev", f64::from(counts), "it must be 2 or more")?;
    let sign = settings.encoder_sign;
    require(settings, sign.abs() == 1.0, "encoder_sign", sign, "it must be 1 or -1")?;
    let offset_rad = settings.encoder_offset_rad;
    require(settings, offset_rad.is_finite(), "encoder_offset_rad", offset_rad, "it must be a number")?;
    let [low_rad, high_rad] = settings.soft_limits_rad;
    let allowed = "the lower limit must lie below the upper one";
    require(settings, low_rad < high_rad, "soft_limits_rad", low_rad, allowed)
}

fn require(
    settings: &DriveSettings,
    valid: bool,
    setting: &'static str,
    value: f64,
    allowed: &str,
) -> Result<(), DeviceError> {
    if valid {
        return Ok(());
    }
    Err(DeviceError::Setting { device: settings.name.clone(), setting, value, allowed: allowed.to_owned() })
}
