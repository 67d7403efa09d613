//! Opening a bus: who is there, in PRE-OP.

use std::time::Duration;

use ethercrab::error::{Error, TimeoutError};
use ethercrab::{Command, MainDevice, MainDeviceConfig, PduStorage, RetryBehaviour, Timeouts};

use super::super::{EthernetLink, MAX_FRAME_BYTES};
use super::al::{AlState, Supervisor};
use super::configure::run;
use super::group::{Group, MOST_BYTES, MOST_STATIONS, Stage};
use super::mailbox::{MailArea, Mailboxes};
use super::pump::{Pump, SLOTS, Stopped};
use super::{EtherCatBus, EtherCatSettings, Failure, StationInfo, clock, station};
use crate::device::DeviceError;

/// Longest start-up of all stations.
const START_LIMIT: Duration = Duration::from_secs(60);
/// Longest wait for the first reply.
const COUNT_LIMIT: Duration = Duration::from_millis(200);
/// Longest read out of a station's SII.
const SII_LIMIT: Duration = Duration::from_secs(1);
/// What ethercrab's name begins with where the SII has no order code; the device's own name is then the better one.
const NO_ORDER_CODE: &str = "manu. ";
/// Configured address of the first station.
const FIRST_ADDRESS: u16 = 0x1000;
/// Register of sync manager 0; each has 8 bytes.
pub(super) const SYNC_MANAGERS: u16 = 0x0800;
/// Sync manager control: mode and direction of a mailbox that the host writes, and of one that it reads.
const MAILBOX_WRITE: u8 = 0x06;
const MAILBOX_READ: u8 = 0x02;

const NOBODY: &str = "check that the cable is in the first SubDevice's IN port, that it has supply, and that the rig file names \
                      the right interface";

type PreOpGroup = Stage<ethercrab::subdevice_group::PreOp, ethercrab::subdevice_group::NoDc>;

impl EtherCatBus {
    /// Opens the bus on an interface: finds the stations, brings them into PRE-OP and aligns their clocks.
    ///
    /// # Errors
    /// When nobody answers, too many or other stations are there than expected, or a station refuses PRE-OP; a setting that
    /// no bus can be given.
    pub fn open(link: Box<dyn EthernetLink>, settings: EtherCatSettings) -> Result<Self, DeviceError> {
        settings.check()?;
        let name = format!("{} ({})", settings.name, link.name());
        // ethercrab's handles borrow their store and cannot be put back into it: it stays for the rest of the program.
        let store: &'static PduStorage<SLOTS, MAX_FRAME_BYTES> = Box::leak(Box::new(PduStorage::new()));
        let (tx, rx, pdu_loop) = store.try_split().expect("a new store has not been split");
        let iterations =
            settings.distributed_clocks.as_ref().map_or(0, |clocks| clocks.static_sync_iterations);
        let timeouts = Timeouts {
            eeprom: Duration::from_millis(500),
            wait_loop_delay: Duration::from_micros(500),
            ..Timeouts::default()
        };
        let config = MainDeviceConfig {
            dc_static_sync_iterations: iterations,
            retry_behaviour: RetryBehaviour::Count(2),
        };
        let mut bus = Self {
            name,
            settings,
            pump: Pump::new(link, tx, rx),
            main: MainDevice::new(pdu_loop, timeouts, config),
            group: Group::Gone,
            stations: Vec::new(),
            mapped: None,
            supervisor: Supervisor::new([]),
            mailboxes: Mailboxes::new([]),
            al_errors: Vec::with_capacity(super::MOST_AL_ERRORS),
            clock: None,
            last_exchange: None,
            took_part: [false; MOST_STATIONS],
            answer: Box::new([0; MAX_FRAME_BYTES]),
            is_closed: false,
            is_free: false,
        };
        let may_let_go = bus.settings.may_let_go;
        bus.find_stations(may_let_go)?;
        Ok(bus)
    }

    fn find_stations(&mut self, may_let_go: bool) -> Result<(), DeviceError> {
        (self.group, self.mapped, self.clock, self.last_exchange) = (Group::Gone, None, None, None);
        self.supervisor.set_all(AlState::Init);
        let count = self.count_stations()?;
        if !may_let_go {
            self.check_nothing_is_held(count)?;
        }
        let starting = self.main.init_single_group::<MOST_STATIONS, MOST_BYTES>(clock::now_ns);
        let group = match run(&mut self.pump, START_LIMIT, starting) {
            Ok(group) => Box::new(group),
            Err(why) => {
                let explained = self.explain_states(count);
                return Err(self.failed(&format!("the {count} stations do not reach PRE-OP{explained}"), why));
            }
        };
        let areas = self.describe(&group)?;
        self.group = Group::PreOp(group);
        self.supervisor = Supervisor::new(self.stations.iter().map(|station| station.station));
        self.supervisor.set_all(AlState::PreOp);
        self.mailboxes = Mailboxes::new(self.stations.iter().map(|s| s.station).zip(areas));
        self.is_closed = false;
        station::check(&self.stations, &self.settings.stations).map_err(|wrong| DeviceError::Field {
            device: self.name.clone(),
            field: "stations",
            expected: wrong.expected,
            found: wrong.found,
            help: wrong.help,
        })
    }

