use std::collections::BTreeMap;

use procedures::case::{Bounds, Case, Condition, Mode, Segment, Then};
use procedures::stimulus::{ProfileLimits, Stimulus};

use super::*;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::plan::{Wanted, plan};

fn rig() -> Rig {
    read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("a shipped rig parses")
}

fn deg(value: f64) -> f64 {
    value.to_radians()
}

fn limits(velocity: f64, acceleration: f64) -> ProfileLimits {
    ProfileLimits {
        velocity_rad_per_s: deg(velocity),
        acceleration_rad_per_s2: deg(acceleration),
        jerk_rad_per_s3: deg(900.0),
    }
}

fn segment(mode: Mode, stimulus: Stimulus, until: Option<Condition>, at_most_s: f64) -> Segment {
    let label = "test".to_owned();
    Segment {
        label,
        mode,
        stimulus,
        until,
        at_most_s,
        then: Then::Hold,
        dithered: false,
        ..Segment::default()
    }
}

fn case(axis: &str, at: f64, segments: Vec<Segment>) -> Case {
    let other = if axis == "az" { "el" } else { "az" };
    let start_pose_rad = BTreeMap::from([(axis.to_owned(), deg(at)), (other.to_owned(), deg(0.0))]);
    Case { point: "point".to_owned(), axis: axis.to_owned(), start_pose_rad, segments, ..Case::default() }
}

fn strokes(axis: &str, from: f64, to: f64, velocity: f64, acceleration: f64, cycles: u32) -> Case {
    let stimulus = Stimulus::Reversals {
        from_rad: deg(from),
        to_rad: deg(to),
        limits: limits(velocity, acceleration),
        cycles,
    };
    case(axis, from, vec![segment(Mode::Position, stimulus, None, 1e4)])
}

fn ramp(rate_nm_per_s: f64, until: Option<Condition>, at_most_s: f64) -> Segment {
    segment(Mode::Torque, Stimulus::TorqueRamp { from_nm: 0.0, rate_nm_per_s }, until, at_most_s)
}

fn of(case: &Case, rig: &Rig) -> ProcedureEnvelope {
    envelope("P", &case.axis, std::slice::from_ref(case), rig).expect("the rig has the axis")
}

fn refused(case: &Case, rig: &Rig) -> Vec<String> {
    let all = refuse::refusals(&of(case, rig), std::slice::from_ref(case), rig);
    all.into_iter().map(|d| d.message).collect()
}

#[test]
fn everything_that_is_shipped_may_fly() {
    for campaign in ["quick", "fat"] {
        let wanted = Wanted { names: vec![campaign.to_owned()], ..Wanted::default() };
        let plan = plan(&wanted, &rig()).expect("it plans");
        let found = envelopes(&plan.procedures, &rig());
        for planned in &plan.procedures {
            let own = |e: &&ProcedureEnvelope| e.procedure == planned.procedure.id;
            assert_eq!(found.iter().filter(own).count(), 1, "{}", planned.procedure.id);
        }
        assert!(refusals(&plan.procedures, &rig()).is_empty(), "{campaign}");
    }
}

