//! Promises in numbers: seeded comparisons, counts held against the exact binomial distribution.

use analysis::paired::{Plan, PlannedCall};
use analysis::proportion::{probability_of_at_least, probability_of_at_most};

use super::*;

const COMPARISONS: u64 = 2000;
/// A count that is less probable than this is not chance.
const LEAST_PROBABILITY: f64 = 0.01;

/// Whether as many of all comparisons are explained by a probability of at most `p`.
fn is_at_most(count: u64, p: f64) -> bool {
    probability_of_at_least(count, COMPARISONS, p).expect("a probability") > LEAST_PROBABILITY
}

/// Whether as few are explained by a probability of at least `p`.
fn is_at_least(count: u64, p: f64) -> bool {
    probability_of_at_most(count, COMPARISONS, p).expect("a probability") > LEAST_PROBABILITY
}

/// Shifts of a family of criteria that do not differ: a part of each is shared by all criteria of a unit.
fn family(noise: &mut impl FnMut() -> f64, units: usize, shared: f64) -> Vec<Vec<f64>> {
    let own = (1.0 - shared * shared).sqrt();
    let common: Vec<f64> = (0..units).map(|_| noise()).collect();
    (0..10).map(|_| common.iter().map(|common| shared * common + own * noise()).collect()).collect()
}

fn ten() -> Criteria {
    criteria((0..10).map(|number| criterion(&format!("R{number}"), 0.3)).collect())
}

fn samples(all: &Criteria, shifts: &[Vec<f64>], units: usize) -> Vec<CriterionSamples> {
    all.all.iter().zip(shifts).map(|(criterion, shifts)| shifted(criterion, &shifts[..units])).collect()
}

#[test]
fn a_family_of_ten_criteria_without_a_change_is_blocked_in_five_of_a_hundred_comparisons_at_most() {
    let all = ten();
    for (shared, seed) in [(0.0, 1), (0.9, 2)] {
        let mut noise = normal(seed);
        let mut blocked = 0;
        let mut called_worse = 0;
        for _ in 0..COMPARISONS {
            let shifts = family(&mut noise, 8, shared);
            let decision = decide(&all, &samples(&all, &shifts, 8), Look::Single).expect("good samples");
            blocked += u64::from(decision.outcomes.iter().any(|outcome| outcome.blocks));
            called_worse += u64::from(decision.outcomes.iter().any(|outcome| outcome.call == Call::Worse));
        }
        assert!(is_at_most(blocked, FAMILY_LEVEL), "shared {shared}: {blocked} of {COMPARISONS}");
        // Independent criteria exhaust the level: 1 − 0.995¹⁰ = 4.9 %. Without Holm it would be 1 − 0.95¹⁰ = 40 %.
        let exhausted = if shared > 0.0 { 0.01 } else { 0.048 };
        assert!(is_at_least(blocked, exhausted), "shared {shared}: {blocked} of {COMPARISONS}");
        assert!(called_worse > 2 * blocked, "{called_worse} worse by themselves, {blocked} blocked");
    }
}

#[test]
fn sequential_looks_keep_ten_per_cent_over_all_for_a_criterion_and_five_for_the_blocks_of_a_family() {
    let all = ten();
    let mut noise = normal(3);
    let mut differs = 0;
    let mut worse = 0;
    let mut blocked = 0;
    for _ in 0..COMPARISONS {
        let shifts = family(&mut noise, 40, 0.0);
        let looked = (1..).zip(&all.looks).map(|(number, units)| {
            let samples = samples(&all, &shifts, *units as usize);
            decide(&all, &samples, Look::Sequential { number }).expect("good samples")
        });
        let decisions: Vec<Decision> = looked.collect();
        let first = || decisions.iter().map(|decision| &decision.outcomes[0]);
        differs += u64::from(first().any(|outcome| outcome.differs));
        worse += u64::from(first().any(|outcome| outcome.differs && outcome.shift > Some(0.0)));
        let is_blocked = |decision: &Decision| decision.outcomes.iter().any(|outcome| outcome.blocks);
        blocked += u64::from(decisions.iter().any(is_blocked));
    }
    assert!(is_at_most(differs, 0.10) && is_at_least(differs, 0.09), "{differs} of {COMPARISONS}");
    assert!(is_at_most(worse, 0.05), "{worse} of {COMPARISONS}");
    assert!(is_at_most(blocked, FAMILY_LEVEL) && is_at_least(blocked, 0.03), "{blocked} of {COMPARISONS}");
}

