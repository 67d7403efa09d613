//! Ramps: each as the estimators see it, the contact that all of them show, and the torques that break it away.

use analysis::breakaway::{FROM_ONSET, Peak, peak};
use analysis::dwell::{Repeats, mean, squares_about_mean};
use analysis::presliding::RampFit;
use analysis::uncertainty::{Component, combine, mean_of_repeats, rectangular_u};

use super::findings::{Findings, condition, ramp_plot};
use super::point::{BreakawayPoint, Ramp, Release, TimeSpan};
use super::{DWELL_LAW_RATE, Direction};
use crate::case::Case;
use crate::measurement::{Conclusion, Measurement};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};

/// Displacement, in z_ss, that still counts as rest: over it the contact renews itself by 5 %.
const REST_FACTOR: f64 = 0.05;
/// Estimator and version of bristle stiffness.
const STIFFNESS_ESTIMATOR: &str = "presliding-exponential/2";
/// Estimator and version of breakaway torques.
const BREAKAWAY_ESTIMATOR: &str = "breakaway-peak/4";

/// Torque over displacement, both in the direction of the motion, load taken off.
#[derive(Clone, Debug)]
pub(super) struct Course {
    pub(super) direction: Direction,
    /// Time of each block on the log's axis.
    pub(super) time_s: Vec<f64>,
    /// Displacement from the start of the ramp, in the direction of the course.
    pub(super) x_rad: Vec<f64>,
    /// F̂ in the direction of the course less load.
    pub(super) effort_nm: Vec<f64>,
    /// Angle at the start.
    pub(super) start_rad: f64,
}

impl Course {
    /// A ramp from rest; `load` gives the load torque at an angle.
    ///
    /// # Errors
    /// Why it is no breakaway: slid during the dwell, never moved, moved the wrong way.
    pub(super) fn ramp(
        point: &BreakawayPoint,
        direction: Direction,
        load: impl Fn(f64) -> f64,
    ) -> Result<Self, Reason> {
        let ramp = point.ramp(direction)?;
        if ramp.slid_in_dwell {
            return Err(FrictionReason::SlidInDwell.into());
        }
        let course =
            Self::new(&ramp.time_s, &ramp.position_rad, &ramp.effort_nm, ramp.start_rad, direction, load);
        let reached_rad = course.x_rad.last().copied().unwrap_or(0.0);
        if !ramp.moved {
            let most_nm = course.effort_nm.iter().copied().fold(0.0, f64::max);
            return Err(FrictionReason::NoBreakawayWithin {
                lasted_s: ramp.span.end_s - ramp.span.start_s,
                moved_mrad: 1e3 * reached_rad,
                most_nm,
            }
            .into());
        }
        if reached_rad < 0.0 {
            return Err(FrictionReason::AgainstRamp { moved_mrad: -1e3 * reached_rad }.into());
        }
        Ok(course)
    }

    /// The slide of a release, in the direction in which the axis went.
    pub(super) fn slide(release: &Release) -> Self {
        let end_rad = release.position_rad.last().copied().unwrap_or(release.start_rad);
        let direction = Direction::from_ratio(end_rad - release.start_rad);
        Self::new(
            &release.time_s,
            &release.position_rad,
            &release.effort_nm,
            release.start_rad,
            direction,
            |_| 0.0,
        )
    }

    fn new(
        time_s: &[f64],
        position_rad: &[f64],
        effort_nm: &[f64],
        start_rad: f64,
        direction: Direction,
        load: impl Fn(f64) -> f64,
    ) -> Self {
        let sign = direction.ratio();
        Self {
            direction,
            time_s: time_s.to_vec(),
            x_rad: position_rad.iter().map(|p| sign * (p - start_rad)).collect(),
            effort_nm: position_rad.iter().zip(effort_nm).map(|(p, f)| sign * (f - load(*p))).collect(),
            start_rad,
        }
    }

    /// The exponential at the start of the course.
    pub(super) fn fit(&self) -> Option<RampFit> {
        RampFit::new(&self.time_s, &self.x_rad, &self.effort_nm)
    }

    /// Breakaway torque.
    pub(super) fn peak(&self, z_ss_rad: f64) -> Result<Peak, Reason> {
        peak(&self.x_rad, &self.effort_nm, z_ss_rad, FROM_ONSET).map_err(Reason::from)
    }

