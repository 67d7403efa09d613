//! Over all points: contact, breakaway torques, dwell law, multisine, and whether the axis holds itself without torque.

use analysis::dwell::{DwellLaw, Repeats};
use analysis::multisine::{Presliding, Record};
use analysis::uncertainty::{Component, combine};

use super::findings::{Findings, Planned, condition, dwell_plot, presliding_plot};
use super::hold::conclude_hold;
use super::plan::MULTISINE;
use super::point::{Multisine, TimeSpan};
use super::ramps::{Broken, Contact, groups, rates};
use super::{FEWEST_DWELLS, Keys, asks_for_dwell_law, ramps};
use crate::axis::Axes;
use crate::case::Case;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};

/// Estimator and version of the dwell law.
const DWELL_ESTIMATOR: &str = "dwell-law/2";
/// Estimator and version of the multisine's stiffness and damping.
const MULTISINE_ESTIMATOR: &str = "presliding-multisine/2";

/// Measurements, pictures and remarks over all points.
pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut conclusion = Conclusion::default();
    let Some(axis) = cases.first().map(|c| c.axis.as_str()) else { return conclusion };
    let Some(limits) = axes.get(axis) else {
        conclusion.remarks.push(format!("the rig of the log has no axis `{axis}`: nothing was evaluated"));
        return conclusion;
    };
    let findings = Findings::new(keys, axis, limits, cases, points);
    findings.remark_on_map(&mut conclusion);
    let courses = ramps::courses(&findings);
    let contact = Contact::shown_by(&courses);
    ramps::conclude_contact(&findings, &courses, contact.as_ref(), &mut conclusion);
    let broken = ramps::conclude_breakaway(&findings, &courses, contact.as_ref(), &mut conclusion);
    conclude_dwell(&findings, &broken, &mut conclusion);
    conclude_multisine(&findings, &mut conclusion);
    conclude_hold(&findings, &mut conclusion);
    for point in points {
        conclusion.measurements.extend(point.measurements.iter().cloned());
        conclusion.plots.extend(point.plots.iter().cloned());
    }
    conclusion
}

/// One slope for each rate of 1 A/s or more that has three dwells and repeats.
fn conclude_dwell(findings: &Findings<'_>, broken: &[Broken<'_>], conclusion: &mut Conclusion) {
    if !asks_for_dwell_law(findings.keys) {
        if !findings.keys.ramps.is_empty() {
            let why = "dwell law not determined: three dwells with repeats at 1 A/s or more are needed";
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
        let reason = FrictionReason::TooFewDwells { least: FEWEST_DWELLS };
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
    m.rest_on(&law.goodness);
    if law.goodness.is_misfit() {
        m.flags.push(format!(
            "not logarithmic: the means deviate from the line by up to {:.2} N·m",
            law.misfit_nm
        ));
    }
    m.evidence = at_rate.iter().map(|b| findings.evidence(b.span)).collect();
    conclusion.measurements.push(m);
    conclusion.plots.push(dwell_plot(rate, groups, law));
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
    fn new(findings: &Findings<'_>, planned: &Planned<'_>) -> Result<Self, Reason> {
        let point = planned.reduced()?;
        let map = findings.map.as_ref().map_err(Clone::clone)?;
        let multisine: &Multisine = point.multisine.as_ref().ok_or(FrictionReason::NoMultisine)?;
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
            inertia: multisine.inertia_kg_m2,
            start_nm: multisine.rest_nm - map.at(start_rad),
        };
        let presliding = Presliding::new(&record).ok_or(FrictionReason::NoPresliding)?;
        presliding.goodness.check()?;
        // The load is a spring too: an error of the map changes its slope by about u over a quarter cogging period.
        let reach_rad = (map.span_rad()[1] - map.span_rad()[0]) / 16.0;
        Ok(Self { presliding, span: multisine.span, slope_u_nm_per_rad: map.u_at(start_rad) / reach_rad })
    }
}

fn report_presliding(findings: &Findings<'_>, case: &Case, fit: &PreslidingFit, conclusion: &mut Conclusion) {
    let found = &fit.presliding;
    let told = [
        format!(
            "multisine: {} lines, {} periods, hysteresis of the loops modelled",
            found.lines.len(),
            found.periods
        ),
        format!("torque ahead of angle by {:.0} µs", 1e6 * found.delay_s),
    ];
    let flags: Vec<String> = told.into_iter().chain(found.goodness.flag()).collect();
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
    conclusion.plots.push(presliding_plot(found));
}
