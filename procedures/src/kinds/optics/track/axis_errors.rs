//! Errors of one axis by one tracker: numbers, and pictures over time with what explains them.

use analysis::estimate::Estimate;
use analysis::spectra::{CrossSpectra, WelchSettings};
use analysis::tracking::{Peak, Rms, Summary, TrackingError, peaks, summarise};

use super::point::{FINE_TOPIC, Point};
use super::record::{Event, Frames, Sight, among, word};
use super::{COARSE, FINE, Names};
use crate::measurement::{Exclusion, Measurement};
use crate::reason::{OpticsReason, Reason};
use crate::trace::{LimitLine, MAX_POINTS, Mark, Plot, Scale, Series, Span, Style};

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
    let none = |reason: &Reason| (0..names.len()).map(|index| of(index, Err(reason.to_owned()))).collect();
    let Some(record_s) = point.record_s else {
        return none(&point.cut.clone().unwrap_or_else(|| OpticsReason::NoTrackRecord.into()));
    };
    let samples = errors.samples(record_s);
    let summary = match summarise(&samples.error_rad, &samples.left_out, SEED) {
        Ok(summary) => summary,
        Err(error) => return none(&error.into()),
    };
    let n = samples.error_rad.len();
    let exact = |value: f64, u: f64| Ok(Estimate { value, u, dof: f64::INFINITY, n });
    let inside = summary.inside.ok_or_else(|| OpticsReason::LittleLeftOut.into());
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
        measurement.inconclusive =
            point.cut.as_ref().map(Reason::to_string).or(measurement.inconclusive.take());
    }
    if summary.inside_ratio > point.keys.most_in_windows && !errors.is_fine() {
        let share = 100.0 * summary.inside_ratio;
        let most = 100.0 * point.keys.most_in_windows;
        all[0].inconclusive.get_or_insert(OpticsReason::InWindows { share, most }.to_string());
    }
    all
}

fn of_rms(rms: Rms) -> Estimate {
    Estimate { value: rms.value, u: rms.u, dof: rms.dof, n: rms.n }
}

fn estimate(found: &Result<Rms, TrackingError>) -> Result<Estimate, Reason> {
    found.as_ref().map(|rms| of_rms(*rms)).map_err(|e| e.clone().into())
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
        format!("includes noise of about {} per frame", urad(frame_noise_rad(samples))),
    ];
    let elevation_rad = point.case.requested.first().map_or(0.0, |r| r.value);
    if let (0, Ok(rms)) = (errors.axis, &summary.outside) {
        all.push(format!("in cross-elevation; {} in azimuth", urad(rms.value / elevation_rad.cos())));
    }
    if summary.inside_ratio == 0.0 {
        all.push("no frame lies in a window".to_owned());
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
        (
            left_out - declared,
            "the mirror was at the end of its stroke, or the fine track had just restarted",
        ),
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

/// Classes of a histogram.
const CLASSES: usize = 60;
/// Longest segment of a spectrum: 10 s at 200 frames a second.
const SEGMENT: usize = 2048;
/// So many peaks of each axis are marked.
const MARKS: usize = 5;
const URAD: f64 = 1e6;

/// The pictures of one tracker, both axes in each.
pub(super) fn of(point: &Point<'_>, errors: &[Errors<'_>; 2], sight: Option<&Sight>) -> Vec<Plot> {
    let Some(record_s) = point.record_s else { return Vec::new() };
    let samples = errors.each_ref().map(|e| e.samples(record_s));
    if samples.iter().any(|s| s.time_s.is_empty()) {
        return Vec::new();
    }
    let tracker = if errors[0].topic == FINE_TOPIC { "fine" } else { "coarse" };
    let id = point.case.point.replace(|c: char| !c.is_ascii_alphanumeric(), "-");
    let id = |what: &str| format!("{tracker}-{what}-{id}");
    let title = |what: &str| format!("{} track {what}, {}", capital(tracker), point.case.point);
    let time = over_time(id("error"), title("error"), errors, &samples, record_s[0]);
    let panel = sight.filter(|_| tracker == "coarse");
    let panel = panel.map(|sight| acceleration(point, sight, record_s).panel_of(&time));
    let spectrum = spectrum(id("spectrum"), title("spectrum"), errors, &samples);
    [Some(time), panel, Some(histogram(id("histogram"), title("histogram"), &samples)), spectrum]
        .into_iter()
        .flatten()
        .collect()
}

fn capital(word: &str) -> &'static str {
    if word == "fine" { "Fine" } else { "Coarse" }
}

