//! Runs one procedure whose line has a fault, and looks at all that it leaves.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use bench::campaign::{self, ProcedureRun, Setup};
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::judge::{self, JudgedLog, Known};
use bench::model::rig::Rig;
use bench::people::Answers;
use bench::people::underway::Underway;
use bench::plan::{Wanted, plan};
use bench::record::journal::{self, Entry};
use bench::rig::wires::Wires;
use bench::site::{Opened, OpenedPorts, Purpose, Site, VirtualSite};
use controllers::DirectorGains;
use drivers::device::DeviceError;
use procedures::log::{Event, LogReader, Window};
use procedures::requirement::Requirements;
use sim_devices::rig::SimulatedRig;

use crate::campaigns::{Silent, nominal};

/// Wires with a fault.
pub(super) type FaultyWires = fn(&SimulatedRig) -> Wires;

/// The wires of one procedure have a fault, those of all others have none.
struct FaultyIn<'a> {
    procedure: &'a str,
    sound: VirtualSite<'a>,
    faulty: VirtualSite<'a>,
}

impl Site for FaultyIn<'_> {
    fn keeps_session(&self) -> bool {
        false
    }

    fn open(&self, rig: &Rig, gains: &DirectorGains, purpose: &Purpose<'_>) -> Result<Opened, DeviceError> {
        let is_faulty = purpose.procedure == self.procedure;
        if is_faulty { &self.faulty } else { &self.sound }.open(rig, gains, purpose)
    }

    fn open_ports(&self, rig: &Rig, purpose: &Purpose<'_>) -> Result<OpenedPorts, DeviceError> {
        self.sound.open_ports(rig, purpose)
    }
}

/// What a run with a fault has left.
pub(super) struct Ran {
    /// Exit code before verdicts.
    pub(super) exit_code: u8,
    /// How the procedure ended.
    pub(super) run: ProcedureRun,
    /// Its points.
    pub(super) windows: Vec<Window>,
    /// Events of its log, each with its time, s.
    pub(super) events: Vec<(f64, Event)>,
}

/// Runs a procedure, given as its text, on these wires. Asserts what holds whatever the fault is: the log is whole and re-judges
/// alike, and every point ends at standstill.
pub(super) fn ran(id: &str, text: &str, wires: FaultyWires) -> Ran {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("procedure.toml");
    std::fs::write(&file, text).expect("a writable folder");
    let out = folder.path().join("run");
    std::fs::create_dir(&out).expect("a writable folder");
    let result = carried_out(&file.display().to_string(), id, &out, wires);
    let index = result.page.procedures.iter().position(|procedure| procedure.id == id).expect("planned");
    let log = out.join(format!("{id}.mcap"));
    judges_alike(&log, result.judged[index].as_ref().expect("judged"));
    ends_at_standstill(&out);
    let mut reader = LogReader::open(&log).expect("a log");
    let windows = std::iter::from_fn(|| reader.next_window()).collect();
    let run = result.runs[index].clone();
    Ran { exit_code: result.exit_code, run, windows, events: events(&log) }
}

fn carried_out(name: &str, id: &str, out: &Path, wires: FaultyWires) -> campaign::RunResult {
    let unit = nominal();
    let sound = VirtualSite::new(&unit, &[]);
    let site = FaultyIn { procedure: id, sound, faulty: VirtualSite::new(&unit, &[]).with_wires(wires) };
    let rig = shipped::find(Folder::Rigs, "sim", None).and_then(read_rig).expect("the shipped rig");
    let wanted = Wanted { names: vec![name.to_owned()], polarity_proven: true, ..Wanted::default() };
    let setup = Setup {
        plan: &plan(&wanted, &rig).expect("a valid procedure"),
        unit: &unit,
        built: Vec::new(),
        laws: Default::default(),
        gains: &parameters::load(&rig).expect("shipped parameters"),
        rig: &rig,
        folder: out.to_owned(),
        seed: 1,
        jobs: Some(1),
        answers: Answers { yes: true, ..Answers::default() },
        lock_folder: out.to_owned(),
        operator: None,
        serial_number: None,
        command_line: String::new(),
        underway: Underway::default(),
        stop: Arc::default(),
        polarity: Some(proof().to_owned()),
        site: &site,
        judge: judge::judge_log,
        judge_program: None,
    };
    campaign::run(&setup, &mut Silent).expect("a writable folder")
}

