//! Simulated rigs: a world each and the far ends of all its wires.

mod handles;
mod table;

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use crate::canopen::{self, CanOpenLine};
use crate::director::DirectorBus;
use crate::ethercat::{ClockError, EtherCatLine, Line, LineSettings, Terminals};
use crate::reader::Reader;
use crate::scene::SceneTruth;
use crate::unit::UnitSettings;
use drivers::reader::ReaderProfile;
use drivers::wire::{AnalogPort, ByteLine, DatagramPort, DigitalPort, Fieldbus};
use handles::{
    AnalogCard, AnalyserLine, BusHandle, DigitalCard, ImuLine, MirrorLine, ReaderLine, ScopeLine, SupplyLine,
    TerminalCard, TrackerHandle,
};

pub use crate::cia402::DriveType;
pub use crate::faults::Fault;
pub use crate::payload::{DeviceTypes, ImuType, MirrorType};
pub use crate::physics::encoder::EncoderFault;
pub use crate::physics::noise::SeedAddress;
pub use crate::world::{AxesTruth, AxisTruth, StartState, WorldRecord};
pub use table::SimulatedTable;

/// Synchronisation pulses per second where nobody says otherwise: the loop of the director.
const SYNC_RATE_HZ: f64 = 4000.0;

/// World, drives, payload and wires of one simulated director. It lives inside one thread; clones are the same rig.
#[derive(Clone)]
pub struct SimulatedRig {
    bus: Rc<RefCell<DirectorBus>>,
}

impl SimulatedRig {
    /// A unit at rest, bristles relaxed, drives switched on but not enabled, exchanged with at 4 kHz.
    pub fn new(unit: &UnitSettings, address: &SeedAddress, start: StartState) -> Self {
        Self::at_rate(unit, address, start, SYNC_RATE_HZ)
    }

    /// A rig with another rate of exchange: each exchange is a synchronisation pulse for the inertial unit.
    pub fn at_rate(unit: &UnitSettings, address: &SeedAddress, start: StartState, sync_rate_hz: f64) -> Self {
        Self::with_devices(unit, address, start, sync_rate_hz, DeviceTypes::default())
    }

    /// A rig with devices of other makes on its gimbal.
    pub fn with_devices(
        unit: &UnitSettings,
        address: &SeedAddress,
        start: StartState,
        sync_rate_hz: f64,
        types: DeviceTypes,
    ) -> Self {
        let bus = DirectorBus::of_director(unit, address, start, sync_rate_hz, types);
        Self { bus: Rc::new(RefCell::new(bus)) }
    }

    /// A handle to the one bus that carries both drives: station 1 azimuth, station 2 elevation.
    pub fn bus(&self) -> Box<dyn Fieldbus> {
        Box::new(BusHandle::new(Rc::clone(&self.bus)))
    }

    /// From now on the drives follow SYNC0 with this cycle, and frames are meant to pass `shift` after each pulse. Without it a
    /// drive samples and acts when a frame passes.
    pub fn follow_sync0(&self, cycle: Duration, shift: Duration) {
        self.bus.borrow_mut().follow_sync0(cycle, shift);
    }

    /// EtherCAT SubDevices in front of the drives, and terminals behind them: station 1 azimuth, station 2 elevation, then the
    /// terminals. Whoever takes frames from a wire hands them to this line. The clock of the second drive is 20 ppm fast, so
    /// that a MainDevice has something to correct.
    pub fn ethercat_line(&self, terminals: Terminals) -> Box<dyn EtherCatLine> {
        Box::new(Line::new(Rc::clone(&self.bus), &LineSettings { clocks: clocks(), terminals }))
    }

    /// A drive (0 azimuth, 1 elevation) is of another type from now on; to be said before it is opened.
    pub fn make_drive(&self, drive: usize, drive_type: DriveType) {
        self.bus.borrow_mut().drive_mut(drive).become_type(drive_type);
    }

    /// The digital terminal at the emergency stop chain, without a bus in front of it.
    pub fn digital_card(&self) -> Box<dyn DigitalPort> {
        Box::new(DigitalCard(Rc::clone(&self.bus)))
    }

    /// CANopen nodes in front of the drives: node 1 azimuth, node 2 elevation.
    pub fn canopen_line(&self) -> Box<dyn CanOpenLine> {
        Box::new(canopen::Line::new(Rc::clone(&self.bus)))
    }

