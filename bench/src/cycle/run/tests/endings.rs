//! Ends of a point in which something panics.

use std::cell::Cell;
use std::rc::Rc;

use drivers::device::DeviceError;
use drivers::wire::ByteLine;
use procedures::device::Task;
use procedures::excitation::{Excitation, Injection, Signal};
use validation::intercepted::{Intercepted, Interceptor};

use super::*;

/// Panics in exchanges of a bus from one time on, so often.
struct BusPanics {
    from: Duration,
    left: Rc<Cell<u32>>,
}

impl Interceptor for BusPanics {
    fn before_exchange(&mut self, now: Duration) -> Duration {
        let left = self.left.get();
        if now >= self.from && left > 0 {
            self.left.set(left - 1);
            panic!("the bus of this test panics");
        }
        now
    }
}

/// A line that panics once when it is written to after the bus has panicked.
struct PanickingLine {
    line: Box<dyn ByteLine>,
    bus_panics_left: Rc<Cell<u32>>,
    panicked: Rc<Cell<bool>>,
}

impl ByteLine for PanickingLine {
    fn name(&self) -> &str {
        self.line.name()
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        self.line.read(now, into)
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        if self.bus_panics_left.get() == 0 && !self.panicked.replace(true) {
            panic!("the line of this test panics");
        }
        self.line.write(now, bytes)
    }
}

fn fast() -> Case {
    let limits =
        ProfileLimits { velocity_rad_per_s: 0.8, acceleration_rad_per_s2: 1.5, jerk_rad_per_s3: 15.0 };
    let move_ = Stimulus::Move { target_rad: 2.0, limits };
    case(vec![segment(Mode::Position, move_, 8.0, Then::Hold)])
}

/// A run whose bus panics so often from 2 s on, in the middle of its motion.
fn with_panics(count: u32) -> (PointOutcome, Window) {
    let wires = |wires: Wires| {
        let panics = BusPanics { from: Duration::from_secs(2), left: Rc::new(Cell::new(count)) };
        Wires { bus: Intercepted::boxed(wires.bus, panics), ..wires }
    };
    run_on(&fast(), &Bed { wires: &wires, ..Bed::on(&UnitSettings::default()) })
}

/// The loop panics in the first exchange, `make_safe` in its own first one: the next try brings the axes to rest.
#[test]
fn a_stop_that_panics_is_begun_anew_and_the_point_is_closed() {
    let (outcome, window) = with_panics(2);
    assert_eq!(outcome.status, PointStatus::Errored);
    assert!(
        outcome.error.as_ref().is_some_and(|error| matches!(error, PointError::Internal(_))),
        "{outcome:?}"
    );
    assert!(outcome.safe.standstill, "{:?}", outcome.safe);
    assert_eq!(window.status, PointStatus::Errored);
    let fastest = column(&window, "/az", "velocity_rad_per_s").iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    assert!(fastest > 0.5, "it was moving: {fastest} rad/s");
    let last = column(&window, "/az", "velocity_rad_per_s").last().copied().expect("rows");
    assert!(last.abs() < 1e-3, "{last} rad/s");
}

#[test]
fn a_stop_that_panics_for_good_is_reported_as_no_standstill_and_the_point_is_closed() {
    let (outcome, window) = with_panics(u32::MAX);
    assert_eq!(outcome.status, PointStatus::Errored);
    assert!(!outcome.safe.standstill);
    assert_eq!(window.status, PointStatus::Errored, "the closing event is in the log");
}

/// A capture that waits for its edge, and a step of torque that makes one after 1 s.
fn capture() -> Case {
    let task = Task::Capture { axis: "az".to_owned(), sample_rate_hz: 100e3, duration_s: 0.02 };
    let waiting = Segment::hold("capture", Mode::Torque, 5.0);
    let signal = Signal::Square { amplitude: 300.0, period_s: 2.0 };
    Case {
        excitations: vec![Excitation { into: Injection::Torque, signal, fade_s: 0.0, every_ticks: 1 }],
        ..case(vec![Segment { task: Some(task), excited: Some(0), ..waiting }])
    }
}

#[test]
fn an_instrument_that_cannot_be_stopped_does_not_keep_the_axes_from_it() {
    let left = Rc::new(Cell::new(1));
    let panicked = Rc::new(Cell::new(false));
    let wires = |wires: Wires| {
        let panics = BusPanics { from: Duration::from_secs(1), left: Rc::clone(&left) };
        let bus = Intercepted::boxed(wires.bus, panics);
        let panicking = |line| -> Box<dyn ByteLine> {
            Box::new(PanickingLine {
                line,
                bus_panics_left: Rc::clone(&left),
                panicked: Rc::clone(&panicked),
            })
        };
        Wires { bus, ports: wires.ports.with_line_through("sim:scope", panicking) }
    };
    let (outcome, window) = run_on(&capture(), &Bed { wires: &wires, ..Bed::on(&UnitSettings::default()) });
    assert!(panicked.get(), "the scope was measuring when the control loop panicked");
    assert_eq!(outcome.status, PointStatus::Errored);
    assert!(outcome.safe.standstill, "{:?}", outcome.safe);
    assert_eq!(window.status, PointStatus::Errored);
}
