//! Pictures: Bode, Nyquist, margins and coupling over elevation.

use analysis::frf::{Line, unwrapped_rad};
use analysis::margins::Margins;

use super::coupling;
use super::honest::Judged;
use crate::kinds::response::excited::ELEVATION;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::trace::{Circle, Plot, Scale, Series, Style};

/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;
/// A disk of a larger margin leaves the picture (at 2 it is half of the plane).
const LARGEST_DISK: f64 = 1.5;
/// 20·lg e: what a relative deviation is in dB.
const DB_PER_NEPER: f64 = 8.685_889_638;

fn frequency() -> Scale {
    Scale::logarithmic("frequency", "Hz")
}

fn of(lines: &[Line], value: impl Fn(&Line) -> f64) -> Vec<f64> {
    lines.iter().map(value).collect()
}

/// Gain with its band, phase and coherence as panels; lines that do not count stay visible as hollow markers.
pub(in crate::kinds) fn bode(id: &str, title: &str, unit: &str, judged: &Judged) -> Vec<Plot> {
    if judged.lines.is_empty() && judged.hollow.is_empty() {
        return Vec::new();
    }
    let hz = |l: &Line| l.frequency_hz;
    let lines = &judged.lines;
    let hollow = &judged.hollow;
    let degrees: Vec<f64> = unwrapped_rad(lines).iter().map(|p| p.to_degrees()).collect();
    let gain = Plot {
        series: curves(
            (of(lines, hz), of(lines, Line::gain_db)),
            of(lines, |l| COVERAGE * DB_PER_NEPER * l.relative_sd()),
            (of(hollow, hz), of(hollow, Line::gain_db)),
        ),
        ..Plot::new(id, title, frequency(), Scale::linear(format!("gain, dB re {unit}"), "dB"))
    };
    let phase = Plot {
        series: curves(
            (of(lines, hz), degrees),
            of(lines, |l| COVERAGE * l.relative_sd().to_degrees()),
            (of(hollow, hz), of(hollow, |l| l.phase_rad().to_degrees())),
        ),
        ..Plot::new(
            format!("{id}-phase"),
            format!("{title}: phase"),
            frequency(),
            Scale::linear("phase", "deg"),
        )
    }
    .panel_of(&gain);
    let share = |l: &Line| l.coherence.unwrap_or(1.0);
    let coherence = Plot {
        series: curves((of(lines, hz), of(lines, share)), Vec::new(), (of(hollow, hz), of(hollow, share))),
        y_range: Some([0.0, 1.0]),
        ..Plot::new(
            format!("{id}-coherence"),
            format!("{title}: coherence of one window"),
            frequency(),
            Scale::linear("coherence", ""),
        )
    }
    .panel_of(&gain);
    vec![gain, phase, coherence]
}

type Points = (Vec<f64>, Vec<f64>);

fn curves(counted: Points, band: Vec<f64>, hollow: Points) -> Vec<Series> {
    let mut all = Vec::new();
    let (x, y) = counted;
    if !band.is_empty() {
        all.push(Series::new("U (k = 2)", Style::Band, x.clone(), y.clone()).with_u(band));
    }
    all.push(Series::new("measured", Style::Line, x, y));
    if !hollow.0.is_empty() {
        all.push(Series::new("does not count", Style::Excluded, hollow.0, hollow.1));
    }
    all
}

/// The open loop in the plane, its circles of 95 %, and the disk around −1 that it keeps out of.
pub(in crate::kinds) fn nyquist(id: &str, title: &str, judged: &Judged, margins: &Margins) -> Plot {
    let lines: Vec<Line> = judged.lines.iter().copied().filter(|l| l.value.norm() < 3.0).collect();
    let x = of(&lines, |l| l.value.re);
    let y = of(&lines, |l| l.value.im);
    let circles = of(&lines, |l| l.circle_radius(0.95));
    let mut plot = Plot {
        series: vec![
            Series::new("95 % circles", Style::Circles, x.clone(), y.clone()).with_u(circles),
            Series::new("measured", Style::Line, x, y),
        ],
        ..Plot::nyquist(id, title)
    };
    let label = format!("modulus margin {:.3}", margins.modulus.value);
    plot.circles.push(Circle::guide(&label, [-1.0, 0.0], margins.modulus.value));
    let alpha = margins.disk.alpha.value;
    if alpha < LARGEST_DISK {
        // Crosses the real axis at -1 over the gains that the loop bears: (2 + a)/(2 - a) either way.
        let gain = (2.0 + alpha) / (2.0 - alpha);
        let centre = -0.5 * (gain + 1.0 / gain);
        let radius = 0.5 * (gain - 1.0 / gain);
        plot.circles.push(Circle::guide(format!("disk margin {alpha:.3}"), [centre, 0.0], radius));
    }
    let hollow: Vec<Line> = judged.hollow.iter().copied().filter(|l| l.value.norm() < 3.0).collect();
    if !hollow.is_empty() {
        let x = of(&hollow, |l| l.value.re);
        let y = of(&hollow, |l| l.value.im);
        plot.series.push(Series::new("does not count", Style::Excluded, x, y));
    }
    plot
}

/// A measurand over elevation, with the limits of its requirement.
pub(super) fn over_elevation(measurand: &str, title: &str, points: &[PointResult]) -> Option<Plot> {
    let all: Vec<&Measurement> =
        points.iter().flat_map(|p| &p.measurements).filter(|m| m.measurand == measurand).collect();
    let kind = all.first()?.kind;
    let at = |m: &Measurement| {
        let elevation = m.conditions.iter().find(|c| c.name == ELEVATION)?;
        Some(Q::Angle.to_display(elevation.achieved.unwrap_or(elevation.requested)))
    };
    let found: Vec<(f64, f64, f64)> = all
        .iter()
        .filter_map(|m| Some((at(m)?, kind.to_display(m.value?), COVERAGE * kind.to_display(m.u))))
        .collect();
    if found.len() < 2 {
        return None;
    }
    let x = found.iter().map(|f| f.0).collect();
    let y = found.iter().map(|f| f.1).collect();
    let series = Series::new("measured, U (k = 2)", Style::Markers, x, y);
    Some(Plot {
        series: vec![series.with_u(found.iter().map(|f| f.2).collect())],
        limits_of: Some(measurand.to_owned()),
        ..Plot::new(
            format!("{measurand}-over-elevation"),
            title,
            Scale::linear("elevation", Q::Angle.display_unit()),
            Scale::linear(measurand, kind.display_unit()),
        )
    })
}

/// Coupling over frequency, all points.
pub(super) fn coupling(points: &[PointResult]) -> Option<Plot> {
    let series: Vec<Series> = points
        .iter()
        .filter_map(|point| {
            let coupling = coupling::of_point(point)?;
            let percent = coupling.ratio.iter().map(|r| 100.0 * r).collect();
            Some(Series::new(&point.point, Style::Line, coupling.frequency_hz.clone(), percent))
        })
        .collect();
    if series.is_empty() {
        return None;
    }
    let y = Scale::logarithmic("rate of the other axis over rate of this one", "%");
    Some(Plot { series, ..Plot::new("cross-axis", "Coupling between the axes", frequency(), y) })
}
