//! Limits: dark lines with their labels.

use super::layout::Panel;
use super::mask;
use super::text::text_width;
use super::units;
use crate::markup::Markup;
use crate::number;

/// Colour of limits: the darkest in the picture but that of text.
pub(super) const LIMIT: &str = "#8b0000";

/// Limits with their labels: at the right end above the line, or where they hide fewer points.
pub(super) fn draw(m: &mut Markup, panel: &Panel<'_>) {
    let x = &panel.x;
    let area = panel.area;
    let mut taken: Vec<f64> = Vec::new();
    for limit in &panel.plot.limits {
        let Some(at) = panel.y.place(limit.y).filter(|_| panel.y.shows(limit.y)) else { continue };
        let whole = [area.left, area.right];
        let ends = limit.x.map_or(whole, |[a, b]| [x.clamped(a.min(b)), x.clamped(a.max(b))]);
        line(m, ends, at);
        let label = number::typeset(&limit.label);
        let (end, base) = label_place(panel, ends, at, text_width(&label));
        halo(m, end, free(base, 12.0, &mut taken), "end", LIMIT, &label);
    }
    mask::draw(m, panel, &mut taken);
}

/// Right end and base line of the label of a line: at its right or left end, above or below, inside the panel.
fn label_place(panel: &Panel<'_>, ends: [f64; 2], at: f64, width: f64) -> (f64, f64) {
    let top = panel.area.top;
    let bottom = panel.area.bottom;
    let least = panel.area.left + 4.0 + width;
    let right = (ends[1] - 4.0).max(least);
    let left = (ends[0] + 4.0 + width).min(ends[1] - 4.0).max(least);
    let bases = [at - 4.0, at + 12.0].into_iter().filter(|base| base - top >= 10.0 && *base <= bottom - 2.0);
    let places = bases.flat_map(|base| [(right, base), (left, base)]);
    let hides = |&(end, base): &(f64, f64)| panel.crowd([end - width, base - 10.0, end, base + 3.0]);
    places.min_by_key(hides).unwrap_or((right, at - 4.0))
}

/// The base line for a text that touches none of those taken, from `base` on in steps.
pub(super) fn free(base: f64, step: f64, taken: &mut Vec<f64>) -> f64 {
    let mut at = base;
    while taken.iter().any(|other| (other - at).abs() < 11.0) {
        at += step;
    }
    taken.push(at);
    at
}

/// A label of a limit around an abscissa of the paper, inside the panel.
pub(super) fn label(m: &mut Markup, panel: &Panel<'_>, text: &str, middle: f64, base: f64) {
    let label = number::typeset(text);
    let half = 0.5 * text_width(&label) + 4.0;
    let left = panel.area.left + half;
    let right = panel.area.right - half;
    let middle = if left < right { middle.clamp(left, right) } else { 0.5 * (left + right) };
    halo(m, middle, base, "middle", LIMIT, &label);
}

/// The line of a limit between two abscissae of the paper.
pub(super) fn line(m: &mut Markup, ends: [f64; 2], at: f64) {
    let d = format!("M{} {}H{}", units(ends[0]), units(at), units(ends[1]));
    let dash = ("stroke-dasharray", "10 3 2 3");
    m.empty("path", &[("d", &d), ("stroke", LIMIT), ("stroke-width", "1.6"), dash]);
}

/// Text with a white edge, legible over lines.
pub(super) fn halo(m: &mut Markup, x: f64, y: f64, anchor: &str, colour: &str, text: &str) {
    m.element(
        "text",
        &[
            ("x", &units(x)),
            ("y", &units(y)),
            ("text-anchor", anchor),
            ("font-size", "10.5"),
            ("fill", colour),
            ("stroke", "#ffffff"),
            ("stroke-width", "3"),
            ("paint-order", "stroke"),
        ],
        text,
    );
}
