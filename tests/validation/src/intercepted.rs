//! A bus whose traffic a test watches or disturbs on its way.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::{BusState, Exchange, Fieldbus, ProcessImage, SdoAbort, SdoRequest, SdoWire, Slot};

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

    /// Exchanges the process image.
    ///
    /// # Errors
    /// The bus fails.
    fn exchange(
        &mut self,
        bus: &mut dyn Fieldbus,
        now: Duration,
        image: &mut ProcessImage,
    ) -> Result<Exchange, DeviceError> {
        bus.exchange(now, image)
    }
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
        self.by.exchange(&mut *self.bus, now, image)
    }
}
