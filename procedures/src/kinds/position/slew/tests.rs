//! Windows of an axis that does what it is told, and of one whose motor cannot.

use super::*;
use crate::diagnostic::SourceFile;
use crate::kinds::position::positioned::tests::{hold_elevation, reached, window_of, with_elevation};
use crate::log::PointStatus;
use crate::measurement::{Bound, Measurement};
use crate::table::read_file;
use crate::verdict::LEAST_DOF;

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "slew.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

fn planned(text: &str, axis: &str) -> (Box<dyn Experiment>, Case) {
    let experiment = read(text).expect("keys");
    let case = experiment.plan(axis, &with_elevation()).expect("a plan").remove(0);
    (experiment, case)
}

/// Follows exactly, and passes each cue by `beyond_rad` for a while.
fn follows(case: &Case, beyond_rad: f64) -> Window {
    let pose = case.start_pose_rad[&case.axis];
    let mut last = [pose, 1.0];
    window_of(case, 500.0, 1e-7, &mut |segment, t, before| {
        if let Some(lasts_s) = segment.stimulus.duration_s(before) {
            last[1] = (segment.stimulus.at(before, lasts_s).position_rad - before).signum();
            return segment.stimulus.at(before, t).position_rad;
        }
        // The rest begins where the move ended, up to its last row.
        let target = Q::Angle.to_display(before).round().to_radians();
        target + last[1] * beyond_rad * (-((t - 0.5) / 0.2).powi(2)).exp()
    })
}

fn value<'a>(result: &'a PointResult, name: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == name).expect("every measurand is there")
}

const FULL: &str = "moves = \"full\"\ncues = [\"-60 deg\", \"60 deg\"]";
const CUE: &str = "moves = \"cue\"\ncues = [\"-20 deg\", \"20 deg\"]";

#[test]
fn an_axis_that_follows_shows_the_acceleration_of_its_plan_and_no_overshoot() {
    let (experiment, case) = planned(FULL, "az");
    let result = experiment.analyse(&case, &follows(&case, 0.0), &with_elevation());
    let limit = with_elevation().all()[0].limits.max_acceleration_rad_per_s2;
    for name in [ACCELERATION, DECELERATION] {
        let found = value(&result, name);
        let a = found.value.unwrap_or_else(|| panic!("{:?}", found.inconclusive));
        assert!((a / limit - 1.0).abs() < 1e-3, "{name}: {a}");
    }
    assert!(value(&result, FULL_OVERSHOOT).value.is_some_and(|rad| rad < 3e-6));
    let (experiment, case) = planned(CUE, "az");
    let result = experiment.analyse(&case, &follows(&case, 0.0), &with_elevation());
    let excess = value(&result, EXCESS);
    assert!(excess.value.is_some_and(|e| e < 0.0), "{excess:?}");
    assert!(value(&result, SETTLING).value.is_some_and(|s| s < 0.1));
}

#[test]
fn the_elevation_of_a_slew_is_where_the_log_has_it() {
    let (experiment, case) = planned(FULL, "az");
    let axes = with_elevation();
    let mut window = follows(&case, 0.0);
    assert_eq!(reached(&experiment.analyse(&case, &window, &axes), "elevation"), None);
    hold_elevation(&mut window, 0.3);
    let elevation_rad = reached(&experiment.analyse(&case, &window, &axes), "elevation");
    assert!(elevation_rad.is_some_and(|rad| (rad - 0.3).abs() < 1e-9), "{elevation_rad:?}");
}

#[test]
fn a_slew_that_does_not_settle_passes_no_limit_and_may_fail_one() {
    let (experiment, case) = planned(CUE, "az");
    let pose = case.start_pose_rad[&case.axis];
    // It goes on swinging by 0.2 mrad, in turns of 0.5 s.
    let swings = window_of(&case, 500.0, 1e-7, &mut |segment, t, before| {
        let swing = 2e-4 * (std::f64::consts::TAU * t / 0.5).sin();
        match segment.stimulus.duration_s(before) {
            Some(_) => segment.stimulus.at(before, t).position_rad,
            None => (Q::Angle.to_display(before).round().to_radians() - pose) + pose + swing,
        }
    });
    let result = experiment.analyse(&case, &swings, &with_elevation());
    let settling = value(&result, SETTLING);
    assert!(settling.value.is_some_and(|s| s > 1.0), "{settling:?}");
    let at_least = |bound: &Bound| matches!(bound, Bound::AtLeast(why) if why.contains("did not settle"));
    assert!(settling.bound.as_ref().is_some_and(at_least), "{settling:?}");
    assert!(settling.u > 0.0);
    let settled = experiment.analyse(&case, &follows(&case, 0.0), &with_elevation());
    assert_eq!(value(&settled, SETTLING).bound, None);
    // What a requirement may claim: the angles that its cues span.
    let [first_rad, last_rad] = value(&settled, SETTLING).angles_rad.expect("it says between which angles");
    let cue_rad = 20_f64.to_radians();
    let off_rad = (first_rad + cue_rad).abs().max((last_rad - cue_rad).abs());
    assert!(off_rad < 1e-5, "{first_rad} {last_rad}");
}

