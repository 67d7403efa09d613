//! Torque that depends on the angle alone: cogging, unbalance, cable spring.

use super::phasor::Phasor;
use crate::unit::AxisSettings;

/// `A_1·sin(nθ + p_1) + A_2·sin(2nθ + p_2) + A_r·sin(mθ + p_r) + A_u·cos θ − K_s·(θ − θ_0)`.
#[derive(Clone, Debug)]
pub struct AngleTorque {
    cogging: Phasor,
    first: [f64; 2],
    second: [f64; 2],
    /// The order m beside cogging; `None` without.
    ripple: Option<Ripple>,
    gravity: Phasor,
    unbalance_nm: f64,
    spring_nm_per_rad: f64,
    rest_rad: f64,
}

/// A torque order: A·sin(mθ + p) as coefficients of sine and cosine.
#[derive(Clone, Debug)]
struct Ripple {
    turned: Phasor,
    parts: [f64; 2],
}

impl AngleTorque {
    /// The torques of an axis that stands at `angle_rad`.
    pub fn new(axis: &AxisSettings, angle_rad: f64) -> Self {
        let parts = |amplitude: f64, phase: f64| [amplitude * phase.cos(), amplitude * phase.sin()];
        Self {
            cogging: Phasor::new(axis.cogging_orders_per_rev, angle_rad),
            first: parts(axis.cogging_amplitude_nm, axis.cogging_phase_rad),
            second: parts(axis.cogging_second_amplitude_nm, axis.cogging_second_phase_rad),
            ripple: (axis.ripple_amplitude_nm != 0.0).then(|| Ripple {
                turned: Phasor::new(axis.ripple_orders_per_rev, angle_rad),
                parts: parts(axis.ripple_amplitude_nm, axis.ripple_phase_rad),
            }),
            gravity: Phasor::new(1.0, angle_rad),
            unbalance_nm: axis.unbalance_nm,
            spring_nm_per_rad: axis.spring_stiffness_nm_per_rad,
            rest_rad: axis.spring_rest_rad,
        }
    }

    /// The sum at an angle, N·m, positive towards larger angles.
    #[inline]
    pub fn at(&mut self, angle_rad: f64) -> f64 {
        let (sin, cos) = self.cogging.turn_to(angle_rad);
        let sin_twice = 2.0 * sin * cos;
        let cos_twice = 1.0 - 2.0 * sin * sin;
        let cogging = self.first[0] * sin
            + self.first[1] * cos
            + self.second[0] * sin_twice
            + self.second[1] * cos_twice;
        let gravity = if self.unbalance_nm == 0.0 {
            0.0
        } else {
            self.unbalance_nm * self.gravity.turn_to(angle_rad).1
        };
        let even = cogging + gravity - self.spring_nm_per_rad * (angle_rad - self.rest_rad);
        let Some(ripple) = &mut self.ripple else { return even };
        let (sin, cos) = ripple.turned.turn_to(angle_rad);
        even + ripple.parts[0] * sin + ripple.parts[1] * cos
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;

    #[test]
    fn the_sum_is_the_formula_term_by_term() {
        let axis =
            AxisSettings { ripple_amplitude_nm: 7.0, ripple_phase_rad: 0.3, ..UnitSettings::default().el };
        let mut torque = AngleTorque::new(&axis, 0.0);
        for k in -20..=150 {
            let angle = f64::from(k) * 0.01;
            let phase = axis.cogging_orders_per_rev * angle;
            let expected = axis.cogging_amplitude_nm * (phase + axis.cogging_phase_rad).sin()
                + axis.cogging_second_amplitude_nm * (2.0 * phase + axis.cogging_second_phase_rad).sin()
                + 7.0 * (axis.ripple_orders_per_rev * angle + 0.3).sin()
                + axis.unbalance_nm * angle.cos()
                - axis.spring_stiffness_nm_per_rad * (angle - axis.spring_rest_rad);
            assert!((torque.at(angle) - expected).abs() < 1e-11);
        }
    }
}
