//! Over all points: rejection of each axis, by the closed loop alone and with and without, and its pictures.

use std::f64::consts::TAU;

use analysis::estimate::Estimate;
use analysis::frf::C64;
use analysis::rejection::{self, Rejected};
use analysis::uncertainty::{Component, combine};

use super::keys::{CLOSED, Keys, OPEN, gain_point};
use super::point::{self, Density, MirrorSine, Record, Responses, responses};
use super::{AMPLIFICATION, CROSSING, REJECTION, WITH_AND_WITHOUT};
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::kinds::optics::frames::{FINE_TOPIC, MIRROR_TOPIC, READINGS};
use crate::measurement::{Conclusion, Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{OpticsReason, Reason};
use crate::trace::{LimitLine, Plot, Scale, Series, Style};

const ESTIMATOR: &str = "atmosphere/1";
/// Lines count up to this part of the frame rate.
const HIGHEST_RATIO: f64 = 0.4;
/// Band of a ratio of powers, to either side.
const BAND_RATIO: f64 = 0.15;
/// Both ways must agree within so many standard uncertainties.
const AGREE: f64 = 4.0;
/// 20·lg e.
const DECIBEL: f64 = 20.0 / std::f64::consts::LN_10;

/// A rejection with everything that makes it uncertain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Read {
    pub(super) frequency_hz: f64,
    pub(super) db: f64,
    pub(super) u: Component,
    lines: usize,
}

/// What the closed loop alone says of an axis.
pub(super) struct Found {
    pub(super) responses: Responses,
    /// What is left, smoothed, up to where lines count.
    pub(super) curve: Vec<Rejected>,
    sight_u_ratio: f64,
    timing_u_s: f64,
    stamp_u_s: f64,
}

impl Found {
    /// |1 − T| in dB, with T the share of d that the mirror takes. A sight that is wrong by ε changes d, too: ln(1 − T)
    /// changes by −T·ε. A mean over a frame that is late by δ changes T alone: −jωδ·T/(1 − T). Exposures that are stated
    /// late by δ turn mirror and mean together against the readings, and d with them: −jωδ·T.
    pub(super) fn read(&self, found: &Rejected) -> Read {
        let taken = C64::new(1.0, 0.0) - found.value;
        let sight = DECIBEL * taken.re.abs() * self.sight_u_ratio;
        let turned = (taken * found.value.conj()).im.abs() / found.value.norm_sqr().max(f64::MIN_POSITIVE);
        let timing = DECIBEL * turned * TAU * found.frequency_hz * self.timing_u_s;
        let stamp = DECIBEL * taken.im.abs() * TAU * found.frequency_hz * self.stamp_u_s;
        let known = [sight, timing, stamp].map(Component::known);
        let u = combine(&[&[found.scatter_db], known.as_slice()].concat());
        Read { frequency_hz: found.frequency_hz, db: found.db(), u, lines: found.lines }
    }
}

/// Measurements, pictures, remarks.
pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Conclusion {
    let named = |name: &str| {
        let mut all = cases.iter().zip(points);
        all.find(|(case, _)| case.point == name).map(|(_, point)| point)
    };
    let closed = named(CLOSED);
    let open = named(OPEN);
    let mut conclusion = Conclusion::default();
    for axis in 0..MIRROR_AXES.len() {
        let found = closed_alone(keys, closed, named(&gain_point(axis)), axis);
        conclusion.measurements.extend(measurements(keys, closed, axis, found.as_ref()));
        let found = found.as_ref().ok();
        let ratios: Vec<Ratio> =
            keys.frequencies_hz.iter().map(|&hz| (hz, ratio(open, found, axis, hz))).collect();
        conclusion.measurements.extend(ratios.iter().map(|ratio| ratio_measurement(ratio, closed, axis)));
        conclusion.remarks.extend(ratios.iter().filter_map(|ratio| contradiction(ratio, found?, axis)));
        conclusion.plots.extend(pictures(open, found, &ratios, axis));
    }
    conclusion
}

/// A frequency with the ratio of powers there.
pub(super) type Ratio = (f64, Result<(f64, Component), Reason>);

