//! The host's ends of all wires of a rig.

use drivers::wire::{AnalogPort, ByteLine, DatagramPort, Fieldbus};

/// All wires.
pub struct Wires {
    /// Both drives.
    pub bus: Box<dyn Fieldbus>,
    /// Devices on the gimbal.
    pub payload: PayloadWires,
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

/// Wires of the devices on the gimbal, by what hangs on them.
pub struct PayloadWires {
    /// Inertial measurement unit.
    pub imu: Box<dyn ByteLine>,
    /// Serial line of the mirror.
    pub mirror: Box<dyn ByteLine>,
    /// Analog card: commands and feedback of the mirror, synchronisation of the oscilloscope, autocollimator, loop-back.
    pub analog: Box<dyn AnalogPort>,
    /// Coarse tracker.
    pub coarse: Box<dyn DatagramPort>,
    /// Fine tracker.
    pub fine: Box<dyn DatagramPort>,
}
