//! The simulated director without the bench: its wires, the production drivers and laws, tracking its target.
//!
//! World, drives, inertial unit, cameras and mirror with all their errors stand behind the wires of
//! [`sim_devices::rig::SimulatedRig`]; nothing of them reaches the laws but what the drivers decode.

mod cases;
mod director;
mod figures;
mod laws;
#[cfg(test)]
mod tests;

use std::time::Duration;

use controllers::DirectorGains;
use drivers::device::DeviceError;
use sim_devices::physics::noise::SeedAddress;
use sim_devices::rig::StartState;
use sim_devices::scene::SceneTruth;
use sim_devices::unit::UnitSettings;

use self::director::{Commands, Director};
use self::laws::{Laws, Task};

pub use self::cases::{CASES, Scenario, TrackingCase, quiet};
pub use self::figures::{FineTracking, deviation, fine_loop, largest, longest_within, rejection, span};

/// Rows of a record per second.
pub const ROW_RATE_HZ: f64 = 400.0;
/// Ticks per row.
const ROW_TICKS: u32 = 10;

/// What really was, at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Since the start of the run.
    pub time_s: f64,
    /// Target, atmosphere, errors.
    pub truth: SceneTruth,
    /// True angle of the mirror, azimuth and elevation axis.
    pub mirror_rad: [f64; 2],
    /// Angles of the axes as the encoders report them.
    pub encoder_rad: [f64; 2],
    /// Whether both cameras show the target.
    pub locked: bool,
}

impl Row {
    /// Coarse error of an axis, as its gimbal has it: of azimuth, not across the elevation axis.
    pub fn coarse_rad(&self, axis: usize) -> f64 {
        let cosine = if axis == 0 { self.truth.target_rad[1].cos() } else { 1.0 };
        self.sight_rad(axis) / cosine
    }

    /// What the fine loop has to reject: target minus line of sight of the frame, and the atmosphere.
    pub fn fine_input_rad(&self, axis: usize) -> f64 {
        self.sight_rad(axis) + self.truth.atmosphere_rad[axis]
    }

    /// What is left behind the mirror.
    pub fn fine_rad(&self, axis: usize) -> f64 {
        // A target behind the director is no error of any size: the record says that it was not locked.
        self.truth.fine_error_rad.map_or(f64::NAN, |error| error[axis])
    }

    fn sight_rad(&self, axis: usize) -> f64 {
        self.truth.coarse_error_rad.map_or(f64::NAN, |error| error[axis])
    }
}

/// Points at the target of a unit, enables both axes and tracks with coarse and fine loop.
///
/// # Errors
/// When a driver refuses its twin.
pub fn track(
    unit: &UnitSettings,
    gains: &DirectorGains,
    seed: u64,
    seconds: f64,
) -> Result<Vec<Row>, DeviceError> {
    let start = [unit.target.azimuth_rad, unit.target.elevation_rad];
    run(unit, gains, seed, start, Task::Track, seconds)
}

/// Enables both axes at these angles and keeps their rate at zero by the gyros, the rate of the Earth taken off, with
/// no position loop around: what drifts is the gyros' bias.
///
/// # Errors
/// When a driver refuses its twin.
pub fn stand(
    unit: &UnitSettings,
    gains: &DirectorGains,
    seed: u64,
    angles_rad: [f64; 2],
    seconds: f64,
) -> Result<Vec<Row>, DeviceError> {
    run(unit, gains, seed, angles_rad, Task::Stand, seconds)
}

fn run(
    unit: &UnitSettings,
    gains: &DirectorGains,
    seed: u64,
    start_rad: [f64; 2],
    task: Task,
    seconds: f64,
) -> Result<Vec<Row>, DeviceError> {
    let address = SeedAddress { seed, procedure: "TRACKING".into(), point: "1".into() };
    let start =
        StartState { az_rad: start_rad[0], el_rad: start_rad[1], heat_sink_degc: unit.az.ambient_degc };
    let mut director = Director::open(unit, &address, start)?;
    let mut laws = Laws::new(unit, gains, task);
    let mut rows = Vec::with_capacity((seconds * ROW_RATE_HZ) as usize + 1);
    let mut commands = Commands::default();
    let mut ticks = 0;
    while director.now() < Duration::from_secs_f64(seconds) {
        let sensed = director.exchange(&commands)?;
        commands = laws.tick(&sensed);
        if ticks % ROW_TICKS == 0 {
            rows.push(director.row(&sensed, laws.locked()));
        }
        ticks += 1;
        director.wait();
    }
    Ok(rows)
}
