//! What the interlocks remember of one axis from tick to tick. No allocation after the first tick.

mod acceleration;
mod deficit;
mod frozen;
mod runaway;
mod spell;

use drivers::cia402::Actuals;

use self::acceleration::Acceleration;
use self::deficit::Deficit;
use self::frozen::{FrozenEncoder, FrozenGyro};
use self::runaway::Runaway;
use super::operates;
use crate::model::axis::AxisGuard;

/// The gyro, where the loop of the axis is closed on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GyroSeen {
    /// Rate of the axis.
    pub(super) rate_rad_per_s: f64,
    /// Rates as they came, before they were turned into axis rates.
    pub(super) raw_rad_per_s: [f64; 3],
    /// Number of the message.
    pub(super) sequence: u8,
    /// What the rig file allows the rate to be wrong by: the bias of the unit, and its share of the speed of the other
    /// axes by their encoders.
    pub(super) error_rad_per_s: f64,
}

/// One axis in one tick, as far as it is remembered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<'a> {
    pub(super) guard: &'a AxisGuard,
    pub(super) actuals: &'a Actuals,
    /// Whether the sample is from this tick.
    pub(super) fresh: bool,
    pub(super) expects_operation: bool,
    pub(super) gyro: Option<GyroSeen>,
    /// Torque in the frame that went out with this tick's exchange.
    pub(super) sent_nm: f64,
}

/// Everything remembered of one axis.
#[derive(Clone, Debug)]
pub struct Memory {
    period_s: f64,
    /// Time since the last fresh sample: what the next one stands for.
    unsampled_s: f64,
    acceleration: Acceleration,
    mean_square_nm2: f64,
    stood_rad: Option<f64>,
    displacement_rad: f64,
    frozen_encoder: FrozenEncoder,
    frozen_gyro: FrozenGyro,
    runaway: Runaway,
    deficit: Deficit,
}

impl Memory {
    /// Nothing seen yet; the time between two ticks.
    pub(super) fn new(period_s: f64) -> Self {
        Self {
            period_s,
            unsampled_s: 0.0,
            acceleration: Acceleration::default(),
            mean_square_nm2: 0.0,
            stood_rad: None,
            displacement_rad: 0.0,
            frozen_encoder: FrozenEncoder::default(),
            frozen_gyro: FrozenGyro::default(),
            runaway: Runaway::new(period_s),
            deficit: Deficit::new(period_s),
        }
    }

    /// Once a tick, so many periods after the one before, before any interlock looks. A sample stands for all the time
    /// since the fresh one before it, be it that periods were missed or that frames were lost.
    pub(super) fn take(&mut self, seen: &Seen<'_>, periods: u32) {
        let actuals = seen.actuals;
        let operates = seen.expects_operation && operates(actuals);
        let passed_s = f64::from(periods) * self.period_s;
        let share = (passed_s / seen.guard.safety.thermal_time_s).min(1.0);
        self.mean_square_nm2 += share * (actuals.torque_nm * actuals.torque_nm - self.mean_square_nm2);
        if operates {
            self.stood_rad.get_or_insert(actuals.position_rad);
        }
        self.displacement_rad = self.stood_rad.map_or(0.0, |stood_rad| actuals.position_rad - stood_rad);
        self.deficit.told(if operates { seen.sent_nm } else { 0.0 }, periods);
        self.unsampled_s += passed_s;
        self.frozen_gyro.take(seen, self.unsampled_s);
        self.frozen_encoder.missed_rad = None;
        // A sample that did not come is another interlock's.
        if !seen.fresh {
            return;
        }
        let span_s = std::mem::take(&mut self.unsampled_s);
        self.acceleration.take(actuals.velocity_rad_per_s, span_s);
        self.frozen_encoder.take(seen, operates, span_s);
        self.runaway.take(seen, operates, self.acceleration.rad_per_s2(), span_s);
        self.deficit.take(seen, operates, span_s);
    }

    /// Acceleration from the encoder's rate, smoothed.
    pub(super) fn acceleration_rad_per_s2(&self) -> f64 {
        self.acceleration.rad_per_s2()
    }

    /// Root mean square of the torque over the thermal time.
    pub(super) fn mean_torque_nm(&self) -> f64 {
        self.mean_square_nm2.sqrt()
    }

    /// Way from where the axis stood when it was first seen in operation.
    pub(super) fn displacement_rad(&self) -> f64 {
        self.displacement_rad
    }

    /// Where the count stood still for too long: motion that it must have missed, and the limit of it.
    pub(super) fn frozen_encoder(&self) -> Option<(f64, f64)> {
        self.frozen_encoder.missed_rad
    }

    /// Where the gyro stood still for too long: motion that it must have missed, and the limit of it.
    pub(super) fn frozen_gyro(&self) -> Option<(f64, f64)> {
        self.frozen_gyro.missed_rad
    }

    /// For how long the axis has done the opposite of what its torque says.
    pub(super) fn runaway_s(&self) -> f64 {
        self.runaway.lasted_s()
    }

    /// How long the drive has shown torque that nobody asked for.
    pub(super) fn uncommanded_s(&self) -> f64 {
        self.deficit.uncommanded_s()
    }

    /// Deceleration that a stop can rely on: what the rig file says, or less where the motor has shown that it gives less.
    pub(super) fn deceleration_rad_per_s2(&self, guard: &AxisGuard) -> f64 {
        self.deficit.deceleration_rad_per_s2(guard)
    }
}
