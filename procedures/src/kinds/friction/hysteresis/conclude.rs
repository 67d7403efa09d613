//! Over all points: friction over velocity, unbalance and spring, cogging, remarks.

use std::fmt::Display;

use analysis::estimate::Estimate;
use analysis::goodness::BY_SCATTER;
use analysis::gravity::{Gravity, LargestSpring, MOST_INFLATION, unbalance_of_poses};
use analysis::stribeck::{LEAST_POINTS, NoCurve, Point, StribeckFit, ViscousLine};
use analysis::uncertainty::{Component, combine, rectangular_u};

use super::cogging;
use super::pictures::{friction_curve, half_sum, spectrum};
use super::point::SlidingPoint;
use super::sweep::Sweep;
use super::{COULOMB, SHAPE, SPRING, STATIC, STIFFNESS, STRIBECK, UNBALANCE, VISCOUS};
use crate::axis::{Axes, AxisLimits, TorqueScale, warming};
use crate::case::Case;
use crate::measurement::{Conclusion, Evidence, Exclusion, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::FrictionReason;

/// Velocities from which friction over velocity is worth a picture.
const LEAST_VELOCITIES: usize = 3;
/// Estimators and versions of friction over velocity.
const CURVE_ESTIMATOR: &str = "stribeck/1";
const LINE_ESTIMATOR: &str = "viscous-line/1";
/// Fastest point that counts for unbalance and spring (director study, erratum E23): 10 deg/s, with a margin for the last
/// digit.
pub(super) const FASTEST_FOR_GRAVITY_RAD_PER_S: f64 = 10.001 * std::f64::consts::PI / 180.0;
/// Whole cogging periods that a point needs for unbalance and spring.
const LEAST_PERIODS: usize = 6;
/// Estimators and versions of unbalance and spring.
const GRAVITY_ESTIMATOR: &str = "gravity-spring/4";
const POSES_ESTIMATOR: &str = "opposite-poses/2";

/// What the procedure says in the end.
pub(super) fn conclude(sweep: &Sweep, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut conclusion = Conclusion::default();
    for point in points {
        conclusion.measurements.extend(point.measurements.iter().cloned());
        conclusion.plots.extend(point.plots.iter().cloned());
    }
    let Some(axis) = cases.first().map(|case| case.axis.as_str()) else { return conclusion };
    let Some(limits) = axes.get(axis) else { return conclusion };
    let sliding: Vec<&SlidingPoint> = points.iter().filter_map(|p| p.reduced.get()).collect();
    if let Some(curve) = FrictionCurve::new(&sliding) {
        let planned = cases.iter().filter(|c| c.requested("pose").is_none_or(|pose| pose == 0.0)).count();
        let rates = cases.iter().filter_map(|case| case.requested("velocity"));
        let fastest_rad_per_s = rates.map(f64::abs).fold(0.0, f64::max);
        conclusion.measurements.extend(curve.measure(axis, planned, fastest_rad_per_s));
        if planned >= LEAST_VELOCITIES {
            conclusion.remarks.push(curve.remark());
            conclusion.plots.extend(friction_curve(&curve, points));
        }
    }
    if sweep.gives_gravity() {
        add_gravity(axis, limits, &sliding, &mut conclusion);
    }
    if sweep.gives_cogging() {
        let slowest = cogging::slowest(&sliding, limits);
        conclusion.measurements.extend(cogging::measure(axis, limits, slowest.as_ref()));
        conclusion.plots.extend(slowest.as_ref().map(spectrum));
    }
    for point in sliding {
        conclusion.remarks.extend(point.offset.map(|offset| {
            let offset = point.kind.format(offset);
            format!("Half the sum of the means of both directions, {}: {offset}.", point.name)
        }));
    }
    conclusion
}

/// Measurands of the curve, as [`analysis::stribeck::Parameters::as_array`] orders them.
const PARAMETERS: [(&str, Q); 5] = [
    (COULOMB, Q::Torque),
    (STATIC, Q::Torque),
    (STRIBECK, Q::AngularVelocity),
    (VISCOUS, Q::Damping),
    (SHAPE, Q::Ratio),
];
/// Measurands that a line alone does not determine.
const OF_CURVE_ALONE: [(&str, Q); 3] =
    [(STATIC, Q::Torque), (STRIBECK, Q::AngularVelocity), (SHAPE, Q::Ratio)];

/// Share of the fastest planned velocity that must have been reached for a line of Coulomb and viscous friction.
const REACHED_RATIO: f64 = 0.9;

/// Friction over velocity, and what was fitted to it: Stribeck parameters, or Coulomb and viscous friction alone.
pub(super) struct FrictionCurve {
    pub(super) points: Vec<Point>,
    pub(super) fitted: Result<StribeckFit, NoCurve>,
    /// The fastest points as a line, where the curve could not be fitted.
    pub(super) line: Option<ViscousLine>,
    scale: TorqueScale,
    evidence: Vec<Evidence>,
}

impl FrictionCurve {
    /// Fits the points that have torque and velocity; `None` if there is none.
    fn new(sliding: &[&SlidingPoint]) -> Option<Self> {
        let torque = || sliding.iter().filter(|p| p.kind == Q::Torque && p.friction.is_some());
        let point = |p: &&SlidingPoint| {
            let friction = p.friction?;
            Some(Point {
                velocity_rad_per_s: p.achieved_rad_per_s?,
                friction_nm: friction.effort,
                u_nm: friction.own_u,
            })
        };
        let points: Vec<Point> = torque().filter_map(point).collect();
        if points.is_empty() {
            return None;
        }
        let fitted = StribeckFit::new(&points);
        let line = if fitted.is_err() { ViscousLine::new(&points) } else { None };
        let scale = torque().next().map_or(TorqueScale::NONE, |p| p.scale);
        let evidence = torque().flat_map(|p| p.evidence.iter().cloned()).collect();
        Some(Self { points, fitted, line, scale, evidence })
    }

    /// Parameters as far as they are determined; `planned` is the number of velocities of the sweep, the last argument the
    /// fastest of them.
    fn measure(&self, axis: &str, planned: usize, fastest_rad_per_s: f64) -> Vec<Measurement> {
        let why = match &self.fitted {
            Ok(fit) => return self.measure_fit(axis, fit),
            Err(why) => why,
        };
        let Some(line) = &self.line else { return Vec::new() };
        let from = Q::AngularVelocity.format(line.from_rad_per_s);
        let mut all = Vec::new();
        let reached_rad_per_s = self.points.iter().map(|p| p.velocity_rad_per_s).fold(0.0, f64::max);
        if reached_rad_per_s < REACHED_RATIO * fastest_rad_per_s {
            let reason = FrictionReason::SlowOnly { reached_rad_per_s, fastest_rad_per_s };
            let line = [(COULOMB, Q::Torque), (VISCOUS, Q::Damping)];
            return line
                .into_iter()
                .chain(OF_CURVE_ALONE.into_iter().filter(|_| planned >= LEAST_POINTS))
                .map(|(name, kind)| Measurement::inconclusive(name, axis, kind, LINE_ESTIMATOR, &reason))
                .collect();
        }
        for (name, kind, [value, u]) in
            [(COULOMB, Q::Torque, line.coulomb_nm), (VISCOUS, Q::Damping, line.viscous_nm_s_per_rad)]
        {
            let own = Component { u, dof: line.dof };
            let mut one =
                Measurement::new(name, axis, kind, Some(self.estimate(kind, value, own)), LINE_ESTIMATOR);
            one.evidence.clone_from(&self.evidence);
            one.flags.push(format!("{} velocities from {from} on", line.points_count));
            one.rest_on(&line.goodness);
            all.push(one);
        }
        if planned >= LEAST_POINTS {
            for (name, kind) in OF_CURVE_ALONE {
                let reason = FrictionReason::NoCurve { why: why.clone() };
                all.push(Measurement::inconclusive(name, axis, kind, CURVE_ESTIMATOR, reason));
            }
        }
        all
    }

    /// All five parameters.
    fn measure_fit(&self, axis: &str, fit: &StribeckFit) -> Vec<Measurement> {
        let mut all = Vec::new();
        for (k, value) in fit.parameters.as_array().into_iter().enumerate() {
            let (name, kind) = PARAMETERS[k];
            let own = Component { u: fit.u(k), dof: fit.dof_count as f64 };
            let mut one =
                Measurement::new(name, axis, kind, Some(self.estimate(kind, value, own)), CURVE_ESTIMATOR);
            one.evidence.clone_from(&self.evidence);
            if fit.misfit_nm > 0.0 {
                let misfit = Q::Torque.format(fit.misfit_nm);
                one.flags.push(format!(
                    "points deviate from the curve by {misfit} (rms) beyond their uncertainty"
                ));
            }
            all.push(one);
        }
        all
    }

    /// A parameter with its own spread and that of the torque constant, which scales all torques alike and neither
    /// velocity nor shape.
    fn estimate(&self, kind: Q, value: f64, own: Component) -> Estimate {
        let largest_nm = self.points.iter().map(|p| p.friction_nm).fold(0.0, f64::max);
        let shared = match kind {
            Q::Torque => self.scale.of_torque(value),
            Q::Damping => self.scale.share(value, largest_nm),
            _ => TorqueScale::NONE.of_torque(value),
        };
        let spread = combine(&[own, shared]);
        Estimate { value, u: spread.u, dof: spread.dof, n: self.points.len() }
    }

    /// What the report says of the curve below the table.
    fn remark(&self) -> String {
        match &self.fitted {
            Ok(_) => "Static torque and the Stribeck curve are those of steady sliding: ageing of the contact (φ = D_c/|ω|) belongs to them."
                .to_owned(),
            Err(NoCurve::TooFew { found }) => format!(
                "Static torque, Stribeck velocity and Stribeck shape: not determined ({found} velocities, {LEAST_POINTS} needed)."
            ),
            Err(why) => {
                format!("Static torque, Stribeck velocity and Stribeck shape: not determined ({why}).")
            }
        }
    }
}

/// The point that separates unbalance and spring best, with its fit.
pub(super) struct SeparatingPoint<'a> {
    pub(super) point: &'a SlidingPoint,
    pub(super) fit: Gravity,
}

