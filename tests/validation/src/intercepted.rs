//! A bus whose traffic a test watches or disturbs on its way.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::{
    BusState, Exchange, Fieldbus, PdoTransport, ProcessImage, SdoAbort, SdoRequest, SdoWire, Slot,
};

/// What stands between the host and a bus. It passes every call on to the bus unless it does otherwise.
pub trait Interceptor {
    /// Begins a transfer.
    fn start(&mut self, bus: &mut dyn Fieldbus, now: Duration, request: &SdoRequest<'_>) {
        bus.start(now, request);
    }

    /// Whether the transfer is over; what was read is then in `into`.
    ///
    /// # Errors
    /// The bus refuses the transfer.
    fn poll(&mut self, bus: &mut dyn Fieldbus, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        bus.poll(now, into)
    }

    /// The bus has given out its process image with these slots.
    fn mapped(&mut self, _slots: &[(u16, Slot)]) {}

    /// An exchange is about to begin; gives the time that the bus takes for now.
    fn before_exchange(&mut self, now: Duration) -> Duration {
        now
    }

    /// An exchange has ended; `is_whole` where every station took part.
    fn after_exchange(&mut self, _now: Duration, _image: &ProcessImage, _is_whole: bool) {}
}

/// A bus behind an interceptor.
pub struct Intercepted<I> {
    bus: Box<dyn Fieldbus>,
    by: I,
}

impl<I: Interceptor + 'static> Intercepted<I> {
    /// Puts the interceptor in front of the bus.
    pub fn boxed(bus: Box<dyn Fieldbus>, by: I) -> Box<dyn Fieldbus> {
        Box::new(Self { bus, by })
    }
}

impl<I: Interceptor> SdoWire for Intercepted<I> {
    fn pdo_transport(&self) -> PdoTransport {
        self.bus.pdo_transport()
    }

    fn start(&mut self, now: Duration, request: &SdoRequest<'_>) {
        self.by.start(&mut *self.bus, now, request);
    }

    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        self.by.poll(&mut *self.bus, now, into)
    }
}

impl<I: Interceptor> Fieldbus for Intercepted<I> {
    fn name(&self) -> &str {
        self.bus.name()
    }

    fn stations(&self) -> Vec<u16> {
        self.bus.stations()
    }

    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        let mapped = self.bus.map()?;
        self.by.mapped(&mapped.1);
        Ok(mapped)
    }

    fn request(&mut self, state: BusState) {
        self.bus.request(state);
    }

    fn state(&self) -> BusState {
        self.bus.state()
    }

    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        let answer = self.bus.exchange(self.by.before_exchange(now), image);
        let is_whole = matches!(&answer, Ok(x) if x.working_counter == x.expected);
        self.by.after_exchange(now, image, is_whole);
        answer
    }
}
