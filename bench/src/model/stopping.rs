//! How an axis stops: under control, coasting without torque, released at rest. Everything from the rig file.
//!
//! The same figures serve the plan (worst case before anything moves), the interlocks (every tick) and the report
//! (computed against reached).

mod coast;

#[cfg(test)]
mod tests;

pub use coast::{Coast, Impact, Swing};

/// Slower than this an axis counts as resting for the interlocks of position, rad/s.
pub const REST_RAD_PER_S: f64 = 1e-3;

/// Part of a computed stop that the loop may need beyond its reference: following error and settling.
const SETTLING_RATIO: f64 = 0.02;
/// Angle that the loop may need beyond its reference at low speed, rad.
const SETTLING_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Time that the loop may need beyond its reference, until it is slower than standstill.
const SETTLING_S: f64 = 1.5;
/// Static friction must hold the load of a released axis with this margin (safety.md: controlled stop).
const RELEASE_MARGIN: f64 = 1.3;

/// Torques that act on an axis by itself: `A_u·cos θ − K_s·(θ − θ_0)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loads {
    /// Unbalance A_u at angle 0, signed.
    pub unbalance_nm: f64,
    /// Rate K_s of the cable spring.
    pub spring_nm_per_rad: f64,
    /// Angle θ_0 at which it rests.
    pub spring_rest_rad: f64,
}

impl Loads {
    /// Torque at an angle, N·m.
    pub fn at(&self, angle_rad: f64) -> f64 {
        self.unbalance_nm * angle_rad.cos() - self.spring_nm_per_rad * (angle_rad - self.spring_rest_rad)
    }

    /// The part that drives an axis on which moves up (`ahead` = 1) or down (−1), N·m: each load may be smaller than
    /// said, so none is counted on to brake.
    pub fn driving(&self, ahead: f64, angle_rad: f64) -> f64 {
        let unbalance_nm = ahead * self.unbalance_nm * angle_rad.cos();
        let spring_nm = -ahead * self.spring_nm_per_rad * (angle_rad - self.spring_rest_rad);
        unbalance_nm.max(0.0) + spring_nm.max(0.0)
    }
}

/// Friction that an axis has at the very least.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeastFriction {
    /// Static, from rest.
    pub static_nm: f64,
    /// Running, at little speed.
    pub coulomb_nm: f64,
    /// Per rate.
    pub viscous_nm_s_per_rad: f64,
}

impl LeastFriction {
    /// While running at a speed, N·m.
    pub fn running_nm(&self, speed_rad_per_s: f64) -> f64 {
        self.coulomb_nm + self.viscous_nm_s_per_rad * speed_rad_per_s.abs()
    }
}

/// What a stop may rely on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StopModel {
    /// Required travel = mechanical travel.
    pub travel_rad: [f64; 2],
    /// Soft limits inside it.
    pub soft_limits_rad: [f64; 2],
    /// Inertia about the axis.
    pub inertia_kg_m2: f64,
    /// Deceleration of a stop under control.
    pub deceleration_rad_per_s2: f64,
    /// Jerk with which it sets in and ends.
    pub jerk_rad_per_s3: f64,
    /// Time between what the loop sees and the torque that answers it.
    pub reaction_s: f64,
    /// Longest time that an axis goes on as it does before anything answers: that of a drive whose bus falls silent, and
    /// which waits for its watchdog. Every computed stop has it.
    pub blind_s: f64,
    /// What pulls at the axis.
    pub loads: Loads,
    /// What slows it down without torque.
    pub friction: LeastFriction,
    /// Angle by which the contact gives way when torque is taken from it: static friction over presliding stiffness.
    pub relaxation_rad: f64,
    /// Torque of a brake that falls in when power goes; 0 without one.
    pub brake_nm: f64,
    /// Energy that the end stops take without damage; 0 for bare stops.
    pub end_stop_energy_j: f64,
}

/// A stop under control, at the worst.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControlledStop {
    /// Angle from the cause to standstill.
    pub angle_rad: f64,
    /// Time from the cause to standstill.
    pub time_s: f64,
}

impl StopModel {
    /// A stop under control from this speed, which holds until the slowest reaction.
    pub fn controlled(&self, speed_rad_per_s: f64) -> ControlledStop {
        self.controlled_from(speed_rad_per_s, 0.0, self.deceleration_rad_per_s2)
    }

    /// A stop under control from an acceleration that goes on until the reaction, counted positive in the direction of
    /// motion, with the deceleration that the motor has shown that it gives.
    ///
    /// `v·t + a·t²/2` until the reaction, then from the speed there a jerk-limited ramp (`v²/2a + v·a/2j`, or `v·√(v/j)`
    /// where `a` is not reached), and an allowance for settling.
    pub fn controlled_from(
        &self,
        speed_rad_per_s: f64,
        acceleration_rad_per_s2: f64,
        deceleration_rad_per_s2: f64,
    ) -> ControlledStop {
        let speed = speed_rad_per_s.abs();
        let until_s = self.blind_s;
        if speed == 0.0 {
            return ControlledStop::default();
        }
        let v = (speed + acceleration_rad_per_s2 * until_s).max(0.0);
        let a = deceleration_rad_per_s2;
        let j = self.jerk_rad_per_s3;
        let (angle, time_s) = if v * j >= a * a {
            (v * v / (2.0 * a) + v * a / (2.0 * j), v / a + a / j)
        } else {
            let rise_s = (v / j).sqrt();
            (v * rise_s, 2.0 * rise_s)
        };
        let moving = 0.5 * (speed + v) * until_s + angle;
        ControlledStop {
            angle_rad: (1.0 + SETTLING_RATIO) * moving + SETTLING_RAD,
            time_s: until_s + time_s + SETTLING_S,
        }
    }

    /// Angle left to the soft limit in the direction of motion, negative beyond it.
    pub fn room_rad(&self, angle_rad: f64, rate_rad_per_s: f64) -> f64 {
        if rate_rad_per_s >= 0.0 {
            self.soft_limits_rad[1] - angle_rad
        } else {
            angle_rad - self.soft_limits_rad[0]
        }
    }

    /// Whether friction holds the axis at this angle when its torque is taken away: static friction at least 1.3 times
    /// what pulls at it, or a brake.
    pub fn holds_without_torque(&self, angle_rad: f64) -> bool {
        self.friction.static_nm + self.brake_nm >= RELEASE_MARGIN * self.loads.at(angle_rad).abs()
    }
}
