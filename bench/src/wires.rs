//! The host's ends of all wires of a rig.

use drivers::wire::{AnalogPort, ByteLine, DatagramPort, Fieldbus};
use sim_devices::rig::SimulatedRig;

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

impl Wires {
    /// The wires of a simulated rig.
    pub fn simulated(rig: &SimulatedRig) -> Self {
        Self {
            bus: rig.bus(),
            payload: PayloadWires {
                imu: rig.imu_line(),
                mirror: rig.mirror_line(),
                analog: rig.analog_card(),
                coarse: rig.coarse_port(),
                fine: rig.fine_port(),
            },
            instruments: InstrumentWires { analyser: rig.analyser_line(), scope: rig.scope_line() },
        }
    }
}
