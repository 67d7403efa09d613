use analysis::estimate::Estimate;
use proptest::prelude::*;

use super::*;
use crate::campaign::Claim;
use crate::condition::Meets;
use crate::measurement::{Bound, Condition};
use crate::quantity::QuantityKind as K;
use crate::requirement::{Band, Judged, Requirements, Rule, Take, Where};

mod coverage;

use coverage::sweep;

fn requirement(id: &str, kind: K, limit: Option<&str>, rule: Rule) -> Requirement {
    let limit = limit.map(|text| kind.parse_limit(text).expect("a limit"));
    Requirement {
        id: id.to_owned(),
        text: String::new(),
        source: String::new(),
        method: "test".to_owned(),
        judges: vec![Judged {
            measurand: "m".to_owned(),
            limit,
            bands: Vec::new(),
            mask: None,
            goal: None,
            rule,
        }],
        limit_text: String::new(),
        goal_text: None,
        axis: None,
        conditions: Vec::new(),
        evidence: None,
        axes: Vec::new(),
        covers: Vec::new(),
        take: Take::Worst,
        rule,
    }
}

fn measured(value: f64, u: f64, dof: f64) -> Measurement {
    Measurement::new("m", "az", K::Torque, Some(Estimate { value, u, dof, n: 10 }), "test/1")
}

fn judged(limit: &str, rule: Rule, value: f64, u: f64, dof: f64) -> Judgement {
    judge(&measured(value, u, dof), 0, &requirement("R", K::Torque, Some(limit), rule))
}

const RULES: [Rule; 3] = [Rule::Simple, Rule::GuardedNinetyFive, Rule::GuardedU];

/// The table of report.md §3, row by row and rule by rule.
#[test]
fn worked_examples_come_out_as_printed() {
    use Verdict::{ConditionalFail as CF, ConditionalPass as CP, Fail as F, Pass as P};
    let table = [
        ("<= 10 N*m", 9.7, 0.2, [P, CP, CP], 6.68e-2),
        ("<= 10 N*m", 9.5, 0.2, [P, P, P], 0.621e-2),
        ("<= 10 N*m", 10.1, 0.2, [F, CF, CF], 69.1e-2),
        ("<= 10 N*m", 10.5, 0.2, [F, F, F], 99.4e-2),
        (">= 3.5 N*m", 3.48, 0.02, [F, CF, CF], 84.1e-2),
        (">= 45 N*m", 46.1, 0.5, [P, P, P], 1.39e-2),
        ("<= 75 N*m", 60.0, 10.0, [P, CP, CP], 6.68e-2),
    ];
    for (limit, value, u, verdicts, outside) in table {
        for (rule, verdict) in RULES.into_iter().zip(verdicts) {
            let judgement = judged(limit, rule, value, u, f64::INFINITY);
            assert_eq!(judgement.verdict, verdict, "{limit} {value} {rule:?}");
            let p = judgement.probability_outside.expect("there is a limit");
            assert!((p / outside - 1.0).abs() < 2e-3, "{limit} {value}: {p} printed as {outside}");
        }
    }
}

/// Student's t at 0.97725; reference values from quadrature of the density and bisection, done elsewhere.
#[test]
fn coverage_factors_follow_the_degrees_of_freedom() {
    for (dof, k) in
        [(None, 2.0), (Some(9.0), 2.31981), (Some(4.0), 2.86932), (Some(20.0), 2.13303), (Some(4.5), 2.74323)]
    {
        let found = coverage_factor(dof);
        assert!((found - k).abs() < 1e-5, "{dof:?}: {found}, not {k}");
    }
    let below = coverage_factor(Some(9.99e5));
    let above = coverage_factor(Some(1.01e6));
    assert!((below - above).abs() < 1e-5, "{below} {above}");
    for dof in [0.0, -1.0, f64::NAN] {
        assert!(coverage_factor(Some(dof)).is_finite(), "{dof}");
    }
}

#[test]
fn risk_on_the_acceptance_limit_is_what_the_rule_promises() {
    let on = |rule, dof| {
        let at = judged("<= 10 N*m", rule, 0.0, 0.2, dof).acceptance[1].expect("an upper limit");
        judged("<= 10 N*m", rule, at, 0.2, dof).probability_outside.expect("a limit")
    };
    for dof in [4.0, 9.0, 50.0, f64::INFINITY] {
        assert!((on(Rule::GuardedU, dof) - 0.02275).abs() < 1e-6, "{dof}");
        assert!((on(Rule::Simple, dof) - 0.5).abs() < 1e-12, "{dof}");
    }
    assert!((on(Rule::GuardedNinetyFive, f64::INFINITY) - 0.0495).abs() < 1e-4);
}

