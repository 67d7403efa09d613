//! A figure as data for the page: what people zoom into is what was drawn, with the same colours.

use procedures::trace::{Plot, Series, Side, Style};
use serde::Serialize;
use serde_json::Value;

use super::axis::Axis;
use super::axis_label;
use super::draw::half_widths;
use super::figure::Figure;
use super::layout::{Panel, panels};
use super::look::Look;
use crate::number::typeset;

/// Digits of a number: a hundredth of a picture still has three.
const DIGITS: usize = 5;
/// Lists of no more numbers are written one by one.
const SHORT: usize = 16;
/// Powers of ten up to it, and whole numbers below the other, are exact in floating point.
const MOST_PLACES: i32 = 15;
const LARGEST_WHOLE: f64 = 9e15;

#[derive(Serialize)]
struct Panels<'a> {
    panels: Vec<PanelData<'a>>,
}

/// Names are short where they repeat with every figure; `assets/zoom.js` reads them.
#[derive(Serialize)]
struct PanelData<'a> {
    x: Scale,
    y: Scale,
    height: Value,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    equal: bool,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rows: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    spans: Vec<Named>,
    series: Vec<SeriesData<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    limits: Vec<Limit>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    masks: Vec<Mask>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    circles: Vec<Circle>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    marks: Vec<Named>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<Named>,
}

#[derive(Serialize)]
struct Scale {
    label: String,
    log: bool,
    turn: bool,
    range: [Value; 2],
}

#[derive(Serialize)]
struct SeriesData<'a> {
    label: &'a str,
    style: Style,
    colour: &'a str,
    #[serde(skip_serializing_if = "str::is_empty")]
    dash: &'a str,
    /// Of markers alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<String>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    hollow: bool,
    x: Value,
    y: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    u: Option<Value>,
}

#[derive(Serialize)]
struct Limit {
    label: String,
    y: Value,
    x: Option<[Value; 2]>,
}

#[derive(Serialize)]
struct Mask {
    label: String,
    points: Vec<[Value; 2]>,
    above: bool,
}

#[derive(Serialize)]
struct Circle {
    label: String,
    at: [Value; 2],
    radius: Value,
    forbidden: bool,
}

#[derive(Serialize)]
struct Named {
    label: String,
    at: Vec<Value>,
}

/// The figure as JSON for a script element: no character in it can end one.
pub(crate) fn data(figure: &Figure<'_>) -> String {
    let panels = panels(figure);
    let text = serde_json::to_string(&Panels { panels: panels.iter().map(panel_data).collect() })
        .expect("the structures have string keys only");
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            // All of these stand in strings only, where an escape is the same character.
            '<'
            | '>'
            | '&'
            | '\''
            | '\u{7f}'..='\u{9f}'
            | '\u{2028}'
            | '\u{2029}'
            | '\u{fffe}'
            | '\u{ffff}' => {
                safe.push_str(&format!("\\u{:04x}", u32::from(c)));
            }
            c => safe.push(c),
        }
    }
    safe
}

fn panel_data<'a>(panel: &'a Panel<'a>) -> PanelData<'a> {
    let plot: &'a Plot = panel.plot;
    let scale = |scale: &procedures::trace::Scale, range: [f64; 2]| Scale {
        label: axis_label(scale, 0),
        log: scale.log,
        turn: scale.unit == "deg",
        range: range.map(compact),
    };
    PanelData {
        x: scale(&plot.x, panel.x.range),
        y: scale(&plot.y, panel.y.range),
        height: compact(panel.area.bottom - panel.area.top),
        equal: plot.equal,
        rows: plot.rows.iter().map(|name| typeset(name)).collect(),
        spans: plot.spans.iter().map(|s| named(&s.label, &s.x)).collect(),
        series: plot
            .series
            .iter()
            .zip(&panel.looks)
            .map(|(s, look)| series(s, look, [&panel.x, &panel.y]))
            .collect(),
        limits: plot
            .limits
            .iter()
            .map(|l| Limit { label: typeset(&l.label), y: compact(l.y), x: l.x.map(|x| x.map(compact)) })
            .collect(),
        masks: plot
            .masks
            .iter()
            .map(|mask| Mask {
                label: typeset(&mask.label),
                points: mask.points.iter().map(|p| p.map(compact)).collect(),
                above: mask.forbidden == Side::Above,
            })
            .collect(),
        circles: plot
            .circles
            .iter()
            .map(|c| Circle {
                label: typeset(&c.label),
                at: c.centre.map(compact),
                radius: compact(c.radius),
                forbidden: c.forbidden,
            })
            .collect(),
        marks: plot.marks.iter().map(|m| named(&m.label, &[m.x])).collect(),
        notes: plot.notes.iter().map(|n| named(&n.label, &n.at)).collect(),
    }
}

fn series<'a>(s: &'a Series, look: &Look, [x, y]: [&Axis; 2]) -> SeriesData<'a> {
    let widths = half_widths(s);
    SeriesData {
        label: &s.label,
        style: s.style,
        colour: look.colour,
        dash: if look.dash == "none" { "" } else { look.dash },
        shape: matches!(s.style, Style::Markers | Style::Excluded)
            .then(|| format!("{:?}", look.shape).to_lowercase()),
        hollow: look.hollow,
        x: numbers(&s.x, x.range, x.log),
        y: numbers(&s.y, y.range, y.log),
        u: match s.style {
            Style::Histogram => Some(numbers(&widths, x.range, x.log)),
            // Small beside the scale as they may be, they are not zero.
            _ => (!s.u.is_empty()).then(|| numbers(&s.u, y.range, true)),
        },
    }
}

