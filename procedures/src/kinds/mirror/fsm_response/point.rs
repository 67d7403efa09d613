//! One point: from rows of the mirror to lines, positions or harmonics.

use std::f64::consts::TAU;
use std::ops::Range;

use analysis::frf::{C64, Line};
use analysis::periodic::errors_in_variables;

use super::keys::Keys;
use super::periods::Periods;
use super::spectra::{
    LineQuality, MirrorLine, Reaction, amplitudes, exclusions, find_reaction, mark_reaction,
};
use super::{MEASURE, POSITION, SETTLE, TONE, has_segment, mirror_axis, response};
use crate::case::{Case, MirrorChannel, Segment};
use crate::device::MIRROR_AXES;
use crate::excitation::Signal;
use crate::log::{Rows, SegmentSpan, Window};
use crate::measurement::{Exclusion, PointResult, Reduced};
use crate::reason::{MirrorReason, Reason};

/// Topic of the mirror.
const TOPIC: &str = "/fsm";
/// Share of the row rate up to which lines count.
const HIGHEST_RATIO: f64 = 0.4;
/// A command this near to its peak over and over is held there by the limit of the driver.
const SATURATED_ROWS: usize = 4;
/// So many times as often as elsewhere a command may rest at its peak by chance.
const HELD_FACTOR: f64 = 2.0;
/// Parts of a tone's record from which the scatter comes.
const TONE_PARTS: usize = 5;

/// What a point was reduced to: a response, positions of the stroke, or single sines.
#[derive(Clone, Debug)]
pub(super) struct MirrorPoint {
    /// Start and end on the log's time axis, the rest before not counted.
    pub(super) start_s: f64,
    pub(super) end_s: f64,
    pub(super) response: Option<Response>,
    pub(super) positions: Vec<Position>,
    pub(super) tones: Vec<Tone>,
}

/// Response of the mirror to the multisine.
#[derive(Clone, Debug)]
pub(super) struct Response {
    /// From command to strain gauge.
    pub(super) gauge: Vec<MirrorLine>,
    /// From command to autocollimator, where there is one that sees the mirror.
    pub(super) reference: Option<Vec<MirrorLine>>,
    /// A resonance of the support, where one is seen.
    pub(super) reaction: Option<Reaction>,
    /// Level that was sent, peak to peak.
    pub(super) level_v: f64,
    /// Periods that are left out.
    pub(super) excluded: Option<Exclusion>,
}

/// A position that was held.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    pub(super) command_rad: f64,
    pub(super) gauge: Tilt,
    /// By the autocollimator, where there is one that sees the mirror.
    pub(super) reference: Option<Tilt>,
    pub(super) rows_count: usize,
}

/// Mean tilt of the mirror by one sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tilt {
    pub(super) tilt_rad: f64,
    /// Standard uncertainty of the mean by the scatter of the rows.
    pub(super) u_rad: f64,
}

/// A single sine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tone {
    pub(super) frequency_hz: f64,
    /// Root of the summed squares of harmonics 2 to 5 over the fundamental.
    pub(super) distortion_ratio: f64,
    /// Standard uncertainty of the distortion.
    pub(super) u_ratio: f64,
    /// Level that was sent, peak to peak.
    pub(super) level_v: f64,
}

/// Reduces one point, and measures what rests on it alone.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    match Record::new(keys, case, window).and_then(|record| record.reduce()) {
        Ok(point) => {
            if let Some(found) = &point.response {
                result.excluded = found.excluded.iter().cloned().chain(exclusions(&found.gauge)).collect();
                result.measurements = response::of_response(keys, case, &point, found);
            } else {
                result.measurements = response::of_tones(keys, case, &point);
            }
            result.reduced = Reduced::to(point);
        }
        Err(reason) => {
            if has_segment(case, MEASURE) {
                result.measurements = response::none_of_response(case, &reason);
            }
            result.inconclusive = Some(reason);
        }
    }
    result
}

/// The columns of the excited axis.
struct Record<'a> {
    keys: &'a Keys,
    case: &'a Case,
    window: &'a Window,
    rows: &'a Rows,
    command_rad: &'a [f64],
    gauge_rad: &'a [f64],
    /// Autocollimator, where there is one that sees the mirror.
    reference_rad: Option<&'a [f64]>,
}

