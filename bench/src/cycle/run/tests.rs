use std::collections::BTreeMap;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use procedures::case::{Case, Condition, Mode, Segment, Then};
use procedures::log::{LogReader, Plan, PointStatus, Window};
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use super::*;
use crate::cycle::dither::Dither;
use crate::cycle::recorder::LogHead;
use crate::files::parameters;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::model::rig::Rig;
use crate::rig::OpenRig;
use crate::rig::wires::Wires;

mod endings;
mod gyros;
mod instruments;
mod late;
mod tracks;

fn sim() -> Rig {
    read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("a shipped rig parses")
}

fn segment(mode: Mode, stimulus: Stimulus, at_most_s: f64, then: Then) -> Segment {
    Segment { stimulus, then, ..Segment::hold("test", mode, at_most_s) }
}

fn case(segments: Vec<Segment>) -> Case {
    Case {
        point: "one".to_owned(),
        axis: "az".to_owned(),
        requested: Vec::new(),
        start_pose_rad: BTreeMap::from([("az".to_owned(), 0.0), ("el".to_owned(), 0.0)]),
        segments,
        ..Case::default()
    }
}

fn slow_move(target_rad: f64) -> Stimulus {
    let limits =
        ProfileLimits { velocity_rad_per_s: 0.2, acceleration_rad_per_s2: 0.5, jerk_rad_per_s3: 5.0 };
    Stimulus::Move { target_rad, limits }
}

/// What a run stands on beside its case.
struct Bed<'a> {
    rig_file: Rig,
    unit: &'a UnitSettings,
    gates: &'a [(String, Limit)],
    /// What a signal would set.
    stop: u16,
    /// The clock of the loop, by the time of its first tick.
    clock: &'a dyn Fn(Duration) -> Clock,
    /// What stands between the bench and the simulated rig.
    wires: &'a dyn Fn(Wires) -> Wires,
}

impl<'a> Bed<'a> {
    fn on(unit: &'a UnitSettings) -> Self {
        let clock = &|_| Clock::Virtual;
        let wires = &|wires| wires;
        Self { rig_file: sim(), unit, gates: &[], stop: 0, clock, wires }
    }
}

/// Runs one case on the simulated rig; `stop` is what a signal would set. Gives the outcome and what was logged.
fn run_case(
    case: &Case,
    unit: &UnitSettings,
    gates: &[(String, Limit)],
    stop: u16,
) -> (PointOutcome, Window) {
    run_on(case, &Bed { gates, stop, ..Bed::on(unit) })
}

fn run_on(case: &Case, bed: &Bed<'_>) -> (PointOutcome, Window) {
    let rig_file = &bed.rig_file;
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("log.mcap");
    let plan = Plan {
        schema: 1,
        procedure: "TEST".to_owned(),
        axis: "az".to_owned(),
        seed: 1,
        loop_rate_hz: 4000.0,
        log_rate_hz: 1000.0,
        command_delay_ticks: 1,
        axes: rig_file.limits(),
        cases: vec![case.clone()],
        mode: "simulated".to_owned(),
    };
    let mut recorder = Recorder::start(&path, LogHead::new(&plan, rig_file), true).expect("a new file");
    let address = SeedAddress { seed: 1, procedure: "TEST".to_owned(), point: "one".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(bed.unit, &address, start);
    let gains = parameters::load(rig_file).expect("shipped parameters");
    let wires = (bed.wires)(Wires::simulated(&simulated));
    let mut rig = OpenRig::open(wires, rig_file, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let loops = AxisLoop::of_rig(rig_file, &gains);
    let stop = AtomicU16::new(bed.stop);
    let conditions = Conditions {
        point: 0,
        case,
        moving: 0,
        log_start_ns: 1_000_000_000,
        loop_rate_hz: 4000.0,
        log_every: 1,
        log_payload_every: 8,
        max_missed_periods: rig_file.max_missed_periods,
        gates: bed.gates,
        questions: [].into(),
        parks: false,
        stop: &stop,
        clock: (bed.clock)(rig.ready()),
        progress: std::sync::Arc::default(),
    };
    let dither = Dither::new(&plan, "one", 0.12);
    let outcome = run_point(&mut rig, loops, conditions, dither, &mut recorder);
    recorder.finish().expect("a writable log");
    let window = LogReader::open(&path).expect("our log").next_window().expect("one point");
    (outcome, window)
}

fn column<'w>(window: &'w Window, topic: &str, channel: &str) -> &'w [f64] {
    window.rows(topic).expect("a topic of the rig").column(channel).expect("a channel of the rig")
}

