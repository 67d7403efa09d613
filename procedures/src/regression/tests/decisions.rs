use super::*;

/// Four shifts with mean m and standard deviation s.
fn four(mean: f64, deviation: f64) -> [f64; 4] {
    let step = deviation * 0.75_f64.sqrt();
    [mean - step, mean + step, mean - step, mean + step]
}

/// Half of the interval of four shifts: t(0.95, 3)·s/2, t by scipy 1.17.1.
const HALF: f64 = 2.3533634348018264 / 2.0;

#[test]
fn equal_values_are_identical_and_rounding_does_not_change_that() {
    let own = criterion("A", 0.1);
    let found = outcome_of(&own, &[0.0; 3]);
    assert_eq!(
        (found.call, found.differs, found.blocks, found.p),
        (Call::Identical, false, false, Some(1.0))
    );
    assert_eq!(outcome_of(&own, &[1e-9, -1e-9, 2e-9]).call, Call::Identical, "1e-10 of ten hertz");
    assert_eq!(outcome_of(&own, &[0.0, 0.0, 2e-8]).call, Call::Equivalent);
}

#[test]
fn an_interval_inside_of_the_margins_is_equivalent_and_says_so_where_it_differs() {
    let own = criterion("A", 0.1);
    let still = outcome_of(&own, &four(0.0, 0.05));
    assert_eq!((still.call, still.differs, still.why), (Call::Equivalent, false, None));
    let [low, high] = still.interval.expect("four units");
    assert!((low + HALF * 0.05).abs() < 1e-9 && (high - HALF * 0.05).abs() < 1e-9, "{low} {high}");
    let moved = outcome_of(&own, &four(0.06, 0.03));
    assert_eq!((moved.call, moved.differs), (Call::Equivalent, true), "{:?}", moved.interval);
    assert!(moved.p.is_some_and(|p| p < 0.05) && !moved.blocks, "equivalence comes first");
    assert_eq!(outcome_of(&own, &four(-0.06, 0.03)).call, Call::Equivalent);
}

#[test]
fn an_interval_above_zero_is_worse_and_one_below_is_better() {
    let own = criterion("A", 0.1);
    let worse = outcome_of(&own, &four(0.3, 0.1));
    assert_eq!((worse.call, worse.blocks, worse.why), (Call::Worse, true, None));
    assert!(worse.shift.is_some_and(|shift| (shift - 0.3).abs() < 1e-12) && worse.units == 4);
    assert!(worse.scatter.is_some_and(|s| (s - 0.1).abs() < 1e-12));
    let better = outcome_of(&own, &four(-0.3, 0.1));
    assert_eq!((better.call, better.blocks), (Call::Better, false));
    assert_eq!(outcome_of(&own, &[0.3; 4]).call, Call::Worse, "the same shift on every unit");
}

#[test]
fn a_wide_interval_is_inconclusive_and_says_how_many_units_are_needed_more() {
    let own = criterion("A", 0.1);
    let found = outcome_of(&own, &four(0.02, 0.2));
    assert_eq!((found.call, found.why), (Call::Inconclusive, Some(Undecided::Wide)));
    // 0.02 + t·0.2/√n ≤ 0.1 from n = 19 on: t(0.95, 18) = 1.7341, t(0.95, 17) = 1.7396.
    assert_eq!(found.units_needed, Some(19 - 4));
}

#[test]
fn a_lower_value_is_worse_where_the_criterion_says_so() {
    let own = Criterion { worse: Worse::Lower, ..criterion("A", 0.1) };
    assert_eq!(outcome_of(&own, &[-0.3; 4]).call, Call::Worse);
    assert_eq!(outcome_of(&own, &[0.3; 4]).call, Call::Better);
    let found = outcome_of(&own, &[0.0; 4]);
    assert!(found.shift.is_some_and(|shift| shift.is_sign_positive()), "zero without a sign");
}

#[test]
fn a_log_ratio_is_held_against_a_margin_in_per_cent() {
    let own = Criterion { scale: Scale::LogRatio, margin: 0.05_f64.ln_1p(), ..criterion("A", 1.0) };
    assert_eq!(outcome_of(&own, &[0.2, 0.3, 0.25]).call, Call::Equivalent, "2.5 % of ten hertz");
    let worse = outcome_of(&own, &[1.0; 3]);
    assert!(worse.call == Call::Worse && worse.shift.is_some_and(|d| (d - 1.1_f64.ln()).abs() < 1e-12));
}

