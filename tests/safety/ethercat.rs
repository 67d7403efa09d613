//! Faults on an EtherCAT wire and at its SubDevices: what the bench makes of each, and that the axes stand afterwards.
//!
//! MainDevice and SubDevices are in one process and in virtual time, so that every instant is the same in every run; the frames
//! are those of a real wire.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use drivers::wire::Fieldbus;
use drivers::wire::ethercat::{EtherCatBus, EtherCatSettings};
use procedures::log::PointStatus;
use sim_devices::ethercat::{Emergency, EtherCatLine, InProcessLink, LineFault, Passage, Terminals};
use sim_devices::rig::{Fault, SimulatedRig};

use super::bed::{Bed, Ran, case, go_to};

/// Faults that are still to act, each at an instant of the link.
pub(super) type Schedule = Rc<RefCell<Vec<(Duration, LineFault)>>>;

/// A line on which faults act when their time has come.
struct Troubled {
    line: Box<dyn EtherCatLine>,
    schedule: Schedule,
}

impl Troubled {
    fn keep_schedule(&mut self, now: Duration) {
        let due = |(at, _): &(Duration, LineFault)| *at <= now;
        let mut schedule = self.schedule.borrow_mut();
        while let Some(k) = schedule.iter().position(due) {
            let (_, fault) = schedule.remove(k);
            self.line.inject(now, fault).expect("a device of the line");
        }
    }
}

impl EtherCatLine for Troubled {
    fn pass(&mut self, now: Duration, frame: &mut [u8]) -> Passage {
        self.keep_schedule(now);
        self.line.pass(now, frame)
    }

    fn advance(&mut self, now: Duration) {
        self.keep_schedule(now);
        self.line.advance(now);
    }

    fn inject(&mut self, now: Duration, fault: LineFault) -> Result<(), String> {
        self.line.inject(now, fault)
    }

    fn names(&self) -> Vec<String> {
        self.line.names()
    }

    fn set_alias(&mut self, device: usize, alias: u16) -> Result<(), String> {
        self.line.set_alias(device, alias)
    }
}

/// The bus of a simulated rig over an EtherCAT wire in process.
pub(super) fn bus(simulated: &SimulatedRig, cycle_s: f64, schedule: &Schedule) -> Box<dyn Fieldbus> {
    let line = Troubled {
        line: simulated.ethercat_line(Terminals { analog: true, digital: false }),
        schedule: Rc::clone(schedule),
    };
    let link = InProcessLink::new(Box::new(line));
    let settings = EtherCatSettings::usual("bus", cycle_s);
    Box::new(EtherCatBus::open(Box::new(link), settings).expect("three stations that answer"))
}

/// When the fault acts: the axis turns at 20 deg/s then.
const AT: Duration = Duration::from_secs(2);

fn with(faults: Vec<(Duration, LineFault)>) -> Ran {
    let case = case("az", [0.0, 40.0], vec![go_to(60.0, 6.0)]);
    Bed { start_deg: [0.0, 40.0], on_ethercat: Some(faults), ..Bed::new(case) }.run()
}

fn after(fault: LineFault) -> Ran {
    with(vec![(AT, fault)])
}

fn goes_on(ran: &Ran, what: &str) {
    assert_eq!(ran.outcome.status, PointStatus::Completed, "{what}: {:?}", ran.outcome);
    assert_eq!(ran.contacts, 0, "{what}");
}

/// The point ends by this interlock, the axes stand, and nothing was hit.
fn trips(ran: &Ran, interlock: &str, what: &str) {
    assert_eq!(ran.outcome.trip.map(|trip| trip.interlock), Some(interlock), "{what}: {:?}", ran.outcome);
    assert_ne!(ran.outcome.status, PointStatus::Completed, "{what}");
    assert!(ran.outcome.safe.standstill, "{what}: {:?}", ran.outcome.safe);
    assert_eq!(ran.contacts, 0, "{what}");
}

/// Which tick is the first that no longer moves the axis, by the log; the first bad exchange is 1.
fn reaction_ticks(ran: &Ran) -> usize {
    let states = ran.column("/bench", "state");
    let moving = states.iter().copied().fold(0.0, f64::max).min(3.0);
    let counters = ran.column("/bench", "working_counter");
    let full = counters.iter().copied().fold(0.0, f64::max);
    let first_bad = (0..states.len()).find(|&k| states[k] == moving && counters[k] < full);
    let stopped = (0..states.len()).rfind(|&k| states[k] == moving);
    stopped.unwrap_or(0) + 2 - first_bad.unwrap_or(0)
}

#[test]
fn a_move_over_an_ethercat_wire_is_completed_and_no_exchange_is_bad() {
    let ran = with(Vec::new());
    goes_on(&ran, "undisturbed");
    let counters = ran.column("/bench", "working_counter");
    let full = counters.iter().copied().fold(0.0, f64::max);
    assert_eq!(counters.iter().filter(|&&counter| counter != full).count(), 0);
    assert!((ran.largest("/az", "position_rad") - 60.0_f64.to_radians()).abs() < 0.01);
}

