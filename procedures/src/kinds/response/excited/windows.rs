//! From a record to amplitudes of every line in every window that can be used.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use analysis::frf::{C64, Frf, Line};
use analysis::periodic::{self, Distortion, PeriodicError, Realisation, RobustLine, Windows};

use super::Excited;
use super::course::{self, Course};
use super::plan::{self, EXCITED, TAKE_OVER_S};
use super::record::{self, Candidate, Channel, Record, sliding, usable, why_none};
use crate::axis::AxisLimits;
use crate::case::{Case, Mode};
use crate::excitation::Injection;
use crate::log::{SegmentSpan, Window};
use crate::measurement::Exclusion;
use crate::reason::{Reason, ResponseReason};
use crate::stimulus::Stimulus;

/// Time in which a light mode forgets that the excitation began (ζω = 3.9 1/s at 17 Hz: 0.04 % are left).
const WARM_UP_S: f64 = 2.0;
/// Room for rounding between segment events and rows.
const ROUNDING_S: f64 = 1e-5;

/// Lines that several realisations share, with their windows.
#[derive(Clone, Debug)]
struct Group {
    frequency_hz: Vec<f64>,
    /// Realisation of each window.
    realisation: Vec<usize>,
    /// First row of each window.
    starts: Vec<usize>,
    /// Place of each window in its stroke, and which way that goes.
    place: Vec<usize>,
    /// Channel → window → line, over the excitation.
    z: BTreeMap<Channel, Vec<Vec<C64>>>,
    /// What the lines show that its grid leaves out, torque to rate.
    detected: Option<Distortion>,
    /// Realisations have other phases: only then does their scatter show distortion.
    differ: bool,
    /// By how much the variance of each line grows because repetitions were told apart, and the windows that it took.
    spent: Vec<[f64; 2]>,
}

impl Group {
    /// Takes out what repeats with the strokes, line by line, in all channels.
    fn take_out_repeated(&mut self, windows: &Windows, record: &Record<'_>) -> Result<(), PeriodicError> {
        let excitation = periodic::Channel { name: "excitation", samples: record.excitation };
        let seen = periodic::spectra(windows, &self.frequency_hz, &[excitation], &[])?.remove(0);
        let classes = record::classes(&self.place);
        self.spent = vec![[1.0, 0.0]; self.frequency_hz.len()];
        for (l, &hz) in self.frequency_hz.iter().enumerate() {
            // Phases of the spectra refer to the record's start; what repeats does so from the window's.
            let inverse = |w: usize| {
                let since_s = windows.starts[w] as f64 / windows.sample_rate_hz;
                (seen[w][l] * C64::from_polar(1.0, 2.0 * PI * (hz * since_s).fract())).inv()
            };
            let inverse: Vec<C64> = (0..windows.starts.len()).map(inverse).collect();
            for channel in self.z.values_mut() {
                let mut line: Vec<C64> = channel.iter().map(|window| window[l]).collect();
                if let Some(left) = record::take_out(&mut line, &inverse, &classes) {
                    self.spent[l] = [1.0 / left, classes.len() as f64];
                    channel.iter_mut().zip(line).for_each(|(window, z)| window[l] = z);
                }
            }
        }
        Ok(())
    }

    /// Realisations of the multisine, each once.
    fn realisations(&self) -> Vec<usize> {
        let mut names = self.realisation.clone();
        names.dedup();
        names
    }

    /// Noise and distortion apart; nothing where the group has one realisation only.
    fn robust(&self, u: &[Vec<C64>], y: &[Vec<C64>]) -> Vec<RobustLine> {
        if !self.differ {
            return Vec::new();
        }
        let names = self.realisations();
        let picked = |z: &[Vec<C64>], which: usize| -> Vec<Vec<C64>> {
            let own = z.iter().zip(&self.realisation).filter(|(_, r)| **r == which);
            own.map(|(lines, _)| lines.clone()).collect()
        };
        let split: Vec<_> = names.iter().map(|&r| (picked(u, r), picked(y, r))).collect();
        let realisations: Vec<Realisation<'_>> = split.iter().map(|(u, y)| Realisation { u, y }).collect();
        periodic::robust(&self.frequency_hz, &realisations).unwrap_or_default()
    }