fn over_time(
    id: String,
    title: String,
    errors: &[Errors<'_>; 2],
    samples: &[Samples; 2],
    start_s: f64,
) -> Plot {
    let mut marks = Vec::new();
    let series = [0, 1].map(|axis| {
        let time: Vec<f64> = samples[axis].time_s.iter().map(|t| t - start_s).collect();
        let error: Vec<f64> = samples[axis].error_rad.iter().map(|e| URAD * e).collect();
        let mark = |peak: Peak| Mark {
            label: format!("{} {}", errors[axis].name, word(peak.cause)),
            x: time[peak.at],
        };
        let mut peaks = errors[axis].peaks(&samples[axis]);
        peaks.sort_by(|a, b| b.value.abs().total_cmp(&a.value.abs()).then(a.at.cmp(&b.at)));
        marks.extend(peaks.into_iter().take(MARKS).map(mark));
        Series::thinned(
            ["cross-elevation (azimuth)", "elevation"][axis],
            Style::Line,
            [&time, &error],
            MAX_POINTS,
        )
    });
    let plot = Plot::new(id, title, Scale::linear("time", "s"), Scale::linear("error", "urad"));
    Plot { series: series.into(), marks, spans: shaded(errors, samples, start_s), ..plot }
}

/// The windows of both axes as far as they lie in the record: what the numbers outside of windows leave out.
fn shaded(errors: &[Errors<'_>; 2], samples: &[Samples; 2], start_s: f64) -> Vec<Span> {
    let mut all = Vec::new();
    for (own, samples) in errors.iter().zip(samples) {
        let Some(&end_s) = samples.time_s.last() else { continue };
        for [from_s, to_s] in own.windows {
            let x = [from_s - start_s, to_s.min(end_s) - start_s];
            if x[1] > x[0].max(0.0) {
                all.push(Span { label: format!("window of {}", own.name), x: [x[0].max(0.0), x[1]] });
            }
        }
    }
    all
}

/// Acceleration of the target with the threshold of the windows.
fn acceleration(point: &Point<'_>, sight: &Sight, [from_s, to_s]: [f64; 2]) -> Plot {
    let from = sight.time_s.partition_point(|&t| t < from_s);
    let to = sight.time_s.partition_point(|&t| t < to_s);
    let time: Vec<f64> = sight.time_s[from..to].iter().map(|t| t - from_s).collect();
    let series = [0, 1].map(|axis| {
        let values: Vec<f64> =
            sight.acceleration_rad_per_s2[axis][from..to].iter().map(|a| 1e3 * a).collect();
        Series::thinned(["azimuth", "elevation"][axis], Style::Line, [&time, &values], MAX_POINTS)
    });
    let threshold = 1e3 * point.keys.threshold_rad_per_s2;
    let limit = |sign: f64| LimitLine { label: "opens a window".to_owned(), y: sign * threshold, x: None };
    let id = format!(
        "target-acceleration-{}",
        point.case.point.replace(|c: char| !c.is_ascii_alphanumeric(), "-")
    );
    let ordinate = Scale::linear("acceleration of the target", "mrad/s^2");
    let plot = Plot::new(id, "Acceleration of the target", Scale::linear("time", "s"), ordinate);
    Plot { series: series.into(), limits: vec![limit(1.0), limit(-1.0)], ..plot }
}

/// Of the samples outside the windows.
fn histogram(id: String, title: String, samples: &[Samples; 2]) -> Plot {
    let kept = samples.each_ref().map(|s| -> Vec<f64> {
        s.error_rad.iter().zip(&s.left_out).filter(|(_, out)| !**out).map(|(e, _)| URAD * e).collect()
    });
    let largest = kept.iter().flatten().fold(0.0_f64, |most, e| most.max(e.abs())).max(f64::MIN_POSITIVE);
    let width = 2.0 * largest / CLASSES as f64;
    let series = [0, 1].map(|axis: usize| {
        let mut counts = vec![0.0; CLASSES];
        for error in &kept[axis] {
            let class = ((error + largest) / width).floor() as usize;
            counts[class.min(CLASSES - 1)] += 1.0;
        }
        let centre: Vec<f64> = (0..CLASSES).map(|k| (k as f64 + 0.5) * width - largest).collect();
        let share = 100.0 / kept[axis].len().max(1) as f64;
        let y = counts.iter().map(|count| share * count).collect();
        let label = ["cross-elevation (azimuth)", "elevation"][axis];
        Series::new(label, Style::Histogram, centre, y).with_u(vec![0.5 * width; CLASSES])
    });
    let plot = Plot::new(id, title, Scale::linear("error", "urad"), Scale::linear("share", "%"));
    Plot { series: series.into(), ..plot }
}

/// Over the longest stretch of frames without a gap.
fn spectrum(id: String, title: String, errors: &[Errors<'_>; 2], samples: &[Samples; 2]) -> Option<Plot> {
    let series: Option<Vec<Series>> = (0..2)
        .map(|axis: usize| {
            let stretch = longest(&samples[axis].time_s, 1.5 * errors[axis].frames.period_s);
            let values = &samples[axis].error_rad[stretch];
            let segment = (values.len() / 4).checked_next_power_of_two()?.min(SEGMENT);
            let settings = WelchSettings::new(1.0 / errors[axis].frames.period_s, segment);
            let psd = CrossSpectra::welch(&[values], &settings).ok()?.psd(0).ok()?;
            let y: Vec<f64> = psd.density[1..].iter().map(|d| URAD * URAD * d).collect();
            let label = ["cross-elevation (azimuth)", "elevation"][axis];
            Some(Series::new(label, Style::Line, psd.frequency_hz[1..].to_vec(), y))
        })
        .collect();
    let abscissa = Scale::logarithmic("frequency", "Hz");
    let plot = Plot::new(id, title, abscissa, Scale::logarithmic("power spectral density", "urad^2/Hz"));
    Some(Plot { series: series?, ..plot })
}

fn longest(time_s: &[f64], gap_s: f64) -> std::ops::Range<usize> {
    let mut longest = 0..0;
    let mut from = 0;
    let breaks = |k: &usize| time_s[*k] - time_s[*k - 1] > gap_s;
    for to in (1..time_s.len()).filter(breaks).chain([time_s.len()]) {
        if to - from > longest.len() {
            longest = from..to;
        }
        from = to;
    }
    longest
}