    /// How many SubDevices a broadcast passes.
    fn count_stations(&mut self) -> Result<u16, DeviceError> {
        // ethercrab says what the working counter was only where it differs from what is expected.
        let read = Command::brd(0).with_wkc(0).receive::<u8>(&self.main);
        let count = match run(&mut self.pump, COUNT_LIMIT, read) {
            Err(Failure::EtherCat(Error::WorkingCounter { received, .. })) => received,
            Ok(_) => 0,
            Err(
                Failure::EtherCat(Error::Timeout(TimeoutError::Pdu)) | Failure::Stopped(Stopped::Deadline),
            ) => {
                return Err(self.wrong_count("no reply".to_owned(), NOBODY));
            }
            Err(why) => return Err(self.failed("SubDevices cannot be counted", why)),
        };
        if count == 0 {
            return Err(self.wrong_count("replies of frames that no SubDevice has seen".to_owned(), NOBODY));
        }
        if usize::from(count) > MOST_STATIONS {
            let help = "a line of this bus has no more: take some off";
            return Err(self.wrong_count(format!("{count} SubDevices"), help));
        }
        Ok(count)
    }

    /// Refuses stations that may hold an axis: in INIT, through which the start takes them, they would let go.
    fn check_nothing_is_held(&mut self, count: u16) -> Result<(), DeviceError> {
        for position in 0..count {
            let read = Command::aprd(position, super::al::STATUS).receive::<[u8; 2]>(&self.main);
            let [status, _] = run(&mut self.pump, COUNT_LIMIT, read).map_err(|why| {
                self.failed(&format!("the state of position {} cannot be read", position + 1), why)
            })?;
            let state = AlState::of(status);
            if state >= AlState::SafeOp {
                return Err(DeviceError::Field {
                    device: self.name.clone(),
                    field: "state",
                    expected: "all stations in INIT or PRE-OP".to_owned(),
                    found: format!("position {} in {}", position + 1, state.name()),
                    help: if state == AlState::Op {
                        "another program drives this line, or the watchdog of the station is off: end the program, or switch \
                         the station off with its axis secured"
                    } else {
                        "its drive may hold an axis, and opening the bus would let go of it: secure the axes mechanically, then \
                         let go with `bench devices --let-go`"
                    },
                });
            }
        }
        Ok(())
    }

    fn wrong_count(&self, found: String, help: &'static str) -> DeviceError {
        let expected = match self.settings.stations.len() {
            0 => format!("1 to {MOST_STATIONS} SubDevices"),
            count => format!("{count} SubDevices"),
        };
        DeviceError::Field { device: self.name.clone(), field: "SubDevices", expected, found, help }
    }

    /// Takes down who the stations are and where their mailboxes lie.
    fn describe(&mut self, group: &PreOpGroup) -> Result<Vec<Option<MailArea>>, DeviceError> {
        let mut stations = Vec::new();
        let mut areas = Vec::new();
        for (position, found) in (1..).zip(group.iter(&self.main)) {
            let identity = found.identity();
            let mut name = found.name().to_owned();
            if name.starts_with(NO_ORDER_CODE)
                && let Ok(Some(described)) = run(&mut self.pump, SII_LIMIT, found.description())
            {
                name = described.as_str().to_owned();
            }
            stations.push(StationInfo {
                station: StationInfo::number(found.alias_address(), position),
                position,
                configured_address: found.configured_address(),
                alias: found.alias_address(),
                name,
                vendor: identity.vendor_id,
                product: identity.product_id,
                revision: identity.revision,
                serial: identity.serial,
                has_sync0: found.dc_support().enhanced(),
                has_mailbox: false,
            });
        }
        for station in &mut stations {
            let area = self.mail_area(station.configured_address)?;
            station.has_mailbox = area.is_some();
            areas.push(area);
        }
        self.stations = stations;
        Ok(areas)
    }

    /// Reads where a station's mailboxes lie, out of its first two sync managers.
    fn mail_area(&mut self, address: u16) -> Result<Option<MailArea>, DeviceError> {
        let [write, read] = [0, 8].map(|offset| self.read_register::<8>(address, SYNC_MANAGERS + offset));
        let (write, read) = (write?, read?);
        let is_mailbox = |bytes: [u8; 8], control: u8| bytes[4] & 0x0F == control && bytes[6] & 1 != 0;
        if !is_mailbox(write, MAILBOX_WRITE) || !is_mailbox(read, MAILBOX_READ) {
            return Ok(None);
        }
        let word = |bytes: [u8; 8], at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let longest = MOST_BYTES as u16;
        Ok(Some(MailArea {
            address,
            write_at: word(write, 0),
            write_bytes: word(write, 2).min(longest),
            read_at: word(read, 0),
            read_bytes: word(read, 2).min(longest),
        }))
    }

    /// Why the first `count` stations are not where they should be, for a message.
    pub(super) fn explain_states(&mut self, count: u16) -> String {
        let mut text = String::new();
        for position in 0..count {
            let Ok(status) = self.read_register::<6>(FIRST_ADDRESS + position, super::al::STATUS) else {
                continue;
            };
            let code = u16::from_le_bytes([status[4], status[5]]);
            if status[0] & super::al::ERROR != 0 {
                let state = AlState::of(status[0]).name();
                let meaning = super::al_status_meaning(code);
                text +=
                    &format!("; position {}: {state}, AL status code {code:04X}h, {meaning}", position + 1);
            }
        }
        text
    }
}