#[test]
fn a_log_ratio_of_nothing_is_inconclusive_with_its_reason_and_keeps_the_family_large() {
    let own = Criterion { scale: Scale::LogRatio, ..criterion("A", 0.05) };
    let found = outcome_of(&own, &[0.0, -10.0, 0.0]);
    let why = found.why.expect("a reason");
    assert_eq!((found.call, found.shift, found.p), (Call::Inconclusive, None, None));
    assert_eq!(
        why.to_string(),
        "unit 2: a log-ratio needs values above zero, found 1e1 (baseline) and 0e0 (candidate), SI; compare this \
         measurand with `scale = \"difference\"`"
    );
    let other = criterion("B", 0.1);
    let samples = [shifted(&own, &[0.0, -10.0, 0.0]), shifted(&other, &[0.3, 0.4, 0.31])];
    let decision = decide(&criteria(vec![own, other]), &samples, Look::Single).expect("good samples");
    let [own_p, alone_p] = [decision.outcomes[1].adjusted_p, decision.outcomes[1].p];
    assert!(own_p.zip(alone_p).is_some_and(|(own, alone)| (own - 2.0 * alone).abs() < 1e-12));
}

#[test]
fn one_unit_decides_nothing() {
    let found = outcome_of(&criterion("A", 0.1), &[0.0]);
    assert_eq!((found.call, found.why), (Call::Inconclusive, Some(Undecided::FewUnits { units: 1 })));
    assert_eq!((found.interval, found.shift), (None, Some(0.0)));
}

#[test]
fn seeds_of_one_unit_are_averaged_and_are_no_units() {
    let own = criterion("A", 0.1);
    let mut samples = shifted(&own, &[0.1, 0.3]);
    for (seed, shift) in [(2, 0.2), (3, 0.6)] {
        samples.samples.push(Sample { seed, candidate: reading(10.0 + shift), ..samples.samples[0] });
    }
    let decision = decide(&criteria(vec![own]), &[samples], Look::Single).expect("good samples");
    let found = &decision.outcomes[0];
    assert_eq!(found.units, 2);
    let shifts: Vec<f64> = found.shifts.iter().map(|unit| unit.shift).collect();
    assert!((shifts[0] - 0.3).abs() < 1e-12 && (shifts[1] - 0.3).abs() < 1e-12, "{shifts:?}");
}

#[test]
fn a_worse_criterion_that_its_family_does_not_uphold_is_named_does_not_block_and_leaves_it_open() {
    // Alone p is 0.03; the second of two is multiplied by 2.
    let own = criterion("A", 0.01);
    let shifts = four(0.3, 0.2);
    let alone = outcome_of(&own, &shifts);
    assert!(alone.blocks && alone.p.is_some_and(|p| p > 0.025 && p < 0.05), "{:?}", alone.p);
    let other = criterion("B", 0.01);
    let samples = [shifted(&own, &shifts), shifted(&other, &four(-0.001, 0.002))];
    let decision = decide(&criteria(vec![own.clone(), other.clone()]), &samples, Look::Single);
    let decision = decision.expect("good samples");
    let found = &decision.outcomes[0];
    assert_eq!((found.call, found.blocks), (Call::Worse, false));
    assert!(matches!(found.why, Some(Undecided::NotUpheld { .. })), "{:?}", found.why);
    assert_eq!((decision.call, decision.call.exit_code()), (Call::Inconclusive, 3));
    let needed = found.units_needed.expect("a number");
    let more: Vec<f64> = shifts.iter().cycle().take(4 + needed as usize).copied().collect();
    let samples = [shifted(&own, &more), shifted(&other, &four(-0.001, 0.002))];
    let again = decide(&criteria(vec![own, other]), &samples, Look::Single).expect("good samples");
    assert!(again.outcomes[0].blocks && again.call == Call::Worse, "{needed} units more");
}

#[test]
fn what_is_only_reported_blocks_nothing_and_does_not_enlarge_the_family() {
    let own = criterion("A", 0.1);
    let reported = Criterion { blocking: false, ..criterion("B", 0.1) };
    let samples = [shifted(&own, &four(0.0, 0.01)), shifted(&reported, &four(0.3, 0.1))];
    let decision = decide(&criteria(vec![own, reported]), &samples, Look::Single).expect("good samples");
    assert_eq!((decision.outcomes[1].call, decision.outcomes[1].blocks), (Call::Worse, false));
    assert_eq!(
        (decision.outcomes[1].adjusted_p, decision.outcomes[0].adjusted_p),
        (None, decision.outcomes[0].p)
    );
    assert_eq!(decision.call, Call::Equivalent);
}

