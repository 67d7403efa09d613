//! One sweep: level at the terminals, the circuit that fits it, what it says of the mirror, and pictures.

use std::f64::consts::{SQRT_2, TAU};

use analysis::circuit::{CircuitFit, Estimate as Fitted, Resonance};
use analysis::estimate::Estimate;
use analysis::frf::{C64, Line};

use super::keys::{Keys, LEVEL, mirror_axis};
use crate::case::Case;
use crate::log::{Rows, Window};
use crate::measurement::{Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{MirrorReason, Reason};
use crate::trace::{Mark, Plot, Scale, Series, Style};

/// Channels of the analyser, V and A RMS.
const LEVEL_CHANNELS: [&str; 2] = ["level_v", "current_a"];
/// What a sweep without them cannot say.
const UNKNOWN: &str = "level not known: voltage and current are not in the log";
/// Resistance of the analyser's source (E4990A), whose level is that of open terminals: the mirror takes the rest.
const SOURCE_OHM: f64 = 25.0;
/// Peak to peak of a sine over its RMS.
const PEAK_TO_PEAK: f64 = 2.0 * SQRT_2;
/// Voltage over current may depart from |Z| by this much: fixture compensation is in Z only.
const CONSISTENT_RATIO: f64 = 0.05;

/// Level of a sweep, V peak to peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// Least and largest of the source over the points: what stands at open terminals.
    source_v: [f64; 2],
    /// Least and largest voltage at the terminals over the points.
    terminals_v: [f64; 2],
    /// Largest departure of voltage over current from |Z|.
    inconsistent_ratio: f64,
}

impl Level {
    /// Of the impedances with the voltages and currents of the same points, RMS; `None` where these are no numbers.
    pub(super) fn new(lines: &[Line], voltage_v: &[f64], current_a: &[f64]) -> Option<Self> {
        let points = || lines.iter().zip(voltage_v).zip(current_a).map(|((l, v), i)| (l.value, *v, *i));
        let sound = |(_, v, i): (_, f64, f64)| v.is_finite() && i.is_finite() && v > 0.0 && i > 0.0;
        if points().count() != lines.len() || lines.is_empty() || !points().all(sound) {
            return None;
        }
        Some(Self {
            // The source drives Z and its own resistance with the same current.
            source_v: extremes(points().map(|(z, _, i)| PEAK_TO_PEAK * i * (z + SOURCE_OHM).norm())),
            terminals_v: extremes(points().map(|(_, v, _)| PEAK_TO_PEAK * v)),
            inconsistent_ratio: points().map(|(z, v, i)| (v / i / z.norm() - 1.0).abs()).fold(0.0, f64::max),
        })
    }

    /// Level of the source at the point where it is farthest from what was asked for.
    pub(super) fn source_v(&self, requested_v: f64) -> f64 {
        let [low, high] = self.source_v;
        if (low - requested_v).abs() > (high - requested_v).abs() { low } else { high }
    }