#[test]
fn a_fault_that_a_wire_may_have_now_and_then_is_counted_and_the_run_goes_on() {
    let rows = [
        LineFault::Drop { frames: 2 },
        LineFault::Delay { frames: 2, by: Duration::from_micros(50) },
        LineFault::Delay { frames: 2, by: Duration::from_millis(3) },
        LineFault::Duplicate { frames: 20 },
        LineFault::Corrupt { frames: 2, byte: 30 },
        LineFault::Truncate { frames: 2, bytes: 40 },
        LineFault::WorkingCounter { frames: 2, by: -1 },
        LineFault::ClockDrift { device: 1, rate_ppm: 100.0 },
        LineFault::Mute { device: 0, is_mute: true },
        LineFault::SlowMailbox { device: 0, take: Duration::from_millis(80) },
        LineFault::RefusesSdo { device: 0, code: Some(0x0800_0000) },
    ];
    for fault in rows {
        goes_on(&after(fault), &format!("{fault:?}"));
    }
}

/// Eight frames are those of four ticks at least: in some ticks one for a mailbox goes beside that of the process data.
#[test]
fn three_bad_exchanges_in_a_row_trip_in_the_tick_of_the_third() {
    let rows = [
        LineFault::Drop { frames: 8 },
        LineFault::Delay { frames: 8, by: Duration::from_millis(3) },
        LineFault::Truncate { frames: 8, bytes: 40 },
        LineFault::WorkingCounter { frames: 8, by: -1 },
        LineFault::Unplugged { device: 1, is_gone: true },
        LineFault::Unplugged { device: 0, is_gone: true },
    ];
    for fault in rows {
        let ran = after(fault);
        let is_for_good = matches!(fault, LineFault::Unplugged { .. });
        assert_eq!(ran.outcome.trip.map(|trip| trip.interlock), Some("bus"), "{fault:?}: {:?}", ran.outcome);
        assert_eq!(ran.contacts, 0, "{fault:?}");
        assert!(is_for_good || ran.outcome.safe.standstill, "{fault:?}: {:?}", ran.outcome.safe);
        assert_eq!(reaction_ticks(&ran), 3, "{fault:?}");
    }
}

#[test]
fn a_terminal_that_stays_out_trips_and_the_axes_are_seen_to_stand() {
    let ran = after(LineFault::Unplugged { device: 2, is_gone: true });
    trips(&ran, "bus", "the terminal is gone");
}

#[test]
fn five_bad_exchanges_among_a_hundred_trip() {
    let faults = (0..5).map(|k| (AT + Duration::from_millis(4 * k), LineFault::Drop { frames: 2 })).collect();
    trips(&with(faults), "bus", "frames lost every 16 ticks");
}

/// The drive stops by itself, which its statusword shows before three working counters are short.
#[test]
fn a_station_that_leaves_op_trips_and_the_log_says_why() {
    let rows = [
        (LineFault::AlError { device: 0, code: 0x001A }, "001Ah"),
        (LineFault::Watchdog { device: 0 }, "001Bh"),
    ];
    for (fault, code) in rows {
        let ran = after(fault);
        trips(&ran, "drive state", &format!("{fault:?}"));
        let notices = &ran.window.as_ref().expect("a log").notices;
        assert!(
            notices.iter().any(|n| n.starts_with("station 1: ") && n.contains(code)),
            "{fault:?}: {notices:?}"
        );
    }
}

/// Without SYNC0 a drive neither samples nor obeys: its inputs stand still, so nobody can say that its axis does.
#[test]
fn a_drive_without_sync0_trips_and_is_not_called_safe() {
    let ran = after(LineFault::Sync0Lost { device: 0, is_lost: true });
    assert!(ran.outcome.trip.is_some(), "{:?}", ran.outcome);
    assert!(!ran.outcome.safe.standstill, "{:?}", ran.outcome.safe);
    assert_eq!(ran.contacts, 0);
}

#[test]
fn an_emergency_message_is_in_the_log_with_its_meaning() {
    let emergency = Emergency { code: 0x4210, register: 0x09, vendor: [0; 5] };
    let ran = after(LineFault::Emergency { device: 1, emergency });
    goes_on(&ran, "only a message");
    let notices = &ran.window.as_ref().expect("a log").notices;
    assert!(notices.iter().any(|n| n.starts_with("station 2: emergency 4210h")), "{notices:?}");
}

#[test]
fn a_fault_of_a_drive_trips_and_its_emergency_message_is_in_the_log() {
    let case = case("az", [0.0, 40.0], vec![go_to(60.0, 6.0)]);
    let faults = vec![(AT, Fault::Drive { drive: 0, code: 0x7300 })];
    let bed = Bed { start_deg: [0.0, 40.0], faults, on_ethercat: Some(Vec::new()), ..Bed::new(case) };
    let ran = bed.run();
    trips(&ran, "drive state", "a fault of a sensor");
    let notices = &ran.window.as_ref().expect("a log").notices;
    assert!(notices.iter().any(|n| n.starts_with("station 1: emergency 7300h")), "{notices:?}");
}
