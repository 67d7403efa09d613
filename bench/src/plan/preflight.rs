//! Pre-flight: what a plan asks of the axes, and what becomes of them when it is interrupted at its worst instant.
//!
//! Everything follows from the planned points and the rig file, before anything is switched on: where the axis is, how
//! fast, with which torque; how far a controlled stop carries it from any instant; how far it coasts without torque, and
//! with which energy it meets its end stop; where it swings that is let go. `plan` prints it, `check` and `run` refuse
//! what does not fit, and the report sets it beside what a run reached.

use std::fmt;

use procedures::case::{Case, Then};
use procedures::diagnostic::Diagnostic;
use procedures::quantity::QuantityKind as Q;
use reports::record::ComputedWorst;

use crate::model::axis::RigAxis;
use crate::model::rig::Rig;
use crate::model::stopping::{Coast, Swing};
use crate::plan::PlannedProcedure;

mod course;
mod refuse;
mod residual;
mod thermal;
mod torque_mode;
mod worst;

#[cfg(test)]
mod tests;

pub(crate) use residual::risks;
use worst::Finder;

/// A controlled stop from the worst instant of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlannedStop {
    /// Where the axis is when it begins.
    pub from_rad: f64,
    /// Rate of the axis when the stop begins, rad/s.
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
pub(crate) struct PlannedCoast {
    /// Where the axis loses its torque.
    pub from_rad: f64,
    /// Rate of the axis when it loses its torque, rad/s.
    pub rate_rad_per_s: f64,
    /// Where that ends.
    pub coast: Coast,
}

impl fmt::Display for PlannedCoast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rate = Q::AngularVelocity.format(self.rate_rad_per_s.abs());
        write!(f, "{rate} at {}", Q::Angle.format(self.from_rad))
    }
}

/// An axis that swings when it is let go at rest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlannedSwing {
    /// Axis.
    pub axis: String,
    /// Where it rests under torque.
    pub from_rad: f64,
    /// Where it goes without.
    pub swing: Swing,
}

/// What bounds a segment that has no planned position.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BoundedSegment {
    /// Label of the segment.
    pub segment: String,
    /// Largest speed that it can reach.
    pub rate_rad_per_s: f64,
    /// What bounds it, in words.
    pub by: &'static str,
}

/// What a point asks, and the worst ways out of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PointEnvelope {
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
    /// Coasting as it is ordered, where the point ends with its torque taken away.
    pub torque_off: Option<PlannedCoast>,
    /// Whether no loop is closed in it: a stop takes the torque away.
    pub open_loop: bool,
}

impl PointEnvelope {
    /// Of a point that asks for nothing yet.
    pub(crate) fn empty() -> Self {
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
            torque_off: None,
            open_loop: false,
        }
    }
}

/// What a procedure asks, and the worst ways out of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProcedureEnvelope {
    /// Id of the procedure.
    pub procedure: String,
    /// Axis that it moves.
    pub axis: String,
    /// Points of the procedure in order.
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
    pub(crate) fn longest_stop(&self) -> Option<PlannedStop> {
        self.points.iter().filter_map(|p| p.longest_stop).reduce(worst::longer)
    }

    /// The stop that ends nearest to a soft limit.
    pub(crate) fn nearest_stop(&self) -> Option<PlannedStop> {
        self.points.iter().filter_map(|p| p.nearest_stop).reduce(worst::nearer)
    }

    /// The coast of all points that ends worst.
    pub(crate) fn coast(&self, axis: &RigAxis) -> Option<PlannedCoast> {
        self.points.iter().filter_map(|p| p.coast).reduce(|a, b| worst::worse_coast(&axis.guard.stop, a, b))
    }
}

