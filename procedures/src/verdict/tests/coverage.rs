//! Axes, conditions and angles that a requirement claims.

use super::{measured, requirement};
use crate::campaign::Claim;
use crate::measurement::{Condition, Measurement};
use crate::quantity::QuantityKind as K;
use crate::requirement::{Cover, Requirement, Requirements, Rule};
use crate::verdict::{Overall, Verdict, roll_up};

/// A requirement that claims both axes and elevations from -6 to 86 degrees, at the most 11 degrees apart.
fn claiming() -> Requirement {
    let cover = Cover {
        measurand: None,
        axis: None,
        condition: "elevation".to_owned(),
        range: [-6.0, 86.0].map(f64::to_radians),
        largest_gap: 11_f64.to_radians(),
        ends: 1_f64.to_radians(),
        text: "-6 deg .. 86 deg".to_owned(),
    };
    let base = requirement("A", K::Torque, Some("<= 10 N*m"), Rule::GuardedU);
    Requirement { axes: vec!["az".to_owned(), "el".to_owned()], covers: vec![cover], ..base }
}

/// Good values at these elevations, degrees; reached half a degree higher than asked for.
pub(super) fn sweep(axis: &str, elevations_deg: &[f64]) -> Vec<Measurement> {
    let at = |deg: &f64| {
        let condition = Condition {
            name: "elevation".to_owned(),
            requested: (deg - 0.5).to_radians(),
            achieved: Some(deg.to_radians()),
            kind: K::Angle,
        };
        Measurement {
            axis: axis.to_owned(),
            conditions: vec![condition],
            ..measured(5.0, 0.2, f64::INFINITY)
        }
    };
    elevations_deg.iter().map(at).collect()
}

fn claimed(measurements: Vec<Measurement>, claim: Claim) -> (Verdict, Option<String>, Overall) {
    let (outcomes, overall) =
        roll_up(&Requirements { all: vec![claiming()] }, &[("P".to_owned(), measurements)], &[], claim);
    let outcome = outcomes.into_iter().next().expect("one requirement");
    (outcome.verdict, outcome.reason, overall)
}

const WHOLE_DEG: [f64; 10] = [-6.0, 4.0, 14.0, 24.0, 34.0, 44.0, 54.0, 64.0, 75.0, 86.0];

#[test]
fn a_requirement_passes_only_over_the_axes_and_conditions_that_it_claims() {
    let both = |az: &[f64], el: &[f64]| [sweep("az", az), sweep("el", el)].concat();
    let (verdict, reason, overall) = claimed(both(&WHOLE_DEG, &WHOLE_DEG), Claim::Acceptance);
    assert_eq!((verdict, reason, overall), (Verdict::Pass, None, Overall::Pass));
    let told = |measurements| {
        let (verdict, reason, overall) = claimed(measurements, Claim::Acceptance);
        assert_eq!((verdict, overall), (Verdict::Inconclusive, Overall::Inconclusive));
        reason.expect("it says what is missing")
    };
    let one = "not measured: m on el: elevation -6 deg .. 86 deg, reached 45 deg only";
    assert_eq!(told(both(&WHOLE_DEG, &[45.0])), one);
    assert_eq!(told(sweep("az", &WHOLE_DEG)), "not measured: m on el");
    let hole: Vec<f64> = WHOLE_DEG.into_iter().filter(|deg| *deg != 34.0).collect();
    let found = told(both(&hole, &WHOLE_DEG));
    assert_eq!(found, "not measured: m on az: elevation -6 deg .. 86 deg, nothing between 24 deg and 44 deg");
    let short: Vec<f64> = WHOLE_DEG.into_iter().filter(|deg| *deg > 0.0).collect();
    assert!(told(both(&short, &WHOLE_DEG)).ends_with("reached 4 deg to 86 deg"));
}

/// A requirement that claims azimuth from -150 to 150 degrees without a gap, judged by values that were measured over these stretches.
fn over_travel(stretches_deg: &[[f64; 2]]) -> (Verdict, Option<String>) {
    let cover = Cover {
        condition: "angle".to_owned(),
        range: [-150.0, 150.0].map(f64::to_radians),
        largest_gap: 0.0,
        ends: 5_f64.to_radians(),
        text: "-150 deg .. 150 deg".to_owned(),
        ..claiming().covers.remove(0)
    };
    let requirement = Requirement { axes: Vec::new(), covers: vec![cover], ..claiming() };
    let one = |ends_deg: &[f64; 2]| Measurement {
        angles_rad: Some(ends_deg.map(f64::to_radians)),
        ..measured(5.0, 0.2, f64::INFINITY)
    };
    let measurements = stretches_deg.iter().map(one).collect();
    let (outcomes, _) = roll_up(
        &Requirements { all: vec![requirement] },
        &[("P".to_owned(), measurements)],
        &[],
        Claim::Acceptance,
    );
    let outcome = outcomes.into_iter().next().expect("one requirement");
    (outcome.verdict, outcome.reason)
}

