//! What the director points at: parametric, seeded trajectories.
//!
//! Everything is a pure function of time, so it may be asked in any order. The track lies across the line of sight,
//! `x` along it and `z` above it, at a horizontal distance R from the director at its nearest point:
//! `az = atan(x/R)`, `el = atan(z/√(R² + x²))`, turned so that the target stands at the set direction at first.

mod drone;
mod rail;
mod sweep;
#[cfg(test)]
mod tests;
mod tones;

use std::time::Duration;

use crate::physics::noise::SeedAddress;
use crate::unit::TargetSettings;

use drone::Drone;
use rail::Rail;
use sweep::Sweep;

/// Direction of the target as the gimbal counts it; azimuth, elevation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TargetState {
    /// Angles.
    pub angle_rad: [f64; 2],
    /// Rates.
    pub rate_rad_per_s: [f64; 2],
}

/// Where the target is on its track, and how fast.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Place {
    along_m: f64,
    up_m: f64,
    along_m_per_s: f64,
    up_m_per_s: f64,
}

/// A course of the target.
#[derive(Clone, Debug)]
enum Course {
    Fixed,
    Rail(Rail),
    Drone(Drone),
    Sweep(Sweep),
}

/// A target on its way.
#[derive(Clone, Debug)]
pub struct Target {
    course: Course,
    standing_s: f64,
    distance_m: f64,
    start_along_m: f64,
    start_height_m: f64,
    azimuth_offset_rad: f64,
    fixed_rad: [f64; 2],
}

impl Target {
    /// A target that stands in the set direction until its time comes.
    pub fn new(settings: &TargetSettings, address: &SeedAddress) -> Self {
        let course = match settings.kind_count.round() as i64 {
            1 => Course::Rail(Rail::new(settings, address)),
            2 => Course::Drone(Drone::new(settings, address)),
            3 => Course::Sweep(Sweep::new(settings)),
            _ => Course::Fixed,
        };
        let start_along_m = match &course {
            Course::Rail(rail) => -0.5 * rail.length_m(),
            _ => 0.0,
        };
        let distance_m = settings.distance_m;
        Self {
            course,
            standing_s: settings.standing_s,
            distance_m,
            start_along_m,
            start_height_m: start_along_m.hypot(distance_m) * settings.elevation_rad.tan(),
            azimuth_offset_rad: settings.azimuth_rad - start_along_m.atan2(distance_m),
            fixed_rad: [settings.azimuth_rad, settings.elevation_rad],
        }
    }

    /// Direction and rates at a time since the start of the run.
    pub fn at(&self, now: Duration) -> TargetState {
        self.at_s(now.as_secs_f64())
    }

    fn at_s(&self, now_s: f64) -> TargetState {
        // A drone is never still: its heave and gusts go on while it stands.
        let moving_s = now_s - self.standing_s;
        let place = match &self.course {
            Course::Fixed => return TargetState { angle_rad: self.fixed_rad, ..TargetState::default() },
            Course::Sweep(sweep) => return self.about_the_first(sweep.at(moving_s)),
            Course::Rail(rail) => rail.at(moving_s),
            Course::Drone(drone) => drone.at(now_s, moving_s),
        };
        self.direction(place)
    }

    /// An offset from the first direction.
    fn about_the_first(&self, offset: TargetState) -> TargetState {
        let angle_rad = [0, 1].map(|axis| self.fixed_rad[axis] + offset.angle_rad[axis]);
        TargetState { angle_rad, ..offset }
    }

    fn direction(&self, place: Place) -> TargetState {
        let along = self.start_along_m + place.along_m;
        let up = self.start_height_m + place.up_m;
        let ground_squared = self.distance_m * self.distance_m + along * along;
        let ground = ground_squared.sqrt();
        let ground_rate = along * place.along_m_per_s / ground;
        let azimuth_rate = self.distance_m * place.along_m_per_s / ground_squared;
        let elevation_rate = (ground * place.up_m_per_s - up * ground_rate) / (ground_squared + up * up);
        TargetState {
            angle_rad: [self.azimuth_offset_rad + along.atan2(self.distance_m), up.atan2(ground)],
            rate_rad_per_s: [azimuth_rate, elevation_rate],
        }
    }
}

/// A change of velocity from 0 to 1 within `rise_s`: share of it and its integral over time, `after_s` its start.
///
/// The acceleration is a raised cosine, so the jerk is bounded: `s = τ/r − sin(2πτ/r)/2π`.
fn velocity_step(after_s: f64, rise_s: f64) -> (f64, f64) {
    use std::f64::consts::TAU;
    if after_s <= 0.0 {
        return (0.0, 0.0);
    }
    if after_s >= rise_s {
        return (1.0, after_s - 0.5 * rise_s);
    }
    let share = after_s / rise_s;
    let (sine, cosine) = (TAU * share).sin_cos();
    (share - sine / TAU, rise_s * (0.5 * share * share + (cosine - 1.0) / (TAU * TAU)))
}
