//! Cogging: the spectrum of one point, and the measurements of the procedure.

use std::f64::consts::TAU;

use analysis::angle_map::Grid;
use analysis::cogging::{Amplitude, Beside, Branch, Harmonic, Settings, Spectrum};
use analysis::derivative::Differentiator;
use analysis::estimate::Estimate;
use analysis::goodness::BY_SCATTER;
use analysis::uncertainty::{Component, combine, rectangular_u};

use super::peak;
use super::point::{Cogging, Finding, SlidingPoint};
use super::strokes::Maps;
use super::{AMPLITUDE, AMPLITUDE_CURRENT, HARMONIC, HARMONIC_CURRENT, ORDER, PEAK, PHASE};
use crate::axis::AxisLimits;
use crate::measurement::{Condition, Measurement};
use crate::quantity::QuantityKind as Q;
use crate::reason::FrictionReason;

/// Whole periods that a spectrum needs.
pub(super) const LEAST_PERIODS: usize = 8;
/// Bins in a period that a spectrum needs.
const LEAST_BINS: usize = 16;
/// Orders are looked at up to this share of the flat bandwidth of α (gain error there 0.13 %).
const BANDWIDTH_SHARE: f64 = 0.6;
/// Orders are looked at up to this multiple of the expected order, or up to [`MOST_ORDER`] where that is more.
const MOST_HARMONIC: f64 = 8.0;
/// See [`MOST_HARMONIC`].
const MOST_ORDER: f64 = 256.0;
/// The cogging line is looked for between these multiples of the expected order.
const NEAR: [f64; 2] = [0.7, 1.4];
/// Estimator and version.
const ESTIMATOR: &str = "cogging-spectrum/2";
/// Error of the encoder once per revolution, amplitude: POS-ACC allows 75 urad between its ends. It stretches the angle by as much
/// relative to it, and shifts it; half-width of a rectangular distribution.
const ENCODER_ERROR_RAD: f64 = 37.5e-6;

/// Highest order worth looking at.
pub(super) fn most_order(limits: &AxisLimits) -> f64 {
    (MOST_HARMONIC * limits.cogging_orders_per_rev).max(MOST_ORDER)
}

/// Adds the spectrum of strokes, if there are periods, bins and bandwidth enough.
pub(super) fn add_of_strokes(
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

/// Adds the spectrum of a static map on part of a turn.
pub(super) fn add_of_map(maps: &Maps, grid: &Grid, limits: &AxisLimits, finding: &mut Finding) {
    finding.spectrum = spectrum(maps, grid, most_order(limits));
}

fn spectrum(maps: &Maps, grid: &Grid, most_order_per_rev: f64) -> Option<Spectrum> {
    if grid.periods_count < LEAST_PERIODS || grid.bins_per_period_count < LEAST_BINS {
        return None;
    }
    Spectrum::new(&branches(maps, grid), &settings(grid, most_order_per_rev))
}

/// What the rate has at the harmonics of the effort, rad/s.
pub(super) fn rates_at(spectrum: &Spectrum, rates: &Maps, grid: &Grid) -> Option<Vec<Beside>> {
    // The harmonics are given: the highest order to look at is of no account.
    spectrum.beside(&branches(rates, grid), &settings(grid, 0.0))
}

fn branches(maps: &Maps, grid: &Grid) -> Vec<Branch> {
    let branch = |reverse: bool, map: &Vec<f64>| Branch {
        reverse,
        angle_rad: grid.centres_rad(),
        value: map.clone(),
        weight: vec![1.0; map.len()],
    };
    let forward = maps.forward.iter().map(|m| branch(false, m));
    forward.chain(maps.reverse.iter().map(|m| branch(true, m))).collect()
}

fn settings(grid: &Grid, most_order_per_rev: f64) -> Settings {
    Settings {
        span_rad: grid.span_rad(),
        full_turn: false,
        most_order_per_rev,
        bin_width_rad: grid.width_rad(),
    }
}

/// A point with its spectrum.
pub(super) struct WithSpectrum<'a> {
    pub(super) point: &'a SlidingPoint,
    pub(super) cogging: &'a Cogging,
    slope: Slope,
}

/// How friction changes with velocity about that of a point, N·m·s/rad (or A·s/rad).
#[derive(Clone, Copy, Debug, Default)]
struct Slope {
    /// Between this velocity and the next faster one; 0 without one.
    known: f64,
    /// How far from it the slope may be.
    half_width: f64,
}

/// Where velocities do not show the slope of friction: in the Stribeck region it is not more than this part of friction over
/// velocity ((T_S − T_C)·δ/e for T_S − T_C up to a fifth of friction and δ up to 3) ...
const STRIBECK_SHARE: f64 = 0.25;
/// ... and viscous friction at the largest velocity of the axis is not more than so many times as large (ours; the director's axes
/// have 1.7 and 2.1 times).
const VISCOUS_SHARE: f64 = 4.0;

