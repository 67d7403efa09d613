//! One point: from rows of the mirror to lines, positions or harmonics.

use std::collections::BTreeMap;
use std::ops::Range;

use analysis::frf::C64;

use super::keys::Keys;
use super::lines::{self, Judged, Standing};
use super::plan::{MEASURE, POSITION, SETTLE, TONE, mirror_axis};
use super::spectra::{amplitudes, errors_in_variables};
use super::{measure, reaction};
use crate::case::{Case, MirrorChannel, Segment};
use crate::excitation::Signal;
use crate::kinds::frames::MIRROR_AXES;
use crate::log::{Rows, SegmentSpan, Window};
use crate::measurement::PointResult;

/// Topic of the mirror.
const TOPIC: &str = "/fsm";
/// Share of the row rate up to which lines count.
const HIGHEST_RATIO: f64 = 0.4;
/// A command this near to its peak over and over is held there by the limit of the driver.
const SATURATED_ROWS: usize = 4;

/// Numbers of a point: lines of gauge and autocollimator, positions, tones, span in time, achieved level.
pub(super) const GAUGE: &str = "gauge";
pub(super) const REFERENCE: &str = "reference";
pub(super) const POSITIONS: &str = "positions";
pub(super) const TONES: &str = "tones";
pub(super) const SPAN: &str = "span";
pub(super) const LEVEL: &str = "level";
pub(super) const REACTION: &str = "reaction";

/// Values of one position in [`POSITIONS`].
pub(super) const POSITION_WIDTH: usize = 7;
/// Values of one sine in [`TONES`]: frequency, share of harmonics, its u, level that was sent in V peak to peak.
pub(super) const TONE_WIDTH: usize = 4;
/// Parts of a tone's record from which the scatter comes.
const TONE_PARTS: usize = 5;

