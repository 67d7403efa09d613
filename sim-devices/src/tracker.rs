//! Video trackers at the far end of their ports: a camera that looks at an angle, a tracker that tells its pixels.

mod port;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;
use std::time::Duration;

use drivers::tracker::{Lock, Sample, Source, encode};

use crate::physics::noise::{Noise, SeedAddress};
use crate::unit::CameraSettings;

pub use port::TrackerPort;

/// Radius of the target's image: nearer to the edge of the field its quality falls (ours).
const IMAGE_RADIUS_PX: f64 = 8.0;

/// A camera with its video tracker.
#[derive(Clone, Debug)]
pub struct Camera {
    source: Source,
    period_ns: f64,
    /// Number of the frame from which on the period holds, and when its shutter opened.
    counted_from: u64,
    opened_ns: f64,
    half_shutter: Duration,
    latency: Duration,
    latency_spread_s: f64,
    clock: OwnClock,
    reacquisition: Duration,
    /// Pixels per radian: rows x, y; columns cross-elevation, elevation.
    pixels_per_rad: [[f64; 2]; 2],
    half_field_px: [f64; 2],
    centroid_step_px: f64,
    jitter_px: f64,
    scale: f64,
    dropped: f64,
    /// Every so many-th frame is not sent; 0 for none.
    drop_period: u64,
    /// Every so many-th frame does not show the target; 0 for none.
    blank_period: u64,
    errors: Errors,
    counter: u64,
    next: Duration,
    /// Since when the target has been in the field of view without a gap.
    seen_since: Option<Duration>,
    port: TrackerPort,
}

/// The clock that a camera stamps its frames with.
#[derive(Clone, Copy, Debug)]
struct OwnClock {
    offset: Duration,
    drift_ratio: f64,
}

impl OwnClock {
    /// What it shows at a time of the simulation.
    fn at(self, time: Duration) -> Duration {
        let gained_ns = (time.as_nanos() as f64 * self.drift_ratio).round();
        let gained = Duration::from_nanos(gained_ns.abs() as u64);
        let shown = self.offset + time;
        if gained_ns < 0.0 { shown.saturating_sub(gained) } else { shown + gained }
    }
}

/// Random errors of a frame by its number.
#[derive(Clone, Debug)]
struct Errors {
    jitter: [Noise; 2],
    drop: Noise,
    latency: Noise,
}

impl Camera {
    /// A camera that has seen nothing yet; its first shutter opens at 0 and its tracker locks at once.
    pub fn new(settings: &CameraSettings, source: Source, address: &SeedAddress) -> Self {
        let name = match source {
            Source::Coarse => "coarse tracker",
            Source::Fine => "fine tracker",
        };
        let seconds = |s: f64| Duration::from_nanos((s * 1e9).round() as u64);
        let half_shutter = seconds(0.5 * settings.shutter_s);
        let row = |cross: f64, elevation: f64, ifov: f64| [cross / ifov, elevation / ifov];
        Self {
            source,
            period_ns: 1e9 / settings.frame_rate_hz,
            counted_from: 0,
            opened_ns: 0.0,
            half_shutter,
            latency: seconds(settings.latency_s),
            latency_spread_s: settings.latency_spread_s,
            clock: OwnClock {
                offset: seconds(settings.clock_offset_s),
                drift_ratio: settings.clock_drift_ratio,
            },
            reacquisition: seconds(settings.reacquisition_s),
            pixels_per_rad: [
                row(settings.x_of_cross_elevation_ratio, settings.x_of_elevation_ratio, settings.ifov_x_rad),
                row(settings.y_of_cross_elevation_ratio, settings.y_of_elevation_ratio, settings.ifov_y_rad),
            ],
            half_field_px: [0.5 * settings.width_px, 0.5 * settings.height_px],
            centroid_step_px: settings.centroid_step_px,
            jitter_px: settings.jitter_px,
            scale: settings.scale_ratio,
            dropped: settings.dropped_ratio,
            drop_period: settings.drop_period_count.round() as u64,
            blank_period: settings.blank_period_count.round() as u64,
            errors: Errors::new(name, address),
            counter: 0,
            next: half_shutter,
            seen_since: None,
            port: TrackerPort::new(name),
        }
    }

    /// Frames per second from the next frame on.
    pub fn set_frame_rate(&mut self, rate_hz: f64) {
        let period_ns = 1e9 / rate_hz;
        if period_ns == self.period_ns {
            return;
        }
        // The next shutter opens when it would have; from there on frames are counted at the new rate.
        let opens_ns = self.opened_ns + (self.counter - self.counted_from) as f64 * self.period_ns;
        (self.opened_ns, self.counted_from, self.period_ns) = (opens_ns, self.counter, period_ns);
    }

