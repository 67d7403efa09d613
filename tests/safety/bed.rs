//! A simulated director in the real loop, with everything that a test may want to change.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use super::ethercat;
use bench::clock::Clock;
use bench::cycle::axis_loop::AxisLoop;
use bench::cycle::dither::Dither;
use bench::cycle::laws::Laws;
use bench::cycle::prompt::Question;
use bench::cycle::recorder::{LogHead, Recorder};
use bench::cycle::run::{Conditions, PointOutcome, run_point};
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::model::rig::Rig;
use bench::rig::wires::Wires;
use bench::rig::{OpenRig, PointSettings};
use drivers::wire::Fieldbus;
use procedures::case::{Case, Mode, Segment, Then};
use procedures::diagnostic::SourceFile;
use procedures::log::{LogReader, Plan, Window};
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::ethercat::LineFault;
use sim_devices::rig::{Fault, SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

/// Puts something between the bench and its bus.
pub(super) type Wrap = Box<dyn Fn(Box<dyn Fieldbus>) -> Box<dyn Fieldbus>>;
/// Makes another recorder.
pub(super) type MakeRecorder = Box<dyn FnOnce(&Plan, &Rig) -> Recorder>;

/// What runs, on what.
pub(super) struct Bed {
    pub(super) rig: Rig,
    pub(super) unit: UnitSettings,
    pub(super) start_deg: [f64; 2],
    pub(super) case: Case,
    pub(super) questions: Arc<[Question]>,
    pub(super) parks: bool,
    pub(super) stop: Arc<AtomicU16>,
    pub(super) clock: Clock,
    pub(super) laws: Laws,
    pub(super) wrap: Wrap,
    pub(super) recorder: Option<MakeRecorder>,
    /// Faults of the simulated rig, each at a time since the first tick.
    pub(super) faults: Vec<(Duration, Fault)>,
    /// With these the drives are at the end of an EtherCAT wire in process, on which each fault acts at a time since the first
    /// tick.
    pub(super) on_ethercat: Option<Vec<(Duration, LineFault)>>,
}

/// What came of it.
pub(super) struct Ran {
    pub(super) outcome: PointOutcome,
    /// The log as the judge reads it; without one where the recorder was another.
    pub(super) window: Option<Window>,
    /// End-stop contacts in the simulated world.
    pub(super) contacts: usize,
}

impl Bed {
    /// The shipped rig and the nominal unit, both axes at 0.
    pub(super) fn new(case: Case) -> Self {
        Self {
            rig: rig(&[]),
            unit: UnitSettings::default(),
            start_deg: [0.0; 2],
            case,
            questions: Arc::default(),
            parks: false,
            stop: Arc::new(AtomicU16::new(0)),
            clock: Clock::Virtual,
            laws: Laws::default(),
            wrap: Box::new(|bus| bus),
            recorder: None,
            faults: Vec::new(),
            on_ethercat: None,
        }
    }

    pub(super) fn run(self) -> Ran {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("log.mcap");
        let plan = plan(&self.rig, &self.case);
        let own = self.recorder.is_none();
        let mut recorder = match self.recorder {
            Some(make) => make(&plan, &self.rig),
            None => Recorder::start(&path, LogHead::new(&plan, &self.rig), true).expect("a new file"),
        };
        let address = SeedAddress { seed: 1, procedure: "TEST".to_owned(), point: "one".to_owned() };
        let [az_rad, el_rad] = self.start_deg.map(f64::to_radians);
        let simulated =
            SimulatedRig::new(&self.unit, &address, StartState { az_rad, el_rad, heat_sink_degc: 40.0 });
        let mut wires = Wires::simulated(&simulated);
        let schedule = Rc::new(RefCell::new(Vec::new()));
        if self.on_ethercat.is_some() {
            wires.bus = ethercat::bus(&simulated, 1.0 / self.rig.loop_rate_hz, &schedule);
        }
        if self.rig.emergency_stop_input.is_some() {
            wires.ports = wires.ports.with_emergency_stop(simulated.digital_card());
        }
        wires.bus = (self.wrap)(wires.bus);
        let gains = parameters::load(&self.rig).expect("shipped parameters");
        let mut armed = OpenRig::open(wires, &self.rig, &gains, &Clock::Virtual)
            .and_then(|rig| rig.arm(&Clock::Virtual))
            .expect("a healthy rig");
        let settings = PointSettings::for_case(&self.rig, &self.case);
        armed.change_before_ticks(&settings, &Clock::Virtual).expect("settings that every device takes");
        for &(after, fault) in &self.faults {
            simulated.schedule(armed.ready() + after, fault);
        }
        for (after, fault) in self.on_ethercat.into_iter().flatten() {
            schedule.borrow_mut().push((armed.ready() + after, fault));
        }
        let loops = AxisLoop::of_rig_with(&self.rig, &gains, &self.laws, None).expect("sound laws");
        let conditions = Conditions {
            point: 0,
            case: &self.case,
            moving: self.rig.axis_index(&self.case.axis).expect("an axis of the rig"),
            log_start_ns: 1_000_000_000,
            loop_rate_hz: 4000.0,
            log_every: 1,
            log_payload_every: 8,
            max_missed_periods: self.rig.max_missed_periods,
            gates: &[],
            questions: Arc::clone(&self.questions),
            parks: self.parks,
            stop: &self.stop,
            clock: self.clock,
            progress: Arc::default(),
        };
        let dither = Dither::new(&plan, "one", 0.12);
        let outcome = run_point(&mut armed, loops, conditions, dither, &mut recorder);
        let finished = recorder.finish();
        let window = own.then(|| {
            finished.expect("a writable log");
            LogReader::open(&path).expect("our log").next_window().expect("one point")
        });
        Ran { outcome, window, contacts: simulated.record().crashes.len() }
    }
}

impl Ran {
    /// A column of the log.
    pub(super) fn column(&self, topic: &str, channel: &str) -> &[f64] {
        let window = self.window.as_ref().expect("this test keeps its log");
        window.rows(topic).expect("a topic of the rig").column(channel).expect("a channel of the rig")
    }

    /// Largest absolute value of a column.
    pub(super) fn largest(&self, topic: &str, channel: &str) -> f64 {
        self.column(topic, channel).iter().fold(0.0, |most, value| value.abs().max(most))
    }

    /// The states that the loop went through, each once, in order.
    pub(super) fn states(&self) -> Vec<u16> {
        let mut states: Vec<u16> = self.column("/bench", "state").iter().map(|s| *s as u16).collect();
        states.dedup();
        states
    }
}

pub(super) fn plan(rig: &Rig, case: &Case) -> Plan {
    Plan {
        schema: 1,
        procedure: "TEST".to_owned(),
        axis: case.axis.clone(),
        seed: 1,
        loop_rate_hz: 4000.0,
        log_rate_hz: 4000.0,
        command_delay_ticks: 1,
        axes: rig.limits(),
        cases: vec![case.clone()],
        mode: "simulated".to_owned(),
    }
}

/// The shipped rig with other lines for elevation's table of safety, as key and value.
pub(super) fn rig(elevation: &[(&str, &str)]) -> Rig {
    let shipped = shipped::find(Folder::Rigs, "sim", None).expect("shipped");
    let (before, after) = shipped.text.split_once("[axis.el.safety]").expect("the table is there");
    let changed = |line: &str| elevation.iter().any(|(key, _)| line.starts_with(&format!("{key} =")));
    let (table, rest) = after.split_once("\n[").expect("another table follows");
    let kept: Vec<&str> = table.lines().filter(|line| !changed(line)).collect();
    let added: Vec<String> = elevation.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let text = format!("{before}[axis.el.safety]{}\n{}\n[{rest}", kept.join("\n"), added.join("\n"));
    read_rig(SourceFile { name: "test.toml".to_owned(), text }).expect("a valid rig")
}

pub(super) fn case(axis: &str, start_deg: [f64; 2], segments: Vec<Segment>) -> Case {
    let pose = ["az", "el"].map(str::to_owned).into_iter().zip(start_deg.map(f64::to_radians));
    Case {
        point: "one".to_owned(),
        axis: axis.to_owned(),
        start_pose_rad: pose.collect::<BTreeMap<_, _>>(),
        segments,
        ..Case::default()
    }
}

/// A move at 20 deg/s.
pub(super) fn go_to(target_deg: f64, at_most_s: f64) -> Segment {
    let limits =
        ProfileLimits { velocity_rad_per_s: 0.35, acceleration_rad_per_s2: 1.0, jerk_rad_per_s3: 10.0 };
    let stimulus = Stimulus::Move { target_rad: target_deg.to_radians(), limits };
    segment(Mode::Position, stimulus, at_most_s)
}

pub(super) fn segment(mode: Mode, stimulus: Stimulus, at_most_s: f64) -> Segment {
    let label = "test".to_owned();
    let until = None;
    let then = Then::Stop;
    let dithered = false;
    Segment { label, mode, stimulus, until, at_most_s, then, dithered, ..Segment::default() }
}
