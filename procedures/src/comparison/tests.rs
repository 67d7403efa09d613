use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;
use crate::measurement::Estimate;
use crate::quantity::QuantityKind as Q;

mod curves;
mod published;

fn measured(name: &str, value: f64, u: f64) -> Measurement {
    let estimate = Estimate { value, u, dof: f64::INFINITY, n: 10 };
    Measurement::new(name, "az", Q::Torque, Some(estimate), "test/1")
}

fn at_rate(rate_rad_per_s: f64, value: f64, u: f64) -> Measurement {
    let condition = Condition {
        name: "velocity".to_owned(),
        requested: rate_rad_per_s,
        achieved: Some(1.01 * rate_rad_per_s),
        kind: Q::AngularVelocity,
    };
    Measurement {
        point: Some(format!("velocity={rate_rad_per_s}")),
        conditions: vec![condition],
        ..measured("friction-torque", value, u)
    }
}

fn found<'a>(measurements: &'a [Measurement], plots: &'a [Plot]) -> Found<'a> {
    Found { procedure: "AZ-FRICTION", measurements, plots }
}

fn compared(a: &[Measurement], b: &[Measurement]) -> Comparison {
    compare(&[found(a, &[])], &[found(b, &[])], None)
}

fn calls(comparison: &Comparison) -> Vec<Call> {
    comparison.values.iter().map(|pair| pair.call).collect()
}

#[test]
fn findings_beside_themselves_are_identical_and_one_bit_is_a_difference_of_rounding() {
    let a = [at_rate(0.1, 200.0, 1.0), at_rate(0.2, 190.0, 1.0)];
    let same = compared(&a, &a);
    assert!(same.is_identical() && !same.differs());
    let mut b = a.clone();
    b[1].value = Some(190.0_f64.next_up());
    let rounded = compared(&a, &b);
    assert!(!rounded.is_identical());
    assert_eq!(calls(&rounded), [Call::Identical, Call::Same]);
}

#[test]
fn a_difference_is_judged_in_units_of_both_uncertainties() {
    let difference =
        |b, u_b| compared(&[at_rate(0.1, 200.0, 3.0)], &[at_rate(0.1, b, u_b)]).values[0].clone();
    let same = difference(209.0, 4.0);
    let told = same.difference.expect("both have a value");
    assert!((told.value - 9.0).abs() < 1e-12 && (told.u - 5.0).abs() < 1e-12 && (told.k - 2.0).abs() < 1e-4);
    assert!((told.apart_u.expect("there is an uncertainty") - 1.8).abs() < 1e-12);
    assert!((told.p - 0.071_861).abs() < 1e-6, "twice the upper tail of a normal at 1.8");
    assert_eq!(same.call, Call::Same);
    assert_eq!(difference(211.0, 4.0).call, Call::Differs, "alone it is not one of many");
}

#[test]
fn few_degrees_of_freedom_make_a_difference_less_certain() {
    let few = |dof| Measurement { dof, ..at_rate(0.1, 200.0, 1.0) };
    let other = |dof| Measurement { dof, ..at_rate(0.1, 203.2, 1.0) };
    let [few_p, many_p] = [Some(2.0), None]
        .map(|dof| compared(&[few(dof)], &[other(dof)]).values[0].difference.expect("a pair").p);
    assert!(many_p < 0.05 && few_p > 0.05, "{many_p} {few_p}");
}

#[test]
fn two_in_forty_beyond_their_u_are_near_and_a_large_one_differs() {
    let a: Vec<Measurement> = (1..=40).map(|k| at_rate(0.01 * f64::from(k), 200.0, 1.0)).collect();
    let mut b = a.clone();
    for own in &mut b {
        own.value = Some(200.5);
    }
    b[3].value = Some(203.0);
    b[7].value = Some(197.0);
    b[20].value = Some(215.0);
    let comparison = compared(&a, &b);
    assert_eq!(comparison.count(Call::Near), 2);
    assert_eq!(comparison.count(Call::Differs), 1);
    assert_eq!(comparison.values[20].call, Call::Differs);
    let tolerant = compare(&[found(&a, &[])], &[found(&b, &[])], Some(0.1));
    assert!(!tolerant.differs(), "15 of 215 is within a tenth");
}

/// Sum of twelve uniform numbers less six: a normal deviate up to four deviations.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| f64::from(random.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
}

