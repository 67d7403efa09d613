//! An Ethernet interface of Linux, through a packet socket for EtherCAT frames only.

use std::io;
use std::num::NonZeroU32;
use std::os::fd::{AsRawFd, OwnedFd};
use std::time::Duration;

use nix::ifaddrs::{InterfaceAddress, getifaddrs};
use nix::net::if_::InterfaceFlags;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::{AddressFamily, Protocol, RecvFlags, SendFlags, SocketFlags, SocketType};

use super::{EthernetLink, MAX_FRAME_BYTES};
use crate::device::DeviceError;

/// EtherType of EtherCAT.
const ETHERTYPE: u16 = 0x88A4;
/// First two bytes of the source address of frames that no SubDevice has passed on.
const OWN_SOURCE: [u8; 2] = [0x10, 0x10];

/// An Ethernet interface that carries EtherCAT frames, e.g. `enp3s0`.
///
/// Opening it needs the capability `CAP_NET_RAW`; using it does not, so privileges can be dropped afterwards.
pub struct PacketSocket {
    name: String,
    socket: OwnedFd,
    clock: Box<dyn Fn() -> Duration>,
    /// Whether frames that no SubDevice has passed on are those of this program.
    drops_own: bool,
    own_frames_count: u64,
}

impl PacketSocket {
    /// Opens the interface `name`. The clock gives the time since the start of the run, of the monotonic clock.
    ///
    /// # Errors
    /// When there is no such interface, it is down, without a link or has an IP address, or the program may not open packet
    /// sockets.
    pub fn open(name: &str, clock: Box<dyn Fn() -> Duration>) -> Result<Self, DeviceError> {
        Self::bound(name, clock, true)
    }

    /// Opens the interface `name` for SubDevices in software: what arrives are frames that no SubDevice has passed on.
    ///
    /// # Errors
    /// As [`PacketSocket::open`].
    pub fn far_end(name: &str, clock: Box<dyn Fn() -> Duration>) -> Result<Self, DeviceError> {
        Self::bound(name, clock, false)
    }

    fn bound(name: &str, clock: Box<dyn Fn() -> Duration>, drops_own: bool) -> Result<Self, DeviceError> {
        let failed = |what: &str, error: io::Error| failure(name, format!("{what}: {error}"));
        let interfaces: Vec<_> =
            getifaddrs().map_err(|error| failed("interfaces cannot be listed", error.into()))?.collect();
        let interface = find(name, &interfaces)?;
        refuse_addresses(name, &interfaces)?;
        let protocol = NonZeroU32::new(u32::from(ETHERTYPE.to_be())).map(Protocol::from_raw);
        let flags = SocketFlags::NONBLOCK | SocketFlags::CLOEXEC;
        let socket = rustix::net::socket_with(AddressFamily::PACKET, SocketType::RAW, flags, protocol)
            .map_err(|error| refused(name, error.into()))?;
        let address = interface
            .address
            .as_ref()
            .ok_or_else(|| failure(name, "the interface has no link-layer address".to_owned()))?;
        nix::sys::socket::bind(socket.as_raw_fd(), address)
            .map_err(|error| failed("the socket cannot be bound to the interface", error.into()))?;
        let mut opened = Self { name: name.to_owned(), socket, clock, drops_own, own_frames_count: 0 };
        opened.drain().map_err(|error| failed("the interface cannot be read", error))?;
        Ok(opened)
    }

    /// Frames of this program that came back without passing a SubDevice, and were dropped: there is a loop in the cabling.
    pub fn own_frames_count(&self) -> u64 {
        self.own_frames_count
    }

    /// Drops what arrived before the socket was bound, which may be from any interface.
    fn drain(&mut self) -> io::Result<()> {
        let mut bytes = [0; MAX_FRAME_BYTES];
        while self.receive(&mut bytes)?.is_some() {}
        Ok(())
    }
}