/// The envelopes of a procedure's points on this rig, one for each axis that moves in any of them, its own first.
pub(crate) fn envelopes_of(procedure: &str, axis: &str, cases: &[Case], rig: &Rig) -> Vec<ProcedureEnvelope> {
    let mut axes = vec![axis];
    let follows = |name: &&str| cases.iter().any(|case| case.is_tracked(name));
    let following = rig.axes.iter().map(|a| a.name.as_str()).filter(follows);
    for moved in cases.iter().flat_map(Case::moved_axes).chain(following) {
        if !axes.contains(&moved) {
            axes.push(moved);
        }
    }
    let named = |moved: &str| {
        if moved == axis { procedure.to_owned() } else { format!("{procedure} (with {moved})") }
    };
    axes.into_iter().filter_map(|moved| envelope(&named(moved), moved, cases, rig)).collect()
}

/// The envelope of a procedure's points on this rig as one axis lives them; `None` where the rig lacks the axis.
pub(crate) fn envelope(procedure: &str, axis: &str, cases: &[Case], rig: &Rig) -> Option<ProcedureEnvelope> {
    let moved = rig.axes.iter().find(|a| a.name == axis)?;
    let mut load = thermal::Load::new(moved);
    let mut rests = worst::Rests::default();
    let points =
        cases.iter().map(|case| point(&case.seen_from(axis), moved, &mut load, &mut rests)).collect();
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
    let mut fenced = axis.clone();
    fenced.guard.stop.soft_limits_rad = case.soft_limits_rad(&axis.name, axis.guard.stop.soft_limits_rad);
    let mut finder = Finder::new(&fenced, case.open_loop);
    let mut last = None;
    for stretch in course::stretches(case, &fenced) {
        last = stretch.end().or(last);
        load.take(&stretch);
        rests.take(&case.axis, &stretch);
        finder.take(&stretch);
    }
    let mut envelope = finder.envelope(&case.point);
    envelope.duration_s = case.planned_s();
    envelope.torque_nm = load.peak_of_point();
    if case.segments.last().is_some_and(|segment| segment.then == Then::TorqueOff) {
        envelope.torque_off = last.map(|(from_rad, rate_rad_per_s)| {
            let coast = axis.guard.stop.coast(from_rad, rate_rad_per_s);
            PlannedCoast { from_rad, rate_rad_per_s, coast }
        });
    }
    envelope
}

/// Envelopes of all procedures of a plan, in order.
pub(crate) fn envelopes(procedures: &[PlannedProcedure], rig: &Rig) -> Vec<ProcedureEnvelope> {
    let each = |p: &PlannedProcedure| envelopes_of(&p.procedure.id, &p.procedure.axis, &p.cases, p.on(rig));
    procedures.iter().flat_map(each).collect()
}

/// Everything in a plan that the rig does not allow, with procedure, point, number, limit and what to do.
pub(crate) fn refusals(procedures: &[PlannedProcedure], rig: &Rig) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    for planned in procedures {
        let procedure = &planned.procedure;
        let rig = planned.on(rig);
        for found in envelopes_of(&procedure.id, &procedure.axis, &planned.cases, rig) {
            let refused = refuse::refusals(&found, &planned.cases, rig);
            all.extend(refused.into_iter().map(|d| d.in_file(&procedure.source)));
        }
    }
    all
}

/// The worst cases of the points of a procedure, as they go into its log; `None` where it moves nothing on its axis. What
/// judges the log later must not compute them again, with other mathematics perhaps than the run relied on.
pub(crate) fn computed_worst(
    procedure: &str,
    axis: &str,
    cases: &[Case],
    rig: &Rig,
) -> Option<ComputedWorst> {
    let all = envelopes_of(procedure, axis, cases, rig);
    let found = all.first().filter(|found| found.axis == axis)?;
    let of_axis = rig.axes.iter().find(|a| a.name == axis)?;
    let longest = found.longest_stop()?;
    let nearest = found.nearest_stop()?;
    let coast = found.coast(of_axis).map(|c| c.coast);
    let impact = coast.and_then(|c| c.impact);
    Some(ComputedWorst {
        stop_angle_rad: longest.angle_rad,
        stop_s: longest.time_s,
        room_rad: nearest.room_rad,
        coast_to_rad: coast.map(|c| c.end_rad),
        impact_energy_j: impact.map(|i| i.energy_j),
        impact_rad_per_s: impact.map(|i| i.speed_rad_per_s),
        risks: risks(&all, rig),
    })
}
