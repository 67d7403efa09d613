use proptest::prelude::*;

use super::*;

/// Samples of a criterion by baseline and candidate of each unit.
fn pairs(of: &Criterion, values: &[[f64; 2]]) -> CriterionSamples {
    let sample = |(unit, [baseline, candidate]): (u32, &[f64; 2])| Sample {
        unit,
        seed: 1,
        baseline: reading(*baseline),
        candidate: reading(*candidate),
    };
    CriterionSamples {
        requirement: of.requirement.clone(),
        measurand: of.measurand.clone(),
        place: of.place.clone(),
        samples: (1..).zip(values).map(sample).collect(),
    }
}

/// Values of a few units: a baseline near 1, a candidate beside it.
fn values() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let one =
        (0.5..2.0_f64, -0.3..0.3_f64).prop_map(|(baseline, shift)| [baseline, baseline * (1.0 + shift)]);
    prop::collection::vec(one, 2..9)
}

fn family() -> impl Strategy<Value = Vec<(Criterion, CriterionSamples)>> {
    let one = (values(), 0.01..0.3_f64, any::<bool>(), any::<bool>(), any::<bool>());
    let one = one.prop_map(|(values, margin, ratio, lower, blocking)| {
        let scale = if ratio { Scale::LogRatio } else { Scale::Difference };
        let worse = if lower { Worse::Lower } else { Worse::Higher };
        (Criterion { scale, worse, blocking, ..criterion("R", margin) }, values)
    });
    prop::collection::vec(one, 1..5).prop_map(|all| {
        let mut family = Vec::new();
        for (number, (criterion, values)) in all.into_iter().enumerate() {
            let criterion = Criterion { requirement: format!("R{number}"), ..criterion };
            let samples = pairs(&criterion, &values);
            family.push((criterion, samples));
        }
        family
    })
}

fn decided(family: &[(Criterion, CriterionSamples)]) -> Decision {
    let all = criteria(family.iter().map(|(criterion, _)| criterion.clone()).collect());
    let samples: Vec<CriterionSamples> = family.iter().map(|(_, samples)| samples.clone()).collect();
    decide(&all, &samples, Look::Single).expect("good samples")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_order_of_units_and_of_criteria_changes_nothing(family in family(), turn in 0..9_usize) {
        let before = decided(&family);
        let mut turned = family;
        for (_, samples) in &mut turned {
            samples.samples.reverse();
            let turn = turn % samples.samples.len();
            samples.samples.rotate_left(turn);
        }
        let shift = turn % turned.len();
        turned.rotate_left(shift);
        let mut after = decided(&turned);
        after.outcomes.rotate_right(shift);
        prop_assert_eq!(after, before);
    }

    #[test]
    fn each_call_is_what_its_interval_says_and_no_two_calls_hold_at_once(family in family()) {
        let decision = decided(&family);
        for outcome in &decision.outcomes {
            let [low, high] = outcome.interval.expect("two units or more");
            let margin = outcome.criterion.margin;
            let is_inside = -margin <= low && high <= margin;
            let expected = match (is_inside, low > 0.0, high < 0.0) {
                (true, _, _) => Call::Equivalent,
                (false, true, _) => Call::Worse,
                (false, false, true) => Call::Better,
                (false, false, false) => Call::Inconclusive,
            };
            prop_assert_eq!(outcome.call, expected);
            prop_assert_eq!(outcome.differs, low > 0.0 || high < 0.0);
            prop_assert!(!outcome.blocks || outcome.call == Call::Worse && outcome.criterion.blocking);
            prop_assert_eq!(outcome.units_needed.is_some(), outcome.why.is_some());
        }
        prop_assert_eq!(decision.call == Call::Worse, decision.outcomes.iter().any(|outcome| outcome.blocks));
    }

    #[test]
    fn a_scale_of_both_arms_leaves_a_log_ratio_alone(values in values(), margin in 0.01..0.3_f64, factor in 1e-6..1e6_f64) {
        let own = Criterion { scale: Scale::LogRatio, ..criterion("R", margin) };
        let scaled: Vec<[f64; 2]> = values.iter().map(|pair| pair.map(|value| factor * value)).collect();
        let [before, after] = [values, scaled].map(|values| decided(&[(own.clone(), pairs(&own, &values))]));
        let [before, after] = [before, after].map(|decision| decision.outcomes[0].clone());
        let ends = |outcome: &Outcome| outcome.interval.expect("two units or more");
        for (old, new) in ends(&before).into_iter().zip(ends(&after)) {
            prop_assert!((old - new).abs() < 1e-9);
        }
        // Where an end lies on a bound, rounding decides.
        let is_on_a_bound = |end: f64| [0.0, margin, -margin].iter().any(|bound| (end - bound).abs() < 1e-9);
        prop_assume!(!ends(&before).into_iter().any(is_on_a_bound));
        prop_assert_eq!(before.call, after.call);
    }

    #[test]
    fn arms_that_change_places_change_worse_and_better(values in values(), margin in 0.01..0.3_f64) {
        let own = criterion("R", margin);
        let turned: Vec<[f64; 2]> = values.iter().map(|[baseline, candidate]| [*candidate, *baseline]).collect();
        let [there, back] = [values, turned].map(|values| decided(&[(own.clone(), pairs(&own, &values))]).outcomes[0].call);
        let mirrored = match there {
            Call::Worse => Call::Better,
            Call::Better => Call::Worse,
            other => other,
        };
        prop_assert_eq!(back, mirrored);
    }
}
