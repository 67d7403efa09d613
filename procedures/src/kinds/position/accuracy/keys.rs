//! What a procedure says.

use analysis::positioning::{LEAST_RUNS, targets_needed};

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "targets",
        Shape::Quantities(Q::Angle),
        "Targets, ascending; faces of the polygon where there is one.",
    ),
    Field::default("runs", Shape::Integer, "5", "Runs in each direction, at least 5."),
    Field::default("elevation", Shape::Quantity(Q::Angle), "0 deg", "Elevation while azimuth moves."),
    Field::default(
        "velocity",
        Shape::Quantity(Q::AngularVelocity),
        "40 deg/s",
        "Of the moves between targets.",
    ),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "60 deg/s^2",
        "Of the moves between targets.",
    ),
    Field::default(
        "overrun",
        Shape::Quantity(Q::Angle),
        "1 deg",
        "How far beyond the last target a run turns.",
    ),
    Field::default("settle", Shape::Quantity(Q::Time), "1.5 s", "Rest at a target before it is measured."),
    Field::default("measure", Shape::Quantity(Q::Time), "0.3 s", "Time over which a place is averaged."),
    Field::optional("poses", Shape::Quantities(Q::Angle), "Poses after ISO 9283, a point of their own."),
    Field::default("pose-cycles", Shape::Integer, "30", "Visits of each pose, at least 5."),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) targets_rad: Vec<f64>,
    pub(super) runs: u32,
    pub(super) elevation_rad: f64,
    pub(super) velocity_rad_per_s: f64,
    pub(super) acceleration_rad_per_s2: f64,
    pub(super) overrun_rad: f64,
    pub(super) settle_s: f64,
    pub(super) measure_s: f64,
    pub(super) poses_rad: Option<Vec<f64>>,
    pub(super) pose_cycles: u32,
}

impl Keys {
    /// Reads them; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let targets = table.quantities("targets");
        let runs = table.count("runs", LEAST_RUNS as i64);
        let cycles = table.count("pose-cycles", LEAST_RUNS as i64);
        let elevation = table.quantity("elevation");
        let velocity = table.positive("velocity");
        let acceleration = table.positive("acceleration");
        let overrun = table.positive("overrun");
        let settle = table.positive("settle");
        let measure = table.positive("measure");
        let poses = table.has("poses").then(|| table.quantities("poses"));
        let targets_rad = targets?;
        let runs = runs?;
        let cycles = cycles?;
        check(table, &targets_rad);
        table.check_steps("runs", &[targets_rad.len(), runs as usize, 4]);
        let poses_given = poses.iter().flatten().map(Vec::len).next().unwrap_or(0);
        table.check_steps("pose-cycles", &[poses_given, cycles as usize, 2]);
        Some(Self {
            targets_rad,
            runs,
            elevation_rad: elevation?,
            velocity_rad_per_s: velocity?,
            acceleration_rad_per_s2: acceleration?,
            overrun_rad: overrun?,
            settle_s: settle?,
            measure_s: measure?,
            poses_rad: match poses {
                Some(poses) => Some(poses?),
                None => None,
            },
            pose_cycles: cycles,
        })
    }
}

fn check(table: &mut TableReader<'_>, targets_rad: &[f64]) {
    if targets_rad.windows(2).any(|pair| pair[1] <= pair[0]) {
        table.mistake("targets", "targets ascend, each once", None);
        return;
    }
    let span_rad = targets_rad[targets_rad.len() - 1] - targets_rad[0];
    let needed = targets_needed(span_rad);
    if targets_rad.len() < needed {
        let message = format!(
            "{} targets over {}: ISO 230-2 asks for {needed}",
            targets_rad.len(),
            Q::Angle.format(span_rad)
        );
        table.mistake("targets", message, Some("add targets between them".to_owned()));
    }
}
