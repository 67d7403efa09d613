//! What stands in a picture beside the data: limits, marks, circles, names.

use serde::{Deserialize, Serialize};

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

/// The side of a curve that is forbidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Larger ordinates than the curve's.
    Above,
    /// Smaller ordinates than the curve's.
    Below,
}

/// A limit that depends on the abscissa: a mask, e.g. of a gain over frequency. Its forbidden side is hatched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitCurve {
    /// Legend, e.g. `ATT-AZ: ≤ −20 dB from 100 Hz`.
    pub label: String,
    /// Corners in the units of the scales, abscissae ascending, equal ones for a step; straight on the scales of the
    /// picture, so a slope in dB per decade is two points on a logarithmic abscissa.
    pub points: Vec<[f64; 2]>,
    /// Where nothing may be.
    pub forbidden: Side,
}

/// A circle in a picture of equal units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Circle {
    /// Legend.
    pub label: String,
    /// Centre.
    pub centre: [f64; 2],
    /// Radius, positive.
    pub radius: f64,
    /// Whether nothing may be inside: drawn as a limit instead of a guide.
    pub forbidden: bool,
}

impl Circle {
    /// A circle that only guides the eye.
    pub fn guide(label: impl Into<String>, centre: [f64; 2], radius: f64) -> Self {
        Self { label: label.into(), centre, radius, forbidden: false }
    }

    /// A disk that must stay empty: `|1 + L| ≥ 1/Ms` is one of radius `1/Ms` around −1.
    pub fn forbidden(label: impl Into<String>, centre: [f64; 2], radius: f64) -> Self {
        Self { forbidden: true, ..Self::guide(label, centre, radius) }
    }
}

/// A point with a name beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Note {
    /// Name of the point, e.g. `−1` or `12.4 Hz`.
    pub label: String,
    /// Where.
    pub at: [f64; 2],
}

/// A stretch of the abscissa with a meaning, e.g. a window that an estimate leaves out: shaded behind the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// Legend; stretches that mean the same have the same.
    pub label: String,
    /// From where to where, ascending.
    pub x: [f64; 2],
}
