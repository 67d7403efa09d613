use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

mod arms;
mod decisions;
mod files;
mod properties;
mod statistics;

/// A criterion on a difference in hertz whose higher values are worse, of this name.
pub(super) fn criterion(requirement: &str, margin: f64) -> Criterion {
    Criterion {
        requirement: requirement.to_owned(),
        measurand: "velocity-bandwidth".to_owned(),
        place: String::new(),
        kind: QuantityKind::Frequency,
        margin,
        scale: Scale::Difference,
        worse: Worse::Higher,
        blocking: true,
    }
}

pub(super) fn criteria(all: Vec<Criterion>) -> Criteria {
    Criteria { looks: vec![5, 10, 20, 40], all }
}

pub(super) fn reading(value: f64) -> Reading {
    Reading { value: Some(value), u: 0.01, passes: true }
}

/// Samples of one criterion: units 1, 2, … with a baseline of 10 and these shifts.
pub(super) fn shifted(of: &Criterion, shifts: &[f64]) -> CriterionSamples {
    let sample = |(unit, shift): (u32, &f64)| Sample {
        unit,
        seed: 1,
        baseline: reading(10.0),
        candidate: reading(10.0 + shift),
    };
    CriterionSamples {
        requirement: of.requirement.clone(),
        measurand: of.measurand.clone(),
        place: of.place.clone(),
        samples: (1..).zip(shifts).map(sample).collect(),
    }
}

/// The outcome of a single criterion with these shifts.
pub(super) fn outcome_of(of: &Criterion, shifts: &[f64]) -> Outcome {
    let decision = decide(&criteria(vec![of.clone()]), &[shifted(of, shifts)], Look::Single);
    decision.expect("good samples").outcomes.remove(0)
}

/// Standard normal numbers, the same on every machine up to rounding: Box and Muller's method.
pub(super) fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move || {
        let mut uniform = || (f64::from(random.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0);
        let radius = (-2.0 * uniform().ln()).sqrt();
        radius * (std::f64::consts::TAU * uniform()).cos()
    }
}
