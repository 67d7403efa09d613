//! Pictures: spectra with and without the loop, and the rejection with its mask.

use super::REJECTION;
use super::conclude::{Found, Ratio};
use super::point::{self, Density, Record};
use crate::kinds::optics::frames::MIRROR_AXES;
use crate::measurement::PointResult;
use crate::trace::{LimitLine, Plot, Scale, Series, Style};

const MICRO_SQUARE: f64 = 1e12;
/// Shown up to here.
const HIGHEST_HZ: f64 = 60.0;

/// Spectra and rejection of an axis.
pub(super) fn pictures(
    open: Option<&PointResult>,
    found: Option<&Found>,
    ratios: &[Ratio],
    axis: usize,
) -> Vec<Plot> {
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
            series("what moved the image, loop closed", Style::Fit, &f.responses.input),
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
    let y = Scale::linear("left of the tip-tilt", "dB");
    Plot {
        series,
        limits: vec![LimitLine { label: "0 dB".to_owned(), y: 0.0, x: None }],
        limits_of: Some(REJECTION.to_owned()),
        ..Plot::new(format!("rejection-{name}"), format!("Rejection of tip-tilt, {name}"), x, y)
    }
}
