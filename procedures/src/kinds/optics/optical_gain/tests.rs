use super::*;
use crate::diagnostic::SourceFile;
use crate::kinds::optics::frames::tests::Scene;
use crate::kinds::position::positioned::tests::with_elevation;
use crate::measurement::Measurement;
use crate::procedure::Procedure;
use crate::reason::Reason;

fn keys() -> Keys {
    Keys {
        frame_rates_hz: vec![100.0, 200.0],
        amplitudes_rad: vec![300e-6],
        frequency_hz: 2.0,
        duration_s: 5.0,
        gains_ratio: [3.5355, 2.5],
        scale_u_ratio: 0.0,
        pose_rad: [0.0, 0.7],
    }
}

fn all<'a>(conclusion: &'a Conclusion, measurand: &str) -> Vec<&'a Measurement> {
    conclusion.measurements.iter().filter(|m| m.measurand == measurand).collect()
}

fn value(m: &Measurement) -> f64 {
    m.value.unwrap_or_else(|| panic!("{}: {:?}", m.measurand, m.inconclusive))
}

fn reason(keys: &Keys, scene: &Scene) -> String {
    let found = scene.conclusion(keys);
    found.measurements[0].inconclusive.clone().expect("no number")
}

#[test]
fn gains_come_out_at_both_frame_rates_and_a_wrong_size_and_sign_show() {
    let scene = Scene { gains: [3.5355, -2.75], ..Scene::default() };
    let found = scene.conclusion(&keys());
    let gains = all(&found, GAIN);
    let names: Vec<&str> = gains.iter().map(|m| m.axis.as_str()).collect();
    assert_eq!(names, ["az", "az", "el", "el"]);
    for (m, expected) in gains.iter().zip([3.5355, 3.5355, -2.75, -2.75]) {
        assert!((value(m) - expected).abs() < 4.0 * m.u + 2e-4, "{} {} {expected}", value(m), m.u);
        assert!(m.u < 0.01 * expected.abs() && m.dof.is_none_or(|dof| dof >= 4.0), "{} {:?}", m.u, m.dof);
        assert!(m.conditions.iter().all(|c| c.achieved.is_some()), "{:?}", m.conditions);
    }
    for (m, expected) in all(&found, DEPARTURE).iter().zip([0.0, 0.0, -2.1, -2.1]) {
        assert!((value(m) - expected).abs() < 4.0 * m.u + 1e-4, "{} {expected}", value(m));
    }
    for m in all(&found, COUPLING) {
        assert!(value(m) < 5.0 * m.u, "{} {}", value(m), m.u);
    }
    let shown: Vec<&str> = found.plots.iter().map(|p| p.id.as_str()).collect();
    assert_eq!(shown, ["sight-az", "sight-el", "departure"]);
}

#[test]
fn a_sound_sight_is_proven_and_each_fault_of_it_is_one_sentence() {
    let keys = Keys { frame_rates_hz: vec![200.0], ..keys() };
    let proof = |scene: &Scene| scene.conclusion(&keys).proof.expect("it proves the sight");
    let sound = proof(&Scene { gains: [3.9, 2.2], ..Scene::default() });
    assert_eq!((sound.gate.as_str(), sound.faults.len()), ("sight", 0), "{:?}", sound.faults);
    for (gains, expected) in [
        ([3.5355, -2.5], "optical sign of el: the line of sight moves the wrong way, -0.40"),
        ([8.0, 2.5], "optical gain of az: the line of sight moves by +0.12"),
    ] {
        let faults = proof(&Scene { gains, ..Scene::default() }).faults;
        assert!(faults.len() == 1 && faults[0].starts_with(expected), "{faults:?}");
    }
    let dark = Scene { frame_rate_hz: Some(50.0), ..Scene::default() }.conclusion(&keys);
    assert_eq!(dark.proof, None, "what was not seen proves nothing");
    assert!(dark.remarks[0].starts_with("sign of mirror az is not proven: "), "{:?}", dark.remarks);
    let axes = with_elevation();
    let cases = keys.plan("az", &axes).expect("a plan");
    let turned: Vec<PointResult> = cases
        .iter()
        .map(|case| {
            let mut log = Scene::default().run(case);
            let fine = log.topics.iter_mut().find(|t| t.topic.name == "/fine").expect("it is there");
            fine.columns.swap(0, 1);
            keys.analyse(case, &log, &axes)
        })
        .collect();
    let faults = keys.conclude(&cases, &turned, &axes).proof.expect("a proof").faults;
    assert!(faults.len() == 2 && faults[0].starts_with("camera axes: "), "{faults:?}");
    assert_eq!(keys.conclude(&[], &[], &axes).proof, None, "nothing moved it");
}

