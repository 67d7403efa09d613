//! Byte lines: ptys and TCP ports.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::ByteLine;

use super::link::Link;
use super::pace::Paced;
use super::pty::Pty;

/// Bytes that are moved at once.
pub(super) const PIECE_BYTES: usize = 4096;

/// What became of the bytes of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounts {
    /// Bytes from the device that the host's end took.
    pub to_host: u64,
    /// Bytes from the host that reached the device.
    pub to_device: u64,
    /// Bytes from the device that found the host's end full, as when the buffer of a receiver overruns.
    pub lost: u64,
    /// Bytes from the device while nobody had the host's end open.
    pub unheard: u64,
}

/// Serves one simulated line.
pub struct LinePump {
    far: Far,
    address: String,
    /// Link to the pty, which goes when this is dropped.
    link: Option<Link>,
    to_host: Paced,
    to_device: Paced,
    counts: LineCounts,
}

enum Far {
    Pty(Pty),
    Tcp { listener: TcpListener, client: Option<TcpStream> },
}

/// What came of a read.
pub(super) enum Arrived {
    Bytes(usize),
    Nothing,
    /// Nobody has the host's end open.
    Nobody,
}

impl LinePump {
    /// Serves a serial line on a new pty. A pty has no bit rate of its own, so bytes are paced here, both ways.
    ///
    /// # Errors
    /// When the operating system has no pty left.
    pub fn pty(baud: u32) -> io::Result<Self> {
        let pty = Pty::new()?;
        let address = format!("serial:{}?baud={baud}", pty.path()?.display());
        let [to_host, to_device] = [Paced::at_baud(baud), Paced::at_baud(baud)];
        let counts = LineCounts::default();
        Ok(Self { far: Far::Pty(pty), address, link: None, to_host, to_device, counts })
    }

    /// Serves a serial line on a new pty that can be reached at a path of one's choice. A link to a pty that was left there is
    /// replaced, unless the simulator that made it still serves it: that one holds a lock on the file beside it, `.lock`.
    ///
    /// # Errors
    /// As [`LinePump::pty`]; when another simulator serves the path; when something else is there, such as the link by which a
    /// serial adapter is found, or no link can be made.
    pub fn pty_at(path: &Path, baud: u32) -> io::Result<Self> {
        let mut pump = Self::pty(baud)?;
        let Far::Pty(pty) = &pump.far else { return Ok(pump) };
        pump.link = Some(Link::make(path, &pty.path()?)?);
        pump.address = format!("serial:{}?baud={baud}", path.display());
        Ok(pump)
    }

    /// Serves a line on a TCP port of the loopback interface; 0 chooses a free one. It has one client at a time; others wait
    /// until that one hangs up.
    ///
    /// # Errors
    /// When the port is in use.
    pub fn tcp(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        let address = format!("tcp:{}", listener.local_addr()?);
        let [to_host, to_device] = [Paced::unpaced(), Paced::unpaced()];
        let far = Far::Tcp { listener, client: None };
        Ok(Self { far, address, link: None, to_host, to_device, counts: LineCounts::default() })
    }

    /// Address of the host's end, as drivers and rig files write it.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// What became of the bytes so far.
    pub fn counts(&self) -> LineCounts {
        self.counts
    }

    /// Moves the bytes that are due at `now` (time of the simulation) between a simulated line and the host's end. Returns at
    /// once; call it at least once a millisecond.
    ///
    /// # Errors
    /// When the simulated line is gone.
    pub fn pump(&mut self, device: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        if self.accepts() {
            // An instrument forgets what it had to say to somebody who hung up.
            self.discard(device, now)?;
        }
        let is_open = self.take_from_host(now);
        let due_count = self.to_device.due_count(now);
        if due_count > 0 {
            device.write(now, self.to_device.first(due_count))?;
            self.to_device.advance(due_count);
            self.counts.to_device += due_count as u64;
        }
        if !is_open {
            self.to_host.clear();
            return self.discard(device, now);
        }
        let mut piece = [0; PIECE_BYTES];
        loop {
            let most_bytes = self.to_host.room_bytes().min(piece.len());
            let count = device.read(now, &mut piece[..most_bytes])?;
            self.to_host.push(now, &piece[..count]);
            if count == 0 || count < most_bytes {
                break;
            }
        }
        self.give_to_host(now);
        Ok(())
    }

    /// Takes a new client, if there is none; whether one came.
    fn accepts(&mut self) -> bool {
        let Far::Tcp { listener, client: client @ None } = &mut self.far else { return false };
        let Ok((stream, _)) = listener.accept() else { return false };
        let is_ready = stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true));
        *client = is_ready.is_ok().then_some(stream);
        self.to_host.clear();
        self.to_device.clear();
        client.is_some()
    }

    /// What the device says is heard by nobody.
    fn discard(&mut self, device: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        let mut piece = [0; PIECE_BYTES];
        loop {
            let count = device.read(now, &mut piece)?;
            self.counts.unheard += count as u64;
            if count < piece.len() {
                return Ok(());
            }
        }
    }

    /// Takes what the host has written, as much as there is room for; whether anybody has the host's end open.
    fn take_from_host(&mut self, now: Duration) -> bool {
        let mut piece = [0; PIECE_BYTES];
        loop {
            let most_bytes = self.to_device.room_bytes().min(piece.len());
            if most_bytes == 0 {
                return true;
            }
            match self.far.read(&mut piece[..most_bytes]) {
                Arrived::Bytes(count) => self.to_device.push(now, &piece[..count]),
                Arrived::Nothing => return true,
                Arrived::Nobody => return false,
            }
        }
    }

    /// Gives the host what is due. What a full pty does not take is lost, as at a receiver; a full connection holds it back.
    fn give_to_host(&mut self, now: Duration) {
        let due_count = self.to_host.due_count(now);
        if due_count == 0 {
            return;
        }
        let taken_count = self.far.write(self.to_host.first(due_count));
        self.counts.to_host += taken_count as u64;
        let lost_count = if matches!(self.far, Far::Pty(_)) { due_count - taken_count } else { 0 };
        self.counts.lost += lost_count as u64;
        self.to_host.advance(taken_count + lost_count);
    }
}

impl Far {
    fn read(&mut self, into: &mut [u8]) -> Arrived {
        match self {
            Self::Pty(pty) => pty.read(into),
            Self::Tcp { client, .. } => {
                let Some(stream) = client else { return Arrived::Nobody };
                match stream.read(into) {
                    Ok(count) if count > 0 => return Arrived::Bytes(count),
                    Err(error) if is_passing(&error) => return Arrived::Nothing,
                    Ok(_) | Err(_) => *client = None,
                }
                Arrived::Nobody
            }
        }
    }

    /// Bytes that were taken.
    fn write(&mut self, bytes: &[u8]) -> usize {
        match self {
            Self::Pty(pty) => pty.write(bytes),
            Self::Tcp { client, .. } => {
                let Some(stream) = client else { return 0 };
                match stream.write(bytes) {
                    Ok(count) => count,
                    Err(error) => {
                        if !is_passing(&error) {
                            *client = None;
                        }
                        0
                    }
                }
            }
        }
    }
}

fn is_passing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
