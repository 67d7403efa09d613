//! Soft limits: the largest rate from which an axis still stops in front of them.

use crate::{EnvelopeSettings, finite_or_zero};

/// Rate over the distance that is left: `v = √(ρ² + 2 a d) − ρ` with `ρ = e·a·τ`; a the deceleration, τ the reaction
/// time.
///
/// Stopping takes `v·τ + v²/(2a)`. But this rate is commanded anew each tick, and a rate that follows the distance
/// with a delay closes a loop of slope dv/dd around it: it comes to rest without passing as long as slope times delay
/// is at most 1/e (El'sgol'ts & Norkin, *Introduction to the Theory of Differential Equations with Deviating
/// Arguments*, 1973, on `x' = −k x(t − τ)`). The slope is largest at rest, a/ρ = 1/(e τ): hence the factor e.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakingCurve {
    /// ρ.
    reaction_rad_per_s: f64,
    twice_deceleration: f64,
}

impl BrakingCurve {
    /// A curve; anything that is not finite or below 0 counts as 0: then nothing is allowed to move.
    pub fn new(settings: &EnvelopeSettings) -> Self {
        let deceleration = finite_or_zero(settings.deceleration_rad_per_s2).max(0.0);
        let reaction_s = finite_or_zero(settings.reaction_time_s).max(0.0);
        Self {
            reaction_rad_per_s: core::f64::consts::E * deceleration * reaction_s,
            twice_deceleration: 2.0 * deceleration,
        }
    }

    /// Largest rate towards something this far ahead; 0 at it and beyond it.
    pub fn rate_rad_per_s(&self, distance_rad: f64) -> f64 {
        let distance_rad = finite_or_zero(distance_rad).max(0.0);
        let square = self.reaction_rad_per_s * self.reaction_rad_per_s;
        libm::sqrt(square + self.twice_deceleration * distance_rad) - self.reaction_rad_per_s
    }
}

/// Soft limits of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftLimits {
    lower_rad: f64,
    upper_rad: f64,
    curve: BrakingCurve,
}

impl SoftLimits {
    /// `None` unless lower < upper.
    pub fn new(lower_rad: f64, upper_rad: f64, settings: &EnvelopeSettings) -> Option<Self> {
        (lower_rad < upper_rad).then(|| Self { lower_rad, upper_rad, curve: BrakingCurve::new(settings) })
    }

    /// The rate nearest to the wanted one that keeps the axis inside. Beyond a limit only rates back inside are left.
    ///
    /// A wanted rate that is not finite counts as 0, and so does any rate while the position is not known.
    pub fn limit(&self, position_rad: f64, wanted_rad_per_s: f64) -> f64 {
        if !position_rad.is_finite() {
            return 0.0;
        }
        let up = self.curve.rate_rad_per_s(self.upper_rad - position_rad);
        let down = self.curve.rate_rad_per_s(position_rad - self.lower_rad);
        finite_or_zero(wanted_rad_per_s).max(-down).min(up)
    }
}

#[cfg(test)]
mod tests;
