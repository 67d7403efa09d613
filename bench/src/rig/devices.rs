//! The devices of a rig as a list: opened, polled and logged in its order.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::tracker::{Actuals, Source};

use procedures::device::DeviceRole;

use super::PointSettings;
use super::device::{Device, Group, LookedAt, RateSensor, SteeringMirror};
use super::driver::{Driver, Made};
use super::hearing::{self, Hearing, HearingNews, Listener};
use super::instruments::Instrument;
use super::wires::Ports;
use crate::clock::Clock;
use crate::model::device::DeviceEntry;
use crate::model::rig::Rig;

mod analyser;
mod auxiliary;
mod ccbu40;
mod clamps;
mod force;
pub(crate) mod gcs;
mod imu;
pub(crate) mod inertial;
pub mod mirror;
mod on_card;
mod on_line;
mod reader;
pub mod reference;
mod scope;
pub(crate) mod stim300;
pub(crate) mod supply;
mod track_log;
pub mod tracker;

pub use track_log::TrackLog;

/// Between two looks at a line during a dialogue.
pub(crate) const DIALOGUE_STEP: Duration = Duration::from_millis(1);
/// Beyond this a dialogue that says nothing is given up, whatever its own timeouts do.
const DIALOGUE_LIMIT: Duration = Duration::from_secs(10);

/// Every driver that a rig file may name.
pub const DRIVERS: &[&Driver] = &[
    &imu::DRIVER,
    &stim300::DRIVER,
    &ccbu40::DRIVER,
    &gcs::DRIVER,
    &tracker::COARSE,
    &tracker::FINE,
    &reference::DRIVER,
    &clamps::DRIVER,
    &force::DRIVER,
    &analyser::DRIVER,
    &scope::DRIVER,
    &supply::DRIVER,
    &reader::DRIVER,
];

/// The driver of this name.
pub fn driver(name: &str) -> Option<&'static Driver> {
    DRIVERS.iter().copied().find(|driver| driver.name == name)
}

/// Role of the `[[instrument]]` whose certificate vouches for the readings of a device; `None` where the device belongs to the
/// unit. A device whose role follows from its profile has the one of the driver that always has this role.
pub fn certified_as(entry: &DeviceEntry) -> Option<&'static str> {
    let of_role = || DRIVERS.iter().find(|other| other.role.is_some() && other.role == entry.role);
    driver(entry.driver)?.certified_as.or_else(|| of_role()?.certified_as)
}

/// Devices and instruments that are not open yet.
pub struct Closed {
    /// What is polled in the tick.
    pub devices: Vec<Box<dyn Device>>,
    /// What is given tasks.
    pub instruments: Vec<Box<dyn Instrument>>,
}

/// Devices and instruments of a rig, closed, in the order of its file. What the track loops log has its place after the
/// last tracker.
pub fn closed(rig: &Rig) -> Closed {
    let is_tracker =
        |entry: &DeviceEntry| matches!(entry.role, Some(DeviceRole::CoarseTracker | DeviceRole::FineTracker));
    let last_tracker = rig.devices.iter().rposition(is_tracker);
    let (mut devices, mut instruments): (Vec<Box<dyn Device>>, _) = (Vec::new(), Vec::new());
    for (place, entry) in rig.devices.iter().enumerate() {
        let driver =
            driver(entry.driver).expect("an entry names a driver of this list: it took its name from there");
        match (driver.make)(entry, rig.loop_rate_hz) {
            Made::InTheTick(device) => devices.push(device),
            Made::Instrument(instrument) => instruments.push(instrument),
        }
        if last_tracker == Some(place) {
            devices.push(Box::new(TrackLog::default()));
        }
    }
    Closed { devices, instruments }
}

/// What the devices of a rig add to the log, in the order of their topics; the instruments come last.
pub fn groups(rig: &Rig) -> Vec<Group> {
    let Closed { devices, instruments } = closed(rig);
    let instruments = instruments.iter().map(|instrument| instrument.group());
    devices.iter().map(|device| device.group()).chain(instruments).collect()
}