/// The worst over every instant at a tenth of the plan's own step, every coast integrated.
#[test]
fn no_instant_between_the_samples_is_worse_than_what_was_found() {
    let rig = rig();
    for (case, axis) in [
        (strokes("el", -8.0, 88.0, 60.0, 90.0, 1), 1),
        (strokes("az", -150.0, 150.0, 60.0, 45.0, 1), 0),
        (strokes("el", 0.0, 89.0, 20.0, 20.0, 1), 1),
    ] {
        let stop = &rig.axes[axis].guard.stop;
        let stimulus = &case.segments[0].stimulus;
        let start = case.start_pose_rad[&case.axis];
        let mut room = f64::INFINITY;
        let mut angle = 0.0_f64;
        let mut energy = 0.0_f64;
        let lasts_s = stimulus.duration_s(start).expect("strokes end");
        let prepared = stimulus.prepare(start);
        for k in 0..(lasts_s / 5e-4) as u32 {
            let at = prepared.at(f64::from(k) * 5e-4);
            let towards = (at.acceleration_rad_per_s2 * at.velocity_rad_per_s.signum())
                .max(-stop.deceleration_rad_per_s2);
            let way =
                stop.controlled_from(at.velocity_rad_per_s, towards, stop.deceleration_rad_per_s2).angle_rad;
            let ahead = stop.room_rad(at.position_rad, at.velocity_rad_per_s);
            room = room.min(if at.velocity_rad_per_s == 0.0 { room } else { ahead - way });
            angle = angle.max(way);
            if k % 4 == 0 && at.velocity_rad_per_s != 0.0 {
                let coast = stop.coast(at.position_rad, at.velocity_rad_per_s);
                energy = energy.max(coast.impact.map_or(0.0, |i| i.energy_j));
            }
        }
        let found = of(&case, &rig);
        let nearest = found.nearest_stop().expect("it moves").room_rad;
        let longest = found.longest_stop().expect("it moves").angle_rad;
        let impact = found.coast(&rig.axes[axis]).and_then(|c| c.coast.impact).map_or(0.0, |i| i.energy_j);
        assert!(
            (nearest - room).abs() < deg(0.002),
            "{} against {}",
            nearest.to_degrees(),
            room.to_degrees()
        );
        assert!((longest - angle).abs() < deg(0.002), "{longest} against {angle}");
        assert!((impact - energy).abs() < 0.01 * energy.max(1.0), "{impact} J against {energy} J");
    }
}

#[test]
fn a_stroke_that_turns_too_near_to_its_soft_limit_is_refused_with_place_rate_and_limit() {
    let near = strokes("el", 0.0, 89.48, 60.0, 90.0, 1);
    let messages = refused(&near, &rig());
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].contains("P, point `point`: a stop under control of axis `el`"), "{messages:?}");
    assert!(messages[0].contains("soft limits are -9.5 deg .. 89.5 deg"), "{messages:?}");
    assert!(refused(&strokes("el", 0.0, 89.0, 60.0, 90.0, 1), &rig()).is_empty());
}

#[test]
fn a_rig_whose_stops_brake_less_than_its_plans_do_is_told_so() {
    let mut weak = rig();
    weak.axes[1].guard.stop.deceleration_rad_per_s2 = deg(25.0);
    let case = strokes("el", -8.0, 88.0, 60.0, 90.0, 1);
    let stop = of(&case, &weak).nearest_stop().expect("it moves");
    // 60 deg/s at 25 deg/s^2 takes 72 deg: from the middle of the travel there is nowhere to go.
    assert!(stop.angle_rad > deg(72.0) || stop.room_rad < 0.0);
    assert!(refused(&case, &weak)[0].contains("a stop under control"));
}

#[test]
fn strokes_without_a_pause_heat_the_motor_and_are_refused_in_the_end() {
    let mut rig = rig();
    rig.axes[1].guard.safety.continuous_torque_nm = 870.0;
    let rms = |cycles| of(&strokes("el", -8.0, 88.0, 60.0, 90.0, cycles), &rig).rms_torque_nm;
    assert!(rms(1) < rms(4) && rms(4) < rms(20));
    // In the long run it is the root mean square of one stroke, whatever the time constant.
    assert!((rms(200) - rms(100)).abs() < 1.0);
    let messages = refused(&strokes("el", -8.0, 88.0, 60.0, 90.0, 20), &rig);
    assert!(messages.iter().any(|m| m.contains("root mean square") && m.contains("870 N*m")), "{messages:?}");
}

#[test]
fn a_constant_torque_warms_up_with_the_time_constant_of_the_rig() {
    let hold = |torque_nm, for_s| segment(Mode::Torque, Stimulus::Hold { torque_nm }, None, for_s);
    let found = of(&case("az", 0.0, vec![hold(100.0, 60.0)]), &rig());
    let expected = 100.0 * (1.0 - (-1.0_f64).exp()).sqrt();
    assert!((found.rms_torque_nm - expected).abs() < 1e-9, "{} N*m", found.rms_torque_nm);
    assert_eq!(found.points[0].torque_nm, 100.0);
}

