//! Whether the axis holds itself without torque: measured at poses, computed over the travel.

use analysis::breakaway::{Peak, peak};
use analysis::uncertainty::combine;

use super::contact::Contact;
use super::{Component, Conclusion, Course, Findings, Q, RELEASE, condition, plots};
use crate::case::Case;
use crate::kinds::breakaway::course::{first, span};
use crate::measurement::{Measurement, PointResult};

mod curve;

pub(super) use curve::Curve;

const ESTIMATOR: &str = "hold-release/1";

/// One pose.
pub(super) struct Pose {
    /// Angle, rad.
    pub(super) pose_rad: f64,
    /// Hold margin, N·m.
    pub(super) margin_nm: f64,
    /// Its standard uncertainty.
    pub(super) u_nm: f64,
    /// Motor torque that balances unbalance and spring there, cogging taken off; `None` where the axis slides.
    pub(super) net_nm: Option<f64>,
    /// Static friction there; `None` where the axis slides.
    pub(super) friction_nm: Option<f64>,
}

/// One margin a pose, the curve over the travel, a picture of both.
pub(super) fn conclude(findings: &Findings<'_>, conclusion: &mut Conclusion) {
    let points: Vec<(&Case, &PointResult)> = findings.having(RELEASE).collect();
    if points.is_empty() {
        return;
    }
    let contact = contact(findings, &points);
    let mut poses = Vec::new();
    for (case, point) in points {
        match pose(findings, case, point, contact.as_ref()) {
            Ok((measurement, pose)) => {
                conclusion.measurements.push(measurement);
                poses.push(pose);
            }
            Err(reason) => {
                let mut none = findings.none("hold-margin", Q::Torque, ESTIMATOR, reason);
                none.point = Some(case.point.clone());
                none.conditions = condition(case, "pose", None).into_iter().collect();
                conclusion.measurements.push(none);
            }
        }
    }
    let curve = Curve::over(&poses, findings.map.as_ref().ok());
    conclusion.remarks.push(match &curve {
        Some(curve) => curve.remark(findings.limits.travel_rad),
        None => {
            "Holding over the travel was not computed: it takes five poses at which both ramps broke away."
                .to_owned()
        }
    });
    conclusion.plots.push(plots::hold(&poses, curve.as_ref(), findings.limits.travel_rad));
}

/// Bending length from the ramps of all poses.
fn contact(findings: &Findings<'_>, points: &[(&Case, &PointResult)]) -> Option<Contact> {
    let fits: Vec<_> = points
        .iter()
        .filter(|(_, p)| p.inconclusive.is_none())
        .flat_map(|(_, p)| [1.0, -1.0].map(|d| without_cogging(findings, p, d)))
        .filter_map(|course| course.ok().as_ref().and_then(Course::fit))
        .collect();
    Contact::over(&fits.iter().collect::<Vec<_>>())
}

fn without_cogging(findings: &Findings<'_>, point: &PointResult, direction: f64) -> Result<Course, String> {
    Course::of_ramp(&point.numbers, direction, |a| findings.map.as_ref().map_or(0.0, |m| m.cogging_at(a)))
}

fn pose(
    findings: &Findings<'_>,
    case: &Case,
    point: &PointResult,
    contact: Option<&Contact>,
) -> Result<(Measurement, Pose), String> {
    if let Some(reason) = &point.inconclusive {
        return Err(reason.clone());
    }
    let contact = contact.ok_or("z_ss unknown: the exponential fit converged for no ramp")?;
    let slid = first(&point.numbers, "release.slid")? > 0.0;
    let (margin_nm, peak, flag) = if slid { slide(point, contact)? } else { held(point, contact)? };
    let noise = Component { u: peak.u_nm, dof: peak.dof as f64 };
    let z_ss = Component::known(peak.per_ln_z_ss_nm * contact.z_ss_u_ratio);
    let spread = combine(&[noise, z_ss, findings.torque_constant(margin_nm), findings.quantum()]);
    let mut m = findings.measurement("hold-margin", Q::Torque, margin_nm, spread, 1, ESTIMATOR);
    m.point = Some(case.point.clone());
    let start_rad = first(&point.numbers, "release.start")?;
    m.conditions = condition(case, "pose", Some(start_rad)).into_iter().collect();
    m.flags.push(flag);
    m.evidence = ["release.span", "ramp+.span", "ramp-.span"]
        .iter()
        .filter_map(|name| span(&point.numbers, name).ok())
        .map(|s| findings.evidence(s))
        .collect();
    let smooth = [1.0, -1.0].map(|d| without_cogging(findings, point, d)?.peak(contact.z_ss_rad));
    let both = match &smooth {
        [Ok(up), Ok(down)] if !slid => Some((up.torque_nm, down.torque_nm)),
        _ => None,
    };
    let pose = Pose {
        pose_rad: start_rad,
        margin_nm,
        u_nm: spread.u,
        net_nm: both.map(|(up, down)| (up - down) / 2.0),
        friction_nm: both.map(|(up, down)| (up + down) / 2.0),
    };
    Ok((m, pose))
}

/// It stayed: the smaller of the torques that break it away, load left in.
fn held(point: &PointResult, contact: &Contact) -> Result<(f64, Peak, String), String> {
    let mut least: Option<(f64, Peak)> = None;
    for direction in [1.0, -1.0] {
        let course = Course::of_ramp(&point.numbers, direction, |_| 0.0)?;
        let peak = course.peak(contact.z_ss_rad)?;
        if least.as_ref().is_none_or(|(_, p)| peak.torque_nm < p.torque_nm) {
            least = Some((direction, peak));
        }
    }
    let (direction, peak) = least.ok_or("no ramp broke away")?;
    let word = if direction > 0.0 { "positive" } else { "negative" };
    Ok((peak.torque_nm, peak, format!("stayed put when released; {word} direction is the weaker")))
}

/// It slid off: minus the largest torque that accelerates it over 3…8 z_ss, so a measured number too.
fn slide(point: &PointResult, contact: &Contact) -> Result<(f64, Peak, String), String> {
    let course = Course::of_slide(&point.numbers)?;
    let driving: Vec<f64> = course.effort_nm.iter().map(|f| -f).collect();
    let peak = peak(&course.x_rad, &driving, contact.z_ss_rad)
        .map_err(|e| format!("does not hold: it slid off when released, and {e}"))?;
    let word = if course.direction > 0.0 { "positive" } else { "negative" };
    Ok((-peak.torque_nm, peak, format!("does not hold: slid off in {word} direction when released")))
}
