//! One point: a record becomes two responses, these become modes, these become measurements.

use analysis::estimate::Estimate;
use analysis::modal::Mode;
use analysis::uncertainty::rectangular_u;

use super::assign::{Expected, Place};
use super::fit::{self, Fitted, Responses, SENSORS, participation};
use super::{Keys, pictures};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::response::excited::{self, ELEVATION, Measured, conditions};
use crate::log::Window;
use crate::measurement::{Evidence, Measurement, PointResult, Reduced};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};

/// What is read from a record before anything is fitted.
struct Read {
    measured: Measured,
    elevation_rad: f64,
    evidence: Vec<Evidence>,
}

/// The modes of one point, with what was fitted beside them.
#[derive(Clone, Debug, PartialEq)]
pub struct PointModes {
    /// Mean elevation of the point.
    pub elevation_rad: f64,
    /// Modes that are visible in a sensor, in ascending order of frequency.
    pub visible: Vec<VisibleMode>,
    /// Transport of both responses.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`.
    pub delay_u_s: f64,
    /// χ² of the fit over its degrees of freedom.
    pub misfit_ratio: f64,
    /// Inertia of the rigid axis.
    pub inertia_kg_m2: f64,
}

/// A mode that a sensor shows.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleMode {
    /// Number of the expected mode that it was taken for; `None` for one that was not expected.
    pub expected: Option<usize>,
    /// Natural frequency.
    pub frequency_hz: f64,
    /// Standard uncertainty of `frequency_hz`.
    pub frequency_u_hz: f64,
    /// Damping ratio, where it could be told.
    pub damping_ratio: Option<f64>,
    /// Share in the gyro's rate over that of the rigid axis.
    pub gyro: f64,
    /// Share in the encoder's rate over that of the rigid axis.
    pub encoder: f64,
}

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let requested_rad = case.requested(ELEVATION).unwrap_or(0.0);
    let read = match read(keys, case, window, axes) {
        Ok(read) => read,
        Err(reason) => return without(keys, case, requested_rad, &reason),
    };
    let cogging_orders_per_rev = axes.get(&case.axis).map_or(0.0, |limits| limits.cogging_orders_per_rev);
    let found = fit::read(&read.measured, cogging_orders_per_rev)
        .and_then(|responses| Ok((fit::fit(&responses, &keys.expected, read.elevation_rad)?, responses)));
    let mut result = match found {
        Ok((fitted, responses)) => with(keys, case, &read, &fitted, &responses),
        Err(reason) => without(keys, case, requested_rad, &reason),
    };
    result.excluded.splice(0..0, read.measured.excluded.clone());
    for measurement in &mut result.measurements {
        measurement.conditions = conditions(case, Some(read.elevation_rad), Some(&read.measured));
        measurement.evidence = read.evidence.clone();
        measurement.flags.push(format!("{} windows", read.measured.windows));
    }
    result
}

fn read(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> Result<Read, Reason> {
    let reading = excited::read(&keys.excited, case, window, axes)?;
    let elevation_rad = reading.elevation_rad.filter(|e| e.is_finite()).ok_or(ResponseReason::NoElevation)?;
    Ok(Read { measured: reading.measured, elevation_rad, evidence: reading.evidence })
}

/// A point whose modes cannot be told.
fn without(keys: &Keys, case: &Case, elevation_rad: f64, reason: &Reason) -> PointResult {
    let measurement = |e: &Expected| Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, None, None),
        inconclusive: Some(reason.to_string()),
        ..not_visible(&case.axis, e, elevation_rad)
    };
    let other = Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, None, None),
        ..Measurement::inconclusive(UNEXPECTED, &case.axis, Q::Ratio, ESTIMATOR, reason)
    };
    PointResult {
        point: case.point.clone(),
        measurements: keys.expected.iter().map(measurement).chain([other]).collect(),
        inconclusive: Some(reason.to_owned()),
        ..PointResult::default()
    }
}

fn with(keys: &Keys, case: &Case, read: &Read, fitted: &Fitted, responses: &Responses) -> PointResult {
    let mut measurements = measurements(&case.axis, &keys.expected, fitted, read.elevation_rad);
    for measurement in &mut measurements {
        measurement.point = Some(case.point.clone());
        measurement.excluded = responses.excluded.clone();
    }
    PointResult {
        measurements,
        plots: pictures::of_point(&case.point, responses, fitted, &keys.expected),
        excluded: responses.excluded.clone(),
        reduced: Reduced::to(visible(fitted, &keys.expected, read.elevation_rad)),
        ..PointResult::of(case)
    }
}

