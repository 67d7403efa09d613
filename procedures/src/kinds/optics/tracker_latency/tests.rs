use super::*;
use crate::diagnostic::SourceFile;
use crate::kinds::optics::frames::tests::{DECLARED_U_S, STEP_S, Scene};
use crate::kinds::position::positioned::tests::with_elevation;
use crate::measurement::Measurement;
use crate::procedure::Procedure;
use crate::reason::Reason;
use crate::synthetic::rows;

fn keys() -> Keys {
    Keys {
        is_fine: true,
        frequencies_hz: vec![2.0, 5.0, 11.0, 17.0, 23.0, 31.0],
        period_s: 1.0,
        periods: 8,
        amplitude_rad: 40e-6,
        rate_rad_per_s: 4e-3,
        frame_rate_hz: Some(200.0),
        moved_delay_s: 0.0,
        moved_delay_u_s: 0.0,
        pose_rad: [0.0, 0.7],
    }
}

fn measured(keys: &Keys, scene: &Scene) -> PointResult {
    let case = &keys.plan("az", &with_elevation()).expect("the axis is there")[0];
    keys.analyse(case, &scene.run(case), &with_elevation())
}

fn of<'a>(point: &'a PointResult, measurand: &str) -> &'a Measurement {
    point.measurements.iter().find(|m| m.measurand == measurand).expect("it is yielded")
}

fn near(m: &Measurement, expected_s: f64, within_s: f64) {
    let found = m.value.unwrap_or_else(|| panic!("{}: {:?}", m.measurand, m.inconclusive));
    assert!(
        (found - expected_s).abs() < 3.0 * m.u + within_s,
        "{}: {found} {expected_s} {}",
        m.measurand,
        m.u
    );
    assert!(m.u < 0.3e-3, "{}", m.u);
}

/// Every tick is logged.
fn every_tick() -> Scene {
    Scene { row_steps: 1, ..Scene::default() }
}

#[test]
fn a_message_is_as_late_as_it_is_and_its_stamp_is_right() {
    for latency_s in [7.5e-3, 15e-3] {
        let point = measured(&keys(), &Scene { latency_s, ..every_tick() });
        // Seen in the very tick of its arrival: half a tick is taken off for one that may come at any time.
        near(of(&point, LATENCY), latency_s - 0.5 * STEP_S, 20e-6);
        near(of(&point, STAMP), 0.0, 20e-6);
        near(of(&point, JITTER), 0.0, 1e-9);
        assert_eq!(point.plots[0].id, "phase");
    }
}

#[test]
fn a_tracker_that_states_its_exposures_late_is_told_and_its_latency_is_not_changed_by_what_it_says() {
    let point = measured(&keys(), &Scene { stamp_s: 2e-3, ..every_tick() });
    near(of(&point, STAMP), 2e-3, 20e-6);
    near(of(&point, LATENCY), 7.5e-3 - 0.5 * STEP_S, 20e-6);
}

#[test]
fn a_declared_delay_that_is_off_is_flagged_and_one_within_its_uncertainty_is_not() {
    let asks = |stamp_s: f64| {
        let point = measured(&keys(), &Scene { stamp_s, ..every_tick() });
        of(&point, STAMP).flags.iter().any(|flag| flag.contains("correct `message-delay` in the rig file"))
    };
    assert!(asks(2e-3) && asks(-2e-3));
    assert!(!asks(0.0) && !asks(DECLARED_U_S));
}

#[test]
fn readings_that_go_with_the_motion_are_a_fault_of_the_sight() {
    let faults = |scene: &Scene| {
        let point = measured(&keys(), scene);
        keys().conclude(&[], &[point], &with_elevation()).proof.map(|proof| proof.faults)
    };
    assert_eq!(faults(&every_tick()), Some(Vec::new()));
    let turned = faults(&Scene { gains: [-3.5355, 2.5], ..every_tick() }).expect("it was seen");
    assert!(
        turned[0].starts_with("sign of the fine tracker: its readings have the same sign as the motion"),
        "{turned:?}"
    );
    assert_eq!(faults(&Scene { gains: [1e9; 2], ..every_tick() }), None, "what was not seen proves nothing");
}

#[test]
fn what_the_angle_is_late_by_itself_is_put_on_top() {
    let known = Keys { moved_delay_s: 1.5e-3, moved_delay_u_s: 0.1e-3, ..keys() };
    let without = measured(&keys(), &every_tick());
    let with = measured(&known, &every_tick());
    let difference = |name: &str| of(&with, name).value.zip(of(&without, name).value).map(|(a, b)| a - b);
    assert!(difference(LATENCY).is_some_and(|d| (d - 1.5e-3).abs() < 1e-12), "{:?}", difference(LATENCY));
    assert!(of(&with, LATENCY).u > of(&without, LATENCY).u);
}

#[test]
fn a_tracker_that_sees_nothing_move_and_a_log_without_it_give_reasons() {
    let still = measured(&keys(), &Scene { gains: [1e9; 2], ..every_tick() });
    let told = still.inconclusive.expect("a reason");
    assert!(told.to_string().contains("sines are above their scatter"), "{told}");
    assert!(still.measurements.iter().all(|m| m.value.is_none()));
    let case = &keys().plan("az", &with_elevation()).expect("a plan")[0];
    let mut log = every_tick().run(case);
    log.topics.retain(|t| t.topic.name != "/fine");
    let told = keys().analyse(case, &log, &with_elevation()).inconclusive.expect("a reason");
    assert!(told.to_string().contains("no topic /fine"), "{told}");
    log.topics = vec![rows("/fine", &[0.0], vec![("counter", vec![0.0])])];
    assert!(keys().analyse(case, &log, &with_elevation()).inconclusive.is_some());
    let empty = keys().analyse(case, &Window::completed(Vec::new(), Vec::new()), &with_elevation());
    assert_eq!(
        empty.inconclusive.as_ref().map(Reason::to_string).as_deref(),
        Some("the segment `sines` did not run")
    );
}

fn parse(text: &str) -> Result<Procedure, String> {
    let text = format!("schema = 1\nid = 'P'\ntitle = 't'\nkind = 'tracker-latency'\naxis = 'az'\n{text}");
    Procedure::parse(SourceFile::new("p.toml", text))
        .map_err(|all| all.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

#[test]
fn the_fine_tracker_gets_sines_of_the_mirror_and_the_coarse_one_of_the_axis() {
    let plan =
        |text: &str| parse(text).expect("right").plan(&with_elevation(), &[]).expect("the rig has the axis");
    let fine = &plan("frame-rate = '200 Hz'\n")[0];
    assert_eq!(fine.excitations[0].into, crate::excitation::Injection::MirrorAz);
    assert_eq!(fine.fine_frame_rate_hz, Some(200.0));
    let coarse = &plan("tracker = 'coarse'\n")[0];
    assert_eq!(coarse.excitations[0].into, crate::excitation::Injection::Velocity);
    assert_eq!(coarse.fine_frame_rate_hz, None);
}

#[test]
fn wrong_keys_are_pointed_at_together() {
    let wrong =
        parse("frequency = ['2.5 Hz', '2 Hz']\nperiods = 3\nrate = '0 rad/s'\n").expect_err("mistakes");
    for part in ["multiple of 1/period", "at least five", "periods", "rate"] {
        assert!(wrong.contains(part), "{part}: {wrong}");
    }
}
