//! Measurements that rest on one point: bandwidth, attenuation, resonance of the support and margins of the servo from a
//! response, distortion from single sines.
//!
//! Levels are read by a parabola through the lines around. The loop of the mirror's servo is opened by calculation:
//! L = T/(1 − T) of the response behind its own gauge.

use std::f64::consts::TAU;

use analysis::estimate::Estimate;
use analysis::frf::{C64, Line};
use analysis::least_squares::LinearFit;
use analysis::margins::{MarginError, Margins, Settings, margins, open_loop_from_closed};

use super::keys::Keys;
use super::point::{MirrorPoint, Response, Tone};
use super::spectra::{LineQuality, MirrorLine, Reaction};
use super::{mirror_axis_name, word};
use crate::case::Case;
use crate::kinds::response::frequency_response::{loops, point};
use crate::measurement::{Bound, Condition, Evidence, Measurement};
use crate::quantity::QuantityKind as Q;
use crate::reason::{MirrorReason, Reason};
use crate::trace::Plot;

pub(super) const BANDWIDTH: &str = "mirror-bandwidth";
pub(super) const ATTENUATION: &str = "mirror-attenuation-100-hz";
pub(super) const RESONANCE: &str = "reaction-resonance";
pub(super) const DISTORTION: &str = "harmonic-distortion";
/// Estimator and version of numbers that are read from one point or compared between points.
const ESTIMATOR: &str = "mirror-response/2";

/// Where attenuation is asked for.
const ATTENUATION_HZ: f64 = 100.0;

/// Most lines of a parabola.
const LINES: usize = 11;
/// Fewest lines of a parabola.
const FEWEST: usize = 7;
/// Gain at half power, dB: 20·lg(1/√2).
pub(super) const HALF_POWER_DB: f64 = -3.010_299_956_639_812;

/// Margins of the servo's loop.
pub(super) const CROSSOVER: &str = "mirror-crossover";
pub(super) const GAIN_MARGIN: &str = "mirror-gain-margin";
pub(super) const PHASE_MARGIN: &str = "mirror-phase-margin";
pub(super) const MODULUS_MARGIN: &str = "mirror-modulus-margin";
/// All margins of the loop, with their kinds of quantity.
pub(super) const MARGINS: [(&str, Q); 4] = [
    (CROSSOVER, Q::Frequency),
    (GAIN_MARGIN, Q::Decibel),
    (PHASE_MARGIN, Q::Angle),
    (MODULUS_MARGIN, Q::Ratio),
];
/// P + I/s + I²/s² (director.md, 3).
const INTEGRATORS: u32 = 2;
/// Estimator and version of the margins.
const MARGINS_ESTIMATOR: &str = "mirror-margins/1";

/// All measurements of a response point.
pub(super) fn of_response(
    keys: &Keys,
    case: &Case,
    point: &MirrorPoint,
    response: &Response,
) -> Vec<Measurement> {
    let sensor = Sensor::new(keys, response);
    let bandwidth = bandwidth_hz(sensor.lines, sensor.scale_u_ratio);
    let attenuation = gain_at(sensor.lines, ATTENUATION_HZ, sensor.scale_u_ratio)
        .map(|gain| Reading { value: -gain.value, ..gain });
    let mut all = vec![
        measurement(BANDWIDTH, Q::Frequency, case, bandwidth),
        measurement(ATTENUATION, Q::Decibel, case, attenuation),
        resonance(case, response.reaction.as_ref()),
    ];
    if all[0].value.is_some() && is_low_from_its_first_line_on(sensor.lines) {
        all[0]
            .set_bound(Bound::AtMost("the mirror is below -3 dB at its lowest line that counts".to_owned()));
    }
    // The servo closes its loop by the gauge, whatever else sees the mirror.
    all.extend(loop_margins(keys, case, &response.gauge));
    for m in &mut all {
        complete(m, keys, case, Some(point));
        if [BANDWIDTH, ATTENUATION].contains(&m.measurand.as_str()) {
            m.flags.extend(sensor.flags.iter().map(|flag| (*flag).to_owned()));
        }
    }
    all
}