fn visible(fitted: &Fitted, expected: &[Expected], elevation_rad: f64) -> PointModes {
    let number = |k: usize| {
        let index = fitted.pairs.iter().position(|pair| *pair == Some(k));
        index.map(|i| expected[i].mode)
    };
    let share = |k: usize, sensor: usize| participation(&fitted.modal, k, sensor, fitted.apart).value;
    let mode = |&k: &usize| {
        let mode = &fitted.modal.modes[k];
        VisibleMode {
            expected: number(k),
            frequency_hz: mode.frequency_hz,
            frequency_u_hz: mode.frequency_u_hz,
            damping_ratio: mode.damping.as_ref().ok().map(|damping| damping.ratio),
            gyro: share(k, 0),
            encoder: share(k, 1),
        }
    };
    PointModes {
        elevation_rad,
        visible: fitted.visible.iter().map(mode).collect(),
        delay_s: fitted.modal.fit.delay_s,
        delay_u_s: fitted.modal.fit.delay_u_s,
        misfit_ratio: fitted.modal.fit.misfit_ratio(),
        inertia_kg_m2: fit::rigid(&fitted.modal).recip(),
    }
}

pub(super) const DAMPING: &str = "mode-damping";
pub(super) const PARTICIPATION: &str = "mode-participation";
pub(super) const UNEXPECTED: &str = "unexpected-mode-participation";
const ESTIMATOR: &str = "modes/3";
/// Modes above the last expected one by more than this are beyond the calculation.
const BEYOND_LAST: f64 = 1.2;

/// What the expected modes of a point measure.
pub(super) fn measurements(
    axis: &str,
    expected: &[Expected],
    fitted: &Fitted,
    elevation_rad: f64,
) -> Vec<Measurement> {
    let mut all = Vec::new();
    for (e, pair) in expected.iter().zip(&fitted.pairs) {
        match pair {
            Some(k) => {
                let other = other_of_two(e, expected, fitted, *k, elevation_rad);
                all.push(match other {
                    Some(reason) => {
                        Measurement::inconclusive(e.measurand(), axis, e.kind(), ESTIMATOR, reason)
                    }
                    None => frequency(axis, e, fitted, *k, elevation_rad),
                });
                all.push(damping(axis, e, fitted, *k));
                all.push(share(axis, e, fitted, *k));
            }
            None => all.push(not_visible(axis, e, elevation_rad)),
        }
    }
    all.push(unexpected(axis, expected, fitted, elevation_rad));
    all.iter_mut().filter(|m| m.value.is_some()).for_each(|m| m.rest_on(&fitted.goodness));
    all
}

/// The mode that nobody expected with the largest share in a sensor, up to a fifth above the last one that was expected: further up
/// nothing was calculated. One that was taken for an expected mode outside of the band of that mode counts, too.
fn unexpected(axis: &str, expected: &[Expected], fitted: &Fitted, elevation_rad: f64) -> Measurement {
    let last_hz = expected.iter().map(|e| e.range_hz(elevation_rad)[1]).fold(0.0, f64::max);
    let top_hz = BEYOND_LAST * last_hz;
    let is_other = |k: &&usize| {
        let hz = fitted.modal.modes[**k].frequency_hz;
        let of_expected = |(e, pair): (&Expected, &Option<usize>)| *pair == Some(**k) && e.allows(hz);
        hz <= top_hz && !expected.iter().zip(&fitted.pairs).any(of_expected)
    };
    let others = fitted.visible.iter().filter(is_other);
    let shares = others.flat_map(|&k| {
        [0, 1].map(|sensor| (k, sensor, participation(&fitted.modal, k, sensor, fitted.apart)))
    });
    let largest = shares.max_by(|a, b| a.2.value.abs().total_cmp(&b.2.value.abs()));
    let flag = match &largest {
        Some((k, sensor, _)) => {
            format!("{:.2} Hz, shown by the {}", fitted.modal.modes[*k].frequency_hz, SENSORS[*sensor])
        }
        None => format!("no other mode up to {top_hz:.1} Hz"),
    };
    let [value, u] = largest.map_or([0.0; 2], |(_, _, share)| [share.value.abs(), share.u]);
    let measured = estimate(fitted, value, u);
    Measurement {
        flags: vec![flag],
        ..Measurement::new(UNEXPECTED, axis, Q::Ratio, Some(measured), ESTIMATOR)
    }
}

