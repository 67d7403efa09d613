//! The whole kind on an axis made of formulas, pulled by a gauge made of formulas.

extern crate self as procedures;

use super::*;
use crate::diagnostic::SourceFile;
use crate::kinds::friction::hysteresis::tests::synthetic_axis::{Gauss, Truth, azimuth, rig};
use crate::log::{EndedBy, SegmentSpan};
use crate::measurement::Measurement;
use crate::synthetic;
use crate::table::read_file;

const FILE: &str = "pull = \"400 N*m\"\narm = \"630 mm\"\narm-uncertainty = \"0.6 mm\"\n\
                    gauge-uncertainty = \"0.3 %\"\nampere = \"rms\"\n";
const RATE_HZ: f64 = 500.0;
/// What the gauge shows without a pull.
const ZERO_N: f64 = 3.0;

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "procedure.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

/// A log of somebody who pulls at `rate`, `late_s` after the zero was read.
fn pulled(truth: &Truth, case: &Case, rate: f64, late_s: f64, seed: u64) -> Window {
    let mut random = Gauss::new(seed);
    let sign = rate.signum();
    let from = case.start_pose_rad["az"];
    let zero_s = 1.5;
    let way_s = 14_f64.to_radians() / rate.abs();
    let end_s = zero_s + late_s.max(0.0) + way_s;
    let count = (end_s * RATE_HZ) as usize;
    let time: Vec<f64> = (0..count).map(|k| k as f64 / RATE_HZ).collect();
    let angle_at = |t: f64| from + rate * (t - zero_s - late_s).max(0.0);
    let force = time.iter().map(|&t| {
        let slides = t > zero_s + late_s;
        let torque = truth.friction_nm(rate.abs())
            + sign * (truth.cogging_nm(angle_at(t)) + truth.load_nm(angle_at(t)));
        ZERO_N + if slides { torque / 0.63 } else { 0.0 } + 0.3 * random.next()
    });
    let force = synthetic::rows("/force", &time, vec![("force_n", force.collect())]);
    let angle = time.iter().map(|&t| angle_at(t)).collect();
    let axis = synthetic::rows("/az", &time, vec![("position_rad", angle), ("current_a", vec![0.0; count])]);
    let span = |segment, start_s, end_s, ended_by| SegmentSpan {
        segment,
        start_s,
        end_s,
        start_position_rad: from,
        ended_by,
    };
    let spans = vec![span(0, 0.0, zero_s, EndedBy::Completed), span(1, zero_s, end_s, EndedBy::Condition)];
    Window::completed(vec![axis, force], spans)
}

/// Judges a unit whose motor has `constant` N·m/A, while the rig file says 60, pulled at `factor` of the velocity.
fn run(constant: f64, factor: f64, late_s: f64) -> Conclusion {
    let truth = azimuth();
    let experiment = read(FILE).expect("the keys are right");
    let axes = rig(&[&truth]);
    let cases = experiment.plan("az", &axes).expect("the axis can do it");
    assert_eq!(cases.len(), 3);
    let real = Truth { torque_constant_nm_per_a: constant, ..azimuth() };
    let points: Vec<PointResult> = cases
        .iter()
        .zip(1..)
        .map(|(case, seed)| {
            let window = match case.pull {
                Some(pull) => pulled(&truth, case, factor * pull.rate_rad_per_s, late_s, seed),
                None => real.run(case, RATE_HZ, seed),
            };
            experiment.analyse(case, &window, &axes)
        })
        .collect();
    experiment.conclude(&cases, &points, &axes)
}

fn of<'a>(found: &'a Conclusion, name: &str) -> &'a Measurement {
    found.measurements.iter().find(|m| m.measurand == name).unwrap_or_else(|| panic!("no {name}: {found:?}"))
}

#[test]
fn a_motor_as_the_rig_file_says_agrees_with_the_gauge_within_its_uncertainty() {
    let found = run(60.0, 1.0, 0.5);
    let constant = of(&found, CONSTANT);
    let value = constant.value.unwrap_or_else(|| panic!("{constant:?}"));
    assert!((value / 60.0 - 1.0).abs() < 0.003, "{value}");
    // 0.3 % gauge, 0.1 % arm; the rest is small.
    assert!((0.003..0.005).contains(&(constant.u / 60.0)), "{}", constant.u);
    assert!(of(&found, ERROR).value.expect("a ratio").abs() < 0.003);
    let friction = of(&found, PULLED);
    let truth = azimuth().friction_nm(2_f64.to_radians());
    assert!((friction.value.expect("a torque") / truth - 1.0).abs() < 0.003, "{friction:?}");
    assert!(found.remarks.is_empty() && found.plots.len() == 1);
    assert!(constant.flags[0].contains("root mean square"));
}

#[test]
fn a_weaker_motor_is_found_with_its_constant_and_called_suspicious() {
    let found = run(49.2, 1.0, 0.5);
    let value = of(&found, CONSTANT).value.expect("a constant");
    assert!((value / 49.2 - 1.0).abs() < 0.004, "{value}");
    assert!((of(&found, ERROR).value.expect("a ratio") + 0.18).abs() < 0.005);
    assert!(found.remarks[0].starts_with("SUSPICIOUS"), "{:?}", found.remarks);
}

#[test]
fn a_pull_at_another_rate_costs_certainty_and_one_far_off_counts_for_nothing() {
    let exact = run(60.0, 1.0, 0.5);
    let slow = run(60.0, 0.93, 0.5);
    assert!(of(&slow, CONSTANT).u > 1.5 * of(&exact, CONSTANT).u);
    let hasty = run(60.0, 1.5, 0.5);
    for name in [CONSTANT, ERROR] {
        let none = of(&hasty, name);
        assert_eq!(none.value, None);
        assert!(none.inconclusive.as_deref().is_some_and(|r| r.contains("within 10 %")), "{none:?}");
    }
}

#[test]
fn a_pull_before_the_zero_was_read_and_a_rig_without_a_gauge_are_inconclusive() {
    let early = run(60.0, 1.0, -0.7);
    assert!(
        of(&early, CONSTANT).inconclusive.as_deref().is_some_and(|r| r.contains("before its zero")),
        "{early:?}"
    );
    let truth = azimuth();
    let experiment = read(FILE).expect("the keys are right");
    let axes = rig(&[&truth]);
    let case = &experiment.plan("az", &axes).expect("a plan")[0];
    let mut bare = pulled(&truth, case, 0.0349, 0.5, 1);
    bare.topics.truncate(1);
    let found = experiment.analyse(case, &bare, &axes);
    assert!(
        found.inconclusive.as_ref().is_some_and(|r| r.to_string().contains("a force gauge")),
        "{found:?}"
    );
}

#[test]
fn nobody_is_next_to_a_drive_that_could_move_the_axis() {
    let axes = rig(&[&azimuth()]);
    let cases = read(FILE).expect("the keys are right").plan("az", &axes).expect("a plan");
    for case in &cases[..2] {
        assert!(case.open_loop && case.torque_limit_nm.is_some_and(|nm| nm < 0.05 * 210.0));
        assert!(
            case.bounds.is_some()
                && case
                    .segments
                    .iter()
                    .all(|s| s.stimulus == crate::stimulus::Stimulus::Hold { torque_nm: 0.0 })
        );
    }
    assert!(cases[2].pull.is_none() && !cases[2].open_loop);
    let short = read(&format!("{FILE}way = \"5 deg\"\n")).expect("the keys are right");
    assert!(short.plan("az", &axes).expect_err("too few periods")[0].message.contains("too few"));
}
