//! Sockets: connected before the tick, never waited for in it.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::os::fd::OwnedFd;
use std::time::Duration;

use super::shared::failure;
use crate::device::DeviceError;

/// Longest wait for a device to take a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// Connects to a device. Small messages are sent at once (`TCP_NODELAY`).
///
/// # Errors
/// When the host is unknown or takes no connection within 3 s.
pub(super) fn connect_tcp(address: &str, host: &str, port: u16) -> Result<OwnedFd, DeviceError> {
    let mut last = None;
    for peer in resolve(address, host, port)? {
        match TcpStream::connect_timeout(&peer, CONNECT_TIMEOUT) {
            Ok(stream) => {
                return ready(&stream).map(|()| stream.into()).map_err(|error| refused(address, &error));
            }
            Err(error) => last = Some(error),
        }
    }
    Err(refused(address, &last.unwrap_or_else(|| ErrorKind::AddrNotAvailable.into())))
}

fn ready(stream: &TcpStream) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_nonblocking(true)
}

/// Binds a socket to an own address and connects it to a peer, so that it takes the datagrams of that peer alone.
///
/// # Errors
/// When the host is unknown, or the own address is none of this computer or in use.
pub(super) fn connect_udp(
    address: &str,
    host: &str,
    port: u16,
    bind: SocketAddr,
) -> Result<OwnedFd, DeviceError> {
    let peers = resolve(address, host, port)?;
    let Some(peer) = peers.iter().find(|peer| peer.is_ipv4() == bind.is_ipv4()) else {
        let expected = format!("an address of the same IP version as {bind}");
        let found: Vec<String> = peers.iter().map(ToString::to_string).collect();
        let help = "write `bind` and the device's address in the same IP version";
        return Err(failure(address, "host", expected, found.join(", "), help));
    };
    let socket = UdpSocket::bind(bind).map_err(|error| unbound(address, bind, &error))?;
    let connected = socket.connect(peer).and_then(|()| socket.set_nonblocking(true));
    connected.map(|()| socket.into()).map_err(|error| refused(address, &error))
}

fn resolve(address: &str, host: &str, port: u16) -> Result<Vec<SocketAddr>, DeviceError> {
    let help = "correct the name in the rig file, or write the IP address";
    let unknown = |found: String| failure(address, "host", "a host that is known", found, help);
    let found = (host, port).to_socket_addrs().map_err(|error| unknown(error.to_string()))?;
    let peers: Vec<SocketAddr> = found.collect();
    if peers.is_empty() { Err(unknown("no address".to_owned())) } else { Ok(peers) }
}

fn refused(address: &str, error: &io::Error) -> DeviceError {
    let help = match error.kind() {
        ErrorKind::ConnectionRefused => {
            "the computer is there and nobody listens: check the port, and whether the device serves other clients"
        }
        ErrorKind::TimedOut => "check supply and network cable of the device, and its IP address",
        ErrorKind::NetworkUnreachable | ErrorKind::HostUnreachable => {
            "no route leads there: check the IP addresses of device and computer, and their network masks"
        }
        _ => "check address and network of the device",
    };
    failure(address, "connection", "a device that takes it", error.to_string(), help)
}

fn unbound(address: &str, bind: SocketAddr, error: &io::Error) -> DeviceError {
    let help = match error.kind() {
        ErrorKind::AddrInUse => "another program listens there: end it, or choose another port in `bind`",
        ErrorKind::AddrNotAvailable => {
            "no interface of this computer has that address: `ip address` shows those that there are"
        }
        ErrorKind::PermissionDenied => "ports below 1024 need more rights: choose another one",
        _ => "correct `bind` in the rig file",
    };
    failure(address, "bind", format!("{bind} to be free"), error.to_string(), help)
}
