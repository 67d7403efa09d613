//! Handles to the wires of a simulated rig: the host's ends.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::{
    AnalogPort, BusState, ByteLine, DatagramPort, DigitalPort, Exchange, Fieldbus, ProcessImage,
};
use drivers::wire::{PdoTransport, SdoAbort, SdoRequest, SdoWire, Slot};

use crate::analog_card::{ECHO_OUTPUT, FORCE_INPUT};
use crate::bus::{self, Plant, VirtualBus};
use crate::director::DirectorBus;
use crate::reader::Reader;

type Shared = Rc<RefCell<DirectorBus>>;

/// The bus of all drives.
pub(super) struct BusHandle<P: Plant> {
    bus: Rc<RefCell<VirtualBus<P>>>,
    /// Answer to the SDO transfer that was begun last.
    answer: Option<Result<Vec<u8>, SdoAbort>>,
}

impl<P: Plant> BusHandle<P> {
    pub(super) fn new(bus: Rc<RefCell<VirtualBus<P>>>) -> Self {
        Self { bus, answer: None }
    }
}

/// Line of the inertial unit.
pub(super) struct ImuLine(pub(super) Shared);

/// Serial line of the mirror.
pub(super) struct MirrorLine(pub(super) Shared);

/// Line of the impedance analyser.
pub(super) struct AnalyserLine(pub(super) Shared);

/// Line of the oscilloscope.
pub(super) struct ScopeLine(pub(super) Shared);

/// Line of the DC supply.
pub(super) struct SupplyLine(pub(super) Shared);

/// Line of an instrument that sends its readings as text.
pub(super) struct ReaderLine {
    pub(super) shared: Shared,
    pub(super) reader: Reader,
}

/// Analog card: what hangs on its channels stands in [`crate::analog_card`].
pub(super) struct AnalogCard(pub(super) Shared);

/// The analog card as a terminal on the bus of the drives: its voltages go with the frames.
pub(super) struct TerminalCard(pub(super) Shared);

/// Digital inputs: input 0 is on while the emergency stop chain is closed.
pub(super) struct DigitalCard<P: Plant>(pub(super) Rc<RefCell<VirtualBus<P>>>);

/// Port of a tracker.
pub(super) struct TrackerHandle {
    pub(super) shared: Shared,
    pub(super) fine: bool,
}

impl<P: Plant> SdoWire for BusHandle<P> {
    fn pdo_transport(&self) -> PdoTransport {
        PdoTransport::Assigned
    }

    /// A simulated mailbox answers at once.
    fn start(&mut self, _now: Duration, request: &SdoRequest<'_>) {
        let SdoRequest { station, index, sub, write } = *request;
        self.answer = Some(match write {
            None => self.bus.borrow().upload(station, index, sub),
            Some(data) => self.bus.borrow_mut().download(station, index, sub, data).map(|()| Vec::new()),
        });
    }

    fn poll(&mut self, _now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        let Some(answer) = self.answer.take() else { return Ok(false) };
        into.extend(answer?);
        Ok(true)
    }
}

impl<P: Plant> Fieldbus for BusHandle<P> {
    fn name(&self) -> &str {
        bus::name()
    }

    fn stations(&self) -> Vec<u16> {
        (1..).take(self.bus.borrow().stations_count()).collect()
    }

    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        self.bus.borrow_mut().map()
    }

    fn request(&mut self, state: BusState) {
        self.bus.borrow_mut().request(state);
    }

    fn state(&self) -> BusState {
        self.bus.borrow().state()
    }

    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        self.bus.borrow_mut().exchange(now, image)
    }
}

impl ByteLine for ImuLine {
    fn name(&self) -> &str {
        "imu line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        Ok(rig.plant.payload.imu.read(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        rig.plant.payload.imu.write(now, bytes);
        Ok(())
    }
}

impl ByteLine for MirrorLine {
    fn name(&self) -> &str {
        "mirror line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        Ok(rig.plant.payload.mirror.read(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        rig.plant.payload.mirror.write(now, bytes);
        Ok(())
    }
}

