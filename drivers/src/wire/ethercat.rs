//! An EtherCAT bus on an Ethernet interface, with ethercrab for the start-up and the frames.
//!
//! One thread does everything: a pump polls ethercrab's futures by hand, so there is no executor and no second thread, and
//! the time is that of the interface. SDO transfers and emergencies are handled here, with at most one acyclic datagram
//! beside a cyclic frame.
//!
//! A station goes by its alias where it has one, else by its position on the line, counted from 1.
//!
//! A frame is made by one exchange and never sent again; a reply counts only for the exchange that sent its frame. When
//! frames are lost, exchanges have working counter 0; when stations have left OP, [`Fieldbus::state`] says so and
//! [`EtherCatBus::al_errors`] says why. Nothing goes back into OP by itself: whoever drives
//! the bus asks for it again, or, where stations have lost their configuration with their supply, opens the bus anew.
//!
//! Each opened bus keeps about 6 kB of memory until the program ends: ethercrab can split its frame store only once.

mod al;
mod clock;
mod close;
mod coe;
mod configure;
mod counters;
mod cycle;
mod datagram;
mod emergency;
mod frame;
mod group;
mod mailbox;
mod open;
mod pump;
mod settings;
mod station;
pub mod terminal;
#[cfg(test)]
mod tests;
mod transfer;

use std::time::Duration;

use ethercrab::MainDevice;

pub use al::{AlError, al_status_meaning};
pub use emergency::Emergency;
pub use pump::LinkCounts;
pub use settings::{DistributedClocks, EtherCatSettings, ExpectedStation};
pub use station::StationInfo;

use self::al::{AlState, Supervisor};
use self::coe::Place;
use self::group::{Cycle, Group, MOST_STATIONS};
use self::mailbox::Mailboxes;
use self::pump::{Pump, Stopped};
use super::{
    BusState, Exchange, Fieldbus, MAX_FRAME_BYTES, News, Notice, PdoTransport, ProcessImage, SdoAbort,
    SdoRequest, SdoWire, Slot,
};
use crate::device::DeviceError;

/// Without an exchange for so long and for so many cycles, nobody exchanges: acyclic transfers drive themselves.
const NOT_CYCLIC_AFTER: Duration = Duration::from_millis(10);
const NOT_CYCLIC_AFTER_CYCLES: f64 = 4.0;
/// How long a look at a transfer may take outside of the cycle.
const LOOK_LIMIT: Duration = Duration::from_millis(1);
/// How long a change of state may take outside of the cycle.
const CHANGE_LIMIT: Duration = Duration::from_millis(500);
/// Wait for the reply to one acyclic frame outside of the cycle.
const REPLY_LIMIT: Duration = Duration::from_millis(20);
/// AL errors that are kept; when there are more, the oldest goes.
const MOST_AL_ERRORS: usize = 64;

/// Distributed clocks in the last exchange that had a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DcStatus {
    /// System time of the reference clock when the frame passed it, nanoseconds.
    pub system_time_ns: u64,
    /// From the last SYNC0 to the frame's passage.
    pub after_sync0: Duration,
    /// From the frame's passage to the instant at which the next one should pass: one period after SYNC0, plus the shift.
    pub next_cycle_in: Duration,
    /// When the exchange was begun, since the start of the run.
    pub at: Duration,
}

/// Layout of the process image, once it is known.
struct Mapped {
    slots: Vec<Slot>,
    output_bytes: usize,
    input_bytes: usize,
    working_counter: u16,
}

impl Mapped {
    /// Which stations took part in an exchange: those that answered for their state, if the working counter is the sum of theirs.
    fn who_took_part(&self, cycle: &Cycle) -> [bool; MOST_STATIONS] {
        let mut took_part = [false; MOST_STATIONS];
        let mut counter = 0;
        for ((slot, &state), took_part) in self.slots.iter().zip(&cycle.states).zip(&mut took_part) {
            *took_part = AlState::of(state) >= AlState::SafeOp;
            counter += if *took_part { counted(slot) } else { 0 };
        }
        if counter == cycle.working_counter { took_part } else { [false; MOST_STATIONS] }
    }
}

/// What a station with this slot adds to the working counter: 1 for its inputs, 2 for its outputs.
fn counted(slot: &Slot) -> u16 {
    u16::from(!slot.inputs.is_empty()) + 2 * u16::from(!slot.outputs.is_empty())
}

/// An EtherCAT bus.
pub struct EtherCatBus {
    name: String,
    settings: EtherCatSettings,
    pump: Pump,
    main: MainDevice<'static>,
    group: Group,
    stations: Vec<StationInfo>,
    mapped: Option<Mapped>,
    supervisor: Supervisor,
    mailboxes: Mailboxes,
    al_errors: Vec<AlError>,
    clock: Option<DcStatus>,
    last_exchange: Option<Duration>,
    /// Which stations are known to have taken part in the last exchange.
    took_part: [bool; MOST_STATIONS],
    answer: Box<[u8; MAX_FRAME_BYTES]>,
    is_closed: bool,
    /// No station holds anything: they may be taken down to INIT when the bus is left.
    is_free: bool,
}

impl EtherCatBus {
    /// The stations on the line, in position order.
    pub fn station_infos(&self) -> &[StationInfo] {
        &self.stations
    }

    /// What the interface has carried.
    pub fn link_counts(&self) -> LinkCounts {
        self.pump.counts
    }

    /// Distributed clocks in the last exchange that had a reply; `None` without them.
    pub fn dc_status(&self) -> Option<DcStatus> {
        self.clock
    }

