//! Whether the encoder follows its axis: play at reversals and slip, by the gyros.

use analysis::estimate::Estimate;
use analysis::goodness::BY_SCATTER;
use analysis::lost_motion::{LostMotion, Motion, bias_at_rest};
use analysis::uncertainty::{Component, combine};

use super::keys::SETTLE;
use super::point::{self, Spin};
use super::{PLAY, SLIP};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::inertial::Samples;
use crate::log::Window;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{InertialReason, Reason};

const ESTIMATOR: &str = "lost-motion/3";
const KINDS: [(&str, Q); 2] = [(PLAY, Q::Angle), (SLIP, Q::Ratio)];

/// Both without a value, and why.
pub(super) fn without(case: &Case, reason: &Reason) -> Vec<Measurement> {
    PointResult::without(case, &KINDS, ESTIMATOR, reason.clone()).measurements
}

/// Play and slip of a spin; the bias of the gyros comes from the rest before it.
pub(super) fn measure(case: &Case, window: &Window, axes: &Axes, spin: &Spin) -> Vec<Measurement> {
    let found = match found(case, window, axes, spin) {
        Ok(found) => found,
        Err(reason) => return without(case, &reason),
    };
    let both = KINDS.into_iter().zip([found.play_rad, found.slip_ratio]);
    let passed_rad = spin.samples.passed_rad(spin.turning);
    let measurement = |((name, kind), estimate): ((&str, Q), _)| {
        let mut m = Measurement {
            point: Some(case.point.clone()),
            conditions: point::conditions(case, spin),
            evidence: spin.samples.evidence(),
            ..Measurement::new(name, &case.axis, kind, Some(estimate), ESTIMATOR)
        };
        m.set_angles(passed_rad);
        m.flags.push(BY_SCATTER.to_owned());
        m
    };
    both.map(measurement).collect()
}

fn found(case: &Case, window: &Window, axes: &Axes, spin: &Spin) -> Result<LostMotion, Reason> {
    let rest = window.segment(case, SETTLE)?;
    let rest = Samples::read(window, axes, rest.start_s, rest.end_s)?;
    let still = about_axis(&point::along(&rest), spin);
    let bias = bias_at_rest(Motion {
        encoder_rad_per_s: &rest.axis_rates()[spin.turning],
        gyro_rad_per_s: &still,
        period_s: rest.period_s,
    });
    let bias = bias.ok_or(InertialReason::Gaps)?;
    let motion = Motion {
        encoder_rad_per_s: &spin.rate_rad_per_s,
        gyro_rad_per_s: &about_axis(&spin.along, spin),
        period_s: spin.samples.period_s,
    };
    let found = LostMotion::new(motion, &bias)?;
    Ok(LostMotion { play_rad: with_structure(found.play_rad), ..found })
}

/// What the structure adds between encoder and gyros at a reversal, not modelled (ours, half-width): its bending lags behind the
/// acceleration. Elevations of drawn units without play or noise of the gyros read up to 1.6 µrad.
const STRUCTURE_RAD: f64 = 2e-6;

fn with_structure(play_rad: Estimate) -> Estimate {
    let own = Component { u: play_rad.u, dof: play_rad.dof };
    let structure = Component::rectangular(STRUCTURE_RAD);
    let both = combine(&[own, structure]);
    Estimate { u: both.u, dof: both.dof, ..play_rad }
}

/// Rate of the gyros about the axis that turns, out of those left, up and ahead.
fn about_axis(along: &[Vec<f64>; 3], spin: &Spin) -> Vec<f64> {
    let rate = |k: usize| (0..3).map(|d| along[d][k] * spin.expected[d]).sum();
    (0..along[0].len()).map(rate).collect()
}