#[test]
fn stated_uncertainty_is_the_scatter_of_many_trials_in_air_that_is_no_white_noise() {
    let keys = Keys { frame_rates_hz: vec![100.0], amplitudes_rad: vec![100e-6], ..keys() };
    let case = &keys.plan("az", &with_elevation()).expect("a plan")[1];
    let trials = 60;
    let mut square = 0.0;
    let mut stated = 0.0;
    for seed in 0..trials {
        let log = Scene { seed, tilt_rad: 2e-6, ..Scene::default() }.run(case);
        let found = keys.analyse(case, &log, &with_elevation());
        let m = found.measurements.iter().find(|m| m.measurand == GAIN).expect("a gain");
        square += (value(m) - 2.5).powi(2);
        stated += m.u.powi(2);
    }
    // Each of 60 is a χ² with one degree of freedom: ± 18 % (1σ).
    let ratio = square / stated;
    assert!((0.5..1.7).contains(&ratio), "scatter over stated variance: {ratio}");
}

#[test]
fn frames_that_are_lost_cost_little_and_are_told() {
    let found = Scene { loses_every: 3, ..Scene::default() }.conclusion(&keys());
    for (m, expected) in all(&found, GAIN).iter().zip([3.5355, 3.5355, 2.5, 2.5]) {
        assert!((value(m) - expected).abs() < 4.0 * m.u + 2e-4, "{} {} {expected}", value(m), m.u);
        assert!(m.flags.contains(&"33 % of the frames lost".to_owned()), "{:?}", m.flags);
    }
}

#[test]
fn a_wrong_frame_rate_a_still_mirror_and_a_command_that_is_cut_off_give_reasons() {
    let slow = Scene { frame_rate_hz: Some(50.0), ..Scene::default() };
    assert!(reason(&keys(), &slow).contains("50.0 frames/s, expected 100.0"), "{}", reason(&keys(), &slow));
    let still = Scene { gains: [1e9; 2], ..Scene::default() };
    let told = reason(&keys(), &still);
    assert!(told.contains("does not see the mirror move in this axis"), "{told}");
    assert!(told.contains("expected 0.2828 in this one"), "{told}");
    let cut = Scene { commanded_ratio: 0.9, ..Scene::default() };
    let told = reason(&keys(), &cut);
    assert!(told.contains("cut off: 270.0 urad of 300.0 urad were sent"), "{told}");
    let case = &keys().plan("az", &with_elevation()).expect("a plan")[0];
    let empty = keys().analyse(case, &Window::completed(Vec::new(), Vec::new()), &with_elevation());
    assert_eq!(
        empty.inconclusive.as_ref().map(Reason::to_string).as_deref(),
        Some("the segment `sine` did not run")
    );
}

fn parse(text: &str) -> Result<Procedure, String> {
    let text = format!("schema = 1\nid = 'P'\ntitle = 't'\nkind = 'optical-gain'\naxis = 'az'\n{text}");
    Procedure::parse(SourceFile::new("p.toml", text))
        .map_err(|all| all.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

#[test]
fn the_plan_moves_each_axis_of_the_mirror_at_each_rate_and_amplitude_before_a_star() {
    let cases = parse("").expect("defaults").plan(&with_elevation(), &[]).expect("the rig has the axis");
    let names: Vec<&str> = cases.iter().map(|c| c.point.as_str()).collect();
    assert_eq!(names.len(), 8);
    assert_eq!(names[..3], ["az 100 Hz 100 urad", "az 100 Hz 500 urad", "az 200 Hz 100 urad"]);
    assert!(cases.iter().all(|c| c.target.is_some() && c.fine_frame_rate_hz.is_some()));
    assert!(parse("").expect("defaults").plan(&crate::axis::Axes::default(), &[]).is_err());
}

#[test]
fn wrong_keys_are_pointed_at_together() {
    let wrong = parse("frame-rate = ['8 Hz']\namplitude = ['0 urad']\nduration = '2 s'\ngain-el = '0'\n")
        .expect_err("four mistakes");
    for part in ["five frames", "`amplitude` needs values", "shorter than five blocks", "must not be zero"] {
        assert!(wrong.contains(part), "{part}: {wrong}");
    }
}
