//! The data on the paper: lines, bands, markers, bars, boxes, circles.

use procedures::trace::{Series, Style, outline};

use super::layout::Panel;
use super::look::{Look, Shape};
use super::plane;
use super::units;
use crate::markup::Markup;

/// Half size of a marker.
const RADIUS: f64 = 3.2;

/// Draws all series: areas first, so that nothing is hidden by one; markers last.
pub(super) fn series(m: &mut Markup, panel: &Panel<'_>) {
    let layer = |style: Style| match style {
        Style::Band | Style::Circles => 0,
        Style::Bars | Style::Histogram => 1,
        Style::Line => 2,
        Style::Fit => 3,
        Style::Excluded => 4,
        Style::Markers => 5,
    };
    for current in 0..=5 {
        let all = panel.plot.series.iter().zip(&panel.looks);
        for (s, look) in all.filter(|(s, _)| layer(s.style) == current) {
            match s.style {
                Style::Line | Style::Fit => line(m, s, look, panel),
                Style::Band => band(m, s, look, panel),
                Style::Bars => bars(m, s, look, panel),
                Style::Histogram => boxes(m, s, look, panel),
                Style::Circles => plane::regions(m, s, look, panel),
                Style::Markers | Style::Excluded => markers(m, s, look, panel),
            }
        }
    }
}

/// What nobody sees on paper: a quarter of the width of a line.
const UNSEEN: f64 = 0.3;

/// The points of a line without those that nobody would miss.
fn lean(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let all: Vec<[f64; 2]> = points.map(|(x, y)| [x, y]).collect();
    outline(&all, UNSEEN).into_iter().map(|i| (all[i][0], all[i][1])).collect()
}

/// Farther than this, in tenths, a point is said by its own place: sums of relative ones stay exact.
const JUMP: i64 = 10_000;

/// Straight lines from point to point, in tenths: each is said relative to the one before, and points at the same
/// place once.
pub(super) fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut d = String::new();
    let (mut last, mut command): (Option<[i64; 2]>, char) = (None, ' ');
    for (px, py) in points {
        let at = [px, py].map(|v| (10.0 * v).round() as i64);
        let (next, [dx, dy]) = match last {
            None => ('M', at),
            Some(before) if before == at => continue,
            Some([x, y]) if (at[0] - x).abs().max((at[1] - y).abs()) > JUMP => ('L', at),
            Some([x, y]) => ('l', [at[0] - x, at[1] - y]),
        };
        // A command holds until another one comes.
        d.push(if next == command { ' ' } else { next });
        d += &format!("{} {}", tenths(dx), tenths(dy));
        (last, command) = (Some(at), next);
    }
    d.replace(" -", "-")
}

/// A number of tenths in as few letters as it takes.
fn tenths(count: i64) -> String {
    let sign = if count < 0 { "-" } else { "" };
    let whole = count.abs() / 10;
    let part = count.abs() % 10;
    match (whole, part) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, part) => format!("{sign}.{part}"),
        (whole, part) => format!("{sign}{whole}.{part}"),
    }
}

fn line(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    let d = path(lean(s.x.iter().zip(&s.y).filter_map(|(&a, &b)| panel.place((a, b)))).into_iter());
    stroke(m, &d, look);
}

fn stroke(m: &mut Markup, d: &str, look: &Look) {
    if d.is_empty() {
        return;
    }
    let width = if look.style == Style::Fit { "1.8" } else { "1.3" };
    let solid = [("d", d), ("fill", "none"), ("stroke", look.colour), ("stroke-width", width)];
    let dashed = [solid[0], solid[1], solid[2], solid[3], ("stroke-dasharray", look.dash)];
    m.empty("path", if look.dash == "none" { &solid } else { &dashed });
}

fn band(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    let edge = |sign: f64| {
        s.x.iter().zip(&s.y).zip(&s.u).filter_map(move |((&a, &b), &u)| {
            // The lower edge may leave a logarithmic scale: it ends at the scale's end.
            Some((panel.x.place(a)?, panel.y.clamped(b + sign * u)))
        })
    };
    let upper = lean(edge(1.0));
    let mut lower = lean(edge(-1.0));
    lower.reverse();
    if upper.is_empty() {
        return;
    }
    let d = path(upper.into_iter().chain(lower)) + "Z";
    m.empty("path", &[("d", &d), ("fill", look.colour), ("fill-opacity", "0.18"), ("stroke", "none")]);
}

/// Where bars begin: at zero, or at the foot of a logarithmic scale.
fn base(panel: &Panel<'_>) -> f64 {
    if panel.y.log { panel.area.bottom } else { panel.y.clamped(0.0) }
}

/// Half widths of the boxes: those given, else half the way to the nearest other box.
pub(super) fn half_widths(s: &Series) -> Vec<f64> {
    let mut sorted = s.x.clone();
    sorted.sort_by(f64::total_cmp);
    let gaps = sorted.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > 0.0);
    let narrowest = gaps.reduce(f64::min).unwrap_or(1.0);
    (0..s.x.len()).map(|i| s.u.get(i).map_or(0.5 * narrowest, |u| u.abs())).collect()
}

fn boxes(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    let zero = units(base(panel));
    let d: String =
        s.x.iter()
            .zip(&s.y)
            .zip(half_widths(s))
            .filter(|((_, b), _)| **b != 0.0)
            .filter_map(|((&a, &b), half)| {
                let left = panel.x.clamped(a - half);
                let right = panel.x.clamped(a + half);
                Some(format!("M{} {zero}V{}H{}V{zero}Z", units(left), units(panel.y.place(b)?), units(right)))
            })
            .collect();
    filled(m, &d, look);
}

