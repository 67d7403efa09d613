use super::*;
use crate::diagnostic::SourceFile;
use crate::log::{EndedBy, SegmentSpan};
use crate::measurement::Measurement;
use crate::procedure::sample::sample_axes;
use crate::synthetic;
use crate::table::read_file;

const FILE: &str =
    "hold = [\"10 deg\"]\nhold-time = \"8 s\"\nrelease = [\"10 deg\"]\noff = [\"10 deg\", \"-20 deg\"]\n";
const RATE_HZ: f64 = 500.0;

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "procedure.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

fn cases() -> Vec<Case> {
    read(FILE).expect("the keys are right").plan("az", &sample_axes()).expect("inside the travel")
}

/// A log of a point whose segments last 1 s each and the last 8 s; `angle` and `current` over the time since the last
/// segment began, `after_s` more rows after its end.
fn window(case: &Case, settled: EndedBy, ended: EndedBy, after_s: f64, angle: impl Fn(f64) -> f64) -> Window {
    let watched =
        case.segments.iter().position(|s| [plan::HELD, plan::RELEASED, plan::OFF].contains(&&*s.label));
    let watched = watched.expect("every point watches something");
    let span = |segment: usize| {
        let start_s = segment as f64;
        let last = segment == watched;
        let end_s = if last { start_s + 8.0 } else { start_s + 1.0 };
        let ended_by = match &*case.segments[segment].label {
            "settle" => settled,
            _ if last => ended,
            _ => EndedBy::Completed,
        };
        SegmentSpan { segment, start_s, end_s, start_position_rad: 0.0, ended_by }
    };
    let from_s = watched as f64;
    let count = ((from_s + 8.0 + after_s) * RATE_HZ) as usize;
    let time: Vec<f64> = (0..count).map(|k| k as f64 / RATE_HZ).collect();
    let position = time.iter().map(|t| angle(t - from_s)).collect();
    // A grain of 0.02 A about 0.5 A, without randomness.
    let current = (0..count).map(|k| 0.5 + 0.02 * (k as f64 * 2.399_963).sin()).collect();
    let rows = synthetic::rows("/az", &time, vec![("position_rad", position), ("current_a", current)]);
    Window::completed(vec![rows], (0..=watched).map(span).collect())
}

fn analysed(case: &Case, window: &Window) -> PointResult {
    read(FILE).expect("the keys are right").analyse(case, window, &sample_axes())
}

fn of<'a>(result: &'a PointResult, name: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == name).expect("measured, or said why not")
}

#[test]
fn a_point_approaches_from_below_settles_and_then_holds_lets_go_or_switches_off() {
    let all = cases();
    let names: Vec<&str> = all.iter().map(|c| c.point.as_str()).collect();
    assert_eq!(
        names,
        ["held, pose=10 deg", "released, pose=10 deg", "off, pose=10 deg", "off, pose=-20 deg"]
    );
    for case in &all {
        let pose = case.requested("pose").expect("a pose");
        assert!((pose - case.start_pose_rad["az"] - 1_f64.to_radians()).abs() < 1e-12);
        assert_eq!([&case.segments[0].label, &case.segments[1].label], ["approach", "settle"]);
    }
    let last = |k: usize| all[k].segments.last().expect("segments").then;
    use crate::case::Then;
    assert_eq!([last(0), last(1), last(2)], [Then::Stop, Then::Stop, Then::TorqueOff]);
}

#[test]
fn noise_drift_and_torque_of_a_held_axis_come_back() {
    let case = &cases()[0];
    // 2 µrad of a sine that fits no batch, 0.5 µrad/s of drift.
    let angle = |t: f64| 0.17 + 0.5e-6 * t + 2e-6 * (991.7 * t).sin();
    let found = analysed(case, &window(case, EndedBy::Condition, EndedBy::Completed, 0.0, angle));
    assert_eq!((found.inconclusive.as_ref(), found.plots.len()), (None, 1));
    let value = |name: &str| of(&found, name).value.expect("a number");
    assert!((value(NOISE) / (2e-6 / 2_f64.sqrt()) - 1.0).abs() < 0.02, "{}", value(NOISE));
    assert!((value(DRIFT) - 0.5e-6).abs() < 3.0 * of(&found, DRIFT).u + 1e-8, "{:?}", of(&found, DRIFT));
    assert!((value(TORQUE) - 30.0).abs() < 0.01 && of(&found, TORQUE).u > 0.15, "0.5 % of 30 N·m");
    assert!((value(TORQUE_NOISE) - 60.0 * 0.02 / 2_f64.sqrt()).abs() < 0.01);
    assert!(of(&found, NOISE).evidence[0].channels == ["/az position_rad"]);
}

#[test]
fn an_axis_that_gives_a_little_and_stays_holds_itself() {
    for case in [&cases()[1], &cases()[2]] {
        let give = |t: f64| {
            let since = if case.point.starts_with("off") { t - 8.0 } else { t };
            if since < 0.0 { 0.17 } else { 0.17 + 1e-3 * (1.0 - (-since / 0.2).exp()) }
        };
        let found = analysed(case, &window(case, EndedBy::Condition, EndedBy::Timeout, 3.0, give));
        let movement = of(&found, MOVEMENT);
        assert!((movement.value.expect("a movement") - 1e-3).abs() < 1e-5, "{movement:?}");
        assert!(movement.flags[0].starts_with("holds itself"), "{movement:?}");
        assert!(found.remarks.is_empty());
    }
}

#[test]
fn an_axis_that_creeps_on_or_slides_does_not() {
    let case = &cases()[1];
    let creeps = analysed(
        case,
        &window(case, EndedBy::Condition, EndedBy::Timeout, 0.0, |t| 0.17 + 2e-4 * t.max(0.0)),
    );
    assert!(of(&creeps, MOVEMENT).flags[0].starts_with(MOVEMENT_MOVED), "{creeps:?}");
    let slides = analysed(
        case,
        &window(case, EndedBy::Condition, EndedBy::Condition, 0.0, |t| 0.17 + 0.0105 * (t.max(0.0) / 8.0)),
    );
    assert!(of(&slides, MOVEMENT).flags[0].starts_with("SLID: held again after 0.6"), "{slides:?}");
    assert!(slides.remarks[0].contains("does not hold itself"));
}

const MOVEMENT_MOVED: &str = "MOVED: 0.25 deg allowed";

#[test]
fn an_axis_that_never_came_to_rest_and_a_log_without_rows_are_inconclusive() {
    for case in &cases() {
        let restless = analysed(case, &window(case, EndedBy::Timeout, EndedBy::Completed, 3.0, |_| 0.17));
        assert!(restless.inconclusive.as_ref().is_some_and(|r| r.to_string().contains("was not at rest")));
        let mut bare = window(case, EndedBy::Condition, EndedBy::Completed, 3.0, |_| 0.17);
        bare.topics[0].time_s.clear();
        bare.topics[0].columns.iter_mut().for_each(Vec::clear);
        let empty = analysed(case, &bare);
        assert!(empty.measurements.iter().all(|m| m.value.is_none()), "{empty:?}");
        assert!(empty.inconclusive.is_some());
    }
}

#[test]
fn a_file_without_poses_and_a_catch_inside_what_is_allowed_are_refused() {
    let nothing = read("hold-time = \"5 s\"\n").expect_err("no poses");
    assert!(nothing[0].message.contains("no poses"), "{nothing:?}");
    let early = read("release = [\"10 deg\"]\ncatch = \"0.1 deg\"\n").expect_err("caught too early");
    assert!(early[0].message.contains("must not be below `movement`"), "{early:?}");
}
