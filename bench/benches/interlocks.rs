//! What all interlocks of both axes cost in a tick of a moving rig. Allowed (ours): 2.5 µs at the median.
#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::time::Duration;

use bench::clock::{Clock, Stopwatch};
use bench::cycle::axis_loop::AxisLoop;
use bench::cycle::interlock::{INTERLOCKS, Situation, Watch, per_axis};
use bench::cycle::sequence::{PointOrder, Sequencer};
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::model::rig::Rig;
use bench::rig::OpenRig;
use bench::rig::wires::Wires;
use procedures::case::{Bounds, Case, Mode, Segment};
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

const PERIOD: Duration = Duration::from_micros(250);
const ALLOWED_US: f64 = 2.5;

/// Azimuth slews with 60 deg/s; elevation holds.
fn case() -> Case {
    let limits = ProfileLimits {
        velocity_rad_per_s: 60_f64.to_radians(),
        acceleration_rad_per_s2: 60_f64.to_radians(),
        jerk_rad_per_s3: 600_f64.to_radians(),
    };
    let there = |target_rad: f64| Segment {
        stimulus: Stimulus::Move { target_rad, limits },
        ..Segment::hold("move", Mode::Position, 8.0)
    };
    Case {
        point: "1".to_owned(),
        axis: "az".to_owned(),
        start_pose_rad: [("az".to_owned(), 0.0), ("el".to_owned(), 0.5)].into(),
        segments: [2.5, -2.5, 2.5, -2.5].map(there).into(),
        ..Case::default()
    }
}

fn main() {
    let source = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig");
    let rig_file = read_rig(source).expect("a valid rig");
    let (p50_us, p99_us) = quantiles(measured(&rig_file));
    println!("{} interlocks, both axes: p50 {p50_us:.3} us, p99 {p99_us:.3} us a tick", INTERLOCKS.len());
    let (coast_us, _) = quantiles(coasts(&rig_file));
    println!("a coast angle by angle, where end stops take too little: p50 {coast_us:.3} us an axis on top");
    assert!(p50_us <= ALLOWED_US, "the interlocks may cost {ALLOWED_US} us");
}

/// Median and 99th percentile.
fn quantiles(mut times_us: Vec<f64>) -> (f64, f64) {
    times_us.sort_by(f64::total_cmp);
    let at = |share: f64| times_us[(share * (times_us.len() - 1) as f64) as usize];
    (at(0.5), at(0.99))
}

/// How long the exact coast takes, µs: a rig with bare stops needs it while it moves.
fn coasts(rig_file: &Rig) -> Vec<f64> {
    let stop = &rig_file.axes[0].guard.stop;
    let once = |k: u32| {
        let stopwatch = Stopwatch::start();
        black_box(stop.coast(black_box(1e-4 * f64::from(k)), 1.0));
        1e6 * stopwatch.elapsed_s()
    };
    (0..10_000).map(once).collect()
}

/// How long each tick's look takes, µs; the clock's own reading is in it.
fn measured(rig_file: &Rig) -> Vec<f64> {
    let gains = parameters::load(rig_file).expect("shipped parameters");
    let address = SeedAddress { seed: 1, procedure: "BENCH".to_owned(), point: "1".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: 0.5, heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(&UnitSettings::default(), &address, start);
    let mut rig = OpenRig::open(Wires::simulated(&simulated), rig_file, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let loops = AxisLoop::of_rig(rig_file, &gains);
    let case = case();
    let order = PointOrder {
        case: &case,
        point: 0,
        moving: 0,
        questions: [].into(),
        parks: false,
        loop_rate_hz: 4000.0,
    };
    let mut sequencer = Sequencer::new(order, loops);
    sequencer.begin(rig.ready());
    let mut watch = Watch::new(PERIOD.as_secs_f64());
    let mut now = rig.ready();
    let mut times_us = Vec::new();
    while !sequencer.finished() {
        rig.exchange(now);
        let operates = sequencer.expects_operation();
        let situation = Situation {
            waits_for_inputs: sequencer.waits_for_inputs(),
            expects_operation: operates,
            uses_feedback: operates,
            following_error_rad: per_axis(2, |axis| sequencer.axis_loop(axis).following_error_rad()),
            sent_nm: per_axis(2, |axis| sequencer.axis_loop(axis).sent_nm()),
            bounds: Some(Bounds { displacement_rad: 6.0, speed_rad_per_s: 2.0 }),
            max_missed_periods: 20,
            ..Situation::default()
        };
        let stopwatch = Stopwatch::start();
        let trip = black_box(watch.tick(black_box(&rig), &situation, None));
        let took_us = 1e6 * stopwatch.elapsed_s();
        assert!(trip.is_none(), "{trip:?}");
        if operates {
            times_us.push(took_us);
        }
        sequencer.step(now, &mut rig, &mut || 0.0, &mut |_| {}).expect("drives that follow");
        now += PERIOD;
    }
    times_us
}
