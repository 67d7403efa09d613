//! Pictures as SVG: axes, series, limits and legend from [`procedures::trace::Plot`].
//!
//! Our own writer. The crate `kuva` 0.6 was tried first with a friction–velocity curve (band, fit, error bars,
//! hollow markers, log axis, limit, mark) and falls short: two renders in one process differ (its clip paths are
//! numbered by a process-wide counter), coordinates carry up to 17 digits, limits reach over the whole width and
//! stand in no legend, bands are missing from the legend and hollow markers are filled there, log axes have decade
//! labels only, bars need categories instead of numbers, and a picture has neither title nor description for
//! screen readers.
//!
//! A picture is 720 units wide; on A4, where three stand on a page, its smallest text is 7 pt. Series differ by dash
//! and marker as well as by colour (Okabe–Ito, readable in greyscale and with any colour vision). Nothing overlaps the
//! data: the legend stands below. Limits are dark and solid or dash-dotted, the forbidden side of a mask is hatched.
//!
//! [`Figure`]s are drawn, not pictures: panels stand above one abscissa. [`zoom::data`] says the same figure as data
//! for the page that lets people zoom.

use procedures::trace::{Scale, Series};

use crate::markup::Markup;
use crate::number;

mod axis;
mod draw;
mod figure;
mod frame;
mod layout;
mod legend;
mod limit;
mod look;
mod mark;
mod mask;
mod plane;
mod span;
mod text;
pub(crate) mod zoom;

pub use figure::Figure;
use layout::Panel;

/// Width of a picture in its own units.
const WIDTH: f64 = 720.0;
/// Right and top edge of the data area.
const RIGHT: f64 = 708.0;
const TOP: f64 = 12.0;
/// Room for tick labels and the label of the abscissa.
const FOOT: f64 = 42.0;

/// A coordinate: one decimal is 0.03 mm on A4, and bytes stay the same.
fn units(value: f64) -> String {
    let text = format!("{value:.1}");
    match text.strip_suffix(".0") {
        Some("-0") => "0".to_owned(),
        Some(whole) => whole.to_owned(),
        None => text,
    }
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

/// The figure as an SVG element. `id` must be unique on its page and a valid XML name; title and description get
/// ids made from it.
pub fn svg(figure: &Figure<'_>, id: &str) -> String {
    let panels = layout::panels(figure);
    let legend = legend::Legend::new(&panels);
    let foot = layout::foot(&panels);
    let all_marks: Vec<_> = panels.iter().flat_map(|p| &p.plot.marks).collect();
    let marks = mark::labels(&all_marks, &panels[0].x);
    let above = mark::ROW * mark::rows(&marks) as f64;
    let title = format!("{id}-title");
    let desc = format!("{id}-desc");
    let view = format!("0 {:.0} {WIDTH:.0} {:.0}", 0.0 - above, foot + legend.height() + above);
    let labelled = format!("{title} {desc}");
    let mut m = Markup::default();
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
            ("stroke-linejoin", "round"),
        ],
    );
    m.element("title", &[("id", &title)], &figure.head().title);
    m.element("desc", &[("id", &desc)], &describe(&panels));
    panels.iter().for_each(|panel| span::draw(&mut m, panel));
    frame::draw(&mut m, &panels);
    panels.iter().for_each(|panel| contents(&mut m, panel));
    mark::draw(&mut m, &marks, foot - FOOT);
    panels.iter().for_each(|panel| limit::draw(&mut m, panel));
    legend.draw(&mut m, foot);
    m.finish()
}

/// Circles and series of a panel; cut off at its edges where it shows a window of them.
fn contents(m: &mut Markup, panel: &Panel<'_>) {
    let cut = panel.is_window();
    if cut {
        let area = panel.area;
        let [x, y, width, height] =
            [area.left, area.top, area.right - area.left, area.bottom - area.top].map(units);
        let view = format!("{x} {y} {width} {height}");
        m.open("svg", &[("x", &x), ("y", &y), ("width", &width), ("height", &height), ("viewBox", &view)]);
    }
    plane::circles(m, panel);
    draw::series(m, panel);
    if cut {
        m.close();
    }
    plane::notes(m, panel);
}

