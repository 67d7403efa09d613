//! The interlocks of a rig, tick by tick: what they see, what they remember, which was first.

use procedures::axis::MAX_AXES;
use procedures::case::{Bounds, Zone};

use super::memory::{GyroSeen, Memory, Seen};
use super::zone::{Approach, entered};
use super::{Interlock, Trip, View, first_out};
use crate::model::axis::VelocityFeedback;
use crate::rig::ArmedRig;

/// A value for each axis of a rig that has so many; the places of axes that it lacks stay empty.
pub fn per_axis<T: Default>(axes: usize, value: impl Fn(usize) -> T) -> [T; MAX_AXES] {
    std::array::from_fn(|axis| if axis < axes { value(axis) } else { T::default() })
}

/// What the loop knows in a tick beside the rig itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Situation {
    /// Whether valid inputs have not come yet: nothing can be checked, nothing can move.
    pub waits_for_inputs: bool,
    /// Whether the drives must be in operation now.
    pub expects_operation: bool,
    /// Whether the loops are closed on the gyro (a stop is closed on the encoder).
    pub uses_feedback: bool,
    /// Position reference less position per axis, where a position loop is closed.
    pub following_error_rad: [Option<f64>; MAX_AXES],
    /// Torque per axis in the frame that went out with this tick's exchange.
    pub sent_nm: [f64; MAX_AXES],
    /// Tighter bounds of this point.
    pub bounds: Option<Bounds>,
    /// How long the target that the axes follow has been missing, and how long it may be.
    pub target_missing_s: Option<(f64, f64)>,
    /// Periods missed in a row before this tick.
    pub missed_periods: u32,
    /// Longest allowed run of missed periods.
    pub max_missed_periods: u32,
    /// Share of the ring to the log's writer that is taken.
    pub ring_ratio: f64,
    /// Time since the slowest part of the bench gave a sign of life.
    pub silent_s: f64,
}

/// Every interlock of every axis.
#[derive(Clone, Debug)]
pub struct Watch {
    period_s: f64,
    memory: [Memory; MAX_AXES],
    zones: Vec<Zone>,
}

impl Watch {
    /// Nothing seen yet.
    pub fn new(period_s: f64) -> Self {
        let memory = std::array::from_fn(|_| Memory::new(period_s));
        Self { period_s, memory, zones: Vec::new() }
    }

    /// The watch of a point with restricted zones.
    pub fn keeping_out_of(self, zones: &[Zone]) -> Self {
        Self { zones: zones.to_vec(), ..self }
    }

    /// Once a tick, after the exchange: the first interlock that trips and is not the `latched` one.
    ///
    /// What was seen does not vanish in one tick: what has tripped is not told twice, and what both axes share must not
    /// count as a second trip when the other axis sees it, too.
    pub fn tick(&mut self, rig: &ArmedRig, situation: &Situation, latched: Option<&Trip>) -> Option<Trip> {
        if situation.waits_for_inputs {
            return None;
        }
        let axes = rig.axes().len().min(MAX_AXES);
        // Every axis is remembered in every tick, whichever trips.
        for axis in 0..axes {
            let seen = seen(rig, situation, axis);
            self.memory[axis].take(&seen, rig.passed_periods());
        }
        (0..axes).find_map(|axis| {
            let same = |t: &&Trip| t.axis == Some(axis) || t.shared;
            first_out(axis, &self.view(rig, situation, axis), latched.filter(same).map(|t| t.interlock))
        })
    }

    /// Whether one interlock trips on an axis, be it the first or not: for what must be known of its sensors and torque.
    pub fn sees(&self, rig: &ArmedRig, situation: &Situation, axis: usize, interlock: &Interlock) -> bool {
        !situation.waits_for_inputs && (interlock.check)(&self.view(rig, situation, axis)).is_some()
    }

