//! An analog terminal: ten inputs and four outputs of ±10 V, 16 bit, without mailbox.

use std::time::Duration;

use drivers::wire::BusState;

use super::application::{Application, ProcessDataBytes};
use super::sii::{Description, Pdo, PdoEntry};
use crate::bus::{Plant, VirtualBus};

/// Inputs of the terminal.
const INPUTS: usize = 10;
/// Outputs of the terminal.
const OUTPUTS: usize = 4;
/// Outputs, then inputs.
const PROCESS_DATA: [u16; 2] = [0x1000, 0x1100];
/// Largest number: 10 V.
const FULL_SCALE: f64 = 32_767.0;
const FULL_SCALE_V: f64 = 10.0;
/// The letters SIM: no real vendor has it.
const VENDOR: u32 = 0x0053_494D;
const PRODUCT: u32 = 0x0A04;
const NO_OBJECT: u32 = 0x0602_0000;

/// State of the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TerminalEnd {
    state: BusState,
}

impl TerminalEnd {
    /// A terminal after power-up.
    pub(crate) fn new() -> Self {
        Self { state: BusState::PreOp }
    }
}

/// The terminal in front of the analog channels of a plant.
pub(crate) struct WiredTerminal<'a, P: Plant> {
    pub(crate) bus: &'a mut VirtualBus<P>,
    pub(crate) end: &'a mut TerminalEnd,
}

impl<P: Plant> Application for WiredTerminal<'_, P> {
    fn upload(&mut self, _index: u16, _sub: u8) -> Result<Vec<u8>, u32> {
        Err(NO_OBJECT)
    }

    fn download(&mut self, _index: u16, _sub: u8, _data: &[u8]) -> Result<(), u32> {
        Err(NO_OBJECT)
    }

    fn indices(&self) -> Vec<u16> {
        Vec::new()
    }

    fn map(&mut self) -> Result<ProcessDataBytes, u32> {
        Ok(ProcessDataBytes { outputs: 2 * OUTPUTS, inputs: 2 * INPUTS })
    }

    fn state(&self) -> BusState {
        self.end.state
    }

    /// Without outputs from the bus all channels go to 0 V.
    fn enter(&mut self, state: BusState) {
        if self.end.state == BusState::Op && state < BusState::Op {
            let now = self.bus.now();
            (0..OUTPUTS).for_each(|channel| {
                self.bus.plant.write_v(now, channel, 0.0);
            });
        }
        self.end.state = state;
    }

    fn sample(&mut self, now: Duration, inputs: &mut [u8]) {
        self.bus.advance_to(now);
        for (channel, bytes) in inputs.chunks_exact_mut(2).enumerate() {
            let volts = self.bus.plant.read_v(now, channel).unwrap_or(0.0);
            bytes.copy_from_slice(&counts(volts).to_le_bytes());
        }
    }

    fn trigger(&mut self, now: Duration) {
        self.bus.trigger(now);
    }

    fn take(&mut self, now: Duration, outputs: &[u8]) {
        self.bus.advance_to(now);
        for (channel, bytes) in outputs.chunks_exact(2).enumerate() {
            let counts = f64::from(i16::from_le_bytes([bytes[0], bytes[1]]));
            self.bus.plant.write_v(now, channel, counts / FULL_SCALE * FULL_SCALE_V);
        }
    }
}

fn counts(volts: f64) -> i16 {
    (volts / FULL_SCALE_V * FULL_SCALE).round_ties_even().clamp(-FULL_SCALE, FULL_SCALE) as i16
}

/// What the SII of the terminal says.
pub(crate) fn description(serial: u32) -> Description {
    let pdo = |index: u16, sync_manager: u8, object: u16, count: usize| Pdo {
        index,
        sync_manager,
        entries: (0..count as u8).map(|k| PdoEntry { index: object, sub: k + 1, bits: 16 }).collect(),
    };
    Description {
        name: "SIM analog terminal".to_owned(),
        vendor: VENDOR,
        product: PRODUCT,
        revision: 1,
        serial,
        alias: 0,
        mailbox: None,
        process_data: PROCESS_DATA,
        outputs: vec![pdo(0x1600, 0, 0x7000, OUTPUTS)],
        inputs: vec![pdo(0x1A00, 1, 0x6000, INPUTS)],
    }
}