    /// What a reader must know of it.
    pub(super) fn flags(&self) -> Vec<String> {
        let [low, high] = self.terminals_v.map(|v| Q::Voltage.format(v));
        let mut all = vec![format!(
            "level of the source; behind its {SOURCE_OHM} ohm the level at the terminals is {low} .. {high}"
        )];
        if self.inconsistent_ratio > CONSISTENT_RATIO {
            all.push(format!(
                "voltage over current departs from the impedance by up to {:.0} %",
                100.0 * self.inconsistent_ratio
            ));
        }
        all
    }
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

pub(super) const DEPARTURE: &str = "mirror-mode-departure";
pub(super) const MODE: &str = "mirror-mode";
pub(super) const DAMPING: &str = "mirror-mode-damping";
pub(super) const COUPLING: &str = "mirror-coupling";
pub(super) const CAPACITANCE: &str = "mirror-capacitance";

const ESTIMATOR: &str = "mirror-impedance/1";
/// Which coupling it is: there are others, by static capacitances and of materials.
const EFFECTIVE: &str =
    "effective coupling (f_p^2 - f_s^2)/f_p^2, IEEE Std 176: the dielectric as it is at f_s";
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
            let said = level.as_ref().map_or_else(|| vec![UNKNOWN.to_owned()], Level::flags);
            result.measurements.iter_mut().for_each(|m| m.flags.extend(said.iter().cloned()));
            result.plots = of(axis, &sweep.lines, &sweep.fit);
            let logged = if level.is_some() { &LEVEL_CHANNELS[..] } else { &[] };
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

fn read(keys: &Keys, window: &Window) -> Result<Sweep, Reason> {
    let rows = window.rows(TOPIC).filter(|r| !r.time_s.is_empty());
    let rows = rows.ok_or(MirrorReason::NoImpedance)?;
    let column = |name: &str| rows.channel(name);
    let [frequency, resistance, reactance] = CHANNELS.map(column);
    let frequency = frequency?;
    let resistance = resistance?;
    let reactance = reactance?;
    let line =
        |(k, &frequency_hz): (usize, &f64)| Line::exact(frequency_hz, C64::new(resistance[k], reactance[k]));
    let lines: Vec<Line> = frequency.iter().enumerate().map(line).collect();
    if lines.len() < keys.points as usize {
        return Err(MirrorReason::SweepBrokeOff { expected: keys.points, found: lines.len() }.into());
    }
    spans(keys, &lines)?;
    let fit = CircuitFit::new(&lines, keys.range_hz[0])?;
    let times_s = [rows.time_s[0], rows.time_s[rows.time_s.len() - 1]];
    Ok(Sweep { level: level(rows, &lines), lines, fit, times_s })
}

/// Refuses a sweep over other frequencies than were asked for.
fn spans(keys: &Keys, lines: &[Line]) -> Result<(), Reason> {
    let hz = |l: Option<&Line>| l.map_or(0.0, |l| l.frequency_hz);
    let found = [hz(lines.first()), hz(lines.last())];
    let is = |k: usize| (found[k] / keys.range_hz[k] - 1.0).abs() <= FREQUENCY_RATIO;
    if !(is(0) && is(1)) {
        return Err(MirrorReason::OtherSpan { found_hz: found, expected_hz: keys.range_hz }.into());
    }
    match lines.windows(2).find(|pair| pair[0].frequency_hz.total_cmp(&pair[1].frequency_hz).is_ge()) {
        Some(pair) => Err(MirrorReason::NotAscending {
            later_hz: pair[1].frequency_hz,
            before_hz: pair[0].frequency_hz,
        }
        .into()),
        None => Ok(()),
    }
}

/// Level of the points, where voltage and current were logged and are numbers.
fn level(rows: &Rows, lines: &[Line]) -> Option<Level> {
    let [voltage, current] = LEVEL_CHANNELS.map(|name| rows.column(name));
    Level::new(lines, voltage?, current?)
}

fn kind_of(measurand: &str) -> Q {
    match measurand {
        MODE => Q::Frequency,
        CAPACITANCE => Q::Capacitance,
        _ => Q::Ratio,
    }
}

fn none(axis: &str, reason: &Reason, measurands: &[&str]) -> Vec<Measurement> {
    let one = |name: &&str| Measurement::inconclusive(name, axis, kind_of(name), ESTIMATOR, reason);
    measurands.iter().map(one).collect()
}

fn measurements(axis: &str, sweep: &Sweep, reference_hz: f64, expected_hz: f64) -> Vec<Measurement> {
    let fit = &sweep.fit;
    let one = |measurand: &str, value: f64, u: f64| {
        let estimate = Estimate { value, u, dof: fit.dof as f64, n: sweep.lines.len() };
        let m = Measurement::new(measurand, axis, kind_of(measurand), Some(estimate), ESTIMATOR);
        Measurement { flags: fit.goodness.flag().into_iter().collect(), ..m }
    };
    let mut all = match &fit.resonance {
        Err(reason) => none(axis, &(*reason).into(), &[DEPARTURE, MODE, DAMPING, COUPLING]),
        Ok(Resonance { series_hz, damping, coupling, .. }) => {
            let mut departure =
                one(DEPARTURE, series_hz.value / expected_hz - 1.0, series_hz.u / expected_hz);
            departure.flags.push(format!("expected {}", Q::Frequency.format(expected_hz)));
            let fitted_one = |name, fitted: &Fitted| one(name, fitted.value, fitted.u);
            let mut coupling = fitted_one(COUPLING, coupling);
            coupling.flags.push(EFFECTIVE.to_owned());
            vec![departure, fitted_one(MODE, series_hz), fitted_one(DAMPING, damping), coupling]
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

/// Points of the fit's curve.
const CURVE: u32 = 600;

/// |Z| and phase over frequency, with the fit and the mode.
pub(super) fn of(axis: &str, lines: &[Line], fit: &CircuitFit) -> Vec<Plot> {
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else { return Vec::new() };
    let ratio = last.frequency_hz / first.frequency_hz;
    let grid: Vec<f64> =
        (0..=CURVE).map(|k| first.frequency_hz * ratio.powf(f64::from(k) / f64::from(CURVE))).collect();
    let found = fit.resonance.as_ref().ok();
    let marks: Vec<Mark> =
        found.map(|r| Mark { label: "mode".to_owned(), x: r.series_hz.value }).into_iter().collect();
    let plot = |id: &str, title: &str, y: Scale, of: &dyn Fn(&Line) -> f64| {
        let fitted: Vec<Line> = grid.iter().map(|&hz| Line::exact(hz, fit.at(hz))).collect();
        let series = |label: &str, style, lines: &[Line]| {
            let x = lines.iter().map(|l| l.frequency_hz).collect();
            Series::new(label, style, x, lines.iter().map(of).collect())
        };
        Plot {
            id: format!("{id}-{axis}"),
            title: format!("{title}, mirror {axis}"),
            x: Scale { label: "frequency".to_owned(), unit: "Hz".to_owned(), log: true },
            y,
            series: vec![series("analyser", Style::Markers, lines), series("circuit", Style::Fit, &fitted)],
            limits: Vec::new(),
            marks: marks.clone(),
            limits_of: None,
            ..Plot::default()
        }
    };
    let magnitude = Scale { label: "impedance".to_owned(), unit: "ohm".to_owned(), log: true };
    let phase = Scale { label: "phase".to_owned(), unit: "deg".to_owned(), log: false };
    vec![
        plot("impedance", "Impedance", magnitude, &|l| l.value.norm()),
        plot("impedance-phase", "Phase of the impedance", phase, &|l| l.phase_rad().to_degrees()),
    ]
}
