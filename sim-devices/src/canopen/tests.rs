//! Nodes as a main device sees them, frame by frame.

use std::time::Duration;

use super::{CanOpenLine, NodeFault};
use crate::rig::{Fault, SeedAddress, SimulatedRig, StartState};
use crate::unit::UnitSettings;
use drivers::wire::can::{CanErrorFrame, CanEvent, CanFrame};
use proptest::prelude::*;

mod anything;

/// A director's nodes, and the time.
struct Network {
    rig: SimulatedRig,
    line: Box<dyn CanOpenLine>,
    now: Duration,
}

impl Network {
    /// Right after the boot-up messages.
    fn new() -> Self {
        let mut network = Self::silent();
        assert_eq!(network.given(), [frame(0x701, &[0]), frame(0x702, &[0])]);
        network
    }

    fn silent() -> Self {
        let address = SeedAddress { seed: 5, procedure: "TEST".into(), point: "1".into() };
        let start = StartState { az_rad: -1.0, el_rad: 1.2, heat_sink_degc: 45.0 };
        let rig = SimulatedRig::at_rate(&UnitSettings::default(), &address, start, 500.0);
        Self { line: rig.canopen_line(), rig, now: Duration::ZERO }
    }

    fn given(&mut self) -> Vec<CanFrame> {
        let events = std::iter::from_fn(|| self.line.give());
        let frames = events.map(|event| match event {
            CanEvent::Frame(frame) => frame,
            CanEvent::Error(error) => panic!("{error:?}"),
        });
        frames.collect()
    }

    /// Sends a frame; what the nodes answer.
    fn send(&mut self, id: u16, data: &[u8]) -> Vec<CanFrame> {
        self.line.take(self.now, &frame(id, data));
        self.given()
    }

    fn pass(&mut self, ms: u64) -> Vec<CanFrame> {
        self.now += Duration::from_millis(ms);
        self.line.advance(self.now);
        self.given()
    }

    /// Expedited upload from node 1: the answer's data.
    fn read(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let answer = self.send(0x601, &[0x40, low, high, sub, 0, 0, 0, 0]);
        let data = answer[0].data();
        assert_eq!((answer[0].id(), data[0] & 0xE3), (0x581, 0x43), "{index:04X}h:{sub}: {data:02X?}");
        u32::from_le_bytes([data[4], data[5], data[6], data[7]])
    }

    /// Expedited download to node 1; the abort code, 0 where it was taken.
    fn write(&mut self, index: u16, sub: u8, data: &[u8]) -> u32 {
        let [low, high] = index.to_le_bytes();
        let mut request = [0x23 | ((4 - data.len()) as u8) << 2, low, high, sub, 0, 0, 0, 0];
        request[4..4 + data.len()].copy_from_slice(data);
        let answer = self.send(0x601, &request);
        match answer[0].data() {
            [0x60, ..] => 0,
            &[0x80, _, _, _, a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            other => panic!("{other:02X?}"),
        }
    }

    /// The state that the heartbeat of node 1 tells.
    fn state(&mut self) -> u8 {
        assert_eq!(self.write(0x1017, 0, &[10, 0]), 0);
        let beats = self.pass(10);
        beats[0].data()[0]
    }
}

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(id, data).expect("a classic frame")
}

fn emergency(code: u16, register: u8) -> CanFrame {
    let [low, high] = code.to_le_bytes();
    frame(0x081, &[low, high, register, 0, 0, 0, 0, 0])
}

#[test]
fn nodes_boot_into_pre_operational_and_again_after_a_reset() {
    let mut network = Network::new();
    assert_eq!(network.state(), 0x7F);
    for command in [0x81, 0x82] {
        assert_eq!(network.send(0x000, &[command, 1]), [frame(0x701, &[0])]);
        assert_eq!(network.read(0x1017, 0), 0, "communication objects have their first values again");
    }
    assert_eq!(network.send(0x000, &[0x82, 0]).len(), 2, "node 0 is every node");
    assert_eq!(network.send(0x000, &[0x82, 3]), [], "another node");
}

