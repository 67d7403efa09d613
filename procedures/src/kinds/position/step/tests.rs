//! Windows of a position loop made of a formula.

use super::plan::{STEP, THERE};
use super::*;
use crate::case::Mode;
use crate::diagnostic::SourceFile;
use crate::kinds::position::positioned::tests::{hold_elevation, reached, window_of, with_elevation};
use crate::measurement::Measurement;
use crate::table::read_file;

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "step.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

/// First order at 4.5 1/s; the share `overshoot` of each step is passed and given back half a second later.
fn run(overshoot: f64) -> PointResult {
    let experiment = read("").expect("defaults");
    let axes = with_elevation();
    let cases = experiment.plan("az", &axes).expect("a plan");
    let response = |t: f64| 1.0 - (-4.5 * t).exp() + overshoot * (-((t - 1.0) / 0.15).powi(2)).exp();
    let case = &cases[0];
    let window = window_of(case, 500.0, 1e-7, &mut |segment, t, before| match segment.stimulus {
        crate::stimulus::Stimulus::Step { target_rad } => before + (target_rad - before) * response(t),
        _ => before,
    });
    experiment.analyse(case, &window, &axes)
}

fn value<'a>(result: &'a PointResult, name: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == name).expect("every measurand is there")
}

#[test]
fn a_loop_without_overshoot_shows_none_and_its_times() {
    let result = run(0.0);
    assert_eq!(result.inconclusive, None);
    let rise_s = value(&result, RISE).value.expect("a rise");
    assert!((rise_s - 9.0_f64.ln() / 4.5).abs() < 2e-3, "{rise_s}");
    let excess = value(&result, EXCESS).value.expect("an overshoot to speak of or not");
    assert!(excess < 0.0, "{excess:e}");
    assert!((value(&result, FINAL).value.expect("a final value") - 1.0).abs() < 1e-3);
}

#[test]
fn elevation_and_height_of_a_step_are_those_of_the_log() {
    let experiment = read("").expect("defaults");
    let axes = with_elevation();
    let stepped = |axis: &str, held_rad: Option<f64>| {
        let case = experiment.plan(axis, &axes).expect("a plan").remove(0);
        // Seven tenths of each step, from a place 20 mrad beside the one that was asked for.
        let mut window = window_of(&case, 500.0, 1e-7, &mut |segment, t, before| match segment.stimulus {
            crate::stimulus::Stimulus::Step { target_rad } => {
                let start_rad = case.start_pose_rad[axis];
                let way_rad = if segment.label == THERE { target_rad - start_rad } else { 0.0 };
                let to_rad = start_rad + 0.02 + 0.7 * way_rad;
                before + (to_rad - before) * (1.0 - (-4.5 * t).exp())
            }
            _ => case.start_pose_rad[axis] + 0.02,
        });
        held_rad.into_iter().for_each(|rad| hold_elevation(&mut window, rad));
        let result = experiment.analyse(&case, &window, &axes);
        let asked_rad = case.requested("elevation").expect("an elevation");
        (asked_rad, reached(&result, "elevation"), case.requested(STEP), reached(&result, STEP), result)
    };
    let (_, elevation_rad, asked_rad, height_rad, result) = stepped("az", Some(0.3));
    assert!(elevation_rad.is_some_and(|rad| (rad - 0.3).abs() < 1e-9), "{elevation_rad:?} {result:?}");
    let ratio = height_rad.expect("a height") / asked_rad.expect("a height");
    assert!((ratio - 0.7).abs() < 0.01, "{ratio}");
    let (asked_rad, elevation_rad, ..) = stepped("el", None);
    assert!(elevation_rad.is_some_and(|rad| (rad - asked_rad - 0.02).abs() < 1e-6), "{elevation_rad:?}");
}

#[test]
fn a_loop_that_overshoots_by_two_hundredths_is_caught() {
    let excess = value(&run(0.02), EXCESS).value.expect("an overshoot");
    assert!(excess > 1e-5, "{excess:e}");
}

#[test]
fn an_axis_that_stays_where_it_is_gives_no_number_but_the_reason() {
    let experiment = read("").expect("defaults");
    let axes = with_elevation();
    let cases = experiment.plan("az", &axes).expect("a plan");
    let window = window_of(&cases[0], 500.0, 0.0, &mut |_, _, before| before);
    let result = experiment.analyse(&cases[0], &window, &axes);
    assert!(
        result.inconclusive.as_ref().is_some_and(|r| r.to_string().contains("no step")),
        "{:?}",
        result.inconclusive
    );
    assert!(result.measurements.iter().all(|m| m.value.is_none()));
}

#[test]
fn heights_elevations_and_holds_that_cannot_be_are_refused() {
    let axes = with_elevation();
    assert!(read("step = [\"0 deg\"]\nhold = \"1 s\"\nrepeats = 2").is_err_and(|all| all.len() == 3));
    let beyond = read("elevation = [\"89.45 deg\"]").expect("keys").plan("el", &axes);
    assert!(beyond.is_err_and(|all| all[0].to_string().contains("soft limits")));
    let plan = read("elevation = [\"80 deg\"]").expect("keys").plan("el", &axes).expect("downwards");
    assert!(plan[0].envelope().position_rad[1] <= 80.1_f64.to_radians());
    assert!(plan[0].segments.iter().all(|s| s.mode == Mode::Position));
}

#[test]
fn the_panel_shows_what_passes_the_final_value_against_what_counts_as_an_overshoot() {
    for (share, above) in [(0.0, false), (0.02, true)] {
        let plots = run(share).plots;
        assert_eq!(plots[1].panel_of.as_deref(), Some(plots[0].id.as_str()));
        let threshold = plots[1].masks[0].points[0][1];
        let most = plots[1].series.iter().flat_map(|s| &s.y).fold(f64::NEG_INFINITY, |most, y| most.max(*y));
        assert_eq!(most > threshold, above, "{most} of {threshold} urad");
        assert!(plots.iter().flat_map(|p| &p.series).all(|s| s.x.len() <= 2000));
    }
}
