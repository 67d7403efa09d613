//! One check of polarity on a simulated director, from the procedure's text to its proof, with the motion that really
//! took place.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use bench::clock::Clock;
use bench::cycle::axis_loop::AxisLoop;
use bench::cycle::dither::Dither;
use bench::cycle::recorder::{LogHead, Recorder};
use bench::cycle::run::{Conditions, PointOutcome, run_point};
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::model::rig::Rig;
use bench::rig::wires::Wires;
use bench::rig::{OpenRig, PointSettings};
use drivers::wire::ProcessImage;
use procedures::case::Case;
use procedures::diagnostic::SourceFile;
use procedures::log::{LogReader, Plan, PointStatus};
use procedures::measurement::{Conclusion, PointResult};
use procedures::procedure::Procedure;
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use crate::conditions::of_point;
use crate::intercepted::{Intercepted, Interceptor};

/// Of a loop at 4 kHz every second row is logged, gyros at 500 Hz.
const LOG_EVERY: u64 = 2;
const LOG_GYROS_EVERY: u64 = 8;
const LOOP_RATE_HZ: f64 = 4000.0;

/// What was concluded, and what really moved.
#[derive(Debug)]
pub struct Trial {
    /// Numbers, remarks and proof.
    pub conclusion: Conclusion,
    /// Largest motion of either axis from where it began, rad.
    pub most_rad: f64,
    /// Largest rate of either axis, rad/s.
    pub most_rad_per_s: f64,
    /// What tripped or went wrong, one line a point.
    pub ended: Vec<String>,
}

impl Trial {
    /// The faults that were found.
    pub fn faults(&self) -> &[String] {
        self.conclusion.proof.as_ref().map_or(&[], |proof| &proof.faults)
    }

    /// A number of an axis.
    pub fn value(&self, measurand: &str, axis: &str) -> Option<f64> {
        let mut all = self.conclusion.measurements.iter();
        all.find(|m| m.measurand == measurand && m.axis == axis)?.value
    }
}

/// Runs the shipped procedure at these poses (azimuth, elevation, degrees) on a unit.
pub fn run(unit: &UnitSettings, pose_deg: [f64; 2], seed: u64, folder: &Path) -> Trial {
    let rig = read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("it parses");
    let procedure = procedure(pose_deg);
    let cases = procedure.plan(&rig.limits(), &[]).expect("the rig allows it");
    let plan = plan(&rig, cases, seed);
    let log = folder.join(format!("{seed}.mcap"));
    let moved = Rc::new(RefCell::new(Moved::default()));
    let ended = record(unit, &rig, &plan, &log, &moved);
    let mut reader = LogReader::open(&log).expect("our log");
    let mut points: Vec<PointResult> = Vec::new();
    while let Some(window) = reader.next_window() {
        let case = &plan.cases[window.point];
        points.push(procedure.analyse(case, &window, &plan.axes, plan.loop_rate_hz));
    }
    let conclusion = procedure.experiment.conclude(&plan.cases[..points.len()], &points, &plan.axes);
    std::fs::remove_file(&log).expect("a folder of ours");
    let Moved { most_rad, most_rad_per_s, .. } = *moved.borrow();
    Trial { conclusion, most_rad, most_rad_per_s, ended }
}

fn procedure([az_deg, el_deg]: [f64; 2]) -> Procedure {
    let text = format!(
        "schema = 1\nid = \"POLARITY\"\ntitle = \"trial\"\nkind = \"polarity\"\naxis = \"az\"\n\
         pose-az = \"{az_deg} deg\"\npose-el = \"{el_deg} deg\"\n"
    );
    Procedure::parse(SourceFile { name: "polarity.toml".to_owned(), text }).expect("a good procedure")
}

fn plan(rig: &Rig, cases: Vec<Case>, seed: u64) -> Plan {
    Plan {
        schema: 1,
        procedure: "POLARITY".to_owned(),
        axis: "az".to_owned(),
        seed,
        loop_rate_hz: LOOP_RATE_HZ,
        log_rate_hz: LOOP_RATE_HZ / LOG_EVERY as f64,
        command_delay_ticks: 1,
        axes: rig.limits(),
        cases,
        mode: "simulated".to_owned(),
    }
}