#[test]
fn acceleration_that_motor_and_friction_leave_no_torque_for_is_refused() {
    let mut weak = rig();
    weak.axes[1].guard.max_torque_nm = 421.0;
    let messages = refused(&strokes("el", 0.0, 80.0, 60.0, 90.0, 1), &weak);
    assert!(messages.iter().any(|m| m.contains("it can deliver 421 N*m")), "{messages:?}");
}

#[test]
fn bare_end_stops_allow_no_coast_that_reaches_them() {
    let mut bare = rig();
    bare.axes[1].guard.stop.end_stop_energy_j = 0.0;
    let messages = refused(&strokes("el", -8.0, 88.0, 60.0, 90.0, 1), &bare);
    assert!(messages[0].contains("hits its end stop with"), "{messages:?}");
    assert!(refused(&strokes("el", 30.0, 50.0, 5.0, 20.0, 1), &bare).is_empty());
}

#[test]
fn a_ramp_is_bounded_by_its_displacement_and_the_torque_that_it_may_reach() {
    let until = Some(Condition::Displacement { above_rad: deg(2.0) });
    let found = of(&case("az", 0.0, vec![ramp(100.0, until, 10.0)]), &rig());
    let bounded = &found.points[0].bounded[0];
    // 1000 N*m less 135 N*m of friction on 1200 kg*m^2 over 2 deg, and the reaction time.
    let expected = (2.0 * 865.0 / 1200.0 * deg(2.0)).sqrt();
    assert_eq!(bounded.by, "its displacement");
    assert!((bounded.rate_rad_per_s - expected).abs() < 0.02 * expected, "{}", bounded.rate_rad_per_s);
    let [low, high] = found.points[0].position_rad;
    assert!(low < deg(-2.0) && high > deg(2.0), "both ways: the load may win");
}

#[test]
fn a_torque_that_static_friction_holds_moves_nothing_and_one_without_a_condition_is_left_to_the_interlock() {
    let held = of(&case("az", 0.0, vec![ramp(10.0, None, 10.0)]), &rig());
    assert_eq!(held.points[0].bounded[0].rate_rad_per_s, 0.0);
    assert!(held.longest_stop().is_none());
    let free = of(&case("az", 0.0, vec![ramp(100.0, None, 10.0)]), &rig());
    assert_eq!(free.points[0].bounded[0].by, "the braking curve alone");
    assert_eq!(free.points[0].bounded[0].rate_rad_per_s, deg(66.0), "the trip velocity");
}

#[test]
fn without_closed_loops_friction_alone_stops_the_axis_and_must_hold_the_other_one() {
    let bounds = Some(Bounds { displacement_rad: deg(1.0), speed_rad_per_s: deg(2.0) });
    let until = Some(Condition::Displacement { above_rad: deg(1.0) });
    let open = |other| {
        let mut case = case("az", 0.0, vec![ramp(100.0, until, 4.0)]);
        (case.open_loop, case.bounds) = (true, bounds);
        case.start_pose_rad.insert("el".to_owned(), deg(other));
        case
    };
    let found = of(&open(45.0), &rig());
    let stop = found.nearest_stop().expect("it may move");
    assert_eq!((stop.time_s, found.points[0].bounded[0].by), (None, "the bounds of the point"));
    assert!(stop.angle_rad < deg(0.5), "friction stops 2 deg/s at once: {}", stop.angle_rad.to_degrees());
    assert!(refused(&open(45.0), &rig()).is_empty());
    let messages = refused(&open(0.0), &rig());
    assert!(messages[0].contains("axis `el` does not stay at 0 deg"), "{messages:?}");
}

