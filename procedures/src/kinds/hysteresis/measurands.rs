//! What the kind yields.

use analysis::stribeck::LEAST_POINTS;

use super::sweep::{Reach, Sweep};
use crate::kinds::Measurand;
use crate::quantity::QuantityKind as Q;

pub(super) const FRICTION: &str = "friction-torque";
pub(super) const FRICTION_CURRENT: &str = "friction-current";
pub(super) const COULOMB: &str = "coulomb-torque";
pub(super) const STATIC: &str = "static-torque";
pub(super) const STRIBECK: &str = "stribeck-velocity";
pub(super) const VISCOUS: &str = "viscous-coefficient";
pub(super) const SHAPE: &str = "stribeck-shape";
pub(super) const UNBALANCE: &str = "unbalance-torque";
pub(super) const SPRING: &str = "spring-torque";
pub(super) const STIFFNESS: &str = "spring-stiffness";
pub(super) const ORDER: &str = "cogging-order";
pub(super) const AMPLITUDE: &str = "cogging-amplitude";
pub(super) const AMPLITUDE_CURRENT: &str = "cogging-current";
pub(super) const HARMONIC: &str = "cogging-harmonic";
pub(super) const HARMONIC_CURRENT: &str = "cogging-harmonic-current";
pub(super) const PHASE: &str = "cogging-phase";

const fn measurand(name: &'static str, kind: Q, doc: &'static str) -> Measurand {
    Measurand { name, kind, doc }
}

/// All measurands of the kind.
pub(super) const ALL: &[Measurand] = &[
    measurand(
        FRICTION,
        Q::Torque,
        "Friction torque in sliding at one velocity, mean over whole cogging periods.",
    ),
    measurand(FRICTION_CURRENT, Q::Current, "Friction as motor current, where no torque constant is known."),
    measurand(COULOMB, Q::Torque, "Coulomb torque T_C: sliding friction without its viscous part."),
    measurand(
        STATIC,
        Q::Torque,
        "Static torque T_S: sliding friction extrapolated to rest by the Stribeck curve.",
    ),
    measurand(STRIBECK, Q::AngularVelocity, "Stribeck velocity ω_s."),
    measurand(VISCOUS, Q::Damping, "Viscous coefficient σ2: slope of friction in gross sliding."),
    measurand(SHAPE, Q::Ratio, "Stribeck shape δ."),
    measurand(UNBALANCE, Q::Torque, "Amplitude |A_u| of the unbalance moment A_u·cos θ."),
    measurand(
        SPRING,
        Q::Torque,
        "Largest cable and hose spring torque |K_s·(θ − θ_0)| over the required travel.",
    ),
    measurand(STIFFNESS, Q::Stiffness, "Stiffness K_s of the cable and hose spring."),
    measurand(ORDER, Q::SpatialOrder, "Order of the largest cogging line near the expected one."),
    measurand(AMPLITUDE, Q::Torque, "Amplitude of the largest cogging line near the expected order."),
    measurand(AMPLITUDE_CURRENT, Q::Current, "The same as motor current, where no torque constant is known."),
    measurand(HARMONIC, Q::Torque, "Amplitude of one spatial harmonic of at least 2 % of the largest."),
    measurand(HARMONIC_CURRENT, Q::Current, "The same as motor current, where no torque constant is known."),
    measurand(PHASE, Q::Angle, "Phase φ of one spatial harmonic A·cos(order·θ + φ)."),
];

/// What this sweep yields.
pub(super) fn of(sweep: &Sweep) -> Vec<&'static str> {
    let mut names = vec![FRICTION];
    if sweep.imported() {
        names.push(FRICTION_CURRENT);
    }
    if sweep.velocities_rad_per_s.len() >= 3 {
        names.extend([COULOMB, VISCOUS]);
    }
    if sweep.velocities_rad_per_s.len() >= LEAST_POINTS {
        names.extend([STATIC, STRIBECK, SHAPE]);
    }
    if sweep.gives_gravity() {
        names.extend([UNBALANCE, SPRING, STIFFNESS]);
    }
    if sweep.gives_cogging() {
        names.extend([ORDER, AMPLITUDE, HARMONIC, PHASE]);
    }
    if sweep.imported() {
        names.extend([AMPLITUDE_CURRENT, HARMONIC_CURRENT]);
    }
    names
}

impl Sweep {
    /// Whether unbalance and spring are asked of it: one span for all velocities.
    pub(super) fn gives_gravity(&self) -> bool {
        matches!(self.reach, Reach::Span(_))
            && self.slowest().is_some_and(|v| v <= super::gravity::FASTEST_RAD_PER_S)
    }

    /// Whether cogging is asked of it: a span, or enough periods.
    pub(super) fn gives_cogging(&self) -> bool {
        match self.reach {
            Reach::Span(_) | Reach::Imported => true,
            Reach::Periods { count, .. } => count >= super::cogging::LEAST_PERIODS as u32,
        }
    }
}