    /// Takes the emergencies that stations have sent, oldest first. At most 64 wait here; the oldest goes first.
    pub fn emergencies(&mut self) -> impl Iterator<Item = Emergency> {
        std::iter::from_fn(|| self.mailboxes.emergencies.pop())
    }

    /// Emergencies that went because nobody took them.
    pub fn lost_emergencies_count(&self) -> u64 {
        self.mailboxes.emergencies.lost_count()
    }

    /// Takes what stations said when they refused a state or left one, oldest first. At most 64 wait here.
    pub fn al_errors(&mut self) -> impl Iterator<Item = AlError> {
        self.al_errors.drain(..)
    }

    /// Whether exchanges are going on, so that acyclic datagrams go with them.
    fn is_cyclic(&self, now: Duration) -> bool {
        let cycles = Duration::from_secs_f64(NOT_CYCLIC_AFTER_CYCLES * self.settings.cycle_s);
        let limit = NOT_CYCLIC_AFTER.max(cycles);
        self.mapped.is_some() && self.last_exchange.is_some_and(|last| now.saturating_sub(last) < limit)
    }

    /// Passes acyclic datagrams until `is_over` or for `limit`.
    fn drive(&mut self, limit: Duration, is_over: fn(&Self) -> bool) {
        let until = self.pump.link.now() + limit;
        while !is_over(self) && self.pump.link.now() < until {
            match self.pass_acyclic() {
                Ok(true) => {}
                Ok(false) if self.pump.reach((self.pump.link.now() + LOOK_LIMIT).min(until)).is_ok() => {}
                Ok(false) | Err(_) => return,
            }
        }
    }

    fn failure(&self, reason: String) -> DeviceError {
        DeviceError::Bus { device: self.name.clone(), reason }
    }

    /// The error of something that ethercrab did or that was not done in time.
    fn failed(&self, what: &str, why: Failure) -> DeviceError {
        let why = match why {
            Failure::Stopped(Stopped::Deadline) => "not done in time".to_owned(),
            Failure::Stopped(Stopped::Link(error)) => format!("the interface failed: {error}"),
            Failure::EtherCat(error) => error.to_string(),
        };
        self.failure(format!("{what}: {why}"))
    }
}

/// Why a step was not done.
enum Failure {
    Stopped(Stopped),
    EtherCat(ethercrab::error::Error),
}

impl SdoWire for EtherCatBus {
    fn pdo_transport(&self) -> PdoTransport {
        PdoTransport::Assigned
    }

    fn start(&mut self, now: Duration, request: &SdoRequest<'_>) {
        // A failed interface shows in the transfer: it times out.
        let _ = self.pump.reach(now);
        let station = self.stations.iter().position(|found| found.station == request.station);
        let place = Place { index: request.index, sub: request.sub };
        self.mailboxes.start(self.pump.link.now(), station, place, request.write);
    }

    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        let _ = self.pump.reach(now);
        if !self.is_cyclic(self.pump.link.now()) {
            self.drive(LOOK_LIMIT, |bus| !bus.mailboxes.is_busy());
        }
        let Some(outcome) = self.mailboxes.take_outcome(self.pump.link.now()) else { return Ok(false) };
        let read = outcome?;
        into.clear();
        into.extend_from_slice(read);
        Ok(true)
    }
}

impl Fieldbus for EtherCatBus {
    fn name(&self) -> &str {
        &self.name
    }

    fn stations(&self) -> Vec<u16> {
        self.stations.iter().map(|station| station.station).collect()
    }

    /// Ends configuration: reads the mappings, sets sync managers, FMMUs, watchdogs and distributed clocks, and brings all
    /// stations into SAFE-OP. It takes as long as the stations need, at most 5 s for the change of state.
    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        self.configure()
    }

    /// Asks for a state. While exchanges go on, each of them carries one request, and nothing waits. OP always needs
    /// exchanges; for a lower state without exchanges the stations are waited for, at most 0.5 s. Before [`Fieldbus::map`]
    /// there is no way up.
    fn request(&mut self, state: BusState) {
        let target = if self.mapped.is_some() { AlState::from(state) } else { AlState::PreOp };
        self.is_free = false;
        self.supervisor.request(target);
        if target < AlState::Op && !self.is_cyclic(self.pump.link.now()) {
            self.drive(CHANGE_LIMIT, |bus| !bus.supervisor.is_changing());
        }
    }

    fn state(&self) -> BusState {
        self.supervisor.lowest().into()
    }

    fn took_part(&self, station: u16) -> bool {
        let place = self.stations.iter().position(|info| info.station == station);
        place.is_some_and(|place| self.took_part[place])
    }

    fn let_go(&mut self) {
        self.is_free = true;
    }

    fn lateness_ns(&self) -> Option<i64> {
        let next_in = self.clock?.next_cycle_in;
        let period = std::time::Duration::from_secs_f64(self.settings.cycle_s);
        i64::try_from(period.as_nanos()).ok()?.checked_sub(i64::try_from(next_in.as_nanos()).ok()?)
    }

    fn tell_notices(&mut self, tell: &mut dyn FnMut(Notice)) {
        while let Some(emergency) = self.mailboxes.emergencies.pop() {
            let Emergency { station, code, register, .. } = emergency;
            tell(Notice { station, news: News::Emergency { code, register } });
        }
        for error in self.al_errors.drain(..) {
            tell(Notice { station: error.station, news: News::AlError { code: error.code } });
        }
    }

    /// Passes one frame for process data and states, and beside it at most one acyclic datagram. Waits for replies until
    /// the settings' time-out; without a reply the working counter is 0 and the inputs stay as they were.
    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        self.cycle(now, image)
    }
}
