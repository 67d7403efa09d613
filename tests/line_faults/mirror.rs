//! The mirror, whose serial line carries its commands: a reply that is missing for 200 ms ends the point with an error, and the
//! mirror is in its middle within 100 ms where it still takes orders.

use std::time::Duration;

use bench::rig::wires::Wires;
use drivers::wire::fault::Occurrence;
use reports::record::Status;
use sim_devices::rig::SimulatedRig;

use super::bed::{FaultyWires, Ran, ran};
use super::troubles::{Trouble, troubled};

const RESPONSE: &str = include_str!("../../procedures/quick/fsm-response.toml");
/// The multisine is under way by then.
const FROM: Duration = Duration::from_millis(1500);
/// The mirror's middle within the noise of its gauges, rad.
const MIDDLE_RAD: f64 = 20e-6;

fn excited(wires: FaultyWires) -> Ran {
    let only = "axis = \"az\"\nmirror-axis = [\"az\"]\nchannel = [\"serial\"]\n";
    let text = RESPONSE.replace("axis = \"az\"\n", only);
    ran("FSM-RESPONSE", &text, wires)
}

fn line(rig: &SimulatedRig, trouble: Trouble) -> Wires {
    troubled(rig, "sim:mirror", FROM, trouble)
}

/// A failed dialogue ends the point, the gimbal is left at standstill, and the mirror is in its middle 100 ms later.
fn ends_with(ran: &Ran, start: &str, end: &str) -> f64 {
    assert_eq!((ran.exit_code, ran.run.status), (4, Status::Errored), "{}", ran.reason());
    let (told_s, told) = ran.notice(start);
    assert!(told.ends_with(end), "{told}");
    assert!(ran.reason().contains(told), "{} does not say {told}", ran.reason());
    told_s
}

/// The mirror is in its middle from `after_s` after the error on.
fn is_back(ran: &Ran, told_s: f64, after_s: f64) {
    let window =
        ran.windows.iter().find(|window| window.segments.iter().any(|s| (s.end_s - told_s).abs() < 1e-3));
    let rows = window.expect("the point that failed").rows("/fsm").expect("the mirror's rows");
    let tilts = rows.column("angle_az_rad").expect("a channel");
    let late = rows.time_s.iter().zip(tilts).filter(|(at_s, _)| **at_s > told_s + after_s);
    let farthest = late.map(|(_, tilt_rad)| tilt_rad.abs()).reduce(f64::max).expect("rows after that time");
    assert!(farthest < MIDDLE_RAD, "{farthest} rad from the middle");
}

#[test]
fn a_mirror_that_is_silent_for_300_ms_ends_the_point_and_is_brought_to_its_middle_when_it_answers_again() {
    let ran = excited(|rig| line(rig, Trouble::Silence(Duration::from_millis(300))));
    let start = "fsm at mirror line: reply: expected 1 bytes to ";
    let told_s = ends_with(&ran, start, "check power, cable and bit rate of the mirror unit");
    // It is silent for 100 ms more, the order that it missed is given up 200 ms after it was sent, and the next one is taken.
    is_back(&ran, told_s, 0.5);
}

#[test]
fn half_a_reply_of_the_mirror_ends_the_point_and_brings_the_mirror_to_its_middle() {
    let ran = excited(|rig| line(rig, Trouble::Cut(1)));
    let told_s =
        ends_with(&ran, "fsm at mirror line: reply: expected 1 bytes to ", "bit rate of the mirror unit");
    is_back(&ran, told_s, 0.1);
}

#[test]
fn garbage_on_the_line_of_the_mirror_ends_the_point_and_brings_the_mirror_to_its_middle() {
    let ran = excited(|rig| line(rig, Trouble::Garbage(3, Occurrence::At { first: 1, count: 1 })));
    let told_s = ends_with(
        &ran,
        "fsm at mirror line: reply: expected X at the end of that to ",
        "check the bit rate, and look for another talker on the line",
    );
    is_back(&ran, told_s, 0.1);
}

#[test]
fn an_adapter_that_is_unplugged_ends_the_point() {
    let ran = excited(|rig| {
        let gone = Trouble::Gone {
            address: "serial:/dev/ttyUSB1?baud=115200",
            found: "one that was unplugged or closed by the far end (end of input)",
            help: "check plug and supply of the adapter, then start again",
        };
        line(rig, gone)
    });
    // Nothing can reach it any more: the residual risk that docs/safety.md names.
    ends_with(
        &ran,
        "fsm at serial:/dev/ttyUSB1?baud=115200: line: expected an open line, found one that was unplugged",
        "check plug and supply of the adapter, then start again",
    );
}