#[test]
fn the_worst_blocking_criterion_decides_over_all() {
    let call = |shifts: [f64; 2]| {
        let all = vec![criterion("A", 0.1), criterion("B", 0.1)];
        let samples = [shifted(&all[0], &four(shifts[0], 0.01)), shifted(&all[1], &four(shifts[1], 0.01))];
        decide(&criteria(all), &samples, Look::Single).expect("good samples").call
    };
    assert_eq!([call([0.5, -0.5]), call([-0.5, 0.0])], [Call::Worse, Call::Better]);
    assert_eq!(call([0.0, 0.0]), Call::Equivalent);
    let codes = |call: Call| [call.exit_code(), call.bisect_code()];
    assert_eq!([codes(Call::Worse), codes(Call::Inconclusive)], [[1, 1], [3, 125]]);
    assert_eq!([Call::Identical, Call::Equivalent, Call::Better].map(codes), [[0, 0]; 3]);
}

#[test]
fn units_that_lose_a_pass_are_listed_whatever_the_mean_says() {
    let own = criterion("A", 0.1);
    let mut samples = shifted(&own, &[0.0; 3]);
    samples.samples[1].candidate.passes = false;
    samples.samples.push(Sample { seed: 7, ..samples.samples[1] });
    samples.samples[2].baseline.passes = false;
    let decision = decide(&criteria(vec![own]), &[samples], Look::Single).expect("good samples");
    let found = &decision.outcomes[0];
    assert_eq!(found.call, Call::Identical);
    assert_eq!(found.lost, [LostPass { unit: 2, seeds: vec![1, 7] }]);
    let passed = [&found.baseline, &found.candidate].map(|arm| arm.expect("units").passed);
    assert_eq!(passed, [2, 2]);
}

#[test]
fn a_sequential_look_has_wider_intervals_and_pays_for_all_looks() {
    let own = criterion("A", 0.1);
    let samples = [shifted(&own, &[0.2, 0.35, 0.3, 0.25, 0.4])];
    let all = criteria(vec![own]);
    let single = decide(&all, &samples, Look::Single).expect("good samples");
    let first = decide(&all, &samples, Look::Sequential { number: 1 }).expect("good samples");
    assert_eq!([single.level, first.level], [0.90, 0.968]);
    let width = |decision: &Decision| decision.outcomes[0].interval.map(|[low, high]| high - low);
    assert!(width(&first) > width(&single));
    let p = |decision: &Decision| decision.outcomes[0].adjusted_p.expect("five units");
    assert!((p(&first) - 4.0 * p(&single)).abs() < 1e-12);
    let refused = decide(&all, &samples, Look::Sequential { number: 5 }).expect_err("four looks are planned");
    assert_eq!(refused, [RegressionError::NoSuchLook { number: 5, looks: 4 }]);
}

#[test]
fn all_that_is_wrong_with_samples_is_told_at_once() {
    let all = vec![criterion("A", 0.1), criterion("B", 0.1)];
    let mut own = shifted(&all[0], &[0.0; 4]);
    own.samples[0].candidate.value = None;
    own.samples[1].baseline.value = Some(f64::NAN);
    own.samples[2].baseline.value = None;
    own.samples[2].candidate.value = None;
    own.samples.push(own.samples[3]);
    let foreign = shifted(&criterion("C", 0.1), &[0.0; 2]);
    let errors = decide(&criteria(all), &[own, foreign], Look::Single).expect_err("a lot is wrong");
    let text: Vec<String> = errors.iter().map(ToString::to_string).collect();
    insta::assert_snapshot!(text.join("\n"));
}

#[test]
fn samples_without_a_value_in_either_arm_are_left_out_and_counted() {
    let own = criterion("A", 0.1);
    let mut samples = shifted(&own, &[0.0; 3]);
    let none = Reading { value: None, u: 0.0, passes: false };
    samples.samples.push(Sample { unit: 9, seed: 1, baseline: none, candidate: none });
    let decision = decide(&criteria(vec![own]), &[samples], Look::Single).expect("good samples");
    assert_eq!((decision.outcomes[0].units, decision.outcomes[0].left_out), (3, 1));
}

#[test]
fn a_decision_keeps_its_names_and_numbers_in_json() {
    let own = criterion("VEL-BW", 0.1);
    // Worse by itself, p = 0.014, and times four looks not below 0.05.
    let samples = [shifted(&own, &four(0.3, 0.15))];
    let decision =
        decide(&criteria(vec![own]), &samples, Look::Sequential { number: 1 }).expect("good samples");
    let text = serde_json::to_string(&decision).expect("numbers are finite");
    assert_eq!(serde_json::from_str::<Decision>(&text).expect("what was written"), decision);
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(value["look"], serde_json::json!({ "kind": "sequential", "number": 1 }));
    assert_eq!(value["outcomes"][0]["why"]["kind"], "not-upheld");
    assert_eq!(value["outcomes"][0]["criterion"]["scale"], "difference");
}
