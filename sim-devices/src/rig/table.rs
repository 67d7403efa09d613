//! A simulated rotary table: axes, drives and the bus that carries them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Duration;

use super::handles::{BusHandle, DigitalCard};
use crate::bus::failure;
use crate::canopen::{self, CanOpenLine};
use crate::ethercat::{EtherCatLine, Line, LineSettings, Terminals};
use crate::faults::Fault;
use crate::physics::encoder::EncoderFault;
use crate::physics::noise::SeedAddress;
use crate::table::TableBus;
use crate::unit::TableSettings;
use crate::world::{AxisTruth, WorldRecord};
use drivers::device::DeviceError;
use drivers::wire::{DigitalPort, Fieldbus};

/// World, drives and bus of one simulated rotary table. It lives inside one thread; clones are the same rig.
///
/// Nothing on it works at the rate of the exchanges, so the host may exchange at any rate.
#[derive(Clone)]
pub struct SimulatedTable {
    bus: Rc<RefCell<TableBus>>,
}

impl SimulatedTable {
    /// A table at rest, bristles relaxed, heat sinks at ambient, drives switched on but not enabled. An axis that
    /// `start_rad` does not name stands at 0.
    pub fn new(settings: &TableSettings, address: &SeedAddress, start_rad: &BTreeMap<String, f64>) -> Self {
        Self { bus: Rc::new(RefCell::new(TableBus::of_table(settings, address, start_rad))) }
    }

    /// A handle to the one bus that carries all drives: station 1 is the first axis.
    pub fn bus(&self) -> Box<dyn Fieldbus> {
        Box::new(BusHandle::new(Rc::clone(&self.bus)))
    }

    /// From now on the drives follow SYNC0 with this cycle, and frames are meant to pass `shift` after each pulse.
    pub fn follow_sync0(&self, cycle: Duration, shift: Duration) {
        self.bus.borrow_mut().follow_sync0(cycle, shift);
    }

    /// EtherCAT SubDevices in front of the drives, and terminals behind them: station 1 is the first axis. Their clocks are
    /// perfect.
    pub fn ethercat_line(&self, terminals: Terminals) -> Box<dyn EtherCatLine> {
        let settings = LineSettings { terminals, ..LineSettings::default() };
        Box::new(Line::new(Rc::clone(&self.bus), &settings))
    }

    /// The digital terminal at the emergency stop chain, without a bus in front of it.
    pub fn digital_card(&self) -> Box<dyn DigitalPort> {
        Box::new(DigitalCard(Rc::clone(&self.bus)))
    }

    /// CANopen nodes in front of the drives: node 1 is the first axis.
    pub fn canopen_line(&self) -> Box<dyn CanOpenLine> {
        Box::new(canopen::Line::new(Rc::clone(&self.bus)))
    }

    /// From now on the encoder of a drive, 0 for station 1, has this fault, or none.
    ///
    /// # Errors
    /// When there is no such drive.
    pub fn inject_encoder_fault(&self, drive: usize, fault: Option<EncoderFault>) -> Result<(), DeviceError> {
        self.check_drive(Some(drive))?;
        self.bus.borrow_mut().inject_encoder_fault(drive, fault);
        Ok(())
    }

    /// A fault for this instant of world time; an instant that is over means now.
    ///
    /// # Errors
    /// When it befalls a drive or a device that this table does not have.
    pub fn schedule(&self, at: Duration, fault: Fault) -> Result<(), DeviceError> {
        self.check_drive(fault.drive())?;
        if fault.is_of_imu() {
            return Err(failure(format!("{fault:?}: a table has no inertial unit")));
        }
        self.bus.borrow_mut().schedule(at, fault);
        Ok(())
    }

    fn check_drive(&self, drive: Option<usize>) -> Result<(), DeviceError> {
        let count = self.bus.borrow().stations_count();
        match drive {
            Some(drive) if drive >= count => {
                Err(failure(format!("fault of drive {drive}: expected 0 to {}", count.saturating_sub(1))))
            }
            _ => Ok(()),
        }
    }

    /// Where the axes really are at the last instant that anybody looked at, in the order of their stations.
    pub fn truth_of_axes(&self) -> Vec<AxisTruth> {
        self.bus.borrow().plant.world.truth()
    }

    /// What happened so far.
    pub fn record(&self) -> WorldRecord {
        self.bus.borrow().plant.world.record()
    }
}

#[cfg(test)]
mod tests;