#[test]
fn a_range_is_guarded_at_both_ends() {
    let verdict = |value| judged("143.5 .. 144.5 N*m", Rule::GuardedU, value, 0.1, f64::INFINITY).verdict;
    assert_eq!(verdict(144.0), Verdict::Pass);
    assert_eq!((verdict(143.6), verdict(144.4)), (Verdict::ConditionalPass, Verdict::ConditionalPass));
    assert_eq!((verdict(143.4), verdict(144.6)), (Verdict::ConditionalFail, Verdict::ConditionalFail));
    assert_eq!((verdict(143.2), verdict(144.8)), (Verdict::Fail, Verdict::Fail));
    let wide = judged("143.5 .. 144.5 N*m", Rule::GuardedU, 144.0, 0.5, f64::INFINITY);
    assert_eq!(wide.verdict, Verdict::ConditionalPass, "the guard bands leave nothing to pass in");
    let p = wide.probability_outside.expect("a limit");
    assert!((p - 0.31731).abs() < 1e-5, "both tails count: {p}");
}

#[test]
fn a_value_that_is_a_bound_decides_only_limits_that_every_truth_beyond_it_meets_or_misses() {
    let why = || "its end was not reached".to_owned();
    let verdict = |bound: Bound, limit: &str, value| {
        let measurement = Measurement { bound: Some(bound), ..measured(value, 0.1, f64::INFINITY) };
        judge(&measurement, 0, &requirement("R", K::Torque, Some(limit), Rule::GuardedU))
    };
    use Verdict::{ConditionalFail, ConditionalPass, Fail, Inconclusive, Pass};
    for (limit, value, at_least, at_most) in [
        (">= 10 N*m", 11.0, Pass, Inconclusive),
        (">= 10 N*m", 10.1, ConditionalPass, Inconclusive),
        (">= 10 N*m", 9.9, Inconclusive, ConditionalFail),
        (">= 10 N*m", 9.0, Inconclusive, Fail),
        ("<= 10 N*m", 9.0, Inconclusive, Pass),
        ("<= 10 N*m", 11.0, Fail, Inconclusive),
        ("8 N*m .. 10 N*m", 7.0, Inconclusive, Fail),
        ("8 N*m .. 10 N*m", 9.0, Inconclusive, Inconclusive),
        ("8 N*m .. 10 N*m", 11.0, Fail, Inconclusive),
    ] {
        for (bound, expected) in [(Bound::AtLeast(why()), at_least), (Bound::AtMost(why()), at_most)] {
            let judgement = verdict(bound, limit, value);
            assert_eq!(judgement.verdict, expected, "{limit} {value}: {judgement:?}");
            let reason =
                (expected == Inconclusive).then_some("the value is a bound, its end was not reached");
            assert_eq!(judgement.reason.as_deref(), reason);
            assert_eq!(judgement.probability_outside.is_none(), expected == Inconclusive);
        }
    }
}

#[test]
fn strict_and_inclusive_limits_differ_on_the_bound() {
    let exact = |limit| judged(limit, Rule::Simple, 10.0, 0.0, f64::INFINITY).verdict;
    assert_eq!((exact("<= 10 N*m"), exact("< 10 N*m")), (Verdict::Pass, Verdict::Fail));
    assert_eq!((exact(">= 10 N*m"), exact("> 10 N*m")), (Verdict::Pass, Verdict::Fail));
}

#[test]
fn without_enough_degrees_of_freedom_value_or_uncertainty_there_is_no_verdict() {
    let reason = |measurement: &Measurement| {
        let judgement =
            judge(measurement, 3, &requirement("R", K::Torque, Some("<= 10 N*m"), Rule::GuardedU));
        assert_eq!(judgement.verdict, Verdict::Inconclusive);
        assert_eq!((judgement.margin, judgement.probability_outside), (None, None));
        judgement.reason.expect("a reason")
    };
    assert_eq!(reason(&measured(5.0, 0.1, 3.9)), "3.9 effective degrees of freedom, at least 4 are needed");
    assert_eq!(judged("<= 10 N*m", Rule::GuardedU, 5.0, 0.1, 4.0).verdict, Verdict::Pass);
    assert_eq!(reason(&measured(f64::NAN, 0.1, 9.0)), "the value is not a finite number");
    assert_eq!(reason(&measured(f64::INFINITY, 0.1, 9.0)), "the value is not a finite number");
    assert_eq!(reason(&measured(5.0, f64::NAN, 9.0)), "the uncertainty is not known");
    assert_eq!(reason(&measured(5.0, -0.1, 9.0)), "the uncertainty is not known");
    let saturated = Measurement::inconclusive("m", "az", K::Torque, "test/1", "torque saturated");
    assert_eq!(reason(&saturated), "torque saturated");
    let mut other = measured(5.0, 0.1, 9.0);
    other.kind = K::Current;
    assert_eq!(reason(&other), "the measurement is a current, but the limit is not");
}

