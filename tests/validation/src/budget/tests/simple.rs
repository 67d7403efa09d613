//! The simplest plant and laws that have the published loops: a rigid body under the velocity loop of modes.md §2,
//! a mirror that is a delay, the coarse law of modes.md §6 variant b, one integrator per fine frame.

use std::collections::VecDeque;
use std::time::Duration;

use drivers::tracker::Actuals;
use sim_devices::motion::Motion;
use sim_devices::unit::UnitSettings;

use super::bed::STEP_RATE_HZ;
use crate::budget::IntegratorLoop;

const STEP_S: f64 = 1.0 / STEP_RATE_HZ as f64;
/// 1.5 ms.
const TRANSPORT_STEPS: usize = 6;
/// 3 ms between command and mirror: its lag below 100 Hz and its channel. With 7.5 ms to the message and up to two steps
/// of 0.25 ms until that is taken and obeyed the fine loop has its 11 ms.
const MIRROR_STEPS: usize = 12;

/// A queue that gives back what was put in some steps ago.
#[derive(Clone)]
struct Delay(VecDeque<f64>);

impl Delay {
    fn new(steps: usize, value: f64) -> Self {
        Self(VecDeque::from(vec![value; steps]))
    }

    fn pass(&mut self, value: f64) -> f64 {
        self.0.push_back(value);
        self.0.pop_front().unwrap_or(value)
    }
}

/// One axis under its velocity loop.
struct Axis {
    gains: [f64; 2],
    inertia: f64,
    damping: f64,
    out: Delay,
    back: Delay,
    integral: f64,
    angle: f64,
    rate: f64,
}

impl Axis {
    fn step(&mut self, command: f64) {
        let error = command - self.back.pass(self.rate);
        self.integral += self.gains[1] * STEP_S * error;
        let torque = self.out.pass(self.gains[0] * error + self.integral);
        let before = self.rate;
        self.rate += STEP_S * (torque - self.damping * self.rate) / self.inertia;
        self.angle += 0.5 * STEP_S * (before + self.rate);
    }
}

/// Both axes of the rigid director, standing at the start.
pub(super) fn plant(start_rad: [f64; 2]) -> impl FnMut([f64; 2]) -> Motion {
    let axis = |k: usize, gains, inertia, damping| Axis {
        gains,
        inertia,
        damping,
        out: Delay::new(TRANSPORT_STEPS, 0.0),
        back: Delay::new(TRANSPORT_STEPS, 0.0),
        integral: 0.0,
        angle: start_rad[k],
        rate: 0.0,
    };
    let mut axes = [
        axis(0, [23_600.0, 447_500.0], 1200.0 / 1.07, 273.6),
        axis(1, [18_250.0, 361_400.0], 975.0 / 0.957, 68.4),
    ];
    move |command| {
        axes.iter_mut().zip(command).for_each(|(axis, command)| axis.step(command));
        let pair = |value: fn(&Axis) -> f64| [value(&axes[0]), value(&axes[1])];
        let angle = pair(|axis| axis.angle);
        let rate = pair(|axis| axis.rate);
        let frame_rad_per_s2 = [0.0; 2];
        Motion {
            shaft_rad: angle,
            shaft_rad_per_s: rate,
            frame_rad: angle,
            frame_rad_per_s: rate,
            frame_rad_per_s2,
        }
    }
}

/// A mirror that follows after 3 ms, within its stroke.
pub(super) fn mirror() -> impl FnMut([f64; 2]) -> [f64; 2] {
    let mut delays = [0, 1].map(|_| Delay::new(MIRROR_STEPS, 0.0));
    move |command| {
        let mut angles = command.into_iter();
        delays.each_mut().map(|delay| delay.pass(angles.next().unwrap_or(0.0)).clamp(-1.05e-3, 1.05e-3))
    }
}

/// The fine law: an integrator per frame in line-of-sight angle, optical gains towards the mirror.
pub(super) fn fine(design: IntegratorLoop, unit: &UnitSettings) -> impl FnMut(&Actuals) -> [f64; 2] {
    let gain = design.gain_per_s / unit.trackers.fine.frame_rate_hz;
    let mut mirror_rad = [0.0_f64; 2];
    move |seen| {
        if seen.is_valid() {
            let error = [seen.cross_elevation_rad, seen.elevation_rad];
            for (k, optical) in [3.5355, 2.5].into_iter().enumerate() {
                mirror_rad[k] = (mirror_rad[k] + optical * gain * error[k]).clamp(-1.05e-3, 1.05e-3);
            }
        }
        mirror_rad
    }
}

/// Gains of the coarse law: Kt 1/s, Tt s.
const COARSE: [[f64; 2]; 2] = [[4.95, 0.246], [5.51, 0.543]];
const TRIM_S: f64 = 2.5e-3;

/// Target angle and rate as estimated at frames: an α-β filter, α and β per frame.
#[derive(Clone, Copy, Default)]
struct Estimate {
    angle: f64,
    rate: f64,
    heard: bool,
}

impl Estimate {
    fn take(&mut self, angle: f64, period_s: f64, [alpha, beta]: [f64; 2]) {
        if !self.heard {
            *self = Self { angle, rate: 0.0, heard: true };
            return;
        }
        let predicted = self.angle + self.rate * period_s;
        let surprise = angle - predicted;
        self.angle = predicted + alpha * surprise;
        self.rate += beta * surprise / period_s;
    }
}

/// The coarse law: a target estimate in inertial angle at each frame, carried on to now with its rate where a filter
/// is given, against the gyro-integrated line of sight; both 1.5 ms old.
pub(super) fn coarse(
    start_rad: [f64; 2],
    predict: Option<[f64; 2]>,
) -> impl FnMut(Duration, (&Actuals, bool), &Motion) -> [f64; 2] {
    let mut gyro =
        start_rad.map(|angle| (Delay::new(TRANSPORT_STEPS, angle), Delay::new(TRANSPORT_STEPS, 0.0)));
    let mut history: Vec<[f64; 2]> = vec![];
    let mut estimates = [Estimate::default(); 2];
    let mut integrals = [0.0; 2];
    let mut command = [0.0; 2];
    let mut exposure = Duration::ZERO;
    move |now, (seen, fresh), motion| {
        let sight = [0, 1].map(|k| gyro[k].0.pass(motion.frame_rad[k]));
        let rate = [0, 1].map(|k| gyro[k].1.pass(motion.frame_rad_per_s[k]));
        history.push(sight);
        if fresh && seen.is_valid() {
            let tick =
                (seen.exposure.as_secs_f64() * f64::from(STEP_RATE_HZ)).round() as usize + TRANSPORT_STEPS;
            let then = history[tick.min(history.len() - 1)];
            let error = [seen.cross_elevation_rad / then[1].cos(), seen.elevation_rad];
            let period_s = seen.exposure.saturating_sub(exposure).as_secs_f64();
            exposure = seen.exposure;
            for k in 0..2 {
                estimates[k].take(then[k] + error[k], period_s, predict.unwrap_or([1.0, 0.0]));
            }
        }
        if history.len() % 2 == 1 && estimates[0].heard {
            let age_s = now.saturating_sub(exposure).as_secs_f64() - 1.5e-3;
            for k in 0..2 {
                let target = estimates[k].angle + estimates[k].rate * age_s;
                let error = target - sight[k] - TRIM_S * rate[k];
                integrals[k] += error * 2.0 * STEP_S / COARSE[k][1];
                command[k] = COARSE[k][0] * (error + integrals[k]);
            }
        }
        command
    }
}
