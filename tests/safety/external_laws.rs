//! External laws that go wrong in motion: named, and the axis stops by the built-in law.

use std::path::{Path, PathBuf};
use std::time::Duration;

use bench::cycle::laws::{DEADLINE, Hosting};
use procedures::log::{EndedBy, PointStatus, StopManner};

use super::bed::{Bed, Ran, case, go_to};
use crate::laws::compiled;

/// A law goes wrong at the first reference above this rate, in the middle of a move.
const WRONG_FROM_RAD_PER_S: f64 = 0.2;

/// State of the sequencer in the log while it stops the axes.
const STOPPING: f64 = 5.0;

/// A move of azimuth by the example in C, which goes wrong in this way.
fn moved(folder: &Path, goes_wrong: &str, hosting: Hosting) -> Ran {
    let spoils = format!(
        "if (in->take_over == 0.0 && in->reference_rad_per_s > {WRONG_FROM_RAD_PER_S:?}) {{ {goes_wrong} }}"
    );
    let library = compiled::spoilt(folder, "wrong", &spoils);
    let mut bed = Bed::new(case("az", [0.0, 0.0], vec![go_to(40.0, 10.0)]));
    bed.laws = compiled::on_azimuth(&library, hosting);
    bed.run()
}

/// The move was stopped in the tick in which the law went wrong: no later tick followed the command.
fn is_stopped_at_once(ran: &Ran, interlock: &str, cause: &str) {
    let outcome = &ran.outcome;
    assert_eq!(outcome.status, PointStatus::Aborted, "{outcome:?}");
    let trip = outcome.trip.expect("it tripped");
    assert_eq!((trip.interlock, trip.axis), (interlock, Some(0)));
    assert!(outcome.cause.as_ref().is_some_and(|found| found.contains(cause)), "{:?}", outcome.cause);
    let window = ran.window.as_ref().expect("a log");
    assert_eq!(window.segments[0].ended_by, EndedBy::Stopped);
    let stop = window.stops.iter().find(|stop| stop.axis == "az").expect("it moved");
    assert!(stop.manner == StopManner::Controlled && stop.standstill, "{stop:?}");
    assert!(stop.from_rad_per_s > 0.15 && ran.contacts == 0, "{stop:?}");
    let commanded = ran.column("/az", "torque_command_nm");
    assert!(commanded.iter().all(|torque_nm| torque_nm.abs() <= 2556.1), "no broken torque went out");
    // The first tick of the stop is the one in which the law went wrong: every command before it was one that the law
    // still took, and its own setpoint is already that of a stop, which begins where the axis is.
    let first =
        ran.column("/bench", "state").iter().position(|&state| state == STOPPING).expect("it was stopped");
    let before = &ran.column("/az", "velocity_command_rad_per_s")[..first];
    assert!(before.iter().all(|&command| command <= WRONG_FROM_RAD_PER_S));
    assert!(before[first - 1] > WRONG_FROM_RAD_PER_S - 1e-3, "{} rad/s", before[first - 1]);
    let ahead_rad =
        ran.column("/az", "position_setpoint_rad")[first] - ran.column("/az", "position_rad")[first];
    assert!(ahead_rad.abs() < 1e-4, "{ahead_rad} rad");
}

#[test]
fn a_torque_that_is_no_number_too_large_or_declared_faulty_stops_the_axis_in_the_same_tick() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (goes_wrong, interlock, cause) in [
        ("out->torque_nm = NAN;", "torque of external law", "not a finite number"),
        ("out->torque_nm = -INFINITY;", "torque of external law", "not a finite number"),
        ("out->torque_nm = 1e6;", "torque of external law", "beyond the limit"),
        ("out->fault = 7;", "fault of external law", "the law reported fault 7"),
    ] {
        is_stopped_at_once(&moved(folder.path(), goes_wrong, Hosting::InProcess), interlock, cause);
    }
}

fn hosted(deadline: Option<Duration>) -> Hosting {
    Hosting::Child { program: PathBuf::from(env!("CARGO_BIN_EXE_bench")), deadline }
}

#[test]
fn a_law_that_crashes_or_ends_in_its_own_process_stops_the_axis_in_the_same_tick() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (goes_wrong, interlock, cause) in [
        ("*(volatile int *)0 = 1;", "process of external law", "signal 11 ended"),
        ("_exit(3);", "process of external law", "ended with exit code 3"),
        ("out->torque_nm = NAN;", "torque of external law", "not a finite number"),
    ] {
        is_stopped_at_once(&moved(folder.path(), goes_wrong, hosted(None)), interlock, cause);
    }
}

#[test]
fn virtual_time_waits_for_a_slow_law() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let slow = "static int steps; if (++steps < 5) usleep(50000);";
    let ran = moved(folder.path(), slow, hosted(None));
    assert_eq!((ran.outcome.status, ran.outcome.trip), (PointStatus::Completed, None));
}

/// With a deadline a busy computer may be late before the law is; the axis stops all the same.
#[test]
fn a_law_that_answers_late_stops_the_axis() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let ran = moved(folder.path(), "usleep(50000);", hosted(Some(DEADLINE)));
    let trip = ran.outcome.trip.expect("it tripped");
    assert_eq!((trip.interlock, trip.limit), ("answer of external law", 100.0));
    assert!(trip.seen > 100.0 && ran.outcome.safe.standstill, "{:?}", ran.outcome);
    // With time enough for a busy computer only the law itself is late.
    let generous = Some(Duration::from_secs(1));
    let ran = moved(folder.path(), "sleep(2);", hosted(generous));
    is_stopped_at_once(&ran, "answer of external law", "did not answer in time");
}