#[test]
fn an_axis_that_passes_its_cue_by_a_tenth_of_a_milliradian_overshoots() {
    let (experiment, case) = planned(CUE, "az");
    let result = experiment.analyse(&case, &follows(&case, 1e-4), &with_elevation());
    let excess = value(&result, EXCESS).value.expect("an overshoot");
    assert!((9e-5..1.1e-4).contains(&excess), "{excess:e}");
    assert!(value(&result, SETTLING).value.is_some_and(|s| s > 0.4));
}

#[test]
fn an_overshoot_is_judged_by_the_scatter_of_five_repeats_and_not_by_the_noise_of_one() {
    for (repeats, dof) in [(1, 1.0), (2, 1.0), (4, 3.0), (5, 4.0)] {
        let (experiment, case) = planned(&format!("{CUE}\nrepeats = {repeats}"), "az");
        let result = experiment.analyse(&case, &follows(&case, 0.0), &with_elevation());
        let excess = value(&result, EXCESS);
        assert_eq!((excess.dof, dof >= LEAST_DOF), (Some(dof), repeats >= 5), "{repeats} repeats");
    }
}

#[test]
fn a_gentle_move_shows_the_velocity_with_the_least_acceleration_that_reaches_it() {
    let (experiment, case) = planned("moves = \"gentle\"\nelevation = \"10 deg\"", "az");
    let reach = case.envelope();
    assert!(reach.acceleration_rad_per_s2 < 20_f64.to_radians(), "{reach:?}");
    let result = experiment.analyse(&case, &follows(&case, 0.0), &with_elevation());
    let found = value(&result, VELOCITY).value.expect("a cruise");
    assert!((found / 60_f64.to_radians() - 1.0).abs() < 1e-4, "{found}");
}

/// Half the torque is missing, and an interlock ends the first move while it speeds up.
fn weak(case: &Case, shown_nm: f64) -> Window {
    const REACHED: f64 = 0.5;
    let limit = case.envelope().acceleration_rad_per_s2;
    let mut window = window_of(case, 500.0, 1e-7, &mut |segment, t, before| {
        let moves = segment.stimulus.duration_s(before).is_some();
        before + if moves { 0.5 * REACHED * limit * t * t } else { 0.0 }
    });
    let cut_s = window.segments[1].start_s + 0.4;
    window.segments.truncate(2);
    window.segments[1].end_s = cut_s;
    let rows = &mut window.topics[0];
    let keep = rows.time_s.partition_point(|t| *t < cut_s);
    rows.time_s.truncate(keep);
    rows.columns.iter_mut().for_each(|column| column.truncate(keep));
    rows.columns[3].fill(2000.0);
    rows.columns[4].fill(shown_nm);
    window.status = PointStatus::Aborted;
    window.trips = vec!["following error: 0.06 rad".to_owned()];
    window
}

#[test]
fn a_motor_that_is_too_weak_fails_with_what_it_reached_until_the_interlock() {
    let (experiment, case) = planned(FULL, "az");
    let result = experiment.analyse(&case, &weak(&case, 1000.0), &with_elevation());
    let found = value(&result, ACCELERATION);
    let half = 0.5 * with_elevation().all()[0].limits.max_acceleration_rad_per_s2;
    assert!(found.value.is_some_and(|a| (a / half - 1.0).abs() < 0.02), "{found:?}");
    assert!(
        found.flags.iter().any(|flag| flag.contains("1000 N*m where 2000 N*m was commanded")),
        "{:?}",
        found.flags
    );
    assert!(value(&result, FULL_OVERSHOOT).value.is_none());
    let (experiment, case) = planned("moves = \"gentle\"", "az");
    let result = experiment.analyse(&case, &weak(&case, 1000.0), &with_elevation());
    assert!(value(&result, VELOCITY).value.is_some_and(|v| v < 0.2));
}

#[test]
fn an_interlock_for_another_reason_leaves_no_number() {
    let (experiment, case) = planned(FULL, "az");
    let result = experiment.analyse(&case, &weak(&case, 2000.0), &with_elevation());
    assert!(result.measurements.iter().all(|m| m.value.is_none()));
    assert!(result.inconclusive.is_some_and(|why| why.to_string().contains("following error")));
}

#[test]
fn an_encoder_that_the_gyro_contradicts_leaves_no_acceleration() {
    let (experiment, case) = planned(FULL, "az");
    let mut window = follows(&case, 0.0);
    window.topics[0].columns[2].iter_mut().for_each(|rate| *rate *= 0.9);
    let found = experiment.analyse(&case, &window, &with_elevation());
    let reason = value(&found, ACCELERATION).inconclusive.clone();
    assert!(reason.is_some_and(|why| why.contains("disagree")));
}

#[test]
fn cues_that_cannot_be_are_refused() {
    assert!(read("moves = \"full\"\ncues = [\"10 deg\"]").is_err());
    assert!(read("moves = \"full\"\ncues = [\"10 deg\", \"10 deg\"]").is_err());
    let axes = with_elevation();
    for cue in ["170 deg", "159 deg"] {
        let refused = read(&format!("moves = \"full\"\ncues = [\"0 deg\", \"{cue}\"]"))
            .expect("keys")
            .plan("az", &axes);
        assert!(refused.is_err_and(|all| all[0].to_string().contains("soft limits")), "{cue}");
    }
    let near = read("moves = \"gentle\"\ncues = [\"0 deg\", \"20 deg\"]").expect("keys").plan("az", &axes);
    assert!(near.is_err_and(|all| all[0].to_string().contains("cruises")));
}