#[test]
fn report_only_has_no_verdict_but_shows_whether_its_goal_is_met() {
    let mut only = requirement("TRK-RMS-F", K::Torque, None, Rule::GuardedU);
    only.judges[0].goal = K::Torque.parse_limit("<= 3.2 N*m").ok();
    let judgement = judge(&measured(3.0, 0.1, 9.0), 0, &only);
    assert_eq!((judgement.verdict, judgement.goal_met), (Verdict::None, Some(true)));
    assert_eq!(judge(&measured(4.0, 0.1, 9.0), 0, &only).goal_met, Some(false));
    let missing = Measurement::inconclusive("m", "az", K::Torque, "test/1", "no light");
    assert_eq!(judge(&missing, 0, &only).verdict, Verdict::None);
}

#[test]
fn measurand_axis_and_conditions_decide_what_is_judged() {
    let mut it = requirement("FRC-AZ", K::Torque, Some("<= 260 N*m"), Rule::GuardedU);
    it.axis = Some("az".to_owned());
    let meets =
        crate::condition::Meets::Limit(K::AngularVelocity.parse_limit("<= 10 deg/s").expect("a limit"));
    it.conditions = vec![Where { condition: "velocity".to_owned(), meets }];
    let mut measurement = measured(200.0, 1.0, 9.0);
    assert!(applies(&it, &measurement), "a measurement without the condition passes the filter");
    let requested = 20f64.to_radians();
    measurement.conditions =
        vec![Condition { name: "velocity".into(), requested, achieved: Some(0.1), kind: K::AngularVelocity }];
    assert!(!applies(&it, &measurement), "what was asked for counts");
    measurement.conditions[0].requested = 10f64.to_radians();
    assert!(applies(&it, &measurement));
    assert!(!applies(&it, &Measurement { axis: "el".to_owned(), ..measurement.clone() }));
    assert!(!applies(&it, &Measurement { measurand: "other".to_owned(), ..measurement }));
}

fn campaign(values: &[f64], must_measure: &[&str]) -> (Vec<Outcome>, Overall) {
    let all = vec![
        requirement("A", K::Torque, Some("<= 10 N*m"), Rule::GuardedU),
        Requirement {
            axis: Some("el".to_owned()),
            ..requirement("B", K::Torque, Some("<= 10 N*m"), Rule::Simple)
        },
    ];
    let measurements = values.iter().map(|&value| measured(value, 0.2, f64::INFINITY)).collect();
    let must_measure: Vec<String> = must_measure.iter().map(|id| (*id).to_owned()).collect();
    roll_up(
        &Requirements { all },
        &[("EMPTY".to_owned(), Vec::new()), ("P".to_owned(), measurements)],
        &must_measure,
        Claim::Acceptance,
    )
}

#[test]
fn the_worst_verdict_counts_and_among_equals_the_smallest_margin() {
    let (outcomes, overall) = campaign(&[5.0, 9.0, 8.0], &["A"]);
    let (procedure, judgement) = outcomes[0].decided_by.as_ref().expect("it was measured");
    assert_eq!((procedure.as_str(), judgement.measurement, outcomes[0].judged), ("P", 1, 3));
    assert_eq!((outcomes[0].verdict, overall), (Verdict::Pass, Overall::Pass));
    let (outcomes, overall) = campaign(&[10.1, 9.9, 11.0, 12.0], &["A"]);
    assert_eq!(outcomes[0].decided_by.as_ref().map(|(_, j)| j.measurement), Some(3));
    assert_eq!((outcomes[0].verdict, overall), (Verdict::Fail, Overall::Fail));
}

#[test]
fn overall_goes_from_fail_down_to_pass_with_incomplete_between() {
    let overall = |values: &[f64], must: &[&str]| campaign(values, must).1;
    assert_eq!(overall(&[5.0], &["A"]), Overall::Pass);
    assert_eq!(overall(&[9.9], &["A"]), Overall::ConditionalPass);
    assert_eq!(overall(&[9.9], &["A", "B"]), Overall::Incomplete, "B has no verdict");
    assert_eq!(overall(&[9.9], &["A", "NEVER-HEARD-OF"]), Overall::Incomplete);
    assert_eq!(overall(&[f64::NAN, 5.0], &["A", "B"]), Overall::Inconclusive);
    assert_eq!(overall(&[f64::NAN, 10.1], &["A", "B"]), Overall::ConditionalFail);
    assert_eq!(overall(&[10.1, 11.0], &["A", "B"]), Overall::Fail);
    assert_eq!(overall(&[], &[]), Overall::Incomplete, "nothing judged is no pass");
}

