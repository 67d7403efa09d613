//! SubDevices in front of nothing but what a test wants.

use std::collections::BTreeMap;
use std::time::Duration;

use drivers::wire::BusState;

use super::super::application::{Application, Emergency, ProcessDataBytes};
use super::super::command;
use super::super::esc::ClockError;
use super::super::faults::LineFault;
use super::super::frame;
use super::super::line::{EtherCatLine, Passage};
use super::super::sii::{Description, MailboxPlace, Pdo, PdoEntry};
use super::super::subdevice::SubDevice;
use super::bench::Bench;

/// An application that remembers what was done to it.
#[derive(Clone, Debug)]
pub(crate) struct Toy {
    pub(crate) objects: BTreeMap<(u16, u8), Vec<u8>>,
    /// Objects that may only be read.
    pub(crate) constants: Vec<(u16, u8)>,
    pub(crate) bytes: ProcessDataBytes,
    pub(crate) map_fails: bool,
    pub(crate) state: BusState,
    pub(crate) taken: Vec<(Duration, Vec<u8>)>,
    pub(crate) sampled: Vec<Duration>,
    pub(crate) tells: Option<Emergency>,
}

impl Toy {
    /// Four bytes each way, no objects.
    pub(crate) fn new() -> Self {
        Self {
            objects: BTreeMap::new(),
            constants: Vec::new(),
            bytes: ProcessDataBytes { outputs: 4, inputs: 4 },
            map_fails: false,
            state: BusState::PreOp,
            taken: Vec::new(),
            sampled: Vec::new(),
            tells: None,
        }
    }

    /// A toy with an object.
    pub(crate) fn with(mut self, index: u16, sub: u8, value: &[u8]) -> Self {
        self.objects.insert((index, sub), value.to_vec());
        self
    }
}

impl Application for Toy {
    fn upload(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        let is_there = self.objects.keys().any(|key| key.0 == index);
        let error = if is_there { 0x0609_0011 } else { 0x0602_0000 };
        self.objects.get(&(index, sub)).cloned().ok_or(error)
    }

    fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        let width = self.upload(index, sub)?.len();
        if self.constants.contains(&(index, sub)) {
            return Err(0x0601_0002);
        }
        if width != data.len() {
            return Err(0x0607_0010);
        }
        self.objects.insert((index, sub), data.to_vec());
        Ok(())
    }

    fn indices(&self) -> Vec<u16> {
        let mut indices: Vec<u16> = self.objects.keys().map(|key| key.0).collect();
        indices.dedup();
        indices
    }

    fn map(&mut self) -> Result<ProcessDataBytes, u32> {
        if self.map_fails { Err(0x0604_0041) } else { Ok(self.bytes) }
    }

    fn state(&self) -> BusState {
        self.state
    }

    fn enter(&mut self, state: BusState) {
        self.state = state;
    }

    /// Inputs are the time in µs, as far as they go.
    fn sample(&mut self, now: Duration, inputs: &mut [u8]) {
        self.sampled.push(now);
        for (byte, value) in inputs.iter_mut().zip((now.as_micros() as u32).to_le_bytes()) {
            *byte = value;
        }
    }

    fn trigger(&mut self, _now: Duration) {}

    fn take(&mut self, now: Duration, outputs: &[u8]) {
        self.taken.push((now, outputs.to_vec()));
    }

    fn emergency(&mut self) -> Option<Emergency> {
        self.tells.take()
    }
}

/// Toys in a line; no faults, no cables that break.
pub(super) struct ToyLine {
    pub(super) devices: Vec<SubDevice>,
    pub(super) toys: Vec<Toy>,
}

impl EtherCatLine for ToyLine {
    fn pass(&mut self, now: Duration, frame: &mut [u8]) -> Passage {
        for (device, toy) in self.devices.iter_mut().zip(&mut self.toys) {
            device.give_pulse(toy, now, false);
            device.advance(toy, now);
        }
        for device in &mut self.devices {
            let passed = frame::for_each_datagram(frame, |d| command::pass(&mut device.esc, d, now));
            if passed.is_err() {
                return Passage { answers: 0, bytes: 0, after: Duration::ZERO };
            }
        }
        frame::mark_as_answer(frame);
        self.devices.iter_mut().zip(&mut self.toys).for_each(|(device, toy)| device.serve(toy, now));
        Passage { answers: 1, bytes: frame.len(), after: Duration::ZERO }
    }

    fn advance(&mut self, now: Duration) {
        for (device, toy) in self.devices.iter_mut().zip(&mut self.toys) {
            device.give_pulse(toy, now, false);
            device.advance(toy, now);
            device.serve(toy, now);
        }
    }

    fn inject(&mut self, _now: Duration, _fault: LineFault) -> Result<(), String> {
        Err("nothing goes wrong here".to_owned())
    }

    fn names(&self) -> Vec<String> {
        self.devices.iter().map(|_| "toy".to_owned()).collect()
    }

    fn set_alias(&mut self, device: usize, alias: u16) -> Result<(), String> {
        let found = self.devices.get_mut(device).ok_or_else(|| format!("no toy {device}"))?;
        found.esc.set_alias(alias);
        Ok(())
    }
}

/// What the SII of a toy says.
pub(super) fn description(has_mailbox: bool) -> Description {
    let pdo = |index: u16, sync_manager: u8| Pdo {
        index,
        sync_manager,
        entries: vec![PdoEntry { index: 0x2000, sub: 0, bits: 32 }],
    };
    let mailbox = MailboxPlace { receive: 0x1000, send: 0x1080, length: 128 };
    Description {
        name: "toy".to_owned(),
        vendor: 1,
        product: 2,
        revision: 3,
        serial: 4,
        alias: 0,
        mailbox: has_mailbox.then_some(mailbox),
        process_data: [0x1100, 0x1400],
        outputs: vec![pdo(0x1600, if has_mailbox { 2 } else { 0 })],
        inputs: vec![pdo(0x1A00, if has_mailbox { 3 } else { 1 })],
    }
}

/// Toys in a line, numbered.
pub(super) fn toys(toys: Vec<Toy>) -> Bench<ToyLine> {
    let devices = toys.iter().map(|_| SubDevice::new(&description(true), ClockError::default())).collect();
    let mut bench = Bench::new(ToyLine { devices, toys });
    bench.number();
    bench
}

/// One toy.
pub(super) fn toy() -> Bench<ToyLine> {
    toys(vec![Toy::new()])
}