    /// Variances and degrees of freedom of lines that rest on fewer independent windows than there are.
    fn corrected(&self, lines: Frf) -> Frf {
        let one = |(l, line): (usize, Line)| {
            let [growth, windows] = self.spent.get(l).copied().unwrap_or([1.0, 0.0]);
            let dof = line.dof - windows;
            Line { variance: growth * line.variance * line.dof / dof, dof, ..line }
        };
        lines.into_iter().enumerate().map(one).collect()
    }

    /// Leaves out the lines that are not wanted.
    fn keep(&mut self, wanted: impl Fn(f64) -> bool) {
        let kept: Vec<usize> =
            (0..self.frequency_hz.len()).filter(|&l| wanted(self.frequency_hz[l])).collect();
        self.frequency_hz = kept.iter().map(|&l| self.frequency_hz[l]).collect();
        if !self.spent.is_empty() {
            self.spent = kept.iter().map(|&l| self.spent[l]).collect();
        }
        for window in self.z.values_mut().flatten() {
            *window = kept.iter().map(|&l| window[l]).collect();
        }
    }
}

/// What the windows of a point hold.
#[derive(Clone, Debug)]
pub(in crate::kinds) struct Measured {
    groups: Vec<Group>,
    /// Mean rate, as a magnitude, over all windows used.
    pub(in crate::kinds) mean_rate_rad_per_s: f64,
    /// Whether the axis slid in all of them.
    pub(in crate::kinds) slides: bool,
    /// Smallest and largest angle, and the mean over time.
    pub(in crate::kinds) angle_rad: [f64; 3],
    pub(in crate::kinds) windows: usize,
    /// Size of the excitation in the log over the size that was planned.
    pub(in crate::kinds) reached_ratio: f64,
    pub(in crate::kinds) excluded: Vec<Exclusion>,
}

/// What is read of a record. A command that nothing is added to says nothing of the loop, and may stand still.
fn channels(keys: &Excited) -> &'static [Channel] {
    const ALL: &[Channel] = &[
        Channel::Error,
        Channel::Rate,
        Channel::Torque,
        Channel::Shown,
        Channel::Angle,
        Channel::OtherRate,
        Channel::Commanded,
    ];
    match keys.into {
        _ if keys.background.target_turn_s.is_some() => &[Channel::Asked, Channel::Commanded],
        Injection::Velocity => ALL,
        _ => &ALL[..ALL.len() - 1],
    }
}

/// Amplitudes of all usable windows of a point.
pub(in crate::kinds) fn measure(
    keys: &Excited,
    case: &Case,
    window: &Window,
    record: &Record<'_>,
    course: &Course,
    limits: &AxisLimits,
) -> Result<Measured, Reason> {
    let rate_hz = limits.row_rate_hz();
    let length = (course.window_s * rate_hz).round() as usize;
    let candidates = candidates(case, window, record, course, length);
    let mut excluded = Vec::new();
    let rests = keys.background.velocity_rad_per_s == 0.0;
    let kept = usable(candidates, record, rests, length, limits, &mut excluded);
    if kept.len() < 2 {
        return Err(course::not_found(case, window).unwrap_or_else(|| why_none(&excluded)).into());
    }
    let rate = |c: &Candidate| mean(&record.rate[c.start..c.start + length]).abs();
    let (kept, slides) = sliding(kept, keys, &rate, &mut excluded);
    let rates: Vec<f64> = kept.iter().map(rate).collect();
    let mut groups = groups(&kept, record, course, limits, length, channels(keys))?;
    let forbidden = course.forbidden_hz(limits);
    let [from_hz, to_hz] = keys.band_hz.map(|hz| hz * (1.0 + 1e-9));
    let wanted = |hz: f64| {
        hz * (1.0 + 2e-9) >= from_hz && hz <= to_hz && !forbidden.iter().any(|band| band.contains(&hz))
    };
    groups.iter_mut().for_each(|group| group.keep(wanted));
    let signal = |realisation: usize| &case.excitations[realisation].signal;
    for group in &mut groups {
        let names = group.realisations();
        let others = |k: usize| &names[..k];
        group.differ = (0..names.len()).all(|k| others(k).iter().all(|&r| signal(r) != signal(names[k])));
    }
    Ok(Measured {
        groups,
        mean_rate_rad_per_s: mean(&rates),
        slides,
        angle_rad: angles(&kept, record, length),
        windows: kept.len(),
        reached_ratio: {
            let first = &kept[0];
            let began_s = began_s(case, window, first.realisation);
            let excitation = &case.excitations[first.realisation];
            record::ratio(excitation, began_s, record, limits, first.start..first.start + length)
        },
        excluded,
    })
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn angles(kept: &[Candidate], record: &Record<'_>, length: usize) -> [f64; 3] {
    let all = || kept.iter().flat_map(|c| &record.angle_rad[c.start..c.start + length]);
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(*a), h.max(*a)));
    [low, high, all().sum::<f64>() / (kept.len() * length) as f64]
}

