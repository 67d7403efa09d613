//! A real motor: cogging maps measured by Gerry Chen (tests/data/odrive_cogging), no time axis, no torque constant.

use std::f64::consts::TAU;

use super::synthetic_axis::{azimuth, elevation, rig, window};
use super::*;
use crate::axis::Axes;
use crate::case::{Case, Mode, Segment, Then};
use crate::log::{EndedBy, SegmentSpan};
use crate::stimulus::Stimulus;

const FORWARD: &str = include_str!("../../../../../../tests/data/odrive_cogging/cogging_c_16.csv");
const REVERSE: &str = include_str!("../../../../../../tests/data/odrive_cogging/cogging_e_16r.csv");

/// A check value of the data's README.
struct Check {
    order: f64,
    amplitude_a: f64,
    phase_deg: f64,
}

const fn check(order: f64, amplitude_a: f64, phase_deg: f64) -> Check {
    Check { order, amplitude_a, phase_deg }
}

const CHECK_FORWARD: [Check; 6] = [
    check(7.0, 1.0385, 73.0),
    check(12.0, 0.2637, 60.7),
    check(14.0, 0.3452, 94.5),
    check(28.0, 0.5611, -59.5),
    check(36.0, 0.2915, 113.4),
    check(84.0, 0.1208, -1.5),
];
#[allow(clippy::approx_constant, reason = "a measured amplitude that happens to be near lg 2")]
const CHECK_REVERSE: [Check; 6] = [
    check(7.0, 1.0413, 68.5),
    check(12.0, 0.2708, 56.2),
    check(14.0, 0.3513, 92.0),
    check(28.0, 0.5614, -69.5),
    check(36.0, 0.3010, 96.7),
    check(84.0, 0.1331, -36.4),
];

/// Angle in rad and current in A of a map.
fn map(csv: &str) -> Vec<[f64; 2]> {
    let number = |text: Option<&str>| text.and_then(|t| t.parse::<f64>().ok()).expect("the data are numbers");
    csv.lines()
        .skip(1)
        .map(|line| {
            let mut fields = line.split(',').skip(1);
            [number(fields.next()) * TAU, number(fields.next())]
        })
        .collect()
}

/// Judges branches as `bench import` hands them over: no meaningful time, one segment each.
fn judge(branches: &[(&str, Vec<[f64; 2]>)], axes: &Axes, axis: &str) -> Conclusion {
    let mut rows = Vec::new();
    let mut segments = Vec::new();
    let mut spans = Vec::new();
    for (index, (label, points)) in branches.iter().enumerate() {
        let start_s = rows.len() as f64;
        rows.extend(
            points.iter().zip(rows.len()..).map(|([angle, current], k)| [k as f64, *angle, *current]),
        );
        segments.push(Segment {
            label: (*label).to_owned(),
            mode: Mode::Position,
            stimulus: Stimulus::Hold { torque_nm: 0.0 },
            until: None,
            at_most_s: points.len() as f64,
            then: Then::Next,
            dithered: false,
            ..Segment::default()
        });
        spans.push(SegmentSpan {
            segment: index,
            start_s,
            end_s: rows.len() as f64,
            start_position_rad: points[0][0],
            ended_by: EndedBy::Completed,
        });
    }
    let case = Case {
        point: "maps".to_owned(),
        axis: axis.to_owned(),
        requested: Vec::new(),
        start_pose_rad: std::iter::once((axis.to_owned(), 0.0)).collect(),
        segments,
        ..Case::default()
    };
    let experiment = read("").expect("no keys are needed");
    let point = experiment.analyse(&case, &window(axis, spans, &rows), axes);
    experiment.conclude(std::slice::from_ref(&case), &[point], axes)
}

/// An axis without torque constant, 12 slots and 14 poles: 84 per revolution.
fn motor() -> Axes {
    let mut axes = rig(&[&azimuth()]);
    let axis = axes.get_mut("az").expect("the rig has it");
    axis.torque_constant_nm_per_a = None;
    axis.cogging_orders_per_rev = 84.0;
    axes
}

/// One order in one direction.
#[derive(Debug)]
struct Found {
    amplitude_a: f64,
    phase_deg: f64,
}

