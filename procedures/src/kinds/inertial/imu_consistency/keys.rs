//! What a procedure says.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "elevation",
        Shape::Quantities(Q::Angle),
        "Elevations at which azimuth spins, a point each.",
    ),
    Field::required("velocity", Shape::Quantity(Q::AngularVelocity), "Velocity of the strokes."),
    Field::default("acceleration", Shape::Quantity(Q::AngularAcceleration), "20 deg/s^2", "At the turns."),
    Field::required("span", Shape::Range(Q::Angle), "Where azimuth turns back."),
    Field::optional(
        "elevation-span",
        Shape::Range(Q::Angle),
        "Where elevation does; no elevation spin without it.",
    ),
    Field::default("cycles", Shape::Integer, "2", "Full cycles of each spin."),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) elevations_rad: Vec<f64>,
    pub(super) velocity_rad_per_s: f64,
    pub(super) acceleration_rad_per_s2: f64,
    pub(super) span_rad: [f64; 2],
    pub(super) elevation_span_rad: Option<[f64; 2]>,
    pub(super) cycles: u32,
}

impl Keys {
    /// Reads them; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let elevations_rad = table.quantities("elevation");
        let velocity = table.positive("velocity");
        let acceleration = table.positive("acceleration");
        let span_rad = table.range("span");
        let elevation_span_rad =
            if table.has("elevation-span") { Some(table.range("elevation-span")?) } else { None };
        let cycles = table.count("cycles", 1);
        Some(Self {
            elevations_rad: elevations_rad?,
            velocity_rad_per_s: velocity?,
            acceleration_rad_per_s2: acceleration?,
            span_rad: span_rad?,
            elevation_span_rad,
            cycles: cycles?,
        })
    }
}
