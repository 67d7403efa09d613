//! The world: two rigid axes with friction, cogging, unbalance, cable spring and hard stops.
//!
//! `J·α = T_m − T_f + A_u·cos θ − K_s·(θ − θ_0) + cogging(θ)` per axis, motor torque constant over a step.
//! Implicit midpoint rule with LuGre linear in the step's mean velocity: second order, stable at any step width.

use crate::physics::cogging::AngleTorque;
use crate::physics::lugre::{Contact, LuGre};
use crate::physics::stops::Stops;
use crate::unit::{AxisSettings, UnitSettings};

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

/// What really happened in the world, for the operator's eyes after a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldRecord {
    /// End-stop contacts: axis, time s, speed rad/s.
    pub crashes: Vec<(String, f64, f64)>,
}

/// Names of the axes, in the order of [`World::axes`].
pub const AXIS_NAMES: [&str; 2] = ["az", "el"];

/// A stop that was hit counts again once the axis has left it by this much.
const REARM_CLEARANCE_RAD: f64 = 2e-3;

/// Contact with a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crash {
    /// World step at which it began.
    pub step_count: u64,
    /// Speed into the stop.
    pub speed_rad_per_s: f64,
}

/// One axis.
#[derive(Clone, Debug)]
pub struct Axis {
    step_s: f64,
    /// 2J/h: what resists a change of the mean velocity.
    double_inertia_per_step: f64,
    half_step_per_inertia: f64,
    friction: LuGre,
    contact: Contact,
    loads: AngleTorque,
    stops: Stops,
    angle_rad: f64,
    velocity_rad_per_s: f64,
    /// Loads minus friction in the last step: what the next one starts its prediction from.
    passive_nm: f64,
    motor_nm: f64,
    /// The last step changed nothing but the age of the contact, so with the same torque the next will not either.
    standing: bool,
    touching: bool,
    crashes: Vec<Crash>,
    steps_count: u64,
}

/// Both axes.
#[derive(Clone, Debug)]
pub struct World {
    /// Azimuth, elevation.
    pub axes: [Axis; 2],
    step_s: f64,
}

impl World {
    /// A unit at rest, bristles relaxed.
    pub fn new(unit: &UnitSettings, start: StartState) -> Self {
        let step_s = 1.0 / unit.step_rate_hz;
        let axes = [Axis::new(&unit.az, start.az_rad, step_s), Axis::new(&unit.el, start.el_rad, step_s)];
        Self { axes, step_s }
    }

    /// What happened so far, in order of time.
    pub fn record(&self) -> WorldRecord {
        let mut crashes = Vec::new();
        for (axis, name) in self.axes.iter().zip(AXIS_NAMES) {
            for crash in &axis.crashes {
                crashes.push((name.to_owned(), crash.step_count as f64 * self.step_s, crash.speed_rad_per_s));
            }
        }
        crashes.sort_by(|a, b| a.1.total_cmp(&b.1));
        WorldRecord { crashes }
    }
}

impl Axis {
    /// An axis at rest with relaxed bristles and a fresh contact.
    pub fn new(settings: &AxisSettings, angle_rad: f64, step_s: f64) -> Self {
        Self {
            step_s,
            double_inertia_per_step: 2.0 * settings.inertia_kg_m2 / step_s,
            half_step_per_inertia: 0.5 * step_s / settings.inertia_kg_m2,
            friction: LuGre::new(settings, step_s),
            contact: Contact::default(),
            loads: AngleTorque::new(settings, angle_rad),
            stops: Stops::new(settings),
            angle_rad,
            velocity_rad_per_s: 0.0,
            passive_nm: 0.0,
            motor_nm: 0.0,
            standing: false,
            touching: false,
            crashes: Vec::new(),
            steps_count: 0,
        }
    }

    /// One step with this motor torque.
    #[inline]
    pub fn step(&mut self, motor_nm: f64) {
        self.steps_count += 1;
        if self.standing && motor_nm == self.motor_nm {
            self.friction.age_standing(&mut self.contact);
            return;
        }
        let half_step_s = 0.5 * self.step_s;
        let expected = self.velocity_rad_per_s + self.half_step_per_inertia * (motor_nm + self.passive_nm);
        let loads_nm = self.loads.at(self.angle_rad + half_step_s * expected);
        let friction = self.friction.predict(&self.contact, expected);
        // The torques first: their sum is exact near balance, so a standing axis comes to a true fixed point.
        let net_nm = motor_nm + loads_nm - friction.offset_nm;
        let push = self.double_inertia_per_step * self.velocity_rad_per_s + net_nm;
        let mass = self.double_inertia_per_step + friction.slope_nm_s_per_rad;
        let depth_rad = self.stops.depth_rad(self.angle_rad);
        let mean = if depth_rad == 0.0 { push / mass } else { self.against_stop(depth_rad, push, mass) };

        let before = (self.angle_rad, self.velocity_rad_per_s, self.contact.deflection_rad, self.passive_nm);
        self.angle_rad += self.step_s * mean;
        self.velocity_rad_per_s = 2.0 * mean - self.velocity_rad_per_s;
        self.passive_nm = loads_nm - friction.offset_nm - friction.slope_nm_s_per_rad * mean;
        friction.apply(&mut self.contact, mean);
        let after = (self.angle_rad, self.velocity_rad_per_s, self.contact.deflection_rad, self.passive_nm);
        self.standing = before == after && friction.standing && depth_rad == 0.0;
        self.motor_nm = motor_nm;
    }

    #[cold]
    fn against_stop(&mut self, depth_rad: f64, push: f64, mass: f64) -> f64 {
        if !self.touching {
            self.touching = true;
            let speed_rad_per_s = self.velocity_rad_per_s.abs();
            self.crashes.push(Crash { step_count: self.steps_count, speed_rad_per_s });
        }
        self.stops.midpoint_rad_per_s(depth_rad, push, mass, self.step_s).unwrap_or(push / mass)
    }

    /// Called now and then: a stop that the axis has left can be hit again.
    pub(crate) fn rearm_stops(&mut self) {
        self.touching &= self.stops.clearance_rad(self.angle_rad) < REARM_CLEARANCE_RAD;
    }

    /// True angle.
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// True velocity.
    pub fn velocity_rad_per_s(&self) -> f64 {
        self.velocity_rad_per_s
    }

    /// State of the friction contact.
    pub fn contact(&self) -> Contact {
        self.contact
    }

    /// Contacts with the stops so far.
    pub fn crashes(&self) -> &[Crash] {
        &self.crashes
    }
}

#[cfg(test)]
mod tests;
