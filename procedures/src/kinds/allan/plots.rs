//! Deviation of a gyro with its interval and the fit.

use super::still::{Found, deg_per_h};
use crate::trace::{Plot, Scale, Series, Style};

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
    let (first, last) = (tau.first().copied().unwrap_or(1.0), tau.last().copied().unwrap_or(1.0));
    let at: Vec<f64> =
        (0..CURVE).map(|k| first * (last / first).powf(k as f64 / (CURVE - 1) as f64)).collect();
    let model: Vec<f64> = at.iter().map(|&tau| deg_per_h(found.fit.deviation(tau))).collect();
    Plot {
        series: vec![
            band,
            Series::new("five noises", Style::Fit, at, model),
            Series::new("overlapping Allan deviation", Style::Markers, tau, deviation),
        ],
        ..Plot::new(
            format!("allan-{gyro}"),
            format!("Allan deviation of gyro {gyro} at standstill"),
            Scale::logarithmic("averaging time", "s"),
            Scale::logarithmic("deviation", "deg/h"),
        )
    }
}