/// Windows as planned, where the record has them.
fn candidates(
    case: &Case,
    window: &Window,
    record: &Record<'_>,
    course: &Course,
    length: usize,
) -> Vec<Candidate> {
    let mut all = Vec::new();
    for span in &window.segments {
        let Some(segment) = case.segments.get(span.segment) else { continue };
        let (Some(realisation), true) = (segment.excited, segment.label == EXCITED) else { continue };
        let Some(signal) = case.excitations.get(realisation).map(|e| &e.signal) else { continue };
        let began_s = began_s(case, window, realisation);
        let starts_s = match segment.mode {
            Mode::Track => steady_s(span, record, course, length),
            _ => starts_s(span, &segment.stimulus, course),
        };
        for (place, start_s) in starts_s {
            let start = record.row_at(start_s - ROUNDING_S);
            let there = start_s >= began_s + WARM_UP_S - ROUNDING_S
                && start_s + course.window_s <= span.end_s + ROUNDING_S
                && start + length <= record.time_s.len();
            // At rest a step's first window is that in which it settles; on strokes the turn-round is.
            let settle_s = if course.cycles == 0 { course.window_s } else { 0.0 };
            let lines_hz = plan::lines_hz(signal, start_s - began_s, course.window_s, settle_s);
            if there && !lines_hz.is_empty() {
                all.push(Candidate { start, realisation, lines_hz, place });
            }
        }
    }
    all
}

/// Times at which the windows of a segment behind a target begin.
fn steady_s(span: &SegmentSpan, record: &Record<'_>, course: &Course, length: usize) -> Vec<(usize, f64)> {
    let rows = record.row_at(span.start_s)..record.row_at(span.end_s);
    let starts = course::steady(record.rate, rows, length, course);
    starts.into_iter().map(|row| (0, record.time_s[row])).collect()
}

/// When an excitation began to play: with the first segment that names it.
fn began_s(case: &Case, window: &Window, realisation: usize) -> f64 {
    let names = |span: &&SegmentSpan| {
        case.segments.get(span.segment).is_some_and(|segment| segment.excited == Some(realisation))
    };
    window.segments.iter().filter(names).map(|span| span.start_s).fold(f64::INFINITY, f64::min)
}

/// Times at which the windows of a segment begin, with their places in a stroke there or back.
fn starts_s(span: &SegmentSpan, stimulus: &Stimulus, course: &Course) -> Vec<(usize, f64)> {
    let (strokes, first_s) = match stimulus {
        Stimulus::Reversals { cycles, .. } => (2 * cycles, course.first_s),
        Stimulus::Cruise { .. } => (1, TAKE_OVER_S),
        _ => (1, course.first_s),
    };
    // Rows begin with the first tick of an excited segment: a window that begins a whole number of rows later begins on one.
    (0..strokes)
        .flat_map(|stroke| {
            let first_s = span.start_s + f64::from(stroke) * course.stroke_s + first_s;
            let back = stroke % 2 * course.windows;
            (0..course.windows).map(move |k| ((back + k) as usize, first_s + f64::from(k) * course.window_s))
        })
        .collect()
}

