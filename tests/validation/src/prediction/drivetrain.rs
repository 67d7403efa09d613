//! What motor, friction and loads let an axis do.

use sim_devices::physics::lugre::LuGre;
use sim_devices::unit::AxisSettings;

use super::{Subject, rig_limits};

/// Rate at which motion is required.
pub(super) const REQUIRED_RAD_PER_S: f64 = 60.0 * DEG;
/// Elevations in which azimuth is moved for MOT-ACC and the duty cycle (our choice: the study names one inertia).
pub(super) const POSES_DEG: [f64; 2] = [0.0, 45.0];

const DEG: f64 = std::f64::consts::PI / 180.0;
/// Only a scale for the steps of the friction law; its steady torque does not depend on it.
const ANY_STEP_S: f64 = 1e-3;

/// One axis at an elevation.
pub(super) struct Drivetrain<'a> {
    pub(super) axis: &'a AxisSettings,
    pub(super) inertia_kg_m2: f64,
    friction: LuGre,
    index: usize,
}

impl<'a> Drivetrain<'a> {
    pub(super) fn new(subject: &'a Subject<'_>, index: usize, elevation_deg: f64) -> Self {
        let axis = subject.axis(index);
        let structure = subject.structure(index);
        let gain = structure.interpolate(&structure.rigid_gain_ratio, elevation_deg * DEG);
        Self { axis, inertia_kg_m2: axis.inertia_kg_m2 / gain, friction: LuGre::new(axis, ANY_STEP_S), index }
    }

    /// Largest current: the drive's own limit, and what the rig's torque limit is to the drive.
    pub(super) fn current_a(&self) -> f64 {
        let believed_nm_per_a = self.axis.rated_torque_nm / self.axis.rated_current_a;
        self.axis.current_limit_a.min(rig_limits::TORQUE_NM[self.index] / believed_nm_per_a)
    }

    /// Largest true torque.
    pub(super) fn torque_nm(&self) -> f64 {
        self.current_a() * self.axis.torque_constant_nm_per_a
    }

    /// Steady friction at a rate, with its sign.
    pub(super) fn friction_nm(&self, rate_rad_per_s: f64) -> f64 {
        if rate_rad_per_s == 0.0 { 0.0 } else { self.friction.steady_torque_nm(rate_rad_per_s) }
    }

    /// Torque of unbalance and spring at an angle, on the axis.
    pub(super) fn load_nm(&self, angle_rad: f64) -> f64 {
        let spring_nm = self.axis.spring_stiffness_nm_per_rad * (angle_rad - self.axis.spring_rest_rad);
        self.axis.unbalance_nm * angle_rad.cos() - spring_nm
    }

    /// Largest of these over the travel.
    pub(super) fn worst_load_nm(&self) -> f64 {
        let [low, high] = rig_limits::TRAVEL_RAD[self.index];
        let angle = |k: u32| low + (high - low) * f64::from(k) / 100.0;
        (0..=100).map(|k| self.load_nm(angle(k)).abs()).fold(0.0, f64::max)
    }

    /// Acceleration left at a rate, against the worst loads.
    pub(super) fn acceleration_rad_per_s2(&self, rate_rad_per_s: f64) -> f64 {
        (self.torque_nm() - self.friction_nm(rate_rad_per_s) - self.worst_load_nm()) / self.inertia_kg_m2
    }

    /// Deceleration at a rate, the worst loads pushing on.
    pub(super) fn deceleration_rad_per_s2(&self, rate_rad_per_s: f64) -> f64 {
        (self.torque_nm() + self.friction_nm(rate_rad_per_s) - self.worst_load_nm()) / self.inertia_kg_m2
    }

    /// Highest rate that can be reached and stopped from within the soft limits, up to the rig's own limit: distances
    /// `∫ω dω/a(ω)` of speeding up and of braking, accelerations never above the rig's.
    pub(super) fn reachable_rad_per_s(&self) -> f64 {
        const STEP_RAD_PER_S: f64 = 0.002;
        let [low, high] = rig_limits::SOFT_RAD[self.index];
        let most = rig_limits::ACCELERATION_RAD_PER_S2;
        let mut rate = 0.0;
        let mut distance_rad = 0.0;
        while rate < rig_limits::VELOCITY_RAD_PER_S {
            let middle = rate + 0.5 * STEP_RAD_PER_S;
            let up = self.acceleration_rad_per_s2(middle).min(most);
            let down = self.deceleration_rad_per_s2(middle).min(most);
            if up <= 0.0 || down <= 0.0 {
                break;
            }
            distance_rad += middle * STEP_RAD_PER_S * (1.0 / up + 1.0 / down);
            if distance_rad > high - low {
                break;
            }
            rate += STEP_RAD_PER_S;
        }
        rate.min(rig_limits::VELOCITY_RAD_PER_S)
    }
}
