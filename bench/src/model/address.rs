//! Addresses of ports: which connection, and where on it.

use std::fmt;

use drivers::wire::lines::{LINE_SORTS, LineAddress};

/// Where a device is connected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A far end in this process, `sim:imu`.
    Simulated {
        /// Its name.
        name: String,
    },
    /// A SubDevice on an EtherCAT wire, `ethercat:enp3s0/1001`.
    EtherCat {
        /// Network interface of the wire.
        interface: String,
        /// Alias of the SubDevice, or its place on the wire, from 1.
        station: u16,
    },
    /// A node on a CAN bus, `can:can0/5`.
    Can {
        /// Network interface of the bus.
        interface: String,
        /// Node-ID.
        node: u8,
    },
    /// A serial port, a TCP connection or a UDP port, `tcp:192.168.1.20:5025`.
    Line(LineAddress),
}

/// Longest name of a network interface (IFNAMSIZ less its NUL).
const LONGEST_INTERFACE: usize = 15;
/// Largest node-ID of a drive: 127 is the bench's own.
const MOST_NODE: u8 = 126;

impl Address {
    /// Reads an address.
    ///
    /// # Errors
    /// What is wrong with it, and how it is written.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (sort, rest) = text.split_once(':').unwrap_or((text, ""));
        match sort {
            "sim" if !rest.is_empty() => Ok(Self::Simulated { name: rest.to_owned() }),
            "ethercat" => ethercat(rest),
            "can" => can(rest),
            sort if LINE_SORTS.contains(&sort) => LineAddress::parse(text).map(Self::Line),
            _ => {
                let lines = LINE_SORTS.join(", ");
                Err(format!("write type and name, e.g. `sim:imu`; types are sim, ethercat, can, {lines}"))
            }
        }
    }
}

fn ethercat(rest: &str) -> Result<Address, String> {
    let expected = || {
        "write interface and station, e.g. `ethercat:enp3s0/1001`: the alias of the SubDevice, or its place on the \
         wire from 1"
            .to_owned()
    };
    let (interface, station) = rest.split_once('/').ok_or_else(expected)?;
    let station = station.parse().ok().filter(|&station: &u16| station > 0);
    match station {
        Some(station) if is_interface(interface) => {
            Ok(Address::EtherCat { interface: interface.to_owned(), station })
        }
        _ => Err(expected()),
    }
}

fn can(rest: &str) -> Result<Address, String> {
    let expected = || {
        format!("write interface and node-ID of 1 to {MOST_NODE}, e.g. `can:can0/5`: 127 is the bench's own")
    };
    let (interface, node) = rest.split_once('/').ok_or_else(expected)?;
    let node = node.parse().ok().filter(|node| (1..=MOST_NODE).contains(node));
    match node {
        Some(node) if is_interface(interface) => Ok(Address::Can { interface: interface.to_owned(), node }),
        _ => Err(expected()),
    }
}

/// Whether a text can be the name of a network interface.
fn is_interface(name: &str) -> bool {
    !name.is_empty()
        && name.len() <= LONGEST_INTERFACE
        && name.chars().all(|c| c.is_ascii_graphic() && c != ':')
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Simulated { name } => write!(f, "sim:{name}"),
            Self::EtherCat { interface, station } => write!(f, "ethercat:{interface}/{station}"),
            Self::Can { interface, node } => write!(f, "can:{interface}/{node}"),
            Self::Line(line) => line.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_a_connection_and_a_place_on_it() {
        let all = [
            "sim:imu",
            "ethercat:enp3s0/1001",
            "ethercat:ecm/1",
            "can:can0/5",
            "serial:/dev/ttyUSB0?baud=4147200",
            "tcp:192.168.1.20:5025",
            "udp:192.168.1.21:6000?bind=192.168.1.2:6001",
        ];
        for text in all {
            assert_eq!(Address::parse(text).map(|address| address.to_string()), Ok(text.to_owned()));
        }
    }

    #[test]
    fn what_is_no_address_is_told_how_one_is_written() {
        let wrong = [
            "",
            "sim",
            "sim:",
            "ethercat:",
            "ethercat:ecm",
            "ethercat:/1",
            "ethercat:ecm/",
            "ethercat:ecm/0",
            "ethercat:ecm/70000",
            "ethercat:ecm/-1",
            "ethercat:a b/1",
            "ethercat:0123456789abcdef/1",
            "can:",
            "can:can0",
            "can:can0/0",
            "can:can0/127",
            "can:/5",
            "serial:ttyUSB0",
            "tcp:5025",
            "udp:192.168.1.21:6000",
        ];
        for text in wrong {
            let error = Address::parse(text).expect_err(text);
            assert!(error.starts_with("write "), "{text}: {error}");
        }
    }
}
