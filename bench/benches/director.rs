//! How fast the whole director is: simulated seconds per CPU second of the process, with world (20 kHz), mirror servo
//! (20 kHz), drives, inertial unit, cameras, codecs, interlocks and the production controllers of both axes.
#![allow(clippy::print_stdout)]

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU16;

use bench::clock::{Clock, cpu_s};
use bench::cycle::axis_loop::AxisLoop;
use bench::cycle::dither::Dither;
use bench::cycle::recorder::{LogHead, Recorder};
use bench::cycle::run::{Conditions, run_point};
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::model::rig::Rig;
use bench::rig::OpenRig;
use bench::rig::wires::Wires;
use procedures::case::{Case, Mode, Segment};
use procedures::log::Plan;
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::{ModeCurves, UnitSettings};
use validation::conditions::of_point;

const SIMULATED_S: f64 = 60.0;
const ROUNDS: usize = 3;

/// Azimuth goes to and fro, each way in less than its share of the time; elevation holds.
fn case() -> Case {
    let limits =
        ProfileLimits { velocity_rad_per_s: 0.3, acceleration_rad_per_s2: 0.5, jerk_rad_per_s3: 5.0 };
    let there = |target_rad: f64| Segment {
        stimulus: Stimulus::Move { target_rad, limits },
        ..Segment::hold("move", Mode::Position, SIMULATED_S / 6.0)
    };
    Case {
        point: "1".to_owned(),
        axis: "az".to_owned(),
        requested: Vec::new(),
        start_pose_rad: BTreeMap::from([("az".to_owned(), 0.0), ("el".to_owned(), 0.5)]),
        segments: [1.2, -1.2, 1.2, -1.2, 1.2, -1.2].map(there).into(),
        ..Case::default()
    }
}

/// Simulated seconds per CPU second, the best of some rounds: others only disturb.
fn ratio(rig: &Rig, unit: &UnitSettings, log_rate_hz: Option<f64>) -> f64 {
    (0..ROUNDS).map(|_| one_round(rig, unit, log_rate_hz)).fold(0.0, f64::max)
}

fn one_round(rig: &Rig, unit: &UnitSettings, log_rate_hz: Option<f64>) -> f64 {
    let case = case();
    let gains = parameters::load(rig).expect("shipped parameters");
    let plan = Plan {
        schema: 1,
        procedure: "BENCH".to_owned(),
        axis: "az".to_owned(),
        seed: 1,
        loop_rate_hz: rig.loop_rate_hz,
        log_rate_hz: log_rate_hz.unwrap_or(rig.loop_rate_hz),
        command_delay_ticks: 1,
        axes: rig.limits(),
        cases: vec![case.clone()],
        mode: "simulated".to_owned(),
    };
    let folder = tempfile::tempdir().expect("temporary folder");
    let before = cpu_s().expect("this system tells CPU time");
    let mut recorder = match log_rate_hz {
        None => Recorder::discarding(),
        Some(_) => {
            let path = folder.path().join("log.mcap");
            Recorder::start(&path, LogHead::new(&plan, rig), true).expect("a new file")
        }
    };
    let address = SeedAddress { seed: 1, procedure: "BENCH".to_owned(), point: "1".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: 0.5, heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(unit, &address, start);
    let mut armed = OpenRig::open(Wires::simulated(&simulated), rig, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let loops = AxisLoop::of_rig(rig, &gains);
    let stop = AtomicU16::new(0);
    let conditions = Conditions { loop_rate_hz: rig.loop_rate_hz, ..of_point(&case, &stop) };
    let dither = Dither::new(&plan, "1", 0.12);
    let outcome = run_point(&mut armed, loops, conditions, dither, &mut recorder);
    assert!(outcome.trip.is_none() && outcome.error.is_none(), "{outcome:?}");
    recorder.finish().expect("a writable log");
    outcome.loop_s / (cpu_s().expect("told before") - before)
}

/// The unit with this many modes on each axis, all like its first ones.
fn with_modes(count: usize) -> UnitSettings {
    let mut unit = UnitSettings::default();
    for structure in [&mut unit.az_structure, &mut unit.el_structure] {
        let modes: Vec<ModeCurves> = structure.modes.iter().take(3).cycle().take(count).cloned().collect();
        structure.modes = modes;
    }
    unit
}

fn main() {
    let source = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig");
    let rig = read_rig(source).expect("a valid rig");
    let nominal = UnitSettings::default();
    println!("simulated s per CPU s, whole director, {SIMULATED_S} s, best of {ROUNDS}");
    println!("without log            {:8.1}", ratio(&rig, &nominal, None));
    println!("zstd log at 4 kHz      {:8.1}", ratio(&rig, &nominal, Some(rig.loop_rate_hz)));
    println!("CPU ms per simulated s, without log, by modes per axis");
    for count in 0..=8 {
        println!("{count} modes                {:8.3}", 1000.0 / ratio(&rig, &with_modes(count), None));
    }
}
