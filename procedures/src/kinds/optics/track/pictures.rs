//! Errors over time with what explains them, their histogram and their spectrum.

use analysis::spectra::{CrossSpectra, WelchSettings};
use analysis::tracking::Peak;

use super::axis_errors::{Errors, Samples};
use super::happenings::word;
use super::point::{FINE_TOPIC, Point};
use super::sight::Sight;
use crate::trace::{LimitLine, MAX_POINTS, Mark, Plot, Scale, Series, Span, Style};

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
    let name = |what: &str| {
        (format!("{tracker}-{what}-{id}"), format!("{} track {what}, {}", capital(tracker), point.case.point))
    };
    let time = over_time(name("error"), errors, &samples, record_s[0]);
    let panel = sight.filter(|_| tracker == "coarse");
    let panel = panel.map(|sight| acceleration(point, sight, record_s).panel_of(&time));
    let spectrum = spectrum(name("spectrum"), errors, &samples);
    [Some(time), panel, Some(histogram(name("histogram"), &samples)), spectrum]
        .into_iter()
        .flatten()
        .collect()
}

fn capital(word: &str) -> &'static str {
    if word == "fine" { "Fine" } else { "Coarse" }
}

fn over_time(
    (id, title): (String, String),
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
            ["across elevation (azimuth)", "elevation"][axis],
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
fn histogram((id, title): (String, String), samples: &[Samples; 2]) -> Plot {
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
        let label = ["across elevation (azimuth)", "elevation"][axis];
        Series::new(label, Style::Histogram, centre, y).with_u(vec![0.5 * width; CLASSES])
    });
    let plot = Plot::new(id, title, Scale::linear("error", "urad"), Scale::linear("share", "%"));
    Plot { series: series.into(), ..plot }
}

/// Over the longest stretch of frames without a gap.
fn spectrum((id, title): (String, String), errors: &[Errors<'_>; 2], samples: &[Samples; 2]) -> Option<Plot> {
    let series: Option<Vec<Series>> = (0..2)
        .map(|axis: usize| {
            let stretch = longest(&samples[axis].time_s, 1.5 * errors[axis].frames.period_s);
            let values = &samples[axis].error_rad[stretch];
            let segment = (values.len() / 4).checked_next_power_of_two()?.min(SEGMENT);
            let settings = WelchSettings::new(1.0 / errors[axis].frames.period_s, segment);
            let psd = CrossSpectra::welch(&[values], &settings).ok()?.psd(0).ok()?;
            let y: Vec<f64> = psd.density[1..].iter().map(|d| URAD * URAD * d).collect();
            let label = ["across elevation (azimuth)", "elevation"][axis];
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
