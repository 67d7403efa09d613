//! Where the drives and terminals of a rig are connected: to the simulated bus of this process, or to an EtherCAT wire.

use procedures::table::TableReader;

use crate::model::address::Address;
use crate::model::device::DeviceEntry;
use crate::model::rig::Tier;

/// What is known of the wire while the axes are read.
pub(super) struct Connections {
    /// `None` where the tier is not known.
    tier: Option<Tier>,
    /// Interface of the first drive.
    interface: Option<String>,
    is_wrong: bool,
}

impl Connections {
    /// Nothing read yet.
    pub(super) fn new(tier: Option<Tier>) -> Self {
        Self { tier, interface: None, is_wrong: false }
    }

    fn mistake(&mut self, t: &mut TableReader<'_>, key: &'static str, message: String, help: &str) {
        self.is_wrong = true;
        t.mistake(key, message, Some(help.to_owned()));
    }

    /// Station of the drive of an axis: its place on the simulated bus, or on the wire.
    pub(super) fn station(&mut self, t: &mut TableReader<'_>) -> Option<u16> {
        let is_wired = self.tier.is_some_and(Tier::is_wired);
        match (t.has("station"), t.has("ports")) {
            (true, true) => {
                let help = "keep `station` for drives in this process, `ports` for drives on a wire";
                self.mistake(
                    t,
                    "ports",
                    "`station` and `ports` both say where the drive is".to_owned(),
                    help,
                );
                None
            }
            (false, true) => self.wired_station(t),
            (true, false) if is_wired => {
                let help = "write `ports = { bus = \"ethercat:enp3s0/1001\" }` instead";
                let message = "a drive on a wire needs an address; `station` is a place on the simulated bus";
                self.mistake(t, "station", message.to_owned(), help);
                None
            }
            (true, false) => u16::try_from(t.integer("station", 1)?).ok(),
            (false, false) => {
                let (message, help) = if is_wired {
                    ("the drive has no address", "write `ports = { bus = \"ethercat:enp3s0/1001\" }`")
                } else {
                    ("the drive has no place on the bus", "write `station = 1` for the first drive")
                };
                let key = if is_wired { "ports" } else { "station" };
                self.mistake(t, key, message.to_owned(), help);
                None
            }
        }
    }

    fn wired_station(&mut self, t: &mut TableReader<'_>) -> Option<u16> {
        let mut found = None;
        for (key, text, span) in t.map("ports")? {
            if key != "bus" {
                self.is_wrong = true;
                let help = Some("a drive has one port: `bus`".to_owned());
                t.mistake_at(span, format!("a drive has no port `{key}`"), help);
                continue;
            }
            let (interface, station) = match Address::parse(&text) {
                Ok(Address::EtherCat { interface, station }) => (interface, station),
                other => {
                    self.is_wrong = true;
                    let help = other.err().unwrap_or_else(|| "write e.g. `ethercat:enp3s0/1001`".to_owned());
                    t.mistake_at(span, format!("`{text}` is not the address of a drive"), Some(help));
                    continue;
                }
            };
            let first = self.interface.get_or_insert_with(|| interface.clone());
            if *first != interface {
                self.is_wrong = true;
                let help = "all drives of a rig share one wire, so that one frame a tick reaches them all";
                let message = format!("the drive is on `{interface}`, an earlier one on `{first}`");
                t.mistake_at(span, message, Some(help.to_owned()));
            }
            found = Some(station);
        }
        if found.is_none() && !self.is_wrong {
            let help = "write `ports = { bus = \"ethercat:enp3s0/1001\" }`";
            self.mistake(t, "ports", "the drive has no port `bus`".to_owned(), help);
        }
        found
    }

    /// The interface of the wire, `None` for a rig in this process; devices must be connected in the same way.
    pub(super) fn interface(
        mut self,
        t: &mut TableReader<'_>,
        devices: &[DeviceEntry],
    ) -> Option<Option<String>> {
        let is_wired = self.tier?.is_wired();
        if !is_wired && self.interface.is_some() {
            let help =
                "choose tier `wired` or `hardware`, or give each drive a `station` on the simulated bus";
            self.mistake(t, "tier", "this tier has no wires, but its drives have addresses".to_owned(), help);
        }
        for entry in devices {
            for (key, text) in &entry.ports {
                let fits = match Address::parse(text) {
                    Ok(Address::EtherCat { interface, .. }) => Some(&interface) == self.interface.as_ref(),
                    Ok(Address::Simulated { .. }) => !is_wired,
                    Err(_) => true,
                };
                if !fits {
                    let message = format!(
                        "`{}`: its port `{key}` is at `{text}`, not on the wire of the drives",
                        entry.name
                    );
                    let help = "devices of a rig in one process are at `sim:`, those of a wired rig on the interface of \
                                its drives";
                    self.mistake(t, "device", message, help);
                }
            }
        }
        (!self.is_wrong).then_some(self.interface)
    }
}
