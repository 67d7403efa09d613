use super::*;

/// An arm on three units, run twice each; values of two places by unit.
pub(super) fn arm(bandwidth_hz: impl Fn(u32, u64) -> f64) -> ArmRecord {
    let value = |place: &str, value: f64| ReplicateValue {
        requirement: "VEL-BW".to_owned(),
        measurand: "velocity-bandwidth".to_owned(),
        place: place.to_owned(),
        value: Some(value),
        u: 0.01,
        passes: value >= 3.5,
    };
    let mut replicates = Vec::new();
    for unit in 1..=3_u32 {
        for repeat in 0..2 {
            let seed = u64::from(2 * (unit - 1) + repeat) + 7;
            let own = bandwidth_hz(unit, seed);
            replicates.push(Replicate {
                unit,
                unit_id: format!("unit-{unit}"),
                unit_sha256: format!("digest of {unit}"),
                seed,
                end: End::Completed,
                values: vec![value("AZ-VELOCITY-LOOP az", own), value("EL-VELOCITY-LOOP el", own + 1.0)],
            });
        }
    }
    ArmRecord {
        schema: ARM_SCHEMA.to_owned(),
        program: Program {
            version: "0.1.0".to_owned(),
            sha256: "a program".to_owned(),
            processor: "x86_64 fma".to_owned(),
        },
        controller: Controller {
            parameters: "director".to_owned(),
            sha256: "gains".to_owned(),
            states: Vec::new(),
            laws: Vec::new(),
        },
        scenario: Scenario {
            campaign: "regression".to_owned(),
            campaign_sha256: "a campaign".to_owned(),
            rig: "sim".to_owned(),
            rig_sha256: "a rig".to_owned(),
            population: Population { name: "files".to_owned(), sha256: "units".to_owned(), units: 3 },
            seed: 7,
            seeds_per_unit: 2,
        },
        shard: Shard::WHOLE,
        look: None,
        replicates,
    }
}

fn own() -> Criteria {
    criteria(vec![Criterion {
        requirement: "VEL-BW".to_owned(),
        worse: Worse::Lower,
        ..criterion("VEL-BW", 0.1)
    }])
}

fn shards(whole: &ArmRecord, parts: u32) -> Vec<ShardFile> {
    let shard = |number: u32| {
        let shard = Shard { number, parts };
        let replicates = whole.replicates.iter().filter(|r| shard.holds(r.unit)).cloned().collect();
        ShardFile { name: format!("part-{number}"), record: ArmRecord { shard, replicates, ..whole.clone() } }
    };
    (1..=parts).map(shard).collect()
}

fn told<E: ToString>(errors: &[E]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<String>>().join("\n")
}

#[test]
fn a_criterion_is_compared_at_each_place_where_its_measurand_is_found() {
    let paired = pair(&own(), &arm(|_, _| 4.0), &arm(|unit, _| 4.0 - 0.1 * f64::from(unit))).expect("alike");
    let places: Vec<&str> = paired.criteria.all.iter().map(|c| c.place.as_str()).collect();
    assert_eq!(places, ["AZ-VELOCITY-LOOP az", "EL-VELOCITY-LOOP el"]);
    let decision = decide(&paired.criteria, &paired.samples, Look::Single).expect("good samples");
    let found = &decision.outcomes[1];
    assert_eq!((found.units, found.call), (3, Call::Worse));
    assert!(found.shift.is_some_and(|shift| (shift - 0.2).abs() < 1e-12), "{found:?}");
}

#[test]
fn a_run_that_ended_early_is_named_and_what_it_measured_before_counts() {
    let early =
        |procedure: usize| End::Aborted { procedure, why: "aborted: tracking error of az".to_owned() };
    let mut candidate = arm(|_, _| 4.0);
    candidate.replicates[2].end = early(5);
    candidate.replicates[2].values.pop();
    candidate.replicates[2].values[0].passes = false;
    let mut baseline = arm(|_, _| 4.0);
    let paired = pair(&own(), &baseline, &candidate).expect("alike");
    assert_eq!(paired.samples.iter().map(|own| own.samples.len()).collect::<Vec<_>>(), [6, 6]);
    let lost = |paired: &Pairing, place: usize| {
        let decision = decide(&paired.criteria, &paired.samples, Look::Single).expect("good samples");
        (decision.outcomes[place].lost.clone(), decision.outcomes[place].call)
    };
    let own_loss = vec![LostPass { unit: 2, seeds: vec![9] }];
    assert_eq!(lost(&paired, 0), (own_loss.clone(), Call::Identical), "measured before the end");
    assert_eq!(lost(&paired, 1), (own_loss, Call::Inconclusive), "not measured any more");
    let end = &paired.ends[0];
    assert_eq!((end.unit, end.seed, end.candidate_first), (2, 9, true));
    for (place, candidate_first) in [(4, false), (5, false), (6, true)] {
        baseline.replicates[2].end = early(place);
        let paired = pair(&own(), &baseline, &candidate).expect("alike");
        assert_eq!(paired.ends[0].candidate_first, candidate_first, "the baseline ended in {place}");
    }
}