/// Devices that are polled in the tick.
pub struct Devices {
    list: Vec<Box<dyn Device>>,
    /// Places in the list of what the loop asks for by role.
    rate_sensor: Option<usize>,
    mirror: Option<usize>,
    track_log: Option<usize>,
    /// Newest samples of the coarse and the fine tracker.
    seen: [Actuals; 2],
    /// The first port that went; what hangs on it only ages from then on.
    failure: Option<DeviceError>,
    /// What was told of how each device of the list is heard.
    listeners: Vec<Listener>,
}

/// Names of the devices of a rig that are polled in the tick, in the order of [`Devices`].
pub fn names(rig: &Rig) -> Vec<String> {
    closed(rig).devices.iter().map(|device| device.name().to_owned()).collect()
}

/// How a device is heard that sends messages by itself and means something in a point.
fn heard(device: &dyn Device, looked_at: LookedAt, now: Duration) -> Option<Hearing> {
    device.hearing(now).filter(|_| device.is_looked_at(looked_at))
}

impl Devices {
    /// Opens every device, one after another, from `now` on; gives the time at which that was done.
    ///
    /// # Errors
    /// The first device that does not answer or is not what it must be.
    pub fn open(
        mut list: Vec<Box<dyn Device>>,
        ports: &mut Ports,
        clock: &Clock,
        mut now: Duration,
    ) -> Result<(Self, Duration), DeviceError> {
        for device in &mut list {
            let name = device.name().to_owned();
            converse(clock, &mut now, &name, |at| {
                device.open(ports, at).map_err(|error| error.of_device(&name))
            })?;
        }
        let rate_sensor = list.iter().position(|device| device.rate_sensor().is_some());
        let mirror = list.iter_mut().position(|device| device.mirror().is_some());
        let track_log = list.iter_mut().position(|device| device.track_log().is_some());
        let seen = [Actuals::default(); 2];
        let listeners = vec![Listener::default(); list.len()];
        Ok((Self { list, rate_sensor, mirror, track_log, seen, failure: None, listeners }, now))
    }

    /// Begins to give the devices what a point changes.
    ///
    /// # Errors
    /// Settings that one of them cannot be given.
    pub fn change(&mut self, settings: &PointSettings) -> Result<(), DeviceError> {
        self.list.iter_mut().try_for_each(|device| device.change(settings))
    }

    /// Goes on with [`Devices::change`] as far as it gets without waiting; whether all devices have their settings now.
    ///
    /// # Errors
    /// The first that refuses them, or reads back something else.
    pub fn poll_change(&mut self, ports: &mut Ports, now: Duration) -> Result<bool, DeviceError> {
        let mut is_done = true;
        for device in &mut self.list {
            is_done &= device.poll_change(ports, now)?;
        }
        Ok(is_done)
    }

    /// The loop begins at this time.
    pub fn start_of_ticks(&mut self, start: Duration) {
        self.list.iter_mut().for_each(|device| device.start_of_ticks(start));
    }

    /// Once a tick, after the exchange: every device takes what has arrived and sends what is commanded. A port that is gone
    /// silences what hangs on it and nothing else.
    pub fn poll(&mut self, ports: &mut Ports, now: Duration) {
        for device in &mut self.list {
            if let Err(error) = device.poll(ports, now) {
                self.failure.get_or_insert_with(|| error.of_device(device.name()));
            }
            match device.tracker() {
                Some((Source::Coarse, newest)) => self.seen[0] = *newest,
                Some((Source::Fine, newest)) => self.seen[1] = *newest,
                None => {}
            }
        }
    }

    /// The sensor of the axes' rates.
    pub fn rate_sensor(&self) -> Option<RateSensor> {
        self.list[self.rate_sensor?].rate_sensor()
    }

    /// Newest samples of the coarse and the fine tracker.
    pub fn trackers(&self) -> &[Actuals; 2] {
        &self.seen
    }

    fn mirror(&mut self) -> Option<&mut dyn SteeringMirror> {
        self.list[self.mirror?].mirror()
    }

    /// Tilts of the mirror by its own gauges, azimuth and elevation; 0 without a mirror.
    pub fn mirror_rad(&mut self) -> [f64; 2] {
        self.mirror().map_or([0.0; 2], |mirror| mirror.angle_rad())
    }

    /// Tilts of the mirror that are sent from the next tick on: azimuth, elevation.
    pub fn command_mirror(&mut self, command_rad: [f64; 2]) {
        if let Some(mirror) = self.mirror() {
            mirror.command(command_rad);
        }
    }