/// A run that has proven polarity, once for all tests.
fn proof() -> &'static Path {
    static PROOF: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = PROOF.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let unit = nominal();
        let site = VirtualSite::new(&unit, &[]);
        let result =
            crate::campaigns::with_setup("sim", &["polarity"], folder.path(), (&unit, &site), |setup| {
                let answers = Answers { yes: true, ..Answers::default() };
                campaign::run(&Setup { answers, ..setup }, &mut Silent).expect("a writable folder")
            });
        assert_eq!(result.exit_code, 0, "{:?}", result.runs);
        result.journal.close(0).expect("a writable folder");
        folder
    });
    folder.path()
}

/// The log is whole, and whoever judges it again finds the same.
fn judges_alike(log: &Path, judged: &JudgedLog) {
    assert_eq!(judged.damage, None);
    let shipped = shipped::find(Folder::Requirements, "requirements", None).expect("shipped");
    let by = Requirements::parse(&shipped).expect("shipped");
    let name = log.file_name().expect("a file").to_string_lossy();
    let again = judge::judge_log(log, &name, &by, &Known::default()).expect("it can be judged");
    assert_eq!((again.damage, again.findings), (None, judged.findings.clone()));
}

fn ends_at_standstill(out: &Path) {
    let (lines, _) = journal::read(out).expect("an intact chain");
    let mut ended_count = 0;
    for line in lines {
        if let Entry::PointEnded { safe, .. } = line.entry {
            assert!(safe.starts_with("standstill: "), "{safe}");
            ended_count += 1;
        }
    }
    assert!(ended_count > 0, "no point was run");
}

fn events(log: &Path) -> Vec<(f64, Event)> {
    let all = crate::bench::content(log).into_iter().filter(|(topic, _, _)| topic == "/events");
    all.map(|(_, at_ns, bytes)| (1e-9 * at_ns as f64, serde_json::from_slice(&bytes).expect("an event")))
        .collect()
}

impl Ran {
    /// Time and text of the first notice that begins so.
    pub(super) fn notice(&self, start: &str) -> (f64, &str) {
        let found = self.events.iter().find_map(|(at_s, event)| match event {
            Event::DeviceNotice { what, .. } if what.starts_with(start) => Some((*at_s, what.as_str())),
            _ => None,
        });
        found.unwrap_or_else(|| panic!("no notice `{start}` among {:?}", self.notices()))
    }

    /// All notices about devices.
    pub(super) fn notices(&self) -> Vec<&str> {
        self.events
            .iter()
            .filter_map(|(_, event)| match event {
                Event::DeviceNotice { what, .. } => Some(what.as_str()),
                _ => None,
            })
            .collect()
    }

    /// When an interlock tripped first.
    pub(super) fn tripped_s(&self, name: &str) -> f64 {
        let found = self.events.iter().find_map(|(at_s, event)| match event {
            Event::Tripped { interlock, .. } => Some((*at_s, interlock)),
            _ => None,
        });
        let (at_s, interlock) = found.expect("something tripped");
        assert_eq!(interlock, name);
        at_s
    }

    /// The run was stopped in motion: each axis came to rest within the time that was computed and the 3 s of `make_safe`.
    pub(super) fn is_stopped_in_motion(&self) {
        let stops = || self.windows.iter().flat_map(|window| &window.stops);
        let fastest = stops().map(|stop| stop.from_rad_per_s.abs()).fold(0.0, f64::max);
        assert!(fastest > 0.1, "an axis was in motion, found {fastest} rad/s");
        for stop in stops() {
            assert!(stop.standstill && stop.took_s <= stop.computed_s.unwrap_or(0.0) + 3.0, "{stop:?}");
            assert!(stop.reached_angle_rad <= stop.computed_angle_rad, "{stop:?}");
        }
    }

    /// Why the procedure did not complete.
    pub(super) fn reason(&self) -> &str {
        self.run.reason.as_deref().unwrap_or("it completed")
    }
}