fn named(label: &str, at: &[f64]) -> Named {
    Named { label: label.to_owned(), at: at.iter().copied().map(compact).collect() }
}

/// All of the numbers, to [`DIGITS`] digits of the scale that they stand on: as the differences between them where that is
/// shorter, `{p, d}` with places of decimals and whole differences; else one by one.
fn numbers(values: &[f64], range: [f64; 2], log: bool) -> Value {
    let places = (DIGITS as i32).saturating_sub((range[1] - range[0]).log10().ceil() as i32);
    let rounded: Vec<f64> = match usize::try_from(places) {
        Ok(places @ 0..=15) if !log => values.iter().map(|v| to_places(*v, places)).collect(),
        _ => values.to_vec(),
    };
    let plain = Value::from_iter(rounded.iter().copied().map(compact));
    let Some((places, whole)) = as_decimals(&rounded).filter(|_| values.len() > SHORT) else { return plain };
    let differences = whole.iter().scan(0, |last, &n| Some(n - std::mem::replace(last, n)));
    let short = serde_json::json!({ "p": places, "d": Value::from_iter(differences) });
    if short.to_string().len() < plain.to_string().len() { short } else { plain }
}

/// The number that ends at a place of decimals; zero without a sign.
fn to_places(value: f64, places: usize) -> f64 {
    format!("{value:.places$}").parse().map_or(value, |v: f64| v + 0.0)
}

/// The least places of decimals that all values end at, and the values in units of the last one.
fn as_decimals(values: &[f64]) -> Option<(i32, Vec<i64>)> {
    (0..=MOST_PLACES).find_map(|places| {
        let unit = 10f64.powi(places);
        let whole = |v: &f64| {
            let n = (v * unit).round();
            // A quotient of whole numbers is the nearest number to the decimal fraction, here and in the page.
            (n.abs() < LARGEST_WHOLE && n / unit == *v).then_some(n as i64)
        };
        Some((places, values.iter().map(whole).collect::<Option<Vec<i64>>>()?))
    })
}

/// The number to [`DIGITS`] digits, whole ones without a point; null for what is no number.
fn compact(value: f64) -> Value {
    let rounded: f64 = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    if rounded.fract() == 0.0 && rounded.abs() < 1e9 {
        Value::from(rounded as i64)
    } else {
        Value::from(rounded)
    }
}

#[cfg(test)]
mod tests {
    use procedures::trace::Scale;

    use super::*;

    #[test]
    fn numbers_are_as_short_as_their_digits() {
        let texts: Vec<String> = [0.1 + 0.2, 20.0, -1.0 / 3.0, 1.5e-12, 123_456_789.0, -0.0, f64::NAN]
            .map(|v| compact(v).to_string())
            .to_vec();
        assert_eq!(texts, ["0.3", "20", "-0.33333", "1.5e-12", "123460000", "0", "null"]);
    }

    /// What `assets/zoom.js` makes of it.
    fn read_back(value: &Value) -> Vec<f64> {
        let Some(differences) = value["d"].as_array() else {
            let all = value.as_array().expect("a list");
            return all.iter().map(|v| v.as_f64().expect("a number")).collect();
        };
        let unit = 10f64.powi(value["p"].as_i64().expect("places") as i32);
        let mut sum = 0;
        let add = |d: &Value| {
            sum += d.as_i64().expect("a whole number");
            sum as f64 / unit
        };
        differences.iter().map(add).collect()
    }

    #[test]
    fn differences_of_decimal_fractions_give_every_bit_back() {
        let slow: Vec<f64> = (0..300).map(|k| (0.3 * f64::from(k)).round() / 1e3 - 7.25).collect();
        let short = numbers(&slow, [-8.0, -7.0], false);
        assert_eq!(short["p"], 3);
        assert_eq!(read_back(&short), slow);
        assert!(short.to_string().len() < 3 * slow.len(), "{short}");
        let ragged: Vec<f64> = (0..300).map(|k| 1.0 / f64::from(k + 1)).collect();
        assert!(numbers(&ragged, [0.001, 1.0], true).is_array(), "no decimal fractions");
        let coarse = numbers(&ragged, [0.0, 1.0], false);
        assert!(read_back(&coarse).iter().zip(&ragged).all(|(a, b)| (a - b).abs() <= 0.5e-5), "{coarse}");
        assert_eq!(read_back(&numbers(&[1e300, -2.5, 0.0], [-1e300, 1e300], false)), [1e300, -2.5, 0.0]);
        assert_eq!(numbers(&[], [0.0, 1.0], false), serde_json::json!([]));
    }

    #[test]
    fn no_label_ends_the_script_that_it_stands_in() {
        let label = "</script><!--<script>&'\"\u{2028}";
        let plot = Plot {
            series: vec![Series::new(label, Style::Line, vec![1.0], vec![2.0])],
            ..Plot::new("a", "b", Scale::linear(label, ""), Scale::default())
        };
        let text = data(&Figure::of(&plot));
        assert!(!text.contains(['<', '>', '&', '\'', '\u{2028}']), "{text}");
        let back: Value = serde_json::from_str(&text).expect("escapes are JSON");
        assert_eq!(back["panels"][0]["series"][0]["label"], label);
    }
}