fn closed_alone(
    keys: &Keys,
    closed: Option<&PointResult>,
    mirror: Option<&PointResult>,
    axis: usize,
) -> Result<Found, Reason> {
    let closed = record(closed, "with the loop closed")?;
    let mirror = record(mirror, "that moves the mirror")?;
    let point::Found::Closed { stamp_u_s, axes, averages } = &closed.found else {
        return Err(OpticsReason::NoClosedSpectra.into());
    };
    let point::Found::Mirror(MirrorSine { sight, sight_u_ratio, .. }) = &mirror.found else {
        return Err(OpticsReason::NoMirrorSine.into());
    };
    let responses = responses(&axes[axis], *averages, *sight, closed.rate_hz);
    let curve = rejection::smoothed(&responses.left, HIGHEST_RATIO * closed.rate_hz);
    if curve.is_empty() {
        return Err(OpticsReason::NoLine.into());
    }
    // Where between two rows the mirror moves does not show.
    let timing_u_s = keys.timing_u_s.hypot(closed.row_s / 12.0_f64.sqrt());
    Ok(Found { responses, curve, sight_u_ratio: *sight_u_ratio, timing_u_s, stamp_u_s: *stamp_u_s })
}

/// The record of a point that was run and says something.
fn record<'a>(point: Option<&'a PointResult>, what: &'static str) -> Result<&'a Record, Reason> {
    let point = point.ok_or(OpticsReason::NotRun { what })?;
    if let Some(reason) = &point.inconclusive {
        return Err(Reason::of_point(&point.point, reason));
    }
    point.reduced.get().ok_or_else(|| OpticsReason::NoRecord { point: point.point.clone() }.into())
}

fn measurements(
    keys: &Keys,
    closed: Option<&PointResult>,
    axis: usize,
    found: Result<&Found, &Reason>,
) -> Vec<Measurement> {
    let measured = |name: &str, kind: Q, result: Result<(f64, Component, usize), Reason>| {
        let mut m = match result {
            Ok((value, Component { u, dof }, n)) => {
                let estimate = Estimate { value, u, dof, n };
                Measurement::new(name, MIRROR_AXES[axis], kind, Some(estimate), ESTIMATOR)
            }
            Err(reason) => Measurement::inconclusive(name, MIRROR_AXES[axis], kind, ESTIMATOR, reason),
        };
        complete(&mut m, closed);
        m
    };
    let found = found.map_err(Clone::clone);
    let mut all = Vec::new();
    for &frequency_hz in &keys.frequencies_hz {
        let read = found.clone().and_then(|f| {
            let there = rejection::rejected(&f.responses.left, frequency_hz)?;
            Ok(f.read(&there))
        });
        let mut m = measured(REJECTION, Q::Decibel, read.map(|r| (r.db, r.u, r.lines)));
        m.conditions.push(at(frequency_hz));
        all.push(m);
    }
    all.push(measured(CROSSING, Q::Frequency, found.clone().and_then(crossing)));
    let peak = found.and_then(|f| {
        let most = rejection::peak(&f.curve).ok_or(OpticsReason::NoLine)?;
        Ok(f.read(&most))
    });
    let mut amplification = measured(AMPLIFICATION, Q::Decibel, peak.clone().map(|r| (r.db, r.u, r.lines)));
    amplification.flags.extend(peak.ok().map(|peak| format!("at {:.1} Hz", peak.frequency_hz)));
    all.push(amplification);
    all
}

fn at(frequency_hz: f64) -> Condition {
    let name = "frequency".to_owned();
    let achieved = Some(frequency_hz);
    Condition { name, requested: frequency_hz, achieved, kind: Q::Frequency }
}

/// The crossing with the uncertainty of its level, over the slope there.
fn crossing(found: &Found) -> Result<(f64, Component, usize), Reason> {
    let (there, scatter) = rejection::crossing(&found.responses.left, &found.curve)?;
    let read = found.read(&there);
    let hz_per_db = if there.scatter_db.u > 0.0 { scatter.u / there.scatter_db.u } else { 0.0 };
    Ok((there.frequency_hz, Component { u: hz_per_db * read.u.u, dof: read.u.dof }, there.lines))
}