/// Unbalance and spring of the procedure, with their picture and remark.
fn add_gravity(axis: &str, limits: &AxisLimits, sliding: &[&SlidingPoint], conclusion: &mut Conclusion) {
    let best = SeparatingPoint::of(sliding);
    conclusion.measurements.extend(match &best {
        Some(best) => best.measure(axis, limits),
        None => no_gravity(axis, &FrictionReason::NoSlowPoint { least: LEAST_PERIODS }),
    });
    conclusion.measurements.extend(unbalance_from_poses(axis, sliding));
    let Some(best) = best else { return };
    conclusion.plots.push(half_sum(&best));
    let [stiffness, _] = best.fit.stiffness_nm_per_rad();
    let [torque, u] = best.fit.spring_nm(0.0);
    conclusion.remarks.push(format!(
        "Spring torque at 0 deg is {} (u {}), stiffness {}: its rest angle comes from the constant of the \
         fit alone, so a torque offset of the drive and friction that differs by direction would count as spring.",
        Q::Torque.format(torque),
        Q::Torque.format(u),
        Q::Stiffness.format(stiffness)
    ));
}

/// Unbalance, spring torque and stiffness without values.
fn no_gravity(axis: &str, reason: impl Display + Copy) -> Vec<Measurement> {
    [(UNBALANCE, Q::Torque), (SPRING, Q::Torque), (STIFFNESS, Q::Stiffness)]
        .map(|(name, kind)| Measurement::inconclusive(name, axis, kind, GRAVITY_ESTIMATOR, reason))
        .to_vec()
}

