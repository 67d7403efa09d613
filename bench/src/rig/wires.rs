//! The host's ends of all wires of a rig: the bus of its drives, and the ports that devices hang on.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::lines::Lines;
use drivers::wire::{AnalogPort, ByteLine, DatagramPort, DigitalPort, Fieldbus};

/// All wires.
pub struct Wires {
    /// The bus of the drives.
    pub bus: Box<dyn Fieldbus>,
    /// What devices and instruments hang on.
    pub ports: Ports,
}

/// Ports that devices hang on, by name. A device looks for its port once, when it is opened, and goes by its place then.
#[derive(Default)]
pub struct Ports {
    lines: Vec<(String, Box<dyn ByteLine>)>,
    cards: Vec<(String, Box<dyn AnalogPort>)>,
    sockets: Vec<(String, Box<dyn DatagramPort>)>,
    emergency_stop: Option<Box<dyn DigitalPort>>,
    /// What moves the bytes of serial ports and sockets. Dropped last: what was written still goes out.
    _mover: Option<Lines>,
}

impl Ports {
    /// With what moves the bytes of serial ports and sockets among the ports.
    #[must_use]
    pub fn with_mover(self, lines: Lines) -> Self {
        Self { _mover: Some(lines), ..self }
    }

    /// With a byte line more.
    #[must_use]
    pub fn with_line(mut self, name: &str, line: Box<dyn ByteLine>) -> Self {
        self.lines.push((name.to_owned(), line));
        self
    }

    /// With an analog card more.
    #[must_use]
    pub fn with_card(mut self, name: &str, card: Box<dyn AnalogPort>) -> Self {
        self.cards.push((name.to_owned(), card));
        self
    }

    /// With a datagram port more.
    #[must_use]
    pub fn with_socket(mut self, name: &str, socket: Box<dyn DatagramPort>) -> Self {
        self.sockets.push((name.to_owned(), socket));
        self
    }

    /// With the digital terminal to which the emergency stop is wired.
    #[must_use]
    pub fn with_emergency_stop(self, terminal: Box<dyn DigitalPort>) -> Self {
        Self { emergency_stop: Some(terminal), ..self }
    }

    /// The digital terminal to which the emergency stop is wired.
    pub fn emergency_stop(&mut self) -> Option<&mut Box<dyn DigitalPort>> {
        self.emergency_stop.as_mut()
    }

    /// The same ports, and what passes the lines and datagram ports among them from now on.
    pub(crate) fn counted(mut self) -> (Self, Rc<Traffic>) {
        let traffic = Rc::new(Traffic::default());
        let count = || Rc::clone(&traffic);
        let lines = self.lines.into_iter();
        self.lines =
            lines.map(|(name, inner)| (name, boxed_line(Counted { inner, traffic: count() }))).collect();
        let sockets = self.sockets.into_iter();
        self.sockets =
            sockets.map(|(name, inner)| (name, boxed_port(Counted { inner, traffic: count() }))).collect();
        (self, traffic)
    }

    /// With a byte line seen through something else, for faults on the wire.
    #[must_use]
    pub fn with_line_through(
        mut self,
        name: &str,
        through: impl FnOnce(Box<dyn ByteLine>) -> Box<dyn ByteLine>,
    ) -> Self {
        if let Some(place) = self.lines.iter().position(|(own, _)| own == name) {
            let (name, line) = self.lines.remove(place);
            self.lines.insert(place, (name, through(line)));
        }
        self
    }

    /// Place of the byte line of a device.
    ///
    /// # Errors
    /// When there is none of this name.
    pub fn find_line(&self, device: &str, name: &str) -> Result<usize, DeviceError> {
        find(&self.lines, device, name, "byte line")
    }

    /// Place of the analog card of a device.
    ///
    /// # Errors
    /// When there is none of this name.
    pub fn find_card(&self, device: &str, name: &str) -> Result<usize, DeviceError> {
        find(&self.cards, device, name, "analog card")
    }

    /// Place of the datagram port of a device.
    ///
    /// # Errors
    /// When there is none of this name.
    pub fn find_socket(&self, device: &str, name: &str) -> Result<usize, DeviceError> {
        find(&self.sockets, device, name, "datagram port")
    }

    /// The byte line at a place that [`Ports::find_line`] gave.
    pub fn line(&mut self, place: usize) -> &mut dyn ByteLine {
        &mut *self.lines[place].1
    }

    /// The analog card at a place that [`Ports::find_card`] gave.
    pub fn card(&mut self, place: usize) -> &mut dyn AnalogPort {
        &mut *self.cards[place].1
    }

    /// The datagram port at a place that [`Ports::find_socket`] gave.
    pub fn socket(&mut self, place: usize) -> &mut dyn DatagramPort {
        &mut *self.sockets[place].1
    }

    /// A byte line and an analog card at once, for a device that hangs on both.
    pub fn line_and_card(&mut self, line: usize, card: usize) -> (&mut dyn ByteLine, &mut dyn AnalogPort) {
        (&mut *self.lines[line].1, &mut *self.cards[card].1)
    }
}

/// Bytes that passed lines and datagram ports.
#[derive(Debug, Default)]
pub(crate) struct Traffic {
    received_bytes: Cell<u64>,
    sent_bytes: Cell<u64>,
}

impl Traffic {
    /// Bytes that came, bytes that were sent.
    pub(crate) fn bytes(&self) -> [u64; 2] {
        [self.received_bytes.get(), self.sent_bytes.get()]
    }

    fn receive(&self, bytes: usize) {
        self.received_bytes.set(self.received_bytes.get() + bytes as u64);
    }

    fn send(&self, bytes: usize) {
        self.sent_bytes.set(self.sent_bytes.get() + bytes as u64);
    }
}

/// A line or a port whose bytes are counted.
struct Counted<T> {
    inner: T,
    traffic: Rc<Traffic>,
}

fn boxed_line(line: impl ByteLine + 'static) -> Box<dyn ByteLine> {
    Box::new(line)
}

fn boxed_port(port: impl DatagramPort + 'static) -> Box<dyn DatagramPort> {
    Box::new(port)
}

impl<L: ByteLine> ByteLine for Counted<L> {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        self.inner.read(now, into).inspect(|count| self.traffic.receive(*count))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.inner.write(now, bytes).inspect(|()| self.traffic.send(bytes.len()))
    }
}

impl<P: DatagramPort> DatagramPort for Counted<P> {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        self.inner.receive(now, into).inspect(|count| self.traffic.receive(count.unwrap_or(0)))
    }

    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.inner.send(now, bytes).inspect(|()| self.traffic.send(bytes.len()))
    }
}

fn find<T>(ports: &[(String, T)], device: &str, name: &str, what: &str) -> Result<usize, DeviceError> {
    ports.iter().position(|(own, _)| own == name).ok_or_else(|| {
        let names: Vec<&str> = ports.iter().map(|(name, _)| name.as_str()).collect();
        let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let reason = format!("no {what} `{name}` on this site, found {found}");
        DeviceError::Bus { device: device.to_owned(), reason }
    })
}
