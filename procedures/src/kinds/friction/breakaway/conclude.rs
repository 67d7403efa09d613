//! Over all points: load map, contact, breakaway torques, dwell law, multisine, hold.

use analysis::dwell::{DwellLaw, Repeats};
use analysis::estimate::Estimate;
use analysis::load_map::LoadMap;
use analysis::multisine::{Presliding, Record};
use analysis::uncertainty::{Component, combine};

use super::keys::Keys;
use super::plan::{MULTISINE, STROKE};
use super::point::{BreakawayPoint, Multisine, TimeSpan};
use super::ramps::{Broken, Contact, cells};
use super::{Direction, hold, plots, ramps};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::measurement::{Conclusion, Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

/// Slowest rate at which the dwell law is judged, A/s: a slower ramp ages the contact while it lasts.
const DWELL_LAW_RATE: f64 = 1.0;
/// Fewest dwell times for a law.
const FEWEST_DWELLS: usize = 3;
/// Estimator and version of the dwell law.
const DWELL_ESTIMATOR: &str = "dwell-law/1";
/// Estimator and version of the multisine's stiffness and damping.
const MULTISINE_ESTIMATOR: &str = "presliding-multisine/1";

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
pub(super) struct Findings<'a> {
    keys: &'a Keys,
    axis: &'a str,
    pub(super) limits: &'a AxisLimits,
    cases: &'a [Case],
    points: &'a [PointResult],
    /// Load near the pose, or why it is not known.
    pub(super) map: Result<LoadMap, String>,
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
    let courses = ramps::courses(&findings);
    let contact = Contact::shown_by(&courses);
    ramps::conclude_contact(&findings, &courses, contact.as_ref(), &mut conclusion);
    let broken = ramps::conclude_breakaway(&findings, &courses, contact.as_ref(), &mut conclusion);
    conclude_dwell(&findings, &broken, &mut conclusion);
    conclude_multisine(&findings, &mut conclusion);
    hold::conclude(&findings, &mut conclusion);
    for point in points {
        conclusion.measurements.extend(point.measurements.iter().cloned());
        conclusion.plots.extend(point.plots.iter().cloned());
    }
    conclusion
}

fn load_map(cases: &[Case], points: &[PointResult], limits: &AxisLimits) -> Result<LoadMap, String> {
    let place = cases
        .iter()
        .position(|case| has_segment(case, STROKE))
        .ok_or("map missing: the procedure has no stroke")?;
    let result = points.get(place).ok_or("map missing: the stroke was not run")?;
    if let Some(reason) = &result.inconclusive {
        return Err(format!("map missing: {reason}"));
    }
    let stroke = result.reduced.get::<BreakawayPoint>().and_then(|point| point.stroke.as_ref());
    stroke
        .and_then(|stroke| {
            let orders_per_rev = limits.cogging_orders_per_rev;
            LoadMap::new(&stroke.position_rad, &stroke.velocity_rad_per_s, &stroke.effort_nm, orders_per_rev)
        })
        .ok_or_else(|| {
            "map missing: the stroke does not cover a cogging period in both directions".to_owned()
        })
}

/// Whether a case has a segment of this label.
fn has_segment(case: &Case, label: &str) -> bool {
    case.segments.iter().any(|s| s.label == label)
}

/// A point with its plan.
#[derive(Clone, Copy)]
pub(super) struct Planned<'a> {
    pub(super) case: &'a Case,
    result: &'a PointResult,
}

impl<'a> Planned<'a> {
    /// What the point was reduced to.
    ///
    /// # Errors
    /// Why the point gives nothing.
    pub(super) fn reduced(&self) -> Result<&'a BreakawayPoint, String> {
        match &self.result.inconclusive {
            Some(reason) => Err(reason.clone()),
            None => self.result.reduced.get().ok_or_else(|| "nothing came of the point".to_owned()),
        }
    }
}

