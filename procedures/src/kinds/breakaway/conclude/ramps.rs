//! Breakaway torque of each ramp, and of each rate and dwell.

use analysis::breakaway::Peak;
use analysis::dwell::{mean, squares_about_mean};
use analysis::presliding::RampFit;
use analysis::uncertainty::{Component, combine};

use super::contact::Contact;
use super::{Conclusion, Course, Findings, Q, condition, plots};
use crate::case::Case;
use crate::measurement::{Condition, Measurement};

pub(super) const ESTIMATOR: &str = "breakaway-peak/1";

/// One ramp point: its course, or why there is none.
pub(super) struct RampCourse<'a> {
    pub(super) case: &'a Case,
    pub(super) course: Result<Course, String>,
    pub(super) fit: Option<RampFit>,
    /// Largest effort as smoothed past 2.5 of its own z_ss, N·m.
    pub(super) top_nm: Option<f64>,
}

/// A ramp that broke away.
pub(super) struct Broken<'a> {
    pub(super) case: &'a Case,
    pub(super) direction: f64,
    pub(super) rate: f64,
    pub(super) dwell_s: f64,
    pub(super) rest_s: f64,
    pub(super) rate_achieved: Option<f64>,
    pub(super) peak: Peak,
    pub(super) map_u_nm: f64,
    /// What a row that is late or early by up to one sample makes of the torque, as a standard uncertainty, N·m.
    pub(super) timing_u_nm: f64,
    pub(super) span_s: [f64; 2],
}

/// All ramp points with their fits.
pub(super) fn courses<'a>(findings: &Findings<'a>) -> Vec<RampCourse<'a>> {
    findings
        .cases
        .iter()
        .zip(findings.points)
        .filter(|(case, _)| case.requested("direction").is_some())
        .map(|(case, point)| {
            let course = match (&point.inconclusive, &findings.map) {
                (Some(reason), _) => Err(reason.clone()),
                (None, Err(reason)) => Err(reason.clone()),
                (None, Ok(map)) => {
                    let direction = case.requested("direction").unwrap_or(1.0);
                    Course::of_ramp(&point.numbers, direction, |angle| map.at(angle))
                }
            };
            let fit = course.as_ref().ok().and_then(Course::fit);
            let own = course.as_ref().ok().zip(fit.as_ref());
            let top_nm = own.and_then(|(c, f)| c.peak(f.z_ss_rad()).ok()).map(|p| p.torque_nm);
            RampCourse { case, course, fit, top_nm }
        })
        .collect()
}

/// One measurement and one picture a ramp, one measurement a rate and dwell; returns what broke away.
pub(super) fn conclude<'a>(
    findings: &Findings<'a>,
    ramps: &[RampCourse<'a>],
    contact: Option<&Contact>,
    conclusion: &mut Conclusion,
) -> Vec<Broken<'a>> {
    let mut broken = Vec::new();
    for ramp in ramps {
        match break_away(findings, ramp, contact) {
            Ok(found) => {
                conclusion.measurements.push(single(findings, &found, contact));
                if let (Ok(course), Some(contact)) = (&ramp.course, contact) {
                    conclusion.plots.push(plots::ramp(found.case, course, &found.peak, contact.z_ss_rad));
                }
                broken.push(found);
            }
            Err(reason) => {
                let mut none = findings.none("breakaway-torque", Q::Torque, ESTIMATOR, reason);
                none.point = Some(ramp.case.point.clone());
                none.conditions = ["direction", "rate", "dwell", "pose"]
                    .iter()
                    .filter_map(|n| condition(ramp.case, n, None))
                    .collect();
                conclusion.measurements.push(none);
            }
        }
    }
    conclusion.measurements.extend(means(findings, &broken, contact));
    broken
}

fn break_away<'a>(
    findings: &Findings<'_>,
    ramp: &RampCourse<'a>,
    contact: Option<&Contact>,
) -> Result<Broken<'a>, String> {
    let course = ramp.course.as_ref().map_err(Clone::clone)?;
    let contact = contact.ok_or("z_ss unknown: the exponential fit converged for no ramp")?;
    let peak = course.peak(contact.z_ss_rad)?;
    let asked = |name: &str| ramp.case.requested(name).unwrap_or(f64::NAN);
    let at_rad = course.start_rad + course.direction * peak.at_rad;
    Ok(Broken {
        case: ramp.case,
        direction: course.direction,
        rate: asked("rate"),
        dwell_s: asked("dwell"),
        rest_s: course.rest_s(contact.z_ss_rad, &peak),
        rate_achieved: course
            .rate_nm_per_s
            .zip(findings.limits.torque_constant_nm_per_a)
            .map(|(rate, constant)| rate / constant),
        map_u_nm: findings.map.as_ref().map_or(0.0, |m| m.u_at(at_rad)),
        timing_u_nm: course.rate_nm_per_s.unwrap_or(0.0).abs() * course.sample_s / 3.0_f64.sqrt(),
        span_s: course.span_s,
        peak,
    })
}

