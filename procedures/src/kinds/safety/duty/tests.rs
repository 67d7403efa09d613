//! Currents, temperatures and a DC link with known truth.

use super::*;
use crate::log::PointStatus;
use crate::measurement::Measurement;
use crate::stimulus::Stimulus;
use crate::synthetic::{self, azimuth_and_elevation as axes, rows};

const DEG: f64 = std::f64::consts::PI / 180.0;
/// Slew, track, slew, track.
const DURATIONS_S: [f64; 4] = [4.0, 6.0, 4.0, 6.0];

fn keys() -> Keys {
    Keys {
        slew_rad: [Some([-90.0 * DEG, 90.0 * DEG]), Some([-5.0 * DEG, 85.0 * DEG])],
        rate_rad_per_s: 60.0 * DEG,
        acceleration_rad_per_s2: 80.0 * DEG,
        track_s: 6.0,
        track_rad_per_s: Some(0.674 * DEG),
        cycles: 6,
        continuous_a: [14.2, 16.8],
        longest_s: 1800.0,
        current_u_ratio: 0.005,
        voltage_u_v: 1.0,
        temperature_u_degc: 1.0,
    }
}

/// Cycles with `slew_a` in the first second of each slew and `track_a` else; a heat sink with 60 s and 0.2 K/A².
fn window(cycles: u32, slew_a: f64, track_a: f64) -> Window {
    let mut segments = Vec::new();
    let mut at_s = 5.0;
    for segment in 0..4 * cycles as usize {
        let start_s = at_s;
        let end_s = at_s + DURATIONS_S[segment % 4];
        segments.push(synthetic::span(segment, start_s, end_s));
        at_s = end_s;
    }
    let count = (f64::from(cycles) * 20.0 * 100.0) as u32;
    let mut time = Vec::new();
    let mut current = Vec::new();
    let mut sink = Vec::new();
    let mut degc = 40.0;
    let mut volts = Vec::new();
    let mut supply = Vec::new();
    let mut shunt = Vec::new();
    for k in 0..count {
        let t_s = f64::from(k) * 0.01;
        let slews = t_s % 10.0 < 1.0;
        let ampere: f64 = if slews { slew_a } else { track_a };
        degc += (40.0 + 0.2 * ampere * ampere - degc) * 0.01 / 60.0;
        time.push(5.0 + t_s);
        current.push(if t_s % 20.0 < 10.0 { ampere } else { -ampere });
        sink.push((degc * 10.0).round() / 10.0);
        volts.push(if slews { 610.0 } else { 552.0 });
        supply.push(if slews { 40.0 } else { 5.0 });
        shunt.push(if slews { 10.0 } else { 0.0 });
    }
    let axis = |name| {
        let columns = vec![
            ("current_a", current.clone()),
            ("bus_v", volts.clone()),
            ("heat_sink_degc", sink.clone()),
            ("position_rad", time.iter().map(|t_s| 0.3 * t_s.sin()).collect()),
        ];
        rows(name, &time, columns)
    };
    let clamps = rows("/supply", &time, vec![("supply_a", supply), ("shunt_a", shunt)]);
    Window::completed(vec![axis("/az"), axis("/el"), clamps], segments)
}

fn found<'a>(all: &'a [Measurement], name: &str) -> &'a Measurement {
    all.iter().find(|m| m.measurand == name).unwrap_or_else(|| panic!("no {name}"))
}

fn near(all: &[Measurement], name: &str, expected: f64, within: f64) {
    let m = found(all, name);
    let value = m.value.unwrap_or_else(|| panic!("{name}: {:?}", m.inconclusive));
    assert!((value - expected).abs() < within, "{name}: {value}, expected {expected} within {within}");
}

fn analysed(window: &Window) -> Vec<Measurement> {
    let case = keys().plan("az", &axes()).expect("a plan").remove(0);
    keys().analyse(&case, window, &axes()).measurements
}