    /// Raises the synchronisation signal of the oscilloscope, or lets it fall.
    pub fn synchronise(&mut self, ports: &mut Ports, now: Duration, high: bool) {
        let Some(device) = self.mirror.map(|place| &mut self.list[place]) else { return };
        let failed = device.mirror().and_then(|mirror| mirror.synchronise(ports, now, high).err());
        if let Some(error) = failed {
            self.failure.get_or_insert_with(|| error.of_device(device.name()));
        }
    }

    /// Places of the devices that send messages by themselves and mean something in a point, and how each is heard at `now`.
    fn heard(&self, looked_at: LookedAt, now: Duration) -> impl Iterator<Item = (usize, Hearing)> {
        let devices = self.list.iter().enumerate();
        devices.filter_map(move |(place, device)| Some((place, heard(&**device, looked_at, now)?)))
    }

    /// A point begins: what lines have lost until now is none of its losses.
    pub fn begin_listening(&mut self, now: Duration) {
        for (device, listener) in self.list.iter().zip(&mut self.listeners) {
            if let Some(hearing) = device.hearing(now) {
                listener.begin(&hearing);
            }
        }
    }

    /// Once a tick: tells which devices have fallen silent or are heard again, by their places in [`names`].
    pub fn tell_silence(
        &mut self,
        looked_at: LookedAt,
        now: Duration,
        mut tell: impl FnMut(usize, HearingNews),
    ) {
        for (place, (device, listener)) in self.list.iter().zip(&mut self.listeners).enumerate() {
            let hearing = heard(&**device, looked_at, now);
            if let Some(news) = hearing.and_then(|hearing| listener.tick(&hearing)) {
                tell(place, news);
            }
        }
    }

    /// Tells what the lines have lost since the point began.
    pub fn tell_losses(&self, looked_at: LookedAt, now: Duration, mut tell: impl FnMut(usize, HearingNews)) {
        for (place, hearing) in self.heard(looked_at, now) {
            if let Some(news) = self.listeners[place].lost(&hearing) {
                tell(place, news);
            }
        }
    }

    /// The first device that is silent, as its error; else why the sensor of the axes' rates is not to be used.
    pub fn silence(&self, looked_at: LookedAt, now: Duration) -> Option<DeviceError> {
        let silent = self.heard(looked_at, now).find(|(_, hearing)| hearing.silent_s > hearing.stale_s);
        silent
            .map(|(place, Hearing { period_s, silent_s, .. })| {
                hearing::silence(self.list[place].name(), period_s, silent_s)
            })
            .or_else(|| self.list[self.rate_sensor?].invalid())
    }

    /// What the track loops did in this tick, in the order of [`crate::rig::tracking::Tracking::CHANNELS`].
    pub fn log_tracking(&mut self, row: [f64; 8]) {
        if let Some(log) = self.track_log.and_then(|place| self.list[place].track_log()) {
            log.take(row);
        }
    }

    /// The first port that went.
    pub fn failure(&self) -> Option<&DeviceError> {
        self.failure.as_ref()
    }

    /// Who they are, as name and identity; without those that cannot say it.
    pub fn identities(&self) -> Vec<(String, String)> {
        self.list.iter().filter_map(|device| Some((device.name().to_owned(), device.identity()?))).collect()
    }

    /// The device of this name.
    pub(crate) fn named(&mut self, name: &str) -> Option<&mut Box<dyn Device>> {
        self.list.iter_mut().find(|device| device.name() == name)
    }

    /// How each of them is set up, as name and text; without those that have nothing to say of it.
    pub(crate) fn configurations(&self) -> Vec<(String, String)> {
        let told = |device: &dyn Device| Some((device.name().to_owned(), device.configuration()?));
        self.list.iter().filter_map(|device| told(&**device)).collect()
    }

    /// How many groups of the log are theirs.
    pub fn groups_count(&self) -> usize {
        self.list.len()
    }

    /// Puts the values of each device into `row` and hands it on, in the order of [`groups`]; `None` for a device that says
    /// nothing in this point.
    pub fn rows<const N: usize>(
        &mut self,
        row: &mut [f64; N],
        looked_at: LookedAt,
        mut each: impl FnMut(Option<&[f64; N]>),
    ) {
        for device in &mut self.list {
            device.row(row);
            each(device.is_looked_at(looked_at).then_some(&*row));
        }
    }
}

