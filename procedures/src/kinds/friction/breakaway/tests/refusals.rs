use super::*;

fn messages(keys: &Keys, change: impl Fn(&mut crate::axis::AxisLimits)) -> String {
    let mut axes = axes(&ELEVATION, 52.0);
    change(axes.get_mut("el").expect("the axis of the tests"));
    let refused = keys.plan("el", &axes).expect_err("the axis cannot do this");
    refused.iter().map(|d| format!("{}\n", d.message)).collect()
}

#[test]
fn everything_the_axis_cannot_do_comes_at_once_with_asked_and_allowed() {
    let mut keys = keys(89.0, 0.6);
    keys.ramps = ramps(&[1.0, 20.0], &[1.0], 1);
    keys.multisine =
        Some(MultisineKeys { level_ratio: 0.3, from_hz: 0.1, to_hz: 10.0, lines: 14, periods: 5 });
    keys.approach_rad_per_s = 100.0 * DEGREE;
    keys.hold = Some(hold_at(-9.0));
    insta::assert_snapshot!(messages(&keys, |axis| axis.torque_quantum_nm = 0.5), @r#"
    the torque quantum of axis `el` is 0.5 N*m, at most 0.14375 N*m is allowed: static friction (43.125 N*m expected) over 300
    the multisine on axis `el` peaks at 30 % of static friction (12.9375 N*m), at most 10 % (4.3125 N*m) is allowed
    `pose` 89 deg reaches 88.25 deg … 89.6 deg on axis `el`, the soft limits are -9.5 deg … 89.5 deg
    the stroke of [map] reaches 82.3333 deg … 95.6667 deg on axis `el`, the soft limits are -9.5 deg … 89.5 deg
    `pose` -9 deg of [hold] reaches -9.75 deg … -8.4 deg on axis `el`, the soft limits are -9.5 deg … 89.5 deg
    `approach-velocity` is 100 deg/s, axis `el` allows 60 deg/s
    a ramp of 20 A/s on axis `el` reaches static friction within 0.0414663 s, at most 4.14663 A/s is allowed
    "#);
}

#[test]
fn an_axis_without_torque_constant_and_a_stroke_too_short_are_refused() {
    let mut keys = keys(60.0, 6.0);
    keys.ramps = ramps(&[1.0], &[1.0], 1);
    keys.holding_torque_nm = 50.0;
    insta::assert_snapshot!(messages(&keys, |axis| axis.torque_constant_nm_per_a = None), @r#"
    the stroke of [map] on axis `el` is 13.3333 deg long, but at least 15.3333 deg is needed: twice `displacement` plus a cogging period
    axis `el` has no torque constant: a current rate gives no torque ramp
    "#);
}

#[test]
fn points_chain_and_repeats_are_counted_over_blocks() {
    let mut keys = keys(60.0, 0.6);
    keys.ramps = [ramps(&[1.0], &[1.0], 1), ramps(&[1.0], &[1.0, 3.0], 2)].concat();
    keys.multisine =
        Some(MultisineKeys { level_ratio: 0.1, from_hz: 0.2, to_hz: 10.0, lines: 14, periods: 5 });
    keys.hold = Some(hold_at(20.0));
    let cases = keys.plan("el", &axes(&ELEVATION, 52.0)).expect("allowed");
    let lines: Vec<String> = cases
        .iter()
        .map(|c| {
            let labels: Vec<&str> = c.segments.iter().map(|s| s.label.as_str()).collect();
            format!("{} from {:.2} deg: {}", c.point, c.start_pose_rad["el"] / DEGREE, labels.join(" "))
        })
        .collect();
    insta::assert_snapshot!(lines.join("\n"), @r#"
    map from 53.33 deg: stroke
    ramp +1 A/s dwell 1 s #1 from 53.33 deg: transfer approach settle dwell+ ramp+ arrest return
    ramp -1 A/s dwell 1 s #1 from 59.25 deg: approach settle dwell- ramp- arrest return
    ramp +1 A/s dwell 1 s #2 from 59.25 deg: approach settle dwell+ ramp+ arrest return
    ramp -1 A/s dwell 1 s #2 from 59.25 deg: approach settle dwell- ramp- arrest return
    ramp +1 A/s dwell 1 s #3 from 59.25 deg: approach settle dwell+ ramp+ arrest return
    ramp -1 A/s dwell 1 s #3 from 59.25 deg: approach settle dwell- ramp- arrest return
    ramp +1 A/s dwell 3 s #1 from 59.25 deg: approach settle dwell+ ramp+ arrest return
    ramp -1 A/s dwell 3 s #1 from 59.25 deg: approach settle dwell- ramp- arrest return
    ramp +1 A/s dwell 3 s #2 from 59.25 deg: approach settle dwell+ ramp+ arrest return
    ramp -1 A/s dwell 3 s #2 from 59.25 deg: approach settle dwell- ramp- arrest return
    multisine from 59.25 deg: approach settle dwell multisine arrest return
    hold 18.8889 deg from 59.25 deg: transfer approach settle release arrest return approach settle dwell+ ramp+ arrest return approach settle dwell- ramp- arrest return
    hold 20 deg from 18.14 deg: transfer approach settle release arrest return approach settle dwell+ ramp+ arrest return approach settle dwell- ramp- arrest return
    hold 21.1111 deg from 19.25 deg: transfer approach settle release arrest return approach settle dwell+ ramp+ arrest return approach settle dwell- ramp- arrest return
    "#);
}

#[test]
fn the_multisine_never_passes_its_level() {
    let mut keys = keys(60.0, 0.6);
    keys.multisine =
        Some(MultisineKeys { level_ratio: 0.1, from_hz: 0.1, to_hz: 10.0, lines: 14, periods: 5 });
    let cases = keys.plan("el", &axes(&ELEVATION, 52.0)).expect("allowed");
    let sine = cases[1].segments.iter().find(|s| s.label == "multisine").expect("planned");
    let stimulus = sine.stimulus.prepare(0.0);
    let most = (0..50_000).map(|k| stimulus.at(f64::from(k) * 1e-3).torque_nm.abs()).fold(0.0, f64::max);
    let allowed = 0.1 * ELEVATION.static_friction;
    assert!(most <= allowed * 1.0005 && most > 0.95 * allowed, "{most} of {allowed}");
}

#[test]
fn envelope_of_a_ramp_reaches_from_the_approach_to_the_displacement_and_no_further() {
    let mut keys = keys(60.0, 0.6);
    keys.ramps = ramps(&[1.0], &[1.0], 1);
    keys.hold = Some(hold_at(20.0));
    let cases = keys.plan("el", &axes(&ELEVATION, 52.0)).expect("allowed");
    let ramp = cases[2].envelope().position_rad.map(|p| p / DEGREE);
    // The dwell may creep by one displacement before the ramp moves by another.
    assert!(ramp[0] > 58.7 && ramp[1] < 61.3, "{ramp:?}");
    let hold = cases.last().expect("hold").envelope().position_rad.map(|p| p / DEGREE);
    assert!(hold[0] > 18.7, "{hold:?}");
}