#[test]
fn equal_units_are_said_to_differ_in_no_more_than_one_comparison_of_twenty() {
    const COMPARISONS: usize = 400;
    let mut random = ChaCha8Rng::seed_from_u64(24);
    let mut run = || -> Vec<Measurement> {
        (1..=150).map(|k| at_rate(f64::from(k), 100.0 + normal(&mut random), 1.0)).collect()
    };
    let all: Vec<Comparison> = (0..COMPARISONS).map(|_| compared(&run(), &run())).collect();
    let wrong = all.iter().filter(|comparison| comparison.differs()).count();
    // 400 at 5 %: 20, deviation 4.4.
    assert!(wrong <= 33, "{wrong} of {COMPARISONS}");
    let near: usize = all.iter().map(|comparison| comparison.count(Call::Near)).sum();
    let share = near as f64 / (150 * COMPARISONS) as f64;
    assert!((share - 0.0455).abs() < 0.005, "beyond their own U: {share}");
}

#[test]
fn without_uncertainty_another_count_is_a_difference_and_a_rounded_zero_is_none() {
    let count = |value| Measurement { kind: Q::Count, ..measured("missed-periods", value, 0.0) };
    assert_eq!(calls(&compared(&[count(0.0)], &[count(3.0)])), [Call::Differs]);
    assert_eq!(calls(&compared(&[count(0.0)], &[count(5.6e-17)])), [Call::Same]);
}

#[test]
fn values_are_paired_by_conditions_and_what_one_run_lacks_is_told_with_its_reason() {
    let renamed = Measurement { point: Some("slow".to_owned()), ..at_rate(0.1, 201.0, 1.0) };
    let why = "the axis did not slide";
    let mute = Measurement { value: None, inconclusive: Some(why.to_owned()), ..at_rate(0.3, 0.0, 0.0) };
    let doubtful = Measurement { inconclusive: Some(why.to_owned()), ..at_rate(0.5, 170.0, 1.0) };
    let a = [at_rate(0.1, 200.0, 1.0), at_rate(0.3, 180.0, 1.0), doubtful.clone()];
    let b = [at_rate(0.2, 190.0, 1.0), renamed, mute, doubtful];
    let comparison = compared(&a, &b);
    assert_eq!(calls(&comparison), [Call::Same, Call::OnlyInA, Call::OnlyInB]);
    assert_eq!(comparison.values[1].reason.as_deref(), Some(why));
    assert_eq!(comparison.values[2].b.map(|b| b.value), Some(190.0));
    assert_eq!(comparison.without_value, 1, "a value in doubt is none, on both sides");
    assert_eq!(comparison.pairs(), 1);
}

#[test]
fn of_several_measurements_alike_the_first_belongs_to_the_first() {
    let a = [measured("unbalance-torque", 10.0, 1.0), measured("unbalance-torque", 30.0, 1.0)];
    let comparison = compared(&a, &a);
    assert!(comparison.is_identical());
    let swapped = [a[1].clone(), a[0].clone()];
    assert_eq!(compared(&a, &swapped).count(Call::Differs), 2);
}

#[test]
fn a_mode_that_one_run_did_not_see_does_not_shift_the_others() {
    let damping = |mode: &str, value| Measurement {
        flags: vec![format!("mode {mode} Hz")],
        ..measured("mode-damping", value, 0.001)
    };
    let a = [damping("1 at 10.99", 0.01), damping("2 at 17.90", 0.03), damping("3 at 20.70", 0.05)];
    let b = [damping("2 at 17.88", 0.03), damping("3 at 20.71", 0.05)];
    assert_eq!(calls(&compared(&a, &b)), [Call::OnlyInA, Call::Identical, Call::Identical]);
}

#[test]
fn a_phase_goes_the_shorter_way_around() {
    let phase = |value| Measurement { kind: Q::Angle, ..measured("cogging-phase", value, 0.01) };
    let comparison = compared(&[phase(3.1)], &[phase(3.11 - std::f64::consts::TAU)]);
    assert!((comparison.values[0].difference.expect("a pair").value - 0.01).abs() < 1e-12);
    assert_eq!(calls(&comparison), [Call::Same]);
}

#[test]
fn a_procedure_of_one_run_is_listed_as_alone() {
    let a = [at_rate(0.1, 200.0, 1.0)];
    let other = Found { procedure: "EL-FRICTION", ..found(&a, &[]) };
    let comparison = compare(&[found(&a, &[])], &[other], None);
    assert_eq!(calls(&comparison), [Call::OnlyInA, Call::OnlyInB]);
    assert_eq!(comparison.pairs(), 0);
    assert!(!comparison.is_identical());
}