#[test]
fn margins_of_different_quantities_compare_by_their_uncertainties_and_each_has_its_outcome() {
    let mut both = requirement("COG", K::SpatialOrder, Some("143.5 .. 144.5 1/rev"), Rule::Simple);
    let limit = K::Torque.parse_limit("<= 12 N*m").ok();
    both.judges.push(Judged {
        measurand: "amplitude".to_owned(),
        limit,
        bands: Vec::new(),
        mask: None,
        goal: None,
        rule: Rule::Simple,
    });
    let mut order = measured(144.0, 0.01, 9.0);
    order.kind = K::SpatialOrder;
    let amplitude = Measurement { measurand: "amplitude".to_owned(), ..measured(11.0, 0.01, 9.0) };
    let procedures = [("P".to_owned(), vec![order, amplitude])];
    let (outcomes, _) = roll_up(&Requirements { all: vec![both] }, &procedures, &[], Claim::Acceptance);
    let decided = outcomes[0].decided_by.as_ref().map(|(_, j)| j.measurement);
    assert_eq!(decided, Some(0), "0.5 1/rev are fewer uncertainties of 0.01 than 1 N*m of 0.01 N*m");
    let each: Vec<&str> = outcomes[0].by_measurand.iter().map(|one| one.measurand.as_str()).collect();
    assert_eq!(each, ["m", "amplitude"]);
}

/// The peak current was hidden behind the larger shortfall of the mean one.
#[test]
fn a_second_shortfall_of_one_requirement_is_not_hidden_by_the_first() {
    let mut both = requirement("CUR", K::Current, Some("<= 14.2 A"), Rule::Simple);
    let peak = Judged {
        measurand: "peak".to_owned(),
        limit: K::Current.parse_limit("<= 42.6 A").ok(),
        ..both.judges[0].clone()
    };
    both.judges.push(peak);
    let current = |name: &str, value| Measurement {
        measurand: name.to_owned(),
        kind: K::Current,
        ..measured(value, 0.1, 9.0)
    };
    let all = vec![current("m", 20.0), current("peak", 41.0), current("peak", 43.0), current("m", 14.0)];
    let procedures = [("P".to_owned(), all)];
    let (outcomes, _) = roll_up(&Requirements { all: vec![both] }, &procedures, &[], Claim::Acceptance);
    let found = |one: &MeasurandOutcome| {
        (one.measurand.clone(), one.verdict, one.decided_by.1.measurement, one.judged)
    };
    assert_eq!(
        outcomes[0].by_measurand.iter().map(found).collect::<Vec<_>>(),
        [("m".to_owned(), Verdict::Fail, 0, 2), ("peak".to_owned(), Verdict::Fail, 2, 2)]
    );
}

/// The tighter limit of one band hides no shortfall by that of everything else.
#[test]
fn each_band_of_a_measurand_has_an_outcome_of_its_own() {
    let limit = |text: &str| K::Time.parse_limit(text).expect("a limit");
    let mut latency = requirement("LAT", K::Time, Some("<= 45 ms"), Rule::Simple);
    let fast = Where {
        condition: "frame-rate".to_owned(),
        meets: Meets::Limit(K::Frequency.parse_limit(">= 150 Hz").expect("a limit")),
    };
    latency.judges[0].bands = vec![Band { conditions: vec![fast], limit: limit("<= 9 ms") }];
    let at = |frame_rate_hz: f64, value: f64| Measurement {
        kind: K::Time,
        conditions: vec![Condition {
            name: "frame-rate".to_owned(),
            requested: frame_rate_hz,
            achieved: Some(frame_rate_hz),
            kind: K::Frequency,
        }],
        ..measured(value, 1e-5, 9.0)
    };
    let requirements = Requirements { all: vec![latency] };
    let judged = |all: Vec<Measurement>| {
        roll_up(&requirements, &[("P".to_owned(), all)], &[], Claim::Acceptance).0.remove(0)
    };
    // Nobody looked at the fine tracker: that passes nothing, and is no finding about the coarse one.
    let coarse = judged(vec![at(60.0, 40e-3)]);
    assert_eq!((coarse.verdict, coarse.before_coverage), (Verdict::Inconclusive, Verdict::Pass));
    assert_eq!(coarse.reason.as_deref(), Some("not measured: m <= 9 ms where frame-rate >= 150 Hz"));
    let outcome = judged(vec![at(60.0, 47e-3), at(200.0, 12e-3), at(200.0, 8e-3)]);
    let found =
        |one: &MeasurandOutcome| (one.band.clone(), one.verdict, one.decided_by.1.measurement, one.judged);
    assert_eq!(
        outcome.by_measurand.iter().map(found).collect::<Vec<_>>(),
        [
            (None, Verdict::Fail, 0, 1),
            (Some("<= 9 ms where frame-rate >= 150 Hz".to_owned()), Verdict::Fail, 1, 2)
        ]
    );
}

