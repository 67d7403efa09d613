//! Masks: limits that depend on the abscissa. Each is a line with hatching on its forbidden side.

use procedures::trace::{LimitCurve, Side};

use super::draw::path;
use super::layout::Panel;
use super::limit::{self, LIMIT};
use super::units;
use crate::markup::Markup;

/// Horizontal distance between two strokes of the hatching, in SVG units.
const PITCH: f64 = 7.0;
/// Vertical depth of the hatching, in SVG units.
const DEPTH: f64 = 8.0;

/// Clips a curve to an interval of the abscissa. `log` says for the x and the y scale whether it is logarithmic.
pub(super) fn within(points: &[[f64; 2]], [low, high]: [f64; 2], log: [bool; 2]) -> Vec<[f64; 2]> {
    // A logarithmic scale has no place for 0 and below.
    let can_be_shown = |p: &[f64; 2]| p.iter().zip(log).all(|(v, log)| v.is_finite() && (!log || *v > 0.0));
    let points: Vec<[f64; 2]> = points.iter().copied().filter(can_be_shown).collect();
    let mut kept = Vec::new();
    for pair in points.windows(2) {
        let a = pair[0];
        let b = pair[1];
        // Outside the interval, or abscissae that do not ascend.
        if b[0] < low || a[0] > high || b[0] < a[0] {
            continue;
        }
        let start = if a[0] < low { between(a, b, low, log) } else { a };
        let end = if b[0] > high { between(a, b, high, log) } else { b };
        for point in [start, end] {
            if kept.last() != Some(&point) {
                kept.push(point);
            }
        }
    }
    kept
}

/// Interpolates from `a` to `b` at the abscissa `x`, along a line that is straight on the scales of the plot.
fn between(a: [f64; 2], b: [f64; 2], x: f64, log: [bool; 2]) -> [f64; 2] {
    let to_scale = |v: f64, log: bool| if log { v.ln() } else { v };
    let [x_a, x_b, x_at] = [a[0], b[0], x].map(|v| to_scale(v, log[0]));
    let [y_a, y_b] = [a[1], b[1]].map(|v| to_scale(v, log[1]));
    let y = y_a + (x_at - x_a) / (x_b - x_a) * (y_b - y_a);
    [x, if log[1] { y.exp() } else { y }]
}

/// Draws the masks of a panel.
///
/// `taken` holds the base lines of all labels so far. New labels keep clear of them and are added.
pub(super) fn draw(m: &mut Markup, panel: &Panel<'_>, taken: &mut Vec<f64>) {
    for mask in &panel.plot.masks {
        let places = places(mask, panel);
        if places.len() < 2 {
            continue;
        }
        let forbidden_edge = match mask.forbidden {
            Side::Above => panel.area.top,
            Side::Below => panel.area.bottom,
        };
        let [left, right] = [places[0].0, places[places.len() - 1].0].map(units);
        let line = path(places.iter().copied());
        // The forbidden region: the line, then back along the edge of the panel.
        let edge = units(forbidden_edge);
        let region = format!("{line}L{right} {edge}L{left} {edge}Z");
        m.empty("path", &[("d", &region), ("fill", LIMIT), ("fill-opacity", "0.06"), ("stroke", "none")]);
        let hatching = hatching(&places, forbidden_edge);
        m.empty("path", &[("d", &hatching), ("stroke", LIMIT), ("stroke-width", "0.8")]);
        m.empty("path", &[("d", &line), ("fill", "none"), ("stroke", LIMIT), ("stroke-width", "1.6")]);
        label(m, panel, mask, &places, taken);
    }
}

/// Draws the legend sample of a mask: a horizontal line at `y` between the abscissae `ends`, in SVG units, hatched above.
pub(super) fn sample(m: &mut Markup, ends: [f64; 2], y: f64) {
    let line = [(ends[0], y), (ends[1], y)];
    let d = hatching(&line, y - DEPTH) + &path(line.into_iter());
    m.empty("path", &[("d", &d), ("fill", "none"), ("stroke", LIMIT), ("stroke-width", "1.2")]);
}

