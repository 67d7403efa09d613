//! Stops as they happen: what was computed when each began, what the axis did, for log and report.

use std::time::Duration;

use procedures::log::{Event, StopManner, StopRecord};

use crate::model::stopping::StopModel;
use crate::rig::ArmedRig;

/// What is left of a stop while the position loop settles.
const CREEP_RAD_PER_S: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// A stop as numbers, so that the tick never allocates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopNumbers {
    axis: usize,
    manner: StopManner,
    began: Duration,
    from_rad: f64,
    from_rad_per_s: f64,
    computed_angle_rad: f64,
    computed_s: Option<f64>,
    farthest_rad: f64,
    last_moving: Duration,
    to_rad: f64,
    room_rad: f64,
    standstill: bool,
}

impl StopNumbers {
    /// Index of the axis.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// When it began.
    pub fn began(&self) -> Duration {
        self.began
    }

    /// Angle to the end of travel from the place that was reached, by the encoder; below 0 beyond it.
    pub fn room_rad(&self) -> f64 {
        self.room_rad
    }

    /// Whether it stood still in the end.
    pub fn standstill(&self) -> bool {
        self.standstill
    }

    /// The event for the log.
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

/// The stops of a point, one an axis at the most.
#[derive(Clone, Debug)]
pub struct Stops {
    axes: Vec<Option<StopNumbers>>,
}

impl Stops {
    /// None yet.
    pub fn new(axes: usize) -> Self {
        Self { axes: vec![None; axes] }
    }

    /// Every axis that moves is being stopped from now on, in this manner or a less controlled one, with its deceleration.
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

    /// One axis that moves is being stopped from now on, with this deceleration where it is braked.
    pub fn begin_axis(
        &mut self,
        axis: usize,
        manner: StopManner,
        now: Duration,
        rig: &ArmedRig,
        deceleration_rad_per_s2: f64,
    ) {
        let believed = rig.believed(axis);
        let at = believed.position_rad;
        let rate = believed.rate_rad_per_s;
        let model = &rig.axes()[axis].guard.stop;
        match &mut self.axes[axis] {
            // One that all but stands is only being held.
            Some(stop) if rank(manner) > rank(stop.manner) && believed.speed_rad_per_s > CREEP_RAD_PER_S => {
                // What was computed holds from here on, beyond what was needed so far.
                let so_far = stop.farthest_rad;
                let (angle, time_s) = computed(model, manner, at, rate, deceleration_rad_per_s2);
                let passed_s = (now - stop.began).as_secs_f64();
                stop.manner = manner;
                stop.computed_angle_rad = so_far + angle;
                stop.computed_s = time_s.map(|s| passed_s + s);
            }
            Some(_) => {}
            None if rate.abs() < CREEP_RAD_PER_S => {}
            free @ None => {
                let (computed_angle_rad, computed_s) =
                    computed(model, manner, at, rate, deceleration_rad_per_s2);
                *free = Some(StopNumbers {
                    axis,
                    manner,
                    began: now,
                    from_rad: at,
                    from_rad_per_s: rate,
                    computed_angle_rad,
                    computed_s,
                    farthest_rad: 0.0,
                    last_moving: now,
                    to_rad: at,
                    room_rad: f64::INFINITY,
                    standstill: false,
                });
            }
        }
    }

    /// Once a tick, after the exchange.
    pub fn observe(&mut self, now: Duration, rig: &ArmedRig) {
        for stop in self.axes.iter_mut().flatten() {
            let believed = rig.believed(stop.axis);
            let at = believed.position_rad;
            let way = (at - stop.from_rad) * stop.from_rad_per_s.signum();
            stop.farthest_rad = stop.farthest_rad.max(way);
            let [low, high] = rig.axes()[stop.axis].guard.stop.travel_rad;
            stop.room_rad = stop.room_rad.min(high - at).min(at - low);
            stop.to_rad = at;
            stop.standstill = believed.stands();
            if !stop.standstill {
                stop.last_moving = now;
            }
        }
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = StopNumbers> + '_ {
        self.axes.iter().flatten().copied()
    }
}

/// The less controlled, the higher.
fn rank(manner: StopManner) -> u8 {
    match manner {
        StopManner::Controlled => 0,
        StopManner::QuickStop => 1,
        StopManner::LinkLimited => 2,
        StopManner::TorqueOff => 3,
    }
}

/// Angle and time at the worst; without torque there is no bound on the time worth a name.
fn computed(
    model: &StopModel,
    manner: StopManner,
    at: f64,
    rate: f64,
    deceleration: f64,
) -> (f64, Option<f64>) {
    match manner {
        StopManner::TorqueOff | StopManner::LinkLimited => ((model.coast(at, rate).end_rad - at).abs(), None),
        StopManner::Controlled | StopManner::QuickStop => {
            let stop = model.controlled_from(rate, 0.0, deceleration);
            (stop.angle_rad, Some(stop.time_s))
        }
    }
}