#[test]
fn a_few_units_that_are_left_of_many_decide_nothing() {
    let mut arms = [arm(|_, _| 4.0), arm(|_, _| 4.0)];
    for arm in &mut arms {
        arm.replicates[..4].iter_mut().for_each(|replicate| replicate.values[0].value = None);
    }
    let paired = pair(&own(), &arms[0], &arms[1]).expect("alike");
    let decision = decide(&paired.criteria, &paired.samples, Look::Single).expect("good samples");
    assert_eq!(decision.outcomes[0].call, Call::Inconclusive, "{:?}", decision.outcomes[0].why);
    assert_eq!(decision.outcomes[1].call, Call::Identical);
}

#[test]
fn a_value_that_the_candidate_does_not_give_leaves_its_criterion_open() {
    let mut candidate = arm(|_, _| 4.0);
    candidate.replicates[0].values[0].value = None;
    candidate.replicates[0].values[0].passes = false;
    let paired = pair(&own(), &arm(|_, _| 4.0), &candidate).expect("alike");
    let decision = decide(&paired.criteria, &paired.samples, Look::Single).expect("good samples");
    let found = &decision.outcomes[0];
    assert_eq!((found.call, found.why), (Call::Inconclusive, Some(Undecided::CandidateWithout { units: 1 })));
    assert_eq!(found.lost, [LostPass { unit: 1, seeds: vec![7] }]);
    assert_eq!(decision.outcomes[1].call, Call::Identical);
}

#[test]
fn arms_that_were_not_run_alike_are_not_compared_and_all_of_it_is_told() {
    let baseline = arm(|_, _| 4.0);
    let mut candidate = arm(|_, _| 4.0);
    candidate.scenario.campaign = "quick".to_owned();
    candidate.scenario.campaign_sha256 = "another campaign".to_owned();
    candidate.scenario.seed = 8;
    candidate.scenario.population.units = 4;
    let lost = candidate.replicates.pop().expect("six runs");
    candidate.replicates.push(Replicate { seed: 99, ..lost });
    candidate.replicates[0].unit_sha256 = "something else".to_owned();
    insta::assert_snapshot!(told(&pair(&own(), &baseline, &candidate).expect_err("not alike")));
}

#[test]
fn a_criterion_that_one_arm_or_none_measured_is_an_error() {
    let mut candidate = arm(|_, _| 4.0);
    candidate.replicates.iter_mut().for_each(|replicate| {
        replicate.values.pop();
    });
    let mut all = own();
    all.all.push(Criterion { measurand: "track-bandwidth".to_owned(), ..criterion("TRK-BW", 0.1) });
    insta::assert_snapshot!(told(&pair(&all, &arm(|_, _| 4.0), &candidate).expect_err("not measured")));
}

#[test]
fn merged_shards_are_the_whole_in_any_order_and_for_any_number_of_parts() {
    let whole = arm(|unit, seed| 4.0 + f64::from(unit) + seed as f64);
    for parts in 1..=8 {
        let mut all = shards(&whole, parts);
        all.reverse();
        assert_eq!(merge(&all, false).expect("all are there"), whole, "{parts} parts");
    }
}

#[test]
fn shards_that_are_lost_double_foreign_or_incomplete_are_named() {
    let whole = arm(|_, _| 4.0);
    let mut all = shards(&whole, 3);
    all.remove(0);
    all[0].record.replicates.pop();
    all[1].record.program.processor = "x86_64".to_owned();
    all.push(all[0].clone());
    all[2].name = "again".to_owned();
    let mut foreign = shards(&whole, 3).remove(0);
    foreign.record.controller.sha256 = "other gains".to_owned();
    foreign.record.shard.parts = 4;
    all.push(foreign);
    insta::assert_snapshot!(told(&merge(&all, false).expect_err("a lot is wrong")));
    assert_eq!(merge(&[], false), Err(vec![MergeError::Nothing]));
    let mut tolerated = shards(&whole, 3);
    tolerated[1].record.program.processor = "x86_64".to_owned();
    assert!(merge(&tolerated, false).is_err());
    assert_eq!(merge(&tolerated, true).expect("tolerated"), whole);
}
