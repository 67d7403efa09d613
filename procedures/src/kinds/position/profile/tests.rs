//! Windows of an axis that follows late, and of one that ripples.

use super::*;
use crate::diagnostic::SourceFile;
use crate::kinds::position::positioned::tests::{hold_elevation, reached, window_of, with_elevation};
use crate::measurement::Measurement;
use crate::table::read_file;

const ALL: &str = "[ramp]\nspan = \"-5 deg .. 5 deg\"\n[sine]\namplitude = \"1 deg\"\nfrequency = \"0.5 Hz\"\n[path]\n\
                   time = [\"0 s\", \"4 s\", \"8 s\"]\nposition = [\"0 deg\", \"3 deg\", \"0 deg\"]";

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "profile.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

/// Late by `delay_s`, and with a ripple of this amplitude at 0.7 Hz.
fn run(text: &str, delay_s: f64, ripple_rad: f64) -> Vec<PointResult> {
    let experiment = read(text).expect("keys");
    let axes = with_elevation();
    let cases = experiment.plan("az", &axes).expect("a plan");
    let one = |case: &Case| {
        let mut window = window_of(case, 500.0, 0.0, &mut |segment, t, before| {
            if segment.stimulus.duration_s(before).is_none() {
                return before;
            }
            let start = if before.abs() < 1e-3 { 0.0 } else { 5_f64.to_radians().copysign(before) };
            segment.stimulus.at(start, t - delay_s).position_rad + ripple_rad * (4.4 * t).sin()
        });
        hold_elevation(&mut window, 0.3);
        experiment.analyse(case, &window, &axes)
    };
    cases.iter().map(one).collect()
}

fn value<'a>(result: &'a PointResult, name: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == name).expect("every measurand is there")
}

#[test]
fn a_late_axis_lags_by_rate_times_delay_and_not_at_all_once_the_delay_is_removed() {
    let points = run(ALL, 2e-3, 0.0);
    let lag = 0.674_f64.to_radians() * 2e-3;
    let measured = |k: usize, name| {
        value(&points[k], name).value.unwrap_or_else(|| panic!("{:?}", points[k].inconclusive))
    };
    assert!((measured(0, RAMP_ERROR) / lag - 1.0).abs() < 0.01, "{}", measured(0, RAMP_ERROR));
    assert!(measured(0, "ramp-error-aligned") < 0.01 * lag);
    let fastest = 1_f64.to_radians() * std::f64::consts::PI;
    assert!((measured(1, PATH_ERROR) / (2e-3 * fastest) - 1.0).abs() < 0.01);
    for k in [1, 2] {
        assert!((measured(k, "path-delay") - 2e-3).abs() < 2e-5, "{}", measured(k, "path-delay"));
        assert!(measured(k, "path-error-aligned") < 0.02 * measured(k, PATH_ERROR));
    }
    for point in &points {
        let elevation_rad = reached(point, "elevation");
        assert!(elevation_rad.is_some_and(|rad| (rad - 0.3).abs() < 1e-9), "{elevation_rad:?}");
    }
    let achieved = reached(&points[0], "velocity");
    assert!((achieved.expect("a rate") / 0.674_f64.to_radians() - 1.0).abs() < 1e-3);
}

#[test]
fn a_ripple_counts_in_full_in_the_percentile_and_says_so_in_its_alignment() {
    let points = run("[ramp]\nspan = \"-5 deg .. 5 deg\"", 0.0, 1e-4);
    let found = value(&points[0], RAMP_ERROR);
    assert!((found.value.expect("an error") / 1e-4 - 1.0).abs() < 0.01);
    assert!((value(&points[0], "ramp-error-rms").value.expect("rms") / 1e-4 - 0.5_f64.sqrt()).abs() < 0.02);
    assert!(found.flags.iter().any(|flag| flag == "alignment: none"));
    assert!(found.dof.is_some_and(|dof| dof >= 4.0));
}

#[test]
fn a_path_that_jumps_is_refused_where_it_stands() {
    let jump = "[path]\ntime = [\"0 s\", \"2 s\", \"2 s\", \"4 s\"]\nposition = [\"0 deg\", \"1 deg\", \"2 deg\", \"2 deg\"]";
    let refused = read(jump).expect_err("a jump");
    assert!(refused[0].to_string().contains("jumps from 1 deg to 2 deg at 2 s"), "{}", refused[0]);
}

#[test]
fn nothing_to_follow_and_places_beyond_the_travel_are_refused() {
    let nothing = read("elevation = \"0 deg\"").expect_err("nothing");
    assert!(nothing[0].to_string().contains("no reference to follow"));
    assert!(read("[sine]\namplitude = \"1 deg\"\nfrequency = \"1 Hz\"\ncycles = 3").is_err());
    let axes = with_elevation();
    let soft = read("[ramp]\nspan = \"150 deg .. 159 deg\"").expect("keys").plan("az", &axes);
    assert!(soft.is_err_and(|all| all[0].to_string().contains("soft limits")));
    let swing =
        read("[sine]\namplitude = \"2 deg\"\nfrequency = \"0.2 Hz\"\nmiddle = \"88 deg\"").expect("keys");
    assert!(swing.plan("el", &axes).is_err());
}

#[test]
fn a_ramp_of_three_seconds_is_too_short_to_say_anything() {
    let points = run("[ramp]\nspan = \"-1 deg .. 0 deg\"", 0.0, 0.0);
    assert!(points[0].inconclusive.is_some() && points[0].measurements.iter().all(|m| m.value.is_none()));
}
