//! What a procedure says.

use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::optional("hold", Shape::Quantities(Q::Angle), "Poses at which the loop holds the axis."),
    Field::default(
        "hold-time",
        Shape::Quantity(Q::Time),
        "10 s",
        "Time for which the axis is held at each pose.",
    ),
    Field::optional(
        "release",
        Shape::Quantities(Q::Angle),
        "Poses at which the torque is set to zero while the drive stays enabled.",
    ),
    Field::default(
        "release-time",
        Shape::Quantity(Q::Time),
        "5 s",
        "Time for which the axis must hold its position there.",
    ),
    Field::optional(
        "off",
        Shape::Quantities(Q::Angle),
        "Poses at which the drive is disabled; allowed only where static friction is 1.3 times the load.",
    ),
    Field::default(
        "movement",
        Shape::Quantity(Q::Angle),
        "0.25 deg",
        "Movement below which the axis counts as holding itself; larger than the deflection of a contact \
         before it slides.",
    ),
    Field::default(
        "catch",
        Shape::Quantity(Q::Angle),
        "0.6 deg",
        "Movement at which the loop holds the axis again.",
    ),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) held_rad: Vec<f64>,
    pub(super) hold_s: f64,
    pub(super) released_rad: Vec<f64>,
    pub(super) release_s: f64,
    pub(super) off_rad: Vec<f64>,
    pub(super) movement_rad: f64,
    pub(super) catch_rad: f64,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let mut poses = |key| if table.has(key) { table.quantities(key) } else { Some(Vec::new()) };
        let held_rad = poses("hold");
        let released_rad = poses("release");
        let off_rad = poses("off");
        let hold_s = table.positive("hold-time");
        let release_s = table.positive("release-time");
        let movement_rad = table.positive("movement");
        let catch_rad = table.positive("catch");
        if !["hold", "release", "off"].into_iter().any(|key| table.has(key)) {
            let help = Some("add `hold`, `release` or `off` with poses such as [\"40 deg\"]".to_owned());
            table.mistake("hold", "no poses given: nothing to run", help);
        }
        if catch_rad < movement_rad && catch_rad.is_some() {
            table.mistake("catch", "`catch` must not be below `movement`", None);
        }
        Some(Self {
            held_rad: held_rad?,
            hold_s: hold_s?,
            released_rad: released_rad?,
            release_s: release_s?,
            off_rad: off_rad?,
            movement_rad: movement_rad?,
            catch_rad: catch_rad?,
        })
    }
}
