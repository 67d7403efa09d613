//! One axis: rigid body, flexible modes, friction contact, loads and stops.

use crate::physics::cogging::AngleTorque;
use crate::physics::flexible::{Deflection, Modes};
use crate::physics::lugre::{Contact, LuGre};
use crate::physics::stops::Stops;
use crate::unit::{AxisSettings, StructureSettings};

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
    steps_per_s: f64,
    inertia_kg_m2: f64,
    /// h/J: what a torque adds to the rate of the rigid body in a step.
    step_per_inertia: f64,
    /// What the shaft's mean rate gains per N·m in a step, and its inverse.
    mean_rate_per_torque: f64,
    torque_per_mean_rate: f64,
    friction: LuGre,
    contact: Contact,
    loads: AngleTorque,
    stops: Stops,
    modes: Modes,
    rigid_rad: f64,
    rigid_rad_per_s: f64,
    /// Angle and rate of the shaft.
    angle_rad: f64,
    velocity_rad_per_s: f64,
    /// Loads minus friction in the last step: what the next one starts its prediction from.
    passive_nm: f64,
    /// Torque at the shaft in the last step, all counted.
    net_nm: f64,
    motor_nm: f64,
    /// The last step changed nothing but the age of the contact, so with the same torque the next will not either.
    standing: bool,
    touching: bool,
    crashes: Vec<Crash>,
    steps_count: u64,
}

impl Axis {
    /// A rigid axis at rest with relaxed bristles and a fresh contact.
    pub fn new(settings: &AxisSettings, angle_rad: f64, step_s: f64) -> Self {
        Self::flexible(settings, &StructureSettings::rigid(), angle_rad, 0.0, step_s)
    }

    /// An axis with a flexible structure, as it is at an elevation.
    pub fn flexible(
        settings: &AxisSettings,
        structure: &StructureSettings,
        angle_rad: f64,
        elevation_rad: f64,
        step_s: f64,
    ) -> Self {
        let mut axis = Self {
            step_s,
            steps_per_s: 1.0 / step_s,
            inertia_kg_m2: settings.inertia_kg_m2,
            step_per_inertia: 0.0,
            mean_rate_per_torque: 0.0,
            torque_per_mean_rate: 0.0,
            friction: LuGre::new(settings, step_s),
            contact: Contact::default(),
            loads: AngleTorque::new(settings, angle_rad),
            stops: Stops::new(settings),
            modes: Modes::new(structure, elevation_rad, step_s),
            rigid_rad: angle_rad,
            rigid_rad_per_s: 0.0,
            angle_rad,
            velocity_rad_per_s: 0.0,
            passive_nm: 0.0,
            net_nm: 0.0,
            motor_nm: 0.0,
            standing: false,
            touching: false,
            crashes: Vec::new(),
            steps_count: 0,
        };
        axis.weigh();
        axis
    }

    /// Follows the elevation that the structure depends on, and lets a stop that was left be hit again.
    pub(crate) fn follow(&mut self, elevation_rad: f64) {
        if self.modes.follow(elevation_rad) {
            self.weigh();
            self.standing = false;
        }
        self.rearm_stops();
    }

    /// Lets a stop that was left be hit again.
    pub(crate) fn rearm_stops(&mut self) {
        self.touching &= self.stops.clearance_rad(self.angle_rad) < REARM_CLEARANCE_RAD;
    }

    fn weigh(&mut self) {
        self.step_per_inertia = self.step_s * self.modes.rigid_gain_ratio() / self.inertia_kg_m2;
        self.mean_rate_per_torque = 0.5 * self.step_per_inertia + self.modes.shaft_per_torque() / self.step_s;
        self.torque_per_mean_rate = 1.0 / self.mean_rate_per_torque;
    }

