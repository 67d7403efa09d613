//! What can go wrong on the wire and at the SubDevices.

use std::time::Duration;

use super::super::faults::LineFault;
use super::super::line::{EtherCatLine, Passage, Terminals};
use super::bench::*;
use crate::rig::{SeedAddress, SimulatedRig, StartState};
use crate::unit::UnitSettings;

const MS: Duration = Duration::from_millis(1);

/// The line of a rig.
pub(super) struct RigLine(Box<dyn EtherCatLine>);

impl EtherCatLine for RigLine {
    fn pass(&mut self, now: Duration, frame: &mut [u8]) -> Passage {
        self.0.pass(now, frame)
    }

    fn advance(&mut self, now: Duration) {
        self.0.advance(now);
    }

    fn inject(&mut self, now: Duration, fault: LineFault) -> Result<(), String> {
        self.0.inject(now, fault)
    }

    fn names(&self) -> Vec<String> {
        self.0.names()
    }

    fn set_alias(&mut self, device: usize, alias: u16) -> Result<(), String> {
        self.0.set_alias(device, alias)
    }
}

/// Two drives and a terminal after power-up, and the rig that they belong to.
pub(super) fn unnumbered() -> (SimulatedRig, RigLine) {
    let address = SeedAddress { seed: 1, procedure: "line".to_owned(), point: String::new() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: 20.0 };
    let rig = SimulatedRig::new(&UnitSettings::default(), &address, start);
    let line = RigLine(rig.ethercat_line(Terminals { analog: true, digital: false }));
    (rig, line)
}

/// The same, numbered.
pub(super) fn rig_and_bench() -> (SimulatedRig, Bench<RigLine>) {
    let (rig, line) = unnumbered();
    let mut bench = Bench::new(line);
    bench.number();
    (rig, bench)
}

/// Two drives and a terminal, numbered.
pub(super) fn rig() -> Bench<RigLine> {
    rig_and_bench().1
}

/// The cable in front of a device breaks, or is mended.
pub(super) fn unplugged(device: usize, is_gone: bool) -> LineFault {
    LineFault::Unplugged { device, is_gone }
}

/// Bytes that a drive takes and gives as power-up maps them.
const DRIVE_BYTES: [u16; 2] = [10, 12];

impl Bench<RigLine> {
    fn inject(&mut self, fault: LineFault) {
        self.line.inject(self.now, fault).expect("a device");
    }

    fn survey(&mut self) -> (Passage, Vec<u8>) {
        let mut sent = frame(&[at(BRD, 0, 0x0000, &[0])]);
        let passage = self.send(&mut sent);
        (passage, sent)
    }

    fn count(&mut self) -> u16 {
        self.one(at(BRD, 0, 0x0000, &[0])).counter
    }
}

#[test]
fn frames_are_dropped_delayed_and_doubled_as_often_as_was_said() {
    let mut bench = rig();
    bench.inject(LineFault::Drop { frames: 2 });
    let answers = [(); 3].map(|()| bench.survey().0.answers);
    assert_eq!(answers, [0, 0, 1]);
    bench.inject(LineFault::Duplicate { frames: 1 });
    assert_eq!([(); 2].map(|()| bench.survey().0.answers), [2, 1]);
    bench.inject(LineFault::Delay { frames: 1, by: MS * 3 });
    assert_eq!([(); 2].map(|()| bench.survey().0.after), [MS * 3, Duration::ZERO]);
}

#[test]
fn an_answer_has_one_wrong_byte_or_is_cut_off() {
    let mut bench = rig();
    let (_, right) = bench.survey();
    bench.inject(LineFault::Corrupt { frames: 2, byte: 16 });
    let (_, wrong) = bench.survey();
    let differ: Vec<usize> = (0..right.len()).filter(|&k| right[k] != wrong[k]).collect();
    assert_eq!(differ, [16]);
    bench.inject(LineFault::Corrupt { frames: 1, byte: usize::MAX });
    let (_, wrong) = bench.survey();
    assert_ne!(wrong.last(), right.last(), "beyond the end means the last byte");
    bench.inject(LineFault::Truncate { frames: 1, bytes: 20 });
    assert_eq!(bench.survey().0.bytes, 20);
    bench.inject(LineFault::Truncate { frames: 1, bytes: 9999 });
    assert_eq!(bench.survey().0.bytes, right.len());
}

#[test]
fn working_counters_are_off_in_every_datagram() {
    let mut bench = rig();
    for (by, counters) in [(1, [4, 1]), (-3, [0, 0xFFFD]), (i16::MIN, [0x8003, 0x8000])] {
        bench.inject(LineFault::WorkingCounter { frames: 1, by });
        let answers = bench.pass(&[at(BRD, 0, 0, &[0]), at(FPRD, 0x2000, 0, &[0])]);
        assert_eq!([answers[0].counter, answers[1].counter], counters);
    }
    assert_eq!(bench.count(), 3);
}