/// Reduces one point, and measures what rests on it alone.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    match Record::of(keys, case, window).and_then(|record| record.reduce()) {
        Ok(numbers) => {
            result.numbers = numbers;
            result.excluded =
                lines::exclusions(&lines::from_numbers(result.numbers.get(GAUGE).map_or(&[], Vec::as_slice)));
            result.measurements = measure::of_point(keys, case, &result.numbers);
        }
        Err(reason) => {
            result.measurements = measure::none_of_point(case, &reason);
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
    fn of(keys: &'a Keys, case: &'a Case, window: &'a Window) -> Result<Self, String> {
        let axis = MIRROR_AXES[mirror_axis(case).ok_or("the point excites no axis of the mirror")?];
        let rows = window.rows(TOPIC).ok_or("the log has no rows of the mirror, `/fsm`")?;
        let column = |part: &str| rows.column(&format!("{part}_{axis}_rad"));
        let needed =
            |part: &str| column(part).ok_or_else(|| format!("`/fsm` has no channel `{part}_{axis}_rad`"));
        let (command_rad, gauge_rad) = (needed("command")?, needed("angle")?);
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

    fn reduce(&self) -> Result<BTreeMap<String, Vec<f64>>, String> {
        let mut numbers = BTreeMap::new();
        let times = self.window.segments.iter().filter(|s| self.label(s) != Some(SETTLE));
        let start_s = times.clone().map(|s| s.start_s).fold(f64::INFINITY, f64::min);
        let end_s = times.map(|s| s.end_s).fold(start_s, f64::max);
        numbers.insert(SPAN.to_owned(), vec![start_s, end_s]);
        for (index, segment) in self.case.segments.iter().enumerate() {
            let span = self.window.segments.iter().find(|s| s.segment == index);
            let span = span.ok_or_else(|| format!("segment `{}` is not in the log", segment.label))?;
            match segment.label.as_str() {
                MEASURE => self.response(segment, span, &mut numbers)?,
                POSITION => self.position(span, &mut numbers)?,
                TONE => self.tone(segment, span, &mut numbers)?,
                _ => {}
            }
        }
        Ok(numbers)
    }

    fn label(&self, span: &SegmentSpan) -> Option<&str> {
        self.case.segments.get(span.segment).map(|s| s.label.as_str())
    }

    fn signal(&self, segment: &Segment) -> Result<&'a Signal, String> {
        let excitation = segment.excited.and_then(|index| self.case.excitations.get(index));
        Ok(&excitation.ok_or("a segment without its excitation")?.signal)
    }

    /// The last `count` rows of a segment; none may be missing.
    fn last_rows(&self, span: &SegmentSpan, count: usize) -> Result<Range<usize>, String> {
        let range = self.rows.range(span.start_s, span.end_s);
        if range.len() < count {
            return Err(format!("expected {count} rows of the mirror, found {}", range.len()));
        }
        Ok(range.end - count..range.end)
    }

    /// Time from row to row; they must be evenly spaced, or a line is not where it is looked for.
    fn row_s(&self, span: &SegmentSpan) -> Result<f64, String> {
        let times = &self.rows.time_s[self.rows.range(span.start_s, span.end_s)];
        let [first, .., last] = times else { return Err("too few rows of the mirror".to_owned()) };
        let row_s = (last - first) / (times.len() - 1) as f64;
        match times.windows(2).find(|pair| (pair[1] - pair[0] - row_s).abs() > 0.5 * row_s) {
            Some(pair) => Err(format!("rows of the mirror are missing at {:.4} s", pair[0])),
            None => Ok(row_s),
        }
    }

    fn response(
        &self,
        segment: &Segment,
        span: &SegmentSpan,
        numbers: &mut BTreeMap<String, Vec<f64>>,
    ) -> Result<(), String> {
        let Signal::Multisine { period_s, lines } = self.signal(segment)? else {
            return Err("the response needs a multisine".to_owned());
        };
        let row_s = self.row_s(span)?;
        let length = whole(period_s / row_s)?;
        let multisine = &self.keys.multisine;
        let count = multisine.periods.saturating_sub(multisine.dropped) as usize;
        let range = self.last_rows(span, count * length)?;
        let command = &self.command_rad[range.clone()];
        self.saturation(command, lines.iter().map(|l| l.amplitude).sum())?;
        let frequencies: Vec<f64> = lines.iter().map(|l| l.frequency_hz).collect();
        let periods = |samples: &[f64]| -> Vec<Vec<C64>> {
            let orders: Vec<usize> =
                frequencies.iter().map(|f| (f * period_s).round() as usize % length).collect();
            samples.chunks_exact(length).map(|period| amplitudes(period, &orders)).collect()
        };
        let sent = periods(command);
        let judged = |samples: &[f64]| -> Result<Vec<Judged>, String> {
            let frf = errors_in_variables(&frequencies, &sent, &periods(samples))
                .ok_or("the sent command does not hold all lines")?;
            Ok(frf.into_iter().map(|line| self.judged(line, row_s)).collect())
        };
        let mut gauge = judged(&self.gauge_rad[range.clone()])?;
        let mut reference = self.reference_rad.map(|r| judged(&r[range.clone()])).transpose()?;
        // The autocollimator sees the mirror itself, the gauge only its motion against the support.
        let seen = reference.as_deref().and_then(|l| reaction::find(l, multisine.reaction_hz));
        if let Some(found) = seen.or_else(|| reaction::find(&gauge, multisine.reaction_hz)) {
            reaction::mark(&mut gauge, &found);
            reference.iter_mut().for_each(|lines| reaction::mark(lines, &found));
            let values = [found.frequency_hz, found.u_hz, found.damping_ratio, found.size_db];
            numbers.insert(REACTION.to_owned(), values.to_vec());
        }
        numbers.insert(GAUGE.to_owned(), lines::to_numbers(&gauge));
        if let Some(reference) = reference {
            numbers.insert(REFERENCE.to_owned(), lines::to_numbers(&reference));
        }
        let (low, high) = extremes(command);
        numbers.insert(LEVEL.to_owned(), vec![(high - low) / self.keys.scale_rad_per_v]);
        Ok(())
    }

    /// A line with hold and known delay of its channel removed, judged.
    fn judged(&self, line: analysis::frf::Line, row_s: f64) -> Judged {
        let line = unheld(line, row_s, self.known_delay_s());
        let snr = line.value.norm_sqr() / line.variance.max(f64::MIN_POSITIVE);
        let standing = if line.frequency_hz > HIGHEST_RATIO / row_s {
            Standing::Fast
        } else if 10.0 * snr.log10() < self.keys.multisine.least_snr_db {
            Standing::Noise
        } else {
            Standing::Counts
        };
        Judged { line, standing }
    }

    fn known_delay_s(&self) -> f64 {
        self.keys.known_delay_s(self.case.mirror_channel.unwrap_or(MirrorChannel::Analog))
    }

    /// A command that rests at its extreme was cut off there.
    fn saturation(&self, command: &[f64], most_rad: f64) -> Result<(), String> {
        let (low, high) = extremes(command);
        let near = 1e-6 * most_rad.max(high - low);
        let resting =
            |at: f64| command.windows(2).filter(|p| p.iter().all(|c| (c - at).abs() < near)).count();
        if resting(low) >= SATURATED_ROWS || resting(high) >= SATURATED_ROWS {
            let micro = |rad: f64| 1e6 * rad;
            return Err(format!(
                "saturation: the command was cut off at {:.0} and {:.0} urad",
                micro(low),
                micro(high)
            ));
        }
        Ok(())
    }

    /// Means of the last half of a position's rest: command, gauge, autocollimator, their u, rows.
    fn position(&self, span: &SegmentSpan, numbers: &mut BTreeMap<String, Vec<f64>>) -> Result<(), String> {
        let rest_s = self.keys.stroke.as_ref().map_or(0.0, |s| 0.5 * s.rest_s);
        let range = self.rows.range(span.end_s - rest_s, span.end_s);
        let of = |values: &[f64]| mean(&values[range.clone()]);
        let (Some(command), Some(gauge)) = (of(self.command_rad), of(self.gauge_rad)) else {
            return Err("too few rows at a position".to_owned());
        };
        let reference = self.reference_rad.and_then(of).unwrap_or([f64::NAN; 2]);
        let known = f64::from(u8::from(reference[0].is_finite()));
        let value = |v: f64| if v.is_finite() { v } else { 0.0 };
        let row: [f64; POSITION_WIDTH] = [
            command[0],
            gauge[0],
            gauge[1],
            known,
            value(reference[0]),
            value(reference[1]),
            range.len() as f64,
        ];
        numbers.entry(POSITIONS.to_owned()).or_default().extend(row);
        Ok(())
    }

    /// Sum of the harmonics 2 to 5 of a sine over its fundamental, in the second half of its time.
    fn tone(
        &self,
        segment: &Segment,
        span: &SegmentSpan,
        numbers: &mut BTreeMap<String, Vec<f64>>,
    ) -> Result<(), String> {
        let Signal::Multisine { period_s, lines } = self.signal(segment)? else {
            return Err("harmonics need a single sine".to_owned());
        };
        let length = whole(period_s / self.row_s(span)?)?;
        let half = self.rows.range(span.start_s, span.end_s).len() / 2;
        let part = half / length / TONE_PARTS * length;
        if part == 0 {
            return Err(format!("a sine shorter than {} periods", 2 * TONE_PARTS));
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
        let [share, u] = mean(&shares).ok_or("no sine in the log")?;
        let frequency_hz = lines.first().map_or(0.0, |l| l.frequency_hz);
        let row: [f64; TONE_WIDTH] = [frequency_hz, share, u, 2.0 * sent / self.keys.scale_rad_per_v];
        numbers.entry(TONES.to_owned()).or_default().extend(row);
        Ok(())
    }
}

/// Takes off the hold of the command from row to row, (1 − e^(−jωT))/(jωT), and a delay.
fn unheld(line: analysis::frf::Line, row_s: f64, delay_s: f64) -> analysis::frf::Line {
    let half = std::f64::consts::PI * line.frequency_hz * row_s;
    let held = half.sin() / half;
    let turn = half + std::f64::consts::TAU * line.frequency_hz * delay_s;
    analysis::frf::Line {
        value: line.value * C64::from_polar(1.0 / held, turn),
        variance: line.variance / (held * held),
        ..line
    }
}

/// A period as a whole number of rows.
fn whole(rows: f64) -> Result<usize, String> {
    let nearest = rows.round();
    if nearest < 4.0 || (rows - nearest).abs() > 1e-2 {
        return Err(format!("a period of {rows:.3} rows, expected a whole number: see the log rate"));
    }
    Ok(nearest as usize)
}

fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)))
}

/// Mean and its standard uncertainty by the scatter.
fn mean(values: &[f64]) -> Option<[f64; 2]> {
    let (mean, spread) = analysis::uncertainty::mean_of_repeats(values)?;
    (mean.is_finite() && spread.u.is_finite()).then_some([mean, spread.u])
}
