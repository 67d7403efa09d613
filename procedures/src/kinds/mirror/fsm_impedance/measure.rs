//! One sweep: the circuit that fits it, and what it says of the mirror.

use std::f64::consts::TAU;

use analysis::circuit::{CircuitFit, Estimate as Fitted, Resonance};
use analysis::estimate::Estimate;
use analysis::frf::{C64, Line};

use super::keys::Keys;
use super::level::{self, Level};
use super::plan::{LEVEL, mirror_axis};
use super::plots;
use crate::case::Case;
use crate::log::{Rows, Window};
use crate::measurement::{Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const DEPARTURE: &str = "mirror-mode-departure";
pub(super) const MODE: &str = "mirror-mode";
pub(super) const DAMPING: &str = "mirror-mode-damping";
pub(super) const COUPLING: &str = "mirror-coupling";
pub(super) const CAPACITANCE: &str = "mirror-capacitance";

const ESTIMATOR: &str = "mirror-impedance/1";
/// Topic of the analyser, and its channels.
const TOPIC: &str = "/analyser";
const CHANNELS: [&str; 3] = ["frequency_hz", "resistance_ohm", "reactance_ohm"];

/// A sweep that was read and fitted.
struct Sweep {
    lines: Vec<Line>,
    fit: CircuitFit,
    /// Where the log holds voltage and current.
    level: Option<Level>,
    times_s: [f64; 2],
}

/// Departure of the first and last frequency from what was asked for: an instrument rounds to millihertz.
const FREQUENCY_RATIO: f64 = 1e-3;

/// Fits one sweep.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window) -> PointResult {
    let mut result = PointResult::of(case);
    let axis = mirror_axis(case);
    let expected_hz = keys.mirror_axes.iter().find(|(name, _)| name == axis).map_or(0.0, |(_, hz)| *hz);
    let mut level = None;
    match read(keys, window) {
        Ok(sweep) => {
            result.measurements = measurements(axis, &sweep, keys.range_hz[0], expected_hz);
            level = sweep.level;
            let said = level.as_ref().map_or_else(|| vec![level::UNKNOWN.to_owned()], Level::flags);
            result.measurements.iter_mut().for_each(|m| m.flags.extend(said.iter().cloned()));
            result.plots = plots::of(axis, &sweep.lines, &sweep.fit);
            let logged = if level.is_some() { &level::CHANNELS[..] } else { &[] };
            let channels = CHANNELS.iter().chain(logged).map(|c| format!("{TOPIC} {c}")).collect();
            let [t0_s, t1_s] = sweep.times_s;
            let evidence = Evidence::new(channels, [t0_s, t1_s]);
            result.measurements.iter_mut().for_each(|m| m.evidence.push(evidence.clone()));
        }
        Err(reason) => {
            result.measurements = none(axis, &reason, &[DEPARTURE, MODE, DAMPING, COUPLING, CAPACITANCE]);
            result.inconclusive = Some(reason);
        }
    }
    for m in &mut result.measurements {
        m.point = Some(case.point.clone());
        let name = LEVEL.to_owned();
        let requested = keys.level_v;
        let achieved = level.as_ref().map(|l| l.source_v(requested));
        m.conditions.push(Condition { name, requested, achieved, kind: Q::Voltage });
    }
    result
}

fn read(keys: &Keys, window: &Window) -> Result<Sweep, String> {
    let rows = window.rows(TOPIC).filter(|r| !r.time_s.is_empty());
    let rows = rows.ok_or("no impedance in the log: is an analyser in the rig, and did its sweep run?")?;
    let column = |name: &str| rows.channel(name);
    let [frequency, resistance, reactance] = CHANNELS.map(column);
    let frequency = frequency?;
    let resistance = resistance?;
    let reactance = reactance?;
    let line =
        |(k, &frequency_hz): (usize, &f64)| Line::exact(frequency_hz, C64::new(resistance[k], reactance[k]));
    let lines: Vec<Line> = frequency.iter().enumerate().map(line).collect();
    if lines.len() < keys.points as usize {
        return Err(format!("the sweep broke off: expected {} points, found {}", keys.points, lines.len()));
    }
    spans(keys, &lines)?;
    let fit = CircuitFit::new(&lines, keys.range_hz[0]).map_err(|e| e.to_string())?;
    let times_s = [rows.time_s[0], rows.time_s[rows.time_s.len() - 1]];
    Ok(Sweep { level: level(rows, &lines), lines, fit, times_s })
}