/// All measurements of a response point, without values.
pub(super) fn none_of_response(case: &Case, reason: &Reason) -> Vec<Measurement> {
    let none = |measurand, kind| measurement(measurand, kind, case, Err(reason.to_owned()));
    let mut all =
        vec![none(BANDWIDTH, Q::Frequency), none(ATTENUATION, Q::Decibel), none(RESONANCE, Q::Frequency)];
    all.extend(no_margins(case, reason));
    all
}

/// Harmonic distortion of each sine of a point, against the procedure's own criterion; the judge checks the level of each.
pub(super) fn of_tones(keys: &Keys, case: &Case, point: &MirrorPoint) -> Vec<Measurement> {
    let Some(criterion) = keys.harmonics.as_ref().map(|h| &h.criterion) else { return Vec::new() };
    let mut all = Vec::new();
    for tone in &point.tones {
        let reading = Reading { value: tone.distortion_ratio, u: tone.u_ratio, dof: 4.0, n: 5 };
        let mut m = measurement(DISTORTION, Q::Ratio, case, Ok(reading));
        complete(&mut m, keys, case, Some(point));
        m.conditions.iter_mut().for_each(|c| c.achieved = Some(tone.level_v));
        m.flags.push(sine(tone));
        let met = if criterion.holds(tone.distortion_ratio) { "met" } else { "not met" };
        m.flags.push(format!("criterion {} {met}", criterion.text));
        all.push(m);
    }
    all
}

/// Words of a sine, in flags and remarks.
pub(super) fn sine(tone: &Tone) -> String {
    format!("sine of {}", Q::Frequency.format(tone.frequency_hz))
}

/// What the tilt of the mirror is read from.
struct Sensor<'a> {
    lines: &'a [MirrorLine],
    /// Standard uncertainty of the sensor's scale, where that is known.
    scale_u_ratio: f64,
    flags: Vec<&'static str>,
}

impl<'a> Sensor<'a> {
    /// The autocollimator, which sees the mirror itself, and else the gauge, which the servo follows: a wrong scale of that
    /// is in its response and does not show there.
    fn new(keys: &Keys, response: &'a Response) -> Self {
        if let Some(lines) = &response.reference {
            let flags = vec!["by the autocollimator"];
            return Self { lines, scale_u_ratio: keys.reference_u_ratio, flags };
        }
        let unknown = keys.gauge_u_ratio.is_none().then_some("u excludes the scale of the gauge");
        Self {
            lines: &response.gauge,
            scale_u_ratio: keys.gauge_u_ratio.unwrap_or(0.0),
            flags: std::iter::once("by the strain gauge").chain(unknown).collect(),
        }
    }
}

fn resonance(case: &Case, reaction: Option<&Reaction>) -> Measurement {
    let Some(found) = reaction else {
        let none = Err(MirrorReason::NoResonance.into());
        return measurement(RESONANCE, Q::Frequency, case, none);
    };
    let reading = Reading { value: found.frequency_hz, u: found.u_hz, dof: f64::INFINITY, n: 1 };
    let mut m = measurement(RESONANCE, Q::Frequency, case, Ok(reading));
    m.flags.push(format!("bends the response by {:.2} dB", found.size_db));
    m.flags.push(format!("damping ratio about {}", found.damping_ratio));
    m
}

/// A measurement of the mirror axis at this point.
pub(super) fn measurement(
    measurand: &str,
    kind: Q,
    case: &Case,
    reading: Result<Reading, Reason>,
) -> Measurement {
    let axis = mirror_axis_name(case);
    let mut m = match reading {
        Ok(Reading { value, u, dof, n }) => {
            Measurement::new(measurand, axis, kind, Some(Estimate { value, u, dof, n }), ESTIMATOR)
        }
        Err(reason) => Measurement::inconclusive(measurand, axis, kind, ESTIMATOR, reason),
    };
    m.point = Some(case.point.clone());
    m
}

/// Adds channel, conditions, place and evidence of a point; `point` is `None` where nothing came of it.
pub(super) fn complete(m: &mut Measurement, keys: &Keys, case: &Case, point: Option<&MirrorPoint>) {
    if let Some(channel) = case.mirror_channel {
        m.flags.push(format!("{} channel", word(channel)));
    }
    complete_without_channel(m, keys, case, point);
}

