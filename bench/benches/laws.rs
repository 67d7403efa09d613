//! What an external velocity law costs: time for each tick of the loop, on the whole simulated director and for the two axis
//! loops alone, and how fast it answers from a process of its own where time is real. Needs the command `cc`.
#![allow(clippy::print_stdout)]

use std::sync::atomic::AtomicU16;
use std::sync::mpsc::channel;
use std::time::Duration;

use bench::clock::{Clock, Stopwatch};
use bench::cycle::axis_loop::AxisLoop;
use bench::cycle::dither::Dither;
use bench::cycle::laws::{Law, Laws};
use bench::cycle::recorder::Recorder;
use bench::cycle::run::{Conditions, run_point};
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::model::rig::Rig;
use bench::realtime::Rights;
use bench::rig::OpenRig;
use bench::rig::wires::Wires;
use drivers::cia402::Actuals;
use procedures::case::{Case, Mode, Segment};
use procedures::log::Plan;
use procedures::stimulus::{ProfileLimits, Setpoint, Stimulus};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;
use validation::compiled;
use validation::conditions::of_point;

/// Rounds of each sort of law, taken in turn; the best one counts, because others only disturb.
const ROUNDS: usize = 9;
const SIMULATED_S: f64 = 10.0;
/// Ticks of the axis loops alone.
const TICKS: u32 = 200_000;
/// Ticks in real time.
const REAL_TICKS: u32 = 40_000;
/// Deadline while answers are timed: late ones are to be counted, not to end the measurement.
const PATIENCE: Duration = Duration::from_secs(10);

/// Both axes by a law.
fn laws(law: &Law) -> Laws {
    let mut laws = Laws::default();
    for axis in ["az", "el"] {
        laws.insert(axis, law.clone());
    }
    laws
}

/// Azimuth goes there and back; elevation holds.
fn case() -> Case {
    let limits =
        ProfileLimits { velocity_rad_per_s: 0.3, acceleration_rad_per_s2: 0.5, jerk_rad_per_s3: 5.0 };
    let there = |target_rad: f64| Segment {
        stimulus: Stimulus::Move { target_rad, limits },
        ..Segment::hold("move", Mode::Position, SIMULATED_S / 2.0)
    };
    Case {
        point: "1".to_owned(),
        axis: "az".to_owned(),
        start_pose_rad: [("az".to_owned(), 0.0), ("el".to_owned(), 0.5)].into(),
        segments: [1.0, -1.0].map(there).into(),
        ..Case::default()
    }
}

