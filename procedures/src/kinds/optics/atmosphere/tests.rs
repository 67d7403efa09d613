use std::f64::consts::TAU;

use analysis::frf::C64;

use super::keys::{CLOSED, OPEN};
use super::*;
use crate::diagnostic::SourceFile;
use crate::kinds::optics::frames::tests::Scene;
use crate::kinds::position::positioned::tests::with_elevation;
use crate::measurement::Measurement;
use crate::procedure::Procedure;

fn keys() -> Keys {
    Keys {
        closed_s: 40.0,
        open_s: 12.0,
        segment_s: 4.0,
        frequencies_hz: vec![1.0, 3.0, 8.0, 15.0],
        frame_rate_hz: 200.0,
        amplitude_rad: 300e-6,
        timing_u_s: 0.05e-3,
        pose_rad: [0.0, 0.7],
    }
}

fn of<'a>(conclusion: &'a Conclusion, measurand: &str, axis: &str) -> Vec<&'a Measurement> {
    conclusion.measurements.iter().filter(|m| m.measurand == measurand && m.axis == axis).collect()
}

fn value(m: &Measurement) -> f64 {
    m.value.unwrap_or_else(|| panic!("{}: {:?}", m.measurand, m.inconclusive))
}

/// What is left of the line of sight by an integrator per frame whose command is obeyed after a delay and held:
/// S = 1 − (K/jω)·e^(−jωτ)/(1 + L), L = K·Ts·z^(−n)/(1 − z⁻¹), z = e^(jωTs), n the whole frames in τ.
fn left_db(gain_per_s: f64, delay_s: f64, frequency_hz: f64) -> f64 {
    const FRAME_S: f64 = 5e-3;
    let omega = TAU * frequency_hz;
    let turned = |s: f64| C64::from_polar(1.0, -omega * s);
    let frames = (delay_s / FRAME_S - 1e-9).ceil();
    let open = turned(frames * FRAME_S) * gain_per_s * FRAME_S / (1.0 - turned(FRAME_S));
    let made = C64::new(0.0, omega).inv() * gain_per_s * turned(delay_s);
    20.0 * (1.0 - made / (1.0 + open)).norm().log10()
}

/// Delay of the scene: latency, mirror, and the step in which a command goes out.
fn delay_s(scene: &Scene) -> f64 {
    scene.latency_s + scene.mirror_delay_s + crate::kinds::optics::frames::tests::STEP_S
}

#[test]
fn a_held_integrator_has_the_rejection_of_its_closed_form_between_its_exposures_too() {
    for mirror_delay_s in [0.0, 0.75e-3, 2e-3] {
        let scene = Scene { mirror_delay_s, row_steps: 2, ..Scene::default() };
        let found = scene.conclusion(&keys());
        let exact = |hz: f64| left_db(48.0, delay_s(&scene), hz);
        for axis in ["az", "el"] {
            for m in of(&found, REJECTION, axis) {
                let hz = m.conditions[0].requested;
                let value = value(m);
                let exact = exact(hz);
                assert!((value - exact).abs() < 3.0 * m.u + 0.03, "{axis} {hz} Hz: {value} {exact} {}", m.u);
                assert!(m.u < 0.5 && m.dof.is_none_or(|dof| dof > 4.0), "{hz} Hz: {} {:?}", m.u, m.dof);
            }
            let grid = (1..4000).map(|k| 0.02 * f64::from(k));
            let crosses = grid.clone().find(|hz| exact(*hz) >= 0.0).expect("it crosses");
            let m = of(&found, CROSSING, axis)[0];
            assert!((value(m) - crosses).abs() < 3.0 * m.u + 0.05, "{} {crosses} {}", value(m), m.u);
            let most = grid.map(exact).fold(f64::MIN, f64::max);
            let m = of(&found, AMPLIFICATION, axis)[0];
            assert!((value(m) - most).abs() < 3.0 * m.u + 0.15, "{} {most} {}", value(m), m.u);
        }
    }
}

/// The mirror's own sine shows how late the exposures are stated.
#[test]
fn exposures_that_are_stated_late_or_early_change_nothing() {
    for stamp_s in [-5e-3, 7.5e-3] {
        let scene = Scene { stamp_s, row_steps: 2, ..Scene::default() };
        let found = scene.conclusion(&keys());
        for m in of(&found, REJECTION, "az") {
            let hz = m.conditions[0].requested;
            let value = value(m);
            let exact = left_db(48.0, delay_s(&scene), hz);
            assert!((value - exact).abs() < 3.0 * m.u + 0.03, "{stamp_s} {hz} Hz: {value} {exact} {}", m.u);
            assert!(m.u < 0.5, "{hz} Hz: {}", m.u);
        }
    }
}

