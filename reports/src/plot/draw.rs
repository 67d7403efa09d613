//! The marks on the paper: lines, bands, markers, bars, limits.

use procedures::trace::{LimitLine, Mark, Plot, Series, Style};

use super::axis::Axis;
use super::look::{Look, Shape};
use super::text::text_width;
use super::{HEIGHT, LEFT, RIGHT, TOP, place, units};
use crate::markup::Markup;
use crate::number;

const LIMIT: &str = "#8b0000";
const MARK: &str = "#4d4d4d";
/// Height of a row of labels of marks.
pub(super) const MARK_ROW: f64 = 13.0;
/// Half size of a marker.
const RADIUS: f64 = 3.2;

/// Draws all series: bands first, so that nothing is hidden by one; markers last.
pub(super) fn series(m: &mut Markup, plot: &Plot, looks: &[Look], x: &Axis, y: &Axis) {
    let layer = |style: Style| match style {
        Style::Band => 0,
        Style::Bars => 1,
        Style::Line => 2,
        Style::Fit => 3,
        Style::Excluded => 4,
        Style::Markers => 5,
    };
    for current in 0..=5 {
        for (s, look) in plot.series.iter().zip(looks).filter(|(s, _)| layer(s.style) == current) {
            match s.style {
                Style::Line | Style::Fit => line(m, s, look, x, y),
                Style::Band => band(m, s, look, x, y),
                Style::Bars => bars(m, s, look, x, y),
                Style::Markers | Style::Excluded => markers(m, s, look, x, y),
            }
        }
    }
}

fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut d = String::new();
    for (px, py) in points {
        let command = if d.is_empty() { 'M' } else { 'L' };
        d += &format!("{command}{} {}", units(px), units(py));
    }
    d
}

fn line(m: &mut Markup, s: &Series, look: &Look, x: &Axis, y: &Axis) {
    let d = path(s.x.iter().zip(&s.y).filter_map(|(&a, &b)| place(x, y, (a, b))));
    stroke(m, &d, look);
}

fn stroke(m: &mut Markup, d: &str, look: &Look) {
    if d.is_empty() {
        return;
    }
    let width = if look.style == Style::Fit { "1.8" } else { "1.3" };
    m.empty(
        "path",
        &[
            ("d", d),
            ("fill", "none"),
            ("stroke", look.colour),
            ("stroke-width", width),
            ("stroke-dasharray", look.dash),
            ("stroke-linejoin", "round"),
        ],
    );
}

fn band(m: &mut Markup, s: &Series, look: &Look, x: &Axis, y: &Axis) {
    let edge = |sign: f64| {
        s.x.iter().zip(&s.y).zip(&s.u).filter_map(move |((&a, &b), &u)| {
            // The lower edge may leave a logarithmic scale: it ends at the scale's end.
            Some((x.place(a)?, y.clamped(b + sign * u)))
        })
    };
    let upper: Vec<(f64, f64)> = edge(1.0).collect();
    let mut lower: Vec<(f64, f64)> = edge(-1.0).collect();
    lower.reverse();
    if upper.is_empty() {
        return;
    }
    let d = path(upper.into_iter().chain(lower)) + "Z";
    m.empty("path", &[("d", &d), ("fill", look.colour), ("fill-opacity", "0.18"), ("stroke", "none")]);
}

fn bars(m: &mut Markup, s: &Series, look: &Look, x: &Axis, y: &Axis) {
    let zero = if y.log { TOP + HEIGHT } else { y.clamped(0.0) };
    let d: String =
        s.x.iter()
            .zip(&s.y)
            .filter_map(|(&a, &b)| place(x, y, (a, b)))
            .map(|(px, py)| format!("M{} {}V{}", units(px), units(zero), units(py)))
            .collect();
    let width = (0.5 * (RIGHT - LEFT) / s.x.len().max(1) as f64).clamp(1.2, 7.0);
    m.empty("path", &[("d", &d), ("stroke", look.colour), ("stroke-width", &units(width))]);
    errors(m, s, look, x, y);
}

