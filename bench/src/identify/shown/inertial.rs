//! What the inertial unit and the encoders say of each other and of gravity.

use std::f64::consts::FRAC_1_SQRT_2;

use sim_devices::unit::UnitSettings;

use super::Shown;

/// Direction of the elevation axis, in the axes of an ideal mount: X and Y at 45 deg about the line of sight, Z.
const ELEVATION_AXIS: [f64; 3] = [-FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0];

/// Delays of gyros and encoder, and the exchange after which a message of the gyros is read.
pub(in crate::identify) fn gyro_encoder_delay_s(s: &Shown<'_>) -> Option<f64> {
    Some(s.unit.imu.delay_s + s.setup.tick_s - s.axis()?.sensor_delay_s)
}

/// What the encoder shows more than gravity: its zero, and how the unit leans about the elevation axis. Of accelerometers that lean
/// against each other one half shows along the line of sight as an angle would.
pub(in crate::identify) fn elevation_zero_rad(s: &Shown<'_>) -> Option<f64> {
    let [x, y, _] = s.unit.imu.misalignment_rad;
    let [_, zx, zy] = s.unit.imu.nonorthogonality_rad;
    Some(FRAC_1_SQRT_2 * (x - y - 0.5 * (zx + zy)) - s.unit.el.encoder_zero_rad)
}

/// Along the directions that the line of sight gives.
pub(in crate::identify) fn accelerometer_bias_m_per_s2(s: &Shown<'_>) -> Option<f64> {
    let [x, y, z] = s.unit.imu.accelerometer_bias_m_per_s2;
    match s.finding.measurement.axis.as_str() {
        "up" => Some(FRAC_1_SQRT_2 * (x + y)),
        "ahead" => Some(z),
        _ => None,
    }
}

/// Of the gyro that the finding names.
pub(in crate::identify) fn gyro_bias_rad_per_s(s: &Shown<'_>) -> Option<f64> {
    let gyro = ["x", "y", "z"].iter().position(|name| *name == s.finding.measurement.axis)?;
    Some(s.unit.imu.gyro_bias_rad_per_s[gyro])
}

/// Direction of the axis that turned at this elevation, in the axes of an ideal mount.
fn turned(s: &Shown<'_>, elevation_rad: f64) -> Option<[f64; 3]> {
    if s.place()? == 1 {
        return Some(ELEVATION_AXIS);
    }
    let (sin, cos) = elevation_rad.sin_cos();
    Some([cos * FRAC_1_SQRT_2, cos * FRAC_1_SQRT_2, sin])
}

/// What the gyros add to a unit rate about a direction, to first order: rotation of the mount, lean, scale.
fn added(unit: &UnitSettings, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [mx, my, mz] = unit.imu.misalignment_rad;
    let [yx, zx, zy] = unit.imu.nonorthogonality_rad;
    let [sx, sy, sz] = unit.imu.gyro_scale_error_ratio;
    [sx * x + mz * y - my * z, sy * y - mz * x + mx * z + yx * x, sz * z + my * x - mx * y + zx * x + zy * y]
}

fn along(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Size of the rate that the gyros show over the rate of the axis, less 1, to first order.
pub(in crate::identify) fn gyro_scale_error_ratio(s: &Shown<'_>) -> Option<f64> {
    let direction = turned(s, s.condition("elevation").unwrap_or(0.0))?;
    Some(along(added(s.unit, direction), direction))
}

/// Angle between the axis that the gyros show and the one that the mount says at the elevation by the encoder, to first order.
pub(in crate::identify) fn gyro_mapping_error_rad(s: &Shown<'_>) -> Option<f64> {
    let by_encoder_rad = s.condition("elevation").unwrap_or(0.0);
    let said = turned(s, by_encoder_rad)?;
    let real = turned(s, by_encoder_rad + s.unit.el.encoder_zero_rad)?;
    let added = added(s.unit, real);
    let off: [f64; 3] = std::array::from_fn(|k| added[k] + real[k] - said[k]);
    let scale = along(off, said);
    Some(off.iter().zip(said).map(|(o, d)| (o - scale * d).powi(2)).sum::<f64>().sqrt())
}
