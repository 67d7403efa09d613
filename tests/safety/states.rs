//! States of the sequencer beside moving: homing, questions, points without a closed loop.

use bench::cycle::prompt::{Answer, Question};
use procedures::case::{Mode, Then};
use procedures::log::{PointStatus, StopManner};
use procedures::procedure::PromptClass;
use procedures::stimulus::Stimulus;

use super::bed::{Bed, case, go_to, segment};

#[test]
fn axes_that_are_elsewhere_go_slowly_to_where_the_plan_begins() {
    let mut bed = Bed::new(case("az", [0.0, 30.0], vec![go_to(2.0, 4.0)]));
    bed.start_deg = [-6.0, 40.0];
    let ran = bed.run();
    assert_eq!(ran.outcome.status, PointStatus::Completed, "{:?}", ran.outcome);
    assert!(ran.states().contains(&10), "{:?}", ran.states());
    let begins = ran.window.as_ref().expect("a log").segments[0].start_position_rad.to_degrees();
    assert!(begins.abs() < 0.1, "began at {begins} deg");
    assert!(ran.largest("/el", "velocity_rad_per_s").to_degrees() < 6.0, "homing is slow");
}

#[test]
fn a_safety_question_is_asked_without_torque_and_another_while_the_axes_are_held() {
    let bed = |class| {
        let mut bed = Bed::new(case("az", [0.0, 40.0], vec![go_to(2.0, 4.0)]));
        bed.start_deg = [0.0, 40.0];
        bed.questions = [Question::new(class)].into();
        bed.questions[0].give(Answer::Confirmed);
        bed
    };
    assert_eq!(bed(PromptClass::Safety).run().states(), [1, 9, 2, 3, 4, 6, 7]);
    assert_eq!(bed(PromptClass::Info).run().states(), [1, 2, 9, 3, 4, 6, 7]);
}

#[test]
fn a_no_ends_the_point_before_it_moves() {
    for class in [PromptClass::Safety, PromptClass::Info] {
        let mut bed = Bed::new(case("az", [0.0, 40.0], vec![go_to(2.0, 4.0)]));
        bed.start_deg = [0.0, 40.0];
        bed.questions = [Question::new(class)].into();
        bed.questions[0].give(Answer::Refused);
        let ran = bed.run();
        assert_eq!(ran.outcome.refused.as_deref(), Some("the operator refused"));
        assert_eq!((ran.outcome.status, ran.outcome.safe.standstill), (PointStatus::Aborted, true));
        assert!(ran.window.as_ref().expect("a log").segments.is_empty());
        assert!(ran.largest("/az", "velocity_rad_per_s") < 1e-3);
    }
}

/// Nothing is proven of signs and scales yet: no torque but the segment's own, and none at all once something trips.
#[test]
fn a_point_without_closed_loops_gives_no_torque_of_its_own_and_lets_go_when_it_trips() {
    let mut push = segment(Mode::Torque, Stimulus::Hold { torque_nm: 400.0 }, 5.0);
    push.then = Then::Next;
    let mut bed = Bed::new(case("az", [0.0, 40.0], vec![push]));
    bed.start_deg = [0.0, 40.0];
    bed.case.open_loop = true;
    bed.case.torque_limit_nm = Some(240.0);
    let ran = bed.run();
    assert!(ran.outcome.safe.standstill, "{:?}", ran.outcome);
    assert_eq!(ran.largest("/el", "torque_command_nm"), 0.0, "the other axis is not held by a loop");
    assert_eq!(ran.largest("/az", "torque_command_nm"), 240.0, "the drive has the point's own limit");
    let stops = &ran.window.as_ref().expect("a log").stops;
    assert!(stops.iter().all(|stop| stop.manner == StopManner::TorqueOff), "{stops:?}");
}
