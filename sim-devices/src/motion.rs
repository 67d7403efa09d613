//! What the structure does at one instant, as the sensors on it feel it.

/// Order of every pair: azimuth, elevation. Elevation rates are d(el)/dt: positive upwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Angles of the shafts: what the encoders see.
    pub shaft_rad: [f64; 2],
    /// Rates of the shafts.
    pub shaft_rad_per_s: [f64; 2],
    /// Angles of the frame that carries gyros, cameras and mirror: what the line of sight follows.
    pub frame_rad: [f64; 2],
    /// Rates of that frame relative to the ground.
    pub frame_rad_per_s: [f64; 2],
    /// Accelerations of that frame.
    pub frame_rad_per_s2: [f64; 2],
}
