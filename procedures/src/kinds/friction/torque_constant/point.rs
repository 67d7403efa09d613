//! One point: torque over angle, by the gauge or by the current.

use std::f64::consts::TAU;

use analysis::derivative::Differentiator;
use analysis::even_rows::EvenRows;
use analysis::plateau::{longest_steady, mean_velocity_rad_per_s};
use analysis::stillness::stillness;

use super::ESTIMATOR;
use super::PULLED;
use super::keys::Keys;
use super::plan::{LEAST_PERIODS, PULL, ZERO};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::kinds::friction::hysteresis::Branches;
use crate::log::Window;
use crate::measurement::{PointResult, Reduced};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};

/// Topic and channel of the gauge.
pub(super) const TOPIC: &str = "/force";
pub(super) const CHANNEL: &str = "force_n";

/// Torque over angle while somebody pulled in one direction.
pub(super) struct Pulled {
    pub(super) angle_rad: Vec<f64>,
    pub(super) torque_nm: Vec<f64>,
    /// Mean rate, a magnitude.
    pub(super) rate_rad_per_s: f64,
    /// Standard uncertainty of the torque from the gauge's zero.
    pub(super) zero_u_nm: f64,
    pub(super) span_s: [f64; 2],
}

/// Torque by the current over angle, in both directions.
pub(super) struct Driven {
    pub(super) angle_rad: Vec<f64>,
    pub(super) growing_nm: Vec<f64>,
    pub(super) falling_nm: Vec<f64>,
    /// Mean rate, a magnitude.
    pub(super) rate_rad_per_s: f64,
    /// Standard uncertainty of the torque from the drive's quantum.
    pub(super) quantum_u_nm: f64,
    pub(super) span_s: [f64; 2],
}

/// Pulled: rate within this of what was asked for.
const STEADY_RATIO: f64 = 0.1;
/// Part of a cogging period over which a rate is a mean.
const RATE_SHARE: f64 = 0.25;
/// Acceleration is followed up to this frequency: the cogging of a slow pull is below 1 Hz.
const FLAT_HZ: f64 = 5.0;
/// A gauge whose zero wanders by more than this share of the largest pull is being pulled at.
const ZERO_SHARE: f64 = 0.02;

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let reduced = axes.limits(&case.axis).map_err(Reason::from).and_then(|limits| match case.pull {
        Some(_) => pulled(keys, case, window, limits).map(Reduced::to),
        None => driven(case, window, limits).map(Reduced::to),
    });
    match reduced {
        Ok(reduced) => PointResult { reduced, ..PointResult::of(case) },
        Err(reason) => PointResult::without(case, &[(PULLED, Q::Torque)], ESTIMATOR, reason),
    }
}

fn driven(case: &Case, window: &Window, limits: &AxisLimits) -> Result<Driven, Reason> {
    // What an ampere is worth is what is looked for here: the current counts as the rig file says.
    let by_the_rig_file = AxisLimits { measured_constant: None, ..limits.clone() };
    let branches = Branches::read(case, window, &by_the_rig_file).map_err(|nothing| nothing.reason)?;
    let [growing_nm, falling_nm] = branches.torque_nm;
    Ok(Driven {
        angle_rad: branches.angle_rad,
        growing_nm,
        falling_nm,
        rate_rad_per_s: branches.achieved_rad_per_s,
        quantum_u_nm: branches.quantum_u_nm,
        span_s: branches.evidence.first().map_or([0.0; 2], |e| [e.t0_s, e.t1_s]),
    })
}

fn pulled(keys: &Keys, case: &Case, window: &Window, limits: &AxisLimits) -> Result<Pulled, Reason> {
    let gauge = window.topic(TOPIC).map_err(|missing| FrictionReason::NoGauge { missing })?;
    let force_n = gauge.channel(CHANNEL).map_err(|missing| FrictionReason::NoGauge { missing })?;
    let before = window.segment(case, ZERO)?;
    let during = window.segment(case, PULL)?;
    let rest = gauge.range(before.start_s, before.end_s);
    let zero = stillness(&gauge.time_s[rest.clone()], &force_n[rest]).map_err(FrictionReason::Zero)?;
    let lasts_s = before.end_s - before.start_s;
    let wanders_n = zero.noise.value + zero.drift_per_s.value.abs() * lasts_s;
    if keys.arm_m * wanders_n > ZERO_SHARE * keys.pull_nm {
        return Err(FrictionReason::PulledEarly.into());
    }
    let axis = window.topic(&format!("/{}", case.axis))?;
    let range = axis.range(during.start_s, during.end_s);
    let rows = EvenRows::over(&axis.time_s[range.clone()])
        .filter(|rows| rows.unbridged(FLAT_HZ).is_none())
        .ok_or(FrictionReason::RowsMissingInPull)?;
    let time = rows.time_s();
    let angle = &rows.column(&axis.channel("position_rad")?[range]);
    let rate_hz = 1.0 / rows.sample_s();
    let wanted = case.requested("velocity").ok_or(FrictionReason::NoVelocity)?;
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let count = (RATE_SHARE * period_rad / wanted.abs() * rate_hz).round() as usize;
    let steady = longest_steady(angle, rate_hz, wanted, count, STEADY_RATIO);
    let covered = match &angle[steady.clone()] {
        [first, .., last] => (last - first).abs(),
        _ => 0.0,
    };
    if covered < LEAST_PERIODS * period_rad {
        return Err(FrictionReason::NobodyPulled { least: LEAST_PERIODS }.into());
    }
    let acceleration = Differentiator::new(rate_hz, FLAT_HZ.min(rate_hz / 16.0))
        .and_then(|d| d.acceleration(angle))
        .ok_or(FrictionReason::PullTooShort)?;
    let newest = |t: f64| gauge.time_s.partition_point(|own| *own <= t).checked_sub(1);
    let torque = steady.clone().map(|k| {
        let force = force_n[newest(time[k])?] - zero.mean.value;
        Some(keys.arm_m * force * wanted.signum() - limits.inertia_kg_m2 * acceleration[k])
    });
    let torque: Option<Vec<f64>> = torque.collect();
    let torque =
        torque.filter(|t| t.iter().all(|nm| nm.is_finite())).ok_or(FrictionReason::GaugeNoNumbers)?;
    Ok(Pulled {
        rate_rad_per_s: mean_velocity_rad_per_s(&angle[steady.clone()], rate_hz).abs(),
        zero_u_nm: keys.arm_m * zero.mean.u,
        span_s: [time[steady.start], time[steady.end - 1]],
        angle_rad: angle[steady].to_vec(),
        torque_nm: torque,
    })
}