#[test]
fn network_management_has_the_states_of_the_standard() {
    let mut network = Network::new();
    network.write(0x1017, 0, &[10, 0]);
    for (command, state) in
        [(0x01, 0x05), (0x80, 0x7F), (0x01, 0x05), (0x02, 0x04), (0x80, 0x7F), (0x02, 0x04)]
    {
        network.send(0x000, &[command, 1]);
        assert_eq!(network.pass(10), [frame(0x701, &[state])], "after command {command:02X}h");
    }
    assert_eq!(network.send(0x601, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]), [], "stopped: no SDO");
}

#[test]
fn heartbeats_come_at_their_period_and_stop_with_it() {
    let mut network = Network::new();
    network.write(0x1017, 0, &[50, 0]);
    let beats: usize = (0..1000).map(|_| network.pass(1).len()).sum();
    assert_eq!(beats, 20);
    network.write(0x1017, 0, &[0, 0]);
    assert_eq!(network.pass(500), []);
}

#[test]
fn a_supervised_heartbeat_that_stays_out_is_an_emergency_and_ends_operation() {
    let mut network = Network::new();
    assert_eq!(network.write(0x1016, 1, &[150, 0, 127, 0]), 0);
    network.send(0x000, &[0x01, 1]);
    assert_eq!(network.pass(1000), [], "supervision begins with the first heartbeat");
    network.send(0x77F, &[0x05]);
    assert_eq!(network.pass(149), []);
    network.send(0x77E, &[0x05]);
    assert_eq!(network.pass(1), [emergency(0x8130, 0x11)]);
    assert_eq!(network.state(), 0x7F);
    assert_eq!(network.pass(1000).iter().filter(|frame| frame.id() == 0x081).count(), 0, "told once");
}

#[test]
fn a_fault_of_the_drive_is_told_once_and_once_that_it_is_gone() {
    let mut network = Network::new();
    network.rig.schedule(Duration::from_millis(5), Fault::Drive { drive: 0, code: 0x4310 });
    assert_eq!(network.pass(10), [emergency(0x4310, 0x09)]);
    assert_eq!(network.pass(10), []);
    network.send(0x000, &[0x81, 1]);
    network
        .line
        .inject(network.now, NodeFault::Emergency { node: 1, code: 0x2001, register: 2 })
        .expect("node 1");
    assert_eq!(network.given(), [emergency(0x2001, 0x02)]);
}

#[test]
fn refusals_carry_the_abort_code_of_their_reason() {
    let mut network = Network::new();
    let cases: [(u16, u8, &[u8], u32); 16] = [
        (0x1C12, 0, &[0], 0x0602_0000),
        (0x1005, 0, &[0x81, 0, 0, 0], 0x0609_0030),
        (0x1014, 0, &[0, 0, 0, 0], 0x0601_0002),
        (0x1016, 3, &[0, 0, 0, 0], 0x0609_0011),
        (0x1016, 1, &[150, 0, 128, 0], 0x0609_0030),
        (0x1017, 0, &[10], 0x0607_0010),
        (0x1400, 2, &[0], 0x0609_0030),
        (0x1400, 2, &[255], 0x0609_0030),
        (0x1400, 1, &[0x02, 0x02, 0, 0], 0x0609_0030),
        (0x1400, 1, &[0x05, 0x06, 0, 0x80], 0x0609_0030),
        (0x1404, 1, &[0, 0, 0, 0], 0x0602_0000),
        (0x1600, 0, &[0], 0x0800_0022),
        (0x1601, 1, &[0x10, 0, 0x6C, 0x60], 0x0604_0041),
        (0x6041, 0, &[0, 0], 0x0601_0002),
        (0x6072, 0, &[0], 0x0607_0010),
        (0x605A, 0, &[9, 0], 0x0609_0031),
    ];
    for (index, sub, data, code) in cases {
        let found = network.write(index, sub, data);
        assert_eq!(found, code, "{index:04X}h:{sub}: {found:08X}h instead of {code:08X}h");
    }
}