#[test]
fn optics_that_are_not_what_the_loop_believes_show_in_what_it_rejects() {
    // The mirror moves the sight a tenth less: the loop has a tenth less gain, whatever it believes.
    let scene = Scene { gains: [3.5355 / 0.9, 2.5 / 0.9], ..Scene::default() };
    let found = scene.conclusion(&keys());
    for m in of(&found, REJECTION, "el") {
        let exact = left_db(0.9 * 48.0, delay_s(&scene), m.conditions[0].requested);
        assert!((value(m) - exact).abs() < 3.0 * m.u + 0.03, "{} {exact} {}", value(m), m.u);
    }
}

#[test]
fn two_records_agree_with_the_closed_loop_alone_unless_the_air_has_changed() {
    let keys = keys();
    let found = Scene::default().conclusion(&keys);
    assert_eq!(found.remarks, [""; 0]);
    assert!(of(&found, WITH_AND_WITHOUT, "az").iter().all(|m| m.value.is_some()));
    let ids: Vec<&str> = found.plots.iter().map(|p| p.id.as_str()).collect();
    assert_eq!(ids, ["tip-tilt-az", "rejection-az", "tip-tilt-el", "rejection-el"]);
    let axes = with_elevation();
    let cases = keys.plan("az", &axes).expect("a plan");
    let calm = Scene { tilt_rad: 0.1e-6, noise_rad: 0.02e-6, ..Scene::default() };
    let scene = |point: &str| if point == OPEN { calm.clone() } else { Scene::default() };
    let points: Vec<PointResult> =
        cases.iter().map(|case| keys.analyse(case, &scene(&case.point).run(case), &axes)).collect();
    let found = keys.conclude(&cases, &points, &axes);
    assert!(found.remarks.iter().any(|r| r.contains("whether the air changed")), "{:?}", found.remarks);
}

#[test]
fn frames_that_are_lost_are_bridged_and_told() {
    let found = Scene { loses_every: 10, ..Scene::default() }.conclusion(&keys());
    let m = of(&found, REJECTION, "az")[0];
    // A tenth of the steps of the integrator is missing.
    let exact = left_db(0.9 * 48.0, delay_s(&Scene::default()), 1.0);
    assert!((value(m) - exact).abs() < 4.0 * m.u + 0.2, "{} {exact}", value(m));
    assert!(m.flags.iter().any(|f| f == "10 % of the frames lost, bridged"), "{:?}", m.flags);
}

#[test]
fn a_wrong_sign_a_wrong_rate_a_saturated_mirror_and_missing_points_give_reasons() {
    let axes = with_elevation();
    let cases = keys().plan("az", &axes).expect("a plan");
    let closed = cases.iter().find(|c| c.point == CLOSED).expect("a closed point");
    let mut log = Scene::default().run(closed);
    let track = log.topics.iter_mut().find(|t| t.topic.name == "/track").expect("it is there");
    track.columns[1].fill(1.0);
    let told = keys().analyse(closed, &log, &axes).inconclusive.expect("a reason");
    assert!(
        told.to_string().contains("at the end of its stroke on el for 100 %")
            && told.to_string().contains("sign"),
        "{told}"
    );
    let slow = Scene { frame_rate_hz: Some(100.0), ..Scene::default() };
    let told = keys().analyse(closed, &slow.run(closed), &axes).inconclusive.expect("a reason");
    assert!(told.to_string().contains("100.0 frames/s, expected 200.0"), "{told}");
    let told = keys()
        .analyse(closed, &Window::completed(Vec::new(), Vec::new()), &axes)
        .inconclusive
        .expect("a reason");
    assert_eq!(told.to_string(), "the segment `record` did not run");
    let nothing = keys().conclude(&[], &[], &axes);
    let reasons: Vec<&str> = nothing.measurements.iter().filter_map(|m| m.inconclusive.as_deref()).collect();
    assert!(nothing.measurements.iter().all(|m| m.value.is_none()), "never a number");
    assert!(reasons[0].contains("was not run"), "{reasons:?}");
}

#[test]
fn the_plan_moves_the_mirror_then_looks_without_and_with_the_fine_loop() {
    let text = "schema = 1\nid = 'P'\ntitle = 't'\nkind = 'atmosphere'\naxis = 'az'\n";
    let procedure = Procedure::parse(SourceFile::new("p.toml", text.to_owned())).expect("defaults");
    let cases = procedure.plan(&with_elevation(), &[]).expect("the rig has the axis");
    let names: Vec<&str> = cases.iter().map(|c| c.point.as_str()).collect();
    assert_eq!(names, ["mirror az", "mirror el", OPEN, CLOSED]);
    let fine: Vec<bool> =
        cases.iter().map(|c| c.segments.iter().any(crate::case::Segment::is_fine)).collect();
    assert_eq!(fine, [false, false, false, true]);
    let wrong = format!("{text}closed = '5 s'\nfrequency = ['0.5 Hz']\n");
    let told = Procedure::parse(SourceFile::new("p.toml", wrong)).expect_err("two mistakes");
    let told = told.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(told.contains("shorter than five segments") && told.contains("three lines below it"), "{told}");
}
