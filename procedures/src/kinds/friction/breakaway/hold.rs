//! Holding without torque: margins at poses, and the curve over the travel.

use analysis::breakaway::{Peak, SLIDING, peak};
use analysis::dwell::mean;
use analysis::least_squares::LinearFit;
use analysis::load_map::LoadMap;
use analysis::uncertainty::{Component, combine};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::Direction;
use super::findings::{Findings, Planned, plot, scale, series};
use super::plan::RELEASE;
use super::point::{BreakawayPoint, Release};
use super::ramps::{Contact, Course};
use crate::measurement::{Conclusion, Condition, Evidence, Measurement};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};
use crate::trace::{Plot, Style};

/// Estimator and version of hold margins.
const HOLD_ESTIMATOR: &str = "hold-release/2";
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

/// One margin a judged pose, the curve over the travel, a picture of both.
pub(super) fn conclude_hold(findings: &Findings<'_>, conclusion: &mut Conclusion) {
    let points: Vec<Planned<'_>> = findings.having(RELEASE).collect();
    if points.is_empty() {
        return;
    }
    let contact = contact(findings, &points);
    let mut poses = Vec::new();
    let mut judged: Vec<(f64, Vec<Result<Phase<'_>, Reason>>)> = Vec::new();
    for planned in &points {
        let found = contact
            .as_ref()
            .ok_or_else(|| FrictionReason::BendingUnknown.into())
            .and_then(|contact| Phase::read(findings, planned, contact));
        poses.extend(found.as_ref().ok().map(|phase| phase.pose(findings)));
        let judged_poses = findings.keys.hold.iter().flat_map(|hold| &hold.poses_rad);
        let asked_rad = planned.case.requested("pose").unwrap_or(f64::NAN);
        if !judged_poses.clone().any(|pose_rad| *pose_rad == asked_rad) {
            continue;
        }
        match judged.iter_mut().find(|(pose_rad, _)| *pose_rad == asked_rad) {
            Some((_, phases)) => phases.push(found),
            None => judged.push((asked_rad, vec![found])),
        }
    }
    for (asked_rad, phases) in judged {
        conclusion.measurements.push(margin(findings, contact.as_ref(), asked_rad, phases));
    }
    let curve = Curve::over(&poses, findings.map.as_ref().ok());
    conclusion.remarks.push(match &curve {
        Some(curve) => curve.remark(findings.limits.travel_rad),
        None => {
            "Holding over the travel was not computed: five poses at which both ramps broke away are needed."
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

/// What a point says of holding at its phase of the cogging.
struct Phase<'a> {
    release: &'a Release,
    /// Torque that breaks the axis away in each direction, load left in; in the direction in which it slid off when released,
    /// less than nothing. `None` where no ramp broke away.
    breakaway: [Option<Peak>; 2],
    slid: Option<Direction>,
    balance: Option<Balance>,
    evidence: Vec<Evidence>,
}

impl<'a> Phase<'a> {
    fn read(findings: &Findings<'_>, planned: &Planned<'a>, contact: &Contact) -> Result<Self, Reason> {
        let point = planned.reduced()?;
        let release = point.release.as_ref().ok_or(FrictionReason::NoRelease)?;
        let ramp = |direction: Direction| Course::ramp(point, direction, |_| 0.0)?.peak(contact.z_ss_rad);
        let [up, down] = [Direction::Positive, Direction::Negative].map(ramp);
        let mut slid = None;
        let breakaway = if release.slid {
            let (direction, peak) = slide(release, contact)?;
            slid = Some(direction);
            let mut breakaway = [up.ok(), down.ok()];
            breakaway[place(direction)] = Some(peak);
            breakaway
        } else {
            [Some(up?), Some(down?)]
        };
        let ramps = [&point.positive_ramp, &point.negative_ramp].into_iter().flatten();
        let spans = std::iter::once(release.span).chain(ramps.map(|ramp| ramp.span));
        Ok(Self {
            release,
            breakaway,
            slid,
            balance: if release.slid { None } else { balance(findings, point, contact) },
            evidence: spans.map(|span| findings.evidence(span)).collect(),
        })
    }

    /// The direction in which the load pulls at this phase: that with the smaller breakaway.
    fn weaker(&self) -> Direction {
        let torque_nm = |direction: Direction| {
            self.breakaway[place(direction)].as_ref().map_or(f64::INFINITY, |peak| peak.torque_nm)
        };
        let down = torque_nm(Direction::Negative) < torque_nm(Direction::Positive);
        if down { Direction::Negative } else { Direction::Positive }
    }

    fn in_direction(&self, direction: Direction) -> Result<&Peak, Reason> {
        self.breakaway[place(direction)].as_ref().ok_or_else(|| FrictionReason::NoRelease.into())
    }

    /// What it adds to the curve over the travel.
    fn pose(&self, findings: &Findings<'_>) -> Pose {
        let peak = self.breakaway[place(self.weaker())].as_ref();
        let margin_nm = peak.map_or(f64::NAN, |peak| peak.torque_nm);
        let noise = Component { u: peak.map_or(0.0, |peak| peak.u_nm), dof: f64::INFINITY };
        let spread = combine(&[noise, findings.torque_constant(margin_nm), findings.quantum()]);
        Pose { pose_rad: self.release.start_rad, margin_nm, u_nm: spread.u, balance: self.balance }
    }
}

fn place(direction: Direction) -> usize {
    usize::from(direction == Direction::Negative)
}

/// Margin at a judged pose: breakaway less load in the direction of the load, mean over three phases of the cogging a third of a
/// period apart, over which its fundamental cancels. Where between them the axis will stand nobody knows: the amplitude that
/// the phases show is in the uncertainty, as that of a cosine at an unknown phase (arcsine distribution, u = A/√2; JCGM 101:2008,
/// 6.4.6).
fn margin(
    findings: &Findings<'_>,
    contact: Option<&Contact>,
    asked_rad: f64,
    phases: Vec<Result<Phase<'_>, Reason>>,
) -> Measurement {
    let at = |achieved| Condition { name: "pose".to_owned(), requested: asked_rad, achieved, kind: Q::Angle };
    let all: Result<Vec<Phase<'_>>, Reason> = phases.into_iter().collect();
    match all.and_then(|all| mean_margin(findings, contact, &all)) {
        Ok(found) => Measurement { conditions: vec![at(Some(asked_rad))], ..found },
        Err(reason) => {
            let mut none = findings.none("hold-margin", Q::Torque, HOLD_ESTIMATOR, reason);
            none.conditions = vec![at(None)];
            none
        }
    }
}

fn mean_margin(
    findings: &Findings<'_>,
    contact: Option<&Contact>,
    phases: &[Phase<'_>],
) -> Result<Measurement, Reason> {
    if phases.len() != 3 {
        return Err(FrictionReason::FewPhases { found: phases.len() }.into());
    }
    let down = phases.iter().filter(|phase| phase.weaker() == Direction::Negative).count();
    let direction = if down >= 2 { Direction::Negative } else { Direction::Positive };
    let peaks: Vec<&Peak> = phases.iter().map(|p| p.in_direction(direction)).collect::<Result<_, _>>()?;
    let torque_nm: Vec<f64> = peaks.iter().map(|peak| peak.torque_nm).collect();
    let margin_nm = mean(&torque_nm);
    // Three samples of a cosine a third of a period apart: the sum of their squares about the mean is 3/2·A².
    let squares: f64 = torque_nm.iter().map(|t| (t - margin_nm).powi(2)).sum();
    let amplitude_nm = (2.0 / 3.0 * squares).sqrt();
    let each = |peak: &&Peak| Component { u: peak.u_nm / 3.0, dof: peak.dof as f64 };
    let noise = combine(&peaks.iter().map(each).collect::<Vec<_>>());
    let per_ln_z_ss_nm = mean(&peaks.iter().map(|peak| peak.per_ln_z_ss_nm).collect::<Vec<_>>());
    let spread = combine(&[
        noise,
        Component::known(per_ln_z_ss_nm * contact.map_or(0.0, |c| c.z_ss_u_ratio)),
        Component::known(amplitude_nm / 2.0_f64.sqrt()),
        findings.torque_constant(margin_nm),
        findings.quantum(),
    ]);
    let mut m = findings.measurement("hold-margin", Q::Torque, margin_nm, spread, 3, HOLD_ESTIMATOR);
    let slid: Vec<&str> = phases.iter().filter_map(|p| p.slid).map(Direction::word).collect();
    m.flags.push(match slid.first() {
        None => format!("held its position when released; the {} direction is the weaker", direction.word()),
        Some(word) => format!("slid in the {word} direction when released, at {} of 3 phases", slid.len()),
    });
    m.flags.push(format!("cogging {} over the phases", Q::Torque.format(amplitude_nm)));
    m.evidence = phases.iter().flat_map(|p| p.evidence.iter().cloned()).collect();
    Ok(m)
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

/// The axis slid off: in that direction its breakaway is minus the largest torque that accelerates it over 3…8 z_ss, so a measured
/// number too.
fn slide(release: &Release, contact: &Contact) -> Result<(Direction, Peak), Reason> {
    let course = Course::slide(release);
    let driving_nm: Vec<f64> = course.effort_nm.iter().map(|f| -f).collect();
    let peak = peak(&course.x_rad, &driving_nm, contact.z_ss_rad, SLIDING)
        .map_err(FrictionReason::SlidOffReleased)?;
    Ok((course.direction, Peak { torque_nm: -peak.torque_nm, ..peak }))
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
            format!("Holds without power over the whole travel {} ({basis}).", degrees(&travel_rad))
        } else {
            let list = stretches.iter().map(degrees).collect::<Vec<_>>().join(", ");
            format!(
                "Holding without power is not certain at {list} ({basis}; uncertainty counted against it)."
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
            soft.remark(TRAVEL).starts_with("Holds without power over the whole travel -10.0 … 90.0 deg")
        );
        let stiff = Curve::over(&poses(54.0), None).expect("seven poses hold");
        insta::assert_snapshot!(stiff.remark(TRAVEL), @"Holding without power is not certain at -10.0 … 9.0 deg, 87.0 … 90.0 deg (computed from 7 poses, model [1, cos θ, θ], static friction 43.0 N·m, cogging 0.0 N·m on top of the load; uncertainty counted against it).");
    }

    #[test]
    fn four_poses_give_no_curve() {
        assert!(Curve::over(&poses(20.0)[..4], None).is_none());
    }
}