fn complete(m: &mut Measurement, closed: Option<&PointResult>) {
    let Some(point) = closed else { return };
    m.point = Some(point.point.clone());
    let Some(record) = point.reduced.get::<Record>() else { return };
    if record.lost_ratio > 0.005 {
        m.flags.push(format!("{:.0} % of the frames lost, bridged", 100.0 * record.lost_ratio));
    }
    let axis = MIRROR_AXES.iter().position(|name| *name == m.axis).unwrap_or(0);
    let angle = format!("{MIRROR_TOPIC} angle_{}_rad", m.axis);
    let channels = vec![format!("{FINE_TOPIC} {}", READINGS[axis]), angle];
    m.evidence.push(Evidence::new(channels, record.span_s));
}

/// Power of the readings with the loop over that without, in a band around a frequency, dB.
fn ratio(
    open: Option<&PointResult>,
    found: Option<&Found>,
    axis: usize,
    frequency_hz: f64,
) -> Result<(f64, Component), Reason> {
    let point::Found::Open(axes) = &record(open, "with the loop open")?.found else {
        return Err(OpticsReason::NoOpenSpectrum.into());
    };
    let without = &axes[axis];
    let with = &found.ok_or(OpticsReason::NoClosedSpectrum)?.responses.error;
    let closed = band(with, frequency_hz);
    let open = band(without, frequency_hz);
    let ((closed, dof_closed), (open, dof_open)) = closed.zip(open).ok_or(OpticsReason::NoPower)?;
    // Each power is a χ² with its freedom: relative standard deviation √(2/dof), 10·lg of it.
    let part = |dof: f64| Component { u: 0.5 * DECIBEL * (2.0 / dof).sqrt(), dof };
    Ok((10.0 * (closed / open).log10(), combine(&[part(dof_closed), part(dof_open)])))
}

/// Mean density of the lines in a band, at least of three, and its degrees of freedom. Neighbouring lines of a Hann window
/// correlate: two are worth one.
fn band(lines: &[Density], frequency_hz: f64) -> Option<(f64, f64)> {
    const WORTH: f64 = 0.5;
    let spacing_hz = lines.get(1)?.frequency_hz - lines.first()?.frequency_hz;
    let reach_hz = (BAND_RATIO * frequency_hz).max(1.1 * spacing_hz);
    let is_near = |line: &&Density| (line.frequency_hz - frequency_hz).abs() <= reach_hz;
    let near: Vec<&Density> = lines.iter().filter(is_near).collect();
    let mean = near.iter().map(|l| l.value).sum::<f64>() / near.len() as f64;
    let dof = near.iter().map(|l| l.dof).sum::<f64>() * WORTH;
    (near.len() >= 3 && mean > 0.0 && mean.is_finite()).then_some((mean, dof))
}

fn ratio_measurement(
    (frequency_hz, ratio): &Ratio,
    closed: Option<&PointResult>,
    axis: usize,
) -> Measurement {
    let name = MIRROR_AXES[axis];
    let mut m = match ratio {
        Ok((value, u)) => {
            let estimate = Estimate { value: *value, u: u.u, dof: u.dof, n: 2 };
            Measurement::new(WITH_AND_WITHOUT, name, Q::Decibel, Some(estimate), ESTIMATOR)
        }
        Err(reason) => {
            Measurement::inconclusive(WITH_AND_WITHOUT, name, Q::Decibel, ESTIMATOR, reason.clone())
        }
    };
    complete(&mut m, closed);
    m.conditions.push(at(*frequency_hz));
    m
}

/// Where the two records say something else about the readings than the closed loop alone does.
fn contradiction((frequency_hz, ratio): &Ratio, found: &Found, axis: usize) -> Option<String> {
    let (db, u) = ratio.as_ref().ok()?;
    let alone = found.read(&rejection::rejected(&found.responses.read, *frequency_hz).ok()?);
    ((db - alone.db).abs() > AGREE * u.u.hypot(alone.u.u)).then(|| {
        format!(
            "{} at {frequency_hz:.1} Hz: readings with the loop closed are {db:.1} dB relative to those \
             with it open, but {:.1} dB by the closed loop alone; check whether the air changed between \
             the records",
            MIRROR_AXES[axis], alone.db
        )
    })
}