#[test]
fn a_mapping_is_written_in_the_order_of_the_standard_and_read_back() {
    let mut network = Network::new();
    assert_eq!(network.write(0x1800, 1, &[0x81, 0x01, 0, 0x80]), 0, "switched off");
    assert_eq!(network.write(0x1A00, 1, &[0x20, 0, 0x64, 0x60]), 0x0601_0003, "its count is not 0");
    assert_eq!(network.write(0x1A00, 0, &[0]), 0);
    for (sub, word) in (1..).zip([0x6064_0020_u32, 0x606C_0020, 0x6041_0010]) {
        assert_eq!(network.write(0x1A00, sub, &word.to_le_bytes()), 0);
        assert_eq!(network.read(0x1A00, sub), word);
    }
    assert_eq!(network.write(0x1A00, 0, &[3]), 0x0604_0042, "80 bits");
    assert_eq!(network.write(0x1A00, 0, &[2]), 0);
    assert_eq!(network.write(0x1800, 1, &[0x85, 0x02, 0, 0]), 0, "another identifier");
    network.send(0x000, &[0x01, 1]);
    let inputs = network.send(0x080, &[]);
    assert_eq!((inputs[0].id(), inputs[0].data().len()), (0x285, 8));
    assert_eq!(network.write(0x1800, 1, &[0x85, 0x02, 0, 0x80]), 0x0800_0022, "operational");
}

#[test]
fn process_data_follow_sync_and_only_in_operational() {
    let mut network = Network::new();
    assert_eq!(network.send(0x080, &[]), [], "pre-operational");
    assert_eq!(network.send(0x000, &[0x01, 0]), []);
    let inputs = network.send(0x080, &[]);
    assert_eq!(inputs.iter().map(CanFrame::id).collect::<Vec<_>>(), [0x181, 0x182]);
    assert_eq!(inputs[0].data()[0] & 0x4F, 0x40, "switch on disabled");
    assert_eq!(network.send(0x201, &[0x06, 0, 0, 0, 0, 0, 0, 0]), []);
    network.pass(2);
    network.send(0x080, &[]);
    network.pass(50);
    let ready = network.send(0x080, &[]);
    assert_eq!(ready[0].data()[0] & 0x6F, 0x21, "ready to switch on");
    assert_eq!(network.read(0x6040, 0) & 0xFFFF, 0x06, "the controlword arrived");
    assert_eq!(network.send(0x201, &[0x06]), [emergency(0x8210, 0x11)], "shorter than mapped");
}

#[test]
fn a_transmission_type_of_3_sends_at_every_third_sync() {
    let mut network = Network::new();
    assert_eq!(network.write(0x1800, 2, &[3]), 0);
    network.send(0x000, &[0x01, 1]);
    let counts: Vec<_> = (0..7).map(|_| network.send(0x080, &[]).len()).collect();
    assert_eq!(counts, [0, 0, 1, 0, 0, 1, 0]);
}

#[test]
fn texts_are_read_in_segments() {
    let mut network = Network::new();
    let begin = network.send(0x601, &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(begin[0].data(), [0x41, 0x08, 0x10, 0, 15, 0, 0, 0]);
    let mut text = Vec::new();
    for toggle in [0x60, 0x70, 0x60] {
        let segment = network.send(0x601, &[toggle, 0, 0, 0, 0, 0, 0, 0]);
        let data = segment[0].data();
        text.extend_from_slice(&data[1..8 - usize::from(data[0] >> 1 & 7)]);
    }
    assert_eq!(text, b"SIM servo drive");
}

#[test]
fn faults_are_planted_and_put_right_again() {
    let mut network = Network::new();
    let request = [0x40, 0x00, 0x10, 0, 0, 0, 0, 0];
    for (on, off) in [
        (NodeFault::Silent { node: 1, is_silent: true }, NodeFault::Silent { node: 1, is_silent: false }),
        (NodeFault::SdoMute { node: 1, is_mute: true }, NodeFault::SdoMute { node: 1, is_mute: false }),
    ] {
        network.line.inject(network.now, on).expect("node 1");
        assert_eq!(network.send(0x601, &request), []);
        network.line.inject(network.now, off).expect("node 1");
        assert_eq!(network.send(0x601, &request).len(), 1);
    }
    network
        .line
        .inject(network.now, NodeFault::RefusesSdo { node: 1, code: Some(0x0800_0021) })
        .expect("node 1");
    assert_eq!(network.write(0x1017, 0, &[50, 0]), 0x0800_0021);
    network.line.inject(network.now, NodeFault::ControllerError(CanErrorFrame::BUS_OFF)).expect("the host's");
    assert_eq!(network.line.give(), Some(CanEvent::Error(CanErrorFrame::BUS_OFF)));
    let unknown = network.line.inject(network.now, NodeFault::Restart { node: 3 });
    assert_eq!(unknown, Err("no node 3: expected 1 to 2".to_owned()));
}