fn markers(m: &mut Markup, s: &Series, look: &Look, x: &Axis, y: &Axis) {
    errors(m, s, look, x, y);
    let d: String =
        s.x.iter()
            .zip(&s.y)
            .filter_map(|(&a, &b)| place(x, y, (a, b)))
            .map(|at| shape(look.shape, at))
            .collect();
    marker_path(m, &d, look);
}

fn marker_path(m: &mut Markup, d: &str, look: &Look) {
    let fill = if look.hollow { "#ffffff" } else { look.colour };
    m.empty("path", &[("d", d), ("fill", fill), ("stroke", look.colour), ("stroke-width", "1.1")]);
}

fn shape(shape: Shape, (px, py): (f64, f64)) -> String {
    let r = RADIUS;
    let at = |dx: f64, dy: f64| format!("{} {}", units(px + dx), units(py + dy));
    match shape {
        Shape::Circle => {
            format!("M{}a{r} {r} 0 1 0 {} 0a{r} {r} 0 1 0 -{} 0Z", at(-r, 0.0), 2.0 * r, 2.0 * r)
        }
        Shape::Square => format!("M{}L{}L{}L{}Z", at(-r, -r), at(r, -r), at(r, r), at(-r, r)),
        Shape::Triangle => format!("M{}L{}L{}Z", at(0.0, -r - 0.8), at(r + 0.6, r), at(-r - 0.6, r)),
        Shape::Diamond => {
            let r = r + 0.8;
            format!("M{}L{}L{}L{}Z", at(0.0, -r), at(r, 0.0), at(0.0, r), at(-r, 0.0))
        }
    }
}

/// Error bars with caps.
fn errors(m: &mut Markup, s: &Series, look: &Look, x: &Axis, y: &Axis) {
    let d: String =
        s.x.iter()
            .zip(&s.y)
            .zip(&s.u)
            .filter(|(_, u)| **u > 0.0)
            .filter_map(|((&a, &b), &u)| Some((place(x, y, (a, b))?.0, y.clamped(b - u), y.clamped(b + u))))
            .map(|(px, low, high)| error_bar(px, low, high))
            .collect();
    if !d.is_empty() {
        m.empty("path", &[("d", &d), ("fill", "none"), ("stroke", look.colour), ("stroke-width", "0.9")]);
    }
}

fn error_bar(px: f64, low: f64, high: f64) -> String {
    let (left, right) = (units(px - 3.0), units(px + 3.0));
    let (px, low, high) = (units(px), units(low), units(high));
    format!("M{px} {low}V{high}M{left} {low}H{right}M{left} {high}H{right}")
}

/// Label of a vertical mark, above the frame.
#[derive(Debug)]
pub(super) struct MarkLabel<'a> {
    text: &'a str,
    at: f64,
    anchor: &'static str,
    row: usize,
}

impl MarkLabel<'_> {
    /// Base line of the text.
    fn base(&self) -> f64 {
        TOP - 4.0 - MARK_ROW * self.row as f64
    }
}

/// Labels of the marks in rows above the frame, each in the lowest row where it touches no other.
///
/// From right to left: the line of a mark then ends below the labels that reach over it from the left.
pub(super) fn mark_labels<'a>(marks: &'a [Mark], x: &Axis) -> Vec<MarkLabel<'a>> {
    let mut taken: Vec<(usize, f64, f64)> = Vec::new();
    let mut labels = Vec::new();
    let mut placed: Vec<(f64, &Mark)> = marks.iter().filter_map(|m| Some((x.place(m.x)?, m))).collect();
    placed.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (at, mark) in placed {
        let width = text_width(&mark.label);
        let fits = at + width < RIGHT;
        let start = if fits { at } else { at - width };
        let touches =
            |row: usize| taken.iter().any(|(r, a, b)| *r == row && start < *b && start + width > *a);
        let row = (0..).find(|&row| !touches(row)).unwrap_or(0);
        taken.push((row, start - 6.0, start + width + 6.0));
        labels.push(MarkLabel { text: &mark.label, at, anchor: if fits { "start" } else { "end" }, row });
    }
    labels
}

