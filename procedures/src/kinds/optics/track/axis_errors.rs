//! Errors of one axis by one tracker.

use analysis::estimate::Estimate;
use analysis::tracking::{Peak, Rms, Summary, TrackingError, peaks, summarise};

use super::frames::Frames;
use super::happenings::{Event, among, word};
use super::point::{FINE_TOPIC, Point};
use super::{COARSE, FINE, Names};
use crate::measurement::{Exclusion, Measurement};

/// Seed of the bootstrap: the same log gives the same numbers.
const SEED: u64 = 1;
/// Errors beyond so many root mean squares are peaks.
const PEAK_RATIO: f64 = 4.0;
/// Peaks closer than this are one.
const APART_S: f64 = 0.3;
/// So many peaks are told one by one.
const TOLD: usize = 5;

/// Errors of one axis, and what explains them.
pub(super) struct Errors<'a> {
    pub(super) topic: &'static str,
    /// 0 azimuth (across the elevation axis), 1 elevation.
    pub(super) axis: usize,
    /// Name of the axis.
    pub(super) name: &'a str,
    pub(super) frames: &'a Frames,
    /// Declared beforehand.
    pub(super) windows: &'a [[f64; 2]],
    /// Where the fine loop could not follow.
    pub(super) spoiled: Vec<[f64; 2]>,
    pub(super) events: Vec<Event>,
}

/// Frames of an axis within the record.
pub(super) struct Samples {
    pub(super) time_s: Vec<f64>,
    pub(super) error_rad: Vec<f64>,
    /// Inside the declared windows.
    declared: Vec<bool>,
    /// Left out for that, or because the loop could not follow.
    pub(super) left_out: Vec<bool>,
}

impl Samples {
    /// Root mean square of what was not left out.
    fn rms_rad(&self) -> f64 {
        let kept = || self.error_rad.iter().zip(&self.left_out).filter(|(_, out)| !**out).map(|(e, _)| e);
        (kept().map(|e| e * e).sum::<f64>() / kept().count().max(1) as f64).sqrt()
    }
}

impl Errors<'_> {
    pub(super) fn samples(&self, record_s: [f64; 2]) -> Samples {
        let shown = self.frames.shown(record_s);
        let within = |stretches: &[[f64; 2]], k: &usize| {
            stretches.iter().any(|[from, to]| (*from..=*to).contains(&self.frames.time_s[*k]))
        };
        let declared: Vec<bool> = shown.iter().map(|k| within(self.windows, k)).collect();
        let spoiled = shown.iter().map(|k| within(&self.spoiled, k));
        Samples {
            left_out: declared.iter().zip(spoiled).map(|(declared, spoiled)| *declared || spoiled).collect(),
            declared,
            time_s: shown.iter().map(|&k| self.frames.time_s[k]).collect(),
            error_rad: shown.iter().map(|&k| self.frames.error_rad[self.axis][k]).collect(),
        }
    }

    /// Peaks of a record, and what explains each.
    pub(super) fn peaks(&self, samples: &Samples) -> Vec<Peak> {
        let apart = (APART_S / self.frames.period_s).ceil() as usize;
        let happenings = among(&self.events, &samples.time_s);
        peaks(&samples.error_rad, PEAK_RATIO * samples.rms_rad(), apart, &happenings)
    }

    fn is_fine(&self) -> bool {
        self.topic == FINE_TOPIC
    }

    fn names(&self) -> &'static Names {
        if self.is_fine() { &FINE } else { &COARSE }
    }
}

/// The six measurements of an axis.
pub(super) fn measure(point: &Point<'_>, errors: &Errors<'_>) -> Vec<Measurement> {
    let names = errors.names();
    let of = |index: usize, found| point.measurement(names[index], errors.name, found, errors.topic);
    let none = |reason: &str| (0..names.len()).map(|index| of(index, Err(reason.to_owned()))).collect();
    let Some(record_s) = point.record_s else {
        return none(point.cut.as_deref().unwrap_or("there is no record"));
    };
    let samples = errors.samples(record_s);
    let summary = match summarise(&samples.error_rad, &samples.left_out, SEED) {
        Ok(summary) => summary,
        Err(error) => return none(&error.to_string()),
    };
    let n = samples.error_rad.len();
    let exact = |value: f64, u: f64| Ok(Estimate { value, u, dof: f64::INFINITY, n });
    let inside = summary.inside.ok_or_else(|| "nothing or too little was left out".to_owned());
    let mut all = vec![
        of(0, estimate(&summary.outside)),
        of(1, estimate(&summary.whole)),
        of(2, inside.map(of_rms)),
        of(3, exact(summary.inside_ratio, 1.0 / n as f64)),
        of(4, exact(summary.percentile_999, summary.percentile_999_u)),
        of(5, exact(summary.largest, frame_noise_rad(&samples))),
    ];
    all[0].flags = told(point, errors, &samples, &summary);
    all[0].excluded = excluded(errors, &samples, record_s);
    all[5].flags = causes(errors, &samples, record_s[0]);
    for measurement in &mut all {
        measurement.inconclusive = point.cut.clone().or(measurement.inconclusive.take());
    }
    if summary.inside_ratio > point.keys.most_in_windows && !errors.is_fine() {
        let share = 100.0 * summary.inside_ratio;
        let most = 100.0 * point.keys.most_in_windows;
        let reason = format!("{share:.1} % of the record lies in windows, at most {most:.1} % may");
        all[0].inconclusive.get_or_insert(reason);
    }
    all
}

