//! What a procedure says.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "duration",
        Shape::Quantity(Q::Time),
        "How long the director stands still, at least 20 s.",
    ),
    Field::default("azimuth", Shape::Quantity(Q::Angle), "0 deg", "Azimuth at which it stands."),
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Elevation at which it stands."),
    Field::optional(
        "latitude",
        Shape::Quantity(Q::Angle),
        "Of the site: the mean rate less the Earth's is the bias.",
    ),
    Field::default("heading", Shape::Quantity(Q::Angle), "0 deg", "Of azimuth zero, clockwise from north."),
    Field::default("creep", Shape::Texts, "az, el", "Axes whose encoder's least count is looked for."),
];

/// Shorter records hold no six averaging times.
const LEAST_DURATION_S: f64 = 20.0;

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) duration_s: f64,
    pub(super) azimuth_rad: f64,
    pub(super) elevation_rad: f64,
    pub(super) latitude_rad: Option<f64>,
    pub(super) heading_rad: f64,
    pub(super) creep: Vec<String>,
}

impl Keys {
    /// Reads them; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let duration_s = table.positive("duration");
        let azimuth_rad = table.quantity("azimuth");
        let elevation_rad = table.quantity("elevation");
        let latitude_rad = if table.has("latitude") { Some(table.quantity("latitude")?) } else { None };
        let heading_rad = table.quantity("heading");
        let creep = table.texts("creep");
        if duration_s.is_some_and(|s| s < LEAST_DURATION_S) {
            table.mistake("duration", format!("`duration` must be {LEAST_DURATION_S} s or more"), None);
        }
        if latitude_rad.is_some_and(|l| l.abs() > std::f64::consts::FRAC_PI_2) {
            table.mistake("latitude", "a latitude lies between -90 deg and 90 deg", None);
        }
        Some(Self {
            duration_s: duration_s?,
            azimuth_rad: azimuth_rad?,
            elevation_rad: elevation_rad?,
            latitude_rad,
            heading_rad: heading_rad?,
            creep: creep?,
        })
    }
}