impl<'a> Record<'a> {
    fn new(keys: &'a Keys, case: &'a Case, window: &'a Window) -> Result<Self, Reason> {
        let axis = MIRROR_AXES[mirror_axis(case).ok_or(MirrorReason::NothingExcited)?];
        let rows = window.rows(TOPIC).ok_or(MirrorReason::NoRowsOfMirror)?;
        let column = |part: &str| rows.column(&format!("{part}_{axis}_rad"));
        let needed = |part: &str| {
            column(part)
                .ok_or_else(|| MirrorReason::NoMirrorChannel { channel: format!("{part}_{axis}_rad") })
        };
        let command_rad = needed("command")?;
        let gauge_rad = needed("angle")?;
        let sees = |values: &&[f64]| values.iter().all(|v| v.is_finite());
        Ok(Self {
            keys,
            case,
            window,
            rows,
            command_rad,
            gauge_rad,
            reference_rad: column("reference").filter(sees),
        })
    }

    fn reduce(&self) -> Result<MirrorPoint, Reason> {
        let times = self.window.segments.iter().filter(|s| self.label(s) != Some(SETTLE));
        let start_s = times.clone().map(|s| s.start_s).fold(f64::INFINITY, f64::min);
        let end_s = times.map(|s| s.end_s).fold(start_s, f64::max);
        let mut point =
            MirrorPoint { start_s, end_s, response: None, positions: Vec::new(), tones: Vec::new() };
        for (index, segment) in self.case.segments.iter().enumerate() {
            let span = self.window.segments.iter().find(|s| s.segment == index);
            let span = span.ok_or_else(|| MirrorReason::SegmentNotLogged { label: segment.label.clone() })?;
            match segment.label.as_str() {
                MEASURE => point.response = Some(self.response(segment, span)?),
                POSITION => point.positions.push(self.position(span)?),
                TONE => point.tones.push(self.tone(segment, span)?),
                _ => {}
            }
        }
        Ok(point)
    }

    fn label(&self, span: &SegmentSpan) -> Option<&str> {
        self.case.segments.get(span.segment).map(|s| s.label.as_str())
    }

