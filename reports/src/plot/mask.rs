//! Limits that depend on the abscissa: their line, and hatching on the side where nothing may be.

use procedures::trace::{LimitCurve, Side};

use super::draw::path;
use super::layout::Panel;
use super::limit::{self, LIMIT};
use super::units;
use crate::markup::Markup;

/// Paper between two strokes of the hatching.
const PITCH: f64 = 7.0;
/// Depth of the hatching.
const DEPTH: f64 = 8.0;

/// The part of a curve within a stretch of the abscissa; `log` says of each scale whether it is logarithmic.
pub(super) fn within(points: &[[f64; 2]], [low, high]: [f64; 2], log: [bool; 2]) -> Vec<[f64; 2]> {
    let shown = |p: &[f64; 2]| p.iter().zip(log).all(|(v, log)| v.is_finite() && (!log || *v > 0.0));
    let points: Vec<[f64; 2]> = points.iter().copied().filter(shown).collect();
    let mut kept = Vec::new();
    for pair in points.windows(2) {
        let a = pair[0];
        let b = pair[1];
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

/// The point of the straight line on the scales at an abscissa.
fn between(a: [f64; 2], b: [f64; 2], x: f64, log: [bool; 2]) -> [f64; 2] {
    let map = |v: f64, log: bool| if log { v.ln() } else { v };
    let part = (map(x, log[0]) - map(a[0], log[0])) / (map(b[0], log[0]) - map(a[0], log[0]));
    let y = map(a[1], log[1]) + part * (map(b[1], log[1]) - map(a[1], log[1]));
    [x, if log[1] { y.exp() } else { y }]
}

/// Draws the masks of a panel; labels keep clear of the ordinates in `taken`.
pub(super) fn draw(m: &mut Markup, panel: &Panel<'_>, taken: &mut Vec<f64>) {
    for mask in &panel.plot.masks {
        let places = places(mask, panel);
        if places.len() < 2 {
            continue;
        }
        let outer = match mask.forbidden {
            Side::Above => panel.area.top,
            Side::Below => panel.area.bottom,
        };
        let ends = [places[0].0, places[places.len() - 1].0];
        let line = path(places.iter().copied());
        let region =
            format!("{line}L{} {}L{} {}Z", units(ends[1]), units(outer), units(ends[0]), units(outer));
        m.empty("path", &[("d", &region), ("fill", LIMIT), ("fill-opacity", "0.06"), ("stroke", "none")]);
        let hatching = hatching(&places, outer);
        m.empty("path", &[("d", &hatching), ("stroke", LIMIT), ("stroke-width", "0.8")]);
        m.empty("path", &[("d", &line), ("fill", "none"), ("stroke", LIMIT), ("stroke-width", "1.6")]);
        label(m, panel, mask, &places, taken);
    }
}

/// The look of a mask between two abscissae of the paper.
pub(super) fn sample(m: &mut Markup, ends: [f64; 2], at: f64) {
    let line = [(ends[0], at), (ends[1], at)];
    let d = hatching(&line, at - DEPTH) + &path(line.into_iter());
    m.empty("path", &[("d", &d), ("fill", "none"), ("stroke", LIMIT), ("stroke-width", "1.2")]);
}

/// Corners on the paper, ordinates beyond the picture at its edge.
fn places(mask: &LimitCurve, panel: &Panel<'_>) -> Vec<(f64, f64)> {
    within(&mask.points, panel.x.range, [panel.x.log, panel.y.log])
        .into_iter()
        .filter_map(|[x, y]| Some((panel.x.place(x)?, panel.y.clamped(y))))
        .collect()
}

/// Slanted strokes from the curve toward `outer`.
fn hatching(places: &[(f64, f64)], outer: f64) -> String {
    let mut d = String::new();
    let end = places.last().map_or(0.0, |place| place.0);
    for pair in places.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        // At places that do not depend on where the corners are, so that strokes keep their distance over them.
        for stroke in (x0 / PITCH).ceil() as i64..=(x1 / PITCH).floor() as i64 {
            let x = stroke as f64 * PITCH;
            let y = if x1 > x0 { y0 + (y1 - y0) * (x - x0) / (x1 - x0) } else { continue };
            let depth = (outer - y).clamp(-DEPTH, DEPTH);
            if depth.abs() >= 1.0 && x + 0.7 * depth.abs() <= end {
                d += &format!("M{} {}l{} {}", units(x), units(y), units(0.7 * depth.abs()), units(depth));
            }
        }
    }
    d
}

/// The label stands on the forbidden side of the widest stretch.
fn label(m: &mut Markup, panel: &Panel<'_>, mask: &LimitCurve, places: &[(f64, f64)], taken: &mut Vec<f64>) {
    let widest = places.windows(2).max_by(|a, b| (a[1].0 - a[0].0).total_cmp(&(b[1].0 - b[0].0)));
    let Some(&[(x0, y0), (x1, y1)]) = widest.and_then(|pair| pair.first_chunk::<2>()) else { return };
    let (first, step) = match mask.forbidden {
        Side::Above => (y0.min(y1) - DEPTH - 4.0, -12.0),
        Side::Below => (y0.max(y1) + DEPTH + 11.0, 12.0),
    };
    let inside = first.clamp(panel.area.top + 11.0, panel.area.bottom - 4.0);
    limit::label(m, panel, &mask.label, 0.5 * (x0 + x1), limit::free(inside, step, taken));
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
