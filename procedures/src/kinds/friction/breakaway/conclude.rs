//! Over all points: contact, breakaway torques, dwell law, multisine, and whether the axis holds itself without torque.

use analysis::breakaway::{Peak, peak};
use analysis::dwell::{DwellLaw, Repeats, mean};
use analysis::least_squares::LinearFit;
use analysis::load_map::LoadMap;
use analysis::multisine::{Presliding, Record};
use analysis::uncertainty::{Component, combine};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::findings::{Findings, Planned, condition, dwell_plot, plot, presliding_plot, scale, series};
use super::plan::{MULTISINE, RELEASE};
use super::point::{BreakawayPoint, Multisine, Release, TimeSpan};
use super::ramps::{Broken, Contact, Course, groups, rates};
use super::{Direction, FEWEST_DWELLS, Keys, asks_for_dwell_law, ramps};
use crate::axis::Axes;
use crate::case::Case;
use crate::measurement::{Conclusion, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};
use crate::trace::{Plot, Style};

/// Estimator and version of the dwell law.
const DWELL_ESTIMATOR: &str = "dwell-law/1";
/// Estimator and version of the multisine's stiffness and damping.
const MULTISINE_ESTIMATOR: &str = "presliding-multisine/1";

/// Measurements, pictures and remarks over all points.
pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut conclusion = Conclusion::default();
    let Some(axis) = cases.first().map(|c| c.axis.as_str()) else { return conclusion };
    let Some(limits) = axes.get(axis) else {
        conclusion.remarks.push(format!("the log's rig has no axis `{axis}`: nothing was concluded"));
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
    if law.misfit_nm > 3.0 * law.repeatability_nm {
        m.flags.push(format!("not a logarithm: the means miss the line by up to {:.2} N·m", law.misfit_nm));
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
            inertia: findings.limits.inertia_kg_m2,
            start_nm: multisine.rest_nm - map.at(start_rad),
        };
        let presliding = Presliding::new(&record).ok_or(FrictionReason::NoPresliding)?;
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
    conclusion.plots.push(presliding_plot(found));
}

/// Estimator and version of hold margins.
const HOLD_ESTIMATOR: &str = "hold-release/1";
/// Fewest poses of the computed curve: three coefficients and two degrees of freedom for their spread.
const FEWEST_POSES: usize = 5;
/// Step over the travel, rad: half a degree.
const STEP_RAD: f64 = std::f64::consts::PI / 360.0;

/// One pose.
struct Pose {
    pose_rad: f64,
    /// Hold margin.
    margin_nm: f64,
    /// Standard uncertainty of the margin.
    u_nm: f64,
    /// What both ramps show together; `None` where the axis slides.
    balance: Option<Balance>,
}

/// What ramps in both directions at a pose show together, cogging taken off.
#[derive(Clone, Copy)]
struct Balance {
    /// Motor torque that balances unbalance and spring.
    net_nm: f64,
    /// Static friction.
    friction_nm: f64,
}