#[test]
fn a_move_arrives_and_the_rig_is_left_at_standstill() {
    let wanted = case(vec![segment(Mode::Position, slow_move(0.3), 5.0, Then::Hold)]);
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    assert!(outcome.safe.standstill, "{:?}", outcome.safe);
    let last = *column(&window, "/az", "position_rad").last().expect("rows");
    assert!((last - 0.3).abs() < 2e-3, "ended at {last} rad");
    assert_eq!(window.segments.len(), 1);
}

#[test]
fn a_signal_in_motion_stops_the_axis_inside_its_limits_and_keeps_the_log() {
    let wanted = case(vec![segment(Mode::Position, slow_move(1.0), 20.0, Then::Hold)]);
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 130);
    assert_eq!(outcome.status, PointStatus::Aborted);
    assert_eq!(outcome.signal, Some(130));
    assert!(outcome.safe.standstill);
    assert_eq!(window.status, PointStatus::Aborted);
}

#[test]
fn a_runaway_torque_trips_an_interlock_and_the_stop_stays_inside_the_travel() {
    let push = Stimulus::Hold { torque_nm: 1500.0 };
    let wanted = case(vec![segment(Mode::Torque, push, 10.0, Then::Hold)]);
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    let trip = outcome.trip.expect("1500 N*m is far above friction");
    assert!(["velocity", "braking curve"].contains(&trip.interlock), "{trip:?}");
    assert!(outcome.safe.standstill, "{:?}", outcome.safe);
    let farthest = column(&window, "/az", "position_rad").iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    assert!(farthest < 160.0_f64.to_radians(), "reached {} deg", farthest.to_degrees());
    assert_eq!(window.trips.len(), 1, "{:?}", window.trips);
}

#[test]
fn a_ramp_ends_on_the_displacement_it_was_to_wait_for() {
    let mut ramp =
        segment(Mode::Torque, Stimulus::TorqueRamp { from_nm: 0.0, rate_nm_per_s: 60.0 }, 10.0, Then::Hold);
    ramp.until = Some(Condition::Displacement { above_rad: 0.02 });
    ramp.dithered = true;
    let (outcome, window) = run_case(&case(vec![ramp]), &UnitSettings::default(), &[], 0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    assert_eq!(window.segments[0].ended_by, EndedBy::Condition);
    let lasted_s = window.segments[0].end_s - window.segments[0].start_s;
    // 210 N*m of static friction at 60 N*m/s: breakaway after 3.5 s.
    assert!((3.0..5.0).contains(&lasted_s), "lasted {lasted_s} s");
}

#[test]
fn a_closed_gate_refuses_before_anything_moves() {
    let limit = procedures::quantity::QuantityKind::Temperature.parse_limit("< 30 degC").expect("a limit");
    let wanted = case(vec![segment(Mode::Position, slow_move(0.3), 5.0, Then::Hold)]);
    let gates = [("heat-sink".to_owned(), limit)];
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &gates, 0);
    let reason = outcome.refused.expect("ambient is 40 degC");
    assert!(reason.contains("expected < 30 degC, found 40"), "{reason}");
    let moved = column(&window, "/az", "position_rad").iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    // The contact gives way elastically to the cogging torque: at most 8.45 N*m over 90 000 N*m/rad.
    assert!(moved < 9.4e-5, "moved {moved} rad");
    assert!(window.segments.is_empty());
}