    /// Time at rest from the last motion before the ramp until the contact gives way.
    fn rest_s(&self, ramp: &Ramp, z_ss_rad: f64, peak: &Peak) -> f64 {
        let away = |p: &f64| (p - self.start_rad).abs() > REST_FACTOR * z_ss_rad;
        let since_s = match ramp.rest_position_rad.iter().rposition(away) {
            Some(last) => ramp.rest_time_s[last],
            None => ramp.rest_time_s.first().copied().unwrap_or(ramp.span.start_s),
        };
        self.time_s[peak.given_way] - since_s
    }
}

/// A ramp that moved, as it was logged, and its course.
struct Moved<'a> {
    ramp: &'a Ramp,
    course: Course,
}

/// One ramp point: its course, or why there is none.
pub(super) struct RampCourse<'a> {
    case: &'a Case,
    moved: Result<Moved<'a>, Reason>,
    fit: Option<RampFit>,
    /// Largest effort as smoothed past 2.5 of its own z_ss.
    top_nm: Option<f64>,
}

/// All ramp points with their fits.
pub(super) fn courses<'a>(findings: &Findings<'a>) -> Vec<RampCourse<'a>> {
    let mut all = Vec::new();
    for planned in findings.planned() {
        let Some(direction) = Direction::requested(planned.case) else { continue };
        let moved = planned.reduced().and_then(|point| {
            let map = findings.map.as_ref().map_err(Clone::clone)?;
            let course = Course::ramp(point, direction, |angle| map.at(angle))?;
            Ok(Moved { ramp: point.ramp(direction)?, course })
        });
        let course = moved.as_ref().ok().map(|moved| &moved.course);
        let fit = course.and_then(Course::fit);
        let top = course.zip(fit.as_ref()).and_then(|(course, fit)| course.peak(fit.z_ss_rad()).ok());
        all.push(RampCourse { case: planned.case, moved, fit, top_nm: top.map(|peak| peak.torque_nm) });
    }
    all
}

/// What the ramps agree on.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    /// Bending length z_ss = T_∞/σ0, mean over the ramps, rad.
    pub(super) z_ss_rad: f64,
    /// Relative standard uncertainty of z_ss.
    pub(super) z_ss_u_ratio: f64,
    /// Ramps that z_ss rests on.
    count: usize,
}

