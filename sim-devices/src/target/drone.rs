//! A drone: hovers, comes down, flies along the rails and back, climbs; heaving and pushed by gusts all the time.

use std::f64::consts::TAU;

use super::tones::Tones;
use super::{Place, velocity_step};
use crate::physics::noise::SeedAddress;
use crate::unit::TargetSettings;

/// Gusts reach down to this share of their highest frequency (ours).
const SLOWEST_GUST: f64 = 0.1;

/// A change of velocity at a time within the cycle.
#[derive(Clone, Copy, Debug)]
struct Change {
    at_s: f64,
    by_m_per_s: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Drone {
    cycle_s: f64,
    rise_s: f64,
    along: [Change; 4],
    up: [Change; 4],
    heave_m: f64,
    heave_rad_per_s: f64,
    gusts: Tones,
    gust_at_start_m: f64,
}

impl Drone {
    pub(super) fn new(settings: &TargetSettings, address: &SeedAddress) -> Self {
        let rise_s = settings.drone_rise_s;
        // A leg that is shorter than its rise would overlap itself.
        let leg_s = |length_m: f64, speed_m_per_s: f64| (length_m / speed_m_per_s).max(rise_s);
        let descent_s = leg_s(settings.drone_descent_m, settings.drone_descent_m_per_s);
        let run_s = leg_s(settings.drone_run_m, settings.drone_run_m_per_s);
        let descent_m_per_s = settings.drone_descent_m / descent_s;
        let run_m_per_s = settings.drone_run_m / run_s;
        let pause_s = settings.drone_hover_s + rise_s;
        let down_s = pause_s;
        let out_s = down_s + descent_s + pause_s;
        let back_s = out_s + run_s + pause_s;
        let climb_s = back_s + run_s + pause_s;
        let highest_hz = settings.drone_gust_hz;
        let band = [SLOWEST_GUST * highest_hz, highest_hz];
        let gusts = Tones::new(address, "target.drone-gust", band, settings.drone_gust_m_per_s);
        Self {
            cycle_s: climb_s + descent_s + rise_s,
            rise_s,
            along: there_and_back([out_s, back_s], run_s, run_m_per_s),
            up: there_and_back([down_s, climb_s], descent_s, -descent_m_per_s),
            heave_m: settings.drone_heave_m,
            heave_rad_per_s: TAU * settings.drone_heave_hz,
            gust_at_start_m: gusts.at(0.0).0,
            gusts,
        }
    }

    /// `now_s` since the start of the run, `moving_s` since it began its first leg's hover.
    pub(super) fn at(&self, now_s: f64, moving_s: f64) -> Place {
        let cycle_s = moving_s.max(0.0) % self.cycle_s;
        let (along_m, along_m_per_s) = self.course(&self.along, cycle_s);
        let (up_m, up_m_per_s) = self.course(&self.up, cycle_s);
        let (gust_m, gust_m_per_s) = self.gusts.at(now_s);
        let (sine, cosine) = (self.heave_rad_per_s * now_s).sin_cos();
        Place {
            along_m: along_m + gust_m - self.gust_at_start_m,
            up_m: up_m + self.heave_m * sine,
            along_m_per_s: along_m_per_s + gust_m_per_s,
            up_m_per_s: up_m_per_s + self.heave_m * self.heave_rad_per_s * cosine,
        }
    }

    fn course(&self, changes: &[Change; 4], cycle_s: f64) -> (f64, f64) {
        changes.iter().fold((0.0, 0.0), |(place_m, velocity), change| {
            let (share, integral_s) = velocity_step(cycle_s - change.at_s, self.rise_s);
            (place_m + change.by_m_per_s * integral_s, velocity + change.by_m_per_s * share)
        })
    }
}

/// Starts and stops of two legs of the same length in opposite directions.
fn there_and_back(starts_s: [f64; 2], leg_s: f64, velocity: f64) -> [Change; 4] {
    let [out_s, back_s] = starts_s;
    [
        Change { at_s: out_s, by_m_per_s: velocity },
        Change { at_s: out_s + leg_s, by_m_per_s: -velocity },
        Change { at_s: back_s, by_m_per_s: -velocity },
        Change { at_s: back_s + leg_s, by_m_per_s: velocity },
    ]
}
