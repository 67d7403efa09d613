//! Both axes on a target: World, velocity loops at 4 kHz on the gyro, coarse track law at 2 kHz on camera frames.

use std::time::Duration;

use controllers::camera::Frame;
use controllers::coarse_track::CoarseTracker;
use controllers::velocity::VelocityController;
use sim_devices::physics::delay::{DelayLine, steps};
use sim_devices::physics::noise::{Noise, SeedAddress};
use sim_devices::target::Target;
use sim_devices::unit::{CameraSettings, UnitSettings};
use sim_devices::world::{StartState, World};

use crate::budget::centroid_variance_px2;
use crate::prediction::{Subject, rig_limits};

/// Rate of plant and velocity loop; the modes are exact at any step.
const TICK_RATE_HZ: u32 = 4000;
const TICK_S: f64 = 1.0 / TICK_RATE_HZ as f64;
/// Ticks of the track law.
const LAW_TICKS: u32 = 2;
/// Ticks between two rows of the record.
const ROW_TICKS: u32 = 10;
/// Rows per second.
pub(super) const ROW_RATE_HZ: f64 = (TICK_RATE_HZ / ROW_TICKS) as f64;
/// Ends of the records: a whole way along the rails with its reversal; the drone's hover and part of its descent.
const RAIL_S: u32 = 48;
const DRONE_S: u32 = 24;
/// The target stands at first.
const STANDING_S: f64 = 2.0;
/// What is acquired before is not counted.
const ACQUIRED_S: f64 = 6.0;
/// A window stays open for so long after the acceleration that opened it: the track loop forgets in as much.
const WINDOW_AFTER_S: f64 = 0.4;
/// Kinds of targets in the settings.
pub(super) const RAIL: f64 = 1.0;
pub(super) const DRONE: f64 = 2.0;
/// Elevation of the drone (director.md 4.5: 85 m high at 85 m).
const DRONE_ELEVATION_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// A flown engagement, one row per 2.5 ms from the start of the motion on.
pub(super) struct Engagement {
    /// Target minus line of sight in the camera: cross-elevation, elevation.
    error_rad: [Vec<f64>; 2],
    /// Acceleration of the target.
    acceleration: [Vec<f64>; 2],
    half_field_rad: [f64; 2],
    lost: [bool; 2],
}

impl Engagement {
    pub(super) fn run(subject: &Subject<'_>, kind: f64) -> Self {
        let unit = scenario(subject.unit, kind);
        let address = SeedAddress { seed: 1, procedure: "PREDICTION".into(), point: "tracking".into() };
        let length_s = if kind == DRONE { DRONE_S } else { RAIL_S };
        let target = Target::new(&unit.target, &address);
        let start = target.at(Duration::ZERO).angle_rad;
        let pose = StartState { az_rad: start[0], el_rad: start[1], heat_sink_degc: 40.0 };
        let mut world = World::new(&unit, pose);
        let mut axes = [0, 1].map(|axis| Axis::new(subject, &unit, &address, axis));
        let mut flown = Self {
            error_rad: [vec![], vec![]],
            acceleration: [vec![], vec![]],
            half_field_rad: [0, 1].map(|axis| half_field_rad(&unit.trackers.coarse, axis)),
            lost: [false; 2],
        };
        let mut rate_before = [0.0; 2];
        for tick in 0..length_s * TICK_RATE_HZ {
            let now_s = f64::from(tick) * TICK_S;
            let motion = world.motion();
            let seen =
                target.at(Duration::from_nanos(u64::from(tick) * 1_000_000_000 / u64::from(TICK_RATE_HZ)));
            let cosine = motion.frame_rad[1].cos();
            let errors: [f64; 2] = std::array::from_fn(|k| seen.angle_rad[k] - motion.frame_rad[k]);
            let torque = [0, 1].map(|k| {
                let gain = if k == 0 { cosine } else { 1.0 };
                axes[k].tick(tick, now_s, errors[k], gain, motion.frame_rad_per_s[k])
            });
            world.step(torque);
            if tick % ROW_TICKS == 0 {
                for k in 0..2 {
                    let change = (seen.rate_rad_per_s[k] - rate_before[k]) * ROW_RATE_HZ;
                    if now_s >= ACQUIRED_S {
                        flown.error_rad[k].push(errors[k] * if k == 0 { cosine } else { 1.0 });
                        flown.acceleration[k].push(change);
                    }
                }
                rate_before = seen.rate_rad_per_s;
            }
        }
        flown.lost = [0, 1].map(|k| axes[k].lost);
        flown
    }

