//! The worst instant of a plan: for a controlled stop, for the loss of torque in motion, for the loss of torque at rest.

use std::collections::BTreeMap;

use procedures::case::Case;

use super::course::{Instant, Stretch};
use super::torque_mode::Bounded;
use super::{BoundedSegment, PlannedCoast, PlannedStop, PlannedSwing, PointEnvelope};
use crate::model::axis::RigAxis;
use crate::model::rig::Rig;
use crate::model::stopping::{REST_RAD_PER_S, StopModel};

/// The stop that takes the larger angle.
pub(super) fn longer(a: PlannedStop, b: PlannedStop) -> PlannedStop {
    if b.angle_rad > a.angle_rad { b } else { a }
}

/// The stop that ends nearer to a soft limit.
pub(super) fn nearer(a: PlannedStop, b: PlannedStop) -> PlannedStop {
    if b.room_rad < a.room_rad { b } else { a }
}

/// The coast that ends worse: with more energy at an end stop, or nearer to one.
pub(super) fn worse_coast(stop: &StopModel, a: PlannedCoast, b: PlannedCoast) -> PlannedCoast {
    let energy = |c: &PlannedCoast| c.coast.impact.map_or(-1.0, |i| i.energy_j);
    let room = |c: &PlannedCoast| {
        let [low, high] = stop.travel_rad;
        (c.coast.end_rad - low).min(high - c.coast.end_rad)
    };
    let worse = energy(&b).total_cmp(&energy(&a)).then(room(&a).total_cmp(&room(&b)));
    if worse.is_gt() { b } else { a }
}

/// Collects the worst of one point.
pub(super) struct Finder<'a> {
    axis: &'a RigAxis,
    found: PointEnvelope,
}

impl<'a> Finder<'a> {
    pub(super) fn new(axis: &'a RigAxis, open_loop: bool) -> Self {
        let found = PointEnvelope { open_loop, ..PointEnvelope::empty() };
        Self { axis, found }
    }

    pub(super) fn envelope(self, point: &str) -> PointEnvelope {
        PointEnvelope { point: point.to_owned(), ..self.found }
    }

    pub(super) fn take(&mut self, stretch: &Stretch<'_>) {
        match stretch {
            Stretch::Stroke { instants, .. } => {
                for i in instants {
                    self.at(i);
                }
                for i in peaks(&self.axis.guard.stop, instants) {
                    self.lose_torque(i.position_rad, i.rate_rad_per_s);
                }
            }
            Stretch::Torque { segment, bounded } => {
                self.bounded(bounded);
                self.found.bounded.push(BoundedSegment {
                    segment: segment.label.clone(),
                    rate_rad_per_s: bounded.rate_rad_per_s,
                    by: bounded.by,
                });
            }
        }
    }

    fn at(&mut self, i: &Instant) {
        let found = &mut self.found;
        found.position_rad[0] = found.position_rad[0].min(i.position_rad);
        found.position_rad[1] = found.position_rad[1].max(i.position_rad);
        found.rate_rad_per_s = found.rate_rad_per_s.max(i.rate_rad_per_s.abs());
        found.acceleration_rad_per_s2 = found.acceleration_rad_per_s2.max(i.acceleration_rad_per_s2.abs());
        // As the braking curve does: what is as slow stops where it is.
        if i.rate_rad_per_s.abs() > REST_RAD_PER_S
            || self.is_inside(i.position_rad) && i.rate_rad_per_s != 0.0
        {
            self.stop(i.position_rad, i.rate_rad_per_s, i.acceleration_rad_per_s2, None);
        }
    }

    /// Whether an angle is farther from the soft limits than a crawl ever comes to them.
    fn is_inside(&self, angle_rad: f64) -> bool {
        const CRAWL_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;
        let [low, high] = self.axis.guard.stop.soft_limits_rad;
        (low + CRAWL_RAD..=high - CRAWL_RAD).contains(&angle_rad)
    }

    fn bounded(&mut self, b: &Bounded) {
        let [low_rad, high_rad] = b.place_rad;
        let found = &mut self.found;
        found.position_rad[0] = found.position_rad[0].min(low_rad);
        found.position_rad[1] = found.position_rad[1].max(high_rad);
        found.rate_rad_per_s = found.rate_rad_per_s.max(b.rate_rad_per_s);
        found.acceleration_rad_per_s2 = found.acceleration_rad_per_s2.max(b.acceleration_rad_per_s2);
        if b.rate_rad_per_s == 0.0 {
            return;
        }
        for (at_rad, rate) in [(high_rad, b.rate_rad_per_s), (low_rad, -b.rate_rad_per_s)] {
            // What speeds it up goes on to do so until the stop answers.
            let acceleration = b.acceleration_rad_per_s2 * rate.signum();
            self.stop(at_rad, rate, acceleration, b.by_interlock.then_some(0.0));
            self.lose_torque(at_rad, rate);
        }
    }

