//! What belongs to a plane: circles, regions of confidence, named points.

use procedures::trace::Series;

use super::layout::Panel;
use super::limit::{self, LIMIT};
use super::look::Look;
use super::text::text_width;
use super::units;
use crate::markup::Markup;

/// A circle of no larger radius lies under the line.
const HIDDEN: f64 = 0.65;
const GUIDE: &str = "#4d4d4d";
/// Half size of the cross at a named point.
const CROSS: f64 = 4.5;

/// An ellipse of these radii.
pub(super) fn circle((px, py): (f64, f64), (rx, ry): (f64, f64)) -> String {
    let (left, rx, ry, across) = (units(px - rx), units(rx), units(ry), units(2.0 * rx));
    format!("M{left} {}a{rx} {ry} 0 1 0 {across} 0a{rx} {ry} 0 1 0 -{across} 0Z", units(py))
}

/// A circle of the plane on the paper; `None` if a scale cannot show its centre or it has no radius.
fn on_paper(panel: &Panel<'_>, [x, y]: [f64; 2], radius: f64) -> Option<String> {
    let centre = panel.place((x, y))?;
    let width = (panel.x.place(x + radius)? - centre.0).abs();
    let height = (panel.y.place(y + radius)? - centre.1).abs();
    (radius > 0.0).then(|| circle(centre, (width, height)))
}

/// The circles of the picture.
pub(super) fn circles(m: &mut Markup, panel: &Panel<'_>) {
    for circle in &panel.plot.circles {
        if let Some(d) = on_paper(panel, circle.centre, circle.radius) {
            outline(m, &d, circle.forbidden);
        }
    }
}

/// The look of a circle: of a limit where nothing may be inside.
pub(super) fn outline(m: &mut Markup, d: &str, forbidden: bool) {
    if forbidden {
        let fill = [("fill", LIMIT), ("fill-opacity", "0.1")];
        m.empty("path", &[("d", d), fill[0], fill[1], ("stroke", LIMIT), ("stroke-width", "1.6")]);
    } else {
        let dash = ("stroke-dasharray", "3 3");
        m.empty("path", &[("d", d), ("fill", "none"), ("stroke", GUIDE), ("stroke-width", "1"), dash]);
    }
}

/// Circles around the points of a series: those that reach into the frame and beyond the line through the points.
pub(super) fn regions(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    let points = s.x.iter().zip(&s.y).zip(&s.u);
    let seen = |(x, y, u): &(f64, f64, f64)| {
        let Some((px, py)) = panel.place((*x, *y)) else { return false };
        let reach = panel.x.place(x + u).map_or(0.0, |edge| (edge - px).abs());
        let inside = |at: f64, from: f64, to: f64| at + reach >= from && at - reach <= to;
        let area = panel.area;
        reach > HIDDEN && inside(px, area.left, area.right) && inside(py, area.top, area.bottom)
    };
    let all = points.map(|((&x, &y), &u)| (x, y, u)).filter(seen);
    let d: String = all.filter_map(|(x, y, u)| on_paper(panel, [x, y], u)).collect();
    if !d.is_empty() {
        region(m, &d, look);
    }
}

/// The look of a region.
pub(super) fn region(m: &mut Markup, d: &str, look: &Look) {
    let fill = [("fill", look.colour), ("fill-opacity", "0.12")];
    let line = [("stroke", look.colour), ("stroke-opacity", "0.6"), ("stroke-width", "0.7")];
    m.empty("path", &[("d", d), fill[0], fill[1], line[0], line[1], line[2]]);
}

/// Crosses with their names at the corner that no other name takes and that holds the fewest points.
pub(super) fn notes(m: &mut Markup, panel: &Panel<'_>) {
    let mut taken: Vec<[f64; 4]> = Vec::new();
    for note in &panel.plot.notes {
        let Some((px, py)) = panel.place((note.at[0], note.at[1])) else { continue };
        if !panel.x.shows(note.at[0]) || !panel.y.shows(note.at[1]) {
            continue;
        }
        let x = units(px);
        let y = units(py);
        let [left, right, top, foot] = [px - CROSS, px + CROSS, py - CROSS, py + CROSS].map(units);
        let d = format!("M{left} {y}H{right}M{x} {top}V{foot}");
        m.empty("path", &[("d", &d), ("stroke", "#1a1a1a"), ("stroke-width", "1.6")]);
        let width = text_width(&note.label);
        // In a list a name stands in its row, off the bar where there is room.
        let away = if note.at[0] < 0.0 { -1.0 } else { 1.0 };
        let beside = [(away, 3.8), (-away, 3.8), (away, 3.8), (-away, 3.8)];
        let around = [(1.0, -6.0), (-1.0, -6.0), (1.0, 14.0), (-1.0, 14.0)];
        let places = if panel.plot.rows.is_empty() { around } else { beside };
        let corners = places.map(|(side, below)| {
            let start = if side > 0.0 { px + 5.0 } else { px - 5.0 - width };
            (side, below, [start, py + below - 9.0, start + width, py + below + 2.0])
        });
        let inside = |b: &[f64; 4]| b[0] >= panel.area.left && b[2] <= panel.area.right;
        let apart =
            |b: &[f64; 4]| taken.iter().all(|t| b[2] < t[0] || t[2] < b[0] || b[3] < t[1] || t[3] < b[1]);
        let free = corners.iter().filter(|(_, _, b)| inside(b) && apart(b));
        let chosen = free.min_by_key(|(_, _, b)| panel.crowd(*b)).unwrap_or(&corners[0]);
        taken.push(chosen.2);
        let anchor = if chosen.0 > 0.0 { "start" } else { "end" };
        limit::halo(m, px + 5.0 * chosen.0, py + chosen.1, anchor, "#1a1a1a", &note.label);
    }
}