    /// One step with this motor torque.
    #[inline]
    pub fn step(&mut self, motor_nm: f64) {
        self.steps_count += 1;
        if self.standing && motor_nm == self.motor_nm {
            self.friction.age_standing(&mut self.contact);
            return;
        }
        let h = self.step_s;
        let m = self.mean_rate_per_torque;
        let free = self.rigid_rad_per_s + self.modes.free_turn_rad() * self.steps_per_s;
        let expected = free + m * (motor_nm + self.passive_nm);
        let loads_nm = self.loads.at(self.angle_rad + 0.5 * h * expected);
        let friction = self.friction.predict(&self.contact, self.angle_rad, expected);
        // The torques first: their sum is exact near balance, so a standing axis comes to a true fixed point.
        let offered_nm = motor_nm + loads_nm - friction.offset_nm;
        let depth_rad = self.stops.depth_rad(self.angle_rad);
        let (mean, net_nm) = if depth_rad == 0.0 {
            let mean = (free + m * offered_nm) / (1.0 + m * friction.slope_nm_s_per_rad);
            (mean, offered_nm - friction.slope_nm_s_per_rad * mean)
        } else {
            self.against_stop(depth_rad, free, offered_nm, friction.slope_nm_s_per_rad)
        };

        let before = (self.rigid_rad, self.rigid_rad_per_s, self.contact.deflection_rad, self.passive_nm);
        self.rigid_rad += h * (self.rigid_rad_per_s + 0.5 * self.step_per_inertia * net_nm);
        self.rigid_rad_per_s += self.step_per_inertia * net_nm;
        let shaft = self.modes.step(net_nm);
        self.angle_rad = self.rigid_rad + shaft.angle_rad;
        self.velocity_rad_per_s = self.rigid_rad_per_s + shaft.rate_rad_per_s;
        self.passive_nm = loads_nm - friction.offset_nm - friction.slope_nm_s_per_rad * mean;
        friction.apply(&mut self.contact, mean);
        let after = (self.rigid_rad, self.rigid_rad_per_s, self.contact.deflection_rad, self.passive_nm);
        self.standing = before == after && friction.standing && depth_rad == 0.0 && self.modes.come_to_rest();
        self.motor_nm = motor_nm;
        self.net_nm = net_nm;
    }

    /// Mean rate and net torque of a step inside a stop.
    #[cold]
    fn against_stop(&mut self, depth_rad: f64, free: f64, offered_nm: f64, slope: f64) -> (f64, f64) {
        if !self.touching {
            self.touching = true;
            let speed_rad_per_s = self.velocity_rad_per_s.abs();
            self.crashes.push(Crash { step_count: self.steps_count, speed_rad_per_s });
        }
        let push = self.torque_per_mean_rate * free + offered_nm;
        let mass = self.torque_per_mean_rate + slope;
        let stopped = self.stops.midpoint_rad_per_s(depth_rad, push, mass, self.step_s);
        let mean = stopped.unwrap_or(push / mass);
        (mean, (mean - free) * self.torque_per_mean_rate)
    }

    /// True angle of the shaft.
    #[inline]
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// True rate of the shaft.
    #[inline]
    pub fn velocity_rad_per_s(&self) -> f64 {
        self.velocity_rad_per_s
    }

    /// Angle of the rigid body.
    pub(crate) fn rigid_rad(&self) -> f64 {
        self.rigid_rad
    }

    /// Rate of the rigid body.
    pub(crate) fn rigid_rad_per_s(&self) -> f64 {
        self.rigid_rad_per_s
    }

    /// What the modes add at the frame.
    pub(crate) fn frame(&self) -> Deflection {
        self.modes.frame()
    }

    /// Acceleration of the frame.
    pub(crate) fn frame_rad_per_s2(&self) -> f64 {
        self.net_nm * self.step_per_inertia / self.step_s + self.modal_rad_per_s2()
    }

    /// The modes' part of it.
    pub(crate) fn modal_rad_per_s2(&self) -> f64 {
        self.modes.frame_rad_per_s2(self.net_nm)
    }

    /// Kinetic and elastic energy of body and modes, J.
    pub fn energy_j(&self) -> f64 {
        let inertia = self.step_s / self.step_per_inertia;
        0.5 * inertia * self.rigid_rad_per_s * self.rigid_rad_per_s + self.modes.energy_j()
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