impl AnalogPort for AnalogCard {
    fn name(&self) -> &str {
        "analog card"
    }

    fn write_v(&mut self, now: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        if !rig.plant.write_v(now, channel, volts) {
            return Err(no_channel("output", channel, ECHO_OUTPUT));
        }
        Ok(())
    }

    fn read_v(&mut self, now: Duration, channel: usize) -> Result<f64, DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        rig.plant.read_v(now, channel).ok_or_else(|| no_channel("input", channel, FORCE_INPUT))
    }
}

impl AnalogPort for TerminalCard {
    fn name(&self) -> &str {
        "analog terminal"
    }

    fn write_v(&mut self, _now: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        let is_there = self.0.borrow_mut().write_terminal_v(channel, volts);
        if is_there { Ok(()) } else { Err(no_channel("output", channel, ECHO_OUTPUT)) }
    }

    fn read_v(&mut self, _now: Duration, channel: usize) -> Result<f64, DeviceError> {
        self.0.borrow().terminal_v(channel).ok_or_else(|| no_channel("input", channel, FORCE_INPUT))
    }
}

impl<P: Plant> DigitalPort for DigitalCard<P> {
    fn name(&self) -> &str {
        "digital terminal"
    }

    fn is_on(&mut self, now: Duration, input: usize) -> Result<Option<bool>, DeviceError> {
        const INPUTS: usize = 8;
        if input >= INPUTS {
            let reason = format!("no input {input}: 0 to {} are there", INPUTS - 1);
            return Err(DeviceError::Bus { device: self.name().to_owned(), reason });
        }
        let mut bus = self.0.borrow_mut();
        bus.advance_to(now);
        Ok(Some(input == 0 && !bus.emergency_stop_is_pressed()))
    }
}

fn no_channel(way: &str, channel: usize, last: usize) -> DeviceError {
    let reason = format!("no {way} {channel}: 0 to {last} are wired");
    DeviceError::Bus { device: "analog card".to_owned(), reason }
}

impl ByteLine for AnalyserLine {
    fn name(&self) -> &str {
        "analyser line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        Ok(rig.plant.instruments.analyser.take(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        rig.plant.instruments.analyser.receive(now, bytes);
        Ok(())
    }
}

impl ByteLine for ScopeLine {
    fn name(&self) -> &str {
        "scope line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        Ok(rig.plant.instruments.scope.take(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        rig.plant.instruments.scope.receive(now, bytes);
        Ok(())
    }
}

impl ByteLine for SupplyLine {
    fn name(&self) -> &str {
        "supply line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        Ok(rig.plant.instruments.supply.take(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut rig = self.0.borrow_mut();
        rig.advance_to(now);
        rig.plant.instruments.supply.receive(now, bytes);
        Ok(())
    }
}

impl ByteLine for ReaderLine {
    fn name(&self) -> &str {
        "reader line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let mut rig = self.shared.borrow_mut();
        rig.advance_to(now);
        Ok(self.reader.take(now, into, || rig.plant.readings(now)))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut rig = self.shared.borrow_mut();
        rig.advance_to(now);
        self.reader.receive(now, bytes, || rig.plant.readings(now));
        Ok(())
    }
}

impl DatagramPort for TrackerHandle {
    fn name(&self) -> &str {
        if self.fine { "fine tracker port" } else { "coarse tracker port" }
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        let mut rig = self.shared.borrow_mut();
        rig.advance_to(now);
        let scene = &mut rig.plant.payload.scene;
        if self.fine { scene.fine_port().receive(now, into) } else { scene.coarse_port().receive(now, into) }
    }

    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let mut rig = self.shared.borrow_mut();
        let scene = &mut rig.plant.payload.scene;
        if self.fine { scene.fine_port().send(now, bytes) } else { scene.coarse_port().send(now, bytes) }
    }
}
