//! Whether friction is the same in both directions and at all angles, of a point that ran.

use analysis::angle_map::period_means;
use analysis::estimate::Estimate;
use analysis::least_squares::LinearFit;
use analysis::peaks::deviation_by_median;
use analysis::uncertainty::{Component, combine};

use super::point::Finding;
use super::{DIRECTIONS, UNEVENNESS};
use crate::axis::TorqueScale;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;

const ESTIMATOR: &str = "hysteresis-evenness/2";

/// Cogging periods below which a point says nothing of how even friction is over the angle: their scatter would rest on fewer than
/// five degrees of freedom.
const LEAST_PERIODS: usize = 6;

/// Difference by direction and unevenness over the angle, under the conditions of the point's friction, or with the reason
/// why that has no value; nothing of a static map and of currents, and no unevenness of a span of a few periods.
pub(super) fn measure(finding: &Finding, friction: &Measurement, scale: TorqueScale) -> Vec<Measurement> {
    if finding.static_map || friction.kind != Q::Torque {
        return Vec::new();
    }
    let one = |name: &str, kind: Q, found: Option<Estimate>| {
        let mut m = Measurement {
            point: friction.point.clone(),
            conditions: friction.conditions.clone(),
            excluded: friction.excluded.clone(),
            evidence: friction.evidence.clone(),
            inconclusive: friction.inconclusive.clone(),
            ..Measurement::new(name, &friction.axis, kind, found, ESTIMATOR)
        };
        friction.angles_rad.into_iter().for_each(|angles_rad| m.set_angles(angles_rad));
        m
    };
    let known = finding.friction.as_ref();
    let mut all =
        vec![one(DIRECTIONS, Q::Torque, known.map(|friction| difference(finding, friction, scale)))];
    if known.is_none() || finding.half_sum.torque_nm.len() >= LEAST_PERIODS {
        all.push(one(UNEVENNESS, Q::Ratio, known.map(|friction| unevenness(finding, friction))));
    }
    all
}

/// Half the sum of both directions has the scatter of half their difference.
fn difference(finding: &Finding, friction: &Estimate, scale: TorqueScale) -> Estimate {
    let halves = &finding.half_sum.torque_nm;
    let value = (halves.iter().sum::<f64>() / halves.len().max(1) as f64).abs();
    let spread = combine(&[
        Component { u: friction.u, dof: friction.dof },
        Component::known(finding.quantum_u),
        scale.of_torque(value),
    ]);
    Estimate { value, u: spread.u, dof: spread.dof, n: friction.n }
}

/// What the largest mean may have from the ends of the strokes, where the loop still settles, and from a load that changes along them;
/// half-width of a rectangular distribution (ours: up to 2 % on drawn units without a spot).
const OF_STROKES: f64 = 0.02;
/// Share of itself by which a spot may seem higher: friction slows the axis there, and changes with the rate (half-width, ours).
const OF_RATE: f64 = 0.1;

/// The largest mean over one cogging period, wherever it begins. Half of the periods lie within the middle half of their scatter: what
/// a spot adds is no scatter.
fn unevenness(finding: &Finding, friction: &Estimate) -> Estimate {
    let periods = Periods::new(finding);
    let value = periods.largest / friction.value - 1.0;
    let dof = (finding.half_sum.torque_nm.len() as f64 - 1.0).max(1.0);
    let spread = combine(&[
        Component { u: periods.scatter / friction.value, dof },
        Component::rectangular(OF_STROKES),
        Component::rectangular(OF_RATE * value.abs()),
    ]);
    Estimate { value, u: spread.u, dof: spread.dof, n: friction.n }
}

/// Share of friction above which a period stands out of the others ...
const SPOT_SHARE: f64 = 0.01;
/// ... if it is so many times their scatter, too.
const SPOT_SCATTERS: f64 = 5.0;

/// Friction by the cogging period, half the difference of both directions.
pub(super) struct Periods {
    /// Mean over each period.
    means: Vec<f64>,
    /// Mean over the period with the most friction, wherever it begins.
    largest: f64,
    /// Scatter of the means of periods side by side.
    scatter: f64,
}

impl Periods {
    pub(super) fn new(finding: &Finding) -> Self {
        let count = finding.half_sum.torque_nm.len().max(1);
        let bins = (finding.forward.effort.len() / count).max(1);
        let both = finding.forward.effort.iter().zip(&finding.reverse.effort);
        let local: Vec<f64> = both.map(|(forward, reverse)| 0.5 * (forward - reverse)).collect();
        let means = period_means(&local, bins);
        let anywhere = local.windows(bins).map(|window| window.iter().sum::<f64>() / bins as f64);
        Self {
            largest: anywhere.fold(f64::NEG_INFINITY, f64::max),
            scatter: deviation_by_median(&means),
            means,
        }
    }

    /// Whether friction is larger at a spot of the strokes. The contact takes z_ss to follow a change of friction along its way, so
    /// the spot lies as much further on in each direction, and half the sum of both directions has its slope left in it.
    pub(super) fn has_spot(&self, finding: &Finding) -> bool {
        if finding.static_map || finding.half_sum.torque_nm.len() < LEAST_PERIODS {
            return false;
        }
        let mean = self.means.iter().sum::<f64>() / self.means.len().max(1) as f64;
        self.largest - mean > (SPOT_SHARE * mean).max(SPOT_SCATTERS * self.scatter)
    }

    /// Growth of friction with the angle, per radian: slope of a straight line through the periods; 0 where there is no line.
    pub(super) fn slope_per_rad(&self, finding: &Finding) -> f64 {
        let angles_rad = &finding.half_sum.angle_rad;
        if self.means.len() != angles_rad.len() {
            return 0.0;
        }
        let columns = [vec![1.0; angles_rad.len()], angles_rad.clone()];
        LinearFit::new(&columns, &self.means, None).map_or(0.0, |line| line.coefficients[1])
    }
}