/// The sentence that stands below a figure whose curves are fewer points than were logged.
pub(crate) fn thinned(figure: &Figure<'_>) -> Option<String> {
    let series = || figure.panels().iter().flat_map(|plot| &plot.series);
    let few: Vec<_> = series().filter(|s| s.whole.is_some()).collect();
    let count = |of: fn(&Series) -> usize| few.iter().map(|s| of(s)).sum::<usize>();
    let [drawn, whole] = [count(|s| s.x.len()), count(Series::whole)].map(number::grouped::<usize>);
    let what = if few.len() == series().count() { "curves" } else { "long curves" };
    (!few.is_empty())
        .then(|| format!("{drawn} of {whole} points of its {what} are drawn; extremes and shape are kept."))
}

/// What the figure shows, in words.
fn describe(panels: &[Panel<'_>]) -> String {
    let mut sentences: Vec<String> = panels.iter().map(describe_panel).collect();
    sentences.extend(shortfall_of(panels));
    sentences.join(" ")
}

fn describe_panel(panel: &Panel<'_>) -> String {
    let plot = panel.plot;
    let mut text = match plot.rows.as_slice() {
        [] => format!("{} over {}.", axis_label(&plot.y, 0), axis_label(&plot.x, 0)),
        rows => format!("{} of {}.", axis_label(&plot.x, 0), rows.join(", ")),
    };
    for s in &plot.series {
        let points = s.x.len().min(s.y.len());
        text += &format!(" {}: {}, {points} points.", s.label, look::style_word(s.style));
    }
    let limits = plot.limits.iter().map(|l| &l.label).chain(plot.masks.iter().map(|m| &m.label));
    for label in limits {
        text += &format!(" Limit {}.", number::typeset(label));
    }
    for circle in &plot.circles {
        let what = if circle.forbidden { "Forbidden disk" } else { "Circle" };
        let [x, y] = circle.centre.map(|v| number::short(v, 4));
        let radius = number::short(circle.radius, 4);
        text += &format!(" {what} {} around {x}, {y} of radius {radius}.", number::typeset(&circle.label));
    }
    for span in &plot.spans {
        let [from, to] = span.x.map(|v| number::short(v, 4));
        text += &format!(" {} from {from} to {to}.", number::typeset(&span.label));
    }
    for mark in &plot.marks {
        text += &format!(" Mark {} at {}.", mark.label, number::short(mark.x, 4));
    }
    for note in &plot.notes {
        let [x, y] = note.at.map(|v| number::short(v, 4));
        text += &format!(" Point {} at {x}, {y}.", note.label);
    }
    text
}

/// The sentence that stands below a figure which does not show all of its points.
pub(crate) fn shortfall(figure: &Figure<'_>) -> Option<String> {
    shortfall_of(&layout::panels(figure))
}

fn shortfall_of(panels: &[Panel<'_>]) -> Option<String> {
    let [hidden, outside] =
        panels.iter().map(Panel::missing).fold([0, 0], |[a, b], [hidden, outside]| [a + hidden, b + outside]);
    let count = |n: usize, one: &str, many: &str| match n {
        0 => None,
        1 => Some(format!("One point {one}.")),
        n => Some(format!("{n} points {many}.")),
    };
    let why = "not positive and cannot be shown on a logarithmic scale";
    let sentences: Vec<String> = [
        count(hidden, &format!("is {why}"), &format!("are {why}")),
        count(outside, "lies outside of what the figure shows", "lie outside of what the figure shows"),
    ]
    .into_iter()
    .flatten()
    .collect();
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

#[cfg(test)]
mod tests;
