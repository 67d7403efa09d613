use super::*;
use crate::kinds::KINDS;
use crate::measurement::{Bound, Condition, Estimate};
use crate::quantity::QuantityKind as Q;

fn friction(value: f64, u: f64, velocity: f64) -> Measurement {
    let estimate = Estimate { value, u, dof: 20.0, n: 9 };
    let at = Condition {
        name: "velocity".to_owned(),
        requested: velocity,
        achieved: None,
        kind: Q::AngularVelocity,
    };
    Measurement {
        conditions: vec![at],
        ..Measurement::new("friction-torque", "az", Q::Torque, Some(estimate), "test/1")
    }
}

type Found = Vec<(String, Vec<Measurement>)>;

fn run(first: Measurement, second: Measurement) -> (Vec<Disagreement>, Found) {
    let mut found = vec![("AZ-FRICTION".to_owned(), vec![first]), ("AZ-STRIBECK".to_owned(), vec![second])];
    (compare(&mut found), found)
}

#[test]
fn two_frictions_of_one_velocity_that_disagree_pass_nothing_and_both_procedures_say_so() {
    let (sentences, found) = run(friction(219.0, 0.7, 0.17), friction(224.0, 0.7, 0.17));
    let [Disagreement { procedures, sentence }] = &sentences[..] else { panic!("{sentences:?}") };
    assert_eq!(*procedures, [0, 1]);
    insta::assert_snapshot!(sentence);
    assert!(found.iter().all(|(_, all)| all[0].doubt.as_ref() == Some(sentence)));
    assert!(found.iter().all(|(_, all)| all[0].inconclusive.is_none() && all[0].value.is_some()));
}

#[test]
fn estimates_that_agree_or_were_made_under_other_conditions_or_on_another_axis_are_left_alone() {
    let first = || friction(219.0, 0.7, 0.17);
    let other_axis = Measurement { axis: "el".to_owned(), ..friction(40.0, 0.7, 0.17) };
    let none = Measurement { inconclusive: Some("no light".to_owned()), ..friction(40.0, 0.7, 0.17) };
    let bound = Bound::AtMost("its end was not reached".to_owned());
    let bound = Measurement { bound: Some(bound), ..friction(264.0, 0.7, 0.17) };
    for second in [friction(221.9, 0.7, 0.17), friction(264.0, 0.7, 0.35), other_axis, none, bound] {
        let (sentences, found) = run(first(), second.clone());
        assert!(sentences.is_empty() && found.iter().all(|(_, all)| all[0].doubt.is_none()), "{second:?}");
    }
}

#[test]
fn every_property_is_a_measurand_of_a_kind() {
    let known = |name: &&str| KINDS.iter().flat_map(|kind| kind.measurands).any(|m| m.name == *name);
    assert!(PROPERTIES.iter().all(known), "{PROPERTIES:?}");
}

#[test]
fn of_two_estimates_the_better_known_one_is_the_parameter_and_the_other_a_cross_check() {
    let flags = |first: Measurement, second: Measurement| {
        let mut found =
            vec![("EL-FRICTION".to_owned(), vec![first]), ("EL-STRIBECK".to_owned(), vec![second])];
        name_cross_checks(&mut found);
        found.into_iter().map(|(_, mut all)| all.remove(0).flags).collect::<Vec<_>>()
    };
    let told = ["a cross-check: EL-FRICTION is the better measurement"];
    assert_eq!(flags(friction(68.3, 0.35, 0.17), friction(81.0, 12.0, 0.17)), [vec![], told.to_vec()]);
    assert_eq!(flags(friction(68.3, 0.35, 0.17), friction(68.3, 0.35, 0.17)), [vec![], told.to_vec()]);
    let better = flags(friction(81.0, 12.0, 0.17), friction(68.3, 0.35, 0.17));
    assert_eq!(better, [vec!["a cross-check: EL-STRIBECK is the better measurement"], vec![]]);
    assert!(flags(friction(81.0, 12.0, 0.17), friction(68.3, 0.35, 0.2)).iter().all(Vec::is_empty));
}
