//! Rates by gyros and encoder, and their difference.

use super::point::Spin;
use crate::case::Case;
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

pub(super) fn picture(case: &Case, spin: &Spin) -> Vec<Plot> {
    let n = spin.rate_rad_per_s.len();
    let start_s = spin.samples.time_s[0];
    let time: Vec<f64> = spin.samples.time_s[1..].iter().map(|t| t - start_s).collect();
    let by_gyros = |k: usize| (0..3).map(|d| spin.along[d][k] * spin.expected[d]).sum::<f64>();
    let gyros: Vec<f64> = (0..n).map(|k| by_gyros(k).to_degrees()).collect();
    let encoder: Vec<f64> = spin.rate_rad_per_s.iter().map(|r| r.to_degrees()).collect();
    let difference: Vec<f64> = gyros.iter().zip(&encoder).map(|(g, e)| 1e3 * (g - e)).collect();
    let series = |label: &str, style: Style, y: &[f64]| Series::thinned(label, style, [&time, y], MAX_POINTS);
    let id = case.point.replace(|c: char| !c.is_ascii_alphanumeric(), "-");
    let abscissa = || Scale::linear("time", "s");
    let rates = Plot {
        series: vec![series("encoder", Style::Line, &encoder), series("gyros", Style::Fit, &gyros)],
        ..Plot::new(
            format!("rates-{id}"),
            format!("Rate of the axis by encoder and gyros, {}", case.point),
            abscissa(),
            Scale::linear("rate", "deg/s"),
        )
    };
    let panel = Plot {
        series: vec![series("gyros less encoder", Style::Line, &difference)],
        ..Plot::new(
            format!("rate-difference-{id}"),
            "Difference",
            abscissa(),
            Scale::linear("difference", "mdeg/s"),
        )
    };
    let panel = panel.panel_of(&rates);
    vec![rates, panel]
}