/// Room that the labels of the marks need above the picture.
pub(super) fn mark_rows(labels: &[MarkLabel<'_>]) -> usize {
    labels.iter().map(|l| l.row + 1).max().unwrap_or(0)
}

/// Vertical marks from their labels down to the foot.
pub(super) fn marks(m: &mut Markup, labels: &[MarkLabel<'_>]) {
    for label in labels {
        let d = format!("M{} {}V{}", units(label.at), units(label.base() + 2.0), units(TOP + HEIGHT));
        m.empty("path", &[("d", &d), ("stroke", MARK), ("stroke-width", "1"), ("stroke-dasharray", "2 2")]);
    }
    for label in labels {
        halo(m, label.at, label.base(), label.anchor, MARK, label.text);
    }
}

/// Limits with their labels at the right end, above the line; below it where the top of the picture is too near.
pub(super) fn limits(m: &mut Markup, limits: &[LimitLine], x: &Axis, y: &Axis) {
    let mut taken: Vec<f64> = Vec::new();
    for limit in limits {
        let Some(at) = y.place(limit.y) else { continue };
        let ends = limit.x.map_or([LEFT, RIGHT], |[a, b]| [x.clamped(a.min(b)), x.clamped(a.max(b))]);
        limit_line(m, ends, at);
        let label = number::typeset(&limit.label);
        let mut text_y = if at - TOP < 14.0 { at + 12.0 } else { at - 4.0 };
        while taken.iter().any(|other| (other - text_y).abs() < 11.0) {
            text_y += 12.0;
        }
        taken.push(text_y);
        let end = (ends[1] - 4.0).max(LEFT + 4.0 + text_width(&label));
        halo(m, end, text_y, "end", LIMIT, &label);
    }
}

/// The line of a limit between two abscissae of the paper.
pub(super) fn limit_line(m: &mut Markup, ends: [f64; 2], at: f64) {
    let d = format!("M{} {}H{}", units(ends[0]), units(at), units(ends[1]));
    let dash = ("stroke-dasharray", "10 3 2 3");
    m.empty("path", &[("d", &d), ("stroke", LIMIT), ("stroke-width", "1.6"), dash]);
}

/// Text with a white edge, legible over lines.
fn halo(m: &mut Markup, x: f64, y: f64, anchor: &str, colour: &str, text: &str) {
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

/// The look of a series as a sample in the legend.
pub(super) fn sample(m: &mut Markup, look: &Look, with_errors: bool, ends: [f64; 2], at: f64) {
    let middle = (ends[0] + ends[1]) / 2.0;
    match look.style {
        Style::Line | Style::Fit => stroke(m, &path([(ends[0], at), (ends[1], at)].into_iter()), look),
        Style::Band => {
            let (left, top, width) = (units(ends[0]), units(at - 5.0), units(ends[1] - ends[0]));
            let size = [("width", width.as_str()), ("height", "10"), ("fill", look.colour)];
            m.empty(
                "rect",
                &[
                    ("x", left.as_str()),
                    ("y", top.as_str()),
                    size[0],
                    size[1],
                    size[2],
                    ("fill-opacity", "0.18"),
                ],
            );
        }
        Style::Bars => {
            let d = format!("M{} {}V{}", units(middle), units(at + 6.0), units(at - 6.0));
            m.empty("path", &[("d", &d), ("stroke", look.colour), ("stroke-width", "5")]);
        }
        Style::Markers | Style::Excluded => {
            if with_errors {
                let d = error_bar(middle, at + 6.5, at - 6.5);
                m.empty(
                    "path",
                    &[("d", &d), ("fill", "none"), ("stroke", look.colour), ("stroke-width", "0.9")],
                );
            }
            marker_path(m, &shape(look.shape, (middle, at)), look);
        }
    }
}