/// Adds conditions, place and evidence of a point.
pub(super) fn complete_without_channel(
    m: &mut Measurement,
    keys: &Keys,
    case: &Case,
    point: Option<&MirrorPoint>,
) {
    let response = point.and_then(|point| point.response.as_ref());
    if let Some(requested) = case.requested("level") {
        let achieved = response.map(|response| response.level_v);
        m.conditions.push(Condition { name: "level".to_owned(), requested, achieved, kind: Q::Voltage });
    }
    m.flags.push(format!("on the {}", keys.place));
    let Some(point) = point else { return };
    let axis = mirror_axis_name(case);
    let reference = response.and_then(|response| response.reference.as_ref()).map(|_| "reference");
    let parts = ["command", "angle"].into_iter().chain(reference);
    m.evidence.push(Evidence {
        file: String::new(),
        channels: parts.map(|part| format!("/fsm {part}_{axis}_rad")).collect(),
        t0_s: point.start_s,
        t1_s: point.end_s,
    });
}

/// A number read from a response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    pub(super) value: f64,
    pub(super) u: f64,
    pub(super) dof: f64,
    pub(super) n: usize,
}

/// Gain in dB around a frequency: a parabola over ln f.
struct Parabola {
    fit: LinearFit,
    centre_hz: f64,
    /// Standard uncertainty of one line by its own scatter, dB.
    line_u_db: f64,
    n: usize,
}

impl Parabola {
    /// Through the lines nearest to a frequency that count.
    fn around(lines: &[MirrorLine], centre_hz: f64) -> Option<Self> {
        let mut near: Vec<&MirrorLine> = lines.iter().filter(|l| l.counts()).collect();
        let distance = |l: &MirrorLine| (l.line.frequency_hz / centre_hz).ln().abs();
        near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        near.truncate(LINES);
        if near.len() < FEWEST {
            return None;
        }
        let x: Vec<f64> = near.iter().map(|l| (l.line.frequency_hz / centre_hz).ln()).collect();
        let gain_db: Vec<f64> = near.iter().map(|l| l.line.gain_db()).collect();
        let columns = [vec![1.0; x.len()], x.clone(), x.iter().map(|x| x * x).collect()];
        let fit = LinearFit::new(&columns, &gain_db, None).ok()?;
        let square = near.iter().map(|l| (decibel(l.line.relative_sd())).powi(2)).sum::<f64>();
        Some(Self { fit, centre_hz, line_u_db: (square / near.len() as f64).sqrt(), n: near.len() })
    }

    fn row(&self, frequency_hz: f64) -> [f64; 3] {
        let x = (frequency_hz / self.centre_hz).ln();
        [1.0, x, x * x]
    }

    fn gain_db(&self, frequency_hz: f64) -> f64 {
        self.fit.at(&self.row(frequency_hz))
    }

    /// What the lines leave of the parabola holds their distortion, which repeats in every period, too; where chance
    /// made them leave little, their own scatter counts.
    fn u_db(&self, frequency_hz: f64) -> f64 {
        let spread = self.fit.residual_variance.sqrt();
        let own = if spread > 0.0 { (self.line_u_db / spread).max(1.0) } else { 1.0 };
        let u = self.fit.u_at(&self.row(frequency_hz)) * own;
        if spread > 0.0 { u } else { self.line_u_db }
    }

    fn slope_db(&self, frequency_hz: f64) -> f64 {
        let [_, x, _] = self.row(frequency_hz);
        self.fit.coefficients[1] + 2.0 * x * self.fit.coefficients[2]
    }

    fn reading(&self, value: f64, u: f64) -> Reading {
        Reading { value, u, dof: self.fit.dof as f64, n: self.n }
    }
}

/// A small relative change in dB.
pub(super) fn decibel(ratio: f64) -> f64 {
    20.0 / std::f64::consts::LN_10 * ratio
}