/// Where two modes lie so close that one hides the other, nothing says which of them was found.
fn other_of_two(
    e: &Expected,
    expected: &[Expected],
    fitted: &Fitted,
    k: usize,
    elevation_rad: f64,
) -> Option<ResponseReason> {
    let found_hz = fitted.modal.modes[k].frequency_hz;
    let mut missing = expected.iter().zip(&fitted.pairs).filter(|(_, pair)| pair.is_none());
    let (other, _) = missing.find(|(other, _)| other.could_be(e, found_hz, elevation_rad))?;
    Some(ResponseReason::OneOfTwo { found_hz, mode: e.mode, other: other.mode })
}

/// Why an expected mode has no frequency.
fn not_visible(axis: &str, e: &Expected, elevation_rad: f64) -> Measurement {
    let reason = ResponseReason::NotVisible { mode: e.mode, range_hz: e.range_hz(elevation_rad) };
    Measurement::inconclusive(e.measurand(), axis, e.kind(), ESTIMATOR, reason)
}

fn estimate(fitted: &Fitted, value: f64, u: f64) -> Estimate {
    let n = fitted.modal.fit.dof / 2;
    Estimate { value, u, dof: fitted.modal.fit.dof as f64, n }
}

/// Half-width of what a sliding contact shifts the poles of a free structure by, as a ratio of frequency: ½·c·Im F/ω with c the
/// share of the mode in the encoder over the inertia and F what the bristles answer to changes of the rate. 1e-4 on units with
/// friction drawn within 20 %.
const CONTACT_RATIO: f64 = 1e-4;

fn frequency(axis: &str, e: &Expected, fitted: &Fitted, k: usize, elevation_rad: f64) -> Measurement {
    let mode = &fitted.modal.modes[k];
    let scale_hz = match e.place {
        Place::Curve(_) => e.range_hz(elevation_rad)[0],
        Place::Band(_) => 1.0,
    };
    let value = match e.place {
        Place::Curve(_) => mode.frequency_hz / scale_hz - 1.0,
        Place::Band(_) => mode.frequency_hz,
    };
    let by_contact_hz = rectangular_u(CONTACT_RATIO) * mode.frequency_hz;
    let measured = estimate(fitted, value, mode.frequency_u_hz.hypot(by_contact_hz) / scale_hz);
    let mut flags = vec![format!("found at {:.3} Hz", mode.frequency_hz)];
    if matches!(e.place, Place::Curve(_)) {
        flags.push(format!("expected at {scale_hz:.2} Hz"));
    }
    Measurement { flags, ..Measurement::new(e.measurand(), axis, e.kind(), Some(measured), ESTIMATOR) }
}

fn named(e: &Expected, mode: &Mode) -> String {
    format!("mode {} at {:.2} Hz", e.mode, mode.frequency_hz)
}

fn damping(axis: &str, e: &Expected, fitted: &Fitted, k: usize) -> Measurement {
    let mode = &fitted.modal.modes[k];
    let measurement = match &mode.damping {
        Ok(d) => {
            let measured = estimate(fitted, d.ratio, d.u);
            Measurement::new(DAMPING, axis, Q::Ratio, Some(measured), ESTIMATOR)
        }
        Err(reason) => Measurement::inconclusive(DAMPING, axis, Q::Ratio, ESTIMATOR, reason.to_string()),
    };
    Measurement { flags: vec![named(e, mode)], ..measurement }
}

fn share(axis: &str, e: &Expected, fitted: &Fitted, k: usize) -> Measurement {
    let [gyro, encoder] = [0, 1].map(|sensor| participation(&fitted.modal, k, sensor, fitted.apart));
    let measured = estimate(fitted, gyro.value, gyro.u);
    let other = format!("{} {:.4}, u {:.4}", SENSORS[1], encoder.value, encoder.u);
    Measurement {
        flags: vec![named(e, &fitted.modal.modes[k]), other],
        ..Measurement::new(PARTICIPATION, axis, Q::Ratio, Some(measured), ESTIMATOR)
    }
}
