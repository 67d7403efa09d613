//! Cogging of one point as spectrum, and of the procedure as measurements.

use std::f64::consts::TAU;

use analysis::angle_map::Grid;
use analysis::cogging::{Amplitude, Branch, Harmonic, Settings, Spectrum};
use analysis::derivative::Differentiator;
use analysis::estimate::Estimate;
use analysis::uncertainty::{Component, combine};

use super::dynamic::Maps;
use super::measurands::{AMPLITUDE, AMPLITUDE_CURRENT, HARMONIC, HARMONIC_CURRENT, ORDER, PHASE};
use super::numbers::{Cogging, Valid};
use super::point::Finding;
use crate::axis::AxisLimits;
use crate::measurement::{Condition, Measurement};
use crate::quantity::QuantityKind as Q;

/// Whole periods that a spectrum needs.
pub(super) const LEAST_PERIODS: usize = 8;
/// Bins in a period that a spectrum needs.
const LEAST_BINS: usize = 16;
/// Orders are looked at up to this share of the flat bandwidth of α (gain error there 0.13 %).
const BANDWIDTH_SHARE: f64 = 0.6;
/// And up to this multiple of the expected order, or to [`MOST_ORDER`].
const MOST_HARMONIC: f64 = 8.0;
const MOST_ORDER: f64 = 256.0;
/// The expected order times these: where the cogging line is looked for.
const NEAR: [f64; 2] = [0.7, 1.4];
/// Estimator and version.
const ESTIMATOR: &str = "cogging-spectrum/1";

/// Highest order worth looking at.
pub(super) fn most_order(limits: &AxisLimits) -> f64 {
    (MOST_HARMONIC * limits.cogging_orders_per_rev).max(MOST_ORDER)
}

/// Spectrum of strokes, if there are periods, bins and bandwidth enough.
pub(super) fn of_strokes(
    maps: &Maps,
    grid: &Grid,
    velocity_rad_per_s: f64,
    differentiator: &Differentiator,
    limits: &AxisLimits,
    finding: &mut Finding,
) {
    let expected = limits.cogging_orders_per_rev;
    let followed = BANDWIDTH_SHARE * differentiator.flat_hz() * TAU / velocity_rad_per_s;
    if followed < 1.05 * expected {
        return;
    }
    finding.spectrum = spectrum(maps, grid, most_order(limits).min(followed));
    let frequency_hz = expected * velocity_rad_per_s / TAU;
    finding.gain_error_ratio = (1.0 - differentiator.acceleration_gain_ratio(frequency_hz)).abs();
}

/// Spectrum of a static map on part of a turn.
pub(super) fn of_map(maps: &Maps, grid: &Grid, limits: &AxisLimits, finding: &mut Finding) {
    finding.spectrum = spectrum(maps, grid, most_order(limits));
}

fn spectrum(maps: &Maps, grid: &Grid, most_order_per_rev: f64) -> Option<Spectrum> {
    if grid.periods_count < LEAST_PERIODS || grid.bins_per_period_count < LEAST_BINS {
        return None;
    }
    let branch = |reverse: bool, map: &Vec<f64>| Branch {
        reverse,
        angle_rad: grid.centres_rad(),
        value: map.clone(),
        weight: vec![1.0; map.len()],
    };
    let forward = maps.forward.iter().map(|m| branch(false, m));
    let branches: Vec<Branch> = forward.chain(maps.reverse.iter().map(|m| branch(true, m))).collect();
    let settings = Settings {
        span_rad: grid.span_rad(),
        full_turn: false,
        most_order_per_rev,
        bin_width_rad: grid.width_rad(),
    };
    Spectrum::new(&branches, &settings)
}

