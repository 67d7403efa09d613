//! How axes are left: held, released, parked.

use procedures::log::PointStatus;

use super::bed::{Bed, case, go_to, rig};

const RELEASE: (&str, &str) = ("safe-state", "\"release\"");
const REST_AT_0: (&str, &str) = ("spring-rest", "\"0 deg\"");

/// A unit whose cable spring rests at 0°: at the top it pulls with 85 N·m, twice what friction holds (director.md, E23).
fn stretched(start_el_deg: f64, safety: &[(&str, &str)]) -> Bed {
    let mut bed = Bed::new(case("az", [0.0, start_el_deg], vec![go_to(1.0, 3.0)]));
    bed.rig = rig(safety);
    bed.start_deg = [0.0, start_el_deg];
    (bed.unit.el.spring_stiffness_nm_per_rad, bed.unit.el.spring_rest_rad) = (54.0, 0.0);
    bed
}

#[test]
fn an_elevation_that_would_swing_back_is_held_although_the_rig_says_release_and_the_swing_is_told() {
    let ran = stretched(89.0, &[RELEASE, REST_AT_0, ("safe-pose", "\"0 deg\"")]).run();
    let safe = &ran.outcome.safe;
    assert!(safe.standstill, "{safe:?}");
    assert!(safe.axes[1].held, "{safe:?}");
    let swing = safe.axes[1].swing.expect("85 N·m against 43");
    let to = swing.to_rad.to_degrees();
    let speed = swing.speed_rad_per_s.to_degrees();
    assert!((0.0..60.0).contains(&to) && speed > 5.0, "swings to {to} deg at {speed} deg/s");
    let left = &ran.window.as_ref().expect("a log").left;
    assert_eq!(left[1].swing_to_rad, Some(swing.to_rad));
    assert!(safe.text(&["az".into(), "el".into()]).contains("without torque it swings to"), "{safe:?}");
}

#[test]
fn an_axis_that_friction_holds_is_released_in_good_order() {
    let ran = stretched(20.0, &[RELEASE, REST_AT_0, ("safe-pose", "\"0 deg\"")]).run();
    let safe = &ran.outcome.safe;
    assert_eq!(ran.outcome.status, PointStatus::Completed, "{:?}", ran.outcome);
    assert!(safe.standstill && !safe.axes[1].held && safe.axes[0].held, "{safe:?}");
    assert_eq!(safe.axes[1].swing, None);
    assert!(ran.states().contains(&12), "disabling is a state of the tick: {:?}", ran.states());
}

#[test]
fn an_axis_is_parked_where_it_may_be_released() {
    let mut bed = stretched(89.0, &[RELEASE, REST_AT_0, ("safe-pose", "\"10 deg\"")]);
    bed.parks = true;
    let ran = bed.run();
    let el = &ran.outcome.safe.axes[1];
    assert!(!el.held && ran.outcome.safe.standstill, "{el:?}");
    assert!((el.position_rad.to_degrees() - 10.0).abs() < 0.1, "{el:?}");
    assert!(ran.largest("/el", "velocity_rad_per_s") < 6.0_f64.to_radians(), "parking is slow");
    assert_eq!(ran.states(), [1, 2, 3, 4, 11, 12, 6, 7]);
}
