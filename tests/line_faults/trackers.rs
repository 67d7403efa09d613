//! The coarse tracker, whose target both axes follow: three frames without it trip. Single datagrams that are lost, damaged or
//! numbered wrongly are counted.

use std::time::Duration;

use bench::rig::wires::Wires;
use reports::record::Status;
use sim_devices::rig::SimulatedRig;

use super::bed::{FaultyWires, Ran, ran};
use super::troubles::{PortTrouble, troubled_coarse};

const RAIL: &str = include_str!("../../procedures/quick/track-rail.toml");
/// The axes follow the carriage by then.
const FROM: Duration = Duration::from_secs(12);
/// Frames of the coarse tracker.
const FRAME_S: f64 = 0.02;
const TICK_S: f64 = 0.25e-3;

fn tracked(wires: FaultyWires) -> Ran {
    ran("TRACK-RAIL", RAIL, wires)
}

fn port(rig: &SimulatedRig, trouble: PortTrouble) -> Wires {
    troubled_coarse(rig, FROM, &trouble)
}

fn trips_within_three_frames(ran: &Ran) {
    assert_eq!((ran.exit_code, ran.run.status), (3, Status::Aborted), "{}", ran.reason());
    let (told_s, told) = ran.notice("coarse: messages: expected one every 20.00 ms, found none for ");
    assert!(told.ends_with("; check power, cable and bit rate or address of the device"), "{told}");
    let tripped_s = ran.tripped_s("tracker lost");
    assert!((tripped_s - told_s).abs() <= 3.0 * FRAME_S, "told at {told_s} s, tripped at {tripped_s} s");
    let silent_ms: f64 =
        told.split("none for ").nth(1).and_then(|t| t.split(' ').next()?.parse().ok()).expect("a time");
    let newest_s = told_s - 1e-3 * silent_ms;
    assert!(
        tripped_s - newest_s <= 3.0 * FRAME_S + 2.0 * TICK_S,
        "{} s after the newest",
        tripped_s - newest_s
    );
    assert!(ran.reason().starts_with("tripped: az: tracker lost "), "{}", ran.reason());
    for stop in ran.windows.iter().flat_map(|window| &window.stops) {
        assert!(stop.standstill && stop.took_s <= stop.computed_s.unwrap_or(0.0) + 3.0, "{stop:?}");
    }
}

#[test]
fn a_tracker_that_is_silent_for_300_ms_trips_after_three_frames() {
    let ran = tracked(|rig| port(rig, PortTrouble::Silence(Duration::from_millis(300))));
    trips_within_three_frames(&ran);
    let (_, lost) = ran.notice("coarse: messages: expected all, found 15 lost");
    assert!(lost.contains(" 0 rejected"), "{lost}");
}

#[test]
fn datagrams_that_are_all_damaged_trip_after_three_frames_and_are_counted() {
    let ran = tracked(|rig| port(rig, PortTrouble::Damage));
    trips_within_three_frames(&ran);
    let (_, lost) = ran.notice("coarse: messages: expected all, found ");
    assert!(!lost.contains(" 0 rejected"), "{lost}");
}

#[test]
fn half_datagrams_trip_after_three_frames_and_are_counted() {
    let ran = tracked(|rig| port(rig, PortTrouble::Half));
    trips_within_three_frames(&ran);
    let (_, lost) = ran.notice("coarse: messages: expected all, found ");
    assert!(!lost.contains(" 0 rejected"), "{lost}");
}

#[test]
fn a_counter_that_jumps_and_one_damaged_datagram_are_counted_and_the_axes_go_on() {
    let ran = tracked(|rig| port(rig, PortTrouble::CounterJumpAndDamage(1000)));
    assert_eq!((ran.exit_code, ran.run.status), (0, Status::Completed), "{}", ran.reason());
    // The damaged one is lost, too.
    assert!(
        ran.notice("coarse: messages: ").1.contains("found 1001 lost, 1 rejected"),
        "{:?}",
        ran.notices()
    );
}
