//! The inertial unit, whose gyros the velocity loop of azimuth is closed on: no data for ten periods (2.5 ms) are told, for
//! 20 ms they trip. What costs single messages is counted, and the point goes on.

use std::time::Duration;

use drivers::wire::fault::Occurrence;
use procedures::log::PointStatus;
use reports::record::Status;
use sim_devices::rig::SimulatedRig;

use bench::rig::wires::Wires;

use super::bed::{FaultyWires, Ran, ran};
use super::troubles::{Trouble, troubled};

const FRICTION: &str = include_str!("../../procedures/quick/az-friction.toml");
/// Azimuth is on its way at 20 deg/s by then.
const FROM: Duration = Duration::from_secs(4);
/// A tick more than what was allowed: what is seen in one is told in it.
const TICK_S: f64 = 0.25e-3;

fn swept(wires: FaultyWires) -> Ran {
    let all = "[\"2 deg/s\", \"10 deg/s\", \"20 deg/s\", \"40 deg/s\", \"60 deg/s\"]";
    let text = FRICTION.replace(all, "[\"20 deg/s\"]");
    assert_ne!(text, FRICTION);
    ran("AZ-FRICTION", &text, wires)
}

fn line(rig: &SimulatedRig, trouble: Trouble) -> Wires {
    troubled(rig, "sim:imu", FROM, trouble)
}

/// What every fault that takes all messages away must come to.
fn trips_within_20_ms(ran: &Ran) {
    assert_eq!((ran.exit_code, ran.run.status), (3, Status::Aborted), "{}", ran.reason());
    let (told_s, told) = ran.notice("imu: messages: expected one every 0.25 ms, found none for ");
    assert!(told.ends_with("; check power, cable and bit rate or address of the device"), "{told}");
    let silent_ms: f64 =
        told.split("none for ").nth(1).and_then(|t| t.split(' ').next()?.parse().ok()).expect("a time");
    assert!(silent_ms > 2.5 && silent_ms < 3.5, "stale at ten periods: {told}");
    let newest_s = told_s - 1e-3 * silent_ms;
    let tripped_s = ran.tripped_s("rate feedback");
    assert!(tripped_s - newest_s <= 20e-3 + 2.0 * TICK_S, "{} ms", 1e3 * (tripped_s - newest_s));
    let reason = ran.reason();
    assert!(
        reason.starts_with("tripped: az: rate feedback 0.020 s, limit 0.020 s (imu: messages: "),
        "{reason}"
    );
    ran.is_stopped_in_motion();
}

#[test]
fn an_inertial_unit_that_is_silent_for_300_ms_is_told_at_2_5_ms_and_trips_at_20_ms() {
    let ran = swept(|rig| line(rig, Trouble::Silence(Duration::from_millis(300))));
    trips_within_20_ms(&ran);
    let (_, again) = ran.notice("imu: messages: heard again after ");
    let silent_ms: f64 =
        again.split("after ").nth(1).and_then(|t| t.split(' ').next()?.parse().ok()).expect("a time");
    assert!((silent_ms - 300.0).abs() < 2.0, "{again}");
    let (_, lost) = ran.notice("imu: messages: expected all, found ");
    // The number of a message counts modulo 128: of 1200 lost ones 48 can be told.
    assert!(lost.contains("0 rejected") && !lost.contains("found 0 lost"), "{lost}");
}

#[test]
fn another_talker_on_the_line_of_the_inertial_unit_trips_as_silence_does() {
    let ran = swept(|rig| line(rig, Trouble::Garbage(20, Occurrence::Every(4))));
    trips_within_20_ms(&ran);
    let (_, lost) = ran.notice("imu: messages: expected all, found ");
    assert!(!lost.contains(" 0 bytes that belong to none"), "{lost}");
}

#[test]
fn a_storm_of_wrong_checksums_trips_as_silence_does_and_is_counted() {
    let ran = swept(|rig| line(rig, Trouble::Damage(0.3)));
    trips_within_20_ms(&ran);
    let (_, lost) = ran.notice("imu: messages: expected all, found ");
    assert!(!lost.contains(" 0 rejected"), "{lost}");
}

/// A fault that costs so few messages that the loop stays closed on valid ones.
fn goes_on(ran: &Ran, losses: &str) {
    assert_eq!((ran.exit_code, ran.run.status), (0, Status::Completed), "{}", ran.reason());
    assert!(
        ran.windows.iter().all(|window| window.status == PointStatus::Completed && window.trips.is_empty())
    );
    let told = ran.notices();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].starts_with(&format!("imu: messages: expected all, found {losses}")), "{told:?}");
}

#[test]
fn half_a_message_of_the_inertial_unit_is_counted_and_the_next_one_is_found() {
    goes_on(&swept(|rig| line(rig, Trouble::Cut(18))), "1 lost, ");
}

#[test]
fn a_counter_that_jumps_by_nine_is_counted() {
    goes_on(&swept(|rig| line(rig, Trouble::Cut(9 * 36))), "9 lost, 0 rejected");
}

#[test]
fn a_burst_of_garbage_is_passed_over() {
    let ran = swept(|rig| line(rig, Trouble::Garbage(500, Occurrence::At { first: 1, count: 1 })));
    goes_on(&ran, "0 lost, 0 rejected (checksum, content, late or twice), 500 bytes");
}

#[test]
fn an_adapter_that_is_unplugged_stops_the_axis_in_the_tick_in_which_it_is_seen() {
    let ran = swept(|rig| {
        let gone = Trouble::Gone {
            address: "serial:/dev/ttyUSB0?baud=4147200",
            found: "one that was unplugged or closed by the far end (end of input)",
            help: "check plug and supply of the adapter, then start again",
        };
        line(rig, gone)
    });
    assert_eq!((ran.exit_code, ran.run.status), (4, Status::Errored));
    let expected = "imu at serial:/dev/ttyUSB0?baud=4147200: line: expected an open line, found one that was unplugged or \
                    closed by the far end (end of input); check plug and supply of the adapter, then start again";
    assert_eq!(ran.reason(), expected);
    let (told_s, told) = ran.notice("imu at ");
    assert_eq!(told, expected);
    let stopped_s = ran.windows[0].segments.last().expect("one ran").end_s;
    assert!((stopped_s - told_s).abs() <= TICK_S, "stopped at {stopped_s} s, told at {told_s} s");
    ran.is_stopped_in_motion();
}
