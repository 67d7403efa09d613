//! The controller, with the real driver at the other end.

use proptest::prelude::*;

use super::*;
use crate::unit::UnitSettings;
use drivers::gcs::{Gcs, GcsSettings, RecordOption, Reply, Request, TriggerSource};

const STEP_S: f64 = 50e-6;

fn controller() -> GcsMirror {
    let address = SeedAddress { seed: 1, procedure: "FSM".into(), point: "1".into() };
    GcsMirror::new(&UnitSettings::default().mirror, &address, STEP_S)
}

/// Controller, line and driver on one clock.
struct Bench {
    controller: Rc<RefCell<GcsMirror>>,
    line: GcsLine,
    driver: Gcs,
    step: u64,
}

impl Bench {
    fn new() -> Self {
        let controller = Rc::new(RefCell::new(controller()));
        let settings =
            GcsSettings { name: "fsm".into(), axes: ["1".into(), "2".into()], answer_timeout_s: 0.05 };
        let driver = Gcs::new(settings).expect("the settings are sound");
        Self { line: GcsLine(Rc::clone(&controller)), controller, driver, step: 0 }
    }

    fn now(&self) -> Duration {
        Duration::from_micros(50 * self.step)
    }

    fn run(&mut self, steps: u64) {
        for _ in 0..steps {
            self.controller.borrow_mut().step(self.step);
            self.step += 1;
        }
    }

    fn ask(&mut self, request: Request) -> Result<Reply, DeviceError> {
        let now = self.now();
        self.driver.send(&mut self.line, request, now)?;
        for _ in 0..200_000 {
            self.run(1);
            let now = self.now();
            if let Some(reply) = self.driver.poll(&mut self.line, now)? {
                return Ok(reply);
            }
        }
        panic!("neither a reply nor an error after 10 s");
    }

    fn values(&mut self, request: Request) -> [f64; 2] {
        match self.ask(request) {
            Ok(Reply::Values(values)) => values,
            other => panic!("{other:?}"),
        }
    }

    fn refusal(&mut self, request: Request) -> String {
        self.ask(request).expect_err("refused").to_string()
    }
}

#[test]
fn a_mirror_is_identified_closed_and_moved() {
    let mut bench = Bench::new();
    let Ok(Reply::Text(identity)) = bench.ask(Request::Identity) else { panic!("no identity") };
    assert!(identity.contains("E-727") && identity.contains("SIM"), "{identity}");
    assert_eq!(bench.ask(Request::Axes), Ok(Reply::Lines(vec!["1".into(), "2".into()])));
    assert_eq!(bench.values(Request::IsServoOn), [0.0, 0.0]);
    assert_eq!(bench.ask(Request::Servo([true, true])), Ok(Reply::Done));
    assert_eq!(bench.values(Request::IsServoOn), [1.0, 1.0]);
    assert_eq!(bench.ask(Request::Move([300.0, -700.0])), Ok(Reply::Done));
    bench.run(4000);
    let positions = bench.values(Request::Positions);
    let truth = bench.controller.borrow().mirror().angle_rad().map(|rad| rad * 1e6);
    for (axis, target) in [300.0, -700.0].into_iter().enumerate() {
        assert!((positions[axis] - target).abs() < 1.5, "{positions:?} urad");
        assert!((truth[axis] - target).abs() < 1.5, "{truth:?} urad");
    }
    assert_eq!((bench.values(Request::OnTarget), bench.values(Request::Overflow)), ([1.0; 2], [0.0; 2]));
    assert_eq!(bench.values(Request::Targets), [300.0, -700.0]);
    bench.ask(Request::MoveBy([50.0, 0.0])).expect("within the travel");
    assert_eq!(bench.values(Request::Targets), [350.0, -700.0]);
    let [low, high] = [bench.values(Request::LowerLimits), bench.values(Request::UpperLimits)];
    assert!(low.iter().zip(high).all(|(low, high)| *low == -high && high > 500.0), "{low:?} {high:?}");
    let volts = bench.values(Request::PiezoVoltages);
    assert!(volts[0] > volts[1], "{volts:?}");
    assert_eq!(bench.ask(Request::Stop), Ok(Reply::Done));
}

#[test]
fn what_the_manual_forbids_is_refused_by_number_and_changes_nothing() {
    let mut bench = Bench::new();
    assert!(bench.refusal(Request::Move([1.0, 0.0])).contains("reports 5,"));
    bench.ask(Request::OpenLoop([100.0, 0.0])).expect("servo off");
    bench.run(2000);
    assert!(bench.values(Request::Positions)[0] > 50.0, "the actuators follow the open-loop value");
    bench.ask(Request::Servo([true, true])).expect("servo on");
    assert!(bench.refusal(Request::OpenLoop([1.0, 0.0])).contains("reports 79,"));
    let targets = bench.values(Request::Targets);
    assert!(bench.refusal(Request::Move([0.0, 9e3])).contains("reports 7,"));
    assert_eq!(bench.values(Request::Targets), targets, "not the good half either");
    assert!(bench.refusal(Request::RecordedCount(9)).contains("reports 57,"));
    assert!(bench.refusal(Request::Parameter { axis: 0, id: 1 }).contains("reports 54,"));
    assert!(bench.refusal(Request::RecordEvery(0)).contains("reports 17,"));
    let beyond = Request::Recorded { first: 1, count: 9000, tables: vec![1] };
    assert!(bench.refusal(beyond).contains("reports 77,"));
    assert_eq!(bench.ask(Request::Parameter { axis: 0, id: 0x0E00_0200 }), Ok(Reply::Number(50e-6)));
}