/// From 40 degC towards 30 degC with a time constant of 300 s: below 39.95 degC, which reads 39.9, after 1.5 s.
#[test]
fn a_warm_heat_sink_is_waited_for_without_motion_and_not_longer_than_was_said() {
    let limit = procedures::quantity::QuantityKind::Temperature.parse_limit("< 39.95 degC").expect("a limit");
    let gates = [("heat-sink".to_owned(), limit)];
    let mut unit = UnitSettings::default();
    (unit.az.ambient_degc, unit.el.ambient_degc) = (30.0, 30.0);
    let waits = |cool_down_s| {
        let wanted = case(vec![segment(Mode::Position, slow_move(0.1), 3.0, Then::Hold)]);
        run_case(&Case { cool_down_s: Some(cool_down_s), ..wanted }, &unit, &gates, 0)
    };
    let (outcome, window) = waits(20.0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    let rows = window.rows("/az").expect("azimuth");
    let time = &rows.time_s;
    let sink = column(&window, "/az", "heat_sink_degc");
    let begun = time.iter().position(|&t| t >= window.segments[0].start_s).expect("it moved");
    assert!(sink[begun] < 39.95, "{}", sink[begun]);
    assert!(window.segments[0].start_s - time[0] > 1.0, "it waited");
    let (outcome, window) = waits(0.5);
    assert!(outcome.refused.is_some_and(|reason| reason.contains("expected < 39.95 degC")));
    assert!(window.segments.is_empty());
}

/// Rows in which the loop had finished: from there on no torque may be asked for.
fn torque_when_finished(window: &Window) -> f64 {
    const FINISHED: f64 = 6.0;
    let states = column(window, "/bench", "state");
    let rows: Vec<usize> = (0..states.len()).filter(|&row| states[row] == FINISHED).collect();
    assert!(!rows.is_empty(), "every tick of this test is logged");
    let torques = ["/az", "/el"].map(|topic| {
        let asked = column(window, topic, "torque_command_nm");
        rows.iter().fold(0.0_f64, |most, &row| most.max(asked[row].abs()))
    });
    torques[0].max(torques[1])
}

#[test]
fn once_finished_no_torque_is_asked_for_whatever_the_last_segment_was() {
    for then in [Then::Next, Then::Hold, Then::Stop] {
        let wanted = case(vec![segment(Mode::Position, slow_move(0.3), 5.0, then)]);
        let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
        assert_eq!(outcome.status, PointStatus::Completed, "{then:?}: {outcome:?}");
        assert_eq!(torque_when_finished(&window), 0.0, "{then:?}");
    }
}

#[test]
fn a_refused_point_asks_for_no_torque() {
    let limit = procedures::quantity::QuantityKind::Temperature.parse_limit("< 30 degC").expect("a limit");
    let mut wanted = case(vec![segment(Mode::Position, slow_move(0.3), 5.0, Then::Hold)]);
    wanted.start_pose_rad.insert("el".to_owned(), 0.9);
    let (_, window) = run_case(&wanted, &UnitSettings::default(), &[("heat-sink".to_owned(), limit)], 0);
    assert_eq!(torque_when_finished(&window), 0.0);
}

#[test]
fn a_second_sigint_leaves_the_controlled_stop_and_quick_stops() {
    let wanted = case(vec![segment(Mode::Position, slow_move(1.0), 20.0, Then::Hold)]);
    let (outcome, _) = run_case(&wanted, &UnitSettings::default(), &[], STOP_AT_ONCE | 130);
    assert!(outcome.safe.standstill, "{:?}", outcome.safe);
    assert_ne!(outcome.status, PointStatus::Completed);
}

/// Positive feedback on either axis: the stop must not use the sensor that is wrong.
#[test]
fn a_gyro_of_the_wrong_sign_trips_at_little_speed_and_no_end_stop_is_touched() {
    let mut unit = UnitSettings::default();
    unit.imu.gyro_sign_factor = [-1.0; 3];
    let wanted = case(vec![segment(Mode::Position, slow_move(0.3), 5.0, Then::Hold)]);
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    assert_eq!(outcome.trip.map(|t| t.interlock), Some("rate disagreement"), "{outcome:?}");
    assert_eq!((outcome.status, outcome.safe.standstill), (PointStatus::Aborted, true), "{outcome:?}");
    for axis in ["/az", "/el"] {
        let fastest = column(&window, axis, "velocity_rad_per_s").iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        assert!(fastest < 5.0_f64.to_radians(), "{axis} reached {fastest} rad/s");
    }
}

#[test]
fn gyros_that_have_just_been_powered_are_waited_for_before_anything_is_enabled() {
    let mut unit = UnitSettings::default();
    unit.imu.startup_s = 1.5;
    let wanted = case(vec![segment(Mode::Position, slow_move(0.1), 5.0, Then::Hold)]);
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    let states = column(&window, "/bench", "state");
    let times = &window.rows("/bench").expect("the loop").time_s;
    let enabling = states.iter().position(|s| *s >= 2.0).expect("it came to enabling");
    assert!(times[enabling] - times[0] > 1.3, "enabled after {} s", times[enabling] - times[0]);
}

#[test]
fn gyros_that_never_become_valid_end_the_point_before_anything_is_enabled() {
    let mut unit = UnitSettings::default();
    unit.imu.startup_s = 500.0;
    let wanted = case(vec![segment(Mode::Position, slow_move(0.1), 5.0, Then::Hold)]);
    let (outcome, window) = run_case(&wanted, &unit, &[], 0);
    assert_eq!(outcome.status, PointStatus::Errored);
    assert!(outcome.error.is_some_and(|e| e.to_string().contains("no valid rates from the gyros")));
    assert!(column(&window, "/az", "torque_nm").iter().all(|t| t.abs() < 10.0));
}

/// The braking of a fast move is taken over where it stands: no torque step when the stop begins.
#[test]
fn a_stop_ordered_in_full_braking_begins_without_a_torque_step() {
    let limits =
        ProfileLimits { velocity_rad_per_s: 1.0, acceleration_rad_per_s2: 1.5, jerk_rad_per_s3: 15.0 };
    let fast = Stimulus::Move { target_rad: 2.0, limits };
    // Cut off while it brakes with all it has.
    let wanted = case(vec![segment(Mode::Position, fast, 2.2, Then::Stop)]);
    let (outcome, window) = run_case(&wanted, &UnitSettings::default(), &[], 0);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    let torque = column(&window, "/az", "torque_command_nm");
    assert!(torque.iter().any(|t| *t < -1000.0), "it must be braking hard");
    let largest = torque.windows(2).map(|t| (t[1] - t[0]).abs()).fold(0.0, f64::max);
    assert!(largest < 250.0, "a step of {largest} N·m");
}

/// The drive's own quick stop is positive feedback, too: its torque must be taken away.
#[test]
fn an_encoder_of_the_wrong_sign_ends_at_standstill_without_torque() {
    for axis in [0, 1] {
        let mut unit = UnitSettings::default();
        let settings = if axis == 0 { &mut unit.az } else { &mut unit.el };
        settings.encoder_sign_factor = -1.0;
        let wanted = case(vec![segment(Mode::Position, slow_move(0.3), 5.0, Then::Hold)]);
        let (outcome, window) = run_case(&wanted, &unit, &[], 0);
        assert!(outcome.trip.is_some() && outcome.safe.standstill, "{outcome:?}");
        for axis in ["/az", "/el"] {
            let speeds = column(&window, axis, "velocity_rad_per_s").iter().map(|v| v.abs());
            let fastest = speeds.fold(0.0, f64::max);
            assert!(fastest < 15.0_f64.to_radians(), "{axis} reached {fastest} rad/s");
        }
    }
}
