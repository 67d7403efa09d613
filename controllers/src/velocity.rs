//! Velocity loop: torque from a rate command and a measured rate, by the law that the gains of the axis name.
//!
//! A further law is a file of its own, a variant of [`VelocityController`] and a row of [`LAWS`].

use crate::AxisGains;

mod pi;

pub use pi::Pi;

/// A law of the velocity loop.
pub struct Law {
    /// Name in parameter files.
    pub name: &'static str,
    /// What it does, in one sentence.
    pub doc: &'static str,
    /// Makes a controller from gains, torque limit and period.
    make: fn(&AxisGains, f64, f64) -> VelocityController,
}

/// Every law that parameters may name; the first one is the default.
pub const LAWS: &[Law] = &[Law {
    name: "pi",
    doc: "PI on the velocity error with feed-forward; the integral is frozen while the torque is limited.",
    make: |gains, torque_limit_nm, period_s| {
        VelocityController::Pi(Pi::new(gains, torque_limit_nm, period_s))
    },
}];

/// Which of the [`LAWS`] closes the velocity loop of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VelocityLaw(usize);

impl VelocityLaw {
    /// The first of the [`LAWS`].
    pub const DEFAULT: Self = Self(0);

    /// The law of this name.
    pub fn named(name: &str) -> Option<Self> {
        LAWS.iter().position(|law| law.name == name).map(Self)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        LAWS[self.0].name
    }
}

/// Velocity loop of an axis by one of the [`LAWS`].
#[derive(Clone, Debug, PartialEq)]
pub enum VelocityController {
    /// `pi`.
    Pi(Pi),
}

impl VelocityController {
    /// The law that the gains name at zero torque, updated every `period_s`; it never asks for more than
    /// ± `torque_limit_nm`.
    pub fn new(gains: &AxisGains, torque_limit_nm: f64, period_s: f64) -> Self {
        (LAWS[gains.velocity_law.0].make)(gains, torque_limit_nm, period_s)
    }

    /// Bumpless start: at zero velocity error and without feed-forward the next torque is `torque_nm`.
    pub fn reset(&mut self, torque_nm: f64) {
        match self {
            Self::Pi(law) => law.reset(torque_nm),
        }
    }

    /// Bumpless start from what was sent: the next torque at this reference, rate and feed-forward is `torque_nm`, but for
    /// one step of an integral.
    pub fn take_over(
        &mut self,
        torque_nm: f64,
        reference_rad_per_s: f64,
        velocity_rad_per_s: f64,
        feed_forward_nm: f64,
    ) {
        match self {
            Self::Pi(law) => {
                law.take_over(torque_nm, reference_rad_per_s, velocity_rad_per_s, feed_forward_nm)
            }
        }
    }

    /// One tick; returns the torque. A sample that is not finite counts as no error, no feed-forward.
    pub fn update(&mut self, reference_rad_per_s: f64, velocity_rad_per_s: f64, feed_forward_nm: f64) -> f64 {
        match self {
            Self::Pi(law) => law.update(reference_rad_per_s, velocity_rad_per_s, feed_forward_nm),
        }
    }

    /// Whether the last torque was limited.
    pub fn is_saturated(&self) -> bool {
        match self {
            Self::Pi(law) => law.is_saturated(),
        }
    }
}

#[cfg(test)]
mod tests;
