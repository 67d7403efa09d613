//! This crate's bus on a link that can let go of its interface and measures how long it waits.

use std::cell::{Cell, RefCell};
use std::io;
use std::rc::Rc;
use std::time::Duration;

use drivers::wire::ethercat::{EtherCatBus, EtherCatSettings};
use drivers::wire::{BusState, EthernetLink, Fieldbus, PacketSocket, ProcessImage};

use super::clock;
use super::compare::{Outcome, REPLY_LIMIT};
use super::meter::{Meter, measured};

/// Longest way into OP.
const OP_LIMIT: Duration = Duration::from_secs(5);
/// Longer than a change from one side to the other takes.
const WATCHDOG_S: f64 = 2.0;

/// What the link and its owner share.
#[derive(Default)]
struct Shared {
    socket: RefCell<Option<PacketSocket>>,
    meter: Meter,
}

/// A packet socket that measures its calls.
struct MeasuredLink {
    interface: String,
    shared: Rc<Shared>,
}

impl MeasuredLink {
    /// Calls the socket and adds how long it took to `sum`.
    fn with<T>(
        &self,
        sum: &Cell<Duration>,
        call: impl FnOnce(&mut PacketSocket) -> io::Result<T>,
    ) -> io::Result<T> {
        measured(sum, || match self.shared.socket.borrow_mut().as_mut() {
            Some(socket) => call(socket),
            None => Err(io::ErrorKind::NotConnected.into()),
        })
    }
}

impl EthernetLink for MeasuredLink {
    fn name(&self) -> &str {
        &self.interface
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        self.with(&self.shared.meter.called, |socket| socket.send(frame))
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        self.with(&self.shared.meter.called, |socket| socket.receive(into))
    }

    fn now(&self) -> Duration {
        clock::now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.with(&self.shared.meter.waited, |socket| socket.wait(until))
    }
}

/// This crate's bus in OP, with outputs of 0.
pub(crate) struct Ours {
    interface: String,
    shared: Rc<Shared>,
    bus: EtherCatBus,
    image: ProcessImage,
    /// Working counter of an exchange in which every station takes part.
    pub(crate) expected: u16,
}

impl Ours {
    /// Brings all stations behind an interface into OP; then lets go of the interface.
    pub(crate) fn open(interface: &str, cycle: Duration) -> Result<Self, String> {
        let shared = Rc::new(Shared::default());
        connect(interface, &shared)?;
        let link = MeasuredLink { interface: interface.to_owned(), shared: Rc::clone(&shared) };
        let usual = EtherCatSettings::usual("EtherCAT", cycle.as_secs_f64());
        let settings = EtherCatSettings {
            reply_timeout_s: REPLY_LIMIT.as_secs_f64(),
            watchdog_s: WATCHDOG_S,
            // The other side has left the stations in SAFE-OP; their outputs were 0 all the time.
            may_let_go: true,
            ..usual
        };
        let mut bus = EtherCatBus::open(Box::new(link), settings).map_err(|error| error.to_string())?;
        let (image, _) = bus.map().map_err(|error| error.to_string())?;
        bus.request(BusState::Op);
        let mut ours = Self { interface: interface.to_owned(), shared, bus, image, expected: 0 };
        let limit = clock::now() + OP_LIMIT;
        let mut next = clock::now();
        while ours.bus.state() != BusState::Op {
            if clock::now() > limit {
                let why = ours.bus.al_errors().last().map_or(String::new(), |error| format!("; {error}"));
                return Err(format!("the stations do not reach OP{why}"));
            }
            next += cycle;
            clock::rest_until(next);
            ours.exchange()?;
        }
        ours.disconnect();
        Ok(ours)
    }

    pub(crate) fn connect(&mut self) -> Result<(), String> {
        connect(&self.interface, &self.shared)
    }

    pub(crate) fn disconnect(&mut self) {
        *self.shared.socket.borrow_mut() = None;
    }

    pub(crate) fn exchange(&mut self) -> Result<Outcome, String> {
        self.shared.meter.reset();
        let done = self.bus.exchange(clock::now(), &mut self.image).map_err(|error| error.to_string())?;
        self.expected = done.expected;
        Ok(match done.working_counter {
            0 => Outcome::Lost,
            all if all == done.expected => Outcome::Complete,
            _ => Outcome::Short,
        })
    }

    /// How long the last exchange spent in calls of the system.
    pub(crate) fn meter(&self) -> &Meter {
        &self.shared.meter
    }

    /// Brings the stations back into INIT.
    pub(crate) fn close(mut self) -> Result<(), String> {
        self.connect()?;
        self.bus.close().map_err(|error| error.to_string())
    }
}

fn connect(interface: &str, shared: &Shared) -> Result<(), String> {
    let socket = PacketSocket::open(interface, Box::new(clock::now)).map_err(|error| error.to_string())?;
    *shared.socket.borrow_mut() = Some(socket);
    Ok(())
}
