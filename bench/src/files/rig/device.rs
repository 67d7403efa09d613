//! `[[device]]`: a device of the rig, its driver, its ports and its settings.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use drivers::reader::{Measured, ReaderProfile};
use drivers::wire::lines::LineAddress;
use procedures::device::DeviceRole;
use procedures::diagnostic::Diagnostic;
use procedures::table::{Field, Shape, TableReader, suggestion};

use crate::files::reader;
use crate::model::address::Address;
use crate::model::device::{DeviceEntry, Setting};
use crate::rig::devices::{DRIVERS, driver};
use crate::rig::driver::{Driver, Misfit, PortSort};

/// Keys of `[[device]]`; its driver adds its own.
pub const DEVICE_FIELDS: &[Field] = &[
    Field::required("name", Shape::Text, "Name in messages and reports, e.g. `imu`."),
    Field::required(
        "driver",
        Shape::Text,
        "Driver of the device, e.g. `kvh-1775`; its keys are given in this table.",
    ),
    Field::required(
        "ports",
        Shape::Map(&Shape::Text),
        "Where it is connected, `{ line = \"sim:imu\" }`: type of the connection and address. On tiers `wired` and \
         `hardware` a line is `serial:PATH?baud=RATE` or `tcp:HOST:PORT`, a socket `udp:HOST:PORT?bind=ADDRESS:PORT`, a card \
         `ethercat:INTERFACE/STATION`. Several devices may share a card.",
    ),
];

/// A device, and where its table stands.
struct Placed {
    entry: DeviceEntry,
    place: Range<usize>,
}

/// Reads every `[[device]]`; `None` if any is wrong, or two of them clash. What is wrong in profiles of readers goes to
/// `of_profiles`.
pub(super) fn read_all(
    t: &mut TableReader<'_>,
    of_profiles: &mut Vec<Diagnostic>,
) -> Option<Vec<DeviceEntry>> {
    let before = t.mistakes();
    let placed = if t.has("device") { t.tables("device", |t| read(t, of_profiles))? } else { Vec::new() };
    clashes(t, &placed);
    let devices = placed.into_iter().map(|placed| placed.entry).collect();
    (t.mistakes() == before).then_some(devices)
}

/// Reads one `[[device]]`. What is wrong in the profile of a reader, which is a file of its own, goes to `of_profiles`.
fn read(t: &mut TableReader<'_>, of_profiles: &mut Vec<Diagnostic>) -> Option<Placed> {
    let name = t.text("name");
    let driver_name = t.text("driver");
    let Some(driver) = driver_name.as_deref().and_then(driver) else {
        if let Some(unknown) = driver_name {
            let help = suggestion(&unknown, DRIVERS.iter().map(|driver| driver.name));
            t.mistake("driver", format!("there is no driver `{unknown}`"), Some(help));
        }
        t.accept_any_key();
        return None;
    };
    t.extend(driver.fields);
    let before = t.mistakes();
    let ports = read_ports(t, driver);
    let settings = driver.fields.iter().filter_map(|field| Some((field.key, setting(t, field)?))).collect();
    let profile = match driver.has_profile {
        true => Some(profile(t, of_profiles)?),
        false => None,
    };
    let role = driver.role.or_else(|| profile.as_deref().map(role_of));
    let entry = DeviceEntry { name: name?, driver: driver.name, role, ports, settings, profile };
    // What a driver checks it may rely on, as a device may.
    if t.mistakes() > before {
        return None;
    }
    for Misfit { key, message, help } in (driver.check)(&entry) {
        t.mistake(key, message, help);
    }
    (t.mistakes() == before).then(|| Placed { entry, place: t.place() })
}

/// The profile that a reader names.
fn profile(t: &mut TableReader<'_>, of_profiles: &mut Vec<Diagnostic>) -> Option<Arc<ReaderProfile>> {
    match reader::load(&t.text("profile")?, Some(&t.source().name)) {
        Ok(profile) => Some(profile),
        Err(mistakes) => {
            of_profiles.extend(mistakes);
            None
        }
    }
}

/// What a reader is to procedures, by what it measures.
fn role_of(profile: &ReaderProfile) -> DeviceRole {
    match profile.scale(Measured::Force) {
        Some(_) => DeviceRole::ForceGauge,
        None => DeviceRole::AngleReference,
    }
}

fn setting(t: &mut TableReader<'_>, field: &Field) -> Option<Setting> {
    match field.shape {
        Shape::Quantity(_) => t.quantity(field.key).map(Setting::Number),
        Shape::Quantities(_) => t.quantities(field.key).map(Setting::Numbers),
        Shape::Integer => t.integer(field.key, i64::MIN).map(Setting::Integer),
        _ => t.text(field.key).map(Setting::Text),
    }
}

