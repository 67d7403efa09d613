//! External laws that go wrong in motion: named, and the axis stops by the built-in law.

use std::path::Path;
use std::time::Duration;

use bench::cycle::laws::{Law, Laws};
use procedures::case::{Case, Mode, Segment};
use procedures::excitation::{Excitation, Injection, Signal};
use procedures::log::{EndedBy, PointStatus, StopManner};
use validation::compiled;

use super::bed::{Bed, Ran, case, go_to};

/// A law goes wrong at the first reference above this rate, in the middle of a move.
const WRONG_FROM_RAD_PER_S: f64 = 0.2;

/// State of the sequencer in the log while it stops the axes.
const STOPPING: f64 = 5.0;

/// Makes a law of a library.
type Make = fn(&Path) -> Law;

fn in_process(library: &Path) -> Law {
    compiled::in_process(library)
}

fn hosted(library: &Path, deadline: Option<Duration>) -> Law {
    compiled::hosted(library, env!("CARGO_BIN_EXE_bench"), deadline)
}

/// Azimuth by the example in C, which goes wrong in this way where the condition holds.
fn goes_wrong(folder: &Path, condition: &str, how: &str, make: Make) -> Laws {
    let spoils = format!("if (in->take_over == 0.0 && ({condition})) {{ {how} }}");
    let library = compiled::spoilt(folder, "wrong", &spoils);
    let mut laws = Laws::default();
    assert!(laws.insert("az", make(&library)), "the only law");
    laws
}

/// A move of azimuth by the example in C, which goes wrong in this way.
fn moved(folder: &Path, how: &str, make: Make) -> Ran {
    let condition = format!("in->reference_rad_per_s > {WRONG_FROM_RAD_PER_S:?}");
    let mut bed = Bed::new(case("az", [0.0, 0.0], vec![go_to(40.0, 10.0)]));
    bed.laws = goes_wrong(folder, &condition, how, make);
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
    for (how, interlock, cause) in [
        ("out->torque_nm = NAN;", "torque of external law", "not a finite number"),
        ("out->torque_nm = -INFINITY;", "torque of external law", "not a finite number"),
        ("out->torque_nm = 1e6;", "torque of external law", "beyond the limit"),
        ("out->fault = 7;", "fault of external law", "the law reported fault 7"),
    ] {
        is_stopped_at_once(&moved(folder.path(), how, in_process), interlock, cause);
    }
}

#[test]
fn a_law_that_crashes_or_ends_in_its_own_process_stops_the_axis_in_the_same_tick() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (how, interlock, cause) in [
        ("*(volatile int *)0 = 1;", "process of external law", "signal 11 ended"),
        ("_exit(3);", "process of external law", "ended with exit code 3"),
        ("out->torque_nm = NAN;", "torque of external law", "not a finite number"),
    ] {
        is_stopped_at_once(&moved(folder.path(), how, |library| hosted(library, None)), interlock, cause);
    }
}

/// The axis holds while a test adds a torque that jumps; the law fails in the tick after the jump.
#[test]
fn the_stop_after_a_failing_law_keeps_nothing_of_an_excitation() {
    const ADDED_NM: f64 = 150.0;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let signal = Signal::Square { amplitude: ADDED_NM, period_s: 1.0 };
    let excitation = Excitation { into: Injection::Torque, signal, fade_s: 0.0, every_ticks: 1 };
    let hold = Segment { excited: Some(0), ..Segment::hold("hold", Mode::Position, 2.0) };
    let mut bed = Bed::new(Case { excitations: vec![excitation], ..case("az", [0.0, 0.0], vec![hold]) });
    bed.laws = goes_wrong(folder.path(), "in->sent_nm > 100.0", "out->fault = 1;", in_process);
    let ran = bed.run();
    let trip = ran.outcome.trip.expect("it tripped");
    assert_eq!((trip.interlock, trip.axis), ("fault of external law", Some(0)));
    let first =
        ran.column("/bench", "state").iter().position(|&state| state == STOPPING).expect("it was stopped");
    let commanded = ran.column("/az", "torque_command_nm");
    assert!(commanded[first - 1] > 100.0, "the excitation was on: {} N·m", commanded[first - 1]);
    // Noise of the gyros makes up to 40 N*m of torque while the axis holds.
    assert!(commanded[first].abs() < 0.5 * ADDED_NM, "{} N·m stay in the stop", commanded[first]);
}

#[test]
fn virtual_time_waits_for_a_slow_law() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let slow = "static int steps; if (++steps < 5) usleep(50000);";
    let ran = moved(folder.path(), slow, |library| hosted(library, None));
    assert_eq!((ran.outcome.status, ran.outcome.trip), (PointStatus::Completed, None));
}

/// With a deadline a busy computer may be late before the law is; the axis stops all the same.
#[test]
fn a_law_that_answers_late_stops_the_axis() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let ran =
        moved(folder.path(), "usleep(50000);", |library| hosted(library, Some(Duration::from_micros(100))));
    let trip = ran.outcome.trip.expect("it tripped");
    assert_eq!((trip.interlock, trip.limit), ("answer of external law", 100.0));
    assert!(trip.seen > 100.0 && ran.outcome.safe.standstill, "{:?}", ran.outcome);
    // With time enough for a busy computer only the law itself is late.
    let generous: Make = |library| hosted(library, Some(Duration::from_secs(1)));
    let ran = moved(folder.path(), "sleep(2);", generous);
    is_stopped_at_once(&ran, "answer of external law", "did not answer in time");
}
