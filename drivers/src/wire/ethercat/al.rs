//! States of the stations: what is asked of them, what they say, and why they refuse. One datagram at a time.

use std::fmt;
use std::time::Duration;

mod codes;

pub use codes::al_status_meaning;

use super::super::BusState;
use crate::device::DeviceError;

/// AL control, AL status, and the status code three words on.
pub(super) const CONTROL: u16 = 0x0120;
pub(super) const STATUS: u16 = 0x0130;
/// AL status up to its code, in one read.
pub(super) const STATUS_BYTES: u16 = 6;
/// AL control: acknowledges an error. AL status: an error is to be acknowledged.
pub(super) const ERROR: u8 = 0x10;
/// How often the reason is asked of a station that is not where it should be.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// State of a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum AlState {
    Init = 1,
    PreOp = 2,
    SafeOp = 4,
    Op = 8,
}

impl AlState {
    /// The state in the low four bits of an AL status; boot and values without meaning count as INIT.
    pub(super) const fn of(status: u8) -> Self {
        match status & 0x0F {
            8 => Self::Op,
            4 => Self::SafeOp,
            2 => Self::PreOp,
            _ => Self::Init,
        }
    }

    /// The state's name.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Init => "INIT",
            Self::PreOp => "PRE-OP",
            Self::SafeOp => "SAFE-OP",
            Self::Op => "OP",
        }
    }

    /// The next state on the way to `target`: upwards one by one, downwards at once.
    const fn towards(self, target: Self) -> Self {
        match (self, target) {
            (Self::Init, Self::PreOp | Self::SafeOp | Self::Op) => Self::PreOp,
            (Self::PreOp, Self::SafeOp | Self::Op) => Self::SafeOp,
            _ => target,
        }
    }
}

impl From<BusState> for AlState {
    fn from(state: BusState) -> Self {
        match state {
            BusState::PreOp => Self::PreOp,
            BusState::SafeOp => Self::SafeOp,
            BusState::Op => Self::Op,
        }
    }
}

impl From<AlState> for BusState {
    /// A station in INIT can do no more than one in PRE-OP.
    fn from(state: AlState) -> Self {
        match state {
            AlState::Init | AlState::PreOp => Self::PreOp,
            AlState::SafeOp => Self::SafeOp,
            AlState::Op => Self::Op,
        }
    }
}

/// A station has left its state, or has refused one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlError {
    /// Station.
    pub station: u16,
    /// State it is in.
    pub state: &'static str,
    /// AL status code (0134h).
    pub code: u16,
    /// When it was read, since the start of the run.
    pub at: Duration,
}

impl fmt::Display for AlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { station, state, code, .. } = self;
        write!(f, "station {station} is in {state}: AL status code {code:04X}h, {}", al_status_meaning(*code))
    }
}

impl AlError {
    /// The error for the bus `name`.
    pub fn on_bus(&self, name: &str) -> DeviceError {
        DeviceError::Bus { device: name.to_owned(), reason: self.to_string() }
    }
}

/// A datagram for the state of station `station` (counted from 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AlPdu {
    /// Writes AL control.
    Write { station: usize, control: u8 },
    /// Reads AL status and its code.
    Read { station: usize },
}

#[derive(Clone, Copy, Debug)]
struct Station {
    name: u16,
    state: AlState,
    /// An error that is not acknowledged yet.
    has_error: bool,
    code: u16,
    /// What it was last asked to be, until it is that.
    target: Option<AlState>,
    /// The step that was written last.
    written: Option<AlState>,
    /// The reason for its state is to be read.
    is_unexplained: bool,
    /// When its status is to be read at the earliest.
    look_at: Duration,
}

/// Supervision of all stations' states.
#[derive(Debug)]
pub(super) struct Supervisor {
    stations: Vec<Station>,
    /// OP is asked for no earlier: before its SYNC0 comes, a station cannot use its outputs.
    op_from: Duration,
}

impl Supervisor {
    /// Stations with these names, in position order, all in PRE-OP.
    pub(super) fn new(names: impl IntoIterator<Item = u16>) -> Self {
        let station = |name| Station {
            name,
            state: AlState::PreOp,
            has_error: false,
            code: 0,
            target: None,
            written: None,
            is_unexplained: false,
            look_at: Duration::ZERO,
        };
        Self { stations: names.into_iter().map(station).collect(), op_from: Duration::ZERO }
    }