    /// 1σ RMS outside the windows around the target's accelerations, which take this share of the record at most.
    pub(super) fn rms_rad(&self, axis: usize, left_out: f64) -> f64 {
        let open = self.windows(axis, left_out);
        let rows = self.error_rad[axis].iter().zip(&open);
        let kept: Vec<f64> = rows.filter(|(_, open)| !**open).map(|(error, _)| *error).collect();
        let mean = kept.iter().sum::<f64>() / kept.len() as f64;
        (kept.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / kept.len() as f64).sqrt()
    }

    /// Rows within windows: open while the acceleration is above a threshold and for a little after. The threshold is
    /// the lowest with which they keep to the share; it depends on the target alone.
    fn windows(&self, axis: usize, share: f64) -> Vec<bool> {
        let after = (WINDOW_AFTER_S * ROW_RATE_HZ) as usize;
        let opened = |threshold: f64| {
            let mut left = 0;
            let each = self.acceleration[axis].iter().map(|acceleration| {
                left = if acceleration.abs() > threshold { after } else { left.saturating_sub(1) };
                left > 0
            });
            each.collect::<Vec<bool>>()
        };
        let mut bounds = [0.0, self.acceleration[axis].iter().fold(0.0, |most: f64, a| most.max(a.abs()))];
        for _ in 0..20 {
            let middle = 0.5 * (bounds[0] + bounds[1]);
            let taken = opened(middle).iter().filter(|open| **open).count();
            let fits = taken as f64 <= share * self.acceleration[axis].len() as f64;
            bounds[usize::from(fits)] = middle;
        }
        opened(bounds[1])
    }

    /// The longest stretch within this error.
    pub(super) fn within(&self, axis: usize, limit_rad: f64) -> &[f64] {
        let stretches = self.error_rad[axis].split(|e| e.abs() > limit_rad);
        stretches.max_by_key(|stretch| stretch.len()).unwrap_or(&[])
    }

    /// Largest error over half the field of view; not a number once the target was lost.
    pub(super) fn field_used(&self, axis: usize) -> f64 {
        let largest = self.error_rad[axis].iter().fold(0.0, |most: f64, e| most.max(e.abs()));
        let used = largest / self.half_field_rad[axis];
        if self.lost[axis] { used.max(2.0) } else { used }
    }
}

fn scenario(unit: &UnitSettings, kind: f64) -> UnitSettings {
    let mut unit = unit.clone();
    unit.step_rate_hz = f64::from(TICK_RATE_HZ);
    unit.target.kind_count = kind;
    unit.target.standing_s = STANDING_S;
    unit.target.azimuth_rad = 0.0;
    unit.target.elevation_rad = if kind == DRONE { DRONE_ELEVATION_RAD } else { 0.0 };
    unit
}

/// Half the field of view along cross-elevation or elevation.
fn half_field_rad(camera: &CameraSettings, axis: usize) -> f64 {
    let ratios = [
        [camera.x_of_cross_elevation_ratio, camera.y_of_cross_elevation_ratio],
        [camera.x_of_elevation_ratio, camera.y_of_elevation_ratio],
    ][axis];
    let sides = [camera.width_px * camera.ifov_x_rad, camera.height_px * camera.ifov_y_rad];
    let reach = |k: usize| 0.5 * sides[k] / ratios[k].abs();
    reach(0).min(reach(1))
}