/// Refuses a sweep over other frequencies than were asked for.
fn spans(keys: &Keys, lines: &[Line]) -> Result<(), String> {
    let hz = |l: Option<&Line>| l.map_or(0.0, |l| l.frequency_hz);
    let found = [hz(lines.first()), hz(lines.last())];
    let is = |k: usize| (found[k] / keys.range_hz[k] - 1.0).abs() <= FREQUENCY_RATIO;
    let named =
        |[low, high]: [f64; 2]| format!("{} .. {}", Q::Frequency.format(low), Q::Frequency.format(high));
    if !(is(0) && is(1)) {
        return Err(format!(
            "the sweep spans {}, expected {}: the analyser did not take what it was told",
            named(found),
            named(keys.range_hz)
        ));
    }
    match lines.windows(2).find(|pair| pair[0].frequency_hz.total_cmp(&pair[1].frequency_hz).is_ge()) {
        Some(pair) => Err(format!(
            "the sweep does not ascend: {} after {}",
            Q::Frequency.format(pair[1].frequency_hz),
            Q::Frequency.format(pair[0].frequency_hz)
        )),
        None => Ok(()),
    }
}

/// Level of the points, where voltage and current were logged and are numbers.
fn level(rows: &Rows, lines: &[Line]) -> Option<Level> {
    let [voltage, current] = level::CHANNELS.map(|name| rows.column(name));
    Level::new(lines, voltage?, current?)
}

fn kind_of(measurand: &str) -> Q {
    match measurand {
        MODE => Q::Frequency,
        CAPACITANCE => Q::Capacitance,
        _ => Q::Ratio,
    }
}

fn none(axis: &str, reason: &str, measurands: &[&str]) -> Vec<Measurement> {
    let one = |name: &&str| Measurement::inconclusive(name, axis, kind_of(name), ESTIMATOR, reason);
    measurands.iter().map(one).collect()
}

fn measurements(axis: &str, sweep: &Sweep, reference_hz: f64, expected_hz: f64) -> Vec<Measurement> {
    let fit = &sweep.fit;
    let one = |measurand: &str, value: f64, u: f64| {
        let estimate = Estimate { value, u, dof: fit.dof as f64, n: sweep.lines.len() };
        Measurement::new(measurand, axis, kind_of(measurand), Some(estimate), ESTIMATOR)
    };
    let mut all = match &fit.resonance {
        Err(reason) => none(axis, &reason.to_string(), &[DEPARTURE, MODE, DAMPING, COUPLING]),
        Ok(Resonance { series_hz, damping, coupling, .. }) => {
            let mut departure =
                one(DEPARTURE, series_hz.value / expected_hz - 1.0, series_hz.u / expected_hz);
            departure.flags.push(format!("expected {}", Q::Frequency.format(expected_hz)));
            let fitted_one = |name, fitted: &Fitted| one(name, fitted.value, fitted.u);
            vec![
                departure,
                fitted_one(MODE, series_hz),
                fitted_one(DAMPING, damping),
                fitted_one(COUPLING, coupling),
            ]
        }
    };
    // What the terminals show far below the mode, as −1/(ωX) of the fit: motion included.
    let reactance_ohm = fit.at(reference_hz).im;
    let value = -1.0 / (TAU * reference_hz * reactance_ohm);
    let relative_u = fit.capacitance_f.u / fit.capacitance_f.value;
    let mut capacitance = one(CAPACITANCE, value, relative_u * value);
    capacitance.flags.push(format!("at {}", Q::Frequency.format(reference_hz)));
    all.push(capacitance);
    all
}
