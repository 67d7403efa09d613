//! Video trackers: target offset in pixels, counter, quality; one datagram per frame.

pub mod datagram;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::device::{Channel, DeviceError, Width};
use crate::wire::DatagramPort;

pub use self::datagram::{DatagramFault, LENGTH, Lock, Sample, Source, decode, encode};

/// How a tracker's pixels become angles; SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackerSettings {
    /// Name in errors and topics, e.g. `coarse`.
    pub name: String,
    /// Which camera's messages are taken.
    pub source: Source,
    /// Angle of one pixel (IFOV) along x and y (study 3.2.4).
    pub ifov_rad: [f64; 2],
    /// Rows cross-elevation, elevation; columns image x, y: a rotated camera is not the identity (erratum E26).
    pub map: [[f64; 2]; 2],
}

/// What the tracker last said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuals {
    /// Target minus line of sight across the elevation axis, from the last valid frame; azimuth error times cos(el).
    pub cross_elevation_rad: f64,
    /// Target minus line of sight in elevation, from the last valid frame.
    pub elevation_rad: f64,
    /// Centre of the shutter of the newest frame, since the start of the run.
    pub exposure: Duration,
    /// Age of that exposure when it was last looked at.
    pub age: Duration,
    /// Image x of the newest frame.
    pub x_px: f32,
    /// Image y of the newest frame.
    pub y_px: f32,
    /// 0 to 1.
    pub quality: f32,
    /// Frame counter.
    pub counter: u32,
    /// Frames whose message never came.
    pub lost_frames: u32,
    /// Messages that were not understood, came late or twice.
    pub rejected: u32,
    /// What the tracker says of its lock.
    pub lock: Lock,
}

/// A video tracker behind a datagram port.
#[derive(Clone, Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    last: Actuals,
    heard: bool,
}

impl Tracker {
    /// What the driver publishes each tick, in the order of [`Actuals::row`].
    pub const CHANNELS: &'static [Channel] = &[
        channel("cross_elevation_rad", "rad", Width::F64),
        channel("elevation_rad", "rad", Width::F64),
        channel("exposure_s", "s", Width::F64),
        channel("age_s", "s", Width::F64),
        channel("x_px", "px", Width::F32),
        channel("y_px", "px", Width::F32),
        channel("quality", "1", Width::F32),
        channel("counter", "count", Width::U32),
        channel("lost_frames", "count", Width::U32),
        channel("rejected", "count", Width::U32),
        channel("lock", "", Width::I8),
    ];

    /// A tracker from which nothing has come yet.
    ///
    /// # Errors
    /// When an IFOV is not positive or an entry of the map is not finite.
    pub fn new(settings: TrackerSettings) -> Result<Self, DeviceError> {
        let bad_ifov = settings.ifov_rad.into_iter().find(|ifov| !(ifov.is_finite() && *ifov > 0.0));
        let bad_map = settings.map.into_iter().flatten().find(|entry| !entry.is_finite());
        let refuse = |setting, value, allowed: &str| {
            let device = settings.name.clone();
            Err(DeviceError::Setting { device, setting, value, allowed: allowed.to_owned() })
        };
        match (bad_ifov, bad_map) {
            (Some(value), _) => refuse("ifov_rad", value, "a positive angle is needed"),
            (_, Some(value)) => refuse("map", value, "finite numbers are needed"),
            (None, None) => Ok(Self { settings, last: Actuals::default(), heard: false }),
        }
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &TrackerSettings {
        &self.settings
    }

    /// Whether any message has come yet.
    pub fn is_heard(&self) -> bool {
        self.heard
    }

    /// Takes every message that has arrived up to `now` and says where things stand; `true` if a frame was new.
    ///
    /// # Errors
    /// When the port is gone.
    pub fn poll(
        &mut self,
        port: &mut dyn DatagramPort,
        now: Duration,
    ) -> Result<(Actuals, bool), DeviceError> {
        // One byte more than a message: what is longer must not pass for one.
        let mut bytes = [0; LENGTH + 1];
        let mut fresh = false;
        while let Some(length) = port.receive(now, &mut bytes)? {
            fresh |= self.accept(bytes.get(..length).unwrap_or(&[]));
        }
        self.last.age = now.saturating_sub(self.last.exposure);
        Ok((self.last, fresh))
    }

    /// Takes one message; `true` if it was a newer frame of this camera.
    pub fn accept(&mut self, bytes: &[u8]) -> bool {
        let newer = match decode(bytes) {
            Ok((source, sample)) if source == self.settings.source => self.follows(&sample).then_some(sample),
            _ => None,
        };
        match newer {
            Some(sample) => self.take(&sample),
            None => self.last.rejected = self.last.rejected.saturating_add(1),
        }
        newer.is_some()
    }

    /// Datagrams may come twice or out of order; a camera that restarted counts from zero at a later exposure.
    fn follows(&self, sample: &Sample) -> bool {
        !self.heard || sample.exposure > self.last.exposure
    }

    fn take(&mut self, sample: &Sample) {
        let step = sample.counter.wrapping_sub(self.last.counter);
        // More than half of the range is a step back: a restart, of which nobody knows what was lost.
        if self.heard && (1..u32::MAX / 2).contains(&step) {
            self.last.lost_frames = self.last.lost_frames.saturating_add(step - 1);
        }
        self.heard = true;
        self.last.counter = sample.counter;
        self.last.exposure = sample.exposure;
        self.last.quality = sample.quality;
        self.last.lock = sample.lock;
        (self.last.x_px, self.last.y_px) = (sample.x_px, sample.y_px);
        if sample.is_valid() {
            let [x_rad, y_rad] = [
                f64::from(sample.x_px) * self.settings.ifov_rad[0],
                f64::from(sample.y_px) * self.settings.ifov_rad[1],
            ];
            let [cross, elevation] = self.settings.map;
            self.last.cross_elevation_rad = cross[0] * x_rad + cross[1] * y_rad;
            self.last.elevation_rad = elevation[0] * x_rad + elevation[1] * y_rad;
        }
    }
}

impl Actuals {
    /// Whether the newest frame measured the target.
    pub fn is_valid(&self) -> bool {
        self.lock == Lock::Tracking
    }

    /// The values in the order of [`Tracker::CHANNELS`].
    pub fn row(&self) -> [f64; 11] {
        [
            self.cross_elevation_rad,
            self.elevation_rad,
            self.exposure.as_secs_f64(),
            self.age.as_secs_f64(),
            f64::from(self.x_px),
            f64::from(self.y_px),
            f64::from(self.quality),
            f64::from(self.counter),
            f64::from(self.lost_frames),
            f64::from(self.rejected),
            f64::from(self.lock.code()),
        ]
    }
}

const fn channel(name: &'static str, unit: &'static str, width: Width) -> Channel {
    Channel { name, unit, width }
}
