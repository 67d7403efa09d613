//! The world of the director: two axes with friction, cogging, unbalance, cable spring, hard stops and a flexible structure.
//!
//! `J/g·ω̇_r = T`, `q̈_n + 2ζω·q̇_n + ω²·q_n = T`, `T = T_m − T_f + A_u·cos θ − K_s·(θ − θ_0) + cogging(θ)` per axis, where
//! the shaft moves by `θ = θ_r + Σ c_e·q` (friction, loads and stops act there, as the motor does) and the frame with
//! gyro and line of sight by `θ_r + Σ c_g·q`. Rigid gain g, c and ω_n depend on elevation: a fit, not a mass that moves.
//! Motor torque is constant over a step, the modes are exact, friction is linear in the step's mean velocity: second
//! order, stable at any step width.

mod axis;
mod uncoupled;

use crate::motion::{FrameMotion, Motion};
use crate::unit::UnitSettings;

pub use axis::{Axis, Crash};
pub use uncoupled::{AxisTruth, UncoupledAxes};

/// Where the world stands, at rest, when a point begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartState {
    /// Azimuth angle.
    pub az_rad: f64,
    /// Elevation angle.
    pub el_rad: f64,
    /// Heat sink temperature of both drives.
    pub heat_sink_degc: f64,
}

/// Where both axes really are, whatever encoders and drives make of it: azimuth, elevation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxesTruth {
    /// Angles of the shafts, rad.
    pub angle_rad: [f64; 2],
    /// Rates of the axes, rad/s.
    pub rate_rad_per_s: [f64; 2],
}

/// What really happened in the world, for the operator's eyes after a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldRecord {
    /// End-stop contacts: axis, time s, speed rad/s.
    pub crashes: Vec<(String, f64, f64)>,
}

/// Names of the axes, in the order of [`World::axes`].
pub const AXIS_NAMES: [&str; 2] = ["az", "el"];

/// Steps between two looks at the elevation: it moves by less than a grid width meanwhile.
const FOLLOW_STEPS: u32 = 8;

/// Both axes.
#[derive(Clone, Debug)]
pub struct World {
    /// Azimuth, elevation.
    pub axes: [Axis; 2],
    step_s: f64,
    /// At elevation 0, and what comes on top at the zenith.
    cross_coupling_ratio: f64,
    cross_coupling_growth_ratio: f64,
    /// At this elevation.
    leak_ratio: f64,
    steps_to_follow: u32,
}

impl World {
    /// A unit at rest, bristles relaxed.
    pub fn new(unit: &UnitSettings, start: StartState) -> Self {
        let step_s = 1.0 / unit.step_rate_hz;
        let elevation_rad = start.el_rad;
        let axes = [
            Axis::flexible(&unit.az, &unit.az_structure, start.az_rad, elevation_rad, step_s),
            Axis::flexible(&unit.el, &unit.el_structure, start.el_rad, elevation_rad, step_s),
        ];
        let mut world = Self {
            axes,
            step_s,
            cross_coupling_ratio: unit.cross_coupling_ratio,
            cross_coupling_growth_ratio: unit.cross_coupling_growth_ratio,
            leak_ratio: 0.0,
            steps_to_follow: 0,
        };
        world.leak_at(elevation_rad);
        world
    }

    /// The coupling of the axes at an elevation.
    fn leak_at(&mut self, elevation_rad: f64) {
        self.leak_ratio = self.cross_coupling_ratio;
        if self.cross_coupling_growth_ratio != 0.0 {
            self.leak_ratio += self.cross_coupling_growth_ratio * elevation_rad.sin();
        }
    }

    /// One step with these motor torques.
    #[inline]
    pub fn step(&mut self, motor_nm: [f64; 2]) {
        if self.steps_to_follow == 0 {
            self.steps_to_follow = FOLLOW_STEPS;
            let elevation_rad = self.axes[1].angle_rad();
            self.axes.iter_mut().for_each(|axis| axis.follow(elevation_rad));
            self.leak_at(elevation_rad);
        }
        self.steps_to_follow -= 1;
        self.axes[0].step(motor_nm[0]);
        self.axes[1].step(motor_nm[1]);
    }

    /// Angles and rates of the frame now. The modes of azimuth leak a little into its elevation.
    #[inline]
    pub fn frame(&self) -> FrameMotion {
        let [az, el] = &self.axes;
        let modes_az = az.frame();
        let modes_el = el.frame();
        let leak = self.leak_ratio;
        FrameMotion {
            rad: [
                az.rigid_rad() + modes_az.angle_rad,
                el.rigid_rad() + modes_el.angle_rad + leak * modes_az.angle_rad,
            ],
            rad_per_s: [
                az.rigid_rad_per_s() + modes_az.rate_rad_per_s,
                el.rigid_rad_per_s() + modes_el.rate_rad_per_s + leak * modes_az.rate_rad_per_s,
            ],
        }
    }

    /// What sensors on the structure feel now.
    pub fn motion(&self) -> Motion {
        let [az, el] = &self.axes;
        let frame = self.frame();
        Motion {
            shaft_rad: [az.angle_rad(), el.angle_rad()],
            shaft_rad_per_s: [az.velocity_rad_per_s(), el.velocity_rad_per_s()],
            frame_rad: frame.rad,
            frame_rad_per_s: frame.rad_per_s,
            frame_rad_per_s2: [
                az.frame_rad_per_s2(),
                el.frame_rad_per_s2() + self.leak_ratio * az.modal_rad_per_s2(),
            ],
        }
    }

    /// Where both axes really are.
    pub fn truth(&self) -> AxesTruth {
        let [az, el] = &self.axes;
        AxesTruth {
            angle_rad: [az.angle_rad(), el.angle_rad()],
            rate_rad_per_s: [az.velocity_rad_per_s(), el.velocity_rad_per_s()],
        }
    }

    /// What happened so far, in order of time.
    pub fn record(&self) -> WorldRecord {
        record_of(AXIS_NAMES.into_iter().zip(&self.axes), self.step_s)
    }
}

/// What happened to these axes so far, in order of time.
fn record_of<'a>(axes: impl Iterator<Item = (&'a str, &'a Axis)>, step_s: f64) -> WorldRecord {
    let mut crashes = Vec::new();
    for (name, axis) in axes {
        for crash in axis.crashes() {
            crashes.push((name.to_owned(), crash.step_count as f64 * step_s, crash.speed_rad_per_s));
        }
    }
    crashes.sort_by(|a, b| a.1.total_cmp(&b.1));
    WorldRecord { crashes }
}

#[cfg(test)]
mod tests;
