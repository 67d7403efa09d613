//! The production laws of both axes, put together as the control computer does.

use std::time::Duration;

use controllers::DirectorGains;
use controllers::camera::{Frame, TrackState};
use controllers::coarse_track::CoarseTracker;
use controllers::earth_rate::EarthRate;
use controllers::fine_track::FineTracker;
use controllers::keyhole::Keyhole;
use controllers::line_of_sight::ImuMount;
use controllers::off_load::OffLoad;
use controllers::velocity::VelocityController;
use drivers::tracker::Actuals;
use sim_devices::unit::UnitSettings;

use super::director::{Commands, Sensed};
use crate::probe::LAW_TICKS;

/// Tick of the velocity loops and of the fine track loop.
const TICK_S: f64 = 250e-6;
/// Both axes reach 60 deg/s.
const RATE_LIMIT_RAD_PER_S: f64 = 1.047;

/// What the director is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// Follow the target with both loops.
    Track,
    /// Keep the rates at zero.
    Stand,
}

/// Laws of both axes; pairs are azimuth, elevation.
pub(super) struct Laws {
    task: Task,
    mount: ImuMount,
    earth: EarthRate,
    keyhole: Keyhole,
    velocity: [VelocityController; 2],
    coarse: [CoarseTracker; 2],
    fine: [FineTracker; 2],
    off_load: [OffLoad; 2],
    /// A coarse frame that came between two updates of the tracker.
    frame: Option<Actuals>,
    wish_rad_per_s: [f64; 2],
    ticks: usize,
}

impl Laws {
    /// At rest, without a target.
    pub(super) fn new(unit: &UnitSettings, gains: &DirectorGains, task: Task) -> Self {
        let axes = [(&unit.az, &gains.az), (&unit.el, &gains.el)];
        let optical_gains = [gains.fine.az_optical_gain, gains.fine.el_optical_gain];
        let frame_s = 1.0 / unit.trackers.fine.frame_rate_hz;
        let law_s = LAW_TICKS as f64 * TICK_S;
        Self {
            task,
            mount: ImuMount::new(gains.elevation_sign),
            earth: EarthRate::new(&gains.earth),
            keyhole: Keyhole::new(&gains.keyhole)
                .expect("the table's ranges leave a keyhole below the zenith"),
            velocity: axes.map(|(axis, gains)| {
                let limit_nm = axis.torque_constant_nm_per_a * axis.current_limit_a;
                VelocityController::new(gains, limit_nm, TICK_S)
            }),
            coarse: axes
                .map(|(_, axis)| CoarseTracker::new(&axis.track, &gains.track, RATE_LIMIT_RAD_PER_S, law_s)),
            fine: optical_gains.map(|gain| FineTracker::new(&gains.fine, gain, frame_s, TICK_S)),
            off_load: optical_gains.map(|gain| {
                OffLoad::new(&gains.off_load, gain, TICK_S).expect("no optical gain in use is 0")
            }),
            frame: None,
            wish_rad_per_s: [0.0; 2],
            ticks: 0,
        }
    }

    /// One tick.
    pub(super) fn tick(&mut self, sensed: &Sensed) -> Commands {
        let [az_rad, el_rad] = sensed.drives.map(|drive| drive.position_rad);
        let rates = self.mount.axis_rates(sensed.body_rad_per_s, el_rad);
        // What the gyros read on axes that stand still on the Earth is no motion of theirs.
        let rate = [
            rates.az_rad_per_s - self.earth.azimuth_rad_per_s(),
            rates.el_rad_per_s - self.earth.elevation_rad_per_s(az_rad),
        ];
        let mut mirror_rad = [0.0; 2];
        let mut command = [0.0; 2];
        if self.task == Task::Track {
            mirror_rad = self.follow_fine(sensed);
            command = self.follow_coarse(sensed, el_rad, rate);
        }
        self.ticks += 1;
        let torque_nm = [0, 1].map(|k| self.velocity[k].update(command[k], rate[k], 0.0));
        Commands { torque_nm, mirror_rad }
    }

    /// Whether both loops have their target.
    pub(super) fn locked(&self) -> bool {
        let states =
            self.coarse.iter().map(CoarseTracker::state).chain(self.fine.iter().map(FineTracker::state));
        states.into_iter().all(|state| state == TrackState::Tracking)
    }

    fn follow_fine(&mut self, sensed: &Sensed) -> [f64; 2] {
        let (seen, fresh) = &sensed.fine;
        let errors_rad = [seen.cross_elevation_rad, seen.elevation_rad];
        [0, 1].map(|k| self.fine[k].update(fresh.then(|| frame(seen, errors_rad[k], sensed.now))))
    }

    /// Rate commands: of the coarse tracker, and what the mirror hands over.
    fn follow_coarse(&mut self, sensed: &Sensed, el_rad: f64, rate_rad_per_s: [f64; 2]) -> [f64; 2] {
        let (seen, fresh) = &sensed.coarse;
        if *fresh {
            self.frame = Some(*seen);
        }
        let secant = self.keyhole.update(el_rad);
        if self.ticks.is_multiple_of(LAW_TICKS) {
            self.coarse[0].fade_integral(secant.integral_factor);
            let frames = self.frame.take().map(|seen| {
                [secant.gain * seen.cross_elevation_rad, seen.elevation_rad]
                    .map(|error_rad| frame(&seen, error_rad, sensed.now))
            });
            self.wish_rad_per_s =
                [0, 1].map(|k| self.coarse[k].update(frames.map(|frames| frames[k]), rate_rad_per_s[k]));
        }
        let held = [0, 1].map(|k| {
            let tracking = self.fine[k].state() == TrackState::Tracking;
            self.off_load[k].update(if tracking { sensed.mirror.angle_rad[k] } else { 0.0 })
        });
        [self.wish_rad_per_s[0] + secant.gain * held[0], self.wish_rad_per_s[1] + held[1]]
    }
}

/// A frame as the laws take it.
fn frame(seen: &Actuals, error_rad: f64, now: Duration) -> Frame {
    let age_s = now.saturating_sub(seen.exposure).as_secs_f64();
    Frame { error_rad: seen.is_valid().then_some(error_rad), age_s }
}
