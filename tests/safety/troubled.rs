//! A bus on which something happens at one exchange.

use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Duration;

use super::bed::Wrap;
use drivers::device::DeviceError;
use drivers::wire::{BusState, Exchange, Fieldbus, ProcessImage, SdoAbort, SdoRequest, SdoWire, Slot};

/// A bus on which something happens at one exchange.
struct Troubled {
    inner: Box<dyn Fieldbus>,
    exchanges: u32,
    at: u32,
    trouble: Trouble,
    behind: Duration,
}

#[derive(Clone)]
pub(super) enum Trouble {
    /// The thread of the loop panics.
    Panic,
    /// The thread of the loop stands for this long: no frame goes out, the world goes on.
    Hang(Duration),
    /// Somebody sends a signal with this exit code.
    Order(Arc<AtomicU16>, u16),
}

/// A wrapping for the bus of a bed.
pub(super) fn troubled(at: u32, trouble: Trouble) -> Wrap {
    Box::new(move |inner| {
        let trouble = trouble.clone();
        Box::new(Troubled { inner, exchanges: 0, at, trouble, behind: Duration::ZERO })
    })
}

impl SdoWire for Troubled {
    fn start(&mut self, now: Duration, request: &SdoRequest<'_>) {
        self.inner.start(now, request);
    }

    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        self.inner.poll(now, into)
    }
}

impl Fieldbus for Troubled {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn stations(&self) -> Vec<u16> {
        self.inner.stations()
    }

    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        self.inner.map()
    }

    fn request(&mut self, state: BusState) {
        self.inner.request(state);
    }

    fn state(&self) -> BusState {
        self.inner.state()
    }

    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        self.exchanges += 1;
        if self.exchanges == self.at {
            match &self.trouble {
                Trouble::Panic => panic!("planned by the test"),
                Trouble::Hang(time) => self.behind = *time,
                Trouble::Order(stop, code) => stop.store(*code, Ordering::Relaxed),
            }
        }
        self.inner.exchange(now + self.behind, image)
    }
}
