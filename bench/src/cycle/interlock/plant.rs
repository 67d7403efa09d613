//! Interlocks against the simulated director.

use std::time::Duration;

use procedures::case::{Case, Mode, Segment, Then};
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use super::{Situation, Trip, Watch, per_axis};
use crate::clock::Clock;
use crate::cycle::axis_loop::AxisLoop;
use crate::cycle::safe::{Exit, make_safe};
use crate::cycle::sequence::{PointOrder, Sequencer};
use crate::cycle::stops::Stops;
use crate::files::parameters;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::files::unit::load_unit;
use crate::rig::wires::Wires;
use crate::rig::{ArmedRig, OpenRig};

const PERIOD: Duration = Duration::from_micros(250);

/// What came of a run.
struct Outcome {
    trip: Option<Trip>,
    /// Elevation from first to last, and its largest speed.
    reached_rad: [f64; 2],
    fastest_rad_per_s: f64,
    /// What a stop could rely on in the end.
    deceleration_rad_per_s2: f64,
    standstill: bool,
}

fn slew(from_deg: f64, to_deg: f64) -> Case {
    let limits = ProfileLimits {
        velocity_rad_per_s: 60_f64.to_radians(),
        acceleration_rad_per_s2: 90_f64.to_radians(),
        jerk_rad_per_s3: 900_f64.to_radians(),
    };
    let slew = Segment {
        label: "slew".to_owned(),
        mode: Mode::Position,
        stimulus: Stimulus::Move { target_rad: to_deg.to_radians(), limits },
        until: None,
        at_most_s: 6.0,
        then: Then::Stop,
        dithered: false,
        ..Segment::default()
    };
    Case {
        point: "slew".to_owned(),
        axis: "el".to_owned(),
        start_pose_rad: [("az".to_owned(), 0.0), ("el".to_owned(), from_deg.to_radians())].into(),
        segments: vec![slew],
        ..Case::default()
    }
}

/// Runs a case on elevation under the interlocks, that of the following error or not, then brings the rig to rest.
fn run(unit: &UnitSettings, case: &Case, following: bool) -> Outcome {
    let rig_file = read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("it parses");
    let gains = parameters::load(&rig_file).expect("shipped parameters");
    let address = SeedAddress { seed: 1, procedure: "TEST".to_owned(), point: case.point.clone() };
    let start = StartState { az_rad: 0.0, el_rad: case.start_pose_rad["el"], heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(unit, &address, start);
    let mut rig = OpenRig::open(Wires::simulated(&simulated), &rig_file, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let loops = AxisLoop::of_rig(&rig_file, &gains);
    let order =
        PointOrder { case, point: 0, moving: 1, questions: [].into(), parks: false, loop_rate_hz: 4000.0 };
    let mut sequencer = Sequencer::new(order, loops);
    sequencer.begin(rig.ready());
    let mut watch = Watch::new(PERIOD.as_secs_f64());
    let mut now = rig.ready();
    let mut trip = None;
    let mut reached_rad = [start.el_rad; 2];
    let mut fastest = 0.0_f64;
    let mut see = |rig: &ArmedRig| {
        if rig.age_ticks(1) == 0 {
            let seen = rig.actuals(1);
            reached_rad = [reached_rad[0].min(seen.position_rad), reached_rad[1].max(seen.position_rad)];
            fastest = fastest.max(seen.velocity_rad_per_s.abs());
        }
    };
    while !sequencer.finished() {
        rig.exchange(now);
        see(&rig);
        let situation = Situation {
            waits_for_inputs: sequencer.waits_for_inputs(),
            expects_operation: sequencer.expects_operation(),
            uses_feedback: sequencer.expects_operation() && trip.is_none(),
            following_error_rad: per_axis(2, |axis| {
                sequencer.axis_loop(axis).following_error_rad().filter(|_| following && trip.is_none())
            }),
            sent_nm: per_axis(2, |axis| sequencer.axis_loop(axis).sent_nm()),
            max_missed_periods: 20,
            ..Situation::default()
        };
        if let Some(first) = watch.tick(&rig, &situation, trip.as_ref()) {
            if trip.is_some() || !first.steerable {
                sequencer.abandon();
            } else {
                sequencer.stop(now, &rig, |axis| watch.deceleration_rad_per_s2(&rig, axis));
            }
            trip.get_or_insert(first);
        }
        sequencer.step(now, &mut rig, &mut || 0.0, &mut |_| {}).expect("drives that follow");
        now += PERIOD;
    }
    let exit = Exit { clock: &Clock::Virtual, from: now, period: PERIOD, open_loop: false };
    let safe = make_safe(&mut rig, &exit, &mut Stops::new(2), |rig, _| see(rig));
    Outcome {
        trip,
        reached_rad,
        fastest_rad_per_s: fastest,
        deceleration_rad_per_s2: watch.deceleration_rad_per_s2(&rig, 1),
        standstill: safe.standstill,
    }
}

/// 421 N·m instead of 1882: the slew that it is asked for would end in the end stop if its brakes were believed in.
#[test]
fn an_undersized_motor_is_braked_early_enough_for_what_it_gives() {
    let unit = load_unit("motor-undersized").expect("a shipped defect");
    let unit = unit.director().expect("a director").clone();
    for (from_deg, to_deg) in [(-5.0, 85.0), (85.0, -5.0)] {
        let outcome = run(&unit, &slew(from_deg, to_deg), false);
        let relied_on = outcome.deceleration_rad_per_s2.to_degrees();
        assert!((20.0..25.0).contains(&relied_on), "the motor has shown 421 N·m: {relied_on} deg/s²");
        assert_eq!(outcome.trip.map(|t| t.interlock), Some("braking curve"), "{:?}", outcome.trip);
        assert!(outcome.fastest_rad_per_s.to_degrees() > 30.0, "it was fast enough to matter");
        let [low, high] = outcome.reached_rad.map(f64::to_degrees);
        assert!(low > -9.5 && high < 89.5, "{from_deg}..{to_deg}: reached {low} .. {high} deg");
        assert!(outcome.standstill);
    }
}

/// The command waits for it instead of running away from it: what trips is that it could not stop in time.
#[test]
fn an_undersized_motor_is_waited_for_and_trips_before_it_is_too_fast_to_be_stopped() {
    let unit = load_unit("motor-undersized").expect("a shipped defect");
    let unit = unit.director().expect("a director").clone();
    let outcome = run(&unit, &slew(-5.0, 85.0), true);
    assert_eq!(outcome.trip.map(|t| t.interlock), Some("braking curve"), "{:?}", outcome.trip);
    assert!(outcome.fastest_rad_per_s.to_degrees() > 30.0, "it was fast enough to matter");
    assert!(outcome.reached_rad[1].to_degrees() < 89.5 && outcome.standstill);
}

#[test]
fn the_nominal_motor_makes_the_same_slew_without_a_trip() {
    let outcome = run(&UnitSettings::default(), &slew(-5.0, 85.0), true);
    assert_eq!(outcome.trip, None);
    assert!((outcome.deceleration_rad_per_s2.to_degrees() - 100.0).abs() < 1e-9);
    assert!(outcome.standstill && outcome.fastest_rad_per_s.to_degrees() > 59.0);
}
