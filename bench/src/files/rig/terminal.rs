//! `[[terminal]]`: SubDevices beside the drives, and the digital input to which the emergency stop is wired.

use std::ops::Range;

use procedures::table::{Field, Shape, TableReader};

use crate::files::profile::number;
use crate::model::address::Address;
use crate::model::terminal::{Terminal, TerminalInput};

/// Keys of `[[terminal]]`.
pub(super) const TERMINAL_FIELDS: &[Field] = &[
    Field::required("name", Shape::Text, "Name in messages, e.g. `coupler`."),
    Field::required(
        "address",
        Shape::Text,
        "Where it is, `ethercat:enp3s0/4`: network interface, then alias or place on the wire.",
    ),
    Field::optional("vendor", Shape::Integer, "Vendor that it must have, e.g. `0x2`."),
    Field::optional("product", Shape::Integer, "Product code that it must have."),
    Field::optional("serial", Shape::Integer, "Serial number that it must have."),
];

/// Key of the input to which the emergency stop is wired.
pub(super) const EMERGENCY_STOP: &str = "emergency-stop";

/// Something on the wire, with its interface and where it is written.
pub(super) struct OnWire<T> {
    pub(super) what: T,
    pub(super) interface: String,
    pub(super) place: Range<usize>,
}

/// Reads one `[[terminal]]`.
pub(super) fn read(t: &mut TableReader<'_>) -> Option<OnWire<Terminal>> {
    let name = t.text("name");
    let address = t.text("address");
    let vendor = number(t, "vendor");
    let product = number(t, "product");
    let serial = number(t, "serial");
    let place = t.span("address");
    let (interface, station) = match Address::parse(&address?) {
        Ok(Address::EtherCat { interface, station }) => (interface, station),
        other => {
            let help = other.err().unwrap_or_else(|| "write e.g. `ethercat:enp3s0/4`".to_owned());
            t.mistake("address", "this is not the address of a SubDevice", Some(help));
            return None;
        }
    };
    Some(OnWire { what: Terminal { name: name?, station, vendor, product, serial }, interface, place })
}

/// Reads `emergency-stop = "ethercat:enp3s0/4#0"`; `None` where the key is left out or wrong.
pub(super) fn read_input(t: &mut TableReader<'_>) -> Option<OnWire<TerminalInput>> {
    if !t.has(EMERGENCY_STOP) {
        return None;
    }
    let text = t.text(EMERGENCY_STOP)?;
    let found = text.split_once('#').and_then(|(address, input)| {
        let Ok(Address::EtherCat { interface, station }) = Address::parse(address) else { return None };
        Some((interface, TerminalInput { station, input: input.parse().ok()? }))
    });
    let Some((interface, what)) = found else {
        let help = "write the address of a digital terminal and its input from 0, e.g. `ethercat:enp3s0/4#0`";
        t.mistake(EMERGENCY_STOP, format!("`{text}` is not an input of a terminal"), Some(help.to_owned()));
        return None;
    };
    if t.has("emergency-stop-bit") {
        let help = "keep the one that the chain is wired to".to_owned();
        t.mistake(EMERGENCY_STOP, "`emergency-stop` and `emergency-stop-bit` both name an input", Some(help));
    }
    Some(OnWire { what, interface, place: t.span(EMERGENCY_STOP) })
}
