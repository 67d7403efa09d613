//! Structure, velocity loops and coarse track loops, by the linear model.

use std::f64::consts::PI;

use num_complex::Complex64;
use procedures::measurement::Measurement;
use sim_devices::unit::UnitSettings;

use super::{at, place};
use crate::linear::{CoarseCamera, Margins, Sensor, VelocityLoop, coarse_open_loop, margins};
use crate::prediction::{ANALYSED_HZ, LOOP_RATE_HZ, TRACK_HZ, TRACK_PERIOD_S, VELOCITY_HZ};
use crate::shipped;

const DEG: f64 = PI / 180.0;
/// Elevation strokes about its mean so far either way while it is evaluated: a window of 1 s at 0.05 rad/s, the response is a mean
/// over it. The stroke goes on to 2.5 deg; there the axis turns round and settles.
const HALF_WIDTH_RAD: f64 = 1.43 * DEG;
/// Rates at which azimuth and elevation slide meanwhile, in both campaigns.
const SLIDING_RAD_PER_S: [f64; 2] = [0.30, 0.05];
/// Poses of that mean on each side.
const POSES: i32 = 4;

fn loops(m: &Measurement, unit: &UnitSettings) -> Option<Vec<VelocityLoop>> {
    let axis = place(m)?;
    let gains = shipped::gains();
    let gains = if axis == 0 { gains.az } else { gains.el };
    let elevation_rad = at(m, "elevation")?;
    let poses = if axis == 0 { 0 } else { POSES };
    let away = |k: i32| if poses == 0 { 0.0 } else { HALF_WIDTH_RAD * f64::from(k) / f64::from(poses) };
    let one = |k| {
        let pose_rad = elevation_rad + away(k);
        let still = VelocityLoop::new(unit, axis, pose_rad, Sensor::Gyro, &gains, LOOP_RATE_HZ);
        let plant = still.plant.clone().sliding(unit.axis(axis), SLIDING_RAD_PER_S[axis]);
        VelocityLoop { plant, ..still }
    };
    Some((-poses..=poses).map(one).collect())
}

fn velocity(m: &Measurement, unit: &UnitSettings) -> Option<Margins> {
    let loops = loops(m, unit)?;
    let open = |hz| loops.iter().map(|l| l.open(hz)).sum::<Complex64>() / loops.len() as f64;
    let [from_hz, to_hz] = VELOCITY_HZ;
    margins(open, from_hz, to_hz)
}

pub(super) fn velocity_bandwidth_hz(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    velocity(m, unit).map(|found| found.bandwidth_hz)
}

pub(super) fn velocity_gain_margin_db(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    velocity(m, unit).map(|found| found.gain_margin_db)
}

pub(super) fn velocity_phase_margin_rad(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    velocity(m, unit).map(|found| found.phase_margin_deg * DEG)
}

pub(super) fn track_bandwidth_hz(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let axis = place(m)?;
    let gains = shipped::gains();
    let own = if axis == 0 { &gains.az } else { &gains.el };
    let velocity = VelocityLoop::new(unit, axis, at(m, "elevation")?, Sensor::Gyro, own, LOOP_RATE_HZ);
    let coarse = CoarseCamera::new(unit, &velocity, &gains.track, TRACK_PERIOD_S);
    let [from_hz, to_hz] = TRACK_HZ;
    margins(|hz| coarse_open_loop(&velocity, &coarse, hz), from_hz, to_hz).map(|found| found.bandwidth_hz)
}

/// Natural frequency of the mode of this rank, by frequency.
fn mode_hz(m: &Measurement, unit: &UnitSettings, rank: usize) -> Option<f64> {
    let structure = [&unit.az_structure, &unit.el_structure][place(m)?];
    let elevation_rad = at(m, "elevation")?;
    let there = structure.modes.iter().map(|mode| structure.interpolate(&mode.frequency_hz, elevation_rad));
    let mut all: Vec<f64> = there.collect();
    all.sort_by(f64::total_cmp);
    all.get(rank).copied()
}

/// Of `first-mode-frequency` … `fourth-mode-frequency`.
pub(super) fn mode_frequency_hz(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let ranks = ["first", "second", "third", "fourth"];
    mode_hz(m, unit, ranks.iter().position(|rank| m.measurand.starts_with(rank))?)
}

/// Of `mode-1-departure` … `mode-3-departure`, calculated frequencies by straight lines between elevations.
pub(super) fn mode_departure(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let rank = ["mode-1", "mode-2", "mode-3"].iter().position(|name| m.measurand.starts_with(name))?;
    let elevation_rad = at(m, "elevation")?;
    let [(low_deg, low), (high_deg, high)] = if elevation_rad >= ANALYSED_HZ[1].0 * DEG {
        [ANALYSED_HZ[1], ANALYSED_HZ[2]]
    } else {
        [ANALYSED_HZ[0], ANALYSED_HZ[1]]
    };
    let share = (elevation_rad / DEG - low_deg) / (high_deg - low_deg);
    let calculated_hz = low[rank] + share * (high[rank] - low[rank]);
    Some(mode_hz(m, unit, rank)? / calculated_hz - 1.0)
}