const MICRO_SQUARE: f64 = 1e12;
/// Shown up to here.
const HIGHEST_HZ: f64 = 60.0;

/// Spectra and rejection of an axis.
fn pictures(open: Option<&PointResult>, found: Option<&Found>, ratios: &[Ratio], axis: usize) -> Vec<Plot> {
    spectra(open, found, axis).into_iter().chain(found.map(|f| rejection(f, ratios, axis))).collect()
}

fn series(label: &str, style: Style, lines: &[Density]) -> Series {
    let shown =
        lines.iter().filter(|l| l.frequency_hz > 0.0 && l.frequency_hz <= HIGHEST_HZ && l.value > 0.0);
    let (x, y) = shown.map(|l| (l.frequency_hz, MICRO_SQUARE * l.value)).unzip();
    Series::new(label, style, x, y)
}

fn spectra(open: Option<&PointResult>, found: Option<&Found>, axis: usize) -> Option<Plot> {
    let name = MIRROR_AXES[axis];
    let without = match open.and_then(|point| point.reduced.get()) {
        Some(Record { found: point::Found::Open(axes), .. }) => {
            Some(series("without the fine loop", Style::Line, &axes[axis]))
        }
        _ => None,
    };
    let with = found.map(|f| {
        [
            series("image motion before the mirror, loop closed", Style::Fit, &f.responses.input),
            series("with the fine loop", Style::Line, &f.responses.error),
        ]
    });
    let all: Vec<Series> = without.into_iter().chain(with.into_iter().flatten()).collect();
    let x = Scale::logarithmic("frequency", "Hz");
    let y = Scale::logarithmic("density", "urad^2/Hz");
    let title = format!("Readings with and without the fine loop, {name}");
    (!all.is_empty()).then(|| Plot { series: all, ..Plot::new(format!("tip-tilt-{name}"), title, x, y) })
}

fn rejection(found: &Found, ratios: &[Ratio], axis: usize) -> Plot {
    let name = MIRROR_AXES[axis];
    let curve: Vec<_> = found.curve.iter().map(|r| found.read(r)).collect();
    let curve: Vec<_> = curve.into_iter().filter(|r| r.frequency_hz <= HIGHEST_HZ).collect();
    let x: Vec<f64> = curve.iter().map(|r| r.frequency_hz).collect();
    let y: Vec<f64> = curve.iter().map(|r| r.db).collect();
    let u = curve.iter().map(|r| 2.0 * r.u.u).collect();
    let read = found.responses.read.iter().filter(|l| l.frequency_hz <= HIGHEST_HZ);
    let (read_x, read_y) = read.map(|l| (l.frequency_hz, l.gain_db())).unzip();
    let mut series = vec![
        Series::new("2 u", Style::Band, x.clone(), y.clone()).with_u(u),
        Series::new("line of sight, closed loop alone", Style::Line, x, y),
        Series::new("readings, closed loop alone", Style::Fit, read_x, read_y),
    ];
    let bands: Vec<_> = ratios.iter().filter_map(|(f, r)| r.as_ref().ok().map(|r| (*f, *r))).collect();
    if !bands.is_empty() {
        let (x, y) = bands.iter().map(|(f, (db, _))| (*f, *db)).unzip();
        let u = bands.iter().map(|(_, (_, u))| 2.0 * u.u).collect();
        series.push(Series::new("readings, with and without, 2 u", Style::Markers, x, y).with_u(u));
    }
    let x = Scale::logarithmic("frequency", "Hz");
    let y = Scale::linear("residual tip-tilt", "dB");
    Plot {
        series,
        limits: vec![LimitLine { label: "0 dB".to_owned(), y: 0.0, x: None }],
        limits_of: Some(REJECTION.to_owned()),
        ..Plot::new(format!("rejection-{name}"), format!("Rejection of tip-tilt, {name}"), x, y)
    }
}