#[test]
fn a_change_as_large_as_its_margin_is_called_equivalent_in_one_of_twenty_comparisons_at_most() {
    let own = criterion("A", 1.2);
    let all = criteria(vec![own.clone()]);
    let mut noise = normal(4);
    let mut once = 0;
    let mut at_any_look = 0;
    for _ in 0..COMPARISONS {
        let shifts: Vec<f64> = (0..40).map(|_| 1.2 + noise()).collect();
        once += u64::from(outcome_of(&own, &shifts[..20]).call == Call::Equivalent);
        let is_equivalent = (1..).zip(&all.looks).any(|(number, units)| {
            let samples = [shifted(&own, &shifts[..*units as usize])];
            let look = Look::Sequential { number };
            decide(&all, &samples, look).expect("good samples").outcomes[0].call == Call::Equivalent
        });
        at_any_look += u64::from(is_equivalent);
    }
    assert!(is_at_most(once, 0.05) && is_at_least(once, 0.04), "{once} of {COMPARISONS}");
    assert!(
        is_at_most(at_any_look, 0.05) && is_at_least(at_any_look, 0.04),
        "{at_any_look} of {COMPARISONS}"
    );
}

#[test]
fn an_effect_of_two_margins_and_one_of_a_third_are_called_as_often_as_planned() {
    let worse = Plan { call: PlannedCall::Worse, effect: 0.2, margin: 0.1, scatter: 0.25, level: 0.9 };
    let equivalent = Plan { call: PlannedCall::Equivalent, effect: 0.1 / 3.0, ..worse };
    for (plan, call, seed) in [(worse, Call::Worse, 5), (equivalent, Call::Equivalent, 6)] {
        let units = plan.pairs(0.9).expect("the effect is on its side of the margin");
        let power = plan.probability(units);
        assert!((0.9..0.92).contains(&power) && plan.probability(units - 1) < 0.9, "{units}: {power}");
        let own = criterion("A", plan.margin);
        let mut noise = normal(seed);
        let is_right = |_: &u64| {
            let shifts: Vec<f64> = (0..units).map(|_| plan.effect + plan.scatter * noise()).collect();
            outcome_of(&own, &shifts).call == call
        };
        let right = (0..COMPARISONS).filter(is_right).count() as u64;
        assert!(
            is_at_least(right, power) && is_at_most(right, power),
            "{right} of {COMPARISONS}, {power} planned"
        );
    }
}

#[test]
fn a_plan_of_a_thousandth_misses_next_to_none_of_two_thousand_changes() {
    let plan = Plan { call: PlannedCall::Worse, effect: 0.2, margin: 0.1, scatter: 0.25, level: 0.99 };
    let units = plan.pairs(0.999).expect("the effect is beyond its margin");
    let all = ten();
    let mut noise = normal(7);
    let mut missed = 0;
    for _ in 0..COMPARISONS {
        let mut shifts = family(&mut noise, units as usize, 0.0);
        for shift in &mut shifts[0] {
            *shift = plan.effect + plan.scatter * *shift;
        }
        let mut criteria = all.clone();
        criteria.all[0].margin = plan.margin;
        let samples = samples(&criteria, &shifts, units as usize);
        let decision = decide(&criteria, &samples, Look::Single).expect("good samples");
        missed += u64::from(!decision.outcomes[0].blocks);
    }
    assert!(is_at_most(missed, 0.001), "{missed} of {COMPARISONS} missed with {units} units");
}