/// Gain at a frequency, dB; u includes that of the sensor's scale.
pub(super) fn gain_at(
    lines: &[MirrorLine],
    frequency_hz: f64,
    scale_u_ratio: f64,
) -> Result<Reading, Reason> {
    let first = lines.iter().find(|l| l.counts());
    let last = lines.iter().rfind(|l| l.counts());
    let starts_below = first.is_some_and(|l| l.line.frequency_hz <= frequency_hz);
    let ends_above = last.is_some_and(|l| l.line.frequency_hz >= frequency_hz);
    if !(starts_below && ends_above) {
        return Err(MirrorReason::NoneOnBothSides { frequency_hz }.into());
    }
    let parabola =
        Parabola::around(lines, frequency_hz).ok_or(MirrorReason::TooFewAround { frequency_hz })?;
    let u = parabola.u_db(frequency_hz).hypot(decibel(scale_u_ratio));
    Ok(parabola.reading(parabola.gain_db(frequency_hz), u))
}

/// Whether noise leaves at least half of the lines up to a frequency.
fn trusted(lines: &[MirrorLine], up_to_hz: f64) -> bool {
    let inside = || lines.iter().filter(|l| l.line.frequency_hz <= up_to_hz);
    2 * inside().filter(|l| l.quality != LineQuality::Noise).count() >= inside().count()
}

fn oscillates(hz: f64) -> MirrorReason {
    MirrorReason::Oscillates { up_to_hz: hz }
}

fn is_low(line: &MirrorLine) -> bool {
    line.line.gain_db() <= HALF_POWER_DB
}

/// Whether the gain has fallen below the lowest line that counts already.
fn is_low_from_its_first_line_on(lines: &[MirrorLine]) -> bool {
    lines.iter().find(|l| l.counts()).is_some_and(is_low)
}

/// First frequency at which the gain falls to −3 dB of the command.
///
/// Bracketed by two neighbouring lines that count, then read from the parabola around them.
pub(super) fn bandwidth_hz(lines: &[MirrorLine], scale_u_ratio: f64) -> Result<Reading, Reason> {
    let counting: Vec<&MirrorLine> = lines.iter().filter(|l| l.counts()).collect();
    let first = counting.first().ok_or(MirrorReason::NoLineCounts)?;
    if is_low_from_its_first_line_on(lines) {
        // The mirror does not follow at all, and the lowest line is an upper bound; but a few lines that chance lifted out of an
        // oscillation bound nothing.
        let frequency_hz = first.line.frequency_hz;
        if !trusted(lines, frequency_hz) {
            return Err(oscillates(frequency_hz).into());
        }
        return Ok(Reading { value: frequency_hz, u: 0.0, dof: f64::INFINITY, n: 1 });
    }
    let pair = counting.windows(2).find(|pair| is_low(pair[1])).ok_or_else(|| {
        let last_hz = counting.last().map_or(0.0, |l| l.line.frequency_hz);
        MirrorReason::NoDrop { last_hz }
    })?;
    let low = pair[0].line;
    let high = pair[1].line;
    if !trusted(lines, high.frequency_hz) {
        return Err(oscillates(high.frequency_hz).into());
    }
    let share = (low.gain_db() - HALF_POWER_DB) / (low.gain_db() - high.gain_db());
    let mut at_hz = low.frequency_hz * (high.frequency_hz / low.frequency_hz).powf(share);
    let parabola = Parabola::around(lines, at_hz).ok_or(MirrorReason::TooFewAroundDrop { at_hz })?;
    // Newton on ln f: the parabola is nearly straight between neighbours.
    for _ in 0..4 {
        let slope_db = parabola.slope_db(at_hz);
        if slope_db >= 0.0 {
            return Err(MirrorReason::NotFalling { at_hz }.into());
        }
        at_hz *= ((HALF_POWER_DB - parabola.gain_db(at_hz)) / slope_db).clamp(-0.2, 0.2).exp();
    }
    let u_db = parabola.u_db(at_hz).hypot(decibel(scale_u_ratio));
    Ok(parabola.reading(at_hz, at_hz * u_db / parabola.slope_db(at_hz).abs()))
}

