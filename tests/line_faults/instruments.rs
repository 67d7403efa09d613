//! Analyser and oscilloscope: a query that is not answered within 2 s (5 s are allowed), an answer that is none, and a connection
//! that the instrument resets end the point with an error. The axes are left at standstill.

use std::time::Duration;

use bench::rig::wires::Wires;
use drivers::wire::fault::Occurrence;
use reports::record::Status;
use sim_devices::rig::SimulatedRig;

use super::bed::{FaultyWires, Ran, ran};
use super::troubles::{Trouble, troubled};

const IMPEDANCE: &str = include_str!("../../procedures/quick/fsm-impedance.toml");
const LATENCY: &str = include_str!("../../procedures/quick/az-latency.toml");
/// Opening is over, no measurement has begun.
const FROM: Duration = Duration::from_millis(500);
/// Longest wait for the answer to a query, s.
const QUERY_S: f64 = 5.0;
const FOREVER: Duration = Duration::from_secs(1000);
const RESET: Trouble = Trouble::Gone {
    address: "tcp:192.168.1.20:5025",
    found: "one that the device reset (Connection reset by peer (os error 104))",
    help: "check whether the device was started again; then start again",
};

fn swept(wires: FaultyWires) -> Ran {
    let text = IMPEDANCE.replace("points = 121", "points = 60\nmirror-axis = [\"az\"]");
    ran("FSM-IMPEDANCE", &text, wires)
}

fn captured(wires: FaultyWires) -> Ran {
    let text = LATENCY.replace("[\"fit\", \"onset\"]", "[\"probe\"]\ncaptures = 2");
    ran("AZ-LATENCY", &text, wires)
}

fn analyser(rig: &SimulatedRig, trouble: Trouble) -> Wires {
    troubled(rig, "sim:analyser", FROM, trouble)
}

fn scope(rig: &SimulatedRig, trouble: Trouble) -> Wires {
    troubled(rig, "sim:scope", FROM, trouble)
}

fn ends_with(ran: &Ran, start: &str, end: &str) -> f64 {
    assert_eq!((ran.exit_code, ran.run.status), (4, Status::Errored), "{}", ran.reason());
    let (told_s, told) = ran.notice(start);
    assert!(told.ends_with(end), "{told}");
    assert!(ran.reason().contains(told), "{} does not say {told}", ran.reason());
    told_s
}

/// A query was waited for, and not longer than is allowed: 5 s after its answer was planned.
fn is_overdue(ran: &Ran, told_s: f64, planned_s: f64) {
    let waited_s = told_s - ran.windows[0].segments.last().expect("one ran").start_s;
    assert!(waited_s > planned_s + 2.0, "told {waited_s} s after the measurement had begun");
    assert!(waited_s < planned_s + QUERY_S, "told {waited_s} s after the measurement had begun");
}

/// Longest time of the sweep of these tests: 0.1 s and 20 periods a point, 60 points from 20 Hz to 2 kHz.
fn sweep_s() -> f64 {
    (0..60).map(|point| 0.1 + 20.0 / (20.0 * 100_f64.powf(f64::from(point) / 59.0))).sum()
}

const NO_ANSWER: &str = "check power, address and cable of the instrument";

#[test]
fn an_analyser_that_does_not_answer_ends_the_point_within_the_time_of_a_query() {
    let ran = swept(|rig| analyser(rig, Trouble::Silence(FOREVER)));
    let told_s = ends_with(&ran, "analyser: answer: expected a whole one to *OPC?", NO_ANSWER);
    is_overdue(&ran, told_s, sweep_s());
}

#[test]
fn an_analyser_whose_answers_are_damaged_ends_the_point() {
    let ran = swept(|rig| analyser(rig, Trouble::Damage(0.05)));
    assert_eq!((ran.exit_code, ran.run.status), (4, Status::Errored), "{}", ran.reason());
    let (_, told) = ran.notice("analyser: ");
    assert!(told.contains("expected ") && told.contains("found ") && told.contains("; check "), "{told}");
}

#[test]
fn an_analyser_whose_answer_is_cut_off_ends_the_point() {
    let ran = swept(|rig| analyser(rig, Trouble::Cut(40)));
    assert_eq!((ran.exit_code, ran.run.status), (4, Status::Errored), "{}", ran.reason());
    let (_, told) = ran.notice("analyser: ");
    assert!(told.contains("expected ") && told.contains("found ") && told.contains("; check "), "{told}");
}

#[test]
fn an_analyser_that_resets_the_connection_ends_the_point_at_once() {
    let ran = swept(|rig| analyser(rig, RESET));
    let expected =
        "analyser at tcp:192.168.1.20:5025: line: expected an open line, found one that the device reset";
    ends_with(&ran, expected, "check whether the device was started again; then start again");
}

#[test]
fn an_oscilloscope_that_does_not_answer_ends_the_point_within_the_time_of_a_query() {
    let ran = captured(|rig| scope(rig, Trouble::Silence(FOREVER)));
    let told_s = ends_with(&ran, "scope: answer: expected a whole one to ", NO_ANSWER);
    is_overdue(&ran, told_s, 0.0);
}

#[test]
fn a_block_of_another_length_than_it_says_ends_the_point() {
    let ran = captured(|rig| troubled(rig, "sim:scope", Duration::ZERO, Trouble::WrongBlock));
    assert_eq!((ran.exit_code, ran.run.status), (4, Status::Errored), "{}", ran.reason());
    let (_, told) = ran.notice("scope: :WAV:DATA?: expected ");
    assert!(
        told.contains("found ") && told.contains("whether another program talks to the instrument"),
        "{told}"
    );
}

#[test]
fn garbage_before_an_answer_of_the_oscilloscope_ends_the_point() {
    let ran = captured(|rig| scope(rig, Trouble::Garbage(10, Occurrence::Every(20))));
    assert_eq!((ran.exit_code, ran.run.status), (4, Status::Errored), "{}", ran.reason());
    let (_, told) = ran.notice("scope: ");
    assert!(told.contains("expected ") && told.contains("found ") && told.contains("; check "), "{told}");
}

#[test]
fn an_oscilloscope_that_resets_the_connection_ends_the_point_at_once() {
    let ran = captured(|rig| scope(rig, RESET));
    let expected =
        "scope at tcp:192.168.1.20:5025: line: expected an open line, found one that the device reset";
    ends_with(&ran, expected, "check whether the device was started again; then start again");
}