#[test]
fn a_move_after_a_ramp_is_planned_from_both_ends_of_where_the_ramp_may_leave_the_axis() {
    let until = Some(Condition::Displacement { above_rad: deg(5.0) });
    let back = Stimulus::Move { target_rad: deg(0.0), limits: limits(20.0, 45.0) };
    let segments = vec![ramp(100.0, until, 10.0), segment(Mode::Position, back, None, 10.0)];
    let found = of(&case("az", 0.0, segments), &rig());
    let [low, high] = found.points[0].position_rad;
    assert!((low + high).abs() < 1e-9 && high > deg(5.0));
}

#[test]
fn an_elevation_that_rests_high_up_swings_when_it_is_let_go() {
    let found = of(&strokes("el", 0.0, 88.0, 10.0, 20.0, 1), &rig());
    let swing = found.swings.iter().find(|s| s.axis == "el").expect("the spring is stronger than friction");
    assert!(swing.swing.to_rad > deg(0.0) && swing.swing.to_rad < deg(60.0));
    let text = risks(&[found], &rig()).join("\n");
    assert!(text.contains("el: if torque is lost at rest at") && text.contains("mirror"), "{text}");
}

/// Nobody plans where a target goes: what holds the axis are the bounds of the point, on the other axis, too.
#[test]
fn an_axis_that_tracks_is_held_by_the_bounds_of_its_point() {
    let track = |bounds: Option<Bounds>, others: bool| {
        let tracks = Some(procedures::case::Tracks { others, ..Default::default() });
        let hold = segment(Mode::Track, Stimulus::Hold { torque_nm: 0.0 }, None, 20.0);
        Case { bounds, ..case("az", 20.0, vec![Segment { tracks, ..hold }]) }
    };
    let bounds = |displacement: f64, speed: f64| {
        Some(Bounds { displacement_rad: deg(displacement), speed_rad_per_s: deg(speed) })
    };
    let rig = rig();
    let held = of(&track(bounds(30.0, 10.0), false), &rig);
    let point = &held.points[0];
    assert!((point.position_rad[0] - deg(-10.0)).abs() < 1e-9, "{point:?}");
    assert!((point.position_rad[1] - deg(50.0)).abs() < 1e-9, "{point:?}");
    assert!((point.rate_rad_per_s - deg(10.0)).abs() < 1e-9, "{point:?}");
    assert!(held.nearest_stop().expect("it may move").reach_rad > deg(50.0));
    assert!(refused(&track(bounds(30.0, 10.0), false), &rig).is_empty());
    assert!(refused(&track(None, false), &rig)[0].contains("its soft limits are"));
    assert!(refused(&track(bounds(138.8, 10.0), false), &rig)[0].contains("its soft limits are"));
    // Elevation stands at 0 deg: there is no room for 30 deg downwards.
    let both = track(bounds(30.0, 10.0), true);
    let other = envelope("P", "el", std::slice::from_ref(&both), &rig).expect("the rig has the axis");
    assert!((other.points[0].position_rad[0] - deg(-30.0)).abs() < 1e-9);
    assert!(!refuse::refusals(&other, std::slice::from_ref(&both), &rig).is_empty());
    let still = track(bounds(30.0, 10.0), false);
    let other = envelope("P", "el", std::slice::from_ref(&still), &rig).expect("the rig has the axis");
    assert!(other.points[0].rate_rad_per_s == 0.0 && other.nearest_stop().is_none());
}

#[test]
fn an_axis_at_rest_loses_its_torque_only_where_friction_holds_it_with_a_margin() {
    let off = |at: f64| {
        let rest = segment(Mode::Position, Stimulus::Hold { torque_nm: 0.0 }, None, 1.0);
        case("el", at, vec![Segment { then: Then::TorqueOff, ..rest }])
    };
    // 14 N*m cos 40 deg = 10.7 N*m against 39 N*m; at 20 deg 32 N*m, which is more than 39 N*m / 1.3; at 85 deg 41 N*m.
    assert_eq!(refused(&off(40.0), &rig()), [""; 0]);
    for at in [20.0, 85.0] {
        let all = refused(&off(at), &rig());
        assert!(all.iter().any(|m| m.contains("may not stay there")), "{at}: {all:?}");
    }
}