#[test]
fn a_broken_cable_takes_all_devices_behind_it() {
    let mut bench = rig();
    assert_eq!(bench.count(), 3);
    assert_eq!(bench.read_u16(FIRST, 0x0110), 0x5A31);
    assert_eq!(bench.read_u16(FIRST + 2, 0x0110), 0x5611, "the last one");
    bench.inject(unplugged(1, true));
    assert_eq!(bench.count(), 1);
    assert_eq!(bench.read_u16(FIRST, 0x0110), 0x5611);
    bench.inject(unplugged(0, true));
    assert_eq!(bench.survey().0.answers, 0, "nobody is there");
    bench.inject(unplugged(0, false));
    assert_eq!(bench.count(), 1, "the other cable is still broken");
    bench.inject(unplugged(1, false));
    assert_eq!(bench.count(), 3);
    assert_eq!(bench.read_u16(FIRST, 0x0110), 0x5A31);
}

#[test]
fn a_link_that_is_lost_is_an_event_until_the_status_was_read() {
    let mut bench = rig();
    let events = |bench: &mut Bench<RigLine>| bench.one(at(BRD, 0, 0x0000, &[0])).events;
    bench.one(at(BWR, 0, 0x0200, &[0x04, 0]));
    assert_eq!(events(&mut bench), 0);
    bench.inject(unplugged(2, true));
    assert_eq!(events(&mut bench), 0x04);
    bench.read(FIRST, 0x0110, 2);
    assert_eq!(events(&mut bench), 0x04, "it is the second device that has it");
    bench.read(FIRST + 1, 0x0110, 2);
    assert_eq!(events(&mut bench), 0);
}

#[test]
fn a_device_that_comes_back_has_its_address_and_the_error_of_its_watchdog() {
    let mut bench = rig();
    let [outputs, inputs] = DRIVE_BYTES;
    bench.reach_op(FIRST + 1, outputs, inputs);
    bench.inject(unplugged(1, true));
    for _ in 0..30 {
        bench.wait(MS * 4);
        assert_eq!(bench.write(FIRST + 1, 0x1100, &[0; 10]), 0, "not reached");
    }
    bench.inject(unplugged(1, false));
    assert_eq!(bench.state(FIRST + 1), [0x14, 0x001B]);
    assert_eq!(bench.write(FIRST + 1, 0x1100, &[0; 10]), 1);
    assert_eq!(bench.asked(FIRST + 1, 0x18), [8, 0]);
}

#[test]
fn a_device_that_is_unplugged_for_a_moment_stays_in_op() {
    let mut bench = rig();
    let [outputs, inputs] = DRIVE_BYTES;
    bench.reach_op(FIRST + 1, outputs, inputs);
    bench.inject(unplugged(1, true));
    bench.wait(MS * 20);
    bench.inject(unplugged(1, false));
    assert_eq!(bench.state(FIRST + 1), [8, 0]);
}

#[test]
fn an_error_of_the_state_machine_ends_op_and_in_lower_states_is_only_shown() {
    let mut bench = rig();
    let [outputs, inputs] = DRIVE_BYTES;
    bench.reach_op(FIRST, outputs, inputs);
    bench.inject(LineFault::AlError { device: 0, code: 0x0032 });
    assert_eq!(bench.state(FIRST), [0x14, 0x0032]);
    bench.inject(LineFault::AlError { device: 1, code: 0x0001 });
    assert_eq!(bench.state(FIRST + 1), [0x11, 0x0001]);
    bench.inject(LineFault::Watchdog { device: 0 });
    assert_eq!(bench.read(FIRST, 0x0442, 1), [1]);
}

#[test]
fn a_watchdog_that_is_made_to_act_ends_op() {
    let mut bench = rig();
    let [outputs, inputs] = DRIVE_BYTES;
    bench.reach_op(FIRST, outputs, inputs);
    bench.inject(LineFault::Watchdog { device: 0 });
    assert_eq!(bench.state(FIRST), [0x14, 0x001B]);
    assert_eq!(bench.read(FIRST, 0x0440, 1)[0] & 1, 0);
}

#[test]
fn transitions_are_refused_by_the_code_that_was_chosen_until_that_is_over() {
    let mut bench = rig();
    bench.inject(LineFault::RefusesTransitions { device: 0, code: Some(0x0020) });
    bench.sync_manager(FIRST, 0, 0x1000, 128, 0x26);
    bench.sync_manager(FIRST, 1, 0x1080, 128, 0x22);
    assert_eq!(bench.asked(FIRST, 2), [0x11, 0x0020]);
    bench.inject(LineFault::RefusesTransitions { device: 0, code: None });
    assert_eq!(bench.asked(FIRST, 0x12), [2, 0]);
    bench.inject(LineFault::SlowTransitions { device: 1, take: MS * 5 });
    bench.sync_manager(FIRST + 1, 0, 0x1000, 128, 0x26);
    bench.sync_manager(FIRST + 1, 1, 0x1080, 128, 0x22);
    assert_eq!(bench.asked(FIRST + 1, 2), [1, 0]);
    bench.wait(MS * 6);
    assert_eq!(bench.state(FIRST + 1), [2, 0]);
}

