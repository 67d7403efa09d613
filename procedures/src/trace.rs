//! Pictures as data: what a report draws, without how.

use serde::{Deserialize, Serialize};

/// Largest number of points in one series: pictures are not the data, the log is.
pub const MAX_POINTS: usize = 2000;

/// An axis of a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scale {
    /// What it shows, e.g. `angle`.
    pub label: String,
    /// Unit of the numbers as drawn, e.g. `deg`; the series are already in it.
    pub unit: String,
    /// Logarithmic.
    pub log: bool,
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
}

/// One series of a picture, in the units of its scales.
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
    /// Half widths of error bars or band, as many as `x`, or empty.
    pub u: Vec<f64>,
}

/// A limit drawn into the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitLine {
    /// Legend, e.g. `FRC-AZ ≤ 260 N*m`.
    pub label: String,
    /// Ordinate of the limit, in the unit of the y scale.
    pub y: f64,
    /// Stretch of the abscissa where it applies; whole width if `None`.
    pub x: Option<[f64; 2]>,
}

/// A vertical mark, e.g. a detected onset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// Legend.
    pub label: String,
    /// Abscissa.
    pub x: f64,
}

/// A picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
}

/// Reduces a curve to at most `most` points, keeping the extremes of every bucket so that peaks survive.
///
/// `x` and `y` must be of equal length; the result's length is `≤ most` (and `most ≥ 4`).
pub fn thin(x: &[f64], y: &[f64], most: usize) -> (Vec<f64>, Vec<f64>) {
    assert_eq!(x.len(), y.len(), "a curve has as many abscissae as ordinates");
    if x.len() <= most {
        return (x.to_vec(), y.to_vec());
    }
    let buckets = most / 2;
    let mut kept = Vec::with_capacity(most);
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
    (kept.iter().map(|&i| x[i]).collect(), kept.iter().map(|&i| y[i]).collect())
}
