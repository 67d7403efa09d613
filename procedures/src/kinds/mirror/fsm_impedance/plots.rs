//! Pictures of one sweep.

use analysis::circuit::CircuitFit;
use analysis::frf::Line;

use crate::trace::{Mark, Plot, Scale, Series, Style};

/// Points of the fit's curve.
const CURVE: u32 = 600;

/// |Z| and phase over frequency, with the fit and the mode.
pub(super) fn of(axis: &str, lines: &[Line], fit: &CircuitFit) -> Vec<Plot> {
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else { return Vec::new() };
    let ratio = last.frequency_hz / first.frequency_hz;
    let grid: Vec<f64> =
        (0..=CURVE).map(|k| first.frequency_hz * ratio.powf(f64::from(k) / f64::from(CURVE))).collect();
    let found = fit.resonance.as_ref().ok();
    let marks: Vec<Mark> =
        found.map(|r| Mark { label: "mode".to_owned(), x: r.series_hz.value }).into_iter().collect();
    let plot = |id: &str, title: &str, y: Scale, of: &dyn Fn(&Line) -> f64| {
        let fitted: Vec<Line> = grid.iter().map(|&hz| Line::exact(hz, fit.at(hz))).collect();
        let series = |label: &str, style, lines: &[Line]| {
            let x = lines.iter().map(|l| l.frequency_hz).collect();
            Series::new(label, style, x, lines.iter().map(of).collect())
        };
        Plot {
            id: format!("{id}-{axis}"),
            title: format!("{title}, mirror {axis}"),
            x: Scale { label: "frequency".to_owned(), unit: "Hz".to_owned(), log: true },
            y,
            series: vec![series("analyser", Style::Markers, lines), series("circuit", Style::Fit, &fitted)],
            limits: Vec::new(),
            marks: marks.clone(),
            limits_of: None,
            ..Plot::default()
        }
    };
    let magnitude = Scale { label: "impedance".to_owned(), unit: "ohm".to_owned(), log: true };
    let phase = Scale { label: "phase".to_owned(), unit: "deg".to_owned(), log: false };
    vec![
        plot("impedance", "Impedance", magnitude, &|l| l.value.norm()),
        plot("impedance-phase", "Phase of the impedance", phase, &|l| l.phase_rad().to_degrees()),
    ]
}
