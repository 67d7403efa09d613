//! What a procedure says.

use crate::case::Case;
use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader, name_of, value_of};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "points",
        Shape::Texts,
        "Points to run: `ends`, `full-speed`, `soft-bench`, `soft-drive`, `zone`.",
    ),
    Field::default("creep", Shape::Quantity(Q::AngularVelocity), "5 deg/s", "Creep rate from end to end."),
    Field::default("full-speed", Shape::Quantity(Q::AngularVelocity), "60 deg/s", "Rate of the fast moves."),
    Field::required("fence", Shape::Range(Q::Angle), "Soft limits that the axis is ordered to pass."),
    Field::default(
        "beyond",
        Shape::Quantity(Q::Angle),
        "15 deg",
        "Distance past the soft limits to which a move is ordered.",
    ),
];

/// What a point is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Ends,
    FullSpeed,
    SoftBench,
    SoftDrive,
    Zone,
}

const STAGES: [(&str, Stage); 5] = [
    ("ends", Stage::Ends),
    ("full-speed", Stage::FullSpeed),
    ("soft-bench", Stage::SoftBench),
    ("soft-drive", Stage::SoftDrive),
    ("zone", Stage::Zone),
];

impl Stage {
    /// Name of the stage, with which the names of its points begin.
    pub(super) fn name(self) -> &'static str {
        name_of(&STAGES, &self)
    }

    /// Stage of a planned point.
    pub(super) fn of(case: &Case) -> Option<Self> {
        value_of(&STAGES, case.point.split(',').next()?)
    }
}

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) stages: Vec<Stage>,
    pub(super) creep_rad_per_s: f64,
    pub(super) full_rad_per_s: f64,
    pub(super) fence_rad: [f64; 2],
    pub(super) beyond_rad: f64,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let stages = table.named_values("points", "point", &STAGES);
        let creep = table.positive("creep");
        let full = table.positive("full-speed");
        let fence = table.range("fence");
        let beyond = table.positive("beyond");
        Some(Self {
            stages: stages?,
            creep_rad_per_s: creep?,
            full_rad_per_s: full?,
            fence_rad: fence?,
            beyond_rad: beyond?,
        })
    }
}

impl Keys {
    /// Whether limits are put to the test.
    pub(super) fn has_limits(&self) -> bool {
        self.stages.iter().any(|stage| !matches!(stage, Stage::Ends | Stage::FullSpeed))
    }
}