/// Realisations with the same lines, together.
fn groups(
    kept: &[Candidate],
    record: &Record<'_>,
    course: &Course,
    limits: &AxisLimits,
    length: usize,
    channels: &[Channel],
) -> Result<Vec<Group>, PeriodicError> {
    let mut groups: Vec<Group> = Vec::new();
    for candidate in kept {
        let same = groups.iter_mut().find(|g| g.frequency_hz == candidate.lines_hz);
        let group = match same {
            Some(group) => group,
            None => {
                let realisation = Vec::new();
                let starts = Vec::new();
                let z = BTreeMap::new();
                let place = Vec::new();
                let spent = Vec::new();
                let frequency_hz = candidate.lines_hz.clone();
                let detected = None;
                let differ = true;
                groups.push(Group { frequency_hz, realisation, starts, place, z, detected, differ, spent });
                groups.last_mut().expect("one was pushed")
            }
        };
        group.realisation.push(candidate.realisation);
        group.starts.push(candidate.start);
        group.place.push(candidate.place);
    }
    groups.retain(|g| g.starts.len() >= 2);
    let forbidden = course.forbidden_hz(limits);
    let nuisance = cogging(record, course, limits);
    let nuisance: Vec<&[f64]> = nuisance.iter().map(Vec::as_slice).collect();
    for group in &mut groups {
        let windows = Windows { sample_rate_hz: limits.row_rate_hz(), length, starts: group.starts.clone() };
        // Where lines lie on cogging it cannot be told from them, and scatters from window to window instead.
        let on_cogging = |hz: &f64| forbidden.iter().any(|band| band.contains(hz));
        let clear = !group.frequency_hz.iter().any(on_cogging);
        let nuisance = if clear { &nuisance[..] } else { &[] };
        group.z = transfers(&windows, &group.frequency_hz, record, nuisance, channels)?;
        if course.cycles > 0 {
            group.take_out_repeated(&windows, record)?;
        }
        // Phases repeat within a realisation only.
        let own = group.starts.iter().zip(&group.realisation).filter(|(_, r)| **r == group.realisation[0]);
        let first = Windows { starts: own.map(|(start, _)| *start).collect(), ..windows };
        group.detected = record::distortion(&first, &group.frequency_hz, course, record, nuisance);
    }
    Ok(groups)
}

fn transfers(
    windows: &Windows,
    grid_hz: &[f64],
    record: &Record<'_>,
    nuisance: &[&[f64]],
    channels: &[Channel],
) -> Result<BTreeMap<Channel, Vec<Vec<C64>>>, PeriodicError> {
    let rows = 0..record.time_s.len();
    let there: Vec<(Channel, Vec<f64>)> = channels
        .iter()
        .filter_map(|&channel| Some((channel, record.values(channel, rows.clone())?)))
        .filter(|(channel, samples)| *channel != Channel::OtherRate || moves(samples, windows))
        .collect();
    let names: Vec<String> = there.iter().map(|(channel, _)| format!("{channel:?}")).collect();
    let channels: Vec<periodic::Channel<'_>> =
        there.iter().zip(&names).map(|((_, samples), name)| periodic::Channel { name, samples }).collect();
    let transfer =
        |nuisance: &[&[f64]]| periodic::transfer(windows, grid_hz, record.excitation, &channels, nuisance);
    // A dense grid between the multiples of 1/T_w can follow anything on a window, cogging too: then it scatters from
    // window to window instead, because the excitation meets it at other phases.
    let z = match transfer(nuisance) {
        Err(PeriodicError::Dependent { .. }) => transfer(&[]),
        other => other,
    }?;
    Ok(there.iter().map(|(channel, _)| *channel).zip(z).collect())
}

/// Whether a channel changes in every window. The encoder of an axis that its friction holds does not: that axis has no response.
fn moves(samples: &[f64], windows: &Windows) -> bool {
    let window = |start: &usize| samples.get(*start..*start + windows.length).unwrap_or_default();
    windows.starts.iter().all(|start| window(start).windows(2).any(|pair| pair[0] != pair[1]))
}

/// Cogging at the angle where the axis is: the first two orders are fitted beside the lines, so that they do not leak
/// into them.
fn cogging(record: &Record<'_>, course: &Course, limits: &AxisLimits) -> Vec<Vec<f64>> {
    let order = limits.cogging_orders_per_rev;
    // Less than a period in a window is a drift, which is fitted anyway.
    let turns = order * course.velocity_rad_per_s * course.window_s / (2.0 * PI);
    if turns < 0.5 {
        return Vec::new();
    }
    let column = |f: &dyn Fn(f64) -> f64| record.angle_rad.iter().map(|a| f(order * a)).collect::<Vec<f64>>();
    vec![
        column(&|a| a.cos()),
        column(&|a| a.sin()),
        column(&|a| (2.0 * a).cos()),
        column(&|a| (2.0 * a).sin()),
    ]
}

