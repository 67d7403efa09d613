//! Pictures as data: what a report draws, without how.

use serde::{Deserialize, Serialize};

mod condense;
mod guide;

pub use condense::{condense, outline};
pub use guide::{Circle, LimitCurve, LimitLine, Mark, Note, Side, Span};

/// Largest number of points in one series: pictures are not the data, the log is.
pub const MAX_POINTS: usize = 1200;

/// An axis of a picture.
///
/// Numbers in `deg` have their ticks at parts of a turn as soon as the scale spans an eighth of one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scale {
    /// What it shows, e.g. `angle`.
    pub label: String,
    /// Unit of the numbers as drawn, e.g. `deg`; the series are already in it.
    pub unit: String,
    /// Logarithmic.
    pub log: bool,
}

impl Scale {
    /// A linear scale.
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), log: false }
    }

    /// A logarithmic scale.
    pub fn logarithmic(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { log: true, ..Self::linear(label, unit) }
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Style {
    /// A line through the points.
    Line,
    /// A dashed line, for models and fits.
    Fit,
    /// Filled markers, with error bars where `u` is given.
    Markers,
    /// Hollow markers: data that was excluded and stays visible.
    Excluded,
    /// Vertical bars from zero, for spectra.
    Bars,
    /// The area between `y - u` and `y + u`.
    Band,
    /// Filled boxes from zero, `u` wide to either side of `x`: classes of a histogram.
    Histogram,
    /// Circles of radius `u` around the points: where the points of a plane lie with some confidence.
    Circles,
}

/// One series of a picture, in the units of its scales. Several with one label and style look alike and stand in the
/// legend once: a line with gaps is one series for each of its pieces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Legend.
    pub label: String,
    /// How it is drawn.
    pub style: Style,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates, as many as `x`.
    pub y: Vec<f64>,
    /// Half widths of error bars, band or boxes, or radii; as many as `x`, or empty.
    pub u: Vec<f64>,
    /// Points of the curve that these few stand for; `None` where they are all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub whole: Option<usize>,
}

impl Series {
    /// A series without uncertainties; `x` and `y` are of equal length.
    pub fn new(label: impl Into<String>, style: Style, x: Vec<f64>, y: Vec<f64>) -> Self {
        Self { label: label.into(), style, x, y, u: Vec::new(), whole: None }
    }

    /// At most `most` points of a curve, as [`thin`] takes them.
    pub fn thinned(label: impl Into<String>, style: Style, [x, y]: [&[f64]; 2], most: usize) -> Self {
        let (few_x, few_y) = thin(x, y, most);
        Self::new(label, style, few_x, few_y).drawn_from(x.len())
    }

    /// This series, standing for a curve of so many points.
    pub fn drawn_from(self, points: usize) -> Self {
        Self { whole: (points > self.x.len()).then_some(points), ..self }
    }

    /// Points of the curve that these stand for: themselves where there are no more.
    pub fn whole(&self) -> usize {
        self.whole.unwrap_or(self.x.len())
    }

    /// This series with half widths or radii, as many as points.
    pub fn with_u(self, u: Vec<f64>) -> Self {
        Self { u, ..self }
    }
}

/// A picture.
///
/// Write `Plot { series, ..Plot::new(id, title, x, y) }`: fields that a picture does not need stay empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Plot {
    /// Unique in its procedure, kebab-case, e.g. `loop-10-deg-s`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Abscissa.
    pub x: Scale,
    /// Ordinate.
    pub y: Scale,
    /// What is drawn.
    pub series: Vec<Series>,
    /// Limits; the judge adds those of the requirements whose measurand is `limits_of`.
    pub limits: Vec<LimitLine>,
    /// Vertical marks.
    pub marks: Vec<Mark>,
    /// Measurand whose requirement limits belong into this picture.
    pub limits_of: Option<String>,
    /// Those limits hold for the magnitude: they are drawn below zero too.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub limits_of_magnitude: bool,
    /// Shaded stretches of the abscissa.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spans: Vec<Span>,
    /// Names of rows, from top to bottom: the ordinate is a list then, its first row at 1. Bars lie along their rows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<String>,
    /// Masks: limits that depend on the abscissa.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub masks: Vec<LimitCurve>,
    /// Circles of a plane: unit circle, disk of a modulus margin.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub circles: Vec<Circle>,
    /// Points with a name, e.g. `−1`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<Note>,
    /// Id of the picture of the same procedure below which this one stands as a further panel, on the same abscissa:
    /// a Bode figure is a gain with phase and coherence as panels of it. The first picture must be no panel itself;
    /// one that names no such picture stands alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub panel_of: Option<String>,
    /// Stretch of the abscissa that is shown, in its unit; everything if `None`. That of a panel is its picture's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x_range: Option<[f64; 2]>,
    /// Stretch of the ordinate that is shown, in its unit; everything if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_range: Option<[f64; 2]>,
    /// A unit is as long on the ordinate as on the abscissa. Has no meaning on logarithmic scales and with panels.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub equal: bool,
}

impl Plot {
    /// A picture of nothing yet.
    pub fn new(id: impl Into<String>, title: impl Into<String>, x: Scale, y: Scale) -> Self {
        Self { id: id.into(), title: title.into(), x, y, ..Self::default() }
    }

    /// The complex plane around the critical point: equal units, unit circle and −1, shown to 2.5 from the origin on
    /// the left and 1.5 elsewhere (a loop with an integrator has no end). Series are real part over imaginary part.
    pub fn nyquist(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self {
            circles: vec![Circle::guide("unit circle", [0.0, 0.0], 1.0)],
            notes: vec![Note { label: "−1".to_owned(), at: [-1.0, 0.0] }],
            x_range: Some([-2.5, 1.5]),
            y_range: Some([-1.5, 1.5]),
            equal: true,
            ..Self::new(id, title, Scale::linear("real part", ""), Scale::linear("imaginary part", ""))
        }
    }

    /// This picture as a panel below the picture `head`.
    pub fn panel_of(self, head: &Self) -> Self {
        Self { panel_of: Some(head.id.clone()), ..self }
    }
}

/// Reduces a curve to at most `most` points, keeping its ends and the extremes of every bucket so that peaks survive.
///
/// `x` and `y` must be of equal length; the result's length is `≤ most` (and `most ≥ 4`).
pub fn thin(x: &[f64], y: &[f64], most: usize) -> (Vec<f64>, Vec<f64>) {
    assert_eq!(x.len(), y.len(), "a curve has as many abscissae as ordinates");
    if x.len() <= most {
        return (x.to_vec(), y.to_vec());
    }
    let buckets = most / 2 - 1;
    let mut kept = Vec::with_capacity(most);
    kept.push(0);
    for bucket in 0..buckets {
        let span = bucket * x.len() / buckets..(bucket + 1) * x.len() / buckets;
        let low = span.clone().min_by(|&a, &b| y[a].total_cmp(&y[b]).then(a.cmp(&b)));
        let high = span.max_by(|&a, &b| y[a].total_cmp(&y[b]).then(b.cmp(&a)));
        let (Some(low), Some(high)) = (low, high) else { continue };
        kept.push(low.min(high));
        if low != high {
            kept.push(low.max(high));
        }
    }
    kept.push(x.len() - 1);
    kept.dedup();
    (kept.iter().map(|&i| x[i]).collect(), kept.iter().map(|&i| y[i]).collect())
}
