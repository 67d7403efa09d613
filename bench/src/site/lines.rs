//! Serial ports, TCP connections and UDP ports of a rig: opened at the host's end, with the grounds on which a device behind one
//! counts as real.

use std::fs;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, ToSocketAddrs, UdpSocket};
use std::os::unix::fs::MetadataExt;
use std::thread;

use drivers::device::DeviceError;
use drivers::wire::lines::{LineAddress, Lines};

use super::interface::{Interface, Kernel};
use crate::clock::Clock;
use crate::model::device::DeviceEntry;
use crate::model::rig::Rig;
use crate::realtime::privileges;
use crate::rig::identities::LineGrounds;
use crate::rig::wires::Ports;

/// Major numbers of the far sides that programs have of pseudoterminals (Linux, Documentation/admin-guide/devices.txt).
const PTY_MAJORS: std::ops::RangeInclusive<u32> = 136..=143;
/// Port of the service `discard`: no datagram is sent, a route is looked up.
const DISCARD_PORT: u16 = 9;

/// Opens every line and datagram port that the devices of a rig name, and hands them to `ports` under their addresses. Nothing is
/// started for a rig without any. To be called before the thread asks for real-time rights: whatever moves bytes inherits them.
///
/// # Errors
/// The first line that is missing, refused or in use; the device that hangs on it is named.
pub(crate) fn open(
    rig: &Rig,
    mut ports: Ports,
    clock: &Clock,
) -> Result<(Ports, Vec<LineGrounds>), DeviceError> {
    let all: Vec<(&DeviceEntry, LineAddress)> =
        rig.devices.iter().flat_map(|entry| entry.lines().map(move |line| (entry, line))).collect();
    if all.is_empty() {
        return Ok((ports, Vec::new()));
    }
    let kernel = Kernel::default();
    let mut lines = start(clock)?;
    let mut grounds = Vec::new();
    for (entry, line) in &all {
        let name = line.to_string();
        let named = |error: DeviceError| error.of_device(&entry.name);
        ports = match line {
            LineAddress::Serial { .. } | LineAddress::Tcp { .. } => {
                ports.with_line(&name, Box::new(lines.open_line(line).map_err(named)?))
            }
            LineAddress::Udp { .. } => {
                ports.with_socket(&name, Box::new(lines.open_port(line).map_err(named)?))
            }
        };
        grounds.push(grounds_of(&kernel, line));
    }
    Ok((ports.with_mover(lines), grounds))
}

/// Starts what moves bytes, in a thread without privileges: it inherits those of the one that starts it.
fn start(clock: &Clock) -> Result<Lines, DeviceError> {
    let clock = clock.clone();
    let started = thread::spawn(move || {
        privileges::give_up();
        Lines::start(Box::new(move || clock.now()))
    });
    started.join().unwrap_or_else(|_| {
        let reason = "the thread that starts them ended without a result".to_owned();
        Err(DeviceError::Bus { device: "lines".to_owned(), reason })
    })
}

/// Whether a device behind a line may exist.
fn grounds_of(kernel: &Kernel, line: &LineAddress) -> LineGrounds {
    let (is_physical, text) = match line {
        LineAddress::Serial { path, .. } => serial_grounds(kernel, path),
        LineAddress::Tcp { host, port } | LineAddress::Udp { host, port, .. } => {
            peer_grounds(kernel, host, *port)
        }
    };
    LineGrounds { address: line.to_string(), is_physical, text }
}

/// A serial port is told by the number of its device file: its name may be that of a link to anything.
fn serial_grounds(kernel: &Kernel, path: &str) -> (bool, String) {
    let Ok(number) = fs::metadata(path).map(|found| found.rdev()) else {
        return (false, format!("nothing proves that a serial port is at {path}"));
    };
    let (major, minor) = (rustix::fs::major(number), rustix::fs::minor(number));
    if PTY_MAJORS.contains(&major) {
        return (false, format!("{path} is a pseudoterminal: a program is at its far end"));
    }
    match kernel.has_device(major, minor) {
        true => (true, format!("serial port {path} has a physical device")),
        false => (false, format!("serial port {path} has no physical device")),
    }
}

/// A peer is real only behind an interface with a physical device: every address that its name stands for.
fn peer_grounds(kernel: &Kernel, host: &str, port: u16) -> (bool, String) {
    let peers: Vec<IpAddr> =
        (host, port).to_socket_addrs().into_iter().flatten().map(|peer| peer.ip()).collect();
    if let Some(own) = peers.iter().find(|peer| is_own(**peer)) {
        return (false, format!("peer {own} is an address of this computer"));
    }
    let mut found =
        peers.iter().map(|peer| through(route(kernel, *peer).as_ref(), *peer)).collect::<Vec<_>>();
    // One that is not physical decides.
    found.sort_by_key(|(is_physical, _)| *is_physical);
    found.into_iter().next().unwrap_or_else(|| (false, format!("peer {host} has no address")))
}

/// Whether an address is that of the loopback interface or of another interface of this computer: only there a socket can listen.
fn is_own(peer: IpAddr) -> bool {
    peer.is_loopback() || UdpSocket::bind((peer, 0)).is_ok()
}

/// The interface through which a peer is reached.
fn route(kernel: &Kernel, peer: IpAddr) -> Option<Interface> {
    let any = if peer.is_ipv4() { Ipv4Addr::UNSPECIFIED.into() } else { IpAddr::from(Ipv6Addr::UNSPECIFIED) };
    let socket = UdpSocket::bind((any, 0)).ok()?;
    socket.connect((peer, DISCARD_PORT)).ok()?;
    let own = socket.local_addr().ok()?.ip().to_string();
    let has_it = |name: &&String| drivers::wire::addresses(name).is_ok_and(|all| all.contains(&own));
    kernel.interface(kernel.names().iter().find(has_it)?).ok()
}

fn through(interface: Option<&Interface>, peer: IpAddr) -> (bool, String) {
    let Some(Interface { name, is_physical, .. }) = interface else {
        return (false, format!("no interface is known that leads to peer {peer}"));
    };
    match is_physical {
        true => (true, format!("peer {peer} is behind interface {name}, which has a physical device")),
        false => (false, format!("peer {peer} is behind interface {name}, which is virtual")),
    }
}

#[cfg(test)]
mod tests;
