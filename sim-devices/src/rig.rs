//! A simulated rig: the world and the far ends of all its wires.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use crate::bus::VirtualBus;
use crate::unit::UnitSettings;
use drivers::device::DeviceError;
use drivers::wire::{BusState, Exchange, Fieldbus, ProcessImage, SdoAbort, SdoWire, Slot};

pub use crate::physics::noise::SeedAddress;
pub use crate::world::{StartState, WorldRecord};

/// World, drives and bus of one simulated director. It lives inside one thread.
pub struct SimulatedRig {
    bus: Rc<RefCell<VirtualBus>>,
}

/// A host's end of the virtual bus.
struct BusHandle(Rc<RefCell<VirtualBus>>);

impl SimulatedRig {
    /// A unit at rest, bristles relaxed, drives switched on but not enabled.
    pub fn new(unit: &UnitSettings, address: &SeedAddress, start: StartState) -> Self {
        Self { bus: Rc::new(RefCell::new(VirtualBus::new(unit, address, start))) }
    }

    /// A handle to the one bus that carries both drives: station 1 azimuth, station 2 elevation.
    pub fn bus(&self) -> Box<dyn Fieldbus> {
        Box::new(BusHandle(Rc::clone(&self.bus)))
    }

    /// What happened so far.
    pub fn record(&self) -> WorldRecord {
        self.bus.borrow().record()
    }
}

impl SdoWire for BusHandle {
    fn upload(&mut self, station: u16, index: u16, sub: u8) -> Result<Vec<u8>, SdoAbort> {
        self.0.borrow().upload(station, index, sub)
    }

    fn download(&mut self, station: u16, index: u16, sub: u8, data: &[u8]) -> Result<(), SdoAbort> {
        self.0.borrow_mut().download(station, index, sub, data)
    }
}

impl Fieldbus for BusHandle {
    fn name(&self) -> &str {
        VirtualBus::name()
    }

    fn stations(&self) -> Vec<u16> {
        vec![1, 2]
    }

    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        self.0.borrow_mut().map()
    }

    fn request(&mut self, state: BusState) {
        self.0.borrow_mut().request(state);
    }

    fn state(&self) -> BusState {
        self.0.borrow().state()
    }

    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        self.0.borrow_mut().exchange(now, image)
    }
}

#[cfg(test)]
mod tests;
