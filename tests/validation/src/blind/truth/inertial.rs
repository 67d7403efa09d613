//! What the inertial unit and the encoders say of each other and of gravity.

use std::f64::consts::FRAC_1_SQRT_2;

use procedures::measurement::Measurement;
use sim_devices::unit::UnitSettings;

use super::drivetrain::TICK_S;
use super::{at, axis, place};
use crate::prediction::encoder_error_rad;

/// Delays of both, and the exchange after which a message of the gyros is read.
pub(super) fn gyro_encoder_delay_s(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    Some(unit.imu.delay_s + TICK_S - axis(m, unit)?.sensor_delay_s)
}

/// What the encoder shows more than gravity: its zero, and how the unit leans about the elevation axis, (1, -1, 0)/√2 in its own
/// axes. Of accelerometers that lean against each other one half shows along the line of sight as an angle would.
pub(super) fn elevation_zero_rad(_: &Measurement, unit: &UnitSettings) -> Option<f64> {
    Some(leans_rad(unit) - unit.el.encoder_zero_rad)
}

/// The part of the inertial unit alone.
pub(in crate::blind) fn leans_rad(unit: &UnitSettings) -> f64 {
    let [x, y, _] = unit.imu.misalignment_rad;
    let [_, zx, zy] = unit.imu.nonorthogonality_rad;
    FRAC_1_SQRT_2 * (x - y - 0.5 * (zx + zy))
}

pub(super) fn accelerometer_bias_m_per_s2(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let [x, y, z] = unit.imu.accelerometer_bias_m_per_s2;
    match m.axis.as_str() {
        "up" => Some(FRAC_1_SQRT_2 * (x + y)),
        "ahead" => Some(z),
        _ => None,
    }
}

/// Direction of the elevation axis, in the axes of an ideal mount.
const ELEVATION_AXIS: [f64; 3] = [-FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0];

/// Direction of the axis that turns, in the axes of an ideal mount.
fn turned(m: &Measurement, elevation_rad: f64) -> Option<[f64; 3]> {
    if place(m)? == 1 {
        return Some(ELEVATION_AXIS);
    }
    let (sin, cos) = elevation_rad.sin_cos();
    Some([cos * FRAC_1_SQRT_2, cos * FRAC_1_SQRT_2, sin])
}

/// What the gyros add to a unit rate about a direction, to first order: rotation of the mount, lean, scale.
fn added(unit: &UnitSettings, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let imu = &unit.imu;
    let [mx, my, mz] = imu.misalignment_rad;
    let [yx, zx, zy] = imu.nonorthogonality_rad;
    let [sx, sy, sz] = imu.gyro_scale_error_ratio;
    [sx * x + mz * y - my * z, sy * y - mz * x + mx * z + yx * x, sz * z + my * x - mx * y + zx * x + zy * y]
}

/// What of that is along the direction.
fn along(added: [f64; 3], direction: [f64; 3]) -> f64 {
    added.iter().zip(direction).map(|(a, d)| a * d).sum()
}

/// Where the axes of a gimbal turn, rad: azimuth in `quick` within 20° and in `fat` within 40°, which makes 6 % of its encoder's share.
const SPINS_RAD: [[f64; 2]; 2] = [[-0.52, 0.52], [0.0, 1.4]];

/// Size of the rate that the gyros show over the rate that the encoder shows, less 1, to first order.
pub(super) fn gyro_scale_error(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    Some(scale_error(unit, place(m)?, turned(m, at(m, "elevation").unwrap_or(0.0))?))
}

/// The same about the elevation axis.
pub(in crate::blind) fn elevation_gyro_scale(unit: &UnitSettings) -> f64 {
    scale_error(unit, 1, ELEVATION_AXIS)
}

/// For an axis, 0 azimuth and 1 elevation, that turns about a direction.
fn scale_error(unit: &UnitSettings, axis: usize, direction: [f64; 3]) -> f64 {
    let settings = [&unit.az, &unit.el][axis];
    let [from_rad, to_rad] = SPINS_RAD[axis];
    let too_much =
        (encoder_error_rad(settings, to_rad) - encoder_error_rad(settings, from_rad)) / (to_rad - from_rad);
    // Warm, as late in a campaign.
    let of_heat = unit.imu.gyro_scale_per_k_ratio * unit.imu.warm_up_degc;
    // The encoder loses its slip on the way towards larger angles, and nothing on the way back.
    along(added(unit, direction), direction) + of_heat - too_much + 0.5 * settings.encoder_slip_ratio
}

/// Angle between the axis that the gyros show and the one that the mount says at the elevation by the encoder, to first order.
pub(super) fn gyro_mapping_error_rad(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let shown_rad = at(m, "elevation").unwrap_or(0.0);
    let said = turned(m, shown_rad)?;
    let real = turned(m, shown_rad + unit.el.encoder_zero_rad - encoder_error_rad(&unit.el, shown_rad))?;
    let added = added(unit, real);
    let off: [f64; 3] = std::array::from_fn(|k| added[k] + real[k] - said[k]);
    let scale = along(off, said);
    Some(off.iter().zip(said).map(|(o, d)| (o - scale * d).powi(2)).sum::<f64>().sqrt())
}