impl<'a> Findings<'a> {
    /// All points with their plan.
    pub(super) fn planned(&self) -> impl Iterator<Item = Planned<'a>> {
        self.cases.iter().zip(self.points).map(|(case, result)| Planned { case, result })
    }

    /// The points whose case has a segment of this label.
    pub(super) fn having(&self, label: &str) -> impl Iterator<Item = Planned<'a>> {
        self.planned().filter(move |planned| has_segment(planned.case, label))
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
    pub(super) fn torque_constant(&self, torque: f64) -> Component {
        Component::known(torque.abs() * self.limits.torque_constant_u_ratio)
    }

    /// The drive's torque quantum as a rectangular distribution.
    pub(super) fn quantum(&self) -> Component {
        Component::known(self.limits.torque_quantum_nm / 12.0_f64.sqrt())
    }

    /// A measurement of this axis.
    pub(super) fn measurement(
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
    pub(super) fn none(&self, measurand: &str, kind: Q, id: &str, reason: impl Into<String>) -> Measurement {
        Measurement::inconclusive(measurand, self.axis, kind, id, reason)
    }

    /// Where in the log a number comes from.
    pub(super) fn evidence(&self, span: TimeSpan) -> Evidence {
        let channels = ["position_rad", "current_a"].map(|c| format!("/{} {c}", self.axis)).to_vec();
        Evidence { file: String::new(), channels, t0_s: span.start_s, t1_s: span.end_s }
    }
}

/// A condition that was asked for, and what was reached.
pub(super) fn condition(case: &Case, name: &str, achieved: Option<f64>) -> Option<Condition> {
    let request = case.requested.iter().find(|r| r.name == name)?;
    Some(Condition { name: name.to_owned(), requested: request.value, achieved, kind: request.kind })
}

/// One slope for each rate of 1 A/s or more that has three dwells and repeats.
fn conclude_dwell(findings: &Findings<'_>, broken: &[Broken<'_>], conclusion: &mut Conclusion) {
    if !asks_for_dwell_law(findings.keys) {
        if !findings.keys.ramps.is_empty() {
            let why = "dwell law not determined: it takes three dwells with repeats at 1 A/s or more";
            conclusion.remarks.push(why.to_owned());
        }
        return;
    }
    let mut found = false;
    for rate in rates(broken) {
        let groups = groups(broken, rate);
        let Some(law) = DwellLaw::new(&groups, findings.keys.dwell_constant_s) else { continue };
        found = true;
        report_dwell_law(findings, broken, rate, &groups, &law, conclusion);
    }
    if !found {
        let reason = format!("fewer than {FEWEST_DWELLS} dwells with repeats broke away at 1 A/s or more");
        conclusion.measurements.push(findings.none("dwell-slope", Q::Torque, DWELL_ESTIMATOR, reason));
    }
}

