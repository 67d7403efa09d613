//! LuGre friction with ageing of the contact (Canudas de Wit et al. 1995; the ageing state is ours).
//!
//! `T_f = σ0·z + σ1·ż + σ2·ω`, `ż = ω − σ0·|ω|·z / s(ω, φ)`,
//! `s(ω, φ) = T_C + (T_S(φ) − T_C)·exp(−|ω/ω_s|^δ)`, `T_S(φ) = T_S0 + ΔT·ln(1 + φ/τ_d)`,
//! `φ̇ = 1 − |ω|·φ/D_c`, `D_c = T_S0/σ0`.
//!
//! `s` is larger in one direction and at a spot of the angle where the settings say so, see [`Uneven`].
//!
//! For a velocity that is constant over a step both states have exact solutions; those are used, so the bristle is
//! stable at any step width.

mod uneven;

use super::octave_table::OctaveTable;
use crate::unit::AxisSettings;
use uneven::Uneven;

/// Beyond this exponent the Stribeck term is below half a unit in the last place of the Coulomb torque.
const EXTINCT_EXPONENT: f64 = 40.0;

/// Below this speed, 2^−50 rad/s, the Stribeck term is what it is at rest.
const LOWEST_SPEED_OCTAVE: i32 = -50;
/// Below this age, 2^−30 s, a contact is fresh.
const LOWEST_AGE_OCTAVE: i32 = -30;

/// State of the contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Mean deflection of the bristles z.
    pub deflection_rad: f64,
    /// Age of the contact φ.
    pub age_s: f64,
}

/// The friction law of one axis, for one step width.
#[derive(Clone, Debug)]
pub struct LuGre {
    step_s: f64,
    sigma0: f64,
    sigma1: f64,
    /// σ1/h.
    sigma1_per_step: f64,
    sigma2: f64,
    coulomb_nm: f64,
    static_excess_nm: f64,
    shape: f64,
    per_stribeck_velocity: f64,
    extinct_velocity_rad_per_s: f64,
    ageing_nm: f64,
    per_ageing_time: f64,
    age_limit_s: f64,
    per_ageing_distance: f64,
    /// exp(−|ω/ω_s|^δ) and ln(1 + φ/τ_d): a power and a logarithm each step would be half of the plant's work.
    stribeck: OctaveTable,
    log_age: OctaveTable,
    /// `None`: alike in both directions and at all angles.
    uneven: Option<Uneven>,
}

/// Friction over one step as a line in the step's mean velocity, and what the step does to the contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrictionStep {
    /// Mean torque over the step at zero mean velocity.
    pub(crate) offset_nm: f64,
    /// Growth of the mean torque with the mean velocity.
    pub(crate) slope_nm_s_per_rad: f64,
    decay: f64,
    gain_s: f64,
    age_s: f64,
    /// Whether neither state notices the velocity at all in double precision.
    pub(crate) standing: bool,
}

impl LuGre {
    /// The law of an axis for steps of `step_s`.
    pub fn new(axis: &AxisSettings, step_s: f64) -> Self {
        let shape = axis.stribeck_shape_exponent;
        let velocity = axis.stribeck_velocity_rad_per_s;
        let stribeck = |speed: f64| (-(speed / velocity).powf(shape)).exp();
        let extinct = velocity * EXTINCT_EXPONENT.powf(1.0 / shape);
        let highest = (extinct.log2().ceil() as i32).max(LOWEST_SPEED_OCTAVE + 1);
        let log_age = |age_s: f64| (age_s / axis.ageing_time_s).ln_1p();
        let oldest = (axis.ageing_limit_s.log2().floor() as i32 + 1).max(LOWEST_AGE_OCTAVE + 1);
        Self {
            stribeck: OctaveTable::new(LOWEST_SPEED_OCTAVE, highest, 1.0, 0.0, stribeck),
            log_age: OctaveTable::new(LOWEST_AGE_OCTAVE, oldest, 0.0, log_age(axis.ageing_limit_s), log_age),
            step_s,
            sigma0: axis.bristle_stiffness_nm_per_rad,
            sigma1: axis.bristle_damping_nm_s_per_rad,
            sigma1_per_step: axis.bristle_damping_nm_s_per_rad / step_s,
            sigma2: axis.viscous_damping_nm_s_per_rad,
            coulomb_nm: axis.coulomb_torque_nm,
            static_excess_nm: axis.static_torque_nm - axis.coulomb_torque_nm,
            shape: axis.stribeck_shape_exponent,
            per_stribeck_velocity: 1.0 / axis.stribeck_velocity_rad_per_s,
            extinct_velocity_rad_per_s: axis.stribeck_velocity_rad_per_s
                * EXTINCT_EXPONENT.powf(1.0 / axis.stribeck_shape_exponent),
            ageing_nm: axis.ageing_ratio * axis.static_torque_nm,
            per_ageing_time: 1.0 / axis.ageing_time_s,
            age_limit_s: axis.ageing_limit_s,
            per_ageing_distance: axis.bristle_stiffness_nm_per_rad / axis.static_torque_nm,
            uneven: Uneven::new(axis),
        }
    }