fn read_ports(t: &mut TableReader<'_>, driver: &Driver) -> BTreeMap<String, String> {
    let Some(given) = t.map("ports") else { return BTreeMap::new() };
    let mut ports = BTreeMap::new();
    let mut named_wrongly = Vec::new();
    for (key, address, span) in given {
        let Some(port) = driver.ports.iter().find(|port| port.key == key) else {
            let message = format!("driver `{}` has no port `{key}`", driver.name);
            let known = driver.ports.iter().map(|port| port.key);
            t.mistake_at(span, message, Some(suggestion(&key, known)));
            continue;
        };
        match Address::parse(&address).and_then(|read| check_sort(read, port.sort)) {
            // One text for one place: `ecm/03` is `ecm/3`.
            Ok(read) => {
                ports.insert(key, read.to_string());
            }
            Err(help) => {
                let message = format!("`{address}` is not the address of this port");
                t.mistake_at(span, message, Some(help));
                named_wrongly.push(key);
            }
        }
    }
    let is_missing =
        |key: &str| !ports.contains_key(key) && !named_wrongly.iter().any(|wrongly| wrongly == key);
    for port in driver.ports.iter().filter(|port| is_missing(port.key)) {
        let message = format!("driver `{}` needs the port `{}`", driver.name, port.key);
        t.mistake("ports", message, Some(port.doc.to_owned()));
    }
    ports
}

/// Refuses an address at which there can be no port of this sort.
///
/// # Errors
/// How an address for such a port is written.
fn check_sort(address: Address, sort: PortSort) -> Result<Address, String> {
    let help = match (&address, sort) {
        (Address::Simulated { .. }, _)
        | (Address::EtherCat { .. }, PortSort::Card)
        | (Address::Line(LineAddress::Serial { .. } | LineAddress::Tcp { .. }), PortSort::Line)
        | (Address::Line(LineAddress::Udp { .. }), PortSort::Socket) => return Ok(address),
        (_, PortSort::Card) => "an analog card is a terminal on EtherCAT: write e.g. `ethercat:enp3s0/3`",
        (_, PortSort::Line) => {
            "this port is a line of bytes: write e.g. `serial:/dev/ttyUSB0?baud=921600` or `tcp:192.168.1.20:5025`"
        }
        (_, PortSort::Socket) => {
            "datagrams arrive over UDP: write e.g. `udp:192.168.1.21:6000?bind=192.168.1.2:6001`"
        }
    };
    Err(help.to_owned())
}

/// What is wrong among the devices of a rig: names, roles, lines and channels that two of them have.
fn clashes(t: &mut TableReader<'_>, devices: &[Placed]) {
    check_lines(t, devices);
    for (index, Placed { entry, place }) in devices.iter().enumerate() {
        for Placed { entry: earlier, .. } in &devices[..index] {
            if earlier.name == entry.name {
                let help = "give each device its own name".to_owned();
                t.mistake_at(place.clone(), format!("two devices are called `{}`", entry.name), Some(help));
            } else if let Some(role) = entry.role.filter(|_| earlier.role == entry.role) {
                let message =
                    format!("`{}` and `{}` have the same role: {}", earlier.name, entry.name, role.noun());
                let help = "a rig has at most one device per role: remove one".to_owned();
                t.mistake_at(place.clone(), message, Some(help));
            } else if entry.role.is_none() && earlier.driver == entry.driver {
                let message = format!(
                    "`{}` and `{}` have the same driver, and would share a topic of the log: `{}`",
                    earlier.name, entry.name, entry.driver
                );
                let help = "a rig has at most one device of this driver: remove one".to_owned();
                t.mistake_at(place.clone(), message, Some(help));
            }
        }
    }
    let mut taken: Vec<(Channel<'_>, &DeviceEntry, &str)> = Vec::new();
    for Placed { entry, place } in devices {
        for (channel, key) in channels(entry) {
            if let Some((_, other, other_key)) = taken.iter().find(|(known, ..)| *known == channel) {
                let message = format!(
                    "`{}` ({}) and `{}` ({other_key}) share {} {} of {}",
                    entry.name, key, other.name, channel.sort, channel.number, channel.card
                );
                t.mistake_at(place.clone(), message, Some("give each signal its own channel".to_owned()));
            }
            taken.push((channel, entry, key));
        }
    }
}

/// A serial port, a TCP connection or a UDP port belongs to one device.
fn check_lines(t: &mut TableReader<'_>, devices: &[Placed]) {
    let mut taken: Vec<(LineAddress, &str)> = Vec::new();
    for Placed { entry, place } in devices {
        for line in entry.lines() {
            if let Some((_, other)) = taken.iter().find(|(earlier, _)| is_one_line(earlier, &line)) {
                let message = format!("`{other}` and `{}` are at one line: `{line}`", entry.name);
                let help = "each device has a line of its own: correct one of the addresses".to_owned();
                t.mistake_at(place.clone(), message, Some(help));
            }
            taken.push((line, &entry.name));
        }
    }
}

/// Whether two addresses are one port of this computer, or one of a device.
fn is_one_line(one: &LineAddress, other: &LineAddress) -> bool {
    match (one, other) {
        (LineAddress::Serial { path, .. }, LineAddress::Serial { path: other, .. }) => path == other,
        (LineAddress::Udp { bind, .. }, LineAddress::Udp { bind: other, .. }) => bind == other,
        _ => one == other,
    }
}

/// A channel of an analog card.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Channel<'a> {
    card: &'a str,
    sort: &'static str,
    number: i64,
}

/// Channels that a device takes of an analog card: its whole numbers whose keys end with `input` or `output`.
fn channels(entry: &DeviceEntry) -> impl Iterator<Item = (Channel<'_>, &'static str)> {
    let card = entry.ports.get("card");
    let taken = move |(&key, setting): (&&'static str, &Setting)| {
        let Setting::Integer(number) = *setting else { return None };
        let sort = ["input", "output"].into_iter().find(|sort| key.ends_with(sort))?;
        Some((Channel { card: card?, sort, number }, key))
    };
    entry.settings.iter().filter_map(taken)
}
