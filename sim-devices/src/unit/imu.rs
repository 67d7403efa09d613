//! Inertial measurement unit on the elevation frame.

mod rows;

pub(super) use rows::IMU;

/// Inertial measurement unit on the elevation frame; arrays are in the order X, Y, Z unless said.
#[derive(Clone, Debug, PartialEq)]
pub struct ImuSettings {
    /// Angle of the unit about its Z axis, from the elevation axis.
    pub mounting_angle_rad: f64,
    /// Small rotation of the unit about X, Y, Z.
    pub misalignment_rad: [f64; 3],
    /// Lean of Y towards X, Z towards X, Z towards Y.
    pub nonorthogonality_rad: [f64; 3],
    /// +1 or -1: sign of each gyro output.
    pub gyro_sign_factor: [f64; 3],
    /// Angle random walk of each gyro.
    pub gyro_random_walk_rad_per_sqrt_s: f64,
    /// Multiplies the angle random walk.
    pub gyro_noise_factor: f64,
    /// Bias instability of each gyro (B of IEEE 952).
    pub gyro_bias_instability_rad_per_s: f64,
    /// Rate random walk of each gyro: standard deviation gathered in one hour.
    pub gyro_hourly_walk_rad_per_s: f64,
    /// Constant bias of each gyro.
    pub gyro_bias_rad_per_s: [f64; 3],
    /// Scale error of each gyro.
    pub gyro_scale_error_ratio: [f64; 3],
    /// Step of the gyro output.
    pub gyro_quantum_rad_per_s: f64,
    /// Size of single wrong samples of a gyro, of either sign.
    pub gyro_spike_rad_per_s: f64,
    /// How often each gyro has one.
    pub gyro_spike_rate_hz: f64,
    /// Velocity random walk of each accelerometer.
    pub accelerometer_random_walk_m_per_s_per_sqrt_s: f64,
    /// Bias instability of each accelerometer.
    pub accelerometer_bias_instability_m_per_s2: f64,
    /// Constant bias of each accelerometer.
    pub accelerometer_bias_m_per_s2: [f64; 3],
    /// Scale error of each accelerometer.
    pub accelerometer_scale_error_ratio: [f64; 3],
    /// Place of the unit from the crossing of the axes: left of the line of sight, up from it, along it.
    pub lever_arm_m: [f64; 3],
    /// Gravity at the site.
    pub gravity_m_per_s2: f64,
    /// Rotation of the Earth.
    pub earth_rate_rad_per_s: f64,
    /// Latitude of the site.
    pub latitude_rad: f64,
    /// Heading of azimuth zero, clockwise from north.
    pub azimuth_zero_heading_rad: f64,
    /// Delay of filter and processing inside the unit. The mean over a pulse period (half of it) and the transmission
    /// until the host's next tick come on top.
    pub delay_s: f64,
    /// Temperature of the unit.
    pub temperature_degc: f64,
    /// What the unit is warmer late in a campaign than at its beginning.
    pub warm_up_degc: f64,
    /// Time constant of that.
    pub warm_up_time_s: f64,
    /// Change of the scale of the gyros per kelvin of it.
    pub gyro_scale_per_k_ratio: f64,
    /// Change of the bias of the gyros per kelvin of it.
    pub gyro_bias_per_k_rad_per_s: f64,
    /// Time from the start of a point until the gyros are valid.
    pub startup_s: f64,
    /// Bit rate of the line.
    pub baud_count: f64,
    /// Data rate as powered up, used without external synchronisation.
    pub data_rate_hz: f64,
}

const DEG: f64 = std::f64::consts::PI / 180.0;
const DEG_PER_H: f64 = DEG / 3600.0;
const STANDARD_G: f64 = 9.806_65;

impl Default for ImuSettings {
    /// The unit `nominal`.
    fn default() -> Self {
        Self {
            mounting_angle_rad: 45.0 * DEG,
            misalignment_rad: [100e-6, -80e-6, 60e-6],
            nonorthogonality_rad: [40e-6, -30e-6, 20e-6],
            gyro_sign_factor: [1.0, 1.0, 1.0],
            gyro_random_walk_rad_per_sqrt_s: 0.01 * DEG / 60.0,
            gyro_noise_factor: 1.0,
            gyro_bias_instability_rad_per_s: 0.05 * DEG_PER_H,
            gyro_hourly_walk_rad_per_s: 0.02 * DEG_PER_H,
            gyro_bias_rad_per_s: [0.2 * DEG_PER_H, -0.1 * DEG_PER_H, 0.15 * DEG_PER_H],
            gyro_scale_error_ratio: [50e-6, -40e-6, 30e-6],
            gyro_quantum_rad_per_s: 1e-6,
            gyro_spike_rad_per_s: 0.0,
            gyro_spike_rate_hz: 1.0,
            accelerometer_random_walk_m_per_s_per_sqrt_s: 0.07 / 60.0,
            accelerometer_bias_instability_m_per_s2: 50e-6 * STANDARD_G,
            accelerometer_bias_m_per_s2: [0.5e-3 * STANDARD_G, -0.4e-3 * STANDARD_G, 0.3e-3 * STANDARD_G],
            accelerometer_scale_error_ratio: [200e-6, -150e-6, 100e-6],
            lever_arm_m: [0.2, 0.3, 0.25],
            gravity_m_per_s2: 9.806_65,
            earth_rate_rad_per_s: 15.041_067 * DEG_PER_H,
            latitude_rad: 40.0 * DEG,
            azimuth_zero_heading_rad: 0.0 * DEG,
            delay_s: 0.875e-3,
            temperature_degc: 45.0,
            warm_up_degc: 0.0,
            warm_up_time_s: 300.0,
            gyro_scale_per_k_ratio: 0.0,
            gyro_bias_per_k_rad_per_s: 0.0,
            startup_s: 0.0,
            baud_count: 4_147_200.0,
            data_rate_hz: 1000.0,
        }
    }
}