    /// The line of the inertial unit.
    pub fn imu_line(&self) -> Box<dyn ByteLine> {
        Box::new(ImuLine(Rc::clone(&self.bus)))
    }

    /// The serial line of the mirror.
    pub fn mirror_line(&self) -> Box<dyn ByteLine> {
        Box::new(MirrorLine(Rc::clone(&self.bus)))
    }

    /// The analog card: outputs 0 and 1 command the mirror, inputs 0 and 1 read its strain gauges; output 2 is the
    /// synchronisation signal, inputs 2 and 3 the autocollimator that looks at the mirror; output 3 is looped to input 4;
    /// inputs 5 and 6 are the autocollimators at the polygons on the axes.
    /// Inputs 7 and 8 are current clamps on supply and shunt of the DC link.
    pub fn analog_card(&self) -> Box<dyn AnalogPort> {
        Box::new(AnalogCard(Rc::clone(&self.bus)))
    }

    /// The analog card as a terminal on the bus of the drives: voltages leave with the next exchange and came with the last one; if
    /// the drives follow SYNC0, they act and are sampled at its pulses.
    pub fn terminal_card(&self) -> Box<dyn AnalogPort> {
        self.bus.borrow_mut().add_terminal();
        Box::new(TerminalCard(Rc::clone(&self.bus)))
    }

    /// The line of the impedance analyser.
    pub fn analyser_line(&self) -> Box<dyn ByteLine> {
        Box::new(AnalyserLine(Rc::clone(&self.bus)))
    }

    /// The line of the oscilloscope.
    pub fn scope_line(&self) -> Box<dyn ByteLine> {
        Box::new(ScopeLine(Rc::clone(&self.bus)))
    }

    /// The line of the DC supply.
    pub fn supply_line(&self) -> Box<dyn ByteLine> {
        Box::new(SupplyLine(Rc::clone(&self.bus)))
    }

    /// The line of an instrument of this type: autocollimators that look at the polygons on the axes, or the force gauge. Each
    /// call is another instrument.
    pub fn reader_line(&self, profile: Arc<ReaderProfile>) -> Box<dyn ByteLine> {
        Box::new(ReaderLine { shared: Rc::clone(&self.bus), reader: Reader::new(profile) })
    }

    /// The port of the coarse tracker.
    pub fn coarse_port(&self) -> Box<dyn DatagramPort> {
        Box::new(TrackerHandle { shared: Rc::clone(&self.bus), fine: false })
    }

    /// The port of the fine tracker.
    pub fn fine_port(&self) -> Box<dyn DatagramPort> {
        Box::new(TrackerHandle { shared: Rc::clone(&self.bus), fine: true })
    }

    /// Brings what is around a running unit as these settings have it: the target, whose course begins now, the frame rate
    /// of the fine camera, and whoever pulls. The unit itself stays as it is.
    pub fn bring(&self, unit: &UnitSettings, address: &SeedAddress) {
        let mut bus = self.bus.borrow_mut();
        let now = bus.now();
        bus.plant.bring(unit, address, now);
    }

    /// From now on the encoder of a drive (0 azimuth, 1 elevation) has this fault, or none.
    pub fn inject_encoder_fault(&self, drive: usize, fault: Option<EncoderFault>) {
        self.bus.borrow_mut().inject_encoder_fault(drive, fault);
    }

    /// A fault for this instant of world time; an instant that is over means now.
    pub fn schedule(&self, at: Duration, fault: Fault) {
        self.bus.borrow_mut().schedule(at, fault);
    }

    /// What the cameras look at as it really is, and the true angles of the mirror, at the last instant.
    pub fn truth(&self) -> (SceneTruth, [f64; 2]) {
        self.bus.borrow_mut().truth()
    }

    /// Where both axes really are at the last instant that anybody looked at.
    pub fn truth_of_axes(&self) -> AxesTruth {
        self.bus.borrow().plant.truth_of_axes()
    }

    /// What happened so far.
    pub fn record(&self) -> WorldRecord {
        self.bus.borrow().plant.record()
    }
}

/// Clocks of the drives as a crystal oscillator makes them.
fn clocks() -> Vec<ClockError> {
    let second = ClockError { rate_ppm: 20.0, phase_ns: 123_456_789 };
    vec![ClockError::default(), second]
}

#[cfg(test)]
mod tests;
