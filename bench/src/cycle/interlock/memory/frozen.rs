//! Channels that stand still while the axis does not. An axis at rest is not frozen.

use super::{GyroSeen, Seen};

/// A channel that is the same for this long is looked at.
const HELD_S: f64 = 0.050;
/// Motion that it must have missed, in counts.
const MISSED_COUNTS: f64 = 20.0;
/// What a gyro without error shows in that time of an axis at rest: the Earth's rate of 73 urad/s, and noise.
const REST_RAD: f64 = 5e-6;
/// Motion that is in doubt whatever says so: delays of rates and counts differ.
const DOUBTFUL_RAD: f64 = 10e-6;
/// Torque moves an axis for certain above this multiple of its least static friction: more than any unit may have.
const CERTAIN_BREAKAWAY: f64 = 2.0;
/// No axis stops faster than with this multiple of its largest torque.
const HARDEST_STOP: f64 = 2.0;

/// The encoder: its count is the same, bit for bit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrozenEncoder {
    counts: i32,
    held_s: f64,
    /// Way that the axis makes at the least from the speed that it had when the count last changed.
    momentum_rad: f64,
    by_gyro_rad: f64,
    /// The part of it that may be the gyro's own error: what the rig file declares, never what was found.
    gyro_error_rad: f64,
    by_torque_rad: f64,
    /// The part of it in ticks without a gyro.
    without_gyro_rad: f64,
    torque_rate_rad_per_s: f64,
    pub(super) missed_rad: Option<(f64, f64)>,
}

impl FrozenEncoder {
    /// A fresh sample, `span_s` after the one before.
    pub(super) fn take(&mut self, seen: &Seen<'_>, operates: bool, span_s: f64) {
        if seen.actuals.position_counts != self.counts {
            let momentum_rad = least_way_rad(seen);
            *self = Self { counts: seen.actuals.position_counts, momentum_rad, ..Self::default() };
            return;
        }
        self.held_s += span_s;
        if operates {
            self.predict(seen, span_s);
        }
        if self.held_s < HELD_S {
            return;
        }
        let limit_rad = MISSED_COUNTS * seen.guard.encoder_quantum_rad;
        let missed_rad = self.predicted_rad().max(self.momentum_rad);
        self.missed_rad = Some((missed_rad, limit_rad));
        // The next 50 ms stand for themselves: noise must not add up while an axis rests.
        *self = Self { counts: self.counts, missed_rad: self.missed_rad, ..Self::default() };
    }

    /// Motion that gyro and torque say. What the gyro shows may be bias and the other axis, except where torque says the
    /// same; without a gyro the torque says it by itself.
    fn predicted_rad(&self) -> f64 {
        let by_gyro_rad = (self.by_gyro_rad.abs() - REST_RAD).max(0.0);
        let by_both_rad = self.by_torque_rad.min(by_gyro_rad);
        (by_gyro_rad - self.gyro_error_rad).max(by_both_rad).max(self.without_gyro_rad)
    }

    fn predict(&mut self, seen: &Seen<'_>, span_s: f64) {
        let stop = &seen.guard.stop;
        let actuals = seen.actuals;
        let held_nm = CERTAIN_BREAKAWAY * stop.friction.static_nm + stop.loads.at(actuals.position_rad).abs();
        let excess_nm = (actuals.torque_nm.abs() - held_nm).max(0.0);
        self.torque_rate_rad_per_s += excess_nm / stop.inertia_kg_m2 * span_s;
        let way_rad = self.torque_rate_rad_per_s * span_s;
        self.by_torque_rad += way_rad;
        match seen.gyro {
            Some(GyroSeen { rate_rad_per_s, error_rad_per_s, .. }) => {
                self.by_gyro_rad += rate_rad_per_s * span_s;
                self.gyro_error_rad += error_rad_per_s * span_s;
            }
            None => self.without_gyro_rad += way_rad,
        }
    }
}

/// Way that the axis needs to stop whatever brakes it, less what the rate's own delay is worth.
fn least_way_rad(seen: &Seen<'_>) -> f64 {
    let guard = seen.guard;
    let rate = seen.actuals.velocity_rad_per_s;
    let hardest_nm = HARDEST_STOP * guard.max_torque_nm + guard.worst_load_nm;
    let way_rad = 0.5 * guard.stop.inertia_kg_m2 * rate * rate / hardest_nm;
    (way_rad - DOUBTFUL_RAD).max(0.0)
}

/// The gyro: its rates are the same, bit for bit, or its messages do not count on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrozenGyro {
    rates: Held<[f64; 3]>,
    sequence: Held<u8>,
    pub(super) missed_rad: Option<(f64, f64)>,
}

impl FrozenGyro {
    /// Once a tick; a fresh sample comes `span_s` after the one before.
    pub(super) fn take(&mut self, seen: &Seen<'_>, span_s: f64) {
        self.missed_rad = None;
        let (Some(gyro), true) = (seen.gyro, seen.fresh) else {
            *self = Self::default();
            return;
        };
        let at_rad = seen.actuals.position_rad;
        let by_rates = self.rates.take(gyro.raw_rad_per_s, at_rad, span_s);
        let by_sequence = self.sequence.take(gyro.sequence, at_rad, span_s);
        if let Some(moved_rad) = by_rates.or(by_sequence) {
            let limit_rad = MISSED_COUNTS * seen.guard.encoder_quantum_rad + DOUBTFUL_RAD;
            self.missed_rad = Some((moved_rad, limit_rad));
        }
    }
}

/// A value, for how long it has been the same, and where the axis was when that began.
#[derive(Clone, Copy, Debug, Default)]
struct Held<T> {
    value: Option<T>,
    held_s: f64,
    from_rad: f64,
}

impl<T: PartialEq + Copy> Held<T> {
    /// Motion of the axis in 50 ms of the same value.
    fn take(&mut self, value: T, at_rad: f64, span_s: f64) -> Option<f64> {
        if self.value != Some(value) {
            *self = Self { value: Some(value), held_s: 0.0, from_rad: at_rad };
            return None;
        }
        self.held_s += span_s;
        if self.held_s < HELD_S {
            return None;
        }
        let moved_rad = (at_rad - self.from_rad).abs();
        *self = Self { held_s: 0.0, from_rad: at_rad, ..*self };
        Some(moved_rad)
    }
}
