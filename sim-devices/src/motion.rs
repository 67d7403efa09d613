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

/// The part of a motion that is kept step by step: angles and rates of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameMotion {
    /// Angles.
    pub rad: [f64; 2],
    /// Rates.
    pub rad_per_s: [f64; 2],
}

impl FrameMotion {
    /// The motion a part of the way to another one.
    pub fn towards(&self, other: &Self, ratio: f64) -> Self {
        let between = |a: [f64; 2], b: [f64; 2]| [a[0] + ratio * (b[0] - a[0]), a[1] + ratio * (b[1] - a[1])];
        Self { rad: between(self.rad, other.rad), rad_per_s: between(self.rad_per_s, other.rad_per_s) }
    }
}

impl From<FrameMotion> for Motion {
    /// A motion of which only the frame is known; the rest is zero.
    fn from(frame: FrameMotion) -> Self {
        Self { frame_rad: frame.rad, frame_rad_per_s: frame.rad_per_s, ..Self::default() }
    }
}

impl Motion {
    /// The mean of the motion over the last `interval_s`, which began with `before`: rates are differences of
    /// angles, accelerations differences of rates (what a uniform averager gives), angles those of the middle.
    pub fn mean_since(&self, before: &Self, interval_s: f64) -> Self {
        let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let per_s = 1.0 / interval_s;
        let slope = |a: [f64; 2], b: [f64; 2]| [(b[0] - a[0]) * per_s, (b[1] - a[1]) * per_s];
        Self {
            shaft_rad: middle(before.shaft_rad, self.shaft_rad),
            shaft_rad_per_s: slope(before.shaft_rad, self.shaft_rad),
            frame_rad: middle(before.frame_rad, self.frame_rad),
            frame_rad_per_s: slope(before.frame_rad, self.frame_rad),
            frame_rad_per_s2: slope(before.frame_rad_per_s, self.frame_rad_per_s),
        }
    }
}