/// Corners of a mask in SVG units. Ordinates beyond the plot are moved to its edge.
fn places(mask: &LimitCurve, panel: &Panel<'_>) -> Vec<(f64, f64)> {
    within(&mask.points, panel.x.range, [panel.x.log, panel.y.log])
        .into_iter()
        .filter_map(|[x, y]| Some((panel.x.place(x)?, panel.y.clamped(y))))
        .collect()
}

/// SVG path of slanted strokes from the line toward the ordinate `edge`, at most [`DEPTH`] deep.
fn hatching(places: &[(f64, f64)], edge: f64) -> String {
    let mut d = String::new();
    let end = places.last().map_or(0.0, |place| place.0);
    for pair in places.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        // A vertical step has no strokes.
        if x1 <= x0 {
            continue;
        }
        // Strokes begin at multiples of the pitch, wherever the corners are: so their distance is the same across corners.
        for stroke in (x0 / PITCH).ceil() as i64..=(x1 / PITCH).floor() as i64 {
            let x = stroke as f64 * PITCH;
            let y = y0 + (y1 - y0) * (x - x0) / (x1 - x0);
            // Negative is upward.
            let depth = (edge - y).clamp(-DEPTH, DEPTH);
            let slant = 0.7 * depth.abs();
            if depth.abs() >= 1.0 && x + slant <= end {
                d += &format!("M{} {}l{} {}", units(x), units(y), units(slant), units(depth));
            }
        }
    }
    d
}

/// Draws the label on the forbidden side of the widest segment of the line.
fn label(m: &mut Markup, panel: &Panel<'_>, mask: &LimitCurve, places: &[(f64, f64)], taken: &mut Vec<f64>) {
    let widest = places.windows(2).max_by(|a, b| (a[1].0 - a[0].0).total_cmp(&(b[1].0 - b[0].0)));
    let Some(&[(x0, y0), (x1, y1)]) = widest.and_then(|pair| pair.first_chunk::<2>()) else { return };
    // Base line beyond the hatching, and the step away from the line to the next one if another label is there.
    let (base, step) = match mask.forbidden {
        Side::Above => (y0.min(y1) - DEPTH - 4.0, -12.0),
        Side::Below => (y0.max(y1) + DEPTH + 11.0, 12.0),
    };
    let base = base.clamp(panel.area.top + 11.0, panel.area.bottom - 4.0);
    limit::label(m, panel, &mask.label, 0.5 * (x0 + x1), limit::free(base, step, taken));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_ends_where_the_picture_ends() {
        let mask = [[1.0, 0.0], [10.0, -20.0], [10.0, -30.0], [1000.0, -70.0]];
        assert_eq!(
            within(&mask, [1.0, 100.0], [true, false]),
            [[1.0, 0.0], [10.0, -20.0], [10.0, -30.0], [100.0, -50.0]],
            "half of the last two decades, half of the 40 dB"
        );
        assert_eq!(within(&mask, [20.0, 30.0], [false, false]).len(), 2);
        assert!(within(&mask, [2000.0, 3000.0], [true, false]).is_empty());
        assert!(within(&[[1.0, 1.0]], [0.0, 3.0], [false, false]).is_empty(), "a point is no curve");
    }

    #[test]
    fn hatching_stays_between_curve_and_edge() {
        let d = hatching(&[(0.0, 20.0), (70.0, 20.0)], 17.0);
        assert_eq!(d.matches('M').count(), 10, "one every seven units; the last would reach beyond the end");
        assert!(d.contains("M7 20l2.1 -3M"), "{d}");
        assert_eq!(hatching(&[(0.0, 20.0), (70.0, 20.0)], 20.0), "", "no room, no strokes");
    }
}
