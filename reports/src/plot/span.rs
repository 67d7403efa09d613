//! Shaded stretches of the abscissa, behind everything else.

use super::layout::Panel;
use super::units;
use crate::markup::Markup;

const SHADE: &str = "#4d4d4d";
/// A window of a moment is still seen.
const NARROWEST: f64 = 1.2;

/// The stretches of a panel, as far as they are in sight.
pub(super) fn draw(m: &mut Markup, panel: &Panel<'_>) {
    let area = panel.area;
    for span in &panel.plot.spans {
        let [low, high] = [span.x[0].min(span.x[1]), span.x[0].max(span.x[1])];
        if high < panel.x.range[0] || low > panel.x.range[1] {
            continue;
        }
        let left = panel.x.clamped(low);
        let right = panel.x.clamped(high);
        shade(m, [left, area.top, (right - left).max(NARROWEST), area.bottom - area.top]);
    }
}

fn shade(m: &mut Markup, [left, top, width, height]: [f64; 4]) {
    let [x, y, width, height] = [left, top, width, height].map(units);
    let fill = [("fill", SHADE), ("fill-opacity", "0.14")];
    m.empty("rect", &[("x", &x), ("y", &y), ("width", &width), ("height", &height), fill[0], fill[1]]);
}

/// In the legend.
pub(super) fn sample(m: &mut Markup, ends: [f64; 2], at: f64) {
    shade(m, [ends[0], at - 5.5, ends[1] - ends[0], 11.0]);
}