#[test]
fn both_axes_start_at_once_and_in_the_second_point_stop_at_once() {
    let cases = keys().plan("az", &axes()).expect("a plan");
    let names: Vec<&str> = cases.iter().map(|c| c.point.as_str()).collect();
    assert_eq!(names, ["both", "both together"]);
    let duration = |case: &Case, segment: usize| {
        let s = &case.segments[segment];
        let along = s.companion.as_ref().expect("elevation moves along");
        let from = |axis: &str| case.start_pose_rad[axis];
        [s.stimulus.duration_s(from("az")), along.stimulus.duration_s(from("el"))].map(|d| d.expect("an end"))
    };
    let [az_s, el_s] = duration(&cases[0], 0);
    assert!(az_s > el_s + 1.0, "180 deg take longer than 90");
    let [az_s, el_s] = duration(&cases[1], 0);
    assert!((az_s - el_s).abs() < 1e-9, "{az_s} s and {el_s} s");
    assert_eq!(cases[0].moved_axes(), ["az", "el"]);
    let Stimulus::Reversals { to_rad, from_rad, .. } = &cases[0].segments[1].stimulus else {
        panic!("tracking goes out and back")
    };
    assert!(
        to_rad > from_rad
            && (cases[0].segments[1].stimulus.duration_s(*from_rad).expect("an end") - 6.0).abs() < 0.01
    );
}

#[test]
fn one_axis_alone_has_no_companion_and_an_axis_without_span_is_refused() {
    let alone = Keys { slew_rad: [None, Some([-5.0 * DEG, 85.0 * DEG])], ..keys() };
    let cases = alone.plan("el", &axes()).expect("a plan");
    assert!(cases.len() == 1 && cases[0].segments.iter().all(|s| s.companion.is_none()));
    let yields = alone.yields().expect("fewer than all of its kind");
    assert!(yields.contains(&"rms-current-el") && !yields.contains(&"rms-current-az"));
    let refused = alone.plan("az", &axes()).expect_err("azimuth has no span");
    assert!(refused[0].message.contains("does not give the slew of axis `az`"), "{refused:?}");
    let hasty = Keys { track_s: 0.05, ..keys() };
    assert!(hasty.plan("az", &axes()).is_err(), "no time to go out and back");
}

/// A requirement that means both axes at once must not take one that stood still for moving.
#[test]
fn axes_that_move_are_counted_by_their_encoders() {
    let moving = |window: &Window| {
        let all = analysed(window);
        assert!(all.iter().all(|m| m.conditions == all[0].conditions), "{all:?}");
        let condition = &all[0].conditions[0];
        assert_eq!((condition.name.as_str(), condition.requested), ("moving-axes", 2.0));
        condition.achieved
    };
    let mut both = window(4, 30.0, 5.0);
    assert_eq!(moving(&both), Some(2.0));
    // Plans in older recordings ask for nothing.
    let mut old = keys().plan("az", &axes()).expect("a plan").remove(0);
    old.requested.clear();
    let all = keys().analyse(&old, &both, &axes()).measurements;
    assert!(all.iter().all(|m| m.conditions.len() == 1 && m.conditions[0].achieved == Some(2.0)), "{all:?}");
    both.topics[1].columns[3].fill(1.2);
    assert_eq!(moving(&both), Some(1.0));
    both.topics[1].columns[3][7] = f64::NAN;
    assert_eq!(moving(&both), None, "nothing tells");
}

#[test]
fn currents_bus_and_supply_are_what_went_in() {
    let all = analysed(&window(6, 30.0, 5.0));
    // 1 s of 10 at 30 A, the rest at 5 A.
    near(&all, "rms-current-az", (0.1_f64 * 900.0 + 0.9 * 25.0).sqrt(), 0.01);
    near(&all, "peak-current-el", 30.0, 1e-9);
    near(&all, "time-above-continuous", 0.99, 0.02);
    near(&all, "bus-voltage-low", 552.0, 1e-9);
    near(&all, "bus-voltage-high", 610.0, 1e-9);
    near(&all, "supply-current-rms", (0.1_f64 * 1600.0 + 0.9 * 25.0).sqrt(), 0.05);
    near(&all, "shunt-power", 6100.0, 20.0);
    assert!(all.iter().all(|m| m.flags.is_empty()), "{all:?}");
}

