//! What rides on the gimbal: inertial unit, mirror, cameras, and the sky they look into.

mod imu;
mod mirror;

use std::time::Duration;

use crate::motion::{FrameMotion, Motion};
use crate::physics::delay::DelayLine;
use crate::physics::noise::SeedAddress;
use crate::scene::Scene;
use crate::unit::UnitSettings;

pub use self::imu::ImuType;
pub use self::mirror::MirrorType;

pub(crate) use self::imu::Imu;
pub(crate) use self::mirror::MirrorUnit;

/// Makes of the devices on the gimbal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceTypes {
    /// Inertial unit.
    pub imu: ImuType,
    /// Controller of the mirror.
    pub mirror: MirrorType,
}

/// Gauge monitors of the mirror, then its command inputs: channels of the analog card.
pub(crate) const MIRROR_AXES: usize = 2;

/// Devices on the gimbal.
#[derive(Debug)]
pub(crate) struct Payload {
    pub(crate) imu: Imu,
    pub(crate) mirror: MirrorUnit,
    pub(crate) scene: Scene,
    /// Motions of the last steps: the inertial unit filters, so its messages are late.
    motions: DelayLine<FrameMotion>,
    /// Age of a message's motion in steps: whole ones, and the rest.
    age_steps: usize,
    age_rest: f64,
    pulse_rate_hz: f64,
    /// Number and instant of the last pulse on the trigger input of the inertial unit.
    last_trigger: Option<(u64, Duration)>,
    step_rate_hz: f64,
    /// The step at whose end a shutter is due.
    look_step: u64,
}

/// What rounding may add to a count of steps.
const ROUNDING_STEPS: f64 = 1e-6;

impl Payload {
    /// Devices at the start of a point on a structure that does this; `pulse_rate_hz` synchronises the inertial unit.
    pub(crate) fn new(
        types: DeviceTypes,
        unit: &UnitSettings,
        address: &SeedAddress,
        motion: FrameMotion,
        pulse_rate_hz: f64,
    ) -> Self {
        let imu = Imu::new(types.imu, unit, address, pulse_rate_hz);
        let age = imu.delay_s() * unit.step_rate_hz;
        let age_steps = age as usize;
        let scene = Scene::new(unit, address);
        Self {
            look_step: look_step(&scene, unit.step_rate_hz),
            imu,
            mirror: MirrorUnit::new(types.mirror, unit, address),
            scene,
            motions: DelayLine::new(age_steps + 2, motion),
            age_steps,
            age_rest: age - age_steps as f64,
            pulse_rate_hz,
            last_trigger: None,
            step_rate_hz: unit.step_rate_hz,
        }
    }

    /// One step of what works at the rate of the world.
    #[inline]
    pub(crate) fn step(&mut self, step: u64, motion: FrameMotion) {
        self.motions.push(motion);
        self.mirror.step(step);
        let Self { motions, age_steps, age_rest, .. } = self;
        let now_s = (step + 1) as f64 / self.step_rate_hz;
        self.imu.reach(now_s, || aged(motions, *age_steps, *age_rest));
        if step >= self.look_step {
            self.look_after(step);
        }
    }

    /// Lets the cameras expose what is due by the end of a step, with the mirror as it is then.
    #[cold]
    fn look_after(&mut self, step: u64) {
        let end_ns = (step + 1) as f64 / self.step_rate_hz * 1e9;
        self.look(Duration::from_nanos(end_ns.round_ties_even() as u64));
    }

    /// Lets the cameras expose what is due.
    pub(crate) fn look(&mut self, now: Duration) {
        self.scene.advance(now, &self.motions.ago(0).into(), self.mirror.mirror().angle_rad());
        self.look_step = look_step(&self.scene, self.step_rate_hz);
    }

    /// The synchronisation pulse of an exchange in this process at `now`, which is a multiple of the period.
    pub(crate) fn pulse(&mut self, now: Duration) {
        let tick = (now.as_secs_f64() * self.pulse_rate_hz).round_ties_even() as u64;
        self.give_pulse(tick);
    }

    /// A pulse on the trigger cable of the inertial unit. The clock of a bus begins at any instant and has a rate of its own, so
    /// that pulses are counted from one to the next.
    pub(crate) fn trigger(&mut self, now: Duration) {
        let periods = |time: Duration| (time.as_secs_f64() * self.pulse_rate_hz).round_ties_even() as u64;
        let tick = match self.last_trigger {
            Some((tick, last)) => tick + periods(now.saturating_sub(last)).max(1),
            None => periods(now),
        };
        self.last_trigger = Some((tick, now));
        self.imu.set_phase(now.as_secs_f64() - tick as f64 / self.pulse_rate_hz);
        self.give_pulse(tick);
    }

    fn give_pulse(&mut self, tick: u64) {
        let Self { motions, age_steps, age_rest, .. } = self;
        self.imu.pulse(tick, || aged(motions, *age_steps, *age_rest));
    }
}

/// The motion so many steps ago.
fn aged(motions: &DelayLine<FrameMotion>, age_steps: usize, age_rest: f64) -> Motion {
    let young = motions.ago(age_steps);
    let old = motions.ago(age_steps + 1);
    young.towards(&old, age_rest).into()
}

/// The step at whose end the next shutter is due.
fn look_step(scene: &Scene, step_rate_hz: f64) -> u64 {
    let steps = scene.next().as_secs_f64() * step_rate_hz - ROUNDING_STEPS;
    (steps.ceil() as u64).saturating_sub(1)
}
