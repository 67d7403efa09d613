//! One point: a record becomes two responses, these become modes.

use super::expected::Expected;
use super::fit::{self, Fitted, participation};
use super::responses::{self, Responses};
use super::{Keys, numbers, pictures};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::excited::{self, ELEVATION, Measured, conditions};
use crate::log::Window;
use crate::measurement::{Evidence, Measurement, PointResult};

/// What is read from a record before anything is fitted.
struct Read {
    measured: Measured,
    elevation_rad: f64,
    evidence: Vec<Evidence>,
}

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let requested_rad = case.requested(ELEVATION).unwrap_or(0.0);
    let read = match read(keys, case, window, axes) {
        Ok(read) => read,
        Err(reason) => return without(keys, case, requested_rad, &reason),
    };
    let cogging_orders_per_rev = axes.get(&case.axis).map_or(0.0, |limits| limits.cogging_orders_per_rev);
    let found = responses::read(&read.measured, cogging_orders_per_rev)
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

fn read(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> Result<Read, String> {
    let reading = excited::read(&keys.excited, case, window, axes)?;
    let elevation_rad = reading
        .elevation_rad
        .filter(|e| e.is_finite())
        .ok_or("the log does not say at which elevation it was taken")?;
    Ok(Read { measured: reading.measured, elevation_rad, evidence: reading.evidence })
}

/// A point whose modes cannot be told.
fn without(keys: &Keys, case: &Case, elevation_rad: f64, reason: &str) -> PointResult {
    let measurement = |e: &Expected| Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, None, None),
        inconclusive: Some(reason.to_owned()),
        ..numbers::not_visible(&case.axis, e, elevation_rad)
    };
    PointResult {
        point: case.point.clone(),
        measurements: keys.expected.iter().map(measurement).collect(),
        inconclusive: Some(reason.to_owned()),
        ..PointResult::default()
    }
}

fn with(keys: &Keys, case: &Case, read: &Read, fitted: &Fitted, responses: &Responses) -> PointResult {
    let mut measurements = numbers::measurements(&case.axis, &keys.expected, fitted, read.elevation_rad);
    for measurement in &mut measurements {
        measurement.point = Some(case.point.clone());
        measurement.excluded = responses.excluded.clone();
    }
    let mut result = PointResult {
        point: case.point.clone(),
        measurements,
        plots: pictures::of_point(&case.point, responses, fitted, &keys.expected),
        excluded: responses.excluded.clone(),
        ..PointResult::default()
    };
    keep(fitted, &keys.expected, read.elevation_rad, &mut result);
    result
}

/// Numbers for what is said over all points: one entry a visible mode.
fn keep(fitted: &Fitted, expected: &[Expected], elevation_rad: f64, result: &mut PointResult) {
    let number = |k: usize| {
        let index = fitted.pairs.iter().position(|pair| *pair == Some(k));
        index.map_or(0.0, |i| expected[i].mode as f64)
    };
    let modes = &fitted.modal.modes;
    let share = |k: usize, sensor: usize| participation(&fitted.modal, k, sensor, fitted.apart).value;
    let mut put = |name: &str, of: &dyn Fn(usize) -> f64| {
        result.numbers.insert(name.to_owned(), fitted.visible.iter().map(|&k| of(k)).collect());
    };
    put("mode", &|k| number(k));
    put("hz", &|k| modes[k].frequency_hz);
    put("hz-u", &|k| modes[k].frequency_u_hz);
    put("damping", &|k| modes[k].damping.as_ref().map_or(0.0, |d| d.ratio));
    put("gyro", &|k| share(k, 0));
    put("encoder", &|k| share(k, 1));
    result.numbers.insert("elevation".to_owned(), vec![elevation_rad]);
    result.numbers.insert("delay-s".to_owned(), vec![fitted.modal.fit.delay_s, fitted.modal.fit.delay_u_s]);
    result.numbers.insert("misfit".to_owned(), vec![fitted.modal.fit.misfit_ratio()]);
    result.numbers.insert("inertia".to_owned(), vec![fit::rigid(&fitted.modal).recip()]);
}
