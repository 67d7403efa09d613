//! Where a contact bears more than elsewhere: in one direction, and at a spot of the angle.

use std::f64::consts::PI;

use crate::unit::AxisSettings;

/// `(1 ± a)·(1 + b·½·(1 + cos(π·(θ − θ_s)/w)))` on Coulomb and static torque, the second factor within a width w of the
/// middle of the spot.
#[derive(Clone, Debug)]
pub(super) struct Uneven {
    asymmetry_ratio: f64,
    spot_ratio: f64,
    spot_rad: f64,
    width_rad: f64,
}

impl Uneven {
    /// `None` where the contact of the axis is even.
    pub(super) fn new(axis: &AxisSettings) -> Option<Self> {
        let uneven = Self {
            asymmetry_ratio: axis.friction_asymmetry_ratio,
            spot_ratio: axis.friction_spot_ratio,
            spot_rad: axis.friction_spot_rad,
            width_rad: axis.friction_spot_width_rad,
        };
        (uneven.asymmetry_ratio != 0.0 || uneven.spot_ratio != 0.0).then_some(uneven)
    }

    /// How much more the contact bears at an angle, sliding this way.
    #[inline]
    pub(super) fn factor(&self, angle_rad: f64, velocity_rad_per_s: f64) -> f64 {
        let direction = 1.0 + self.asymmetry_ratio * 1.0_f64.copysign(velocity_rad_per_s);
        let off_rad = (angle_rad - self.spot_rad).abs();
        if self.spot_ratio == 0.0 || off_rad >= self.width_rad {
            return direction;
        }
        direction * (1.0 + 0.5 * self.spot_ratio * (1.0 + (PI * off_rad / self.width_rad).cos()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;

    #[test]
    fn a_spot_is_half_as_high_half_a_width_off_and_a_direction_adds_its_share() {
        let axis = AxisSettings {
            friction_asymmetry_ratio: 0.1,
            friction_spot_ratio: 0.5,
            friction_spot_rad: 0.2,
            friction_spot_width_rad: 0.1,
            ..UnitSettings::default().az
        };
        let uneven = Uneven::new(&axis).expect("uneven");
        for (angle_rad, velocity, expected) in [
            (0.2, 1.0, 1.1 * 1.5),
            (0.25, 1.0, 1.1 * 1.25),
            (0.15, -1.0, 0.9 * 1.25),
            (0.31, 1.0, 1.1),
            (0.0, -1.0, 0.9),
        ] {
            let found = uneven.factor(angle_rad, velocity);
            assert!((found - expected).abs() < 1e-12, "{angle_rad}, {velocity}: {found}");
        }
        assert!(Uneven::new(&UnitSettings::default().az).is_none());
    }
}
