//! Pre-flight: what a plan asks of the axes, and what becomes of them when it is interrupted at its worst instant.
//!
//! Everything follows from the planned points and the rig file, before anything is switched on: where the axis is, how
//! fast, with which torque; how far a controlled stop carries it from any instant; how far it coasts without torque, and
//! with which energy it meets its end stop; where it swings that is let go. `plan` prints it, `check` and `run` refuse
//! what does not fit, and the report sets it beside what a run reached.

use procedures::case::Case;
use procedures::diagnostic::Diagnostic;

use crate::files::rig::{Rig, RigAxis};
use crate::plan::PlannedProcedure;
use crate::stopping::{Coast, Swing};

mod course;
mod refuse;
mod residual;
mod thermal;
mod torque_mode;
mod tracks;
mod worst;

#[cfg(test)]
mod tests;

pub use residual::{NOT_ENFORCED, NotEnforced, risks};
use worst::Finder;

/// A controlled stop from the worst instant of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedStop {
    /// Where the axis is when it begins.
    pub from_rad: f64,
    /// Its rate then.
    pub rate_rad_per_s: f64,
    /// Angle that it takes at the most.
    pub angle_rad: f64,
    /// Time that it takes at the most; `None` where torque is taken away and friction stops the axis.
    pub time_s: Option<f64>,
    /// Where it ends.
    pub reach_rad: f64,
    /// Angle from there to the nearer soft limit, negative beyond it.
    pub room_rad: f64,
}

/// Coasting without torque from the worst instant of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedCoast {
    /// Where the axis loses its torque.
    pub from_rad: f64,
    /// Its rate then.
    pub rate_rad_per_s: f64,
    /// Where that ends.
    pub coast: Coast,
}

/// An axis that swings when it is let go at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedSwing {
    /// Axis.
    pub axis: String,
    /// Where it rests under torque.
    pub from_rad: f64,
    /// Where it goes without.
    pub swing: Swing,
}

/// What bounds a segment that has no planned position.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundedSegment {
    /// Label of the segment.
    pub segment: String,
    /// Largest speed that it can reach.
    pub rate_rad_per_s: f64,
    /// What bounds it, in words.
    pub by: &'static str,
}

/// What a point asks, and the worst ways out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct PointEnvelope {
    /// Name of the point.
    pub point: String,
    /// Longest duration.
    pub duration_s: f64,
    /// Lowest and highest place.
    pub position_rad: [f64; 2],
    /// Largest speed.
    pub rate_rad_per_s: f64,
    /// Largest acceleration.
    pub acceleration_rad_per_s2: f64,
    /// Largest torque: inertia, expected friction and loads, or as commanded.
    pub torque_nm: f64,
    /// The stop that takes the largest angle and the longest time.
    pub longest_stop: Option<PlannedStop>,
    /// The stop that ends nearest to a soft limit, or farthest beyond it.
    pub nearest_stop: Option<PlannedStop>,
    /// The coast that ends worst.
    pub coast: Option<PlannedCoast>,
    /// Segments without a planned position.
    pub bounded: Vec<BoundedSegment>,
    /// Whether no loop is closed in it: a stop takes the torque away.
    pub open_loop: bool,
}

impl PointEnvelope {
    /// Of a point that asks for nothing yet.
    pub fn empty() -> Self {
        Self {
            point: String::new(),
            duration_s: 0.0,
            position_rad: [f64::INFINITY, f64::NEG_INFINITY],
            rate_rad_per_s: 0.0,
            acceleration_rad_per_s2: 0.0,
            torque_nm: 0.0,
            longest_stop: None,
            nearest_stop: None,
            coast: None,
            bounded: Vec::new(),
            open_loop: false,
        }
    }
}