    fn signal(&self, segment: &Segment) -> Result<&'a Signal, Reason> {
        let excitation = segment.excited.and_then(|index| self.case.excitations.get(index));
        Ok(&excitation.ok_or(MirrorReason::NoExcitation)?.signal)
    }

    /// The last `count` rows of a segment; none may be missing.
    fn last_rows(&self, span: &SegmentSpan, count: usize) -> Result<Range<usize>, Reason> {
        let range = self.rows.range(span.start_s, span.end_s);
        if range.len() < count {
            return Err(MirrorReason::FewerRows { expected: count, found: range.len() }.into());
        }
        Ok(range.end - count..range.end)
    }

    /// Time from row to row; they must be evenly spaced, or a line is not where it is looked for.
    fn row_s(&self, span: &SegmentSpan) -> Result<f64, Reason> {
        let times = &self.rows.time_s[self.rows.range(span.start_s, span.end_s)];
        let [first, .., last] = times else { return Err(MirrorReason::TooFewRows.into()) };
        let row_s = (last - first) / (times.len() - 1) as f64;
        match times.windows(2).find(|pair| (pair[1] - pair[0] - row_s).abs() > 0.5 * row_s) {
            Some(pair) => Err(MirrorReason::RowsMissing { at_s: pair[0] }.into()),
            None => Ok(row_s),
        }
    }

    fn response(&self, segment: &Segment, span: &SegmentSpan) -> Result<Response, Reason> {
        let Signal::Multisine { period_s, lines } = self.signal(segment)? else {
            return Err(MirrorReason::NotAMultisine.into());
        };
        let multisine = &self.keys.multisine;
        let count = multisine.periods.saturating_sub(multisine.dropped) as usize;
        let range = self.rows.range(span.start_s, span.end_s);
        let periods = Periods::last(&self.rows.time_s, range, *period_s, count)?;
        let row_s = periods.row_s;
        let length = whole(period_s / row_s)?;
        let command = periods.values(self.command_rad);
        self.saturation(&command, lines.iter().map(|l| l.amplitude).sum())?;
        let frequencies: Vec<f64> = lines.iter().map(|l| l.frequency_hz).collect();
        let orders: Vec<usize> =
            frequencies.iter().map(|f| (f * period_s).round() as usize % length).collect();
        let amplitudes_of = |samples: &[f64]| -> Vec<Vec<C64>> {
            periods.rows.iter().map(|rows| amplitudes(&samples[rows.clone()], &orders)).collect()
        };
        let mut sent = amplitudes_of(self.command_rad);
        self.add_signs(&mut sent, &periods.rows, &frequencies, row_s);
        let judged = |samples: &[f64]| -> Result<Vec<MirrorLine>, Reason> {
            let frf = errors_in_variables(&frequencies, &sent, &amplitudes_of(samples))
                .map_err(|_| MirrorReason::LinesMissing)?;
            Ok(frf.into_iter().map(|line| self.judged(line, row_s)).collect())
        };
        let mut gauge = judged(self.gauge_rad)?;
        let mut reference = self.reference_rad.map(judged).transpose()?;
        // The autocollimator sees the mirror itself, the gauge only its motion against the support.
        let seen = reference.as_deref().and_then(|lines| find_reaction(lines, multisine.reaction_hz));
        let reaction = seen.or_else(|| find_reaction(&gauge, multisine.reaction_hz));
        if let Some(found) = &reaction {
            mark_reaction(&mut gauge, found);
            reference.iter_mut().for_each(|lines| mark_reaction(lines, found));
        }
        let level_v = peak_to_peak(&command) / self.keys.scale_rad_per_v;
        Ok(Response { gauge, reference, reaction, level_v, excluded: periods.excluded() })
    }

    /// Makes of complex amplitudes of the command, by periods, those of what acted: the changes to a negative order come later
    /// by its sign.
    ///
    /// A held signal of steps Δu at row times t has the amplitude Σ Δu·e^(−jωt)/(1 − e^(−jωT)) of its rows; those that come
    /// δ later have the factor e^(−jωδ).
    fn add_signs(&self, sent: &mut [Vec<C64>], periods: &[Range<usize>], frequencies_hz: &[f64], row_s: f64) {
        let late_s = self.keys.sign_s(self.channel());
        let Some(first) = periods.first().filter(|_| late_s > 0.0) else { return };
        let step = |k: usize| match k.checked_sub(1) {
            Some(before) if self.command_rad[k].is_sign_negative() => {
                self.command_rad[k] - self.command_rad[before]
            }
            _ => 0.0,
        };
        let length = first.len();
        let order = |hz: &f64| (hz * row_s * length as f64).round() as usize % length;
        let orders: Vec<usize> = frequencies_hz.iter().map(order).collect();
        let turn = |hz: f64, time_s: f64| C64::from_polar(1.0, -TAU * hz * time_s);
        for (lines, rows) in sent.iter_mut().zip(periods) {
            let steps: Vec<f64> = rows.clone().map(step).collect();
            let late = amplitudes(&steps, &orders);
            for ((line, late), &hz) in lines.iter_mut().zip(late).zip(frequencies_hz) {
                *line += late * (turn(hz, late_s) - 1.0) / (1.0 - turn(hz, row_s));
            }
        }
    }

    /// A line with hold and known delay of its channel removed, judged.
    ///
    /// The coherence is that of one period and says nothing of the mean: it is left out.
    fn judged(&self, line: Line, row_s: f64) -> MirrorLine {
        let line = Line { coherence: None, ..unheld(line, row_s, self.known_delay_s()) };
        let snr = line.value.norm_sqr() / line.variance.max(f64::MIN_POSITIVE);
        let quality = if line.frequency_hz > HIGHEST_RATIO / row_s {
            LineQuality::Fast
        } else if 10.0 * snr.log10() < self.keys.multisine.least_snr_db {
            LineQuality::Noise
        } else {
            LineQuality::Counts
        };
        MirrorLine { line, quality }
    }

    fn known_delay_s(&self) -> f64 {
        self.keys.known_delay_s(self.channel())
    }

    fn channel(&self) -> MirrorChannel {
        self.case.mirror_channel.unwrap_or(MirrorChannel::Analog)
    }

    /// A command that rests at its extreme was cut off there, unless it rests as often elsewhere: a serial line takes another
    /// command only when the last one was answered, so that some last two ticks.
    fn saturation(&self, command: &[f64], most_rad: f64) -> Result<(), Reason> {
        let low_rad = lowest(command);
        let high_rad = highest(command);
        let near_rad = 1e-6 * most_rad.max(high_rad - low_rad);
        let rests = |pair: &&[f64]| (pair[1] - pair[0]).abs() < near_rad;
        let is_extreme = |c: f64| (c - low_rad).abs() < near_rad || (c - high_rad).abs() < near_rad;
        let elsewhere = || command.windows(2).filter(|pair| !is_extreme(pair[0]));
        let held_ratio = elsewhere().filter(rests).count() as f64 / elsewhere().count().max(1) as f64;
        let is_cut_off = |extreme_rad: f64| {
            let there = || command.windows(2).filter(|pair| (pair[0] - extreme_rad).abs() < near_rad);
            let held = held_ratio * there().count() as f64;
            there().filter(rests).count() as f64 >= SATURATED_ROWS as f64 + HELD_FACTOR * held
        };
        if is_cut_off(low_rad) || is_cut_off(high_rad) {
            return Err(
                MirrorReason::Saturation { low_urad: 1e6 * low_rad, high_urad: 1e6 * high_rad }.into()
            );
        }
        Ok(())
    }

    /// Means of the last half of a position's rest.
    fn position(&self, span: &SegmentSpan) -> Result<Position, Reason> {
        let rest_s = self.keys.stroke.as_ref().map_or(0.0, |s| 0.5 * s.rest_s);
        let range = self.rows.range(span.end_s - rest_s, span.end_s);
        let tilt = |values: &[f64]| {
            let mean = Mean::new(&values[range.clone()])?;
            Some(Tilt { tilt_rad: mean.value, u_rad: mean.u })
        };
        let (Some(command), Some(gauge)) = (tilt(self.command_rad), tilt(self.gauge_rad)) else {
            return Err(MirrorReason::TooFewAtPosition.into());
        };
        Ok(Position {
            command_rad: command.tilt_rad,
            gauge,
            reference: self.reference_rad.and_then(tilt),
            rows_count: range.len(),
        })
    }

    /// Sum of the harmonics 2 to 5 of a sine over its fundamental, in the second half of its time.
    fn tone(&self, segment: &Segment, span: &SegmentSpan) -> Result<Tone, Reason> {
        let Signal::Multisine { period_s, lines } = self.signal(segment)? else {
            return Err(MirrorReason::NotASine.into());
        };
        let length = whole(period_s / self.row_s(span)?)?;
        let half = self.rows.range(span.start_s, span.end_s).len() / 2;
        let part = half / length / TONE_PARTS * length;
        if part == 0 {
            return Err(MirrorReason::ShortSine { periods: 2 * TONE_PARTS }.into());
        }
        let range = self.last_rows(span, TONE_PARTS * part)?;
        let periods = part / length;
        let sent = amplitudes(&self.command_rad[range.clone()], &[TONE_PARTS * periods])[0].norm();
        let shares: Vec<f64> = self.gauge_rad[range]
            .chunks_exact(part)
            .map(|samples| {
                let orders: Vec<usize> = (1..=5).map(|h| h * periods).filter(|o| 2 * o < part).collect();
                let found = amplitudes(samples, &orders);
                let power: f64 = found.iter().skip(1).map(C64::norm_sqr).sum();
                power.sqrt() / found.first().map_or(1.0, |f| f.norm()).max(f64::MIN_POSITIVE)
            })
            .collect();
        let share = Mean::new(&shares).ok_or(MirrorReason::NoSine)?;
        Ok(Tone {
            frequency_hz: lines.first().map_or(0.0, |l| l.frequency_hz),
            distortion_ratio: share.value,
            u_ratio: share.u,
            level_v: 2.0 * sent / self.keys.scale_rad_per_v,
        })
    }
}

