//! The tick allocates nothing: exchange, decoding, interlocks, sequencer, controllers, encoding, rows to the recorder.
//!
//! What a run allocates before its first and after its last tick does not depend on how long it is: so a long run and a
//! short one, both ending in a trip, must allocate exactly as often. Simulated devices are not counted, neither is the
//! writer's thread. A target of its own, because the counting allocator is the whole program's.

#[path = "allocations/uncounted.rs"]
mod uncounted;

use std::sync::atomic::AtomicU16;

use bench::clock::Clock;
use bench::cycle::axis_loop::AxisLoop;
use bench::cycle::dither::Dither;
use bench::cycle::recorder::{LogHead, Recorder};
use bench::cycle::run::{PointOutcome, run_point};
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::rig::OpenRig;
use procedures::case::{Case, Mode, Segment, Then};
use procedures::log::Plan;
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;
use validation::conditions::of_point;

const LOOP_RATE_HZ: f64 = 4000.0;

/// Moves for a while in every mode, then pushes until an interlock trips.
fn case(moves: usize) -> Case {
    let limits =
        ProfileLimits { velocity_rad_per_s: 0.3, acceleration_rad_per_s2: 0.5, jerk_rad_per_s3: 5.0 };
    let segment = |mode, stimulus, at_most_s, then| Segment {
        stimulus,
        then,
        dithered: mode == Mode::Torque,
        ..Segment::hold("test", mode, at_most_s)
    };
    let there_and_back = [0.2, 0.0]
        .map(|target_rad| segment(Mode::Position, Stimulus::Move { target_rad, limits }, 2.0, Then::Hold));
    let mut segments: Vec<Segment> = there_and_back.iter().cycle().take(2 * moves).cloned().collect();
    segments.push(segment(Mode::Torque, Stimulus::Hold { torque_nm: 50.0 }, 0.5, Then::Hold));
    segments.push(segment(Mode::Torque, Stimulus::Hold { torque_nm: 1500.0 }, 10.0, Then::Hold));
    Case {
        point: "1".to_owned(),
        axis: "az".to_owned(),
        start_pose_rad: [("az".to_owned(), 0.0), ("el".to_owned(), 0.3)].into(),
        segments,
        ..Case::default()
    }
}

/// Allocations of this thread in one run, and how it ended.
fn allocations(moves: usize) -> (u64, PointOutcome) {
    let rig_file = read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("it parses");
    let case = case(moves);
    let plan = Plan {
        schema: 1,
        procedure: "TEST".to_owned(),
        axis: "az".to_owned(),
        seed: 1,
        loop_rate_hz: LOOP_RATE_HZ,
        log_rate_hz: LOOP_RATE_HZ,
        command_delay_ticks: 1,
        axes: rig_file.limits(),
        cases: vec![case.clone()],
        mode: "simulated".to_owned(),
    };
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("log.mcap");
    let mut recorder = Recorder::start(&path, LogHead::new(&plan, &rig_file), true).expect("a new file");
    let gains = parameters::load(&rig_file).expect("shipped parameters");
    let address = SeedAddress { seed: 1, procedure: "TEST".to_owned(), point: "1".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: 0.3, heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(&UnitSettings::default(), &address, start);
    let mut rig = OpenRig::open(uncounted::wires(&simulated), &rig_file, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let loops = AxisLoop::of_rig(&rig_file, &gains);
    let stop = AtomicU16::new(0);
    let conditions = of_point(&case, &stop);
    let dither = Dither::new(&plan, "1", 0.12);
    let mut outcome = None;
    let counted = allocation_counter::measure(|| {
        outcome = Some(run_point(&mut rig, loops, conditions, dither, &mut recorder));
    });
    recorder.finish().expect("a writable log");
    (counted.count_total, outcome.expect("it ran"))
}

#[test]
fn the_counter_counts_and_the_devices_may_be_left_out() {
    let counted = allocation_counter::measure(|| {
        std::hint::black_box(vec![1_u8; 100]);
        allocation_counter::opt_out(|| drop(std::hint::black_box(vec![1_u8; 100])));
    });
    assert_eq!(counted.count_total, 1);
}

#[test]
fn thousands_of_ticks_and_a_trip_allocate_nothing() {
    let (short, first) = allocations(1);
    let (long, second) = allocations(4);
    for outcome in [&first, &second] {
        assert!(outcome.trip.is_some() && outcome.safe.standstill, "{outcome:?}");
    }
    let ticks = ((second.loop_s - first.loop_s) * LOOP_RATE_HZ) as u64;
    assert!(ticks > 20_000, "{ticks} ticks more");
    assert_eq!(long, short, "allocations of {ticks} ticks more, three rounds of moves more");
    // Tasks, sequencer, memory of the interlocks, brakes and the words of the outcome: before the first tick and after the
    // last one.
    assert!(short <= AROUND, "{short} allocations around the loop");
}

/// What a run may allocate before its first and after its last tick.
const AROUND: u64 = 40;