#[test]
fn the_heat_sink_ends_where_its_losses_take_it_with_its_ripple_on_top() {
    let all = analysed(&window(12, 30.0, 5.0));
    let mean_degc = 40.0 + 0.2 * (0.1 * 900.0 + 0.9 * 25.0);
    let end = found(&all, "heat-sink-end");
    let value = end.value.expect("an end");
    // A second at 30 A takes it 180·1/60 = 3 K up, half of that is above the mean.
    assert!(value > mean_degc && value < mean_degc + 3.0, "{value}, mean {mean_degc}");
    near(&all, "heat-sink-time", 60.0, 5.0);
}

#[test]
fn what_was_cut_short_tells_how_far_it_came_and_nothing_of_whole_cycles() {
    let mut cut = window(2, 60.0, 5.0);
    cut.status = PointStatus::Aborted;
    cut.trips = vec!["temperature: az: temperature 83.1 degC, limit 83.0 degC".to_owned()];
    let all = analysed(&cut);
    near(&all, "peak-current-az", 60.0, 1e-9);
    near(&all, "bus-voltage-high", 610.0, 1e-9);
    let hottest = found(&all, "heat-sink-end");
    assert!(hottest.value.is_some_and(|v| v > 60.0) && !hottest.flags.is_empty(), "{hottest:?}");
    for name in ["rms-current-az", "supply-current-rms", "heat-sink-time"] {
        let reason = found(&all, name).inconclusive.clone().unwrap_or_default();
        assert!(reason.contains("did not complete (temperature"), "{name}: {reason}");
    }
}

#[test]
fn a_rig_without_clamps_says_so_and_three_cycles_are_too_few_for_the_heat_sink() {
    let mut bare = window(3, 30.0, 5.0);
    bare.topics.pop();
    let all = analysed(&bare);
    for name in ["supply-current-rms", "supply-current-peak", "shunt-power"] {
        let reason = found(&all, name).inconclusive.clone().unwrap_or_default();
        assert!(reason.contains("no current clamps"), "{name}: {reason}");
    }
    let reason = found(&all, "heat-sink-end").inconclusive.clone().unwrap_or_default();
    assert!(reason.contains("3 whole cycles, but 4 are needed"), "{reason}");
    near(&all, "peak-current-az", 30.0, 1e-9);
}

#[test]
fn a_value_that_is_no_number_makes_what_rests_on_it_inconclusive() {
    let mut broken = window(5, 30.0, 5.0);
    broken.topics[0].columns[0][100] = f64::NAN;
    let all = analysed(&broken);
    for name in ["rms-current-az", "peak-current-az", "time-above-continuous"] {
        assert!(found(&all, name).value.is_none(), "{name}");
    }
    near(&all, "rms-current-el", (0.1_f64 * 900.0 + 0.9 * 25.0).sqrt(), 0.01);
}

#[test]
fn the_picture_of_a_current_has_its_root_mean_square_of_every_cycle_below() {
    let case = keys().plan("az", &axes()).expect("a plan").remove(0);
    let result = keys().analyse(&case, &window(6, 30.0, 4.0), &axes());
    let head = result.plots.iter().find(|p| p.id == "both-current-az").expect("the current");
    assert!(head.limits_of_magnitude && head.limits_of.as_deref() == Some("peak-current-az"));
    let panel =
        result.plots.iter().find(|p| p.panel_of.as_deref() == Some("both-current-az")).expect("a panel");
    assert_eq!(panel.limits_of.as_deref(), Some("rms-current-az"));
    let rms = (0.1_f64 * 30.0 * 30.0 + 0.9 * 4.0 * 4.0).sqrt();
    assert_eq!(panel.series[0].y.len(), 12, "two ends of six cycles");
    assert!(panel.series[0].y.iter().all(|y| (y - rms).abs() < 0.01), "{:?} of {rms}", panel.series[0].y);
}