/// Time for each tick of a point on the simulated director, µs.
fn whole_us(rig: &Rig, laws: &Laws) -> f64 {
    let case = case();
    let gains = parameters::load(rig).expect("shipped parameters");
    let plan = Plan {
        schema: 1,
        procedure: "BENCH".to_owned(),
        axis: "az".to_owned(),
        seed: 1,
        loop_rate_hz: rig.loop_rate_hz,
        log_rate_hz: rig.loop_rate_hz,
        command_delay_ticks: 1,
        axes: rig.limits(),
        cases: vec![case.clone()],
        mode: "simulated".to_owned(),
    };
    let address = SeedAddress { seed: 1, procedure: "BENCH".to_owned(), point: "1".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: 0.5, heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(&UnitSettings::default(), &address, start);
    let mut armed = OpenRig::open(Wires::simulated(&simulated), rig, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let loops = AxisLoop::of_rig_with(rig, &gains, laws, None).expect("sound laws");
    let stop = AtomicU16::new(0);
    let conditions = Conditions { loop_rate_hz: rig.loop_rate_hz, ..of_point(&case, &stop) };
    let dither = Dither::new(&plan, "1", 0.12);
    let watch = Stopwatch::start();
    let outcome = run_point(&mut armed, loops, conditions, dither, &mut Recorder::discarding());
    let took_s = watch.elapsed_s();
    assert!(outcome.trip.is_none() && outcome.error.is_none(), "{outcome:?}");
    1e6 * took_s / (outcome.loop_s * rig.loop_rate_hz)
}

/// Time for each tick of the two axis loops alone, µs.
fn alone_us(rig: &Rig, laws: &Laws) -> f64 {
    let gains = parameters::load(rig).expect("shipped parameters");
    let mut loops = AxisLoop::of_rig_with(rig, &gains, laws, None).expect("sound laws");
    let actuals = Actuals::default();
    for axis_loop in &mut loops {
        axis_loop.enter(&Segment::hold("rate", Mode::Velocity, 1.0), 0.0);
    }
    let watch = Stopwatch::start();
    let mut sum_nm = 0.0;
    for tick in 0..TICKS {
        let rate_rad_per_s = 1e-3 * f64::from(tick % 17);
        let wanted = Setpoint { velocity_rad_per_s: 1e-3 * f64::from(tick % 13), ..Setpoint::default() };
        for axis_loop in &mut loops {
            let torque_nm = axis_loop.torque(&actuals, rate_rad_per_s, Some(&wanted));
            axis_loop.sent(torque_nm);
            sum_nm += torque_nm;
        }
    }
    std::hint::black_box(sum_nm);
    1e6 * watch.elapsed_s() / f64::from(TICKS)
}

/// Times for the answer of a law of azimuth in real time, sorted, µs, and the rights of the thread that asks. As in a session, the
/// process of the law is started by another thread: it would be bound to the same processor otherwise.
fn answers_us(rig: &Rig, laws: &Laws) -> (Vec<f64>, Rights) {
    let gains = parameters::load(rig).expect("shipped parameters");
    let (bound, ticks_on) = channel();
    let (made, loops) = channel();
    std::thread::scope(|scope| {
        let asking = scope.spawn(move || {
            let rights = Rights::ask();
            bound.send(rights.processor).expect("the thread that starts the law waits for it");
            let loops = loops.recv().expect("sound laws");
            (timed_answers_us(rig.loop_rate_hz, loops), rights)
        });
        let ticks_on = ticks_on.recv().expect("asking panics nowhere");
        let loops = AxisLoop::of_rig_with(rig, &gains, laws, ticks_on).expect("sound laws");
        made.send(loops).expect("the thread that asks waits for them");
        asking.join().expect("no panic while answers are timed")
    })
}

fn timed_answers_us(loop_rate_hz: f64, mut loops: Vec<AxisLoop>) -> Vec<f64> {
    let az = &mut loops[0];
    az.enter(&Segment::hold("rate", Mode::Velocity, 1.0), 0.0);
    let actuals = Actuals::default();
    let period = Duration::from_secs_f64(1.0 / loop_rate_hz);
    let clock = Clock::real();
    let mut times_us = Vec::new();
    for tick in 1..=REAL_TICKS {
        clock.wait_until(period * tick);
        let watch = Stopwatch::start();
        let torque_nm = az.torque(&actuals, 1e-3, None);
        times_us.push(1e6 * watch.elapsed_s());
        az.sent(torque_nm);
    }
    times_us.sort_by(f64::total_cmp);
    times_us
}

/// Prints how fast a law answers where time is real.
fn print_answers(rig: &Rig, law: &Law) {
    let mut laws = Laws::default();
    laws.insert("az", law.clone());
    let (times_us, rights) = answers_us(rig, &laws);
    let at = |share: f64| times_us[((times_us.len() - 1) as f64 * share) as usize];
    let limit_us = 1e6 * rig.law_deadline_s;
    let late = times_us.iter().filter(|&&time_us| time_us > limit_us).count();
    println!(
        "answer in real time at {:.0} Hz: p50 {:.2} us, p99 {:.2} us, p99.9 {:.2} us, largest {:.1} us; {late} of {} above {limit_us:.0} us",
        rig.loop_rate_hz,
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0),
        times_us.len(),
    );
    for grant in &rights.grants {
        println!("  {}: {}", grant.what, grant.found);
    }
}

fn main() {
    let rig =
        read_rig(shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig")).expect("a valid rig");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let library = compiled::c_example(folder.path());
    let hosted = compiled::hosted(&library, env!("CARGO_BIN_EXE_bench"), None);
    let sorts = [
        ("built in", Laws::default()),
        ("external, in process", laws(&compiled::in_process(&library))),
        ("external, process of its own", laws(&hosted)),
    ];
    let mut best = [[f64::INFINITY; 2]; 3];
    for _ in 0..ROUNDS {
        for (best, (_, laws)) in best.iter_mut().zip(&sorts) {
            *best = [best[0].min(whole_us(&rig, laws)), best[1].min(alone_us(&rig, laws))];
        }
    }
    println!("time for each tick, both axes by the law, best of {ROUNDS}");
    for ((name, _), [whole_us, alone_us]) in sorts.iter().zip(best) {
        let more = 100.0 * (whole_us / best[0][0] - 1.0);
        println!("{name:30} director {whole_us:8.3} us ({more:+6.2} %), axis loops alone {alone_us:8.3} us");
    }
    print_answers(&rig, &compiled::hosted(&library, env!("CARGO_BIN_EXE_bench"), Some(PATIENCE)));
}