    /// s(ω, φ): the torque that the bristles bear in steady sliding where the contact is even, N·m.
    pub fn sliding_torque_nm(&self, velocity_rad_per_s: f64, age_s: f64) -> f64 {
        let speed = velocity_rad_per_s.abs();
        if speed >= self.extinct_velocity_rad_per_s {
            return self.coulomb_nm;
        }
        let exponent = (speed * self.per_stribeck_velocity).powf(self.shape);
        let aged = self.ageing_nm * (age_s * self.per_ageing_time).ln_1p();
        self.coulomb_nm + (self.static_excess_nm + aged) * (-exponent).exp()
    }

    /// [`Self::sliding_torque_nm`] from the tables, to 10⁻⁹.
    #[inline]
    fn tabled_torque_nm(&self, velocity_rad_per_s: f64, age_s: f64) -> f64 {
        let speed = velocity_rad_per_s.abs();
        if speed >= self.extinct_velocity_rad_per_s {
            return self.coulomb_nm;
        }
        let static_nm = self.static_excess_nm + self.ageing_nm * self.log_age.at(age_s);
        self.coulomb_nm + static_nm * self.stribeck.at(speed)
    }

    /// Friction torque of steady sliding, `s·sgn ω + σ2·ω` with the contact's age `D_c/|ω|`, N·m.
    pub fn steady_torque_nm(&self, velocity_rad_per_s: f64) -> f64 {
        let travelled = (velocity_rad_per_s * self.per_ageing_distance).abs();
        let age_s = (1.0 / travelled).min(self.age_limit_s);
        let bristles = self.sliding_torque_nm(velocity_rad_per_s, age_s);
        bristles.copysign(velocity_rad_per_s) + self.sigma2 * velocity_rad_per_s
    }

    /// Moves the contact by one step at a given velocity, at angle 0; the mean friction torque over the step, N·m.
    pub fn advance(&self, contact: &mut Contact, velocity_rad_per_s: f64) -> f64 {
        let step = self.predict(contact, 0.0, velocity_rad_per_s);
        step.apply(contact, velocity_rad_per_s);
        step.offset_nm + step.slope_nm_s_per_rad * velocity_rad_per_s
    }

    /// Friction of the coming step from an angle, around an expected velocity.
    #[inline]
    pub(crate) fn predict(&self, contact: &Contact, angle_rad: f64, expected_rad_per_s: f64) -> FrictionStep {
        let h = self.step_s;
        let z = contact.deflection_rad;
        let swept_rad = expected_rad_per_s.abs() * h;
        let (age_decay, age_growth) = relaxation(swept_rad * self.per_ageing_distance);
        let age_s = (contact.age_s * age_decay + h * age_growth).min(self.age_limit_s);
        let mut bristles_nm = self.tabled_torque_nm(expected_rad_per_s, 0.5 * (contact.age_s + age_s));
        if let Some(uneven) = &self.uneven {
            bristles_nm *= uneven.factor(angle_rad, expected_rad_per_s);
        }
        let (decay, growth) = relaxation(self.sigma0 * swept_rad / bristles_nm);
        FrictionStep {
            offset_nm: z * (0.5 * self.sigma0 * (1.0 + decay) - self.sigma1_per_step * (1.0 - decay)),
            slope_nm_s_per_rad: (0.5 * self.sigma0 * h + self.sigma1) * growth + self.sigma2,
            decay,
            gain_s: h * growth,
            age_s,
            standing: decay == 1.0 && growth == 1.0 && age_decay == 1.0 && age_growth == 1.0,
        }
    }

    /// The age of a standing contact after one more step; the same arithmetic as in [`LuGre::predict`].
    #[inline]
    pub(crate) fn age_standing(&self, contact: &mut Contact) {
        contact.age_s = (contact.age_s + self.step_s).min(self.age_limit_s);
    }
}

impl FrictionStep {
    /// Carries the contact to the end of the step whose mean velocity is now known.
    #[inline]
    pub(crate) fn apply(&self, contact: &mut Contact, mean_rad_per_s: f64) {
        contact.deflection_rad = self.decay * contact.deflection_rad + self.gain_s * mean_rad_per_s;
        contact.age_s = self.age_s;
    }
}

/// `e^−x` and `(1 − e^−x)/x` for `x ≥ 0`; below 0.1 by series, whose remainder x⁸/9! is under 3·10⁻¹⁴.
#[inline]
fn relaxation(x: f64) -> (f64, f64) {
    if x > 0.1 {
        let lost = -(-x).exp_m1();
        return (1.0 - lost, lost / x);
    }
    let tail = 1.0 / 120.0 - x * (1.0 / 720.0 - x * (1.0 / 5040.0 - x / 40320.0));
    let growth = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * tail)));
    (1.0 - x * growth, growth)
}

#[cfg(test)]
mod tests;