/// What was found at one order in one direction (0: mean of both).
fn harmonic(conclusion: &Conclusion, order: f64, direction: f64) -> Option<Found> {
    let condition =
        |m: &Measurement, name: &str| m.conditions.iter().find(|c| c.name == name).map(|c| c.requested);
    let value = |name: &str| {
        let mut all = conclusion.measurements.iter().filter(|m| m.measurand == name);
        all.find(|m| {
            condition(m, "order") == Some(order) && condition(m, "direction").unwrap_or(0.0) == direction
        })?
        .value
    };
    Some(Found {
        amplitude_a: value("cogging-harmonic-current")?,
        phase_deg: value("cogging-phase")?.to_degrees(),
    })
}

#[test]
fn maps_of_a_real_motor_give_the_check_values_of_their_readme() {
    let branches = [("forward", map(FORWARD)), ("reverse", map(REVERSE))];
    let found = judge(&branches, &motor(), "az");
    for (direction, check) in [(1.0, CHECK_FORWARD), (-1.0, CHECK_REVERSE)] {
        for Check { order, amplitude_a, phase_deg } in check {
            let found = harmonic(&found, order, direction).expect("a line of the README");
            assert!(
                (found.amplitude_a - amplitude_a).abs() < 6e-5,
                "order {order}: {found:?}, README {amplitude_a} A"
            );
            assert!(
                (found.phase_deg - phase_deg).abs() < 0.06,
                "order {order}: {found:?}, README {phase_deg}°"
            );
        }
    }
    let friction = find(&found, "friction-current");
    assert!((friction.value.expect("two directions") - 0.171).abs() < 5e-4, "{friction:?}");
    assert!(friction.u > 0.0005 && friction.u < 0.02, "{friction:?}");
    assert!(found.remarks.iter().any(|r| r.contains("-0.02")), "half sum −0.022 A: {:?}", found.remarks);
    let order = find(&found, "cogging-order");
    assert!((order.value.expect("the slots") - 84.0).abs() < 0.1, "{order:?}");
    assert_eq!(order.flags, ["order 7 is larger", analysis::goodness::BY_SCATTER]);
    // Mean of directions at 84: the two maps are 35° apart there, so it is smaller than either.
    let mean = harmonic(&found, 84.0, 0.0).expect("the slots").amplitude_a;
    assert!((mean - 0.1212).abs() < 5e-4, "{mean}");
    let peak = find(&found, "cogging-peak-current").value.expect("lines");
    let lines = found.measurements.iter().filter(|m| m.measurand == "cogging-harmonic-current");
    let means = lines.filter(|m| m.conditions.iter().all(|c| c.name != "direction")).filter_map(|m| m.value);
    let [largest, all] = means.fold([0.0_f64, 0.0], |[most, sum], a| [most.max(a), sum + a]);
    assert!(largest < peak && peak < all, "{largest} A, {peak} A, {all} A");
    assert!(!found.measurements.iter().any(|m| m.measurand == "unbalance-torque"));
}

#[test]
fn one_direction_alone_still_has_its_orders() {
    let found = judge(&[("forward", map(FORWARD))], &motor(), "az");
    let friction = find(&found, "friction-current");
    assert_eq!(friction.inconclusive.as_deref(), Some("one direction only: friction needs both"));
    let harmonic = harmonic(&found, 28.0, 0.0).expect("the second pole harmonic");
    assert!((harmonic.amplitude_a - 0.5611).abs() < 6e-5, "{harmonic:?}");
}

#[test]
fn unevenly_spaced_branches_on_part_of_a_turn_give_torque_friction() {
    let truth = elevation();
    let branch = |sign: f64| -> Vec<[f64; 2]> {
        (0..6000)
            .map(|k| {
                let s = f64::from(k) / 6000.0;
                let angle = (-8.0 + 96.0 * (s + 0.02 * (s * 40.0).sin())).to_radians();
                let torque = sign * 35.0 + truth.cogging_nm(angle) + truth.load_nm(angle);
                [angle, torque / truth.torque_constant_nm_per_a]
            })
            .collect()
    };
    let found = judge(&[("forward", branch(1.0)), ("reverse", branch(-1.0))], &rig(&[&truth]), "el");
    let friction = find(&found, "friction-torque").value.expect("two directions");
    assert!((friction - 35.0).abs() < 0.01, "{friction}");
    let amplitude = find(&found, "cogging-amplitude").value.expect("28 periods");
    assert!((amplitude - 5.07).abs() < 0.05, "{amplitude}");
}

#[test]
fn a_window_without_branches_or_channels_says_so() {
    let found = judge(&[("dwell", map(FORWARD))], &motor(), "az");
    let reason = find(&found, "friction-current").inconclusive.as_deref();
    assert_eq!(reason, Some("no segment `forward` or `reverse` with 16 rows"));
}