impl EthernetLink for PacketSocket {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let sent_bytes =
            retried(|| rustix::net::send(&self.socket, frame, SendFlags::DONTWAIT)).map_err(full)?;
        if sent_bytes == frame.len() {
            return Ok(());
        }
        Err(io::Error::other(format!("{sent_bytes} of {} bytes were sent", frame.len())))
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        loop {
            let received = retried(|| rustix::net::recv(&self.socket, &mut *into, RecvFlags::DONTWAIT));
            let length = match received {
                Ok((_, length)) => length.min(into.len()),
                Err(error) if error == rustix::io::Errno::WOULDBLOCK => return Ok(None),
                Err(error) => return Err(error.into()),
            };
            if self.drops_own && length >= 8 && into[6..8] == OWN_SOURCE {
                self.own_frames_count += 1;
                continue;
            }
            return Ok(Some(length));
        }
    }

    fn now(&self) -> Duration {
        (self.clock)()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        let left = until.saturating_sub((self.clock)());
        let timeout = Timespec {
            tv_sec: i64::try_from(left.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: left.subsec_nanos().into(),
        };
        match poll(&mut [PollFd::new(&self.socket, PollFlags::IN)], Some(&timeout)) {
            // A signal: whoever waits looks at the time and waits again.
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

/// Internet addresses of an interface, which one that carries EtherCAT must not have.
///
/// # Errors
/// When the interfaces cannot be listed.
pub fn addresses(name: &str) -> Result<Vec<String>, DeviceError> {
    let interfaces =
        getifaddrs().map_err(|error| failure(name, format!("interfaces cannot be listed: {error}")))?;
    let own = interfaces.filter(|found| found.interface_name == name);
    let internet = own.filter_map(|found| {
        let address = found.address?;
        let v4 = address.as_sockaddr_in().map(|address| address.ip().to_string());
        v4.or_else(|| address.as_sockaddr_in6().map(|address| address.ip().to_string()))
    });
    Ok(internet.collect())
}

/// The link-layer entry of an interface that is up and has a link.
fn find<'a>(name: &str, interfaces: &'a [InterfaceAddress]) -> Result<&'a InterfaceAddress, DeviceError> {
    let is_link =
        |found: &&InterfaceAddress| found.address.as_ref().is_some_and(|a| a.as_link_addr().is_some());
    let found = interfaces.iter().filter(is_link).find(|found| found.interface_name == name);
    let Some(found) = found else {
        let names: Vec<_> = interfaces.iter().filter(is_link).map(|i| i.interface_name.as_str()).collect();
        let reason = format!(
            "no such Ethernet interface; there are: {}; correct the interface in the rig file",
            names.join(", ")
        );
        return Err(failure(name, reason));
    };
    if !found.flags.contains(InterfaceFlags::IFF_UP) {
        let reason = format!("the interface is down; run `ip link set {name} up`");
        return Err(failure(name, reason));
    }
    if !found.flags.contains(InterfaceFlags::IFF_RUNNING) {
        return Err(failure(
            name,
            "the interface has no link; check the cable and the first SubDevice's supply".to_owned(),
        ));
    }
    Ok(found)
}

/// Refuses an interface that is in use for something else: one with an IP address, apart from IPv6's link-local ones.
fn refuse_addresses(name: &str, interfaces: &[InterfaceAddress]) -> Result<(), DeviceError> {
    for found in interfaces.iter().filter(|found| found.interface_name == name) {
        let Some(address) = &found.address else { continue };
        let v4 = address.as_sockaddr_in().map(|v4| v4.ip().to_string());
        let v6 = address.as_sockaddr_in6().map(|v6| v6.ip()).filter(|ip| !ip.is_unicast_link_local());
        if let Some(ip) = v4.or_else(|| v6.map(|ip| ip.to_string())) {
            let reason = format!(
                "the interface has the IP address {ip}: EtherCAT needs one of its own; run `ip address flush dev {name}` if \
                 nothing else uses it, or correct the interface in the rig file"
            );
            return Err(failure(name, reason));
        }
    }
    Ok(())
}

/// The error of a socket that could not be opened.
fn refused(name: &str, error: io::Error) -> DeviceError {
    let help = match error.kind() {
        io::ErrorKind::PermissionDenied => {
            "; the program needs the capability CAP_NET_RAW: run `setcap cap_net_raw+ep` on it once, as root"
        }
        _ => "",
    };
    failure(name, format!("no packet socket: {error}{help}"))
}

fn failure(name: &str, reason: String) -> DeviceError {
    DeviceError::Bus { device: format!("interface {name}"), reason }
}

/// Calls again what a signal has interrupted.
fn retried<T>(mut call: impl FnMut() -> rustix::io::Result<T>) -> rustix::io::Result<T> {
    loop {
        match call() {
            Err(rustix::io::Errno::INTR) => {}
            done => return done,
        }
    }
}

/// A full queue of the interface is something that passes.
fn full(error: rustix::io::Errno) -> io::Error {
    match error {
        rustix::io::Errno::NOBUFS => io::ErrorKind::WouldBlock.into(),
        error => error.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interface_that_does_not_exist_is_named_with_those_that_do() {
        let error = PacketSocket::open("no-such-interface", Box::new(|| Duration::ZERO));
        let text = error.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(
            text.starts_with("interface no-such-interface: no such Ethernet interface; there are: "),
            "{text}"
        );
        assert!(text.contains("lo"), "{text}");
    }

    #[test]
    fn an_interface_with_an_ip_address_is_refused() {
        let text = PacketSocket::open("lo", Box::new(|| Duration::ZERO)).err().map(|error| error.to_string());
        let text = text.unwrap_or_default();
        assert!(text.contains("127.0.0.1") || text.contains("the interface is down"), "{text}");
    }

    #[test]
    fn a_missing_permission_says_how_to_grant_it() {
        let text = refused("enp3s0", io::ErrorKind::PermissionDenied.into()).to_string();
        assert!(text.contains("setcap cap_net_raw+ep"), "{text}");
    }
}