/// A requirement without a limit shows its largest value, not its first.
#[test]
fn what_is_only_reported_is_decided_by_the_largest() {
    let only = requirement("RMS", K::Torque, None, Rule::Simple);
    let procedures = [("P".to_owned(), [3.31, 4.95, -1.0].map(|v| measured(v, 0.2, 9.0)).to_vec())];
    let (outcomes, _) = roll_up(&Requirements { all: vec![only] }, &procedures, &[], Claim::Acceptance);
    assert_eq!(outcomes[0].decided_by.as_ref().map(|(_, j)| j.measurement), Some(1));
}

#[test]
fn extreme_numbers_give_probabilities_of_zero_or_one() {
    for dof in [4.0, f64::INFINITY] {
        let outside = |value| judged("<= 10 N*m", Rule::GuardedU, value, 1e-300, dof).probability_outside;
        assert_eq!((outside(-1e300), outside(1e300)), (Some(0.0), Some(1.0)));
        assert_eq!((outside(-f64::MAX), outside(f64::MAX)), (Some(0.0), Some(1.0)));
    }
}

proptest! {
    #[test]
    fn a_better_value_never_gets_a_worse_verdict(
        a in 0.0f64..20.0, b in 0.0f64..20.0, u in 0.0f64..3.0, dof in 4.0f64..60.0, rule in 0usize..3,
    ) {
        let better = a.min(b);
        let worse = a.max(b);
        let judged = |value| judged("<= 10 N*m", RULES[rule], value, u, dof);
        prop_assert!(judged(better).verdict <= judged(worse).verdict);
        prop_assert!(judged(better).probability_outside <= judged(worse).probability_outside);
    }

    #[test]
    fn limits_above_and_below_mirror_each_other(
        value in -20.0f64..20.0, u in 0.0f64..3.0, dof in 4.0f64..60.0, rule in 0usize..3,
    ) {
        let below = judged("<= 10 N*m", RULES[rule], value, u, dof);
        let above = judged(">= -10 N*m", RULES[rule], -value, u, dof);
        prop_assert_eq!(below.verdict, above.verdict);
        prop_assert_eq!(below.margin, above.margin);
    }

    #[test]
    fn a_pass_never_has_more_risk_than_the_guarded_rule_promises(
        value in 0.0f64..20.0, u in 1e-6f64..3.0, dof in 4.0f64..60.0,
    ) {
        let judgement = judged("<= 10 N*m", Rule::GuardedU, value, u, dof);
        if judgement.verdict == Verdict::Pass {
            prop_assert!(judgement.probability_outside <= Some(0.02275 + 1e-9));
        }
    }
}

/// A pose that the axis did not reach was not measured, though the procedure asked for it.
#[test]
fn a_listed_pose_counts_where_it_was_reached_and_not_where_it_was_only_asked_for() {
    let listed = Where {
        condition: "elevation".to_owned(),
        meets: Meets::OneOf { values: vec![20_f64.to_radians()], text: "20 deg".to_owned() },
    };
    let base = requirement("HOLD", K::Torque, Some("<= 10 N*m"), Rule::GuardedU);
    let requirements = Requirements { all: vec![Requirement { conditions: vec![listed], ..base }] };
    let found = |reached_deg: Option<f64>| {
        let mut one = sweep("el", &[20.5]);
        one[0].conditions[0].achieved = reached_deg.map(f64::to_radians);
        let (outcomes, _) = roll_up(&requirements, &[("P".to_owned(), one)], &[], Claim::Acceptance);
        (outcomes[0].verdict, outcomes[0].reason.clone())
    };
    assert_eq!(found(Some(20.4)), (Verdict::Pass, None));
    let not_measured = (Verdict::Inconclusive, Some("not measured: elevation 20 deg".to_owned()));
    assert_eq!(found(Some(24.0)), not_measured);
    assert_eq!(found(None), not_measured);
}
