//! How an axis stops: by a controlled stop, by coasting without torque, or by a swing after its release at rest.
//! All figures come from the rig file.
//!
//! One model serves three users. The plan computes worst cases before the first motion, the interlocks check every tick,
//! and the report compares reached with computed stops.

mod coast;

#[cfg(test)]
mod tests;

pub use coast::{Coast, Impact, Swing};

/// Below this speed the position interlocks take an axis as being at rest, rad/s.
pub const REST_RAD_PER_S: f64 = 1e-3;

/// Allowance for the axis running on beyond its reference (following error, settling), as a ratio of the stopping angle.
const SETTLING_RATIO: f64 = 0.02;
/// Allowance for the axis running on beyond its reference at low speed, rad. It adds to `SETTLING_RATIO`.
const SETTLING_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Time from the end of the reference until the axis is below the standstill speed, s.
const SETTLING_S: f64 = 1.5;
/// Least ratio of static friction and brake to the load torque of a released axis (safety.md: controlled stop).
const RELEASE_MARGIN: f64 = 1.3;

/// Torques that act on an axis without its motor: `A_u·cos θ − K_s·(θ − θ_0)`. Positive torque drives the angle θ up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loads {
    /// Unbalance torque A_u at angle 0; positive drives the angle up.
    pub unbalance_nm: f64,
    /// Stiffness K_s of the cable spring.
    pub spring_nm_per_rad: f64,
    /// Angle θ_0 at which the cable spring gives no torque.
    pub spring_rest_rad: f64,
}

impl Loads {
    /// Sum of both torques at an angle, N·m.
    pub fn at(&self, angle_rad: f64) -> f64 {
        self.unbalance_nm * angle_rad.cos() - self.spring_nm_per_rad * (angle_rad - self.spring_rest_rad)
    }

    /// Load torque that may drive a moving axis on, N·m. `ahead` is the direction of motion: 1 upwards, −1 downwards.
    /// The rig file gives the largest loads. A load that brakes may really be smaller, so it counts as 0.
    pub fn driving(&self, ahead: f64, angle_rad: f64) -> f64 {
        let unbalance_nm = ahead * self.unbalance_nm * angle_rad.cos();
        let spring_nm = -ahead * self.spring_nm_per_rad * (angle_rad - self.spring_rest_rad);
        unbalance_nm.max(0.0) + spring_nm.max(0.0)
    }
}

/// Lower bound of the friction of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeastFriction {
    /// Static friction (breakaway torque).
    pub static_nm: f64,
    /// Coulomb friction: sliding friction in the limit of zero speed.
    pub coulomb_nm: f64,
    /// Viscous friction per angular rate.
    pub viscous_nm_s_per_rad: f64,
}

impl LeastFriction {
    /// Magnitude of the sliding friction at a speed, N·m.
    pub fn running_nm(&self, speed_rad_per_s: f64) -> f64 {
        self.coulomb_nm + self.viscous_nm_s_per_rad * speed_rad_per_s.abs()
    }
}

/// Data of one axis from which its stops are computed, on the safe side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StopModel {
    /// Lower and upper end of the mechanical travel, which is also the required travel.
    pub travel_rad: [f64; 2],
    /// Lower and upper soft limit, inside `travel_rad`.
    pub soft_limits_rad: [f64; 2],
    /// Inertia about the axis.
    pub inertia_kg_m2: f64,
    /// Deceleration of a controlled stop.
    pub deceleration_rad_per_s2: f64,
    /// Jerk with which this deceleration builds up and ends.
    pub jerk_rad_per_s3: f64,
    /// Delay of the closed loop, from a sampled angle to the torque that answers it. [`Self::controlled_from`]
    /// does not use it: it assumes `blind_s`.
    pub reaction_s: f64,
    /// Longest time for which the axis goes on unchanged before the stop takes effect: a drive whose bus falls silent
    /// reacts only when its watchdog expires. Every computed controlled stop includes this time.
    pub blind_s: f64,
    /// Unbalance and cable spring.
    pub loads: Loads,
    /// Friction that slows the axis down without motor torque.
    pub friction: LeastFriction,
    /// Presliding rebound when the motor torque is removed: static friction over presliding stiffness.
    pub relaxation_rad: f64,
    /// Torque of a brake that engages on loss of power; 0 without one.
    pub brake_nm: f64,
    /// Energy that the end stops take without damage; 0 for bare stops.
    pub end_stop_energy_j: f64,
}

/// Worst case of a controlled stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControlledStop {
    /// Angle from the cause to standstill.
    pub angle_rad: f64,
    /// Time from the cause to standstill.
    pub time_s: f64,
}

impl StopModel {
    /// A controlled stop from this speed, which stays constant until the stop takes effect.
    pub fn controlled(&self, speed_rad_per_s: f64) -> ControlledStop {
        self.controlled_from(speed_rad_per_s, 0.0, self.deceleration_rad_per_s2)
    }

    /// A controlled stop of an axis that accelerates until the stop takes effect.
    ///
    /// `acceleration_rad_per_s2` is positive in the direction of motion. `deceleration_rad_per_s2` is positive: the
    /// deceleration that the motor is known to give.
    ///
    /// Phase 1 lasts `blind_s` = t and covers `v·t + α·t²/2` with the acceleration α. Phase 2 is a jerk-limited ramp from
    /// the speed reached then: `v²/2a + v·a/2j`, or `v·√(v/j)` where the deceleration a is not reached. An allowance for
    /// settling follows.
    pub fn controlled_from(
        &self,
        speed_rad_per_s: f64,
        acceleration_rad_per_s2: f64,
        deceleration_rad_per_s2: f64,
    ) -> ControlledStop {
        let speed = speed_rad_per_s.abs();
        let blind_s = self.blind_s;
        if speed == 0.0 {
            return ControlledStop::default();
        }
        // Speed at which braking begins.
        let v = (speed + acceleration_rad_per_s2 * blind_s).max(0.0);
        let a = deceleration_rad_per_s2;
        let j = self.jerk_rad_per_s3;
        let reaches_full_deceleration = v * j >= a * a;
        let (ramp_rad, ramp_s) = if reaches_full_deceleration {
            (v * v / (2.0 * a) + v * a / (2.0 * j), v / a + a / j)
        } else {
            let rise_s = (v / j).sqrt();
            (v * rise_s, 2.0 * rise_s)
        };
        let reference_rad = 0.5 * (speed + v) * blind_s + ramp_rad;
        ControlledStop {
            angle_rad: (1.0 + SETTLING_RATIO) * reference_rad + SETTLING_RAD,
            time_s: blind_s + ramp_s + SETTLING_S,
        }
    }

    /// Angle left to the soft limit in the direction of motion, rad; negative beyond this limit. The upper limit at rest.
    pub fn room_rad(&self, angle_rad: f64, rate_rad_per_s: f64) -> f64 {
        if rate_rad_per_s >= 0.0 {
            self.soft_limits_rad[1] - angle_rad
        } else {
            angle_rad - self.soft_limits_rad[0]
        }
    }

    /// Whether the axis stays at this angle without motor torque: static friction and brake together must be at least
    /// `RELEASE_MARGIN` times the load torque.
    pub fn holds_without_torque(&self, angle_rad: f64) -> bool {
        self.friction.static_nm + self.brake_nm >= RELEASE_MARGIN * self.loads.at(angle_rad).abs()
    }
}