impl Contact {
    /// The mean of the ramps' own z_ss; `None` if no ramp's fit converged.
    pub(super) fn shown_by(ramps: &[RampCourse<'_>]) -> Option<Self> {
        let fits: Vec<&RampFit> = ramps.iter().filter_map(|r| r.fit.as_ref()).collect();
        Self::over(&fits)
    }

    /// The mean z_ss of these fits; `None` without fits.
    pub(super) fn over(fits: &[&RampFit]) -> Option<Self> {
        let each: Vec<f64> = fits.iter().map(|f| f.z_ss_rad()).collect();
        if each.is_empty() {
            return None;
        }
        let z_ss_rad = mean(&each);
        // Noise of each fit: stiffness and plateau move against each other, so their relative u add.
        let noise =
            fits.iter().map(|f| (f.sigma0_u / f.sigma0 + f.plateau_u_nm / f.plateau_nm).powi(2)).sum::<f64>();
        let z_ss_u_ratio = noise.sqrt() / fits.len() as f64;
        Some(Self { z_ss_rad, z_ss_u_ratio, count: fits.len() })
    }
}

/// Reports the stiffness, or why there is none.
pub(super) fn conclude_contact(
    findings: &Findings<'_>,
    ramps: &[RampCourse<'_>],
    contact: Option<&Contact>,
    conclusion: &mut Conclusion,
) {
    if ramps.is_empty() {
        return;
    }
    let Some(contact) = contact else {
        let reasons = ramps.iter().find_map(|r| r.moved.as_ref().err().cloned());
        let reason = reasons.unwrap_or_else(|| FrictionReason::NoFit.into());
        conclusion.measurements.push(findings.none(
            "bristle-stiffness",
            Q::Stiffness,
            STIFFNESS_ESTIMATOR,
            reason,
        ));
        return;
    };
    conclusion.measurements.push(stiffness(findings, ramps));
    conclusion.remarks.push(format!(
        "Bending length z_ss = T_∞/σ0 = {:.5} mrad (mean of {} ramps); breakaway is judged between {:.3} and {:.3} mrad.",
        1e3 * contact.z_ss_rad,
        contact.count,
        1e3 * FROM_ONSET.judged[0] * contact.z_ss_rad,
        1e3 * FROM_ONSET.judged[1] * contact.z_ss_rad
    ));
}

/// The mean stiffness of all ramps with a fit, of which there is at least one.
fn stiffness(findings: &Findings<'_>, ramps: &[RampCourse<'_>]) -> Measurement {
    let fitted: Vec<(&RampCourse<'_>, &RampFit)> =
        ramps.iter().filter_map(|r| r.fit.as_ref().map(|f| (r, f))).collect();
    let values: Vec<f64> = fitted.iter().map(|(_, f)| f.sigma0).collect();
    let n = values.len();
    let noise = fitted.iter().map(|(_, f)| f.sigma0_u.powi(2)).sum::<f64>().sqrt() / n as f64;
    let scatter = mean_of_repeats(&values).map_or(Component::known(noise), |(_, c)| c);
    let value = mean(&values);
    let model = Component::rectangular(value * model_ratio(&fitted));
    let spread = combine(&[scatter, model, findings.torque_constant(value)]);
    let mut measurement =
        findings.measurement("bristle-stiffness", Q::Stiffness, value, spread, n, STIFFNESS_ESTIMATOR);
    measurement.flags.push(format!("exponential fit on {n} ramps"));
    let missing = ramps.len() - n;
    if missing > 0 {
        measurement.flags.push(format!("{missing} ramps without a fit"));
    }
    measurement.evidence = fitted
        .iter()
        .filter_map(|(r, _)| r.moved.as_ref().ok())
        .map(|moved| findings.evidence(moved.ramp.span))
        .collect();
    measurement
}

/// What the exponential leaves out (fall of friction with speed, renewal of the contact), relative: the plateau that
/// the fit tends to and the largest effort are two readings of one torque; their mean distance is taken as the half
/// width of a rectangular distribution.
fn model_ratio(fitted: &[(&RampCourse<'_>, &RampFit)]) -> f64 {
    let each: Vec<f64> = fitted
        .iter()
        .filter_map(|(r, f)| {
            let top = r.top_nm?;
            Some((f.plateau_nm / top - 1.0).abs())
        })
        .collect();
    if each.is_empty() { 0.0 } else { mean(&each) }
}

/// A ramp that broke away.
pub(super) struct Broken<'a> {
    pub(super) case: &'a Case,
    pub(super) direction: Direction,
    /// Rate of the motor current that was asked for.
    pub(super) rate_a_per_s: f64,
    /// Dwell that was asked for.
    dwell_s: f64,
    /// Time at rest as measured.
    pub(super) rest_s: f64,
    rate_achieved_a_per_s: Option<f64>,
    pub(super) peak: Peak,
    map_u_nm: f64,
    /// What a row that is late or early by up to one sample makes of the torque, as a standard uncertainty.
    timing_u_nm: f64,
    pub(super) span: TimeSpan,
}

/// One measurement and one picture a ramp, one measurement a rate and dwell; returns what broke away.
pub(super) fn conclude_breakaway<'a>(
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
                if let (Ok(moved), Some(contact)) = (&ramp.moved, contact) {
                    conclusion.plots.push(ramp_plot(
                        found.case,
                        &moved.course.x_rad,
                        &moved.course.effort_nm,
                        &found.peak,
                        contact.z_ss_rad,
                    ));
                }
                broken.push(found);
            }
            Err(reason) => {
                let mut none = findings.none("breakaway-torque", Q::Torque, BREAKAWAY_ESTIMATOR, reason);
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
) -> Result<Broken<'a>, Reason> {
    let Moved { ramp: logged, course } = ramp.moved.as_ref().map_err(Clone::clone)?;
    let contact = contact.ok_or(FrictionReason::BendingUnknown)?;
    let peak = course.peak(contact.z_ss_rad)?;
    let sign = course.direction.ratio();
    let rate_nm_per_s = logged.rate_nm_per_s.map(|rate| sign * rate);
    let constant = findings.limits.torque_constant();
    Ok(Broken {
        case: ramp.case,
        direction: course.direction,
        rate_a_per_s: ramp.case.requested("rate").ok_or(FrictionReason::NoRate)?,
        dwell_s: ramp.case.requested("dwell").ok_or(FrictionReason::NoDwell)?,
        rest_s: course.rest_s(logged, contact.z_ss_rad, &peak),
        rate_achieved_a_per_s: rate_nm_per_s.zip(constant).map(|(rate, constant)| rate / constant),
        map_u_nm: findings.map.as_ref().map_or(0.0, |m| m.u_at(course.start_rad + sign * peak.at_rad)),
        timing_u_nm: rectangular_u(rate_nm_per_s.unwrap_or(0.0).abs() * logged.sample_s.unwrap_or(0.0)),
        span: logged.span,
        peak,
    })
}

/// What is common to all ramps: map, timing, bending length, torque constant, quantum; means over `ramps`. What the inertia adds that
/// is taken off is known to the judge of a run alone.
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
    let mut m =
        findings.measurement("breakaway-torque", Q::Torque, peak.torque_nm, spread, 1, BREAKAWAY_ESTIMATOR);
    m.point = Some(found.case.point.clone());
    m.conditions = [
        condition(found.case, "direction", Some(found.direction.ratio())),
        condition(found.case, "rate", found.rate_achieved_a_per_s),
        condition(found.case, "dwell", Some(found.rest_s)),
        condition(found.case, "pose", found.case.requested("pose")),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let Some(contact) = contact {
        m.flags.push(format!("maximum at {:.1} z_ss", peak.at_rad / contact.z_ss_rad));
    }
    m.evidence = vec![findings.evidence(found.span)];
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
    let mut m =
        findings.measurement("breakaway-torque", Q::Torque, value, spread, cell.len(), BREAKAWAY_ESTIMATOR);
    let rest_s = over(&|b| b.rest_s);
    let rates: Option<Vec<f64>> = cell.iter().map(|b| b.rate_achieved_a_per_s).collect();
    m.conditions = [
        condition(cell[0].case, "rate", rates.map(|r| mean(&r))),
        condition(cell[0].case, "dwell", Some(rest_s)),
        condition(cell[0].case, "pose", cell[0].case.requested("pose")),
    ]
    .into_iter()
    .flatten()
    .collect();
    m.flags.push(format!("mean of {} ramps", cell.len()));
    if let Some(asymmetry) = asymmetry(cell) {
        m.flags.push(format!("positive less negative direction {asymmetry:+.2} N·m"));
    }
    if excess.is_none() {
        m.flags.push("no repeats: uncertainty from the noise of each ramp".to_owned());
    }
    m.evidence = cell.iter().map(|b| findings.evidence(b.span)).collect();
    m
}

/// Ramps by rate and dwell, in plan order.
fn cells<'b, 'a>(broken: &'b [Broken<'a>]) -> Vec<Vec<&'b Broken<'a>>> {
    let mut cells: Vec<Vec<&Broken<'a>>> = Vec::new();
    for one in broken {
        let same =
            |c: &&mut Vec<&Broken<'a>>| c[0].rate_a_per_s == one.rate_a_per_s && c[0].dwell_s == one.dwell_s;
        match cells.iter_mut().find(same) {
            Some(cell) => cell.push(one),
            None => cells.push(vec![one]),
        }
    }
    cells
}

