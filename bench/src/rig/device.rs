//! What a device of the rig is to the tick.

use std::time::Duration;

use drivers::device::{Channel, DeviceError};
use drivers::tracker;
use procedures::case::{Case, Mode};

use super::PointSettings;
use super::devices::TrackLog;
use super::hearing::Hearing;
use super::wires::Ports;

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

    /// How it is set up, once it is open: what decides what its values mean; `None` where the rig file says all of it.
    fn configuration(&self) -> Option<String> {
        None
    }

    /// What has come over its line since it was opened, each count with its name, the samples first; nothing for a device that is
    /// read once a tick.
    fn counts(&self) -> Vec<(&'static str, u64)> {
        Vec::new()
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

    /// How it is heard, for a device that sends messages by itself; `None` for any other, and before it is open.
    fn hearing(&self, _now: Duration) -> Option<Hearing> {
        None
    }

    /// The device as the sensor of the axes' rates.
    fn rate_sensor(&self) -> Option<RateSensor> {
        None
    }

    /// Why its newest message is no rate to be used, where it is the sensor of the axes' rates.
    fn invalid(&self) -> Option<DeviceError> {
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

/// The sensor of the axes' rates, and the errors that the rig file declares of it.
#[derive(Clone, Copy, Debug)]
pub struct RateSensor {
    /// Newest message; `None` before the first.
    pub newest: Option<RateSample>,
    /// Ticks since it arrived.
    pub age_ticks: u16,
    /// Messages that came with the last poll.
    pub new_count: u32,
    /// Messages per second.
    pub message_rate_hz: f64,
    /// Share of the motion of one axis that it may show as motion of another.
    pub cross_axis_ratio: f64,
    /// Rate that it may show at rest, without that of the Earth.
    pub bias_rad_per_s: f64,
}

/// A message of an inertial unit.
#[derive(Clone, Copy, Debug)]
pub struct RateSample {
    /// Angular rates about X, Y, Z, positive by the right-hand rule.
    pub rate_rad_per_s: [f64; 3],
    /// Whether all gyros are valid in it.
    pub is_valid: bool,
    /// Number of the message, which wraps.
    pub sequence: u8,
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
    /// Channels of the message.
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