impl Measured {
    /// The response from one channel to another over all lines, ascending; joint input–output, so that it is right in a
    /// closed loop.
    pub(in crate::kinds) fn response(&self, from: Channel, to: Channel) -> Result<Frf, Reason> {
        let mut all = Frf::new();
        for group in &self.groups {
            let (Some(u), Some(y)) = (group.z.get(&from), group.z.get(&to)) else {
                return Err(
                    ResponseReason::NoChannels { from: format!("{from:?}"), to: format!("{to:?}") }.into()
                );
            };
            let lines = periodic::errors_in_variables(&group.frequency_hz, u, y)?;
            let mut lines = group.corrected(lines);
            // What distorts repeats from window to window of a realisation: only realisations show its scatter.
            for (line, robust) in lines.iter_mut().zip(group.robust(u, y)) {
                if robust.is_distorted() && robust.response.variance > line.variance {
                    (line.variance, line.dof) = (robust.response.variance, robust.response.dof);
                }
            }
            all.extend(lines);
        }
        all.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        Ok(all)
    }

    /// What left-out lines show of torque to rate, where the grid leaves any out.
    pub(in crate::kinds) fn left_out(&self) -> Option<&Distortion> {
        self.groups.iter().find_map(|group| group.detected.as_ref())
    }

    /// Noise and distortion of that response apart, where a grid has two realisations.
    pub(in crate::kinds) fn distortion(&self, from: Channel, to: Channel) -> Vec<RobustLine> {
        let robust = |group: &Group| Some(group.robust(group.z.get(&from)?, group.z.get(&to)?));
        self.groups.iter().filter_map(robust).flatten().collect()
    }
}

/// How far a direct estimate lies from the joint one at a line.
#[derive(Clone, Copy, Debug)]
pub(in crate::kinds) struct Departure {
    pub(in crate::kinds) frequency_hz: f64,
    pub(in crate::kinds) departure: f64,
    pub(in crate::kinds) u: f64,
}

impl Measured {
    /// The largest relative departure of Σ Y·U*/Σ|U|² over the windows from the joint estimate, and how many lines were
    /// compared; of those that count and scatter by less than
    /// 10 %.
    pub(in crate::kinds) fn direct_departure(
        &self,
        from: Channel,
        to: Channel,
        counted_hz: &[f64],
    ) -> Option<(Departure, usize)> {
        const SHARP: f64 = 0.1;
        let mut all = Vec::new();
        for group in &self.groups {
            let u = group.z.get(&from)?;
            let y = group.z.get(&to)?;
            let joint = periodic::errors_in_variables(&group.frequency_hz, u, y).ok()?;
            let counts = |line: &Line| line.relative_sd() < SHARP && counted_hz.contains(&line.frequency_hz);
            for (l, line) in joint.iter().enumerate().filter(|(_, line)| counts(line)) {
                let cross: C64 = u.iter().zip(y).map(|(u, y)| y[l] * u[l].conj()).sum();
                let power: f64 = u.iter().map(|u| u[l].norm_sqr()).sum();
                let departure = (cross / power / line.value - 1.0).norm();
                all.push(Departure { frequency_hz: line.frequency_hz, departure, u: line.relative_sd() });
            }
        }
        let worst = all.iter().copied().max_by(|a, b| a.departure.total_cmp(&b.departure))?;
        Some((worst, all.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_that_its_friction_holds_in_one_window_has_no_response() {
        let mut samples: Vec<f64> = (0..12).map(f64::from).collect();
        let windows = Windows { sample_rate_hz: 1.0, length: 4, starts: vec![0, 8] };
        assert!(moves(&samples, &windows));
        samples[8..].fill(3.0);
        assert!(!moves(&samples, &windows), "it stands still in the second window");
        assert!(moves(&samples, &Windows { starts: vec![0, 4], ..windows }), "no window is where it stands");
    }
}