/// A step of 200 µrad, recorded from the command on at every second cycle.
#[test]
fn the_recorder_shows_the_step_from_its_command_on() {
    let mut bench = Bench::new();
    bench.ask(Request::Servo([true, true])).expect("servo on");
    bench.ask(Request::RecordEvery(2)).expect("a rate");
    for (table, axis, option) in
        [(1, 0, RecordOption::Target), (2, 0, RecordOption::Position), (3, 0, RecordOption::PositionError)]
    {
        bench.ask(Request::RecordInto { table, axis, option }).expect("a source");
    }
    bench.ask(Request::RecordOn(TriggerSource::Move)).expect("a trigger");
    bench.ask(Request::Move([200.0, 0.0])).expect("within the travel");
    bench.run(2000);
    let Ok(Reply::Number(count)) = bench.ask(Request::RecordedCount(1)) else { panic!("no count") };
    assert!(count >= 1000.0, "{count}");
    let request = Request::Recorded { first: 1, count: 400, tables: vec![1, 2, 3] };
    let Ok(Reply::Record(record)) = bench.ask(request) else { panic!("no record") };
    assert_eq!(record.sample_time_s, 100e-6);
    assert_eq!(record.names[1], "Actual Position of axis 1");
    let [target, position, error] = record.columns.as_slice() else { panic!("three tables") };
    assert!(target.iter().all(|urad| *urad == 200.0));
    assert!(
        position[0].abs() < 2.0 && (position[399] - 200.0).abs() < 2.0,
        "{} {}",
        position[0],
        position[399]
    );
    for row in 0..400 {
        assert!((target[row] - position[row] - error[row]).abs() < 2e-6, "row {row}");
    }
}

/// `POS? 1` and its line feed are 7 characters of 86.8 µs each at 115200 bit/s; the reply begins after them.
#[test]
fn characters_take_their_time_on_the_line() {
    let mut controller = controller();
    controller.write(Duration::ZERO, b"POS? 1\n");
    let mut bytes = [0; 64];
    for step in 0..40 {
        controller.step(step);
        let now = Duration::from_micros(50 * (step + 1));
        let count = controller.read(now, &mut bytes);
        assert!(count == 0 || now.as_secs_f64() >= 8.0 * 86.8e-6, "{count} bytes after {now:?}");
    }
    assert_eq!(controller.read(Duration::from_millis(10), &mut bytes), 0, "taken already");
}

#[test]
fn any_case_is_heard_single_characters_need_no_line_feed_and_errors_are_cleared() {
    let mut controller = controller();
    let mut step = 0;
    let mut talk = |text: &[u8]| {
        controller.write(Duration::from_micros(50 * step), text);
        let end = step + 2000;
        while step < end {
            controller.step(step);
            step += 1;
        }
        let mut bytes = [0; 4096];
        let count = controller.read(Duration::from_micros(50 * step), &mut bytes);
        String::from_utf8_lossy(&bytes[..count]).into_owned()
    };
    assert_eq!(talk(b"svo? 2\n"), "2=0\n");
    assert_eq!(talk(b"SVO?\n"), "1=0 \n2=0\n");
    assert_eq!(talk(b"NIX 1\nERR?\nERR?\n"), "2\n0\n");
    for (command, code) in [
        (&b"MOV 1\n"[..], "24"),
        (b"MOV 3 1\n", "15"),
        (b"SVO 1 x\n", "25"),
        (b"SVO 1 2\n", "17"),
        (b"SPA 1 0x0E000200 1\n", "64"),
        (b"DRC 1 1 99\n", "58"),
    ] {
        let text = String::from_utf8_lossy(command).into_owned();
        assert_eq!(talk(&[command, b"ERR?\n"].concat()), format!("{code}\n"), "{text}");
    }
    assert_eq!(talk(&[&[b'A'; 300][..], b"\nERR?\n"].concat()), "3\n");
    assert_eq!(talk(&[MOTION_STATUS]), "0\n");
    assert_eq!(talk(&[&[STOP_ALL][..], b"ERR?\n"].concat()), "10\n");
    assert_eq!(
        talk(b"DRR? 1 0 1\n"),
        "# TYPE = 1 \n# SEPARATOR = 32 \n# DIM = 1 \n# SAMPLE_TIME = 0.00005 \n# NDATA = 0 \n\
                                       # NAME0 = Actual Position of axis 1 \n# END_HEADER\n"
    );
}

proptest! {
    #[test]
    fn no_bytes_bring_the_controller_down(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
        let mut controller = controller();
        controller.write(Duration::ZERO, &bytes);
        controller.write(Duration::ZERO, b"\n");
        (0..300).for_each(|step| controller.step(step));
        controller.read(Duration::from_secs(1), &mut [0; 4096]);
    }
}
