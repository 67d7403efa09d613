//! The host's ends of all wires of a rig.

use drivers::wire::{ByteLine, Fieldbus};

use crate::rig::device::Ports;

/// All wires.
pub struct Wires {
    /// Both drives.
    pub bus: Box<dyn Fieldbus>,
    /// What the devices hang on that are polled in the tick.
    pub ports: Ports,
    /// Instruments on the bench.
    pub instruments: InstrumentWires,
}

/// Wires of the instruments on the bench.
pub struct InstrumentWires {
    /// Impedance analyser.
    pub analyser: Box<dyn ByteLine>,
    /// Oscilloscope.
    pub scope: Box<dyn ByteLine>,
}