/// The look of boxes.
fn filled(m: &mut Markup, d: &str, look: &Look) {
    let fill = [("fill", look.colour), ("fill-opacity", "0.55")];
    m.empty("path", &[("d", d), fill[0], fill[1], ("stroke", look.colour), ("stroke-width", "0.8")]);
}

fn bars(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    if !panel.plot.rows.is_empty() {
        return lying_bars(m, s, look, panel);
    }
    let zero = base(panel);
    let d: String =
        s.x.iter()
            .zip(&s.y)
            .filter_map(|(&a, &b)| panel.place((a, b)))
            .map(|(px, py)| format!("M{} {}V{}", units(px), units(zero), units(py)))
            .collect();
    let width = (0.5 * (panel.area.right - panel.area.left) / s.x.len().max(1) as f64).clamp(1.2, 7.0);
    m.empty("path", &[("d", &d), ("stroke", look.colour), ("stroke-width", &units(width))]);
    errors(m, s, look, panel);
}

/// Bars along the rows of a list.
fn lying_bars(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    let zero = units(panel.x.clamped(0.0));
    let places = s.x.iter().zip(&s.y).filter_map(|(&a, &b)| panel.place((a, b)));
    let d: String = places.map(|(px, py)| format!("M{zero} {}H{}", units(py), units(px))).collect();
    let width = [("stroke-width", "9"), ("stroke-opacity", "0.55")];
    m.empty("path", &[("d", &d), ("stroke", look.colour), width[0], width[1]]);
}

fn markers(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    errors(m, s, look, panel);
    let places = s.x.iter().zip(&s.y).filter_map(|(&a, &b)| panel.place((a, b)));
    if look.shape == Shape::Circle && !look.hollow {
        return dots(
            m,
            &places.map(|(px, py)| format!("M{} {}h0", units(px), units(py))).collect::<String>(),
            look,
        );
    }
    let d: String = places.map(|at| shape(look.shape, at)).collect();
    marker_path(m, &d, look);
}

/// Filled circles: lines of no length with round ends, a fifth of the letters.
fn dots(m: &mut Markup, d: &str, look: &Look) {
    let size = units(2.0 * RADIUS + 1.1);
    let line = [("stroke-width", size.as_str()), ("stroke-linecap", "round")];
    m.empty("path", &[("d", d), ("fill", "none"), ("stroke", look.colour), line[0], line[1]]);
}

fn marker_path(m: &mut Markup, d: &str, look: &Look) {
    let fill = if look.hollow { "#ffffff" } else { look.colour };
    m.empty("path", &[("d", d), ("fill", fill), ("stroke", look.colour), ("stroke-width", "1.1")]);
}

fn shape(shape: Shape, (px, py): (f64, f64)) -> String {
    let r = RADIUS;
    let at = |dx: f64, dy: f64| format!("{} {}", units(px + dx), units(py + dy));
    let wide = 2.0 * r;
    match shape {
        Shape::Circle => format!("M{}a{r} {r} 0 1 0 {wide} 0a{r} {r} 0 1 0-{wide} 0Z", at(-r, 0.0)),
        Shape::Square => format!("M{}h{wide}v{wide}h-{wide}Z", at(-r, -r)),
        Shape::Triangle => {
            let [half, high, base] = [r + 0.6, wide + 0.8, wide + 1.2].map(units);
            format!("M{}l{half} {high}h-{base}Z", at(0.0, -r - 0.8))
        }
        Shape::Diamond => {
            let half = units(r + 0.8);
            format!("M{}l{half} {half}-{half} {half}-{half}-{half}Z", at(0.0, -r - 0.8))
        }
    }
}

/// Error bars with caps.
fn errors(m: &mut Markup, s: &Series, look: &Look, panel: &Panel<'_>) {
    let d: String =
        s.x.iter()
            .zip(&s.y)
            .zip(&s.u)
            .filter(|(_, u)| **u > 0.0)
            .filter_map(|((&a, &b), &u)| {
                Some((panel.place((a, b))?.0, panel.y.clamped(b - u), panel.y.clamped(b + u)))
            })
            .map(|(px, low, high)| error_bar(px, low, high))
            .collect();
    if !d.is_empty() {
        m.empty("path", &[("d", &d), ("fill", "none"), ("stroke", look.colour), ("stroke-width", "0.9")]);
    }
}

fn error_bar(px: f64, low: f64, high: f64) -> String {
    let left = units(px - 3.0);
    let px = units(px);
    let low = units(low);
    let high = units(high);
    format!("M{px} {low}V{high}m-3 0h6M{left} {low}h6")
}

/// The look of a series as a sample in the legend.
pub(super) fn sample(m: &mut Markup, look: &Look, with_errors: bool, ends: [f64; 2], at: f64) {
    let middle = (ends[0] + ends[1]) / 2.0;
    match look.style {
        Style::Line | Style::Fit => stroke(m, &path([(ends[0], at), (ends[1], at)].into_iter()), look),
        Style::Band => {
            let left = units(ends[0]);
            let top = units(at - 5.0);
            let width = units(ends[1] - ends[0]);
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
        Style::Circles => {
            let d = plane::circle((middle, at), (6.0, 6.0));
            plane::region(m, &d, look);
        }
        Style::Histogram => {
            let [left, top, foot, right] = [middle - 7.0, at - 5.5, at + 5.5, middle + 7.0].map(units);
            filled(m, &format!("M{left} {foot}V{top}H{right}V{foot}Z"), look);
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
