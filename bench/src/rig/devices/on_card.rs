//! What every device has in common that is nothing but channels of an analog card.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::AnalogPort;

use crate::model::device::DeviceEntry;
use crate::rig::device::{Device, Group, LookedAt};
use crate::rig::wires::Ports;

/// Voltage that shows the range of a clamp or a gauge.
pub(super) const FULL_SCALE_V: f64 = 10.0;

/// Channels of an analog card that are one device.
pub(super) trait CardChannels {
    /// What it adds to the log.
    const GROUP: Group;

    /// One tick.
    ///
    /// # Errors
    /// When the card is gone or lacks a channel.
    fn read(&mut self, card: &mut dyn AnalogPort, now: Duration) -> Result<(), DeviceError>;

    /// Its values, in the order of its channels.
    fn values(&mut self) -> impl AsRef<[f64]>;

    /// Whether its rows mean anything in a point.
    fn is_looked_at(_looked_at: LookedAt) -> bool {
        true
    }
}

/// Such a device on its card.
pub(super) struct OnCard<C> {
    name: String,
    channels: C,
    port: String,
    card: usize,
}

impl<C> OnCard<C> {
    /// On a card that is not open yet.
    pub(super) fn closed(channels: C, entry: &DeviceEntry) -> Self {
        Self { name: entry.name.clone(), channels, port: entry.port("card").to_owned(), card: 0 }
    }
}

impl<C: CardChannels> Device for OnCard<C> {
    fn name(&self) -> &str {
        &self.name
    }

    fn open(&mut self, ports: &mut Ports, _now: Duration) -> Result<Option<()>, DeviceError> {
        self.card = ports.find_card(&self.name, &self.port)?;
        Ok(Some(()))
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        self.channels.read(ports.card(self.card), now)
    }

    fn group(&self) -> Group {
        C::GROUP
    }

    fn is_looked_at(&self, looked_at: LookedAt) -> bool {
        C::is_looked_at(looked_at)
    }

    fn row(&mut self, row: &mut [f64]) {
        let values = self.channels.values();
        let values = values.as_ref();
        row[..values.len()].copy_from_slice(values);
    }
}

/// A card for tests: `0` says how many volts an input shows when it is read.
#[cfg(test)]
pub(super) struct TestCard<F>(pub(super) F);

#[cfg(test)]
impl<F: FnMut(usize) -> f64> AnalogPort for TestCard<F> {
    fn name(&self) -> &str {
        "card"
    }

    fn write_v(&mut self, _now: Duration, _channel: usize, _volts: f64) -> Result<(), DeviceError> {
        Ok(())
    }

    fn read_v(&mut self, _now: Duration, channel: usize) -> Result<f64, DeviceError> {
        Ok((self.0)(channel))
    }
}