    /// Asks for OP no earlier than at `from`.
    pub(super) fn hold_op_until(&mut self, from: Duration) {
        self.op_from = from;
    }

    /// The lowest state of all stations.
    pub(super) fn lowest(&self) -> AlState {
        self.stations.iter().map(|station| station.state).min().unwrap_or(AlState::Init)
    }

    /// All stations are known to be in a state, e.g. after ethercrab has brought them there.
    pub(super) fn set_all(&mut self, state: AlState) {
        for station in &mut self.stations {
            *station = Station { state, has_error: false, target: None, written: None, ..*station };
        }
    }

    /// Asks all stations for a state.
    pub(super) fn request(&mut self, state: AlState) {
        for station in &mut self.stations {
            station.target = (station.state != state).then_some(state);
            station.written = None;
        }
    }

    /// Whether a station is still on its way.
    pub(super) fn is_changing(&self) -> bool {
        self.stations.iter().any(|station| station.target.is_some())
    }

    /// Takes the state that a station had in the last exchange.
    pub(super) fn seen(&mut self, station: usize, status: u8) {
        let Some(station) = self.stations.get_mut(station) else { return };
        let state = AlState::of(status);
        if state < station.state {
            station.is_unexplained = station.target.is_none_or(|target| state < target);
        }
        station.state = state;
        if station.target == Some(state) {
            (station.target, station.written) = (None, None);
        }
    }

    /// The datagram that is to be sent at `now`, if any.
    pub(super) fn next(&self, now: Duration) -> Option<AlPdu> {
        let is_due = |station: &Station| station.is_unexplained && now >= station.look_at;
        if let Some(station) = self.stations.iter().position(is_due) {
            return Some(AlPdu::Read { station });
        }
        for (k, station) in self.stations.iter().enumerate() {
            let Some(target) = station.target else { continue };
            if station.has_error {
                return Some(AlPdu::Write { station: k, control: station.state as u8 | ERROR });
            }
            let step = station.state.towards(target);
            let is_held = step == AlState::Op && now < self.op_from;
            if station.written != Some(step) && !is_held {
                return Some(AlPdu::Write { station: k, control: step as u8 });
            }
        }
        let is_late = |station: &Station| station.target.is_some() && now >= station.look_at;
        self.stations.iter().position(is_late).map(|station| AlPdu::Read { station })
    }

    /// Takes note that AL control was written, or was not.
    pub(super) fn written(&mut self, now: Duration, station: usize, control: u8, is_done: bool) {
        let Some(station) = self.stations.get_mut(station) else { return };
        station.look_at = now + LOOK_EVERY;
        if !is_done {
            return;
        }
        if control & ERROR != 0 {
            station.has_error = false;
        } else {
            station.written = Some(AlState::of(control));
        }
    }

    /// Takes note that AL status could not be read.
    pub(super) fn unread(&mut self, now: Duration, station: usize) {
        if let Some(station) = self.stations.get_mut(station) {
            station.look_at = now + LOOK_EVERY;
        }
    }

