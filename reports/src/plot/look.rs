//! How series look: colour, dash and marker by their order, so that no two look alike in greyscale.

use procedures::trace::{Plot, Style};

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

/// The look of every series, in their order.
///
/// A band has the colour of the line or fit that it belongs to: the next one in the list, else the one before.
pub(super) fn looks(plot: &Plot) -> Vec<Look> {
    let mut looks = Vec::with_capacity(plot.series.len());
    let (mut colours, mut dashes, mut shapes) = (0, 0, 0);
    for series in &plot.series {
        let own_colour = !matches!(series.style, Style::Band | Style::Excluded);
        let colour = if own_colour { COLOURS[colours % COLOURS.len()] } else { EXCLUDED };
        let dash = match series.style {
            Style::Line => DASHES[dashes % DASHES.len()],
            Style::Fit => FIT_DASH,
            _ => "none",
        };
        looks.push(Look {
            style: series.style,
            colour,
            dash,
            shape: SHAPES[shapes % SHAPES.len()],
            hollow: series.style == Style::Excluded || shapes >= SHAPES.len(),
        });
        colours += usize::from(own_colour);
        dashes += usize::from(series.style == Style::Line);
        shapes += usize::from(series.style == Style::Markers);
    }
    for i in 0..looks.len() {
        if looks[i].style == Style::Band {
            looks[i].colour = band_colour(&looks, i);
        }
        if looks[i].style == Style::Excluded {
            looks[i].shape = marker_before(&looks, i);
        }
    }
    looks
}

fn is_curve(look: &&Look) -> bool {
    matches!(look.style, Style::Line | Style::Fit)
}

fn band_colour(looks: &[Look], band: usize) -> &'static str {
    let after = looks[band + 1..].iter().find(is_curve);
    after.or_else(|| looks[..band].iter().rev().find(is_curve)).map_or(COLOURS[0], |l| l.colour)
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
    }
}
