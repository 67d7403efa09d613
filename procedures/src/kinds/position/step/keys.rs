//! What a procedure says.

use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// Fewer repeats of a direction tell no noise from an overshoot.
pub(super) const LEAST_REPEATS: i64 = 3;

pub(super) const FIELDS: &[Field] = &[
    Field::default("elevation", Shape::Quantities(Q::Angle), "0 deg", "Elevations, one point each."),
    Field::default(
        "step",
        Shape::Quantities(Q::Angle),
        "0.5 deg",
        "Heights of the steps, one point each, directed towards the middle of the travel.",
    ),
    Field::default("repeats", Shape::Integer, "3", "Number of steps out; as many lead back."),
    Field::default("hold", Shape::Quantity(Q::Time), "2.5 s", "Time from one step to the next."),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) elevations_rad: Vec<f64>,
    pub(super) heights_rad: Vec<f64>,
    pub(super) repeats: u32,
    pub(super) hold_s: f64,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let elevations_rad = table.quantities("elevation");
        let heights_rad = table.quantities("step");
        let repeats = table.count("repeats", LEAST_REPEATS);
        let hold_s = table.positive("hold");
        let heights_rad = heights_rad?;
        let hold_s = hold_s?;
        if heights_rad.iter().any(|height| *height <= 0.0) {
            table.mistake(
                "step",
                "give a positive height",
                Some("steps are made in both directions".to_owned()),
            );
        }
        if hold_s < 1.5 {
            let help = "allow 1 s to settle and 0.5 s for the final value".to_owned();
            table.mistake("hold", "the response would be cut off", Some(help));
        }
        let elevations_rad = elevations_rad?;
        let repeats = repeats?;
        table.check_steps("repeats", &[elevations_rad.len(), heights_rad.len(), repeats as usize, 2]);
        Some(Self { elevations_rad, heights_rad, repeats, hold_s })
    }
}