    /// Takes AL status and code of a station; what it says if it refuses a state or has left one.
    pub(super) fn read(&mut self, now: Duration, station: usize, status: [u8; 6]) -> Option<AlError> {
        let station = self.stations.get_mut(station)?;
        station.look_at = now + LOOK_EVERY;
        station.state = AlState::of(status[0]);
        station.has_error = status[0] & ERROR != 0;
        let code = u16::from_le_bytes([status[4], status[5]]);
        let has_news = station.target.is_some() || station.code != code;
        let is_new = station.is_unexplained || (station.has_error && has_news);
        station.is_unexplained = false;
        station.code = code;
        if station.target == Some(station.state) || station.has_error {
            (station.target, station.written) = (None, None);
        }
        is_new.then_some(AlError { station: station.name, state: station.state.name(), code, at: now })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Duration = Duration::from_millis(5);

    fn two() -> Supervisor {
        let mut supervisor = Supervisor::new([1, 2]);
        supervisor.set_all(AlState::SafeOp);
        supervisor
    }

    #[test]
    fn each_station_is_asked_once_and_is_done_when_it_is_there() {
        let mut supervisor = two();
        supervisor.request(AlState::Op);
        for station in 0..2 {
            assert_eq!(supervisor.next(NOW), Some(AlPdu::Write { station, control: 8 }));
            supervisor.written(NOW, station, 8, true);
        }
        assert_eq!(supervisor.next(NOW), None);
        supervisor.seen(0, 8);
        assert_eq!(supervisor.lowest(), AlState::SafeOp);
        assert!(supervisor.is_changing());
        supervisor.seen(1, 8);
        assert_eq!((supervisor.lowest(), supervisor.is_changing()), (AlState::Op, false));
    }

    #[test]
    fn a_lost_request_is_made_again() {
        let mut supervisor = two();
        supervisor.request(AlState::Op);
        let first = supervisor.next(NOW);
        supervisor.written(NOW, 0, 8, false);
        assert_eq!(supervisor.next(NOW), first);
    }

    #[test]
    fn op_waits_for_the_first_sync0() {
        let mut supervisor = two();
        supervisor.hold_op_until(NOW);
        supervisor.request(AlState::Op);
        let write = Some(AlPdu::Write { station: 0, control: 8 });
        assert_ne!(supervisor.next(NOW - Duration::from_millis(1)), write);
        assert_eq!(supervisor.next(NOW), write);
    }

    #[test]
    fn a_refusal_is_explained_once_and_not_asked_again() {
        let mut supervisor = two();
        supervisor.request(AlState::Op);
        for station in 0..2 {
            supervisor.written(NOW, station, 8, true);
        }
        let later = NOW + LOOK_EVERY;
        assert_eq!(supervisor.next(later), Some(AlPdu::Read { station: 0 }));
        let error = supervisor.read(later, 0, [0x14, 0, 0, 0, 0x1D, 0]).expect("it refuses");
        assert_eq!(
            error.to_string(),
            "station 1 is in SAFE-OP: AL status code 001Dh, invalid output configuration"
        );
        assert_eq!(supervisor.next(later), Some(AlPdu::Read { station: 1 }));
        assert_eq!(supervisor.read(later, 1, [0x08, 0, 0, 0, 0, 0]), None);
        assert_eq!(supervisor.next(later + LOOK_EVERY), None, "no automatic retry");
        supervisor.request(AlState::Op);
        assert_eq!(
            supervisor.next(later),
            Some(AlPdu::Write { station: 0, control: 0x14 }),
            "acknowledged first"
        );
        supervisor.written(later, 0, 0x14, true);
        assert_eq!(supervisor.next(later), Some(AlPdu::Write { station: 0, control: 8 }));
    }

    #[test]
    fn a_station_that_falls_out_of_op_is_explained_and_stays_there() {
        let mut supervisor = two();
        supervisor.set_all(AlState::Op);
        supervisor.seen(0, 8);
        supervisor.seen(1, 4);
        assert_eq!(supervisor.lowest(), AlState::SafeOp);
        assert_eq!(supervisor.next(NOW), Some(AlPdu::Read { station: 1 }));
        let error = supervisor.read(NOW, 1, [0x14, 0, 0, 0, 0x1B, 0]).expect("it has fallen");
        assert_eq!((error.station, error.code), (2, 0x1B));
        assert_eq!(supervisor.next(NOW + LOOK_EVERY), None, "no automatic restart");
    }

    #[test]
    fn a_station_that_begins_anew_after_a_loss_of_supply_is_reported_without_an_error_code() {
        let mut supervisor = two();
        supervisor.seen(1, 1);
        let error = supervisor.read(NOW, 1, [0x01, 0, 0, 0, 0, 0]).expect("it has left SAFE-OP");
        assert_eq!(error.to_string(), "station 2 is in INIT: AL status code 0000h, no error");
        assert_eq!(supervisor.read(NOW, 1, [0x01, 0, 0, 0, 0, 0]), None, "told once");
        supervisor.unread(NOW, 1);
        assert_eq!(supervisor.next(NOW), None);
    }

    #[test]
    fn states_are_raised_one_by_one_and_lowered_at_once() {
        assert_eq!(AlState::Init.towards(AlState::Op), AlState::PreOp);
        assert_eq!(AlState::PreOp.towards(AlState::Op), AlState::SafeOp);
        assert_eq!(AlState::Op.towards(AlState::Init), AlState::Init);
        assert_eq!(AlState::of(0x13), AlState::Init, "boot");
    }
}
