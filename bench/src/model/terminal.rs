//! SubDevices on the wire of the drives that are none of them: terminals, couplers.

use super::address::Address;
use super::device::DeviceEntry;
use super::rig::Rig;

/// A SubDevice that a rig file names in `[[terminal]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Terminal {
    /// Name in messages.
    pub name: String,
    /// Station.
    pub station: u16,
    /// Vendor that it must have; `None` takes any.
    pub vendor: Option<u32>,
    /// Product code that it must have; `None` takes any.
    pub product: Option<u32>,
    /// Serial number that it must have; `None` takes any.
    pub serial: Option<u32>,
}

/// A digital input of a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TerminalInput {
    /// Station of the terminal.
    pub station: u16,
    /// The input, from 0.
    pub input: u16,
}

/// What a rig has at a station that is none of its drives'.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StationUse {
    /// Station.
    pub station: u16,
    /// Who names it: devices, `[[terminal]]`, the emergency stop.
    pub names: Vec<String>,
    /// Devices use it as an analog card.
    pub is_card: bool,
    /// The emergency stop is wired to one of its inputs.
    pub is_emergency_stop: bool,
    /// What `[[terminal]]` says of it.
    pub terminal: Option<Terminal>,
}

impl Rig {
    /// The rig with this device alone. The stations of the others stay known as terminals, so that nobody is surprised by them.
    #[must_use]
    pub(crate) fn with_only(&self, device: &DeviceEntry) -> Self {
        let mut alone = Self { devices: vec![device.clone()], ..self.clone() };
        let known: Vec<u16> = alone.stations_beside_drives().iter().map(|own| own.station).collect();
        for own in self.stations_beside_drives().into_iter().filter(|own| !known.contains(&own.station)) {
            let (station, name) = (own.station, own.names.join(", "));
            alone.terminals.push(Terminal { name, station, vendor: None, product: None, serial: None });
        }
        alone
    }

    /// The stations of the wire that are none of the drives', in ascending order.
    pub fn stations_beside_drives(&self) -> Vec<StationUse> {
        let mut all: Vec<StationUse> = Vec::new();
        for device in &self.devices {
            for text in device.ports.values() {
                if let Ok(Address::EtherCat { station, .. }) = Address::parse(text) {
                    let own = entry(&mut all, station);
                    own.names.push(device.name.clone());
                    own.is_card = true;
                }
            }
        }
        if let Some(TerminalInput { station, .. }) = self.emergency_stop_input {
            let own = entry(&mut all, station);
            own.names.push("emergency stop".to_owned());
            own.is_emergency_stop = true;
        }
        for terminal in &self.terminals {
            let own = entry(&mut all, terminal.station);
            own.names.push(terminal.name.clone());
            own.terminal = Some(terminal.clone());
        }
        all.sort_by_key(|own| own.station);
        all
    }
}

fn entry(all: &mut Vec<StationUse>, station: u16) -> &mut StationUse {
    let place = all.iter().position(|own| own.station == station).unwrap_or_else(|| {
        all.push(StationUse { station, ..StationUse::default() });
        all.len() - 1
    });
    &mut all[place]
}
