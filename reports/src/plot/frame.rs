//! The frame of a picture: grid, ticks, labels.

use super::axis::{Axis, Label};
use super::{HEIGHT, LEFT, RIGHT, TOP, units};
use crate::markup::Markup;

const GRID: &str = "#d9d9d9";
const MINOR_GRID: &str = "#efefef";
const FRAME: &str = "#4d4d4d";

/// Draws grid, ticks and labels.
pub(super) fn draw(m: &mut Markup, x: &Axis, y: &Axis, x_label: &str, y_label: &str) {
    let bottom = TOP + HEIGHT;
    grid(m, x, |at| [at, TOP, at, bottom]);
    grid(m, y, |at| [LEFT, at, RIGHT, at]);
    m.empty(
        "rect",
        &[
            ("x", &units(LEFT)),
            ("y", &units(TOP)),
            ("width", &units(RIGHT - LEFT)),
            ("height", &units(HEIGHT)),
            ("fill", "none"),
            ("stroke", FRAME),
            ("stroke-width", "0.8"),
        ],
    );
    labels(m, x, "middle", |at| (at, bottom + 15.0));
    labels(m, y, "end", |at| (LEFT - 6.0, at + 3.8));
    let middle = units((LEFT + RIGHT) / 2.0);
    m.open("text", &[("x", &middle), ("y", &units(bottom + 33.0)), ("text-anchor", "middle")]);
    with_powers(m, x_label);
    m.close();
    let turn = format!("rotate(-90 13 {})", units(TOP + HEIGHT / 2.0));
    let middle = units(TOP + HEIGHT / 2.0);
    m.open("text", &[("x", "13"), ("y", &middle), ("text-anchor", "middle"), ("transform", &turn)]);
    with_powers(m, y_label);
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
            .map(|[x0, y0, x1, y1]| format!("M{} {}L{} {}", units(x0), units(y0), units(x1), units(y1)))
            .collect();
        if !path.is_empty() {
            m.empty("path", &[("d", &path.concat()), ("stroke", colour), ("stroke-width", "0.8")]);
        }
    }
}

fn labels(m: &mut Markup, axis: &Axis, anchor: &str, place: impl Fn(f64) -> (f64, f64)) {
    m.open("g", &[("text-anchor", anchor), ("font-size", "10.5")]);
    for tick in &axis.ticks {
        let (Some(label), Some(at)) = (&tick.label, axis.place(tick.at)) else { continue };
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