/// Measurements from the slowest point that has a spectrum.
pub(super) fn measure(axis: &str, limits: &AxisLimits, points: &[Valid<'_>]) -> Vec<Measurement> {
    let Some((point, cogging)) = slowest(points) else {
        let reason = format!(
            "no valid point with {LEAST_PERIODS} whole cogging periods at a velocity where the acceleration follows cogging"
        );
        return vec![
            Measurement::inconclusive(ORDER, axis, Q::SpatialOrder, ESTIMATOR, &reason),
            Measurement::inconclusive(AMPLITUDE, axis, Q::Torque, ESTIMATOR, reason),
        ];
    };
    let torque = point.kind == Q::Torque;
    let harmonic_name = if torque { HARMONIC } else { HARMONIC_CURRENT };
    let mut all = main_line(axis, limits, point, &cogging);
    for harmonic in &cogging.harmonics {
        let sides =
            [(None, Some(harmonic.mean)), (Some(1.0), harmonic.forward), (Some(-1.0), harmonic.reverse)];
        for (direction, amplitude) in sides {
            let Some(amplitude) = amplitude.filter(|_| direction.is_none() || cogging.static_map) else {
                continue;
            };
            let order = harmonic.at_order_per_rev;
            let estimate = estimate(&amplitude, point, &cogging);
            all.push(measurement(harmonic_name, axis, point.kind, estimate, point, Some((order, direction))));
            let u = amplitude.u / amplitude.amplitude;
            let phase = Estimate { value: amplitude.phase_rad, u, ..estimate };
            all.push(measurement(PHASE, axis, Q::Angle, phase, point, Some((order, direction))));
        }
    }
    all
}

/// The slowest point with a spectrum (a static map counts as slowest).
pub(super) fn slowest<'a, 'b>(points: &'a [Valid<'b>]) -> Option<(&'a Valid<'b>, Cogging)> {
    let speed = |p: &Valid<'_>| p.velocity_rad_per_s.unwrap_or(0.0);
    let with: Vec<&Valid<'_>> = points.iter().filter(|p| p.has_cogging()).collect();
    let slowest = with.into_iter().min_by(|a, b| speed(a).total_cmp(&speed(b)))?;
    Some((slowest, slowest.cogging()?))
}

/// Order and amplitude of the largest line near the expected order.
fn main_line(axis: &str, limits: &AxisLimits, point: &Valid<'_>, cogging: &Cogging) -> Vec<Measurement> {
    let expected = limits.cogging_orders_per_rev;
    let near = NEAR[0] * expected..NEAR[1] * expected;
    let torque = point.kind == Q::Torque;
    let amplitude_name = if torque { AMPLITUDE } else { AMPLITUDE_CURRENT };
    let largest_in = |range: &std::ops::Range<f64>| {
        let inside = cogging.harmonics.iter().filter(|h| range.contains(&h.at_order_per_rev));
        inside.reduce(|a, b| if b.mean.amplitude > a.mean.amplitude { b } else { a })
    };
    let Some(line) = largest_in(&near) else {
        let reason = format!("no line above noise between orders {:.0} and {:.0}", near.start, near.end);
        return vec![
            Measurement::inconclusive(ORDER, axis, Q::SpatialOrder, ESTIMATOR, &reason),
            Measurement::inconclusive(amplitude_name, axis, point.kind, ESTIMATOR, reason),
        ];
    };
    let amplitude = estimate(&line.mean, point, cogging);
    let order = Estimate { value: line.order_per_rev, u: line.order_u_per_rev, ..amplitude };
    let mut order = measurement(ORDER, axis, Q::SpatialOrder, order, point, None);
    let mut amplitude = measurement(amplitude_name, axis, point.kind, amplitude, point, None);
    if let Some(other) =
        largest_in(&(0.0..f64::INFINITY)).filter(|o| o.at_order_per_rev != line.at_order_per_rev)
    {
        let flag = format!("order {:.0} is larger", other.at_order_per_rev);
        order.flags.push(flag.clone());
        amplitude.flags.push(flag);
    }
    vec![order, amplitude]
}

fn estimate(amplitude: &Amplitude, point: &Valid<'_>, cogging: &Cogging) -> Estimate {
    let value = amplitude.amplitude;
    let spread = combine(&[
        Component { u: amplitude.u, dof: amplitude.dof },
        Component::known(point.scale_u_ratio * value),
        Component::known(cogging.gain_error_ratio * value / 3_f64.sqrt()),
    ]);
    Estimate { value, u: spread.u, dof: spread.dof, n: cogging.points_count }
}

fn measurement(
    name: &str,
    axis: &str,
    kind: Q,
    estimate: Estimate,
    point: &Valid<'_>,
    line: Option<(f64, Option<f64>)>,
) -> Measurement {
    let mut all = Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR);
    all.point = Some(point.name.to_owned());
    all.conditions = point.conditions.to_vec();
    all.evidence = point.evidence.to_vec();
    if let Some((order, direction)) = line {
        let condition = |name: &str, value: f64, kind: Q| Condition {
            name: name.to_owned(),
            requested: value,
            achieved: Some(value),
            kind,
        };
        all.conditions.push(condition("order", order, Q::SpatialOrder));
        all.conditions.extend(direction.map(|d| condition("direction", d, Q::Count)));
    }
    all
}

/// Harmonics for a picture: order and amplitude with u.
pub(super) fn markers(harmonics: &[Harmonic]) -> [Vec<f64>; 3] {
    [
        harmonics.iter().map(|h| h.at_order_per_rev).collect(),
        harmonics.iter().map(|h| h.mean.amplitude).collect(),
        harmonics.iter().map(|h| h.mean.u).collect(),
    ]
}