fn report_dwell_law(
    findings: &Findings<'_>,
    broken: &[Broken<'_>],
    rate: f64,
    groups: &[Repeats],
    law: &DwellLaw,
    conclusion: &mut Conclusion,
) {
    let repeats = Component { u: law.slope_u_nm, dof: law.dof };
    let spread = combine(&[repeats, findings.torque_constant(law.slope_nm)]);
    let n = groups.iter().map(|g| g.torque_nm.len()).sum();
    let mut m = findings.measurement("dwell-slope", Q::Torque, law.slope_nm, spread, n, DWELL_ESTIMATOR);
    let at_rate: Vec<&Broken<'_>> = broken.iter().filter(|b| b.rate_a_per_s == rate).collect();
    if let Some(one) = at_rate.first() {
        m.conditions =
            ["rate", "pose"].iter().filter_map(|n| condition(one.case, n, one.case.requested(n))).collect();
    }
    m.flags.push(format!("per unit of ln(1 + t/{:.0} s), t counted to 3 z_ss", law.tau_s));
    if law.misfit_nm > 3.0 * law.repeatability_nm {
        m.flags.push(format!("not a logarithm: the means miss the line by up to {:.2} N·m", law.misfit_nm));
    }
    m.evidence = at_rate.iter().map(|b| findings.evidence(b.span)).collect();
    conclusion.measurements.push(m);
    conclusion.plots.push(plots::dwell(rate, groups, law));
}

/// Rates fast enough, each once, in plan order.
fn rates(broken: &[Broken<'_>]) -> Vec<f64> {
    let mut rates: Vec<f64> = Vec::new();
    for one in broken.iter().filter(|b| b.rate_a_per_s >= DWELL_LAW_RATE) {
        if !rates.contains(&one.rate_a_per_s) {
            rates.push(one.rate_a_per_s);
        }
    }
    rates
}

fn groups(broken: &[Broken<'_>], rate: f64) -> Vec<Repeats> {
    let mut groups = Vec::new();
    for cell in cells(broken).iter().filter(|c| c[0].rate_a_per_s == rate) {
        for direction in Direction::BOTH {
            let own: Vec<&&Broken<'_>> = cell.iter().filter(|b| b.direction == direction).collect();
            if !own.is_empty() {
                groups.push(Repeats {
                    direction_ratio: direction.ratio(),
                    rest_s: own.iter().map(|b| b.rest_s).collect(),
                    torque_nm: own.iter().map(|b| b.peak.torque_nm).collect(),
                });
            }
        }
    }
    groups
}

/// Both measurands of each multisine point, or why there are none.
fn conclude_multisine(findings: &Findings<'_>, conclusion: &mut Conclusion) {
    for planned in findings.having(MULTISINE) {
        match PreslidingFit::new(findings, &planned) {
            Ok(fit) => report_presliding(findings, planned.case, &fit, conclusion),
            Err(reason) => {
                for (name, kind) in [("bristle-stiffness", Q::Stiffness), ("presliding-damping", Q::Damping)]
                {
                    let mut none = findings.none(name, kind, MULTISINE_ESTIMATOR, reason.clone());
                    none.point = Some(planned.case.point.clone());
                    conclusion.measurements.push(none);
                }
            }
        }
    }
}

/// The fit of a multisine.
struct PreslidingFit {
    presliding: Presliding,
    span: TimeSpan,
    /// Standard uncertainty of the load's slope at the pose.
    slope_u_nm_per_rad: f64,
}

impl PreslidingFit {
    fn new(findings: &Findings<'_>, planned: &Planned<'_>) -> Result<Self, String> {
        let point = planned.reduced()?;
        let map = findings.map.as_ref().map_err(Clone::clone)?;
        let multisine: &Multisine = point.multisine.as_ref().ok_or("the point has no multisine")?;
        let start_rad = multisine.start_rad;
        let x_rad: Vec<f64> = multisine.position_rad.iter().map(|p| p - start_rad).collect();
        let torque_nm: Vec<f64> =
            multisine.position_rad.iter().zip(&multisine.torque_nm).map(|(p, t)| t - map.at(*p)).collect();
        let record = Record {
            x_rad: &x_rad,
            torque_nm: &torque_nm,
            period_blocks: multisine.period_blocks,
            period_s: multisine.period_s,
            orders: &multisine.orders,
            inertia: findings.limits.inertia_kg_m2,
            start_nm: multisine.rest_nm - map.at(start_rad),
        };
        let presliding =
            Presliding::new(&record).ok_or("the presliding fit did not converge, or too few periods")?;
        // The load is a spring too: an error of the map changes its slope by about u over a quarter cogging period.
        let reach_rad = (map.span_rad()[1] - map.span_rad()[0]) / 16.0;
        Ok(Self { presliding, span: multisine.span, slope_u_nm_per_rad: map.u_at(start_rad) / reach_rad })
    }
}

fn report_presliding(findings: &Findings<'_>, case: &Case, fit: &PreslidingFit, conclusion: &mut Conclusion) {
    let found = &fit.presliding;
    let flags = vec![
        format!(
            "multisine: {} lines, {} periods, hysteresis of the loops modelled",
            found.lines.len(),
            found.periods
        ),
        format!("misfit over scatter {:.2}", found.misfit_ratio),
        format!("torque ahead of angle by {:.0} µs", 1e6 * found.delay_s),
    ];
    let measurement = |name: &str, kind: Q, value: f64, u: f64, load_u: f64| {
        let scatter = Component { u, dof: found.dof };
        let spread = combine(&[scatter, Component::known(load_u), findings.torque_constant(value)]);
        let mut m = findings.measurement(name, kind, value, spread, found.periods, MULTISINE_ESTIMATOR);
        m.point = Some(case.point.clone());
        m.conditions =
            ["level", "pose"].iter().filter_map(|n| condition(case, n, case.requested(n))).collect();
        m.flags.clone_from(&flags);
        m.evidence = vec![findings.evidence(fit.span)];
        m
    };
    conclusion.measurements.extend([
        measurement("bristle-stiffness", Q::Stiffness, found.sigma0, found.sigma0_u, fit.slope_u_nm_per_rad),
        measurement("presliding-damping", Q::Damping, found.damping, found.damping_u, 0.0),
    ]);
    conclusion.plots.push(plots::presliding(found));
}
