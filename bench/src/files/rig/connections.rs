//! Where the drives and terminals of a rig are connected: to the simulated bus of this process, to an EtherCAT wire or to a CAN bus.

use std::ops::Range;

use procedures::table::TableReader;

use super::terminal::OnWire;
use crate::model::address::Address;
use crate::model::device::DeviceEntry;
use crate::model::rig::Tier;
use crate::model::terminal::{Terminal, TerminalInput};

/// What is known of the wire while the axes are read.
pub(super) struct Connections {
    /// `None` where the tier is not known.
    tier: Option<Tier>,
    /// Interface of the first drive.
    interface: Option<String>,
    /// The first drive is on a CAN bus.
    is_can: bool,
    /// Stations of the drives.
    drives: Vec<u16>,
    is_wrong: bool,
}

impl Connections {
    /// Nothing read yet.
    pub(super) fn new(tier: Option<Tier>) -> Self {
        Self { tier, interface: None, is_can: false, drives: Vec::new(), is_wrong: false }
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
            let (interface, station, is_can) = match Address::parse(&text) {
                Ok(Address::EtherCat { interface, station }) => (interface, station, false),
                Ok(Address::Can { interface, node }) => (interface, u16::from(node), true),
                other => {
                    self.is_wrong = true;
                    let help = other
                        .err()
                        .unwrap_or_else(|| "write e.g. `ethercat:enp3s0/1001` or `can:can0/5`".to_owned());
                    t.mistake_at(span, format!("`{text}` is not the address of a drive"), Some(help));
                    continue;
                }
            };
            if self.interface.is_none() {
                self.is_can = is_can;
            }
            let first = self.interface.get_or_insert_with(|| interface.clone());
            if *first != interface || self.is_can != is_can {
                self.is_wrong = true;
                let help = "all drives of a rig share one wire, so that one frame a tick reaches them all";
                let message = match self.is_can == is_can {
                    true => format!("the drive is on `{interface}`, an earlier one on `{first}`"),
                    false => "one drive is on EtherCAT, another one on a CAN bus".to_owned(),
                };
                t.mistake_at(span, message, Some(help.to_owned()));
            }
            self.drives.push(station);
            found = Some(station);
        }
        if found.is_none() && !self.is_wrong {
            let help = "write `ports = { bus = \"ethercat:enp3s0/1001\" }`";
            self.mistake(t, "ports", "the drive has no port `bus`".to_owned(), help);
        }
        found
    }

    /// Terminals and the emergency stop are on the wire of the drives, at stations of their own.
    pub(super) fn check_terminals(
        &mut self,
        t: &mut TableReader<'_>,
        terminals: &[OnWire<Terminal>],
        input: Option<&OnWire<TerminalInput>>,
    ) {
        for (k, terminal) in terminals.iter().enumerate() {
            self.check_station(t, &terminal.interface, terminal.what.station, &terminal.place);
            let earlier = terminals[..k].iter().find(|other| other.what.station == terminal.what.station);
            if let Some(earlier) = earlier {
                self.is_wrong = true;
                let (name, other) = (&terminal.what.name, &earlier.what.name);
                let message = format!("`{other}` and `{name}` are at the same station");
                let help = "each SubDevice has its own: correct one of the addresses".to_owned();
                t.mistake_at(terminal.place.clone(), message, Some(help));
            }
        }
        if let Some(input) = input {
            self.check_station(t, &input.interface, input.what.station, &input.place);
        }
    }

    fn check_station(
        &mut self,
        t: &mut TableReader<'_>,
        interface: &str,
        station: u16,
        place: &Range<usize>,
    ) {
        let (message, help) = if self.drives.contains(&station) {
            (format!("station {station} is that of a drive"), "name the station of the terminal")
        } else if self.is_can || self.interface.as_deref() != Some(interface) {
            let help = "terminals are on the interface of the drives; a rig in this process has none";
            (format!("`{interface}` is not the wire of the drives"), help)
        } else {
            return;
        };
        self.is_wrong = true;
        t.mistake_at(place.clone(), message, Some(help.to_owned()));
    }

    /// Whether the drives are on a CAN bus.
    pub(super) fn is_can(&self) -> bool {
        self.is_can
    }

    /// What is wrong with the address of a device, and what to do.
    fn misplaced(&self, is_wired: bool, address: &Address) -> Option<(&'static str, &'static str)> {
        let fits = match address {
            Address::EtherCat { interface, .. } => !self.is_can && Some(interface) == self.interface.as_ref(),
            Address::Can { .. } => false,
            Address::Simulated { .. } => !is_wired,
            Address::Line(_) => is_wired,
        };
        let told = match address {
            Address::Line(_) => (
                "outside this process",
                "choose tier `wired` or `hardware`, or write the name of its simulated end, e.g. `sim:imu`",
            ),
            _ => (
                "not on the wire of the drives",
                "devices of a rig in one process are at `sim:`, those of a wired rig on the interface of its drives or at \
                 `serial:`, `tcp:` or `udp:`",
            ),
        };
        (!fits).then_some(told)
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
                let address = Address::parse(text);
                if let Ok(Address::EtherCat { station, .. }) = &address
                    && self.drives.contains(station)
                {
                    let message =
                        format!("`{}`: its port `{key}` is at `{text}`, where a drive is", entry.name);
                    let help = "name the station of the terminal: what is written to it would be commands of the drive";
                    self.mistake(t, "device", message, help);
                    continue;
                }
                if let Some((what, help)) =
                    address.ok().and_then(|address| self.misplaced(is_wired, &address))
                {
                    let message = format!("`{}`: its port `{key}` is at `{text}`, {what}", entry.name);
                    self.mistake(t, "device", message, help);
                }
            }
        }
        (!self.is_wrong).then_some(self.interface)
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_rig;
    use super::super::tests::told;
    use crate::files::profile::simulated;
    use crate::files::shipped::{self, Folder};
    use crate::model::rig::Tier;
    use procedures::diagnostic::SourceFile;

    /// What is said of the shipped wired rig after these replacements, each of the first place where the text stands.
    fn said(edits: &[(&str, &str)]) -> String {
        let mut text = shipped::wired_without_lines();
        for (old, new) in edits {
            assert!(text.contains(old), "the rig file no longer says {old}");
            text = text.replacen(old, new, 1);
        }
        told(&read_rig(SourceFile::new("rig.toml", text)).err().unwrap_or_default())
    }

    #[test]
    fn the_shipped_wired_rig_is_on_one_wire_and_can_be_rehearsed_in_process() {
        let source = shipped::find(Folder::Rigs, "wired", None).expect("a shipped rig");
        let rig = read_rig(source).expect("it parses");
        assert_eq!((rig.tier, rig.interface()), (Tier::Wired, Some("ecm")));
        let rehearsed = rig.rehearsed_on(Tier::Virtual, &simulated());
        let stations: Vec<u16> = rehearsed.axes.iter().map(|axis| axis.drive.station).collect();
        assert_eq!((rehearsed.interface(), stations), (None, vec![1, 2]));
    }

    #[test]
    fn aliases_keep_their_order_when_a_rig_is_rehearsed() {
        let text = shipped::wired_without_lines();
        let text = text.replace("ecm/1\"", "ecm/2002\"").replace("ecm/2\"", "ecm/1001\"");
        let rig = read_rig(SourceFile::new("rig.toml", text)).expect("it parses");
        let rehearsed = rig.rehearsed_on(Tier::Paced, &simulated());
        let stations: Vec<u16> = rehearsed.axes.iter().map(|axis| axis.drive.station).collect();
        assert_eq!(stations, [2, 1], "azimuth has the higher alias");
    }

    #[test]
    fn drives_on_two_wires_are_refused() {
        insta::assert_snapshot!(said(&[("ethercat:ecm/2", "ethercat:ecx/2")]));
    }

    #[test]
    fn an_address_that_is_none_is_shown_how_one_is_written() {
        insta::assert_snapshot!(said(&[("ethercat:ecm/1", "ethercat:ecm")]));
    }

    #[test]
    fn a_drive_on_a_wire_needs_an_address_and_no_station() {
        insta::assert_snapshot!(said(&[("ports = { bus = \"ethercat:ecm/1\" }", "station = 1")]));
        insta::assert_snapshot!(said(&[("ports = { bus", "station = 1\nports = { bus")]));
    }

    #[test]
    fn an_analog_card_cannot_be_where_a_drive_is() {
        insta::assert_snapshot!(said(&[("card = \"ethercat:ecm/3\"", "card = \"ethercat:ecm/1\"")]));
    }

    /// With these lines at the end of the file.
    fn said_with(lines: &str) -> String {
        let text = shipped::wired_without_lines() + lines;
        told(&read_rig(SourceFile::new("rig.toml", text)).err().unwrap_or_default())
    }

    #[test]
    fn terminals_are_on_the_wire_of_the_drives_at_stations_of_their_own() {
        let terminal =
            |address: &str| format!("\n[[terminal]]\nname = \"{address}\"\naddress = \"{address}\"\n");
        assert_eq!(said_with(&(terminal("ethercat:ecm/3") + &terminal("ethercat:ecm/4"))), "");
        let wrong = ["ethercat:ecm/2", "ethercat:ecx/4", "sim:card", "ethercat:ecm/5", "ethercat:ecm/05"];
        insta::assert_snapshot!(said_with(&wrong.map(terminal).concat()));
    }

    #[test]
    fn an_emergency_stop_is_wired_to_a_drive_or_to_an_input_of_a_terminal() {
        let bit = "emergency-stop-bit = 3";
        assert_eq!(said(&[(bit, "emergency-stop = \"ethercat:ecm/4#0\"\n#")]), "");
        insta::assert_snapshot!(said(&[(
            bit,
            "emergency-stop = \"ethercat:ecm/4#0\"\nemergency-stop-bit = 3"
        )]));
        insta::assert_snapshot!(said(&[(bit, "emergency-stop = \"ethercat:ecm/4\"")]));
        insta::assert_snapshot!(said(&[(bit, "emergency-stop = \"ethercat:ecm/1#0\"")]));
    }

    #[test]
    fn one_station_written_in_two_ways_is_one_station() {
        let text = shipped::wired_without_lines();
        let text = text.replacen("ethercat:ecm/3", "ethercat:ecm/03", 1);
        let rig = read_rig(SourceFile::new("rig.toml", text)).expect("it parses");
        let beside = rig.stations_beside_drives();
        let names: Vec<(u16, Vec<String>)> = beside.into_iter().map(|own| (own.station, own.names)).collect();
        let devices = ["reference", "supply", "force"].map(str::to_owned).to_vec();
        assert_eq!(names, [(3, devices)]);
    }

    /// An inertial unit at this address, and a bit rate.
    fn imu(address: &str, baud: u32) -> String {
        format!(
            "\n[[device]]\nname = \"imu\"\ndriver = \"kvh-1775\"\nports = {{ line = \"{address}\" }}\nbaud = {baud}\n"
        )
    }

    /// An instrument at this address.
    fn instrument(name: &str, driver: &str, address: &str) -> String {
        format!(
            "\n[[device]]\nname = \"{name}\"\ndriver = \"{driver}\"\nports = {{ line = \"{address}\" }}\n"
        )
    }

    /// A tracker at this address.
    fn tracker(address: &str) -> String {
        format!(
            "\n[[device]]\nname = \"fine\"\ndriver = \"fine-tracker\"\nports = {{ socket = \"{address}\" }}\n\
             ifov-x = \"2 urad\"\nifov-y = \"2 urad\"\nmessage-delay = \"7.5 ms\"\n\
             message-delay-uncertainty = \"0.2 ms\"\n"
        )
    }

    #[test]
    fn devices_of_a_wired_rig_have_lines() {
        let lines = imu("serial:/dev/ttyUSB0?baud=4147200", 4_147_200)
            + &instrument("analyser", "e4990a", "tcp:192.168.1.20:5025")
            + &tracker("udp:[::1]:6000?bind=[::1]:06001");
        assert_eq!(said_with(&lines), "");
        let text = shipped::wired_without_lines() + &lines;
        let rig = read_rig(SourceFile::new("rig.toml", text)).expect("it parses");
        let ports = |rig: &crate::model::rig::Rig| {
            let all = rig.devices.iter().flat_map(|entry| entry.ports.values().cloned());
            all.filter(|text| !text.starts_with("ethercat:")).collect::<Vec<_>>()
        };
        let own =
            ["serial:/dev/ttyUSB0?baud=4147200", "tcp:192.168.1.20:5025", "udp:[::1]:6000?bind=[::1]:6001"];
        assert_eq!(ports(&rig), own);
    }

    #[test]
    fn a_line_is_of_the_sort_that_its_driver_speaks() {
        let wrong = imu("ethercat:ecm/4", 9600)
            + &instrument("analyser", "e4990a", "udp:127.0.0.1:6000?bind=127.0.0.1:6001")
            + &instrument("scope", "infiniivision", "tcp:5025")
            + &tracker("tcp:192.168.1.20:5025");
        insta::assert_snapshot!(said_with(&wrong));
        insta::assert_snapshot!(said(&[(
            "card = \"ethercat:ecm/3\"",
            "card = \"serial:/dev/ttyUSB0?baud=9600\""
        )]));
    }

    #[test]
    fn the_inertial_unit_and_its_line_have_one_bit_rate() {
        insta::assert_snapshot!(said_with(&imu("serial:/dev/ttyUSB0?baud=921600", 4_147_200)));
    }

    #[test]
    fn two_devices_do_not_share_a_line() {
        let twice = imu("serial:/dev/ttyUSB0?baud=921600", 921_600)
            + &instrument("analyser", "e4990a", "serial:/dev/ttyUSB0?baud=9600");
        insta::assert_snapshot!(said_with(&twice));
    }

    #[test]
    fn a_tier_in_process_has_no_lines_and_a_wired_one_no_simulated_ends() {
        insta::assert_snapshot!(said_with(&imu("sim:imu", 4_147_200)));
        let text = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig").text;
        let text = text.replacen("sim:scope", "tcp:192.168.1.20:5025", 1);
        insta::assert_snapshot!(told(&read_rig(SourceFile::new("rig.toml", text)).err().unwrap_or_default()));
    }

    #[test]
    fn a_tier_in_process_has_no_wires() {
        insta::assert_snapshot!(said(&[("tier = \"wired\"", "tier = \"paced\"")]));
    }
}