#[test]
fn a_mailbox_is_mute_slow_or_refuses_every_transfer() {
    let upload = [0, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0];
    let mut bench = rig();
    bench.reach_pre_op(FIRST);
    bench.inject(LineFault::Mute { device: 0, is_mute: true });
    assert_eq!(bench.post(FIRST, 0x13, &upload), 1);
    bench.wait(MS * 100);
    assert_eq!(bench.fetch(FIRST), None);
    bench.inject(LineFault::Mute { device: 0, is_mute: false });
    bench.inject(LineFault::SlowMailbox { device: 0, take: MS * 10 });
    bench.post(FIRST, 0x23, &upload);
    assert_eq!(bench.fetch(FIRST), None);
    bench.wait(MS * 11);
    assert_eq!(bench.fetch(FIRST).map(|(kind, _)| kind), Some(0x23));
    bench.inject(LineFault::SlowMailbox { device: 0, take: Duration::ZERO });
    bench.inject(LineFault::RefusesSdo { device: 0, code: Some(0x0800_0022) });
    bench.post(FIRST, 0x33, &upload);
    let body = bench.fetch(FIRST).map(|(_, body)| body);
    assert_eq!(body, Some(vec![0, 0x20, 0x80, 0x00, 0x10, 0, 0x22, 0, 0, 0x08]));
    bench.inject(LineFault::RefusesSdo { device: 0, code: None });
    assert_eq!(bench.upload(FIRST, 0x1000, 0)[0], 0x43);
}

#[test]
fn clocks_jump_drift_and_lose_their_pulses() {
    let mut bench = rig();
    let read = |bench: &mut Bench<RigLine>| bench.read_u32(FIRST, 0x0910);
    let before = read(&mut bench);
    bench.inject(LineFault::ClockStep { device: 0, by_ns: 40_000 });
    assert_eq!(read(&mut bench) - before, 140_000, "one frame later");
    bench.inject(LineFault::ClockDrift { device: 0, rate_ppm: 1000.0 });
    let before = read(&mut bench);
    bench.wait(MS * 100 - Duration::from_micros(100));
    assert_eq!(read(&mut bench) - before, 100_100_000);
    bench.inject(LineFault::Sync0Lost { device: 0, is_lost: true });
    bench.inject(LineFault::Sync0Lost { device: 0, is_lost: false });
}

#[test]
fn faults_of_devices_that_do_not_exist_are_named() {
    let mut bench = rig();
    let error = bench.line.inject(MS, LineFault::Watchdog { device: 3 }).expect_err("three devices");
    assert_eq!(error, "no SubDevice 3: expected 0 to 2");
    assert!(bench.line.inject(MS, unplugged(9, true)).is_err());
    assert_eq!(bench.count(), 3);
}

#[test]
fn times_without_end_overflow_nothing() {
    let mut bench = rig();
    bench.reach_pre_op(FIRST);
    bench.inject(LineFault::SlowMailbox { device: 0, take: Duration::MAX });
    bench.inject(LineFault::SlowTransitions { device: 0, take: Duration::MAX });
    bench.inject(LineFault::ClockStep { device: 0, by_ns: i64::MIN });
    bench.inject(LineFault::ClockDrift { device: 1, rate_ppm: f64::INFINITY });
    bench.inject(LineFault::ClockDrift { device: 2, rate_ppm: f64::NAN });
    bench.post(FIRST, 0x13, &[0, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    bench.ask(FIRST, 4);
    bench.one(at(FRMW, FIRST, 0x0910, &[0; 8]));
    bench.wait(MS * 10);
    assert_eq!(bench.state(FIRST), [2, 0]);
    assert_eq!(bench.fetch(FIRST), None);
}

#[test]
fn the_wire_in_the_same_process_delays_without_end_too() {
    use drivers::wire::EthernetLink;
    let mut link = crate::ethercat::InProcessLink::new(Box::new(rig().line));
    link.line().inject(MS, LineFault::Delay { frames: 1, by: Duration::MAX }).expect("a fault of frames");
    let sent = frame(&[at(BRD, 0, 0x0000, &[0])]);
    link.send(&sent).expect("sent");
    link.send(&sent).expect("sent");
    link.wait(MS).expect("waited");
    let mut back = [0; 1600];
    assert_eq!(link.receive(&mut back).expect("received"), Some(sent.len()), "the second one");
    link.wait(MS).expect("waited");
    assert_eq!(link.receive(&mut back).expect("received"), None);
}