/// One margin a pose, the curve over the travel, a picture of both.
fn conclude_hold(findings: &Findings<'_>, conclusion: &mut Conclusion) {
    let points: Vec<Planned<'_>> = findings.having(RELEASE).collect();
    if points.is_empty() {
        return;
    }
    let contact = contact(findings, &points);
    let mut poses = Vec::new();
    for planned in points {
        match pose(findings, &planned, contact.as_ref()) {
            Ok((measurement, pose)) => {
                conclusion.measurements.push(measurement);
                poses.push(pose);
            }
            Err(reason) => {
                let mut none = findings.none("hold-margin", Q::Torque, HOLD_ESTIMATOR, reason);
                none.point = Some(planned.case.point.clone());
                none.conditions = condition(planned.case, "pose", None).into_iter().collect();
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
    conclusion.plots.push(hold_plot(&poses, curve.as_ref(), findings.limits.travel_rad));
}

/// Bending length from the ramps of all poses.
fn contact(findings: &Findings<'_>, points: &[Planned<'_>]) -> Option<Contact> {
    let fits: Vec<_> = points
        .iter()
        .filter_map(|planned| planned.reduced().ok())
        .flat_map(|point| Direction::BOTH.map(|direction| without_cogging(findings, point, direction)))
        .filter_map(|course| course.ok().as_ref().and_then(Course::fit))
        .collect();
    Contact::over(&fits.iter().collect::<Vec<_>>())
}

fn without_cogging(
    findings: &Findings<'_>,
    point: &BreakawayPoint,
    direction: Direction,
) -> Result<Course, Reason> {
    Course::ramp(point, direction, |angle| findings.map.as_ref().map_or(0.0, |map| map.cogging_at(angle)))
}

/// What a pose says of holding.
struct Margin {
    margin_nm: f64,
    /// The breakaway, or the slide, that the margin is read from.
    peak: Peak,
    /// How the axis behaved, in words.
    flag: String,
}

/// Margin of one pose, with its pose and what it rests on.
fn pose(
    findings: &Findings<'_>,
    planned: &Planned<'_>,
    contact: Option<&Contact>,
) -> Result<(Measurement, Pose), Reason> {
    let point = planned.reduced()?;
    let contact = contact.ok_or(FrictionReason::BendingUnknown)?;
    let release = point.release.as_ref().ok_or(FrictionReason::NoRelease)?;
    let margin = if release.slid { slide(release, contact)? } else { held(point, contact)? };
    let noise = Component { u: margin.peak.u_nm, dof: margin.peak.dof as f64 };
    let z_ss = Component::known(margin.peak.per_ln_z_ss_nm * contact.z_ss_u_ratio);
    let spread = combine(&[noise, z_ss, findings.torque_constant(margin.margin_nm), findings.quantum()]);
    let pose = Pose {
        pose_rad: release.start_rad,
        margin_nm: margin.margin_nm,
        u_nm: spread.u,
        balance: if release.slid { None } else { balance(findings, point, contact) },
    };
    let mut m = findings.measurement("hold-margin", Q::Torque, margin.margin_nm, spread, 1, HOLD_ESTIMATOR);
    m.point = Some(planned.case.point.clone());
    m.conditions = condition(planned.case, "pose", Some(release.start_rad)).into_iter().collect();
    m.flags.push(margin.flag);
    let ramps = [&point.positive_ramp, &point.negative_ramp].into_iter().flatten();
    let spans = std::iter::once(release.span).chain(ramps.map(|ramp| ramp.span));
    m.evidence = spans.map(|span| findings.evidence(span)).collect();
    Ok((m, pose))
}

/// What the ramps of a pose show together, where both broke away.
fn balance(findings: &Findings<'_>, point: &BreakawayPoint, contact: &Contact) -> Option<Balance> {
    let torque_nm = |direction: Direction| {
        let peak = without_cogging(findings, point, direction).ok()?.peak(contact.z_ss_rad).ok()?;
        Some(peak.torque_nm)
    };
    let up_nm = torque_nm(Direction::Positive)?;
    let down_nm = torque_nm(Direction::Negative)?;
    Some(Balance { net_nm: (up_nm - down_nm) / 2.0, friction_nm: (up_nm + down_nm) / 2.0 })
}

/// The axis stayed: the smaller of the torques that break it away, load left in.
fn held(point: &BreakawayPoint, contact: &Contact) -> Result<Margin, Reason> {
    let broken = |direction: Direction| Course::ramp(point, direction, |_| 0.0)?.peak(contact.z_ss_rad);
    let up = broken(Direction::Positive)?;
    let down = broken(Direction::Negative)?;
    let (weaker, peak) =
        if down.torque_nm < up.torque_nm { (Direction::Negative, down) } else { (Direction::Positive, up) };
    let flag = format!("stayed put when released; {} direction is the weaker", weaker.word());
    Ok(Margin { margin_nm: peak.torque_nm, peak, flag })
}

/// The axis slid off: minus the largest torque that accelerates it over 3…8 z_ss, so a measured number too.
fn slide(release: &Release, contact: &Contact) -> Result<Margin, Reason> {
    let course = Course::slide(release);
    let driving_nm: Vec<f64> = course.effort_nm.iter().map(|f| -f).collect();
    let peak = peak(&course.x_rad, &driving_nm, contact.z_ss_rad).map_err(FrictionReason::SlidOffReleased)?;
    let flag = format!("does not hold: slid off in {} direction when released", course.direction.word());
    Ok(Margin { margin_nm: -peak.torque_nm, peak, flag })
}

/// Unbalance and spring over the travel against static friction: net torque `[1, cos θ, θ]` over the angle and the
/// friction that must hold it.
struct Curve {
    fit: LinearFit,
    /// Coverage factor for 95 %.
    k_factor: f64,
    friction_nm: f64,
    cogging_nm: f64,
    poses: usize,
}

/// Margin that the curve leaves at an angle.
struct CurveMargin {
    /// Friction less |net| less cogging.
    margin_nm: f64,
    /// Expanded uncertainty, 95 %.
    expanded_u_nm: f64,
}

impl Curve {
    /// Fits the poses at which both ramps broke away; `None` if they are too few or too close together.
    fn over(poses: &[Pose], map: Option<&LoadMap>) -> Option<Self> {
        let known: Vec<&Pose> = poses.iter().filter(|p| p.balance.is_some()).collect();
        if known.len() < FEWEST_POSES {
            return None;
        }
        let columns = [
            vec![1.0; known.len()],
            known.iter().map(|p| p.pose_rad.cos()).collect(),
            known.iter().map(|p| p.pose_rad).collect(),
        ];
        let balances: Vec<Balance> = known.iter().filter_map(|p| p.balance).collect();
        let net_nm: Vec<f64> = balances.iter().map(|b| b.net_nm).collect();
        let fit = LinearFit::new(&columns, &net_nm, None).ok()?;
        let k_factor = StudentsT::new(0.0, 1.0, fit.dof as f64).ok()?.inverse_cdf(0.975);
        Some(Self {
            fit,
            k_factor,
            friction_nm: mean(&balances.iter().map(|b| b.friction_nm).collect::<Vec<_>>()),
            cogging_nm: map.map_or(0.0, LoadMap::cogging_amplitude_nm),
            poses: known.len(),
        })
    }

    /// Margin left at an angle.
    fn margin(&self, angle_rad: f64) -> CurveMargin {
        let row = [1.0, angle_rad.cos(), angle_rad];
        CurveMargin {
            margin_nm: self.friction_nm - self.fit.at(&row).abs() - self.cogging_nm,
            expanded_u_nm: self.k_factor * self.fit.u_at(&row),
        }
    }

    /// Angles on the grid over the travel.
    fn angles(travel_rad: [f64; 2]) -> Vec<f64> {
        let steps = ((travel_rad[1] - travel_rad[0]) / STEP_RAD).round().max(1.0);
        (0..=steps as usize)
            .map(|k| travel_rad[0] + (travel_rad[1] - travel_rad[0]) * k as f64 / steps)
            .collect()
    }

    /// Where the axis does not hold itself, in words.
    fn remark(&self, travel_rad: [f64; 2]) -> String {
        let stretches = self.stretches(travel_rad);
        let basis = format!(
            "computed from {} poses, model [1, cos θ, θ], static friction {:.1} N·m, cogging {:.1} N·m on top of the load",
            self.poses, self.friction_nm, self.cogging_nm
        );
        let degrees = |[a, b]: &[f64; 2]| format!("{:.1} … {:.1} deg", a.to_degrees(), b.to_degrees());
        if stretches.is_empty() {
            format!("Holds itself unpowered over the whole travel {} ({basis}).", degrees(&travel_rad))
        } else {
            let list = stretches.iter().map(degrees).collect::<Vec<_>>().join(", ");
            format!(
                "Does not surely hold itself unpowered at {list} ({basis}; uncertainty counted against it)."
            )
        }
    }

    /// Stretches of the travel where |net| + cogging + U exceeds static friction.
    fn stretches(&self, travel_rad: [f64; 2]) -> Vec<[f64; 2]> {
        let mut stretches: Vec<[f64; 2]> = Vec::new();
        let mut open = false;
        for angle in Self::angles(travel_rad) {
            let left = self.margin(angle);
            if left.margin_nm >= left.expanded_u_nm {
                open = false;
                continue;
            }
            match stretches.last_mut() {
                Some(last) if open => last[1] = angle,
                _ => stretches.push([angle, angle]),
            }
            open = true;
        }
        stretches
    }
}

/// Margins at the poses and the computed curve over the travel.
fn hold_plot(poses: &[Pose], curve: Option<&Curve>, travel_rad: [f64; 2]) -> Plot {
    let x = poses.iter().map(|p| p.pose_rad.to_degrees()).collect();
    let y = poses.iter().map(|p| p.margin_nm).collect();
    let u = poses.iter().map(|p| 2.0 * p.u_nm).collect();
    let mut all = vec![series("measured", Style::Markers, x, y, u)];
    if let Some(curve) = curve {
        let angles = Curve::angles(travel_rad);
        let margins: Vec<CurveMargin> = angles.iter().map(|a| curve.margin(*a)).collect();
        let y: Vec<f64> = margins.iter().map(|m| m.margin_nm).collect();
        let u = margins.iter().map(|m| m.expanded_u_nm).collect();
        let x: Vec<f64> = angles.iter().map(|a| a.to_degrees()).collect();
        all.push(series("computed, 95 %", Style::Band, x.clone(), y.clone(), u));
        all.push(series("computed, worst over cogging", Style::Fit, x, y, Vec::new()));
    }
    let mut plot = plot(
        "hold-margin".to_owned(),
        "Static friction less unbalance and spring".to_owned(),
        scale("elevation", "deg", false),
        scale("hold margin", "N*m", false),
        all,
    );
    plot.limits_of = Some("hold-margin".to_owned());
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses(spring: f64) -> Vec<Pose> {
        [-7.0_f64, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 87.0]
            .map(|degrees| {
                let angle = degrees.to_radians();
                let net = spring * (angle - 40.0_f64.to_radians()) - 14.0 * angle.cos();
                let stays = net.abs() < 43.0;
                Pose {
                    pose_rad: angle,
                    margin_nm: 43.0 - net.abs(),
                    u_nm: 0.3,
                    balance: stays.then_some(Balance { net_nm: net, friction_nm: 43.0 }),
                }
            })
            .into()
    }

    const TRAVEL: [f64; 2] = [-10.0 * std::f64::consts::PI / 180.0, std::f64::consts::PI / 2.0];

    #[test]
    fn a_soft_spring_holds_everywhere_and_a_stiff_one_names_where_not() {
        let soft = Curve::over(&poses(20.0), None).expect("nine poses");
        assert!(
            soft.remark(TRAVEL).starts_with("Holds itself unpowered over the whole travel -10.0 … 90.0 deg")
        );
        let stiff = Curve::over(&poses(54.0), None).expect("seven poses hold");
        insta::assert_snapshot!(stiff.remark(TRAVEL), @"Does not surely hold itself unpowered at -10.0 … 9.0 deg, 87.0 … 90.0 deg (computed from 7 poses, model [1, cos θ, θ], static friction 43.0 N·m, cogging 0.0 N·m on top of the load; uncertainty counted against it).");
    }

    #[test]
    fn four_poses_give_no_curve() {
        assert!(Curve::over(&poses(20.0)[..4], None).is_none());
    }
}
