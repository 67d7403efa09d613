//! Deviation of a gyro with its interval and the fit.

use super::still::{Found, deg_per_h};
use crate::quantity::QuantityKind as Q;
use crate::trace::{Mark, Note, Plot, Scale, Series, Style};

/// Points of the fitted curve.
const CURVE: usize = 200;

pub(super) fn picture(gyro: &str, found: &Found) -> Plot {
    let tau: Vec<f64> = found.points.iter().map(|p| p.at.tau_s).collect();
    let deviation: Vec<f64> = found.points.iter().map(|p| deg_per_h(p.at.deviation)).collect();
    let bounded: Vec<(f64, [f64; 2])> =
        found.points.iter().filter_map(|p| Some((p.at.tau_s, p.interval?.map(deg_per_h)))).collect();
    let band = Series::new(
        "95 % interval",
        Style::Band,
        bounded.iter().map(|(tau, _)| *tau).collect(),
        bounded.iter().map(|(_, [low, high])| 0.5 * (low + high)).collect(),
    )
    .with_u(bounded.iter().map(|(_, [low, high])| 0.5 * (high - low)).collect());
    let first = tau.first().copied().unwrap_or(1.0);
    let last = tau.last().copied().unwrap_or(1.0);
    let at: Vec<f64> =
        (0..CURVE).map(|k| first * (last / first).powf(k as f64 / (CURVE - 1) as f64)).collect();
    let model: Vec<f64> = at.iter().map(|&tau| deg_per_h(found.fit.deviation(tau))).collect();
    let mut series = vec![
        band,
        Series::new("five noises", Style::Fit, at, model),
        Series::new("overlapping Allan deviation", Style::Markers, tau, deviation),
    ];
    let walk = found.fit.random_walk();
    let mut notes = Vec::new();
    let mut marks = Vec::new();
    if walk.is_determined && first < last {
        let of_walk = |tau: f64| deg_per_h(walk.value) / tau.sqrt();
        let line = Series::new(
            "angle random walk alone",
            Style::Line,
            vec![first, last],
            vec![of_walk(first), of_walk(last)],
        );
        series.push(line);
        // One second is where the coefficient is read.
        if (first..=last).contains(&1.0) {
            marks.push(Mark { label: "1 s".to_owned(), x: 1.0 });
            let label = format!("N = {} °/√h", rounded(Q::AngleRandomWalk.to_display(walk.value)));
            notes.push(Note { label, at: [1.0, of_walk(1.0)] });
        }
    }
    Plot {
        series,
        notes,
        marks,
        ..Plot::new(
            format!("allan-{gyro}"),
            format!("Allan deviation of gyro {gyro} at standstill"),
            Scale::logarithmic("averaging time", "s"),
            Scale::logarithmic("deviation", "deg/h"),
        )
    }
}

/// Three digits: what an interval of some per cent lets one say.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
