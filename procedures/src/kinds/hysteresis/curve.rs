//! Friction over velocity: Stribeck parameters, or Coulomb and viscous friction alone.

use analysis::estimate::Estimate;
use analysis::stribeck::{LEAST_POINTS, NoCurve, Point, StribeckFit, ViscousLine};
use analysis::uncertainty::{Component, combine};

use super::measurands::{COULOMB, SHAPE, STATIC, STRIBECK, VISCOUS};
use super::numbers::Valid;
use crate::measurement::{Evidence, Measurement};
use crate::quantity::QuantityKind as Q;

/// Estimators and versions.
const ESTIMATOR: &str = "stribeck/1";
const LINE_ESTIMATOR: &str = "viscous-line/1";
/// Measurands of the curve in the order of its parameters.
const PARAMETERS: [(&str, Q); 5] = [
    (COULOMB, Q::Torque),
    (STATIC, Q::Torque),
    (STRIBECK, Q::AngularVelocity),
    (VISCOUS, Q::Damping),
    (SHAPE, Q::Ratio),
];

/// Friction by velocity and what was fitted to it.
pub(super) struct Curve {
    pub(super) points: Vec<Point>,
    pub(super) fit: Option<StribeckFit>,
    pub(super) line: Option<ViscousLine>,
    scale_u_ratio: f64,
    evidence: Vec<Evidence>,
    why_no_fit: Option<NoCurve>,
}

impl Curve {
    /// Fits the points that have torque and velocity; `None` if there is none.
    pub(super) fn new(valid: &[Valid<'_>]) -> Option<Self> {
        let torque = || valid.iter().filter(|p| p.kind == Q::Torque && p.friction.is_some());
        let point = |p: &Valid<'_>| {
            Some(Point { velocity_rad_per_s: p.velocity_rad_per_s?, friction_nm: p.friction?, u_nm: p.own_u })
        };
        let points: Vec<Point> = torque().filter_map(point).collect();
        if points.is_empty() {
            return None;
        }
        let (fit, why_no_fit) = match StribeckFit::new(&points) {
            Ok(fit) => (Some(fit), None),
            Err(why) => (None, Some(why)),
        };
        let line = if fit.is_none() { ViscousLine::new(&points) } else { None };
        let scale_u_ratio = torque().map(|p| p.scale_u_ratio).fold(0.0, f64::max);
        let evidence = torque().flat_map(|p| p.evidence.iter().cloned()).collect();
        Some(Self { points, fit, line, scale_u_ratio, evidence, why_no_fit })
    }

    /// Parameters as far as they are determined; `planned` is the number of velocities of the sweep.
    pub(super) fn measure(&self, axis: &str, planned: usize) -> Vec<Measurement> {
        if let Some(fit) = &self.fit {
            let values = fit.parameters.as_array();
            let estimates = (0..5).map(|k| {
                let spread = Component { u: fit.u(k), dof: fit.dof_count as f64 };
                self.parameter(k, axis, values[k], spread, ESTIMATOR)
            });
            return estimates.collect();
        }
        let mut all = Vec::new();
        let Some(line) = &self.line else { return all };
        for (k, [value, u]) in [(0, line.coulomb_nm), (3, line.viscous_nm_s_per_rad)] {
            let mut one = self.parameter(k, axis, value, Component { u, dof: line.dof }, LINE_ESTIMATOR);
            let from = Q::AngularVelocity.format(line.from_rad_per_s);
            one.flags.push(format!("{} velocities from {from} on", line.points_count));
            all.push(one);
        }
        if planned >= LEAST_POINTS {
            let why = self.why_no_fit.as_ref().map_or_else(String::new, ToString::to_string);
            for k in [1, 2, 4] {
                let (name, kind) = PARAMETERS[k];
                all.push(Measurement::inconclusive(
                    name,
                    axis,
                    kind,
                    ESTIMATOR,
                    format!("not determined: {why}"),
                ));
            }
        }
        all
    }

    fn parameter(&self, k: usize, axis: &str, value: f64, own: Component, estimator: &str) -> Measurement {
        let (name, kind) = PARAMETERS[k];
        // The torque constant scales all torques alike: no part of velocity and shape.
        let shared =
            if matches!(kind, Q::Torque | Q::Damping) { self.scale_u_ratio * value.abs() } else { 0.0 };
        let spread = combine(&[own, Component::known(shared)]);
        let estimate = Estimate { value, u: spread.u, dof: spread.dof, n: self.points.len() };
        let mut one = Measurement::new(name, axis, kind, Some(estimate), estimator);
        one.evidence.clone_from(&self.evidence);
        one
    }

    /// What the report should say below the table.
    pub(super) fn remarks(&self) -> Vec<String> {
        match (&self.fit, &self.why_no_fit) {
            (Some(_), _) => vec![
                "Static torque and the Stribeck curve are those of steady sliding: ageing of the contact (φ = D_c/|ω|) belongs to them."
                    .to_owned(),
            ],
            (None, Some(NoCurve::TooFew { found })) => vec![format!(
                "Static torque, Stribeck velocity and Stribeck shape: not determined ({found} velocities, {LEAST_POINTS} needed)."
            )],
            (None, Some(why)) => {
                vec![format!("Static torque, Stribeck velocity and Stribeck shape: not determined ({why}).")]
            }
            (None, None) => Vec::new(),
        }
    }
}
