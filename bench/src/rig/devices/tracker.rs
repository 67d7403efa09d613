//! The video trackers: their drivers for rig files, and the device that is polled every tick on its datagram port.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::tracker::{self, DeclaredDelay, Source, TrackerSettings};
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use crate::model::device::DeviceEntry;
use crate::rig::PointSettings;
use crate::rig::device::{Device, Group, LookedAt};
use crate::rig::driver::{Driver, Made, PortField, not_above_zero};
use crate::rig::hearing::{FRAMES_TO_LOSE, Hearing, Losses};
use crate::rig::wires::Ports;

/// Key of the frame rate in frames per second. A procedure may change it for a point.
pub const FRAME_RATE: &str = "frame-rate";

const PORTS: &[PortField] = &[PortField::socket("Port that its datagrams arrive at.")];
/// Keys of the angle of one pixel (instantaneous field of view) along x and y.
const IFOV: [&str; 2] = ["ifov-x", "ifov-y"];
/// Keys of the delay from an exposure to its message, and of the standard uncertainty of that delay.
const DELAY: [&str; 2] = ["message-delay", "message-delay-uncertainty"];

/// Keys of the settings that must be above zero.
const ABOVE_ZERO: [&str; 5] = [IFOV[0], IFOV[1], FRAME_RATE, DELAY[0], DELAY[1]];

/// Driver of the tracker of the wide camera.
pub const COARSE: Driver = Driver {
    name: "coarse-tracker",
    doc: "Video tracker of the wide infrared camera.",
    role: Some(DeviceRole::CoarseTracker),
    certified_as: None,
    rate_range_rad_per_s: None,
    ports: PORTS,
    has_profile: false,
    fields: &fields("50 Hz"),
    check: |entry| not_above_zero(entry, &ABOVE_ZERO),
    make: |entry, loop_rate_hz| {
        Made::InTheTick(Box::new(Tracker::closed(entry, Source::Coarse, loop_rate_hz)))
    },
};

/// Driver of the tracker of the narrow camera behind the mirror.
pub const FINE: Driver = Driver {
    name: "fine-tracker",
    doc: "Video tracker of the narrow camera behind the mirror.",
    role: Some(DeviceRole::FineTracker),
    certified_as: None,
    rate_range_rad_per_s: None,
    ports: PORTS,
    has_profile: false,
    fields: &fields("200 Hz"),
    check: |entry| not_above_zero(entry, &ABOVE_ZERO),
    make: |entry, loop_rate_hz| Made::InTheTick(Box::new(Tracker::closed(entry, Source::Fine, loop_rate_hz))),
};

/// Settings of a tracker in a rig file. `frame_rate` is its default (study 3.2.4).
const fn fields(frame_rate: &'static str) -> [Field; 6] {
    [
        Field::required(IFOV[0], Shape::Quantity(K::Angle), "Angle of a pixel along x."),
        Field::required(IFOV[1], Shape::Quantity(K::Angle), "Angle of a pixel along y."),
        Field::default(
            "x-is",
            Shape::Choice(&["cross-elevation", "elevation"]),
            "cross-elevation",
            "Angle that moves the image along x; the other one moves it along y (erratum E26: the coarse \
             camera is rotated).",
        ),
        Field::default(FRAME_RATE, Shape::Quantity(K::Frequency), frame_rate, "Frames per second."),
        Field::required(
            DELAY[0],
            Shape::Quantity(K::Time),
            "Shortest time from the middle of an exposure to the arrival of its message. The camera stamps \
             frames with its own clock; arrivals show the drift of that clock, but not this delay. Kind \
             `tracker-latency` measures its remaining error (`tracker-stamp-error`).",
        ),
        Field::required(DELAY[1], Shape::Quantity(K::Time), "Standard uncertainty of that delay."),
    ]
}

fn settings(entry: &DeviceEntry, source: Source, loop_rate_hz: f64) -> TrackerSettings {
    // Rows: cross-elevation, elevation. Columns: x and y of the image.
    let rotated = entry.text("x-is") == "elevation";
    let map = if rotated { [[0.0, 1.0], [1.0, 0.0]] } else { [[1.0, 0.0], [0.0, 1.0]] };
    TrackerSettings {
        name: entry.name.clone(),
        source,
        ifov_rad: IFOV.map(|key| entry.number(key)),
        map,
        declared_delay: DeclaredDelay { delay_s: entry.number(DELAY[0]), u_s: entry.number(DELAY[1]) },
        poll_period: Duration::from_secs_f64(1.0 / loop_rate_hz),
    }
}