#[test]
fn a_requirement_that_claims_angles_passes_only_where_strokes_leave_none_out() {
    assert_eq!(over_travel(&[[-148.0, 147.0]]), (Verdict::Pass, None));
    let told = |stretches: &[[f64; 2]]| {
        let (verdict, reason) = over_travel(stretches);
        assert_eq!(verdict, Verdict::Inconclusive);
        reason.expect("it says what is missing")
    };
    assert!(told(&[[-57.0, 57.0]]).ends_with("m: angle -150 deg .. 150 deg, reached -57 deg to 57 deg"));
    assert!(told(&[[20.0, 150.0], [-150.0, -20.0]]).ends_with("nothing between -20 deg and 20 deg"));
    // A long stroke is not cut short by a shorter one that begins within it.
    assert_eq!(over_travel(&[[-150.0, 100.0], [-60.0, 60.0], [90.0, 150.0]]).0, Verdict::Pass);
}

/// What a supply bears is measured beside one of the axes that move: both at once count, whichever axis else was measured.
#[test]
fn a_single_value_is_claimed_on_the_axis_that_the_claim_names_though_only_another_one_was_measured() {
    let cover = Cover {
        axis: Some("az".to_owned()),
        range: [0.0; 2],
        largest_gap: 0.0,
        ends: 0.5_f64.to_radians(),
        text: "0 deg".to_owned(),
        ..claiming().covers.remove(0)
    };
    let requirement = Requirement { axes: Vec::new(), covers: vec![cover], ..claiming() };
    assert_eq!(requirement.claims(), ["az: elevation 0 deg"]);
    let missing = |measurements: Vec<Measurement>| {
        requirement.not_covered(&measurements.iter().collect::<Vec<&Measurement>>())
    };
    assert_eq!(missing(sweep("el", &[45.0])), ["m on az"]);
    assert_eq!(
        missing([sweep("el", &[0.0]), sweep("az", &[45.0])].concat()),
        ["m on az: elevation 0 deg, reached 45 deg only"]
    );
    assert_eq!(missing([sweep("el", &[45.0]), sweep("az", &[0.2])].concat()), [""; 0]);
    assert_eq!(missing(sweep("az", &[0.0, 45.0])), [""; 0]);
}

#[test]
fn what_was_asked_for_and_not_reached_covers_nothing() {
    let mut measurements = [sweep("az", &WHOLE_DEG), sweep("el", &WHOLE_DEG)].concat();
    measurements.iter_mut().for_each(|m| m.conditions[0].achieved = None);
    let (verdict, reason, _) = claimed(measurements, Claim::Acceptance);
    assert_eq!(verdict, Verdict::Inconclusive);
    assert!(reason.is_some_and(|reason| reason.contains("elevation -6 deg .. 86 deg, reached nowhere")));
}

#[test]
fn a_screening_has_no_verdict_on_what_it_looked_at_in_part_and_fails_a_shortfall_all_the_same() {
    let (verdict, reason, overall) = claimed(sweep("az", &[45.0]), Claim::Screening);
    assert_eq!((verdict, overall), (Verdict::Screened, Overall::Screening));
    assert!(reason.is_some_and(|reason| reason.contains("m on el")));
    let whole = [sweep("az", &WHOLE_DEG), sweep("el", &WHOLE_DEG)].concat();
    let (verdict, _, overall) = claimed(whole, Claim::Screening);
    assert_eq!((verdict, overall), (Verdict::Pass, Overall::Screening), "a first look is no acceptance");
    let mut bad = sweep("az", &[45.0]);
    bad[0].value = Some(12.0);
    assert_eq!(claimed(bad, Claim::Screening).2, Overall::Fail);
    let mut none = sweep("az", &[45.0]);
    none[0].value = None;
    none[0].inconclusive = Some("no rows".to_owned());
    assert_eq!(
        claimed(none, Claim::Screening).2,
        Overall::Inconclusive,
        "a number that is missing is missing"
    );
}