impl Slope {
    /// From this point and the two that are next faster, in the order of their velocities.
    fn new(point: &SlidingPoint, points: &[&SlidingPoint], limits: &AxisLimits) -> Self {
        let Some(own) = Sliding::new(point) else { return Self::default() };
        let faster = points.iter().filter(|p| p.kind == point.kind).filter_map(|p| Sliding::new(p));
        let mut faster: Vec<Sliding> =
            faster.filter(|p| p.velocity_rad_per_s > 1.1 * own.velocity_rad_per_s).collect();
        faster.sort_by(|a, b| a.velocity_rad_per_s.total_cmp(&b.velocity_rad_per_s));
        match &faster[..] {
            [] => {
                let of_velocity = STRIBECK_SHARE / own.velocity_rad_per_s;
                let viscous = VISCOUS_SHARE / limits.max_velocity_rad_per_s;
                Self { known: 0.0, half_width: own.friction * (of_velocity + viscous) }
            }
            [next, others @ ..] => {
                let [known, u] = own.chord(next);
                let further = others.first().map_or(0.0, |other| next.chord(other)[0]);
                Self { known, half_width: known.abs().max(further.abs()) + u }
            }
        }
    }
}

/// Friction at a velocity.
struct Sliding {
    velocity_rad_per_s: f64,
    friction: f64,
    u: f64,
}

impl Sliding {
    fn new(point: &SlidingPoint) -> Option<Self> {
        let velocity_rad_per_s = point.achieved_rad_per_s.filter(|rate| *rate > 0.0)?;
        let friction = point.friction?;
        Some(Self { velocity_rad_per_s, friction: friction.effort, u: friction.own_u })
    }

    /// Slope between this velocity and a faster one, and its standard uncertainty.
    fn chord(&self, faster: &Self) -> [f64; 2] {
        let over_rad_per_s = faster.velocity_rad_per_s - self.velocity_rad_per_s;
        [(faster.friction - self.friction) / over_rad_per_s, self.u.hypot(faster.u) / over_rad_per_s]
    }
}

/// The slowest point with a spectrum (a static map counts as slowest).
pub(super) fn slowest<'a>(points: &[&'a SlidingPoint], limits: &AxisLimits) -> Option<WithSpectrum<'a>> {
    let speed = |found: &WithSpectrum<'_>| found.point.achieved_rad_per_s.unwrap_or(0.0);
    let with_spectrum = |&point: &&'a SlidingPoint| {
        let cogging = point.cogging.as_ref()?;
        Some(WithSpectrum { point, cogging, slope: Slope::new(point, points, limits) })
    };
    points.iter().filter_map(with_spectrum).min_by(|a, b| speed(a).total_cmp(&speed(b)))
}

/// Measurements from the slowest point that has a spectrum.
pub(super) fn measure(
    axis: &str,
    limits: &AxisLimits,
    slowest: Option<&WithSpectrum<'_>>,
) -> Vec<Measurement> {
    match slowest {
        Some(slowest) => {
            let peak = slowest.peak(axis, limits);
            let mut all = [slowest.main_line(axis, limits), vec![peak], slowest.harmonics(axis)].concat();
            all.iter_mut().filter(|m| m.value.is_some()).for_each(|m| m.flags.push(BY_SCATTER.to_owned()));
            all
        }
        None => {
            let reason = FrictionReason::NoCogging { least: LEAST_PERIODS };
            vec![
                Measurement::inconclusive(ORDER, axis, Q::SpatialOrder, ESTIMATOR, &reason),
                Measurement::inconclusive(AMPLITUDE, axis, Q::Torque, ESTIMATOR, &reason),
                Measurement::inconclusive(PEAK, axis, Q::Torque, peak::ESTIMATOR, reason),
            ]
        }
    }
}

