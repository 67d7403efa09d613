//! The lines of a served simulator: serial ones on pseudoterminals, TCP and UDP on the loopback interface, where the rig file says.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::Path;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::lines::LineAddress;
use drivers::wire::{ByteLine, DatagramPort};
use sim_devices::served::{LinePump, PortPump};

use crate::site::{FarEnd, FarLine};

/// All lines that are served.
pub(super) struct ServedLines(Vec<Served>);

/// A line, and whose it is.
struct Served {
    device: String,
    pump: Pump,
}

/// What moves bytes or datagrams, and the simulated device that it moves them for.
enum Pump {
    Line(Box<LinePump>, Box<dyn ByteLine>),
    Port(PortPump, Box<dyn DatagramPort>),
}

impl ServedLines {
    /// Serves these far ends at their addresses.
    ///
    /// # Errors
    /// An address that is not of this computer, or that something else uses.
    pub(super) fn open(far_lines: Vec<FarLine>) -> Result<Self, DeviceError> {
        far_lines.into_iter().map(serve).collect::<Result<_, _>>().map(Self)
    }

    /// Address and device of each, in the order of the rig file.
    pub(super) fn names(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|Served { device, pump }| match pump {
            Pump::Line(pump, _) => (pump.address(), device.as_str()),
            Pump::Port(pump, _) => (pump.address(), device.as_str()),
        })
    }

    /// Moves what is due at `now`, the time of the simulation. Never waits.
    ///
    /// # Errors
    /// When a simulated device is gone.
    pub(super) fn pump(&mut self, now: Duration) -> Result<(), DeviceError> {
        self.0.iter_mut().try_for_each(|served| match &mut served.pump {
            Pump::Line(pump, device) => pump.pump(&mut **device, now),
            Pump::Port(pump, device) => pump.pump(&mut **device, now),
        })
    }
}

fn serve(far_line: FarLine) -> Result<Served, DeviceError> {
    let FarLine { device, address, end } = far_line;
    let made = match (&address, end) {
        (LineAddress::Serial { path, baud }, FarEnd::Line(end)) => {
            LinePump::pty_at(Path::new(path), *baud).map(|pump| Pump::Line(Box::new(pump), end))
        }
        (LineAddress::Tcp { host, port }, FarEnd::Line(end)) => match loopback(host, false) {
            Ok(IpAddr::V4(Ipv4Addr::LOCALHOST)) => {
                LinePump::tcp(*port).map(|pump| Pump::Line(Box::new(pump), end))
            }
            Ok(other) => Err(foreign(&other.to_string())),
            Err(error) => Err(error),
        },
        (LineAddress::Udp { host, port, bind }, FarEnd::Port(end)) => loopback(host, bind.is_ipv6())
            .and_then(|own| PortPump::udp(SocketAddr::new(own, *port), *bind))
            .map(|pump| Pump::Port(pump, end)),
        (_, FarEnd::Line(_) | FarEnd::Port(_)) => {
            Err(io::Error::other("a device of another sort: bytes and datagrams do not mix"))
        }
    };
    let failed = |error: io::Error| DeviceError::Field {
        device: format!("{device} at {address}"),
        field: "address",
        expected: "a free address of this computer at which a simulator may serve it".to_owned(),
        found: error.to_string(),
        help: "serve a rig file whose serial lines are paths in a folder of your own, and whose hosts are 127.0.0.1",
    };
    let pump = made.map_err(failed)?;
    Ok(Served { device, pump })
}

/// The loopback address that a host of a rig file stands for.
fn loopback(host: &str, is_v6: bool) -> io::Result<IpAddr> {
    let address: IpAddr = match host {
        "localhost" if is_v6 => Ipv6Addr::LOCALHOST.into(),
        "localhost" => Ipv4Addr::LOCALHOST.into(),
        other => other.parse().map_err(|_| foreign(other))?,
    };
    if address.is_loopback() { Ok(address) } else { Err(foreign(host)) }
}

fn foreign(host: &str) -> io::Error {
    let why =
        format!("host {host}, which is not 127.0.0.1: a simulator must not answer where hardware may be");
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

#[cfg(test)]
mod tests;
