//! Stops of the axes: the worst case that was computed when a stop began, and what the axis really did.
//!
//! The log and the report compare the two.

use std::time::Duration;

use procedures::log::{Event, StopManner, StopRecord};

use crate::model::stopping::StopModel;
use crate::rig::ArmedRig;

/// Below this speed (0.5 °/s) an axis only settles in its position loop: no stop begins, and a stop under way keeps its
/// manner.
const CREEP_RAD_PER_S: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// One stop of one axis. It holds numbers only, so that the tick never allocates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopNumbers {
    axis: usize,
    /// Least controlled manner so far.
    manner: StopManner,
    began: Duration,
    from_rad: f64,
    /// Rate when the stop began; its sign is the direction of motion.
    from_rad_per_s: f64,
    /// Worst-case angle from `from_rad` to standstill, without sign.
    computed_angle_rad: f64,
    /// Worst-case time from `began` to standstill; `None` where only friction is sure to brake.
    computed_s: Option<f64>,
    /// Largest angle from `from_rad` in the direction of motion so far.
    farthest_rad: f64,
    /// Last tick without standstill.
    last_moving: Duration,
    /// Angle at the newest tick.
    to_rad: f64,
    /// Least angle to either end of travel so far; negative beyond the end.
    room_rad: f64,
    /// Whether the axis stood still at the newest tick.
    standstill: bool,
}

impl StopNumbers {
    /// Index of the axis.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// Loop time at which the stop began.
    pub fn began(&self) -> Duration {
        self.began
    }

    /// Least angle to either end of travel during the stop, by the believed position; negative beyond the end.
    pub fn room_rad(&self) -> f64 {
        self.room_rad
    }

    /// Whether the axis stood still at the last tick that was observed.
    pub fn standstill(&self) -> bool {
        self.standstill
    }

    /// The stop as a log event of point number `point`; `axes` holds the names of the axes by index.
    pub fn spelled_out(self, point: usize, axes: &[String]) -> Event {
        Event::Stopped(StopRecord {
            point,
            axis: axes.get(self.axis).cloned().unwrap_or_default(),
            manner: self.manner,
            from_rad: self.from_rad,
            from_rad_per_s: self.from_rad_per_s,
            computed_angle_rad: self.computed_angle_rad,
            computed_s: self.computed_s,
            reached_angle_rad: self.farthest_rad,
            took_s: (self.last_moving - self.began).as_secs_f64(),
            to_rad: self.to_rad,
            room_rad: self.room_rad,
            standstill: self.standstill,
        })
    }
}

/// The stops during one point: at most one per axis.
#[derive(Clone, Debug)]
pub struct Stops {
    axes: Vec<Option<StopNumbers>>,
}

impl Stops {
    /// No stop yet, on any of `axes` axes.
    pub fn new(axes: usize) -> Self {
        Self { axes: vec![None; axes] }
    }

    /// Records at time `now` that every moving axis is being stopped.
    ///
    /// A stop under way takes on `manner` only if that is less controlled. `deceleration` gives the braking deceleration of
    /// an axis by its index, rad/s², positive.
    pub fn begin(
        &mut self,
        manner: StopManner,
        now: Duration,
        rig: &ArmedRig,
        deceleration: impl Fn(usize) -> f64,
    ) {
        for axis in 0..self.axes.len() {
            self.begin_axis(axis, manner, now, rig, deceleration(axis));
        }
    }

    /// Records at time `now` that one axis is being stopped, if it moves; see [`Stops::begin`].
    ///
    /// The deceleration counts only where torque brakes the axis.
    pub fn begin_axis(
        &mut self,
        axis: usize,
        manner: StopManner,
        now: Duration,
        rig: &ArmedRig,
        deceleration_rad_per_s2: f64,
    ) {
        let believed = rig.believed(axis);
        let position_rad = believed.position_rad;
        let rate_rad_per_s = believed.rate_rad_per_s;
        let model = &rig.axes()[axis].guard.stop;
        let worst_case = || computed(model, manner, position_rad, rate_rad_per_s, deceleration_rad_per_s2);
        match &mut self.axes[axis] {
            // An axis that is almost at standstill is only being held: nothing new is computed for it.
            Some(stop) if rank(manner) > rank(stop.manner) && believed.speed_rad_per_s > CREEP_RAD_PER_S => {
                // The new worst case begins here: the angle and time that the stop has taken so far are added to it.
                let (angle_rad, time_s) = worst_case();
                let elapsed_s = (now - stop.began).as_secs_f64();
                stop.manner = manner;
                stop.computed_angle_rad = stop.farthest_rad + angle_rad;
                stop.computed_s = time_s.map(|s| elapsed_s + s);
            }
            Some(_) => {}
            None if rate_rad_per_s.abs() < CREEP_RAD_PER_S => {}
            stop @ None => {
                let (computed_angle_rad, computed_s) = worst_case();
                *stop = Some(StopNumbers {
                    axis,
                    manner,
                    began: now,
                    from_rad: position_rad,
                    from_rad_per_s: rate_rad_per_s,
                    computed_angle_rad,
                    computed_s,
                    farthest_rad: 0.0,
                    last_moving: now,
                    to_rad: position_rad,
                    room_rad: f64::INFINITY,
                    standstill: false,
                });
            }
        }
    }

    /// Updates every stop with the newest samples; called once per tick, after the fieldbus exchange.
    pub fn observe(&mut self, now: Duration, rig: &ArmedRig) {
        for stop in self.axes.iter_mut().flatten() {
            let believed = rig.believed(stop.axis);
            let position_rad = believed.position_rad;
            // Positive in the direction in which the axis moved when the stop began.
            let travelled_rad = (position_rad - stop.from_rad) * stop.from_rad_per_s.signum();
            stop.farthest_rad = stop.farthest_rad.max(travelled_rad);
            let [low_rad, high_rad] = rig.axes()[stop.axis].guard.stop.travel_rad;
            stop.room_rad = stop.room_rad.min(high_rad - position_rad).min(position_rad - low_rad);
            stop.to_rad = position_rad;
            stop.standstill = believed.stands();
            if !stop.standstill {
                stop.last_moving = now;
            }
        }
    }

    /// All stops so far, in the order of the axes.
    pub fn all(&self) -> impl Iterator<Item = StopNumbers> + '_ {
        self.axes.iter().flatten().copied()
    }
}

/// Order of the manners: the less controlled a stop, the higher its rank.
fn rank(manner: StopManner) -> u8 {
    match manner {
        StopManner::Controlled => 0,
        StopManner::QuickStop => 1,
        StopManner::LinkLimited => 2,
        StopManner::TorqueOff => 3,
    }
}

/// Worst case of a stop from here on: angle, rad, without sign, and time, s.
///
/// A stop that may get no braking torque has no useful bound on its time: friction alone brakes it.
fn computed(
    model: &StopModel,
    manner: StopManner,
    position_rad: f64,
    rate_rad_per_s: f64,
    deceleration_rad_per_s2: f64,
) -> (f64, Option<f64>) {
    match manner {
        StopManner::TorqueOff | StopManner::LinkLimited => {
            let coast = model.coast(position_rad, rate_rad_per_s);
            ((coast.end_rad - position_rad).abs(), None)
        }
        StopManner::Controlled | StopManner::QuickStop => {
            let stop = model.controlled_from(rate_rad_per_s, 0.0, deceleration_rad_per_s2);
            (stop.angle_rad, Some(stop.time_s))
        }
    }
}
