//! Limits of the simulated rig's file that shape what is measured. A test of [`crate::expected`] compares them with the file.

/// Travel, rad.
pub const TRAVEL_RAD: [[f64; 2]; 2] = [[-160.0 * DEG, 160.0 * DEG], [-10.0 * DEG, 90.0 * DEG]];
/// Soft limits, rad.
pub const SOFT_RAD: [[f64; 2]; 2] = [[-159.0 * DEG, 159.0 * DEG], [-9.5 * DEG, 89.5 * DEG]];
/// Largest commanded rate, rad/s.
pub const VELOCITY_RAD_PER_S: f64 = 62.0 * DEG;
/// Largest commanded acceleration, rad/s².
pub const ACCELERATION_RAD_PER_S2: f64 = 93.0 * DEG;
/// Largest commanded jerk, rad/s³.
pub const JERK_RAD_PER_S3: f64 = 900.0 * DEG;
/// Largest commanded torque, N·m.
pub const TORQUE_NM: [f64; 2] = [2556.0, 1882.0];

const DEG: f64 = std::f64::consts::PI / 180.0;
