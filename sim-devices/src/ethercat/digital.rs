//! A digital terminal: eight inputs, without mailbox. Input 0 is wired to the emergency stop chain, the others to nothing.

use std::time::Duration;

use drivers::wire::BusState;

use super::application::{Application, ProcessDataBytes};
use super::sii::{Description, Pdo, PdoEntry};
use crate::bus::{Plant, VirtualBus};

/// Inputs of the terminal.
const INPUTS: u8 = 8;
/// Outputs, of which there are none, then inputs.
const PROCESS_DATA: [u16; 2] = [0x1000, 0x1000];
/// The letters SIM: no real vendor has it.
const VENDOR: u32 = 0x0053_494D;
const PRODUCT: u32 = 0x0D08;
const NO_OBJECT: u32 = 0x0602_0000;

/// State of the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DigitalEnd {
    state: BusState,
}

impl DigitalEnd {
    /// A terminal after power-up.
    pub(crate) fn new() -> Self {
        Self { state: BusState::PreOp }
    }
}

/// The terminal at the emergency stop chain of a rig.
pub(crate) struct WiredInputs<'a, P: Plant> {
    pub(crate) bus: &'a mut VirtualBus<P>,
    pub(crate) end: &'a mut DigitalEnd,
}

impl<P: Plant> Application for WiredInputs<'_, P> {
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
        Ok(ProcessDataBytes { outputs: 0, inputs: usize::from(INPUTS / 8) })
    }

    fn state(&self) -> BusState {
        self.end.state
    }

    fn enter(&mut self, state: BusState) {
        self.end.state = state;
    }

    /// The contact of the chain gives a voltage while the chain is closed, so that a broken wire reads as an open chain.
    fn sample(&mut self, now: Duration, inputs: &mut [u8]) {
        self.bus.advance_to(now);
        inputs.fill(0);
        if let Some(first) = inputs.first_mut() {
            *first = u8::from(!self.bus.emergency_stop_is_pressed());
        }
    }

    fn trigger(&mut self, now: Duration) {
        self.bus.trigger(now);
    }

    fn take(&mut self, _now: Duration, _outputs: &[u8]) {}
}

/// What the SII of the terminal says.
pub(crate) fn description(serial: u32) -> Description {
    let entries = (1..=INPUTS).map(|sub| PdoEntry { index: 0x6000, sub, bits: 1 }).collect();
    Description {
        name: "SIM digital terminal".to_owned(),
        vendor: VENDOR,
        product: PRODUCT,
        revision: 1,
        serial,
        alias: 0,
        mailbox: None,
        process_data: PROCESS_DATA,
        outputs: Vec::new(),
        inputs: vec![Pdo { index: 0x1A00, sync_manager: 1, entries }],
    }
}
