//! Pictures as SVG: axes, series, limits and legend from [`procedures::trace::Plot`].
//!
//! Our own writer. The crate `kuva` 0.6 was tried first with a friction–velocity curve (band, fit, error bars,
//! hollow markers, log axis, limit, mark) and falls short: two renders in one process differ (its clip paths are
//! numbered by a process-wide counter), coordinates carry up to 17 digits, limits reach over the whole width and
//! stand in no legend, bands are missing from the legend and hollow markers are filled there, log axes have decade
//! labels only, bars need categories instead of numbers, and a picture has neither title nor description for
//! screen readers.
//!
//! A picture is 720 units wide; on A4 its smallest text is 7.5 pt. Series differ by dash and marker as well as by
//! colour (Okabe–Ito, readable in greyscale and with any colour vision). Nothing overlaps the data: the legend
//! stands below.

use procedures::trace::{Plot, Scale, Style};

use crate::markup::Markup;
use crate::number;

mod axis;
mod draw;
mod frame;
mod legend;
mod look;
mod text;

use axis::Axis;

/// Width of a picture in its own units.
const WIDTH: f64 = 720.0;
/// Height of the data area.
const HEIGHT: f64 = 270.0;
/// Left, right and top edge of the data area.
const LEFT: f64 = 62.0;
const RIGHT: f64 = 708.0;
const TOP: f64 = 12.0;
/// Room for tick labels and the label of the abscissa.
const FOOT: f64 = 42.0;

/// A coordinate: one decimal is 0.03 mm on A4, and bytes stay the same.
fn units(value: f64) -> String {
    let text = format!("{value:.1}");
    if text == "-0.0" { "0.0".to_owned() } else { text }
}

/// `label in unit`.
fn axis_label(scale: &Scale, power: i32) -> String {
    let unit = number::typeset(&scale.unit);
    match (unit.as_str(), power) {
        ("" | "1", 0) => scale.label.clone(),
        ("" | "1", _) => format!("{} × 10^{}", scale.label, -power),
        (_, 0) => format!("{} in {unit}", scale.label),
        _ => format!("{} in 10^{power} {unit}", scale.label),
    }
}

/// The picture as an SVG element. `id` must be unique on its page and a valid XML name; title and description get
/// ids made from it.
pub fn svg(plot: &Plot, id: &str) -> String {
    let looks = look::looks(plot);
    let legend = legend::Legend::new(plot, &looks);
    let height = TOP + HEIGHT + FOOT + legend.height();
    let (x, y) = axes(plot);
    let mut m = Markup::default();
    let (title, desc) = (format!("{id}-title"), format!("{id}-desc"));
    let marks = draw::mark_labels(&plot.marks, &x);
    let above = draw::MARK_ROW * draw::mark_rows(&marks) as f64;
    let view = format!("0 {:.0} {WIDTH:.0} {:.0}", 0.0 - above, height + above);
    let labelled = format!("{title} {desc}");
    m.open(
        "svg",
        &[
            ("xmlns", "http://www.w3.org/2000/svg"),
            ("viewBox", &view),
            ("class", "plot"),
            ("role", "img"),
            ("aria-labelledby", &labelled),
            ("font-family", "Helvetica, Arial, 'Liberation Sans', sans-serif"),
            ("font-size", "11"),
            ("fill", "#1a1a1a"),
        ],
    );
    m.element("title", &[("id", &title)], &plot.title);
    m.element("desc", &[("id", &desc)], &describe(plot, &x, &y));
    frame::draw(&mut m, &x, &y, &axis_label(&plot.x, x.power), &axis_label(&plot.y, y.power));
    draw::series(&mut m, plot, &looks, &x, &y);
    draw::marks(&mut m, &marks);
    draw::limits(&mut m, &plot.limits, &x, &y);
    legend.draw(&mut m, TOP + HEIGHT + FOOT);
    m.finish()
}

/// Scales that show every point with its uncertainty, every limit and every mark.
fn axes(plot: &Plot) -> (Axis, Axis) {
    let xs = plot.series.iter().flat_map(|s| s.x.iter().copied()).chain(plot.marks.iter().map(|m| m.x));
    let mut ys: Vec<f64> = plot.limits.iter().map(|l| l.y).collect();
    for s in &plot.series {
        for (i, &y) in s.y.iter().enumerate() {
            let u = s.u.get(i).copied().unwrap_or(0.0);
            ys.extend([y, y - u, y + u]);
        }
        if s.style == Style::Bars {
            ys.push(0.0);
        }
    }
    (
        Axis::new(xs, plot.x.log, [LEFT, RIGHT], 9),
        Axis::new(ys.into_iter(), plot.y.log, [TOP + HEIGHT, TOP], 6),
    )
}

/// Points that the scales cannot show: zero or negative on a logarithmic one.
fn hidden(plot: &Plot, x: &Axis, y: &Axis) -> usize {
    plot.series
        .iter()
        .flat_map(|s| s.x.iter().zip(&s.y))
        .filter(|&(&a, &b)| x.place(a).is_none() || y.place(b).is_none())
        .count()
}

/// What the picture shows, in words.
fn describe(plot: &Plot, x: &Axis, y: &Axis) -> String {
    let mut text = format!("{} over {}.", axis_label(&plot.y, 0), axis_label(&plot.x, 0));
    for s in &plot.series {
        let points = s.x.len().min(s.y.len());
        text += &format!(" {}: {}, {points} points.", s.label, look::style_word(s.style));
    }
    for l in &plot.limits {
        text += &format!(" Limit {}.", number::typeset(&l.label));
    }
    for mark in &plot.marks {
        text += &format!(" Mark {} at {}.", mark.label, number::short(mark.x, 4));
    }
    match hidden(plot, x, y) {
        0 => text,
        count => {
            text + &format!(" {count} points are not positive and cannot be shown on a logarithmic scale.")
        }
    }
}

/// The sentence that stands below a picture which does not show all of its points.
pub(crate) fn shortfall(plot: &Plot) -> Option<String> {
    let (x, y) = axes(plot);
    match hidden(plot, &x, &y) {
        0 => None,
        1 => Some("One point is not positive and cannot be shown on a logarithmic scale.".to_owned()),
        count => Some(format!("{count} points are not positive and cannot be shown on a logarithmic scale.")),
    }
}

/// Place of a point; `None` if one of the scales cannot show it.
fn place(x: &Axis, y: &Axis, point: (f64, f64)) -> Option<(f64, f64)> {
    Some((x.place(point.0)?, y.place(point.1)?))
}

#[cfg(test)]
mod tests;
