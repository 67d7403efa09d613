//! Whether the axis holds itself without torque: measured at poses, computed over the travel.

use analysis::breakaway::{Peak, peak};
use analysis::dwell::mean;
use analysis::least_squares::LinearFit;
use analysis::load_map::LoadMap;
use analysis::uncertainty::{Component, combine};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::conclude::{Findings, Planned, condition};
use super::plan::RELEASE;
use super::point::{BreakawayPoint, Release};
use super::ramps::{Contact, Course};
use super::{Direction, plots};
use crate::measurement::{Conclusion, Measurement};
use crate::quantity::QuantityKind as Q;

/// Estimator and version.
const ESTIMATOR: &str = "hold-release/1";
/// Fewest poses of the computed curve: three coefficients and two degrees of freedom for their spread.
const FEWEST_POSES: usize = 5;
/// Step over the travel, rad: half a degree.
const STEP_RAD: f64 = std::f64::consts::PI / 360.0;

/// One pose.
pub(super) struct Pose {
    pub(super) pose_rad: f64,
    /// Hold margin.
    pub(super) margin_nm: f64,
    /// Standard uncertainty of the margin.
    pub(super) u_nm: f64,
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
pub(super) fn conclude(findings: &Findings<'_>, conclusion: &mut Conclusion) {
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
                let mut none = findings.none("hold-margin", Q::Torque, ESTIMATOR, reason);
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
    conclusion.plots.push(plots::hold(&poses, curve.as_ref(), findings.limits.travel_rad));
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
) -> Result<Course, String> {
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
) -> Result<(Measurement, Pose), String> {
    let point = planned.reduced()?;
    let contact = contact.ok_or("z_ss unknown: the exponential fit converged for no ramp")?;
    let release = point.release.as_ref().ok_or("the point has no release")?;
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
    let mut m = findings.measurement("hold-margin", Q::Torque, margin.margin_nm, spread, 1, ESTIMATOR);
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
fn held(point: &BreakawayPoint, contact: &Contact) -> Result<Margin, String> {
    let broken = |direction: Direction| Course::ramp(point, direction, |_| 0.0)?.peak(contact.z_ss_rad);
    let up = broken(Direction::Positive)?;
    let down = broken(Direction::Negative)?;
    let (weaker, peak) =
        if down.torque_nm < up.torque_nm { (Direction::Negative, down) } else { (Direction::Positive, up) };
    let flag = format!("stayed put when released; {} direction is the weaker", weaker.word());
    Ok(Margin { margin_nm: peak.torque_nm, peak, flag })
}

/// The axis slid off: minus the largest torque that accelerates it over 3…8 z_ss, so a measured number too.
fn slide(release: &Release, contact: &Contact) -> Result<Margin, String> {
    let course = Course::slide(release);
    let driving_nm: Vec<f64> = course.effort_nm.iter().map(|f| -f).collect();
    let peak = peak(&course.x_rad, &driving_nm, contact.z_ss_rad)
        .map_err(|e| format!("does not hold: it slid off when released, and {e}"))?;
    let flag = format!("does not hold: slid off in {} direction when released", course.direction.word());
    Ok(Margin { margin_nm: -peak.torque_nm, peak, flag })
}

/// Unbalance and spring over the travel against static friction: net torque `[1, cos θ, θ]` over the angle and the
/// friction that must hold it.
pub(super) struct Curve {
    fit: LinearFit,
    /// Coverage factor for 95 %.
    k_factor: f64,
    friction_nm: f64,
    cogging_nm: f64,
    poses: usize,
}

/// Margin that the curve leaves at an angle.
pub(super) struct CurveMargin {
    /// Friction less |net| less cogging.
    pub(super) margin_nm: f64,
    /// Expanded uncertainty, 95 %.
    pub(super) expanded_u_nm: f64,
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
    pub(super) fn margin(&self, angle_rad: f64) -> CurveMargin {
        let row = [1.0, angle_rad.cos(), angle_rad];
        CurveMargin {
            margin_nm: self.friction_nm - self.fit.at(&row).abs() - self.cogging_nm,
            expanded_u_nm: self.k_factor * self.fit.u_at(&row),
        }
    }

    /// Angles on the grid over the travel.
    pub(super) fn angles(travel_rad: [f64; 2]) -> Vec<f64> {
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