/// Runs the points until one does not complete, as a campaign does.
fn record(
    unit: &UnitSettings,
    rig: &Rig,
    plan: &Plan,
    log: &Path,
    moved: &Rc<RefCell<Moved>>,
) -> Vec<String> {
    let axes = rig.axis_names();
    let mut recorder = Recorder::start(log, LogHead::new(plan, rig), true).expect("a new file");
    let mut ended = Vec::new();
    for (point, case) in plan.cases.iter().enumerate() {
        let outcome = run_one(unit, rig, plan, point, moved, &mut recorder);
        if let Some(trip) = &outcome.trip {
            ended.push(format!("{}: {}", case.point, trip.reason(&axes)));
        }
        ended.extend(outcome.refused.map(|refused| format!("{}: {refused}", case.point)));
        ended.extend(outcome.error.map(|error| format!("{}: {error}", case.point)));
        if outcome.status != PointStatus::Completed {
            break;
        }
    }
    recorder.finish().expect("a writable log");
    ended
}

fn run_one(
    unit: &UnitSettings,
    rig: &Rig,
    plan: &Plan,
    point: usize,
    moved: &Rc<RefCell<Moved>>,
    recorder: &mut Recorder,
) -> PointOutcome {
    let case = &plan.cases[point];
    let address =
        SeedAddress { seed: plan.seed, procedure: plan.procedure.clone(), point: case.point.clone() };
    let at = |axis: &str| case.start_pose_rad[axis];
    let start = StartState { az_rad: at("az"), el_rad: at("el"), heat_sink_degc: 40.0 };
    let simulated = Rc::new(SimulatedRig::at_rate(unit, &address, start, LOOP_RATE_HZ));
    moved.borrow_mut().from_rad = [start.az_rad, start.el_rad];
    let mut wires = Wires::simulated(&simulated);
    let watch = Watch { rig: Rc::clone(&simulated), moved: Rc::clone(moved) };
    wires.bus = Intercepted::boxed(wires.bus, watch);
    let gains = parameters::load(rig).expect("shipped parameters");
    let mut armed = OpenRig::open(wires, rig, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a rig that answers");
    let settings = PointSettings::for_case(rig, case);
    armed.change_before_ticks(&settings, &Clock::Virtual).expect("settings that every device takes");
    let loops = AxisLoop::of_rig(rig, &gains);
    let stop = AtomicU16::new(0);
    let conditions = Conditions {
        point,
        moving: rig.axis_index(&case.axis).expect("an axis of the rig"),
        log_start_ns: 1_000_000_000 * (1 + 60 * point as u64),
        loop_rate_hz: LOOP_RATE_HZ,
        log_every: LOG_EVERY,
        log_payload_every: LOG_GYROS_EVERY,
        ..of_point(case, &stop)
    };
    let dither = Dither::new(plan, &case.point, 0.12);
    run_point(&mut armed, loops, conditions, dither, recorder)
}

/// What really moved, in the world and not in any encoder.
#[derive(Debug, Default)]
struct Moved {
    from_rad: [f64; 2],
    most_rad: f64,
    most_rad_per_s: f64,
}

/// Looks at the world in each exchange of the bus.
struct Watch {
    rig: Rc<SimulatedRig>,
    moved: Rc<RefCell<Moved>>,
}

impl Interceptor for Watch {
    fn after_exchange(&mut self, _now: Duration, _image: &ProcessImage, _is_whole: bool) {
        let truth = self.rig.truth_of_axes();
        let mut moved = self.moved.borrow_mut();
        for axis in 0..2 {
            let away = (truth.angle_rad[axis] - moved.from_rad[axis]).abs();
            moved.most_rad = moved.most_rad.max(away);
            moved.most_rad_per_s = moved.most_rad_per_s.max(truth.rate_rad_per_s[axis].abs());
        }
    }
}
