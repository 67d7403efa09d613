//! Points with a task for an instrument, from the plan to the topics of the log.

use procedures::device::Task;
use procedures::excitation::{Excitation, Injection, Signal};

use super::*;

fn with_task(task: Task, at_most_s: f64) -> Segment {
    Segment { task: Some(task), label: "measure".to_owned(), ..Segment::hold("", Mode::Position, at_most_s) }
}

fn impedance(axis: &str, points: u32) -> Task {
    Task::Impedance { axis: axis.to_owned(), level_v_ptp: 1.0, from_hz: 20.0, to_hz: 2000.0, points }
}

fn capture() -> Task {
    Task::Capture { axis: "az".to_owned(), sample_rate_hz: 100e3, duration_s: 0.02 }
}

/// 0, then a torque of 300 N·m after 1 s, for 50 ms and no longer: a segment ends before that.
fn step() -> Excitation {
    let signal = Signal::Square { amplitude: 300.0, period_s: 2.0 };
    Excitation { into: Injection::Torque, signal, fade_s: 0.0, every_ticks: 1 }
}

#[test]
fn an_impedance_sweep_ends_its_segment_and_stands_in_the_log() {
    let wanted = case(vec![with_task(impedance("el", 21), 60.0)]);
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    assert_eq!((outcome.status, &outcome.error), (PointStatus::Completed, &None));
    assert_eq!(window.segments[0].ended_by, EndedBy::Condition);
    let [hz, resistance, reactance, point] =
        ["frequency_hz", "resistance_ohm", "reactance_ohm", "point"].map(|c| column(&window, "/analyser", c));
    assert_eq!(point, (0..21).map(f64::from).collect::<Vec<_>>());
    assert!((hz[0] - 20.0).abs() < 1e-6 && (hz[20] - 2000.0).abs() < 1e-4);
    // 30.2 µF at 20 Hz, within its noise of 0.1 % and what the dielectric does.
    let farad = -1.0 / (std::f64::consts::TAU * hz[0] * reactance[0]);
    assert!((farad / 30.2e-6 - 1.0).abs() < 0.02, "{farad:e} F");
    assert!(resistance.iter().all(|ohm| *ohm > 0.0));
}

#[test]
fn a_capture_begins_with_the_excitation_and_shows_the_current_rise() {
    let mut wanted =
        case(vec![Segment { excited: Some(0), mode: Mode::Torque, ..with_task(capture(), 5.0) }]);
    wanted.excitations = vec![step()];
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    assert_eq!((outcome.status, &outcome.error), (PointStatus::Completed, &None));
    assert_eq!(window.segments[0].ended_by, EndedBy::Condition);
    let [time, current, sync] = ["time_s", "current_a", "sync_v"].map(|c| column(&window, "/scope", c));
    assert!(time.len() > 2000 && time[1] - time[0] <= 10e-6, "{} rows", time.len());
    let edge = sync.iter().position(|volts| *volts > 2.5).expect("an edge");
    assert!(time[edge].abs() < 11e-6, "the edge is time 0: {}", time[edge]);
    // 300 N·m are 5 A; the command waits for the next exchange (0.25 ms), the drive's delay and the lag of its loop.
    let rise = time.iter().zip(current).find(|(_, a)| **a > 2.5).map(|(t, _)| *t).expect("the current rises");
    let unit = UnitSettings::default();
    let expected_s = 250e-6
        + unit.az.command_delay_s
        + 2.0_f64.ln() / (std::f64::consts::TAU * unit.az.current_bandwidth_hz);
    assert!((rise - expected_s).abs() < 60e-6, "half of it after {rise} s, expected {expected_s} s");
    let last = current[current.len() - 100..].iter().sum::<f64>() / 100.0;
    assert!((last - 5.05 - 0.02).abs() < 0.1, "{last} A through a probe that is 1 % off");
}

#[test]
fn an_excitation_that_never_changes_is_an_error_that_says_so() {
    let wanted = case(vec![with_task(capture(), 1.0)]);
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    assert_eq!((outcome.status, outcome.safe.standstill), (PointStatus::Errored, true));
    let error = outcome.error.expect("a reason").to_string();
    let expected =
        "scope: measurement: expected a whole one, found no trigger (the excitation did not change";
    assert!(error.contains(expected), "{error}");
    assert!(window.rows("/scope").is_none_or(|rows| rows.time_s.is_empty()));
}

#[test]
fn a_sweep_that_its_instrument_refuses_ends_the_point_before_anything_moves() {
    let Task::Impedance { axis, level_v_ptp, to_hz, points, .. } = impedance("az", 5) else { unreachable!() };
    let low = Task::Impedance { axis, level_v_ptp, from_hz: 10.0, to_hz, points };
    let (outcome, window) = run_case(&case(vec![with_task(low, 5.0)]), &UnitSettings::default(), &[], 0);
    assert_eq!((outcome.status, outcome.safe.standstill), (PointStatus::Errored, true), "{outcome:?}");
    assert!(outcome.error.is_some_and(|e| e.to_string().contains("E4990A goes from 20 Hz")));
    assert!(window.segments.is_empty());
}

#[test]
fn a_trip_in_the_middle_of_a_sweep_ends_in_order() {
    let push = Stimulus::Hold { torque_nm: 1500.0 };
    let wanted =
        case(vec![Segment { mode: Mode::Torque, stimulus: push, ..with_task(impedance("az", 201), 60.0) }]);
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    assert!(outcome.trip.is_some() && outcome.safe.standstill, "{outcome:?}");
    assert_eq!((outcome.status, outcome.error), (PointStatus::Aborted, None));
    assert_eq!(window.segments[0].ended_by, EndedBy::Stopped);
}

#[test]
fn the_autocollimator_follows_the_mirror_and_the_echo_comes_back_one_tick_late() {
    let signal = Signal::Square { amplitude: 300e-6, period_s: 0.2 };
    let tilt = Excitation { into: Injection::MirrorAz, signal, fade_s: 0.0, every_ticks: 1 };
    let mut wanted = case(vec![Segment { excited: Some(0), ..Segment::hold("tilt", Mode::Position, 0.5) }]);
    wanted.excitations = vec![tilt];
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    let [gauge, seen] = ["angle_az_rad", "reference_az_rad"].map(|c| column(&window, "/fsm", c));
    let highest = seen.iter().fold(0.0_f64, |most, rad| most.max(*rad));
    assert!((200e-6..600e-6).contains(&highest), "{highest} rad");
    let worst = gauge.iter().zip(seen).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 60e-6, "{worst} rad between gauge and autocollimator");
    let still =
        column(&window, "/fsm", "reference_el_rad").iter().fold(0.0_f64, |most, rad| most.max(rad.abs()));
    assert!(still < 0.1 * highest, "elevation saw {still} rad");
    let [out, back] = ["echo_out_v", "echo_in_v"].map(|c| column(&window, "/fsm", c));
    // Bit n of x¹⁰ + x⁷ + 1 goes out in tick n + 1; a row is written every eighth tick.
    let mut bits = vec![false; 9];
    bits.insert(0, true);
    for n in 0..1000 {
        bits.push(bits[n] ^ bits[n + 3]);
    }
    let volts = |tick: usize| if bits[9 + tick] { 1.0 } else { -1.0 };
    for row in 0..100 {
        let tick = 8 * (row + 1);
        assert_eq!([out[row], back[row]], [volts(tick), volts(tick - 1)], "tick {tick}");
    }
}