    /// Centre of the next shutter.
    #[inline]
    pub fn next_exposure(&self) -> Duration {
        self.next
    }

    /// Where its messages come out.
    pub fn port(&mut self) -> &mut TrackerPort {
        &mut self.port
    }

    /// Takes the frame that is due: target minus axis of the camera (cross-elevation, elevation, rad) at the centre of
    /// the shutter; `None` behind the camera.
    pub fn expose(&mut self, offset_rad: Option<[f64; 2]>) {
        let exposure = self.next;
        let shown_rad = offset_rad.filter(|_| !self.in_turn(self.blank_period));
        let offset_px = shown_rad.map(|offset| self.pixels(offset)).filter(|px| self.quality(*px) > 0.0);
        self.seen_since = offset_px.and(self.seen_since.or(Some(exposure)));
        let lock = match self.seen_since {
            None => Lock::Lost,
            Some(since) if since > self.half_shutter && exposure - since < self.reacquisition => {
                Lock::Reacquiring
            }
            Some(_) => Lock::Tracking,
        };
        let measured_px = offset_px.map(|px| self.measure(px)).unwrap_or_default();
        let sample = Sample {
            // The counter on the wire wraps.
            counter: self.counter as u32,
            stamp: self.clock.at(exposure),
            x_px: measured_px[0],
            y_px: measured_px[1],
            quality: offset_px.map_or(0.0, |px| self.quality(px)) as f32,
            lock,
        };
        if !self.in_turn(self.drop_period) && !self.errors.drops(self.counter, self.dropped) {
            let beyond = self.errors.latency(self.counter, self.latency_spread_s);
            self.port.put(exposure + self.latency + beyond, encode(self.source, &sample));
        }
        self.counter += 1;
        // From the number of the frame, so that no rounding adds up.
        let frames = (self.counter - self.counted_from) as f64;
        let opens = Duration::from_nanos((self.opened_ns + frames * self.period_ns).round() as u64);
        self.next = opens + self.half_shutter;
    }

    /// Whether the frame that is due is one of those that come every so many frames.
    fn in_turn(&self, period: u64) -> bool {
        period > 0 && (self.counter + 1).is_multiple_of(period)
    }

    fn pixels(&self, [cross, elevation]: [f64; 2]) -> [f64; 2] {
        self.pixels_per_rad.map(|row| row[0] * cross + row[1] * elevation)
    }

    /// 1 where the whole image of the target is in the field, 0 where none of it is.
    fn quality(&self, px: [f64; 2]) -> f64 {
        let inside = |k: usize| self.half_field_px[k] - px[k].abs();
        (0.5 + 0.5 * inside(0).min(inside(1)) / IMAGE_RADIUS_PX).clamp(0.0, 1.0)
    }

    /// What the tracker makes of it: jitter, resolution of the centroid, scale.
    fn measure(&mut self, px: [f64; 2]) -> [f32; 2] {
        let jitter = self.errors.jitter(self.counter, self.jitter_px);
        let step = self.centroid_step_px;
        std::array::from_fn(|k| {
            let found = px[k] + jitter[k];
            let centroid = if step > 0.0 { (found / step).round() * step } else { found };
            (self.scale * centroid) as f32
        })
    }
}

impl Errors {
    fn new(name: &str, address: &SeedAddress) -> Self {
        let noise = |what: &str| Noise::new(address, &format!("{name}.{what}"), 1.0);
        Self {
            jitter: [noise("jitter-x"), noise("jitter-y")],
            drop: noise("drop"),
            latency: noise("latency"),
        }
    }

    /// Uniform on both axes, this much peak to peak.
    fn jitter(&mut self, frame: u64, peak_to_peak: f64) -> [f64; 2] {
        if peak_to_peak == 0.0 {
            return [0.0; 2];
        }
        self.jitter.each_mut().map(|noise| peak_to_peak * uniform(noise, frame))
    }

    /// What the message of a frame takes beyond its latency, uniform up to this.
    fn latency(&mut self, frame: u64, spread_s: f64) -> Duration {
        if spread_s == 0.0 {
            return Duration::ZERO;
        }
        Duration::from_secs_f64(spread_s * self.latency.uniform_at(frame))
    }

    fn drops(&mut self, frame: u64, share: f64) -> bool {
        share > 0.0 && 0.5 + uniform(&mut self.drop, frame) < share
    }
}

/// Uniform on −½ to ½: the angle of two independent Gaussians.
fn uniform(noise: &mut Noise, index: u64) -> f64 {
    noise.at(2 * index).atan2(noise.at(2 * index + 1)) / TAU
}
