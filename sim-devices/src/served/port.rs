//! Datagram ports: UDP.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::DatagramPort;

/// Longest datagram of UDP over IPv4.
const LONGEST_DATAGRAM_BYTES: usize = 65_507;
/// Datagrams that are moved at once, each way: a flood must not hold the simulation up.
const MOST_AT_ONCE: usize = 1024;

/// What became of the datagrams of a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounts {
    /// Datagrams from the device that were sent.
    pub to_host: u64,
    /// Datagrams from the host that reached the device.
    pub to_device: u64,
    /// Datagrams from the device that the operating system did not take.
    pub lost: u64,
    /// Times that nobody listened at the host's end.
    pub unheard: u64,
}

/// Serves one simulated port.
pub struct PortPump {
    socket: UdpSocket,
    address: String,
    buffer: Vec<u8>,
    counts: PortCounts,
}

impl PortPump {
    /// Serves a port on a UDP socket of the loopback interface that is bound to `own` (port 0 chooses a free one) and speaks to
    /// `host` alone.
    ///
    /// # Errors
    /// When an address is none of the loopback interface, or `own` is in use.
    pub fn udp(own: SocketAddr, host: SocketAddr) -> io::Result<Self> {
        if let Some(foreign) = [own, host].into_iter().find(|address| !address.ip().is_loopback()) {
            let why = format!(
                "{foreign} is no loopback address: a simulator must not answer where hardware may be"
            );
            return Err(io::Error::new(ErrorKind::InvalidInput, why));
        }
        let socket = UdpSocket::bind(own)?;
        socket.connect(host)?;
        socket.set_nonblocking(true)?;
        let address = format!("udp:{}?bind={host}", socket.local_addr()?);
        Ok(Self { socket, address, buffer: vec![0; LONGEST_DATAGRAM_BYTES], counts: PortCounts::default() })
    }

    /// Address of the host's end, as drivers and rig files write it.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// What became of the datagrams so far.
    pub fn counts(&self) -> PortCounts {
        self.counts
    }

    /// Moves the datagrams that are due at `now` (time of the simulation). Returns at once; call it at least once a
    /// millisecond.
    ///
    /// # Errors
    /// When the simulated port is gone.
    pub fn pump(&mut self, device: &mut dyn DatagramPort, now: Duration) -> Result<(), DeviceError> {
        for _ in 0..MOST_AT_ONCE {
            match self.socket.recv(&mut self.buffer) {
                Ok(count) => {
                    device.send(now, &self.buffer[..count])?;
                    self.counts.to_device += 1;
                }
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => self.counts.unheard += 1,
                Err(_) => break,
            }
        }
        for _ in 0..MOST_AT_ONCE {
            let Some(count) = device.receive(now, &mut self.buffer)? else { break };
            let count = count.min(self.buffer.len());
            self.give(count);
        }
        Ok(())
    }

    /// Sends what is in the buffer.
    fn give(&mut self, count: usize) {
        let mut sent = self.socket.send(&self.buffer[..count]);
        if sent.as_ref().is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused) {
            // The refusal of an earlier datagram; this one was not sent.
            self.counts.unheard += 1;
            sent = self.socket.send(&self.buffer[..count]);
        }
        match sent {
            Ok(_) => self.counts.to_host += 1,
            Err(_) => self.counts.lost += 1,
        }
    }
}