/// What is common to all ramps: map, timing, bending length, torque constant, quantum; means over `ramps`.
fn common(findings: &Findings<'_>, ramps: &[&Broken<'_>], contact: Option<&Contact>) -> [Component; 5] {
    let over = |get: &dyn Fn(&Broken<'_>) -> f64| mean(&ramps.iter().map(|b| get(b)).collect::<Vec<_>>());
    let z_ss = over(&|b| b.peak.per_ln_z_ss_nm) * contact.map_or(0.0, |c| c.z_ss_u_ratio);
    [
        Component::known(over(&|b| b.map_u_nm)),
        Component::known(over(&|b| b.timing_u_nm)),
        Component::known(z_ss),
        findings.torque_constant(over(&|b| b.peak.torque_nm)),
        findings.quantum(),
    ]
}

fn single(findings: &Findings<'_>, found: &Broken<'_>, contact: Option<&Contact>) -> Measurement {
    let peak = &found.peak;
    let noise = Component { u: peak.u_nm, dof: peak.dof as f64 };
    let common = common(findings, &[found], contact);
    let spread = combine(&[&[noise][..], &common].concat());
    let mut m = findings.measurement("breakaway-torque", Q::Torque, peak.torque_nm, spread, 1, ESTIMATOR);
    m.point = Some(found.case.point.clone());
    m.conditions = [
        condition(found.case, "direction", Some(found.direction)),
        condition(found.case, "rate", found.rate_achieved),
        condition(found.case, "dwell", Some(found.rest_s)),
        condition(found.case, "pose", found.case.requested("pose")),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let Some(contact) = contact {
        m.flags.push(format!("maximum at {:.1} z_ss", peak.at_rad / contact.z_ss_rad));
    }
    m.evidence = vec![findings.evidence(found.span_s)];
    m
}

/// The mean of all ramps of a rate and dwell: the noise of the single ramps, and what repeats scatter beyond it.
fn means(findings: &Findings<'_>, broken: &[Broken<'_>], contact: Option<&Contact>) -> Vec<Measurement> {
    let excess = excess(broken);
    cells(broken).into_iter().map(|cell| mean_of_cell(findings, &cell, excess, contact)).collect()
}

fn mean_of_cell(
    findings: &Findings<'_>,
    cell: &[&Broken<'_>],
    excess: Option<Component>,
    contact: Option<&Contact>,
) -> Measurement {
    let n = cell.len() as f64;
    let over = |get: &dyn Fn(&Broken<'_>) -> f64| mean(&cell.iter().map(|b| get(b)).collect::<Vec<_>>());
    let value = over(&|b| b.peak.torque_nm);
    let noise = (cell.iter().map(|b| b.peak.u_nm.powi(2)).sum::<f64>()).sqrt() / n;
    let noise = Component { u: noise, dof: cell.iter().map(|b| b.peak.dof as f64).sum() };
    let beyond = excess.map_or(Component::known(0.0), |c| Component { u: c.u / n.sqrt(), dof: c.dof });
    let common = common(findings, cell, contact);
    let spread = combine(&[&[noise, beyond][..], &common].concat());
    let mut m = findings.measurement("breakaway-torque", Q::Torque, value, spread, cell.len(), ESTIMATOR);
    let rest_s = over(&|b| b.rest_s);
    let rates: Option<Vec<f64>> = cell.iter().map(|b| b.rate_achieved).collect();
    m.conditions = [
        condition(cell[0].case, "rate", rates.map(|r| mean(&r))),
        condition(cell[0].case, "dwell", Some(rest_s)),
        condition(cell[0].case, "pose", cell[0].case.requested("pose")),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<Condition>>();
    m.flags.push(format!("mean of {} ramps", cell.len()));
    if let Some(asymmetry) = asymmetry(cell) {
        m.flags.push(format!("positive less negative direction {asymmetry:+.2} N·m"));
    }
    if excess.is_none() {
        m.flags.push("no repeats: uncertainty from the noise of each ramp".to_owned());
    }
    m.evidence = cell.iter().map(|b| findings.evidence(b.span_s)).collect();
    m
}

/// Ramps by rate and dwell, in plan order.
pub(super) fn cells<'b, 'a>(broken: &'b [Broken<'a>]) -> Vec<Vec<&'b Broken<'a>>> {
    let mut cells: Vec<Vec<&Broken<'a>>> = Vec::new();
    for one in broken {
        let same = |c: &&mut Vec<&Broken<'a>>| c[0].rate == one.rate && c[0].dwell_s == one.dwell_s;
        match cells.iter_mut().find(same) {
            Some(cell) => cell.push(one),
            None => cells.push(vec![one]),
        }
    }
    cells
}

/// Torques of a cell in one direction.
pub(super) fn torques(cell: &[&Broken<'_>], direction: f64) -> Vec<f64> {
    cell.iter().filter(|b| b.direction == direction).map(|b| b.peak.torque_nm).collect()
}

/// Standard deviation that one ramp has beyond its noise, from the repeats of all cells, each direction about its own
/// mean (a lopsided contact is no scatter); `None` without repeats.
fn excess(broken: &[Broken<'_>]) -> Option<Component> {
    let (mut squares, mut dof) = (0.0, 0.0);
    for cell in cells(broken) {
        for direction in [1.0, -1.0] {
            let values = torques(&cell, direction);
            if values.len() > 1 {
                squares += squares_about_mean(&values);
                dof += values.len() as f64 - 1.0;
            }
        }
    }
    let noise = mean(&broken.iter().map(|b| b.peak.u_nm.powi(2)).collect::<Vec<_>>());
    (dof > 0.0).then(|| Component { u: (squares / dof - noise).max(0.0).sqrt(), dof })
}

fn asymmetry(cell: &[&Broken<'_>]) -> Option<f64> {
    let [up, down] = [1.0, -1.0].map(|d| torques(cell, d));
    (!up.is_empty() && !down.is_empty()).then(|| mean(&up) - mean(&down))
}
