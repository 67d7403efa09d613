//! One run: what a model of steady friction and loads misses, direction by direction.

use analysis::estimate::Estimate;
use analysis::residual::{Residual, residual};
use analysis::uncertainty::{Component, combine};

use super::keys::Keys;
use super::{MEAN, MEASURANDS, RMS};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::friction::hysteresis::Branches;
use crate::log::Window;
use crate::measurement::{Condition, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::Reason;
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

/// Friction in steady sliding (Canudas de Wit et al. 1995), unbalance and spring, SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Model {
    pub(super) coulomb_nm: f64,
    pub(super) static_nm: f64,
    pub(super) stribeck_rad_per_s: f64,
    pub(super) shape_ratio: f64,
    pub(super) viscous_nm_s_per_rad: f64,
    pub(super) unbalance_nm: f64,
    pub(super) spring_nm_per_rad: f64,
    pub(super) rest_rad: f64,
}

impl Model {
    /// Motor torque that keeps the axis at a rate that is not zero, at an angle: director.md §3 and §8 (motor sign).
    pub(super) fn motor_nm(&self, angle_rad: f64, rate_rad_per_s: f64) -> f64 {
        let fall = (-(rate_rad_per_s / self.stribeck_rad_per_s).abs().powf(self.shape_ratio)).exp();
        let sliding_nm = self.coulomb_nm + (self.static_nm - self.coulomb_nm) * fall;
        let friction_nm = sliding_nm.copysign(rate_rad_per_s) + self.viscous_nm_s_per_rad * rate_rad_per_s;
        let load_nm =
            self.unbalance_nm * angle_rad.cos() - self.spring_nm_per_rad * (angle_rad - self.rest_rad);
        friction_nm - load_nm
    }
}

const ESTIMATOR: &str = "model-check/1";
/// Directions, with the words for them.
const WAYS: [(f64, &str); 2] = [(1.0, "growing angle"), (-1.0, "falling angle")];

/// Motor torque less inertia less model, one direction.
struct Way {
    sign: f64,
    label: &'static str,
    error_nm: Vec<f64>,
    /// Mean of the torque itself: what the torque constant scales.
    torque_nm: f64,
}

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult::of(case);
    let limits = match axes.limits(&case.axis) {
        Ok(limits) => limits,
        Err(missing) => return PointResult { inconclusive: Some(missing.into()), ..result },
    };
    let branches = match Branches::read(case, window, limits) {
        Ok(branches) => branches,
        Err(nothing) => {
            return without(result, case, nothing.achieved_rad_per_s, &nothing.reason);
        }
    };
    let ways = ways(keys, &branches);
    for way in &ways {
        match residual(&way.error_nm, branches.bins_per_period) {
            Ok(found) => result.measurements.extend(measured(case, &branches, way, &found)),
            Err(reason) => {
                return without(result, case, Some(branches.achieved_rad_per_s), &reason.into());
            }
        }
    }
    result.excluded.clone_from(&branches.excluded);
    result.plots.push(picture(case, &branches, &ways));
    result
}

fn ways(keys: &Keys, branches: &Branches) -> Vec<Way> {
    let error = |(&(sign, label), torque_nm): (&(f64, &'static str), &Vec<f64>)| {
        let rate = sign * branches.achieved_rad_per_s;
        let error_nm = branches.angle_rad.iter().zip(torque_nm);
        let error_nm = error_nm.map(|(&at, torque)| torque - keys.model.motor_nm(at, rate)).collect();
        let torque_nm = torque_nm.iter().sum::<f64>() / torque_nm.len().max(1) as f64;
        Way { sign, label, error_nm, torque_nm }
    };
    WAYS.iter().zip(&branches.torque_nm).map(error).collect()
}

fn measured(case: &Case, branches: &Branches, way: &Way, found: &Residual) -> [Measurement; 2] {
    let torque_constant = branches.scale.of_torque(way.torque_nm);
    let quantum = Component::known(branches.quantum_u_nm);
    // What shifts the mean shifts the root mean square by as much of it as the mean makes up.
    let share = if found.rms.value > 0.0 { (found.mean.value / found.rms.value).abs() } else { 0.0 };
    let with = |estimate: Estimate, share: f64| {
        let own = Component { u: estimate.u, dof: estimate.dof };
        let shifts = [torque_constant, quantum].map(|c| Component::known(share * c.u));
        let spread = combine(&[own, shifts[0], shifts[1]]);
        Estimate { u: spread.u, dof: spread.dof, ..estimate }
    };
    let averaged = format!("{} over whole cogging periods", Q::Torque.format(found.rms_of_periods));
    let describe = |name: &str, estimate, own: Vec<String>| Measurement {
        point: Some(case.point.clone()),
        conditions: vec![condition(case, way.sign, Some(branches.achieved_rad_per_s))],
        flags: [vec![way.label.to_owned()], own, branches.flags.clone()].concat(),
        excluded: branches.excluded.clone(),
        evidence: branches.evidence.clone(),
        ..Measurement::new(name, &case.axis, Q::Torque, Some(estimate), ESTIMATOR)
    };
    [describe(MEAN, with(found.mean, 1.0), Vec::new()), describe(RMS, with(found.rms, share), vec![averaged])]
}

/// The velocity of a direction, asked for and reached.
fn condition(case: &Case, sign: f64, achieved_rad_per_s: Option<f64>) -> Condition {
    Condition {
        name: "velocity".to_owned(),
        requested: sign * case.requested("velocity").unwrap_or(0.0),
        achieved: achieved_rad_per_s.map(|rate| sign * rate),
        kind: Q::AngularVelocity,
    }
}

fn without(mut result: PointResult, case: &Case, achieved: Option<f64>, reason: &Reason) -> PointResult {
    result.measurements = WAYS
        .iter()
        .flat_map(|&(sign, label)| {
            MEASURANDS.iter().map(move |m| Measurement {
                point: Some(case.point.clone()),
                conditions: vec![condition(case, sign, achieved)],
                flags: vec![label.to_owned()],
                ..Measurement::inconclusive(m.name, &case.axis, m.kind, ESTIMATOR, reason)
            })
        })
        .collect();
    result.inconclusive = Some(reason.to_owned());
    result
}

/// What the model misses over the angle.
fn picture(case: &Case, branches: &Branches, ways: &[Way]) -> Plot {
    let angle: Vec<f64> = branches.angle_rad.iter().map(|&rad| Q::Angle.to_display(rad)).collect();
    let series = |way: &Way| Series::thinned(way.label, Style::Line, [&angle, &way.error_nm], MAX_POINTS);
    let plot = Plot::new(
        format!("model-error-{}", case.axis),
        format!("Torque not explained by the model: {}", case.point),
        Scale::linear("angle", Q::Angle.display_unit()),
        Scale::linear("motor torque less inertia less model", Q::Torque.display_unit()),
    );
    Plot { series: ways.iter().map(series).collect(), ..plot }
}
