//! Transfers with a simulated mailbox, which answers at once.

use std::time::Duration;

use drivers::wire::{Fieldbus, SdoAbort, SdoRequest};

/// Whole transfers, for tests.
pub(crate) trait AtOnce {
    /// Reads an object.
    fn upload(&mut self, station: u16, index: u16, sub: u8) -> Result<Vec<u8>, SdoAbort>;

    /// Writes an object.
    fn download(&mut self, station: u16, index: u16, sub: u8, data: &[u8]) -> Result<(), SdoAbort>;
}

impl AtOnce for dyn Fieldbus + '_ {
    fn upload(&mut self, station: u16, index: u16, sub: u8) -> Result<Vec<u8>, SdoAbort> {
        transfer(self, &SdoRequest { station, index, sub, write: None })
    }

    fn download(&mut self, station: u16, index: u16, sub: u8, data: &[u8]) -> Result<(), SdoAbort> {
        transfer(self, &SdoRequest { station, index, sub, write: Some(data) }).map(|_| ())
    }
}

fn transfer(bus: &mut dyn Fieldbus, request: &SdoRequest<'_>) -> Result<Vec<u8>, SdoAbort> {
    let mut answer = Vec::new();
    bus.start(Duration::ZERO, request);
    assert!(bus.poll(Duration::ZERO, &mut answer)?, "a simulated mailbox answers at once");
    Ok(answer)
}