/// Polls a dialogue until it ends, letting time pass.
pub(crate) fn converse<T>(
    clock: &Clock,
    now: &mut Duration,
    device: &str,
    mut poll: impl FnMut(Duration) -> Result<Option<T>, DeviceError>,
) -> Result<T, DeviceError> {
    let until = *now + DIALOGUE_LIMIT;
    while *now < until {
        if let Some(opened) = poll(*now)? {
            return Ok(opened);
        }
        *now = clock.wait_until(*now + DIALOGUE_STEP);
    }
    let reason = format!("its configuration was not finished within {} s", DIALOGUE_LIMIT.as_secs());
    Err(DeviceError::Bus { device: device.to_owned(), reason })
}

#[cfg(test)]
mod tests {
    use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
    use sim_devices::unit::UnitSettings;

    use super::*;
    use crate::files::rig::read_rig;
    use crate::files::shipped::{self, Folder};
    use crate::model::rig::Rig;

    fn shipped() -> Rig {
        shipped::find(Folder::Rigs, "sim", None).and_then(read_rig).expect("the shipped rig")
    }

    /// The shipped rig with these devices alone.
    fn with(names: &[&str]) -> Rig {
        let mut rig = shipped();
        rig.devices.retain(|entry| names.contains(&entry.name.as_str()));
        rig
    }

    fn open(rig: &Rig, ports: &mut Ports) -> Result<Devices, DeviceError> {
        Devices::open(closed(rig).devices, ports, &Clock::Virtual, Duration::ZERO).map(|(devices, _)| devices)
    }

    #[test]
    fn a_rig_without_devices_needs_no_port_and_logs_nothing_of_them() {
        let none = with(&[]);
        let mut ports = Ports::default();
        let mut devices = open(&none, &mut ports).expect("nothing is missing");
        devices.poll(&mut ports, Duration::ZERO);
        devices.command_mirror([1e-3; 2]);
        devices.synchronise(&mut ports, Duration::ZERO, true);
        assert_eq!((devices.groups_count(), groups(&none)), (0, Vec::new()));
        assert!(devices.failure().is_none() && devices.rate_sensor().is_none());
        assert_eq!(devices.mirror_rad(), [0.0; 2]);
    }

    #[test]
    fn a_device_whose_port_is_not_there_is_refused_by_both_names() {
        let address = SeedAddress { seed: 1, procedure: "test".to_owned(), point: String::new() };
        let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: 20.0 };
        let rig = SimulatedRig::new(&UnitSettings::default(), &address, start);
        let mut ports = Ports::default().with_line("sim:mirror", rig.mirror_line());
        let error = open(&with(&["imu"]), &mut ports).err().expect("its line is missing").to_string();
        assert!(error.contains("imu: no byte line `sim:imu` on this site, found sim:mirror"), "{error}");
        let error = open(&with(&["supply"]), &mut Ports::default()).err();
        let error = error.expect("its card is missing").to_string();
        assert!(error.contains("supply: no analog card `sim:analog` on this site, found none"), "{error}");
    }

    #[test]
    fn topics_of_the_shipped_rig_stand_in_the_order_of_its_devices() {
        let topics: Vec<&str> = groups(&shipped()).iter().map(|group| group.topic).collect();
        let expected =
            ["imu", "fsm", "coarse", "fine", "track", "reference", "supply", "force", "analyser", "scope"];
        assert_eq!(topics, expected);
    }

    #[test]
    fn every_driver_has_its_own_name_and_says_what_it_is_and_every_role_can_be_played() {
        for (place, driver) in DRIVERS.iter().enumerate() {
            let others = &DRIVERS[place + 1..];
            assert!(!others.iter().any(|other| other.name == driver.name), "{}", driver.name);
            assert!(!driver.doc.is_empty() && !driver.ports.is_empty(), "{}", driver.name);
        }
        let can_be_played = |role: &&DeviceRole| DRIVERS.iter().any(|driver| driver.role == Some(**role));
        assert_eq!(DeviceRole::ALL.iter().filter(can_be_played).count(), DeviceRole::ALL.len());
    }
}