/// A tracker and its newest sample.
pub(super) struct Tracker {
    settings: TrackerSettings,
    /// What the rig file gives for the port `socket`.
    port: String,
    /// Index of that port among the open sockets; meaningless before [`Device::open`].
    socket: usize,
    /// `None` before [`Device::open`].
    driver: Option<tracker::Tracker>,
    newest: tracker::Actuals,
    /// Polls that found a newer frame.
    frames_count: u64,
    /// Start of the loop.
    start: Duration,
    /// When its newest message was found; `None` before the first.
    heard_at: Option<Duration>,
    /// Time between two of its frames.
    frame_s: f64,
}

impl Tracker {
    /// A tracker whose port is not open yet. (This has nothing to do with a closed loop.)
    fn closed(entry: &DeviceEntry, source: Source, loop_rate_hz: f64) -> Self {
        Self {
            settings: settings(entry, source, loop_rate_hz),
            port: entry.port("socket").to_owned(),
            socket: 0,
            driver: None,
            newest: tracker::Actuals::default(),
            frames_count: 0,
            start: Duration::ZERO,
            heard_at: None,
            frame_s: 1.0 / entry.number(FRAME_RATE),
        }
    }
}

impl Device for Tracker {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn open(&mut self, ports: &mut Ports, _now: Duration) -> Result<Option<()>, DeviceError> {
        self.socket = ports.find_socket(&self.settings.name, &self.port)?;
        self.driver = Some(tracker::Tracker::new(self.settings.clone())?);
        Ok(Some(()))
    }

    fn change(&mut self, settings: &PointSettings) -> Result<(), DeviceError> {
        if let (Source::Fine, Some(rate_hz)) = (self.settings.source, settings.fine_frame_rate_hz) {
            self.frame_s = 1.0 / rate_hz;
        }
        Ok(())
    }

    /// A tracker is not asked anything: its datagrams say which camera they come from, and nothing else of it.
    fn configuration(&self) -> Option<String> {
        let TrackerSettings { source, ifov_rad, declared_delay, .. } = &self.settings;
        let [x, y] = ifov_rad.map(|ifov_rad| ifov_rad * 1e6);
        let ms = declared_delay.delay_s * 1e3;
        Some(format!(
            "datagrams of version {}, {source:?} camera, pixel {x:.4} x {y:.4} urad, message delay {ms} ms; a tracker is \
             not asked who it is",
            tracker::datagram::VERSION
        ))
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let tracker::Actuals { lost_frames, rejected, .. } = self.newest;
        vec![("frames", self.frames_count), ("lost", lost_frames.into()), ("rejected", rejected.into())]
    }

    fn start_of_ticks(&mut self, start: Duration) {
        self.start = start;
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        if let Some(driver) = &mut self.driver {
            let (newest, is_new) = driver.poll(ports.socket(self.socket), now)?;
            self.frames_count += u64::from(is_new);
            self.newest = newest;
            if is_new {
                self.heard_at = Some(now);
            }
        }
        Ok(())
    }

    /// The first message comes a frame and its delay after the start of the loop.
    fn hearing(&self, now: Duration) -> Option<Hearing> {
        self.driver.as_ref()?;
        let way_s = if self.heard_at.is_some() { 0.0 } else { self.settings.declared_delay.delay_s };
        Some(Hearing {
            period_s: self.frame_s,
            silent_s: now.saturating_sub(self.heard_at.unwrap_or(self.start)).as_secs_f64(),
            stale_s: FRAMES_TO_LOSE * self.frame_s + way_s,
            losses: Losses {
                messages_count: u64::from(self.newest.lost_frames),
                rejected_count: u64::from(self.newest.rejected),
                skipped_bytes_count: 0,
            },
        })
    }

    fn group(&self) -> Group {
        let topic = match self.settings.source {
            Source::Coarse => "coarse",
            Source::Fine => "fine",
        };
        Group { topic, message: "Tracker", channels: tracker::Tracker::CHANNELS }
    }

    fn is_looked_at(&self, looked_at: LookedAt) -> bool {
        looked_at.trackers
    }

    /// Exposure times are logged relative to the start of the loop, as the log's own time is.
    fn row(&mut self, row: &mut [f64]) {
        let exposure = self.newest.exposure.saturating_sub(self.start);
        let values = tracker::Actuals { exposure, ..self.newest }.row();
        row[..values.len()].copy_from_slice(&values);
    }

    fn tracker(&self) -> Option<(Source, &tracker::Actuals)> {
        Some((self.settings.source, &self.newest))
    }
}
