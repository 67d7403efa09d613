//! What a device of the rig is to the tick, and the ports that devices hang on.

use std::time::Duration;

use drivers::device::{Channel, DeviceError};
use drivers::kvh::Kvh;
use drivers::tracker;
use drivers::wire::{AnalogPort, ByteLine, DatagramPort};
use procedures::case::{Case, Mode};

use super::PointSettings;
use super::devices::TrackLog;

/// One thing on the rig. It never blocks, and is handed the ports with each call, because several devices may share one.
///
/// What the loop needs of a device beyond rows for the log it asks by role: [`Device::rate_sensor`], [`Device::tracker`],
/// [`Device::mirror`]. A device has the roles that it overrides.
pub trait Device {
    /// Name in messages and reports.
    fn name(&self) -> &str;

    /// Goes on with the dialogue that finds, identifies and configures the device; `None` until that is done. Nothing may
    /// move by it.
    ///
    /// # Errors
    /// Settings that cannot be, a port that there is not, a device that does not answer or is not what it must be.
    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError>;

    /// Who it is, once it is open; `None` for what cannot say it.
    fn identity(&self) -> Option<String> {
        None
    }

    /// Begins to take what a point changes of it; [`Device::poll_change`] goes on with it.
    ///
    /// # Errors
    /// Settings that it cannot be given.
    fn change(&mut self, _settings: &PointSettings) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Goes on with [`Device::change`] as far as it gets without waiting; whether the device has the settings now.
    ///
    /// # Errors
    /// When it refuses them, or reads back something else.
    fn poll_change(&mut self, _ports: &mut Ports, _now: Duration) -> Result<bool, DeviceError> {
        Ok(true)
    }

    /// The loop begins at this time.
    fn start_of_ticks(&mut self, _start: Duration) {}

    /// Once a tick: takes what has arrived, sends what is commanded.
    ///
    /// # Errors
    /// When a port is gone; what hangs on it only ages from then on.
    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError>;

    /// What it adds to the log.
    fn group(&self) -> Group;

    /// Whether its rows mean anything in a point.
    fn is_looked_at(&self, _looked_at: LookedAt) -> bool {
        true
    }

    /// Puts its values into the head of `row`, in the order of its channels. What is summed up since the row before begins
    /// anew.
    fn row(&mut self, row: &mut [f64]);

    /// The device as the sensor of the axes' rates.
    fn rate_sensor(&self) -> Option<&Kvh> {
        None
    }

    /// The device as a tracker: which of them, and its newest sample.
    fn tracker(&self) -> Option<(tracker::Source, &tracker::Actuals)> {
        None
    }

    /// The device as the place where the track loops are logged.
    fn track_log(&mut self) -> Option<&mut TrackLog> {
        None
    }

    /// The device as a mirror with two tilts.
    fn mirror(&mut self) -> Option<&mut dyn SteeringMirror> {
        None
    }
}

/// A mirror with two tilts: azimuth, elevation.
pub trait SteeringMirror {
    /// Tilts by its own gauges.
    fn angle_rad(&self) -> [f64; 2];

    /// Tilts that are sent from the next tick on.
    fn command(&mut self, command_rad: [f64; 2]);

    /// Raises the synchronisation signal of the oscilloscope, or lets it fall.
    ///
    /// # Errors
    /// When the port is gone.
    fn synchronise(&mut self, ports: &mut Ports, now: Duration, high: bool) -> Result<(), DeviceError>;
}

/// What one device adds to the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Topic without its slash.
    pub topic: &'static str,
    /// Type of its messages.
    pub message: &'static str,
    /// Its channels.
    pub channels: &'static [Channel],
}

/// Which devices have something to say in a point.
#[derive(Clone, Copy, Debug)]
pub struct LookedAt {
    /// Trackers and the loops behind them: there is a target, or a loop that is closed on one.
    pub trackers: bool,
    /// Force gauge: somebody pulls.
    pub force: bool,
}

impl LookedAt {
    /// By a point; by one that logs its payload fully, everything.
    pub fn by(case: &Case) -> Self {
        let tracks = case.segments.iter().any(|s| s.mode == Mode::Track || s.tracks.is_some());
        Self {
            trackers: case.logs_payload_fully || case.target.is_some() || tracks,
            force: case.logs_payload_fully || case.pull.is_some(),
        }
    }
}

/// Ports that devices hang on, by name. A device looks for its port once, when it is opened, and goes by its place then.
#[derive(Default)]
pub struct Ports {
    lines: Vec<(String, Box<dyn ByteLine>)>,
    cards: Vec<(String, Box<dyn AnalogPort>)>,
    sockets: Vec<(String, Box<dyn DatagramPort>)>,
}

impl Ports {
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

fn find<T>(ports: &[(String, T)], device: &str, name: &str, what: &str) -> Result<usize, DeviceError> {
    ports.iter().position(|(own, _)| own == name).ok_or_else(|| {
        let names: Vec<&str> = ports.iter().map(|(name, _)| name.as_str()).collect();
        let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let reason = format!("no {what} `{name}` on this site, found {found}");
        DeviceError::Bus { device: device.to_owned(), reason }
    })
}