/// What a procedure asks, and the worst ways out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcedureEnvelope {
    /// Its id.
    pub procedure: String,
    /// Axis that it moves.
    pub axis: String,
    /// Its points in order.
    pub points: Vec<PointEnvelope>,
    /// Largest root mean square of the torque, with the axis' thermal time as time constant.
    pub rms_torque_nm: f64,
    /// The point that reaches it.
    pub rms_point: String,
    /// Per axis, the swing that goes farthest when torque is lost at a planned place of rest.
    pub swings: Vec<PlannedSwing>,
}

impl ProcedureEnvelope {
    /// The longest stop of all points.
    pub fn longest_stop(&self) -> Option<PlannedStop> {
        self.points.iter().filter_map(|p| p.longest_stop).reduce(worst::longer)
    }

    /// The stop that ends nearest to a soft limit.
    pub fn nearest_stop(&self) -> Option<PlannedStop> {
        self.points.iter().filter_map(|p| p.nearest_stop).reduce(worst::nearer)
    }

    /// The coast of all points that ends worst.
    pub fn coast(&self, axis: &RigAxis) -> Option<PlannedCoast> {
        self.points.iter().filter_map(|p| p.coast).reduce(|a, b| worst::worse_coast(&axis.guard.stop, a, b))
    }
}

/// The envelope of a procedure's points on this rig; `None` where the rig lacks the axis.
pub fn envelope(procedure: &str, axis: &str, cases: &[Case], rig: &Rig) -> Option<ProcedureEnvelope> {
    let moved = rig.axes.iter().find(|a| a.name == axis)?;
    let mut load = thermal::Load::new(moved);
    let mut rests = worst::Rests::default();
    let points = cases.iter().map(|case| point(case, moved, &mut load, &mut rests)).collect();
    let (rms_torque_nm, index) = load.worst_rms();
    Some(ProcedureEnvelope {
        procedure: procedure.to_owned(),
        axis: axis.to_owned(),
        points,
        rms_torque_nm,
        rms_point: cases.get(index).map_or(String::new(), |c| c.point.clone()),
        swings: rests.swings(rig),
    })
}

fn point(
    case: &Case,
    axis: &RigAxis,
    load: &mut thermal::Load<'_>,
    rests: &mut worst::Rests,
) -> PointEnvelope {
    rests.start(case);
    load.next_point();
    let mut finder = Finder::new(axis, case.open_loop);
    for stretch in course::stretches(case, axis) {
        load.take(&stretch);
        let rests_too = if tracks::is_beside(case, axis) { &axis.name } else { &case.axis };
        rests.take(rests_too, &stretch);
        finder.take(&stretch);
    }
    let mut envelope = finder.envelope(&case.point);
    envelope.duration_s = case.planned_s();
    envelope.torque_nm = load.peak_of_point();
    envelope
}

/// Envelopes of all procedures of a plan, in order.
pub fn envelopes(procedures: &[PlannedProcedure], rig: &Rig) -> Vec<ProcedureEnvelope> {
    procedures.iter().flat_map(|p| of_procedure(p, rig)).collect()
}

/// Of its own axis, then of every other one that follows a target in it.
fn of_procedure(planned: &PlannedProcedure, rig: &Rig) -> Vec<ProcedureEnvelope> {
    let (id, own) = (&planned.procedure.id, &planned.procedure.axis);
    let follows =
        |axis: &&RigAxis| axis.name != *own && planned.cases.iter().any(|c| c.is_tracked(&axis.name));
    let others = rig.axes.iter().filter(follows).map(|axis| (format!("{id} ({})", axis.name), &axis.name));
    let all = std::iter::once((id.clone(), own)).chain(others);
    all.filter_map(|(name, axis)| envelope(&name, axis, &planned.cases, rig)).collect()
}

/// Everything in a plan that the rig does not allow, with procedure, point, number, limit and what to do.
pub fn refusals(procedures: &[PlannedProcedure], rig: &Rig) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    for planned in procedures {
        for found in of_procedure(planned, rig) {
            let refused = refuse::refusals(&found, &planned.cases, rig);
            all.extend(refused.into_iter().map(|d| d.in_file(&planned.procedure.source)));
        }
    }
    all
}