    /// A stop that begins here, at this rate and acceleration; `room_rad` where an interlock sees to it.
    fn stop(&mut self, from_rad: f64, rate_rad_per_s: f64, acceleration: f64, room_rad: Option<f64>) {
        let model = &self.axis.guard.stop;
        let (angle_rad, time_s) = if self.found.open_loop {
            (model.coast(from_rad, rate_rad_per_s).end_rad - from_rad, None)
        } else {
            let towards = (acceleration * rate_rad_per_s.signum()).max(-model.deceleration_rad_per_s2);
            let stop = model.controlled_from(rate_rad_per_s, towards, model.deceleration_rad_per_s2);
            (stop.angle_rad * rate_rad_per_s.signum(), Some(stop.time_s))
        };
        let reach_rad = from_rad + angle_rad;
        let [low, high] = model.soft_limits_rad;
        let room_rad = room_rad.unwrap_or((reach_rad - low).min(high - reach_rad));
        let angle_rad = angle_rad.abs();
        let stop = PlannedStop { from_rad, rate_rad_per_s, angle_rad, time_s, reach_rad, room_rad };
        let found = &mut self.found;
        found.longest_stop = Some(found.longest_stop.map_or(stop, |other| longer(other, stop)));
        found.nearest_stop = Some(found.nearest_stop.map_or(stop, |other| nearer(other, stop)));
    }

    fn lose_torque(&mut self, from_rad: f64, rate_rad_per_s: f64) {
        let model = &self.axis.guard.stop;
        let here = PlannedCoast { from_rad, rate_rad_per_s, coast: model.coast(from_rad, rate_rad_per_s) };
        let found = &mut self.found;
        found.coast = Some(found.coast.map_or(here, |other| worse_coast(model, other, here)));
    }
}

/// The instants of a stroke whose coasts may end worst.
///
/// Coasts never cross: energy over angle follows a differential equation of first order. An instant whose neighbour
/// lies on a faster coast than its own is left out; what remains are the few at which the plan begins to brake harder
/// than friction does.
fn peaks<'a>(stop: &'a StopModel, instants: &'a [Instant]) -> impl Iterator<Item = &'a Instant> {
    // Whether the plan loses more energy from `a` to `b` than a coast from `a` would: then `a` is on the faster one.
    let brakes = |a: &Instant, b: &Instant| {
        let half = |i: &Instant| 0.5 * stop.inertia_kg_m2 * i.rate_rad_per_s * i.rate_rad_per_s;
        let ahead = if a.rate_rad_per_s + b.rate_rad_per_s < 0.0 { -1.0 } else { 1.0 };
        let middle_rad = 0.5 * (a.position_rad + b.position_rad);
        let friction = &stop.friction;
        let speed = 0.5 * (a.rate_rad_per_s + b.rate_rad_per_s).abs();
        let losses_nm = friction.coulomb_nm + stop.brake_nm + friction.viscous_nm_s_per_rad * speed;
        let pull_nm = losses_nm - stop.loads.driving(ahead, middle_rad);
        half(a) - half(b) >= pull_nm * (b.position_rad - a.position_rad).abs()
    };
    instants.iter().enumerate().filter_map(move |(k, here)| {
        let before = k.checked_sub(1).and_then(|k| instants.get(k));
        let slower_than_before = before.is_some_and(|before| brakes(before, here));
        let slower_than_after = instants.get(k + 1).is_some_and(|after| !brakes(here, after));
        let moves = here.rate_rad_per_s != 0.0;
        (moves && !slower_than_before && !slower_than_after).then_some(here)
    })
}

/// Places at which axes rest under torque.
#[derive(Debug, Default)]
pub(super) struct Rests {
    places_rad: BTreeMap<String, Vec<f64>>,
}

impl Rests {
    /// Where all axes stand when a point begins.
    pub(super) fn start(&mut self, case: &Case) {
        for (axis, &at_rad) in &case.start_pose_rad {
            self.add(axis, at_rad);
        }
    }

    /// Where strokes begin and end.
    pub(super) fn take(&mut self, axis: &str, stretch: &Stretch<'_>) {
        if let Stretch::Stroke { instants, .. } = stretch {
            for end in instants.first().into_iter().chain(instants.last()) {
                self.add(axis, end.position_rad);
            }
        }
    }

    fn add(&mut self, axis: &str, at_rad: f64) {
        match self.places_rad.get_mut(axis) {
            Some(places) if places.contains(&at_rad) => {}
            Some(places) => places.push(at_rad),
            None => drop(self.places_rad.insert(axis.to_owned(), vec![at_rad])),
        }
    }

    /// Per axis of the rig, the swing that goes farthest.
    pub(super) fn swings(&self, rig: &Rig) -> Vec<PlannedSwing> {
        let farthest = |axis: &RigAxis| {
            let way = |s: &PlannedSwing| (s.swing.to_rad - s.from_rad).abs();
            let places = self.places_rad.get(&axis.name)?;
            places
                .iter()
                .filter_map(|&from_rad| {
                    let swing = axis.guard.stop.swing(from_rad)?;
                    Some(PlannedSwing { axis: axis.name.clone(), from_rad, swing })
                })
                .max_by(|a, b| way(a).total_cmp(&way(b)))
        };
        rig.axes.iter().filter_map(farthest).collect()
    }
}
