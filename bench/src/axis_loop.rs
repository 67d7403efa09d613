//! The production controllers of one axis in the tick: position → velocity → torque.

use controllers::AxisGains;
use controllers::position::PositionLaw;
use controllers::profile::{ProfileLimits, Reference};
use controllers::velocity::VelocityPi;
use drivers::cia402::Actuals;
use procedures::case::Mode;
use procedures::stimulus::Setpoint;

use crate::files::rig::{RigAxis, stop_limits};
use crate::sequence::standing;

/// Below this rate an axis counts as standing at the end of a stop.
const REST_RAD_PER_S: f64 = 1e-4;

/// One axis' loop.
#[derive(Clone, Debug)]
pub struct AxisLoop {
    position: PositionLaw,
    velocity: VelocityPi,
    reference: Reference,
    mode: Mode,
    setpoint: Setpoint,
    following_reference: bool,
    sent_nm: f64,
    inertia_kg_m2: f64,
    cycle_s: f64,
}

impl AxisLoop {
    /// A loop with the production gains, saturating at the axis' torque limit.
    pub fn new(gains: &AxisGains, axis: &RigAxis, cycle_s: f64) -> Self {
        let stop = stop_limits(axis);
        let limits = ProfileLimits {
            velocity_rad_per_s: stop.velocity_rad_per_s,
            acceleration_rad_per_s2: stop.acceleration_rad_per_s2,
            jerk_rad_per_s3: stop.jerk_rad_per_s3,
        };
        Self {
            position: PositionLaw::new(gains.position_gain_per_s),
            velocity: VelocityPi::new(
                gains.velocity_kp_nm_s_per_rad,
                gains.velocity_ki_nm_per_rad,
                axis.limits.max_torque_nm,
                cycle_s,
            ),
            reference: Reference::at_rest(0.0, limits),
            mode: Mode::Position,
            setpoint: Setpoint::default(),
            following_reference: true,
            sent_nm: 0.0,
            inertia_kg_m2: axis.limits.inertia_kg_m2,
            cycle_s,
        }
    }

    /// Holds the axis where it is, without a torque step.
    pub fn hold_here(&mut self, actuals: &Actuals) {
        self.following_reference = true;
        self.mode = Mode::Position;
        self.reference.reset(actuals.position_rad, 0.0);
        self.velocity.reset(self.sent_nm);
    }

    /// Decelerates from the present rate to rest within the axis' limits, then holds.
    pub fn start_stop(&mut self, actuals: &Actuals) {
        self.velocity.reset(self.sent_nm);
        let (position_rad, rate) = match (self.following_reference, self.mode) {
            (false, Mode::Position) => (self.setpoint.position_rad, self.setpoint.velocity_rad_per_s),
            _ => (actuals.position_rad, actuals.velocity_rad_per_s),
        };
        self.reference.reset(position_rad, rate);
        self.reference.stop();
        self.following_reference = true;
        self.mode = Mode::Position;
    }

    /// Whether a stop is over: the reference rests and so does the axis.
    pub fn stopped(&self, actuals: &Actuals) -> bool {
        self.following_reference
            && self.reference.is_at_rest()
            && actuals.velocity_rad_per_s.abs() < REST_RAD_PER_S
    }

    /// Where the position command stands, for a segment that goes on from there.
    pub fn reference_rad(&self, actuals: &Actuals) -> f64 {
        if self.mode == Mode::Position && !self.following_reference {
            self.setpoint.position_rad
        } else if self.mode == Mode::Position {
            self.reference.position_rad()
        } else {
            actuals.position_rad
        }
    }

    /// Prepares for a segment in `mode`, without a torque step where the loop stays closed.
    pub fn enter(&mut self, mode: Mode, _actuals: &Actuals) {
        if self.mode == Mode::Torque && mode != Mode::Torque {
            self.velocity.reset(self.sent_nm);
        }
        self.mode = mode;
        self.following_reference = false;
    }

    /// The torque for this tick. `wanted` is the segment's setpoint; without one the axis follows its own reference.
    pub fn torque(&mut self, actuals: &Actuals, wanted: Option<&Setpoint>) -> f64 {
        self.setpoint = match wanted {
            Some(setpoint) => *setpoint,
            None => self.follow_reference(),
        };
        if self.mode == Mode::Torque && wanted.is_some() {
            return self.setpoint.torque_nm;
        }
        let rate = match self.mode {
            Mode::Velocity if wanted.is_some() => self.setpoint.velocity_rad_per_s,
            _ => self.position.rate(
                self.setpoint.position_rad,
                actuals.position_rad,
                self.setpoint.velocity_rad_per_s,
            ),
        };
        self.setpoint.velocity_rad_per_s = rate;
        let feed_forward_nm = self.inertia_kg_m2 * self.setpoint.acceleration_rad_per_s2;
        self.velocity.torque(rate, actuals.velocity_rad_per_s, feed_forward_nm)
    }

    /// What really went out, for a bumpless change of mode.
    pub fn sent(&mut self, torque_nm: f64) {
        self.sent_nm = torque_nm;
    }

    /// Torque that went out last.
    pub fn sent_nm(&self) -> f64 {
        self.sent_nm
    }

    /// Setpoint of this tick, for the log.
    pub fn setpoint(&self) -> &Setpoint {
        &self.setpoint
    }

    fn follow_reference(&mut self) -> Setpoint {
        self.following_reference = true;
        self.reference.advance(self.cycle_s);
        Setpoint {
            velocity_rad_per_s: self.reference.velocity_rad_per_s(),
            acceleration_rad_per_s2: self.reference.acceleration_rad_per_s2(),
            ..standing(self.reference.position_rad())
        }
    }
}
