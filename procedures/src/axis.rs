//! What planning and judging know of an axis: the rig's limits and scales, in SI units.

use std::f64::consts::TAU;

use analysis::uncertainty::rectangular_u;
use serde::{Deserialize, Serialize};

mod axes;
#[cfg(test)]
mod tests;
mod torque;

pub use axes::{Axes, Axis, Gimbal, MAX_AXES, NoGimbal};
pub(crate) use torque::warming;
pub use torque::{MeasuredConstant, TorqueScale};

/// Limits and scales of one axis, as the rig file declares them. Angles rad, torques N·m, times s.
///
/// Limits travel inside the log (as part of the plan), so that a log judges alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisLimits {
    /// Required travel, lower and upper end.
    pub travel_rad: [f64; 2],
    /// Soft limits inside the travel that the interlocks enforce.
    pub soft_limits_rad: [f64; 2],
    /// Largest angular rate that a procedure may ask for.
    pub max_velocity_rad_per_s: f64,
    /// Largest angular acceleration that a profile may use.
    pub max_acceleration_rad_per_s2: f64,
    /// Largest angular jerk that a profile may use.
    pub max_jerk_rad_per_s3: f64,
    /// Largest motor torque.
    pub max_torque_nm: f64,
    /// Torque constant: motor torque per ampere of drive current. `None` (imported records): efforts stay in ampere.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Relative standard uncertainty of the torque constant.
    pub torque_constant_u_ratio: f64,
    /// Torque constant that was measured in the same run. It is no part of a log: whoever judges all logs puts it here.
    #[serde(skip)]
    pub measured_constant: Option<MeasuredConstant>,
    /// Inertia about the axis.
    pub inertia_kg_m2: f64,
    /// Relative standard uncertainty of the inertia. Logs of versions that did not state it are judged with 15 %, rectangular.
    #[serde(default = "unstated_inertia_u_ratio")]
    pub inertia_u_ratio: f64,
    /// Torque that one count of the drive's torque command is worth (6071, ‰ of 6076).
    pub torque_quantum_nm: f64,
    /// Angle that one encoder count is worth.
    pub encoder_quantum_rad: f64,
    /// Expected static friction: sizes gates (quantum ≤ T_S/300, multisine ≤ 0.1 T_S), never a result.
    pub expected_static_friction_nm: f64,
    /// Expected stiffness of the axis against a small torque from rest (bristles): sizes the first pulses, never a result.
    #[serde(default)]
    pub expected_presliding_stiffness_nm_per_rad: f64,
    /// Largest torque of the check of polarity: breakaway of the stiffest unit that is still to be tested, + 20 %.
    #[serde(default)]
    pub polarity_torque_nm: f64,
    /// How far the zero of the encoder may be off where people say that the axis stands, before the first motion. Logs of
    /// versions that did not state it were judged with 5°.
    #[serde(default = "unstated_zero_tolerance_rad")]
    pub zero_tolerance_rad: f64,
    /// Rate at which the loops of the axis are closed; 0 where it is not known (imported records).
    #[serde(default)]
    pub loop_rate_hz: f64,
    /// Rate of the rows in the log, where it is lower: each is the mean over its ticks.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub log_rate_hz: f64,
    /// Cogging periods per revolution that are expected: whole periods are used for averages, never a result.
    pub cogging_orders_per_rev: f64,
    /// What measures the true angle from outside; `None` without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<AngleReference>,
}

/// A polygon on an axis, read by an autocollimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AngleReference {
    /// Places of the faces by their calibration, −π…π, rad.
    pub faces_rad: Vec<f64>,
    /// Largest angle off a face that is read, rad.
    pub range_rad: f64,
    /// Standard uncertainty of a place, rad.
    pub u_rad: f64,
}

impl AngleReference {
    /// Where the axis is, if the autocollimator reads `deviation_rad` at the face that is nearest to `near_rad` (by the
    /// encoder, which is good enough to tell faces apart).
    pub fn angle_rad(&self, near_rad: f64, deviation_rad: f64) -> Option<f64> {
        self.nearest_rad(near_rad).map(|face_rad| face_rad + deviation_rad)
    }

    /// Place of the face that is nearest to an angle, in the same turn.
    pub fn nearest_rad(&self, near_rad: f64) -> Option<f64> {
        let turned = |face: &f64| face + ((near_rad - face) / TAU).round() * TAU;
        let off = |face: &f64| (face - near_rad).abs();
        self.faces_rad.iter().map(turned).min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

fn unstated_inertia_u_ratio() -> f64 {
    rectangular_u(0.15)
}

fn unstated_zero_tolerance_rad() -> f64 {
    5.0 * TAU / 360.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn is_zero(rate_hz: &f64) -> bool {
    *rate_hz == 0.0
}

impl AxisLimits {
    /// Rows per second in the log: those of the loop unless a procedure asks for fewer.
    pub fn row_rate_hz(&self) -> f64 {
        if self.log_rate_hz > 0.0 { self.log_rate_hz } else { self.loop_rate_hz }
    }

    /// From one tick of the loop to the next; 0 where the rate is not known.
    pub fn tick_s(&self) -> f64 {
        if self.loop_rate_hz > 0.0 { 1.0 / self.loop_rate_hz } else { 0.0 }
    }

    /// Whether a torque is so near to the axis' largest that more of it would not have come.
    pub fn is_saturated(&self, torque_nm: f64) -> bool {
        torque_nm.abs() >= SATURATED_SHARE * self.max_torque_nm
    }
}

/// Share of the largest torque from which on a torque counts as being at its limit.
pub const SATURATED_SHARE: f64 = 0.98;

/// Bit 11 of the statusword (CiA 402): a limit of the drive is active.
pub const INTERNAL_LIMIT: u16 = 1 << 11;

/// Whether a drive says in any of these statuswords that a limit of its own was active: what was sent was not what acted.
pub fn says_limited(statuswords: &[f64]) -> bool {
    statuswords.iter().any(|word| *word as u16 & INTERNAL_LIMIT != 0)
}

/// Ticks for each row of a log that is to have `log_rate_hz` rows per second (all if `None`).
pub fn ticks_per_row(loop_rate_hz: f64, log_rate_hz: Option<f64>) -> f64 {
    log_rate_hz.map_or(1.0, |wanted_hz| (loop_rate_hz / wanted_hz).round().max(1.0))
}