impl<'a> SeparatingPoint<'a> {
    /// The point at ≤ 10 °/s with the least variance inflation; the slower of equals (to 1 %).
    fn of(sliding: &[&'a SlidingPoint]) -> Option<Self> {
        let mut best: Option<Self> = None;
        for &point in sliding {
            let slow = point.achieved_rad_per_s.is_some_and(|v| v <= FASTEST_FOR_GRAVITY_RAD_PER_S * 1.05)
                && asked_slowly(point);
            if !slow || point.kind != Q::Torque || point.half_sum.torque_nm.len() < LEAST_PERIODS {
                continue;
            }
            let Ok(fit) = Gravity::new(&point.half_sum) else { continue };
            let better = |b: &Self| fit.inflation_factor() < 0.99 * b.fit.inflation_factor();
            if best.as_ref().is_none_or(better) {
                best = Some(Self { point, fit });
            }
        }
        best
    }

    /// Unbalance, spring torque and stiffness, or why not.
    fn measure(&self, axis: &str, limits: &AxisLimits) -> Vec<Measurement> {
        let inflation = self.fit.inflation_factor();
        if inflation > MOST_INFLATION {
            let reason = FrictionReason::NotSeparated { inflation, most: MOST_INFLATION };
            return no_gravity(axis, &reason).into_iter().map(|m| self.described(m)).collect();
        }
        self.values(axis, limits)
    }

    /// A measurement with what is known of the point and the fit behind it.
    fn described(&self, mut m: Measurement) -> Measurement {
        m.point = Some(self.point.name.clone());
        m.conditions.clone_from(&self.point.conditions);
        m.evidence.clone_from(&self.point.evidence);
        m.flags.push(format!("variance inflation {:.1}", self.fit.inflation_factor()));
        self.point.half_sum.angles_rad().into_iter().for_each(|angles_rad| m.set_angles(angles_rad));
        if self.point.unsettled_count > 0 {
            let reason = "the loop had not settled there in one of the directions".to_owned();
            m.excluded.push(Exclusion {
                count: self.point.unsettled_count,
                of: "cogging periods".to_owned(),
                reason,
            });
        }
        m
    }

    /// The three values of a fit that stands.
    fn values(&self, axis: &str, limits: &AxisLimits) -> Vec<Measurement> {
        let [unbalance_nm, unbalance_u_nm] = self.fit.unbalance_nm();
        let [stiffness, stiffness_u] = self.fit.stiffness_nm_per_rad();
        let found = self.fit.largest_spring(limits.travel_rad);
        // A spring that is at rest on the travel has no more than its stiffness over all of it for a constant.
        let whole_nm = stiffness.abs() * (limits.travel_rad[1] - limits.travel_rad[0]);
        let by_direction_nm = (DIRECTION_SHARE * self.point.friction_nm()).min(whole_nm);
        // Where friction grows with the angle, what it differs by in both directions grows, too.
        let by_slope = rectangular_u(DIRECTION_SHARE * self.point.friction_slope_per_rad.abs());
        // What grows with time grows with the angle one way and against it the other way, as a spring does.
        let by_warming = warming(self.point.kelvin_per_rad).u * self.point.friction_nm().abs();
        let systematic_u = by_slope.hypot(by_warming);
        let spring_u_nm = found
            .u_nm
            .hypot(rectangular_u(by_direction_nm))
            .hypot(systematic_u * self.lever_rad(&found, limits));
        let mut unbalance = self.value(UNBALANCE, axis, Q::Torque, unbalance_nm.abs(), unbalance_u_nm);
        let mut spring = self.value(SPRING, axis, Q::Torque, found.torque_nm, spring_u_nm);
        for m in [&mut unbalance, &mut spring] {
            if m.value.is_some_and(|value| value <= 2.0 * m.u) {
                m.flags.push("zero within U".to_owned());
            }
        }
        spring.flags.push(format!("largest at {}", Q::Angle.format(found.at_rad)));
        if found.beyond_nm > 2.0 * found.u_nm {
            let beyond = Q::Torque.format(found.beyond_nm);
            spring
                .flags
                .push(format!("a constant of {beyond} belongs to no spring that is at rest on the travel"));
        }
        vec![
            unbalance,
            spring,
            self.value(STIFFNESS, axis, Q::Stiffness, stiffness, stiffness_u.hypot(systematic_u)),
        ]
    }

    /// Over which angle a stiffness adds to the spring torque: from the middle of what was measured, or from the rest angle.
    fn lever_rad(&self, found: &LargestSpring, limits: &AxisLimits) -> f64 {
        match self.point.half_sum.angles_rad() {
            Some([from, to]) if found.beyond_nm == 0.0 => (found.at_rad - 0.5 * (from + to)).abs(),
            _ => limits.travel_rad[1] - limits.travel_rad[0],
        }
    }

    fn value(&self, name: &str, axis: &str, kind: Q, value: f64, u: f64) -> Measurement {
        let quantum_u = if kind == Q::Torque { self.point.quantum_u } else { 0.0 };
        let spread = combine(&[
            Component { u, dof: self.fit.dof_count() },
            Component::known(quantum_u),
            self.point.scale.share(value, value.abs() + self.point.friction_nm()),
        ]);
        let n = self.point.half_sum.torque_nm.len();
        let estimate = Estimate { value, u: spread.u, dof: spread.dof, n };
        let mut m = self.described(Measurement::new(name, axis, kind, Some(estimate), GRAVITY_ESTIMATOR));
        m.flags.push(BY_SCATTER.to_owned());
        m
    }
}

/// Half of what friction may differ by in both directions, as a share of it, half-width of a rectangular distribution (ours). It
/// leaves a constant in the half-sum, as a spring does.
const DIRECTION_SHARE: f64 = 0.05;

/// Whether a point was asked for at a velocity that counts for unbalance and spring.
fn asked_slowly(point: &SlidingPoint) -> bool {
    point.requested("velocity").is_some_and(|v| v <= FASTEST_FOR_GRAVITY_RAD_PER_S)
}

/// Unbalance from two opposite poses at the same velocity, if there are any.
fn unbalance_from_poses(axis: &str, sliding: &[&SlidingPoint]) -> Option<Measurement> {
    let turned = |p: &SlidingPoint| p.requested("pose").is_some_and(|pose| pose != 0.0);
    let opposite = sliding.iter().find(|p| asked_slowly(p) && turned(p))?;
    let velocity = opposite.requested("velocity");
    let pose =
        sliding.iter().find(|p| p.requested("velocity") == velocity && p.requested("pose") == Some(0.0))?;
    let periods = pose.half_sum.torque_nm.len().min(opposite.half_sum.torque_nm.len());
    if periods < LEAST_PERIODS {
        let reason = FrictionReason::NoSlowPoint { least: LEAST_PERIODS };
        return Some(Measurement::inconclusive(UNBALANCE, axis, Q::Torque, POSES_ESTIMATOR, reason));
    }
    let middle = pose.half_sum.middle(periods);
    let [value, u, dof] = unbalance_of_poses(&middle, &opposite.half_sum.middle(periods)).ok()?;
    let spread = combine(&[
        Component { u, dof },
        Component::known(pose.quantum_u),
        pose.scale.share(value, value.abs() + pose.friction_nm()),
    ]);
    let estimate = Estimate { value: value.abs(), u: spread.u, dof: spread.dof, n: 2 * periods };
    let mut m = Measurement::new(UNBALANCE, axis, Q::Torque, Some(estimate), POSES_ESTIMATOR);
    m.conditions = pose.conditions.iter().filter(|c| c.name == "velocity").cloned().collect();
    m.evidence = pose.evidence.iter().chain(&opposite.evidence).cloned().collect();
    m.flags.push("half the difference of two opposite poses".to_owned());
    middle.angles_rad().into_iter().for_each(|angles_rad| m.set_angles(angles_rad));
    Some(m)
}
