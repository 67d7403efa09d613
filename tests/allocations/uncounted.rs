//! Wires whose far ends are simulated: what those allocate is not counted.

use std::time::Duration;

use allocation_counter::opt_out;
use bench::rig::wires::{Ports, Wires};
use drivers::device::DeviceError;
use drivers::wire::{AnalogPort, BusState, ByteLine, DatagramPort, Exchange, Fieldbus, ProcessImage};
use drivers::wire::{PdoTransport, SdoAbort, SdoRequest, SdoWire, Slot};
use sim_devices::rig::SimulatedRig;

/// Anything whose allocations are not counted.
struct Uncounted<W: ?Sized>(Box<W>);

/// All wires of a simulated rig.
pub(super) fn wires(rig: &SimulatedRig) -> Wires {
    Wires {
        bus: Box::new(Uncounted(rig.bus())),
        ports: Ports::default()
            .with_line("sim:imu", Box::new(Uncounted(rig.imu_line())))
            .with_line("sim:mirror", Box::new(Uncounted(rig.mirror_line())))
            .with_card("sim:analog", Box::new(Uncounted(rig.analog_card())))
            .with_socket("sim:coarse", Box::new(Uncounted(rig.coarse_port())))
            .with_socket("sim:fine", Box::new(Uncounted(rig.fine_port())))
            .with_line("sim:analyser", Box::new(Uncounted(rig.analyser_line())))
            .with_line("sim:scope", Box::new(Uncounted(rig.scope_line()))),
    }
}

fn uncounted<T>(call: impl FnOnce() -> T) -> T {
    let mut answer = None;
    opt_out(|| answer = Some(call()));
    answer.expect("the call was made")
}

impl SdoWire for Uncounted<dyn Fieldbus> {
    fn pdo_transport(&self) -> PdoTransport {
        self.0.pdo_transport()
    }

    fn start(&mut self, now: Duration, request: &SdoRequest<'_>) {
        uncounted(|| self.0.start(now, request));
    }

    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        uncounted(|| self.0.poll(now, into))
    }
}

impl Fieldbus for Uncounted<dyn Fieldbus> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn stations(&self) -> Vec<u16> {
        self.0.stations()
    }

    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        uncounted(|| self.0.map())
    }

    fn request(&mut self, state: BusState) {
        uncounted(|| self.0.request(state));
    }

    fn state(&self) -> BusState {
        self.0.state()
    }

    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        uncounted(|| self.0.exchange(now, image))
    }
}

impl ByteLine for Uncounted<dyn ByteLine> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        uncounted(|| self.0.read(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        uncounted(|| self.0.write(now, bytes))
    }
}

impl AnalogPort for Uncounted<dyn AnalogPort> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn write_v(&mut self, now: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        uncounted(|| self.0.write_v(now, channel, volts))
    }

    fn read_v(&mut self, now: Duration, channel: usize) -> Result<f64, DeviceError> {
        uncounted(|| self.0.read_v(now, channel))
    }
}

impl DatagramPort for Uncounted<dyn DatagramPort> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        uncounted(|| self.0.receive(now, into))
    }

    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        uncounted(|| self.0.send(now, bytes))
    }
}
