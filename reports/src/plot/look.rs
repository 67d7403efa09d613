//! How series look: colour, dash and marker by their order, so that no two look alike in greyscale.

use procedures::trace::{Plot, Series, Style};

/// Okabe–Ito colours, those dark enough for thin lines on white first.
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#007a5a", "#a3397d", "#56b4e9", "#6b5b00"];
/// Dashes of lines; the dash of fits is not among them.
const DASHES: [&str; 6] = ["none", "1.5 2", "9 2 2 2", "4 2", "9 2 2 2 2 2", "12 3"];
/// Dash of fits.
const FIT_DASH: &str = "7 4";
/// Colour of what was excluded.
const EXCLUDED: &str = "#555555";

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Circle,
    Square,
    Triangle,
    Diamond,
}

const SHAPES: [Shape; 4] = [Shape::Circle, Shape::Square, Shape::Triangle, Shape::Diamond];

/// Look of one series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    pub(super) style: Style,
    pub(super) colour: &'static str,
    pub(super) dash: &'static str,
    pub(super) shape: Shape,
    /// Hollow markers: excluded data, and markers beyond the fourth shape.
    pub(super) hollow: bool,
}

/// How much of what distinguishes series has been used.
#[derive(Debug, Default)]
struct Used {
    colours: usize,
    dashes: usize,
    shapes: usize,
}

/// The look of every series of every panel, in their order. A series that reads like one before it, in its panel or
/// in another, looks like it; no two others look alike.
///
/// A band or region has the colour of the line or fit that it belongs to: the next one in the list, else the one
/// before, else the same of markers; of as many bands as markers without any curve each has that of its own.
pub(super) fn looks(panels: &[&Plot]) -> Vec<Vec<Look>> {
    let mut used = Used::default();
    let mut all: Vec<Vec<Look>> = Vec::with_capacity(panels.len());
    for panel in panels {
        let mut looks: Vec<Look> = Vec::with_capacity(panel.series.len());
        for series in &panel.series {
            let earlier = panels.iter().zip(&all).flat_map(|(p, looks)| p.series.iter().zip(looks));
            let beside = panel.series.iter().zip(&looks).filter(|(s, _)| !s.label.is_empty());
            let reads_alike = |(s, _): &(&Series, &Look)| s.label == series.label && s.style == series.style;
            let known = earlier.chain(beside).find(reads_alike).map(|(_, look)| *look);
            looks.push(known.unwrap_or_else(|| next(series.style, &mut used)));
        }
        let own = band_of_markers(&looks);
        for i in 0..looks.len() {
            if is_area(looks[i].style) {
                looks[i].colour = own.get(i).copied().flatten().unwrap_or_else(|| area_colour(&looks, i));
            }
            if looks[i].style == Style::Excluded {
                looks[i].shape = marker_before(&looks, i);
            }
        }
        all.push(looks);
    }
    all
}

/// A look that no series has yet.
fn next(style: Style, used: &mut Used) -> Look {
    let own_colour = !is_area(style) && style != Style::Excluded;
    let look = Look {
        style,
        colour: if own_colour { COLOURS[used.colours % COLOURS.len()] } else { EXCLUDED },
        dash: match style {
            Style::Line => DASHES[used.dashes % DASHES.len()],
            Style::Fit => FIT_DASH,
            _ => "none",
        },
        shape: SHAPES[used.shapes % SHAPES.len()],
        hollow: style == Style::Excluded || used.shapes >= SHAPES.len(),
    };
    used.colours += usize::from(own_colour);
    used.dashes += usize::from(style == Style::Line);
    used.shapes += usize::from(style == Style::Markers);
    look
}

fn is_area(style: Style) -> bool {
    matches!(style, Style::Band | Style::Circles)
}

/// Colours of bands in a picture of as many bands as markers and no curve: each belongs to its markers, in their order.
fn band_of_markers(looks: &[Look]) -> Vec<Option<&'static str>> {
    let markers: Vec<&'static str> =
        looks.iter().filter(|l| l.style == Style::Markers).map(|l| l.colour).collect();
    let bands = looks.iter().filter(|l| is_area(l.style)).count();
    let curves = looks.iter().any(|l| matches!(l.style, Style::Line | Style::Fit));
    if curves || bands != markers.len() {
        return Vec::new();
    }
    let mut next = markers.into_iter();
    looks.iter().map(|l| if is_area(l.style) { next.next() } else { None }).collect()
}

fn area_colour(looks: &[Look], area: usize) -> &'static str {
    let nearest = |belongs: fn(Style) -> bool| {
        let after = looks[area + 1..].iter().find(|l| belongs(l.style));
        after.or_else(|| looks[..area].iter().rev().find(|l| belongs(l.style)))
    };
    let curve = nearest(|style| matches!(style, Style::Line | Style::Fit));
    curve.or_else(|| nearest(|style| style == Style::Markers)).map_or(COLOURS[0], |l| l.colour)
}

/// Excluded data has the shape of the series that it was excluded from: the markers before it.
fn marker_before(looks: &[Look], excluded: usize) -> Shape {
    let before = looks[..excluded].iter().rev().find(|l| l.style == Style::Markers);
    before.map_or(Shape::Circle, |l| l.shape)
}

/// The style in words.
pub(super) fn style_word(style: Style) -> &'static str {
    match style {
        Style::Line => "line",
        Style::Fit => "dashed line",
        Style::Markers => "markers",
        Style::Excluded => "hollow markers, excluded",
        Style::Bars => "bars",
        Style::Band => "band",
        Style::Histogram => "boxes",
        Style::Circles => "circles",
    }
}
