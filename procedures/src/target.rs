//! What the director looks at in a point. On metal a person brings it there; a simulated scene takes it from here.

use serde::{Deserialize, Serialize};

/// A target, and where it stands before it moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// How it moves.
    pub course: TargetCourse,
    /// Azimuth at which it stands at first.
    pub azimuth_rad: f64,
    /// Elevation at which it stands at first.
    pub elevation_rad: f64,
    /// The target begins to move so long after the point's power-up, at the earliest.
    pub stands_s: f64,
}

/// How a target moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum TargetCourse {
    /// Not at all.
    Star,
    /// A cart on rails, back and forth (director.md 4.5).
    Rail,
    /// A drone: down from a hover, along the rails and back (director.md 4.5).
    Drone,
    /// A light that sweeps back and forth about its first direction, at these rates.
    Sweep {
        /// Rate of azimuth between turn-rounds.
        azimuth_rad_per_s: f64,
        /// Rate of elevation between turn-rounds.
        elevation_rad_per_s: f64,
        /// Time from the middle of one turn-round to the middle of the next.
        leg_s: f64,
        /// Time that a turn-round takes, at constant acceleration.
        turn_s: f64,
    },
}

impl TargetCourse {
    /// The word for it in procedure files and for people.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Star => "star",
            Self::Rail => "rail",
            Self::Drone => "drone",
            Self::Sweep { .. } => "sweep",
        }
    }

    /// Largest acceleration about the azimuth and the elevation axis, rad/s². Rail and drone: of their course as published, seen
    /// from 85 m, joints and velocity steps of 0.1 s included.
    pub fn accelerations_rad_per_s2(&self) -> [f64; 2] {
        match *self {
            Self::Star => [0.0; 2],
            Self::Rail | Self::Drone => [0.25; 2],
            Self::Sweep { azimuth_rad_per_s, elevation_rad_per_s, turn_s, .. } => {
                [azimuth_rad_per_s, elevation_rad_per_s].map(|rate| 2.0 * rate.abs() / turn_s)
            }
        }
    }
}