/// Takes off the hold of the command from row to row, (1 − e^(−jωT))/(jωT), and a delay.
fn unheld(line: Line, row_s: f64, delay_s: f64) -> Line {
    let half = std::f64::consts::PI * line.frequency_hz * row_s;
    let held = half.sin() / half;
    let turn = half + std::f64::consts::TAU * line.frequency_hz * delay_s;
    Line {
        value: line.value * C64::from_polar(1.0 / held, turn),
        variance: line.variance / (held * held),
        ..line
    }
}

/// A period as a whole number of rows.
pub(super) fn whole(rows: f64) -> Result<usize, Reason> {
    let nearest = rows.round();
    if nearest < 4.0 || (rows - nearest).abs() > 1e-2 {
        return Err(MirrorReason::BrokenPeriod { rows }.into());
    }
    Ok(nearest as usize)
}

fn lowest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn highest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn peak_to_peak(values: &[f64]) -> f64 {
    highest(values) - lowest(values)
}

/// A mean and its standard uncertainty by the scatter.
struct Mean {
    value: f64,
    u: f64,
}

impl Mean {
    /// `None` for fewer than two values, or where one of them is not finite.
    fn new(values: &[f64]) -> Option<Self> {
        let (value, spread) = analysis::uncertainty::mean_of_repeats(values)?;
        (value.is_finite() && spread.u.is_finite()).then_some(Self { value, u: spread.u })
    }
}
