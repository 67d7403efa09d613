//! Kind `hysteresis`: strokes at constant velocity back and forth between the same limits.

use analysis::stribeck::LEAST_POINTS;

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod cogging;
mod conclude;
mod evenness;
mod peak;
mod pictures;
mod point;
mod reach;
mod static_map;
mod strokes;
mod sweep;

#[cfg(test)]
pub(in crate::kinds) mod tests;

pub(in crate::kinds) use strokes::{Branches, Strokes};
use sweep::{Reach, Sweep};

const FRICTION: &str = "friction-torque";
const FRICTION_CURRENT: &str = "friction-current";
const DIRECTIONS: &str = "friction-difference";
const UNEVENNESS: &str = "friction-unevenness";
const COULOMB: &str = "coulomb-torque";
const STATIC: &str = "static-torque";
const STRIBECK: &str = "stribeck-velocity";
const VISCOUS: &str = "viscous-coefficient";
const SHAPE: &str = "stribeck-shape";
const UNBALANCE: &str = "unbalance-torque";
const SPRING: &str = "spring-torque";
const STIFFNESS: &str = "spring-stiffness";
const ORDER: &str = "cogging-order";
const AMPLITUDE: &str = "cogging-amplitude";
const AMPLITUDE_CURRENT: &str = "cogging-current";
const HARMONIC: &str = "cogging-harmonic";
const HARMONIC_CURRENT: &str = "cogging-harmonic-current";
const PHASE: &str = "cogging-phase";
const PEAK: &str = "cogging-peak";
const PEAK_CURRENT: &str = "cogging-peak-current";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        FRICTION,
        Q::Torque,
        "Friction torque in sliding at one velocity, mean over whole cogging periods.",
    ),
    Measurand::new(
        FRICTION_CURRENT,
        Q::Current,
        "Friction torque in sliding as motor current, for records without a torque constant.",
    ),
    Measurand::new(
        DIRECTIONS,
        Q::Torque,
        "Half the difference of friction between the directions, as a magnitude; it includes a constant \
         load (unbalance, spring).",
    ),
    Measurand::new(
        UNEVENNESS,
        Q::Ratio,
        "Largest friction of any one cogging period over the mean of all periods, less 1.",
    ),
    Measurand::new(COULOMB, Q::Torque, "Coulomb torque T_C: sliding friction without its viscous part."),
    Measurand::new(
        STATIC,
        Q::Torque,
        "Static torque T_S: sliding friction extrapolated to rest by the Stribeck curve.",
    ),
    Measurand::new(STRIBECK, Q::AngularVelocity, "Stribeck velocity ω_s."),
    Measurand::new(VISCOUS, Q::Damping, "Viscous coefficient σ2: slope of friction in gross sliding."),
    Measurand::new(SHAPE, Q::Ratio, "Stribeck shape δ, an exponent without unit: 100 % stands for 1."),
    Measurand::new(UNBALANCE, Q::Torque, "Amplitude |A_u| of the unbalance moment A_u·cos θ."),
    Measurand::new(
        SPRING,
        Q::Torque,
        "Largest cable and hose spring torque |K_s·(θ − θ_0)| over the required travel.",
    ),
    Measurand::new(STIFFNESS, Q::Stiffness, "Stiffness K_s of the cable and hose spring."),
    Measurand::new(ORDER, Q::SpatialOrder, "Order of the largest cogging line near the expected one."),
    Measurand::new(AMPLITUDE, Q::Torque, "Amplitude of the largest cogging line near the expected order."),
    Measurand::new(
        AMPLITUDE_CURRENT,
        Q::Current,
        "Amplitude of the largest cogging line as motor current, for records without a torque constant.",
    ),
    Measurand::new(HARMONIC, Q::Torque, "Amplitude of one spatial harmonic of at least 2 % of the largest."),
    Measurand::new(
        HARMONIC_CURRENT,
        Q::Current,
        "Amplitude of one spatial harmonic as motor current, for records without a torque constant.",
    ),
    Measurand::new(PHASE, Q::Angle, "Phase φ of one spatial harmonic A·cos(order·θ + φ)."),
    Measurand::new(
        PEAK,
        Q::Torque,
        "Peak of the cogging ripple: largest magnitude of the sum of all spatial harmonics over the travel.",
    ),
    Measurand::new(
        PEAK_CURRENT,
        Q::Current,
        "Peak of the cogging ripple as motor current, for records without a torque constant.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Sweep>("hysteresis", include_str!("hysteresis/doc.md"), sweep::FIELDS, MEASURANDS);

impl Experiment for Sweep {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let mut names = vec![FRICTION];
        if self.imported() {
            names.push(FRICTION_CURRENT);
        } else {
            names.extend([DIRECTIONS, UNEVENNESS]);
        }
        if self.velocities_rad_per_s.len() >= 3 {
            names.extend([COULOMB, VISCOUS]);
        }
        if self.velocities_rad_per_s.len() >= LEAST_POINTS {
            names.extend([STATIC, STRIBECK, SHAPE]);
        }
        if self.gives_gravity() {
            names.extend([UNBALANCE, SPRING, STIFFNESS]);
        }
        if self.gives_cogging() {
            names.extend([ORDER, AMPLITUDE, HARMONIC, PHASE, PEAK]);
        }
        if self.imported() {
            names.extend([AMPLITUDE_CURRENT, HARMONIC_CURRENT, PEAK_CURRENT]);
        }
        Some(names)
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        sweep::plan(self, axis, axes)
    }

    fn cuts(&self, axis: &str, axes: &Axes) -> Vec<String> {
        reach::cuts(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        conclude::conclude(self, cases, points, axes)
    }
}

impl Sweep {
    /// Whether unbalance and spring are asked of the sweep: one span for all velocities, a slow one among them.
    fn gives_gravity(&self) -> bool {
        matches!(self.reach, Reach::Span(_))
            && self.slowest().is_some_and(|v| v <= conclude::FASTEST_FOR_GRAVITY_RAD_PER_S)
    }

    /// Whether cogging is asked of the sweep: a span, or enough periods.
    fn gives_cogging(&self) -> bool {
        match self.reach {
            Reach::Span(_) | Reach::Imported => true,
            Reach::Periods { count, .. } => count >= cogging::LEAST_PERIODS as u32,
        }
    }
}