fn of_rms(rms: Rms) -> Estimate {
    Estimate { value: rms.value, u: rms.u, dof: rms.dof, n: rms.n }
}

fn estimate(found: &Result<Rms, TrackingError>) -> Result<Estimate, String> {
    found.as_ref().map(|rms| of_rms(*rms)).map_err(ToString::to_string)
}

/// White noise of single frames, from second differences: an upper bound, as motion adds to it.
fn frame_noise_rad(samples: &Samples) -> f64 {
    let differences = samples.error_rad.windows(3).map(|e| (e[2] - 2.0 * e[1] + e[0]).abs());
    let mut sizes: Vec<f64> = differences.collect();
    sizes.sort_by(f64::total_cmp);
    // The median magnitude of a normal variable is 0.6745 of its standard deviation; 1, 2 and 1 squared are 6.
    sizes.get(sizes.len() / 2).map_or(0.0, |median| median / 0.6745 / 6.0_f64.sqrt())
}

fn told(point: &Point<'_>, errors: &Errors<'_>, samples: &Samples, summary: &Summary) -> Vec<String> {
    let urad = |rad: f64| format!("{:.2} urad", 1e6 * rad);
    let mut all = vec![
        format!("mean {}", urad(summary.mean)),
        format!("noise of a frame about {}, contained", urad(frame_noise_rad(samples))),
    ];
    let elevation_rad = point.case.requested.first().map_or(0.0, |r| r.value);
    if let (0, Ok(rms)) = (errors.axis, &summary.outside) {
        all.push(format!("across the elevation axis; {} of azimuth", urad(rms.value / elevation_rad.cos())));
    }
    if summary.inside_ratio == 0.0 {
        all.push("no window was opened".to_owned());
    }
    all
}

fn excluded(errors: &Errors<'_>, samples: &Samples, [from_s, to_s]: [f64; 2]) -> Vec<Exclusion> {
    let frames = errors.frames.time_s.iter().filter(|t| (from_s..to_s).contains(t)).count();
    let declared = samples.declared.iter().filter(|d| **d).count();
    let left_out = samples.left_out.iter().filter(|l| **l).count();
    let all = [
        (frames - samples.time_s.len(), "the frame does not show the target"),
        (declared, "the target's acceleration opened a window"),
        (left_out - declared, "the mirror stood at the end of its stroke, or the fine track began again"),
    ];
    let exclusion = |(count, reason): (usize, &str)| Exclusion {
        count,
        of: "frames".to_owned(),
        reason: reason.to_owned(),
    };
    all.into_iter().filter(|(count, _)| *count > 0).map(exclusion).collect()
}

/// How many peaks there are of each cause, and the largest of them.
fn causes(errors: &Errors<'_>, samples: &Samples, start_s: f64) -> Vec<String> {
    let mut found = errors.peaks(samples);
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for peak in &found {
        match counts.iter_mut().find(|(cause, _)| *cause == word(peak.cause)) {
            Some((_, count)) => *count += 1,
            None => counts.push((word(peak.cause), 1)),
        }
    }
    let counted: Vec<String> = counts.iter().map(|(cause, count)| format!("{count} by {cause}")).collect();
    let all = if counted.is_empty() { "none".to_owned() } else { counted.join(", ") };
    let mut told = vec![format!("peaks beyond {PEAK_RATIO} times the root mean square: {all}")];
    found.sort_by(|a, b| b.value.abs().total_cmp(&a.value.abs()).then(a.at.cmp(&b.at)));
    told.extend(found.iter().take(TOLD).map(|peak| {
        let at_s = samples.time_s[peak.at] - start_s;
        format!("{:.0} urad at {at_s:.2} s: {}", 1e6 * peak.value, word(peak.cause))
    }));
    told
}
