//! The responses of both directions over each other, and the same near their final value, where an overshoot shows.

use super::point::{SETTINGS, Way};
use crate::case::Case;
use crate::trace::{LimitCurve, MAX_POINTS, Mark, Plot, Scale, Series, Side, Style};

const URAD: f64 = 1e6;
/// The panel reaches so many thresholds beyond the final value, and short of it.
const SHOWN: [f64; 2] = [-12.0, 5.0];

/// The responses with the band of settling, and a panel that shows what is beyond the final value.
pub(super) fn of(case: &Case, ways: &[Way; 2], height_rad: f64) -> Vec<Plot> {
    let id = format!("step-{}", case.point.replace([' ', ',', '='], "-"));
    let head = response(&id, case, ways, height_rad);
    let panel = beyond(&id, ways).panel_of(&head);
    vec![head, panel]
}

fn label(way: &Way) -> String {
    format!("{}, mean of {}", way.label, way.found.repeats)
}

fn last_s(ways: &[Way; 2]) -> f64 {
    ways.iter().filter_map(|way| way.time_s.last()).fold(0.0, |last, t| last.max(*t))
}

fn response(id: &str, case: &Case, ways: &[Way; 2], height_rad: f64) -> Plot {
    let band =
        Series::new("settling: within 2 % of the height", Style::Band, vec![0.0, last_s(ways)], vec![1.0; 2]);
    let mut series = vec![band.with_u(vec![SETTINGS.band_ratio; 2])];
    series.extend(ways.iter().map(|way| {
        let sign = way.found.final_value.signum();
        let ratio: Vec<f64> = way.mean_rad.iter().map(|v| sign * v / height_rad).collect();
        Series::thinned(label(way), Style::Line, [&way.time_s, &ratio], MAX_POINTS)
    }));
    let slowest = ways.iter().map(|way| way.found.settling_s).fold(0.0, f64::max);
    let marks = vec![Mark { label: format!("settled after {slowest:.3} s"), x: slowest }];
    let title = format!("Step response, {}", case.point);
    let x = Scale::linear("time since the step", "s");
    let y = Scale::linear("position over height", "1");
    Plot { series, marks, ..Plot::new(id, title, x, y) }
}

/// Past the final value in the direction of the step, with what counts as an overshoot hatched.
fn beyond(id: &str, ways: &[Way; 2]) -> Plot {
    let series = ways.iter().map(|way| {
        let last = way.found.final_value;
        let past: Vec<f64> = way.mean_rad.iter().map(|v| URAD * last.signum() * (v - last)).collect();
        Series::thinned(label(way), Style::Line, [&way.time_s, &past], MAX_POINTS)
    });
    // The direction with less room to its threshold is the one that is reported.
    let excess = |way: &Way| way.found.overshoot - way.found.threshold;
    let worse = if excess(&ways[1]) > excess(&ways[0]) { &ways[1] } else { &ways[0] };
    let threshold = URAD * worse.found.threshold;
    let mask = LimitCurve {
        label: format!("overshoot above {threshold:.2} urad ({})", worse.label),
        points: vec![[0.0, threshold], [last_s(ways), threshold]],
        forbidden: Side::Above,
    };
    let x = Scale::linear("time since the step", "s");
    let y = Scale::linear("past final value", "urad");
    Plot {
        series: series.collect(),
        masks: vec![mask],
        y_range: Some(SHOWN.map(|times| times * threshold)),
        ..Plot::new(format!("{id}-beyond"), "Past the final value", x, y)
    }
}