/// One axis: camera, laws, delays.
struct Axis {
    tracker: CoarseTracker,
    velocity: VelocityController,
    camera: CameraSettings,
    half_field_rad: f64,
    noise_rad: f64,
    noise: Noise,
    rates: DelayLine<f64>,
    torques: DelayLine<f64>,
    torque_ratio: f64,
    command: f64,
    exposures: u32,
    /// Frames under way: exposed at, error.
    under_way: std::collections::VecDeque<(f64, Option<f64>)>,
    lost: bool,
}

impl Axis {
    fn new(subject: &Subject<'_>, unit: &UnitSettings, address: &SeedAddress, axis: usize) -> Self {
        let settings = unit.axis(axis);
        let gains = subject.gains(axis);
        let current_lag_s = 1.0 / (std::f64::consts::TAU * settings.current_bandwidth_hz);
        let command_steps = steps(TICK_S + settings.command_delay_s + current_lag_s, TICK_S);
        let torque_limit_nm = rig_limits::TORQUE_NM[axis]
            .min(settings.current_limit_a * settings.rated_torque_nm / settings.rated_current_a);
        let camera = unit.trackers.coarse.clone();
        let ifov_rad = 2.0 * half_field_rad(&camera, axis)
            / if camera.x_of_elevation_ratio.abs() > 0.5 && axis == 1 {
                camera.width_px
            } else {
                camera.height_px
            };
        Self {
            tracker: CoarseTracker::new(
                &gains.track,
                &subject.gains.track,
                rig_limits::VELOCITY_RAD_PER_S,
                TICK_S * f64::from(LAW_TICKS),
            ),
            velocity: VelocityController::new(gains, torque_limit_nm, TICK_S),
            half_field_rad: half_field_rad(&camera, axis),
            noise_rad: centroid_variance_px2(&camera).sqrt() * ifov_rad,
            noise: Noise::new(address, ["coarse.az", "coarse.el"][axis], 1.0),
            rates: DelayLine::new(steps(unit.imu.delay_s + 1.5 * TICK_S, TICK_S), 0.0),
            torques: DelayLine::new(command_steps, 0.0),
            torque_ratio: crate::prediction::torque_ratio(settings),
            command: 0.0,
            exposures: 0,
            under_way: std::collections::VecDeque::new(),
            lost: false,
            camera,
        }
    }

    /// One tick; the motor torque. `gain` turns the axis' angle into that in the camera.
    fn tick(&mut self, tick: u32, now_s: f64, error_rad: f64, gain: f64, rate: f64) -> f64 {
        self.expose(now_s, error_rad, gain);
        let gyro = self.rates.push(rate);
        if tick.is_multiple_of(LAW_TICKS) {
            let frame = self.arrived(now_s);
            self.command = self.tracker.update(frame, gyro);
        }
        self.torque_ratio * self.torques.push(self.velocity.update(self.command, gyro, 0.0))
    }

    fn expose(&mut self, now_s: f64, error_rad: f64, gain: f64) {
        if now_s * self.camera.frame_rate_hz < f64::from(self.exposures) - 1e-9 {
            return;
        }
        let number = self.exposures;
        self.exposures += 1;
        // Frames are lost evenly: what counts is their share.
        let kept = 1.0 - self.camera.dropped_ratio;
        if (f64::from(number + 1) * kept).floor() == (f64::from(number) * kept).floor() {
            return;
        }
        let in_camera = error_rad * gain;
        let is_in_field = in_camera.abs() < self.half_field_rad;
        self.lost |= !is_in_field;
        let noise_rad = self.noise_rad * self.noise.at(u64::from(number));
        let seen = (self.camera.scale_ratio * in_camera + noise_rad) / gain;
        self.under_way.push_back((now_s, is_in_field.then_some(seen)));
    }

    fn arrived(&mut self, now_s: f64) -> Option<Frame> {
        let (exposed_s, error_rad) = *self.under_way.front()?;
        if now_s < exposed_s + self.camera.latency_s {
            return None;
        }
        self.under_way.pop_front();
        Some(Frame { error_rad, age_s: now_s - exposed_s })
    }
}
