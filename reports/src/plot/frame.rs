//! The frame of a picture: grid, ticks, labels.

use super::axis::{Axis, Label};
use super::layout::Panel;
use super::text::text_width;
use super::{RIGHT, axis_label, units};
use crate::markup::Markup;

const GRID: &str = "#d9d9d9";
const MINOR_GRID: &str = "#efefef";
const FRAME: &str = "#4d4d4d";
/// Between two labels of an abscissa.
const CLEAR: f64 = 5.0;

/// Draws grid, ticks and labels; those of the abscissa below the last panel only.
pub(super) fn draw(m: &mut Markup, panels: &[Panel<'_>]) {
    panels.iter().for_each(|panel| one(m, panel));
    let Some(last) = panels.last() else { return };
    let area = last.area;
    let x = &last.x;
    labels(m, x, "middle", true, |at| (at, area.bottom + 15.0));
    let middle = units((area.left + RIGHT) / 2.0);
    m.open("text", &[("x", &middle), ("y", &units(area.bottom + 33.0)), ("text-anchor", "middle")]);
    with_powers(m, &axis_label(&panels[0].plot.x, x.power));
    m.close();
}

/// Grid, frame and ordinate of a panel.
fn one(m: &mut Markup, panel: &Panel<'_>) {
    let area = panel.area;
    grid(m, &panel.x, |at| [at, area.top, at, area.bottom]);
    grid(m, &panel.y, |at| [area.left, at, area.right, at]);
    m.empty(
        "rect",
        &[
            ("x", &units(area.left)),
            ("y", &units(area.top)),
            ("width", &units(area.right - area.left)),
            ("height", &units(area.bottom - area.top)),
            ("fill", "none"),
            ("stroke", FRAME),
            ("stroke-width", "0.8"),
        ],
    );
    labels(m, &panel.y, "end", false, |at| (area.left - 6.0, at + 3.8));
    let label = axis_label(&panel.plot.y, panel.y.power);
    if label.is_empty() {
        return;
    }
    let middle = units((area.top + area.bottom) / 2.0);
    let turn = format!("rotate(-90 13 {middle})");
    let place =
        [("x", "13"), ("y", middle.as_str()), ("text-anchor", "middle"), ("transform", turn.as_str())];
    // A label longer than its panel is set smaller, down to what can just be read.
    let fitting = 11.0 * (area.bottom - area.top) / text_width(&label);
    let size = units(fitting.clamp(7.5, 11.0));
    let smaller = [place[0], place[1], place[2], place[3], ("font-size", size.as_str())];
    m.open("text", if fitting < 11.0 { &smaller } else { &place });
    with_powers(m, &label);
    m.close();
}

/// All grid lines of an axis in one path for the major and one for the minor ticks.
fn grid(m: &mut Markup, axis: &Axis, ends: impl Fn(f64) -> [f64; 4]) {
    for (major, colour) in [(false, MINOR_GRID), (true, GRID)] {
        let path: Vec<String> = axis
            .ticks
            .iter()
            .filter(|t| t.label.is_some() == major)
            .filter_map(|t| axis.place(t.at))
            .map(&ends)
            .map(|[x0, y0, x1, y1]| match x0 == x1 {
                true => format!("M{} {}V{}", units(x0), units(y0), units(y1)),
                false => format!("M{} {}H{}", units(x0), units(y0), units(x1)),
            })
            .collect();
        if !path.is_empty() {
            m.empty("path", &[("d", &path.concat()), ("stroke", colour), ("stroke-width", "0.8")]);
        }
    }
}

/// Labels of an axis; those along a line only where they do not touch, round powers of ten first.
fn labels(m: &mut Markup, axis: &Axis, anchor: &str, along: bool, place: impl Fn(f64) -> (f64, f64)) {
    m.open("g", &[("text-anchor", anchor), ("font-size", "10.5")]);
    let all: Vec<(f64, f64, &Label)> =
        axis.ticks.iter().filter_map(|t| Some((t.at, axis.place(t.at)?, t.label.as_ref()?))).collect();
    for (i, &(value, at, label)) in all.iter().enumerate() {
        let touches = |&(_, other_at, other): &(f64, f64, &Label)| {
            let clear = 0.5 * (text_width(&label.text()) + text_width(&other.text())) + CLEAR;
            (at - other_at).abs() < clear
        };
        // A label gives way to the one before it, and to a decade that follows.
        let follows = all.get(i + 1).filter(|next| axis.log && !is_decade(value) && is_decade(next.0));
        let before = i.checked_sub(1).map(|b| &all[b]).filter(|_| !(axis.log && is_decade(value)));
        if along && (follows.is_some_and(touches) || before.is_some_and(touches)) {
            continue;
        }
        let (x, y) = place(at);
        m.open("text", &[("x", &units(x)), ("y", &units(y))]);
        match label {
            Label::Plain(text) => m.text(text),
            Label::Power(power) => with_powers(m, &format!("10^{power}")),
        }
        m.close();
    }
    m.close();
}

fn is_decade(value: f64) -> bool {
    (value.log10() - value.log10().round()).abs() < 1e-9
}

/// Text in which `10^n` stands as a power.
fn with_powers(m: &mut Markup, text: &str) {
    let Some((before, rest)) = text.split_once("10^") else { return m.text(text) };
    let digits = rest.len()
        - rest.trim_start_matches(['-', '−', '0', '1', '2', '3', '4', '5', '6', '7', '8', '9']).len();
    m.text(before);
    m.text("10");
    m.element("tspan", &[("baseline-shift", "super"), ("font-size", "8")], &rest[..digits].replace('-', "−"));
    m.text(&rest[digits..]);
}
