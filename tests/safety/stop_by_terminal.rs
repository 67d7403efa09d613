//! The emergency stop at an input of a digital terminal instead of one of a drive: what the loop makes of it is the same.

use std::time::Duration;

use bench::model::terminal::TerminalInput;
use sim_devices::rig::Fault;

use super::bed::{Bed, Ran, case, go_to};

const AT: Duration = Duration::from_secs(2);

/// A move of azimuth during which the emergency stop is pressed, or not; wired to an input, or to the drive.
fn moved(input: Option<u16>, is_pressed: bool) -> Ran {
    let mut bed = Bed::new(case("az", [0.0, 40.0], vec![go_to(60.0, 6.0)]));
    bed.start_deg = [0.0, 40.0];
    if let Some(input) = input {
        bed.rig.emergency_stop_input = Some(TerminalInput { station: 4, input });
        bed.rig.emergency_stop_bit = None;
        bed.rig.axes.iter_mut().for_each(|axis| axis.guard.emergency_stop_bit = None);
    }
    if is_pressed {
        bed.faults = vec![(AT, Fault::EmergencyStop { pressed: true })];
    }
    bed.run()
}

#[test]
fn the_input_of_a_terminal_trips_as_the_bit_of_a_drive_does() {
    let [by_terminal, by_drive] = [Some(0), None].map(|input| moved(input, true));
    let trip = by_terminal.outcome.trip.as_ref().expect("it was pressed");
    assert_eq!(trip.interlock, "emergency stop");
    assert_eq!(by_drive.outcome.trip.as_ref(), Some(trip));
    assert!(by_terminal.outcome.safe.standstill && by_drive.outcome.safe.standstill);
    let rows = |ran: &Ran| ran.column("/az", "position_rad").len();
    assert!(
        rows(&by_terminal).abs_diff(rows(&by_drive)) <= 8,
        "{} and {}",
        rows(&by_terminal),
        rows(&by_drive)
    );
}

#[test]
fn an_input_that_is_on_lets_the_axis_move() {
    let ran = moved(Some(0), false);
    assert_eq!(ran.outcome.trip, None);
    let last = ran.column("/az", "position_rad").last().expect("rows").to_degrees();
    assert!((last - 60.0).abs() < 0.5, "{last} deg");
}

#[test]
fn an_input_that_nothing_is_wired_to_counts_as_pressed_and_nothing_moves() {
    let ran = moved(Some(3), false);
    assert_eq!(ran.outcome.trip.as_ref().map(|trip| trip.interlock), Some("emergency stop"));
    assert!(ran.largest("/az", "position_rad").to_degrees() < 0.1);
}
