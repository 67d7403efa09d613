//! Hard stops: stiff contacts that push, never pull, and lose energy.

use crate::unit::AxisSettings;

/// Both ends of an axis.
#[derive(Clone, Debug)]
pub struct Stops {
    ends_rad: [f64; 2],
    stiffness_nm_per_rad: f64,
    damping_nm_s_per_rad: f64,
}

impl Stops {
    /// The stops of an axis.
    pub fn new(axis: &AxisSettings) -> Self {
        Self {
            ends_rad: [axis.lower_stop_rad, axis.upper_stop_rad],
            stiffness_nm_per_rad: axis.stop_stiffness_nm_per_rad,
            damping_nm_s_per_rad: axis.stop_damping_nm_s_per_rad,
        }
    }

    /// How deep the axis is inside a stop, signed like the angle; zero when free.
    #[inline]
    pub fn depth_rad(&self, angle_rad: f64) -> f64 {
        let [lower, upper] = self.ends_rad;
        if angle_rad > upper {
            angle_rad - upper
        } else if angle_rad < lower {
            angle_rad - lower
        } else {
            0.0
        }
    }

    /// Distance to the nearer stop, negative inside it.
    pub fn clearance_rad(&self, angle_rad: f64) -> f64 {
        (self.ends_rad[1] - angle_rad).min(angle_rad - self.ends_rad[0])
    }

    /// Mean velocity of a step that begins `depth_rad` inside a stop, by the same implicit midpoint rule as the
    /// free step `velocity = push/mass`; `None` when the stop would have to pull.
    pub(crate) fn midpoint_rad_per_s(
        &self,
        depth_rad: f64,
        push: f64,
        mass: f64,
        step_s: f64,
    ) -> Option<f64> {
        let k = self.stiffness_nm_per_rad;
        let d = self.damping_nm_s_per_rad;
        let velocity = (push - k * depth_rad) / (mass + 0.5 * k * step_s + d);
        let torque = -k * (depth_rad + 0.5 * step_s * velocity) - d * velocity;
        (torque * depth_rad < 0.0).then_some(velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;

    #[test]
    fn depth_is_signed_and_zero_between_the_stops() {
        let stops = Stops::new(&UnitSettings::default().el);
        assert_eq!(stops.depth_rad(0.5), 0.0);
        assert!((stops.depth_rad(91.0_f64.to_radians()) - 0.5_f64.to_radians()).abs() < 1e-12);
        assert!((stops.depth_rad((-11.0_f64).to_radians()) + 0.5_f64.to_radians()).abs() < 1e-12);
        assert!((stops.clearance_rad(90.0_f64.to_radians()) - 0.5_f64.to_radians()).abs() < 1e-12);
    }

    #[test]
    fn a_stop_never_pulls_a_receding_axis() {
        let stops = Stops::new(&UnitSettings::default().el);
        let mass = 2.0 * 975.0 / 50e-6;
        assert_eq!(stops.midpoint_rad_per_s(1e-6, -2.0 * mass, mass, 50e-6), None);
        assert!(stops.midpoint_rad_per_s(1e-3, 0.0, mass, 50e-6).is_some_and(|v| v < 0.0));
    }
}