/// Torques of a cell in one direction.
fn torques(cell: &[&Broken<'_>], direction: Direction) -> Vec<f64> {
    cell.iter().filter(|b| b.direction == direction).map(|b| b.peak.torque_nm).collect()
}

/// Standard deviation that one ramp has beyond its noise, from the repeats of all cells, each direction about its own
/// mean (a lopsided contact is no scatter); `None` without repeats.
fn excess(broken: &[Broken<'_>]) -> Option<Component> {
    let mut squares = 0.0;
    let mut dof = 0.0;
    for cell in cells(broken) {
        for direction in Direction::BOTH {
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
    let [up, down] = Direction::BOTH.map(|d| torques(cell, d));
    (!up.is_empty() && !down.is_empty()).then(|| mean(&up) - mean(&down))
}

/// Rates fast enough, each once, in plan order.
pub(super) fn rates(broken: &[Broken<'_>]) -> Vec<f64> {
    let mut rates: Vec<f64> = Vec::new();
    for one in broken.iter().filter(|b| b.rate_a_per_s >= DWELL_LAW_RATE) {
        if !rates.contains(&one.rate_a_per_s) {
            rates.push(one.rate_a_per_s);
        }
    }
    rates
}

/// Repeats of each cell and direction at a rate.
pub(super) fn groups(broken: &[Broken<'_>], rate: f64) -> Vec<Repeats> {
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
