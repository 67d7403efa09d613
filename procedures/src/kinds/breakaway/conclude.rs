//! Over all points: load map, contact, breakaway torques, dwell law, multisine, hold.

use analysis::estimate::Estimate;
use analysis::load_map::LoadMap;
use analysis::uncertainty::Component;

use super::course::{self, Course};
use super::keys::Keys;
use super::plan::{MULTISINE, RELEASE, STROKE};
use super::record::Numbers;
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::measurement::{Conclusion, Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

mod contact;
mod dwell;
mod hold;
mod multisine;
mod plots;
mod ramps;

/// Slowest rate at which the dwell law is judged, A/s: a slower ramp ages the contact while it lasts.
const DWELL_LAW_RATE: f64 = 1.0;
/// Fewest dwell times for a law.
const FEWEST_DWELLS: usize = 3;

/// Whether the ramps ask for a dwell law: three dwells, with repeats, at one rate of 1 A/s or more.
pub(super) fn asks_for_dwell_law(keys: &Keys) -> bool {
    keys.ramps.iter().any(|r| {
        let mut dwells: Vec<u64> = r.dwells_s.iter().map(|d| d.to_bits()).collect();
        dwells.sort_unstable();
        dwells.dedup();
        let fast = r.rates_a_per_s.iter().any(|&rate| rate >= DWELL_LAW_RATE);
        dwells.len() >= FEWEST_DWELLS && r.repeats >= 2 && fast
    })
}

/// What concluding rests on.
struct Findings<'a> {
    keys: &'a Keys,
    axis: &'a str,
    limits: &'a AxisLimits,
    cases: &'a [Case],
    points: &'a [PointResult],
    map: Result<LoadMap, String>,
}

/// Measurements, pictures and remarks over all points.
pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut conclusion = Conclusion::default();
    let Some(axis) = cases.first().map(|c| c.axis.as_str()) else { return conclusion };
    let Some(limits) = axes.get(axis) else {
        conclusion.remarks.push(format!("the log's rig has no axis `{axis}`: nothing was concluded"));
        return conclusion;
    };
    let findings = Findings { keys, axis, limits, cases, points, map: load_map(cases, points, limits) };
    findings.remark_on_map(&mut conclusion);
    let ramps = ramps::courses(&findings);
    let contact = contact::Contact::of(&ramps);
    contact::conclude(&findings, &ramps, contact.as_ref(), &mut conclusion);
    let broken = ramps::conclude(&findings, &ramps, contact.as_ref(), &mut conclusion);
    dwell::conclude(&findings, &broken, &mut conclusion);
    multisine::conclude(&findings, &mut conclusion);
    hold::conclude(&findings, &mut conclusion);
    for point in points {
        conclusion.measurements.extend(point.measurements.iter().cloned());
        conclusion.plots.extend(point.plots.iter().cloned());
    }
    conclusion
}

fn load_map(cases: &[Case], points: &[PointResult], limits: &AxisLimits) -> Result<LoadMap, String> {
    let place =
        cases.iter().position(|c| has(c, STROKE)).ok_or("map missing: the procedure has no stroke")?;
    let point = points.get(place).ok_or("map missing: the stroke was not run")?;
    if let Some(reason) = &point.inconclusive {
        return Err(format!("map missing: {reason}"));
    }
    let column = |part: &str| course::values(&point.numbers, &format!("stroke.{part}"));
    LoadMap::new(column("position"), column("velocity"), column("effort"), limits.cogging_orders_per_rev)
        .ok_or_else(|| {
            "map missing: the stroke does not cover a cogging period in both directions".to_owned()
        })
}

/// Whether a case has a segment of this label.
fn has(case: &Case, label: &str) -> bool {
    case.segments.iter().any(|s| s.label == label)
}

impl<'a> Findings<'a> {
    /// The points whose case has a segment of this label, with their results.
    fn having(&self, label: &str) -> impl Iterator<Item = (&'a Case, &'a PointResult)> {
        self.cases.iter().zip(self.points).filter(move |(c, _)| has(c, label))
    }

    fn remark_on_map(&self, conclusion: &mut Conclusion) {
        match &self.map {
            Ok(map) => conclusion.remarks.push(format!(
                "Load near the pose, from the slow stroke: cogging {:.2} N·m; the map misses the half sum by {:.3} N·m rms.",
                map.cogging_amplitude_nm(),
                map.misfit_nm
            )),
            Err(reason) if self.keys.map.is_some() => conclusion.remarks.push(reason.clone()),
            Err(_) => {}
        }
    }

    /// Torque constant's share of the uncertainty of a torque.
    fn torque_constant(&self, torque: f64) -> Component {
        Component::known(torque.abs() * self.limits.torque_constant_u_ratio)
    }

    /// The drive's torque quantum as a rectangular distribution.
    fn quantum(&self) -> Component {
        Component::known(self.limits.torque_quantum_nm / 12.0_f64.sqrt())
    }

    /// A measurement of this axis.
    fn measurement(
        &self,
        measurand: &str,
        kind: Q,
        value: f64,
        spread: Component,
        n: usize,
        id: &str,
    ) -> Measurement {
        let estimate = Estimate { value, u: spread.u, dof: spread.dof, n };
        Measurement::new(measurand, self.axis, kind, Some(estimate), id)
    }

    /// A measurement of this axis that has no value, and why.
    fn none(&self, measurand: &str, kind: Q, id: &str, reason: impl Into<String>) -> Measurement {
        Measurement::inconclusive(measurand, self.axis, kind, id, reason)
    }

    /// Where in the log a number comes from.
    fn evidence(&self, [t0_s, t1_s]: [f64; 2]) -> Evidence {
        let channels = ["position_rad", "current_a"].map(|c| format!("/{} {c}", self.axis)).to_vec();
        Evidence { file: String::new(), channels, t0_s, t1_s }
    }
}

/// A condition that was asked for, and what was reached.
fn condition(case: &Case, name: &str, achieved: Option<f64>) -> Option<Condition> {
    let request = case.requested.iter().find(|r| r.name == name)?;
    Some(Condition { name: name.to_owned(), requested: request.value, achieved, kind: request.kind })
}