    /// Deceleration that a stop of an axis can rely on: the rig file's, or less where the motor has shown that it gives
    /// less than it is asked for.
    pub fn deceleration_rad_per_s2(&self, rig: &ArmedRig, axis: usize) -> f64 {
        self.memory[axis].deceleration_rad_per_s2(&rig.axes()[axis].guard)
    }

    fn view<'a>(&'a self, rig: &'a ArmedRig, situation: &Situation, axis: usize) -> View<'a> {
        let (bad_exchanges_in_row, bad_exchanges_in_100) = rig.bad_exchanges();
        View {
            guard: &rig.axes()[axis].guard,
            actuals: rig.actuals(axis),
            memory: &self.memory[axis],
            expects_operation: situation.expects_operation,
            uses_gyro: uses_gyro(rig, situation, axis),
            rig_inputs: rig.actuals(0).digital_inputs,
            emergency_stop_is_open: rig.emergency_stop_is_open(),
            following_error_rad: situation.following_error_rad[axis],
            bounds: situation.bounds,
            target_missing_s: situation.target_missing_s,
            zone: self.zone(rig, axis),
            age_s: f64::from(rig.age_ticks(axis)) * self.period_s,
            bad_exchanges_in_row,
            bad_exchanges_in_100,
            feedback_age_s: f64::from(rig.feedback_silent_ticks(axis)) * self.period_s,
            feedback_disagreement_rad_per_s: rig.feedback_disagreement(axis),
            missed_periods: situation.missed_periods,
            max_missed_periods: situation.max_missed_periods,
            ring_ratio: situation.ring_ratio,
            silent_s: situation.silent_s,
        }
    }
}

impl Watch {
    /// The zone that an axis is about to enter: a zone has an interval of azimuth and one of elevation.
    fn zone(&self, rig: &ArmedRig, axis: usize) -> Option<(f64, f64)> {
        if self.zones.is_empty() {
            return None;
        }
        let gimbal = rig.gimbal()?;
        let approaches = gimbal.both().map(|axis| {
            let actuals = rig.actuals(axis);
            let guard = &rig.axes()[axis].guard;
            let memory = &self.memory[axis];
            let rate = actuals.velocity_rad_per_s;
            let deceleration = memory.deceleration_rad_per_s2(guard);
            let towards = (memory.acceleration_rad_per_s2() * rate.signum()).max(-deceleration);
            Approach {
                angle_rad: actuals.position_rad,
                rate_rad_per_s: rate,
                stop_rad: guard.stop.controlled_from(rate, towards, deceleration).angle_rad,
            }
        });
        entered(&self.zones, gimbal.place_of(axis)?, &approaches)
    }
}

fn uses_gyro(rig: &ArmedRig, situation: &Situation, axis: usize) -> bool {
    situation.uses_feedback && rig.axes()[axis].velocity_feedback == VelocityFeedback::Gyro
}

/// Speed of all axes but one.
fn others_rad_per_s(rig: &ArmedRig, axis: usize) -> f64 {
    let others = (0..rig.axes().len()).filter(|&other| other != axis);
    others.map(|other| rig.actuals(other).velocity_rad_per_s.abs()).sum()
}

fn seen<'a>(rig: &'a ArmedRig, situation: &Situation, axis: usize) -> Seen<'a> {
    let sensor = rig.devices().rate_sensor().filter(|_| uses_gyro(rig, situation, axis));
    let gyro = sensor.and_then(|sensor| {
        let sample = sensor.newest?;
        Some(GyroSeen {
            rate_rad_per_s: rig.feedback(axis).0,
            raw_rad_per_s: sample.rate_rad_per_s,
            sequence: sample.sequence,
            error_rad_per_s: sensor.bias_rad_per_s + sensor.cross_axis_ratio * others_rad_per_s(rig, axis),
        })
    });
    Seen {
        guard: &rig.axes()[axis].guard,
        actuals: rig.actuals(axis),
        fresh: rig.age_ticks(axis) == 0,
        expects_operation: situation.expects_operation,
        gyro,
        sent_nm: situation.sent_nm[axis],
    }
}
