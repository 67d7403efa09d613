//! Video trackers: target offset in pixels, counter, quality; one datagram per frame.

pub mod clock;
pub mod datagram;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::device::{Channel, DeviceError, Width};
use crate::wire::DatagramPort;

pub use self::clock::{CameraClock, DeclaredDelay};
pub use self::datagram::{DatagramFault, LENGTH, Lock, Sample, Source, advance_counter, decode, encode};

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
    /// Delay from the middle of an exposure to the arrival of its message.
    pub declared_delay: DeclaredDelay,
    /// Time between two polls of its port.
    pub poll_period: Duration,
}

/// What the tracker last said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuals {
    /// Target minus line of sight across the elevation axis, from the last valid frame; azimuth error times cos(el).
    pub cross_elevation_rad: f64,
    /// Target minus line of sight in elevation, from the last valid frame.
    pub elevation_rad: f64,
    /// Centre of the shutter of the newest frame on the clock of the loop, see [`clock`].
    pub exposure: Duration,
    /// Age of that exposure when it was last looked at.
    pub age: Duration,
    /// Time of the exposure on the camera's own clock, as its message states it.
    pub stamp: Duration,
    /// Standard uncertainty of the exposure on the clock of the loop as far as arrivals make it, s.
    pub exposure_u_s: f64,
    /// Standard uncertainty of the declared delay from an exposure to its message, s.
    pub message_delay_u_s: f64,
    /// Rate of the camera's clock over that of the loop, less 1; 0 while it is not known.
    pub clock_drift_ratio: f64,
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
    clock: CameraClock,
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
        channel("stamp_s", "s", Width::F64),
        channel("exposure_u_s", "s", Width::F32),
        channel("message_delay_u_s", "s", Width::F32),
        channel("clock_drift_ratio", "1", Width::F32),
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
    /// When an IFOV is not positive, an entry of the map is not finite, or the declared delay or its uncertainty is negative.
    pub fn new(settings: TrackerSettings) -> Result<Self, DeviceError> {
        let bad_ifov = settings.ifov_rad.into_iter().find(|ifov| !(ifov.is_finite() && *ifov > 0.0));
        let bad_map = settings.map.into_iter().flatten().find(|entry| !entry.is_finite());
        let DeclaredDelay { delay_s, u_s } = settings.declared_delay;
        let bad_delay = [delay_s, u_s].into_iter().find(|time_s| !(time_s.is_finite() && *time_s >= 0.0));
        let refuse = |setting, value, allowed: &str| {
            let device = settings.name.clone();
            Err(DeviceError::Setting { device, setting, value, allowed: allowed.to_owned() })
        };
        if let Some(value) = bad_ifov {
            return refuse("ifov_rad", value, "a positive angle is needed");
        }
        if let Some(value) = bad_map {
            return refuse("map", value, "finite numbers are needed");
        }
        if let Some(value) = bad_delay {
            return refuse("declared_delay", value, "a time that is not negative is needed");
        }
        let clock = CameraClock::new(settings.declared_delay, settings.poll_period);
        Ok(Self { settings, clock, last: Actuals::default(), heard: false })
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
            fresh |= self.accept(bytes.get(..length).unwrap_or(&[]), now);
        }
        self.last.age = now.saturating_sub(self.last.exposure);
        Ok((self.last, fresh))
    }

    /// Takes one message that the poll of `now` has found; `true` if it was a newer frame of this camera.
    pub fn accept(&mut self, bytes: &[u8], now: Duration) -> bool {
        let newer = match decode(bytes) {
            // Datagrams may come twice or out of order.
            Ok((source, sample)) if source == self.settings.source => {
                self.clock.follows(sample.stamp).then_some(sample)
            }
            _ => None,
        };
        match newer {
            Some(sample) => self.take(&sample, now),
            None => self.last.rejected = self.last.rejected.saturating_add(1),
        }
        newer.is_some()
    }

    fn take(&mut self, sample: &Sample, now: Duration) {
        let step = sample.counter.wrapping_sub(self.last.counter);
        // More than half of the range is a step back: a restart, of which nobody knows what was lost.
        if self.heard && (1..u32::MAX / 2).contains(&step) {
            self.last.lost_frames = self.last.lost_frames.saturating_add(step - 1);
        }
        self.heard = true;
        self.last.counter = sample.counter;
        let placed = self.clock.place(sample.stamp, now);
        self.last.stamp = sample.stamp;
        self.last.exposure = placed.exposure;
        self.last.exposure_u_s = placed.u_s;
        self.last.message_delay_u_s = self.settings.declared_delay.u_s;
        self.last.clock_drift_ratio = placed.drift_ratio;
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
    pub fn row(&self) -> [f64; 15] {
        [
            self.cross_elevation_rad,
            self.elevation_rad,
            self.exposure.as_secs_f64(),
            self.age.as_secs_f64(),
            self.stamp.as_secs_f64(),
            self.exposure_u_s,
            self.message_delay_u_s,
            self.clock_drift_ratio,
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
