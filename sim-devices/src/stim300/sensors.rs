//! Errors of the sensors that every unit of this type has.
//!
//! Sources: Safran's datasheet as the NavToolkit of IS4S quotes it (`navtk::filtering::stim300_model`), the bias from one power-up
//! to the next as ION Navigation 2023 quotes it for its unit. What is not published is marked as ours.

use crate::unit::ImuSettings;

const DEG: f64 = std::f64::consts::PI / 180.0;
const DEG_PER_H: f64 = DEG / 3600.0;
const STANDARD_G: f64 = 9.806_65;

/// Biases of the gyros. Ours: the size is that from one power-up to the next, 4 °/h.
const BIAS_RAD_PER_S: [f64; 3] = [4.0 * DEG_PER_H, -3.0 * DEG_PER_H, 2.0 * DEG_PER_H];
/// Bandwidth of the low-pass filters as delivered, Hz (TS1524, table 5-16).
const BANDWIDTH_HZ: f64 = 262.0;

/// The errors of one unit of this type: noise, bias, delay and step are those of the type, everything else is that of `imu`. A factor
/// on the noise acts on the noise of the type; biases add.
pub(crate) fn of_type(imu: &ImuSettings) -> ImuSettings {
    let bias = |k: usize| imu.gyro_bias_rad_per_s[k] + BIAS_RAD_PER_S[k];
    ImuSettings {
        gyro_random_walk_rad_per_sqrt_s: 0.15 * DEG / 60.0,
        gyro_bias_instability_rad_per_s: 0.5 * DEG_PER_H,
        // Not published.
        gyro_hourly_walk_rad_per_s: 0.0,
        gyro_bias_rad_per_s: [bias(0), bias(1), bias(2)],
        // The datagram rounds to 2⁻¹⁴ °/s.
        gyro_quantum_rad_per_s: 0.0,
        accelerometer_random_walk_m_per_s_per_sqrt_s: 0.06 / 60.0,
        accelerometer_bias_instability_m_per_s2: 50e-6 * STANDARD_G,
        // Ours: the filters as Butterworth filters of the second order, whose delay at low frequencies is √2/ω.
        delay_s: std::f64::consts::SQRT_2 / (std::f64::consts::TAU * BANDWIDTH_HZ),
        ..imu.clone()
    }
}