/// Margins of the loop.
///
/// The gauge is the sensor of the loop, so neither its scale nor its filter counts. The delay of the command channel is
/// not in the loop: its uncertainty counts.
pub(super) fn loop_margins(keys: &Keys, case: &Case, lines: &[MirrorLine]) -> Vec<Measurement> {
    let found = open_loop(lines, 0.0).and_then(|opened| {
        let margins = find_margins(&opened.lines)?;
        Ok((opened.lines.len(), margins))
    });
    let (n, margins) = match found {
        Ok(found) => found,
        Err(reason) => return no_margins(case, &reason),
    };
    let delay_u_s = keys.delays.u_s;
    // Later and earlier: near its crossing a margin may be there with one of them only.
    let turned = [delay_u_s, -delay_u_s].map(|later_s| {
        let found = open_loop(lines, later_s).and_then(|opened| find_margins(&opened.lines));
        found.ok().map(|margins| values(&margins))
    });
    let freedom = |l: &MirrorLine| 2.0 * l.line.dof;
    let dof = lines.iter().filter(|l| l.counts()).map(freedom).fold(f64::INFINITY, f64::min);
    let mut all = Vec::new();
    for (k, found) in values(&margins).into_iter().enumerate() {
        let (name, kind) = MARGINS[k];
        let reading = found.and_then(|[value, u]| {
            let of_turned = |found: &Option<[Result<[f64; 2], Reason>; 4]>| {
                let [turned, _] = found.as_ref()?[k].as_ref().ok().copied()?;
                Some((turned - value).abs())
            };
            let delay_u = of_turned(&turned[0]).zip(of_turned(&turned[1]));
            let (late, early) = delay_u.ok_or(MirrorReason::DelayUnknown { delay_u_s })?;
            Ok(Reading { value, u: u.hypot(late.max(early)), dof, n })
        });
        let mut m = measurement(name, kind, case, reading);
        m.estimator = MARGINS_ESTIMATOR.to_owned();
        m.flags.extend(margins.doubts.iter().map(|doubt| format!("not certified: {doubt}")));
        all.push(m);
    }
    all
}

/// Margins of the loop, without values.
fn no_margins(case: &Case, reason: &Reason) -> Vec<Measurement> {
    MARGINS.map(|(name, kind)| measurement(name, kind, case, Err(reason.to_owned()))).to_vec()
}

/// Bode and Nyquist of the open loop.
pub(super) fn loop_plots(case: &Case, lines: &[MirrorLine]) -> Vec<Plot> {
    let Ok(opened) = open_loop(lines, 0.0) else { return Vec::new() };
    let slug: String = case.point.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let title = |what: &str| format!("{what}, {}", case.point);
    let mut plots =
        point::bode(&format!("mirror-loop-{slug}"), &title("Open loop of the mirror"), "1", &opened);
    if let Ok(found) = find_margins(&opened.lines) {
        let id = format!("mirror-nyquist-{slug}");
        plots.push(point::nyquist(&id, &title("Nyquist of the mirror"), &opened, &found));
    }
    plots
}

/// Lines of the open loop, if the command channel is later by so much than was taken off.
fn open_loop(lines: &[MirrorLine], later_s: f64) -> Result<point::Judged, Reason> {
    let turned = |l: &MirrorLine| {
        let turn = C64::from_polar(1.0, TAU * l.line.frequency_hz * later_s);
        Line { value: l.line.value * turn, ..l.line }
    };
    let counting: Vec<Line> = lines.iter().filter(|l| l.counts()).map(turned).collect();
    Ok(point::judge_noise(open_loop_from_closed(&counting)?))
}

fn find_margins(lines: &[Line]) -> Result<Margins, Reason> {
    let settings = Settings { integrators_count: INTEGRATORS, ..Settings::default() };
    margins(lines, &settings).map_err(Reason::from)
}

/// Values with their standard uncertainties, as [`MARGINS`].
fn values(found: &Margins) -> [Result<[f64; 2], Reason>; 4] {
    let [crossover, gain, phase, _, modulus, _] = loops::readings(found);
    [crossover, gain, phase, modulus].map(|(_, reading)| match reading {
        Ok([_, value, u]) => Ok([value, u]),
        Err(none) => Err(MarginError::from(none).into()),
    })
}