impl WithSpectrum<'_> {
    /// Order and amplitude of the largest line near the expected order.
    fn main_line(&self, axis: &str, limits: &AxisLimits) -> Vec<Measurement> {
        let kind = self.point.kind;
        let spectrum = &self.cogging.spectrum;
        let amplitude_name = if kind == Q::Torque { AMPLITUDE } else { AMPLITUDE_CURRENT };
        let expected = limits.cogging_orders_per_rev;
        let near = NEAR[0] * expected..NEAR[1] * expected;
        let Some(line) = spectrum.largest_in(near.clone()) else {
            let reason = FrictionReason::NoLine { from: near.start, to: near.end };
            return vec![
                Measurement::inconclusive(ORDER, axis, Q::SpatialOrder, ESTIMATOR, &reason),
                Measurement::inconclusive(amplitude_name, axis, kind, ESTIMATOR, reason),
            ];
        };
        let amplitude = self.estimate(&self.cogging_line(line));
        let stretched = rectangular_u(ENCODER_ERROR_RAD * line.order_per_rev);
        let order =
            Estimate { value: line.order_per_rev, u: line.order_u_per_rev.hypot(stretched), ..amplitude };
        let mut order = self.measurement(ORDER, axis, Q::SpatialOrder, order);
        let mut amplitude = self.measurement(amplitude_name, axis, kind, amplitude);
        let largest = spectrum.largest_in(0.0..f64::INFINITY);
        if let Some(other) = largest.filter(|o| o.at_order_per_rev != line.at_order_per_rev) {
            let flag = format!("order {:.0} is larger", other.at_order_per_rev);
            order.flags.push(flag.clone());
            amplitude.flags.push(flag);
        }
        vec![order, amplitude]
    }

    /// Amplitude and phase of every harmonic; of a static map in each direction, too.
    fn harmonics(&self, axis: &str) -> Vec<Measurement> {
        let mut all = Vec::new();
        for harmonic in &self.cogging.spectrum.harmonics {
            all.extend(self.line(axis, harmonic, &self.cogging_line(harmonic), None));
            if self.cogging.static_map {
                let forward = harmonic.forward.iter();
                all.extend(forward.flat_map(|a| self.line(axis, harmonic, a, Some(1.0))));
                let reverse = harmonic.reverse.iter();
                all.extend(reverse.flat_map(|a| self.line(axis, harmonic, a, Some(-1.0))));
            }
        }
        all
    }

    /// Amplitude and phase of one harmonic, in one direction or as the mean of both.
    fn line(
        &self,
        axis: &str,
        harmonic: &Harmonic,
        amplitude: &Amplitude,
        direction: Option<f64>,
    ) -> [Measurement; 2] {
        let kind = self.point.kind;
        let name = if kind == Q::Torque { HARMONIC } else { HARMONIC_CURRENT };
        let estimate = self.estimate(amplitude);
        let shifted_rad = rectangular_u(ENCODER_ERROR_RAD * harmonic.at_order_per_rev);
        let phase = Estimate {
            value: amplitude.phase_rad,
            u: (amplitude.u / amplitude.amplitude).hypot(shifted_rad),
            ..estimate
        };
        let condition = |name: &str, value: f64, kind: Q| Condition {
            name: name.to_owned(),
            requested: value,
            achieved: Some(value),
            kind,
        };
        [self.measurement(name, axis, kind, estimate), self.measurement(PHASE, axis, Q::Angle, phase)].map(
            |mut m| {
                m.conditions.push(condition("order", harmonic.at_order_per_rev, Q::SpatialOrder));
                m.conditions.extend(direction.map(|d| condition("direction", d, Q::Count)));
                m
            },
        )
    }

    /// The line of the cogging alone. Cogging makes the rate ripple, and friction follows the rate: the ripple of friction is in the
    /// mean of both directions, too. It is taken off as far as the slope of friction is known. What the slope may be off counts with
    /// the ripple of a single direction, because friction that lags does not cancel as the mean of the rate may.
    pub(super) fn cogging_line(&self, harmonic: &Harmonic) -> Amplitude {
        let (left, of_slope) = self.freed_of_friction(harmonic);
        let spread = combine(&[Component { u: left.u, dof: left.dof }, of_slope]);
        Amplitude { u: spread.u, dof: spread.dof, ..left }
    }

    /// The line of the cogging with its own noise, and what the slope of friction may be off: the same slope for every line.
    pub(super) fn freed_of_friction(&self, harmonic: &Harmonic) -> (Amplitude, Component) {
        let harmonics = &self.cogging.spectrum.harmonics;
        let index = harmonics.iter().position(|h| h.at_order_per_rev == harmonic.at_order_per_rev);
        let rate = index.and_then(|k| self.cogging.rate_lines_rad_per_s.get(k)).copied().unwrap_or_default();
        let left = harmonic.mean.less(self.slope.known * rate.mean);
        (left, Component::rectangular(self.slope.half_width * rate.largest))
    }

    fn estimate(&self, amplitude: &Amplitude) -> Estimate {
        let value = amplitude.amplitude;
        let spread = combine(&[
            Component { u: amplitude.u, dof: amplitude.dof },
            self.point.scale.share(value, self.point.friction_nm()),
            Component::rectangular(self.cogging.gain_error_ratio * value),
        ]);
        Estimate { value, u: spread.u, dof: spread.dof, n: self.cogging.points_count }
    }

    fn measurement(&self, name: &str, axis: &str, kind: Q, estimate: Estimate) -> Measurement {
        self.described(Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR))
    }

    /// With the point that it comes from.
    pub(super) fn described(&self, mut m: Measurement) -> Measurement {
        m.point = Some(self.point.name.clone());
        m.conditions.clone_from(&self.point.conditions);
        m.evidence.clone_from(&self.point.evidence);
        if m.value.is_some()
            && let Some(angles_rad) = self.point.half_sum.angles_rad()
        {
            m.set_angles(angles_rad);
        }
        m
    }
}
