//! What the cameras see: target, atmosphere, line of sight, mirror.
//!
//! Offsets are target minus axis of the camera, rad, in the order cross-elevation (azimuth error times cos el),
//! elevation. The fine camera looks over the mirror: of its offset `mirror angle / optical gain` is taken away.

#[cfg(test)]
mod tests;

use std::time::Duration;

use drivers::tracker::Source;

use crate::atmosphere::TipTilt;
use crate::motion::Motion;
use crate::physics::noise::SeedAddress;
use crate::target::Target;
use crate::tracker::{Camera, TrackerPort};
use crate::unit::UnitSettings;

/// Target, turbulence and both cameras.
#[derive(Clone, Debug)]
pub struct Scene {
    target: Target,
    /// When its course began.
    target_since: Duration,
    atmosphere: TipTilt,
    coarse: Camera,
    fine: Camera,
    /// Line-of-sight angle per mirror angle.
    sight_per_mirror: [f64; 2],
    next: Duration,
}

/// What really is, for tests and the operator's eyes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneTruth {
    /// Target, azimuth and elevation.
    pub target_rad: [f64; 2],
    /// Rates of the target, rad/s.
    pub target_rad_per_s: [f64; 2],
    /// Tip and tilt of the atmosphere: cross-elevation, elevation.
    pub atmosphere_rad: [f64; 2],
    /// Offset of the target from the frame's line of sight, atmosphere not counted; `None` behind the director.
    pub coarse_error_rad: Option<[f64; 2]>,
    /// What is left behind the mirror, atmosphere included.
    pub fine_error_rad: Option<[f64; 2]>,
}

impl Scene {
    /// A scene at the start of a run.
    pub fn new(unit: &UnitSettings, address: &SeedAddress) -> Self {
        let trackers = &unit.trackers;
        let coarse = Camera::new(&trackers.coarse, Source::Coarse, address);
        let fine = Camera::new(&trackers.fine, Source::Fine, address);
        let gains = [trackers.optical_gain_cross_elevation_ratio, trackers.optical_gain_elevation_ratio];
        Self {
            target: Target::new(&unit.target, address),
            target_since: Duration::ZERO,
            atmosphere: TipTilt::new(&unit.atmosphere, address),
            next: coarse.next_exposure().min(fine.next_exposure()),
            coarse,
            fine,
            // A gain of 0 stands for a mirror that moves nothing.
            sight_per_mirror: gains.map(|gain| if gain == 0.0 { 0.0 } else { 1.0 / gain }),
        }
    }

    /// Another target before the cameras, whose course begins at `now`, and another frame rate of the fine one.
    pub fn bring(&mut self, unit: &UnitSettings, address: &SeedAddress, now: Duration) {
        (self.target, self.target_since) = (Target::new(&unit.target, address), now);
        self.fine.set_frame_rate(unit.trackers.fine.frame_rate_hz);
        self.next = self.coarse.next_exposure().min(self.fine.next_exposure());
    }

    /// When the next shutter is due.
    #[inline]
    pub fn next(&self) -> Duration {
        self.next
    }

    /// Brings the scene to `now` with what structure and mirror (azimuth, elevation axis) do there. To be called at
    /// every step; it does something only when a shutter is due.
    #[inline]
    pub fn advance(&mut self, now: Duration, motion: &Motion, mirror_rad: [f64; 2]) {
        if now >= self.next {
            self.expose(now, motion, mirror_rad);
        }
    }

    #[cold]
    fn expose(&mut self, now: Duration, motion: &Motion, mirror_rad: [f64; 2]) {
        while self.next <= now {
            let centre = self.next;
            let truth = self.truth_at(centre, now, motion, mirror_rad);
            if self.coarse.next_exposure() == centre {
                let tilt = truth.atmosphere_rad;
                let seen = truth.coarse_error_rad.map(|error| [error[0] + tilt[0], error[1] + tilt[1]]);
                self.coarse.expose(seen);
            }
            if self.fine.next_exposure() == centre {
                self.fine.expose(truth.fine_error_rad);
            }
            self.next = self.coarse.next_exposure().min(self.fine.next_exposure());
        }
    }

    /// Messages of the coarse tracker.
    pub fn coarse_port(&mut self) -> &mut TrackerPort {
        self.coarse.port()
    }

    /// Messages of the fine tracker.
    pub fn fine_port(&mut self) -> &mut TrackerPort {
        self.fine.port()
    }

    /// What really is at `now`, which must not go back.
    pub fn truth(&mut self, now: Duration, motion: &Motion, mirror_rad: [f64; 2]) -> SceneTruth {
        self.truth_at(now, now, motion, mirror_rad)
    }

    /// At `time`, a little before `now`, when the structure was where its rates say.
    fn truth_at(
        &mut self,
        time: Duration,
        now: Duration,
        motion: &Motion,
        mirror_rad: [f64; 2],
    ) -> SceneTruth {
        let target = self.target.at(time.saturating_sub(self.target_since));
        let atmosphere_rad = self.atmosphere.at(time);
        let ago_s = (now - time).as_secs_f64();
        let axis = std::array::from_fn(|k| motion.frame_rad[k] - ago_s * motion.frame_rad_per_s[k]);
        let coarse_error_rad = offset(target.angle_rad, axis);
        let behind_mirror = |error: [f64; 2]| {
            std::array::from_fn(|k| error[k] + atmosphere_rad[k] - self.sight_per_mirror[k] * mirror_rad[k])
        };
        SceneTruth {
            target_rad: target.angle_rad,
            target_rad_per_s: target.rate_rad_per_s,
            atmosphere_rad,
            coarse_error_rad,
            fine_error_rad: coarse_error_rad.map(behind_mirror),
        }
    }
}

/// Where a direction lies in the image of a camera along another one (both azimuth, elevation): gnomonic projection,
/// for small angles `[Δaz·cos el, Δel]`. `None` behind the camera.
fn offset(target_rad: [f64; 2], axis_rad: [f64; 2]) -> Option<[f64; 2]> {
    let (sine, cosine) = target_rad[1].sin_cos();
    let (axis_sine, axis_cosine) = axis_rad[1].sin_cos();
    let (turn_sine, turn_cosine) = (target_rad[0] - axis_rad[0]).sin_cos();
    let ahead = sine * axis_sine + cosine * axis_cosine * turn_cosine;
    let up = sine * axis_cosine - cosine * axis_sine * turn_cosine;
    (ahead > 0.0).then(|| [cosine * turn_sine / ahead, up / ahead])
}
