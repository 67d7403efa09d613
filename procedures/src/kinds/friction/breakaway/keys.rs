//! What a breakaway procedure says, and how it is read.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default(
        "pose",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Where the ramps start: where the load is balanced.",
    ),
    Field::required(
        "displacement",
        Shape::Quantity(Q::Angle),
        "Movement that ends a ramp: more than 1.1 × 8 z_ss as expected, z_ss = static friction over bristle stiffness.",
    ),
    Field::default(
        "holding-torque",
        Shape::Quantity(Q::Torque),
        "0 N*m",
        "Motor torque during the dwell and at the start of each ramp, for poses where the load is not balanced.",
    ),
    Field::default(
        "approach-velocity",
        Shape::Quantity(Q::AngularVelocity),
        "2 deg/s",
        "Velocity of the approach, always from below, that fixes the history of the contact.",
    ),
    Field::optional(
        "map",
        Shape::Table(MAP),
        "Slow stroke that shows cogging, unbalance and spring near the pose.",
    ),
    Field::optional(
        "ramp",
        Shape::Tables(RAMP),
        "Torque ramps: every rate with every dwell, both directions.",
    ),
    Field::optional("multisine", Shape::Table(MULTISINE), "Small periodic torque for stiffness and damping."),
    Field::optional("hold", Shape::Table(HOLD), "Poses at which the axis must hold itself unpowered."),
    Field::default(
        "dwell-constant",
        Shape::Quantity(Q::Time),
        "1 s",
        "τ_d of the dwell law T = T0 + slope·ln(1 + t/τ_d): given, not fitted.",
    ),
];

const MAP: &[Field] = &[
    Field::default("velocity", Shape::Quantity(Q::AngularVelocity), "1 deg/s", "Velocity of the stroke."),
    Field::default("periods", Shape::Integer, "2", "Cogging periods on each side of the pose."),
    Field::default("cycles", Shape::Integer, "1", "Strokes there and back."),
];

const RAMP: &[Field] = &[
    Field::required("rate", Shape::Quantities(Q::CurrentRate), "Rates of the motor current."),
    Field::default(
        "dwell",
        Shape::Quantities(Q::Time),
        "1 s",
        "Times at rest without motion before the ramp.",
    ),
    Field::default("repeats", Shape::Integer, "1", "Ramps of each rate, dwell and direction."),
];

const MULTISINE: &[Field] = &[
    Field::default(
        "level",
        Shape::Quantity(Q::Ratio),
        "0.09",
        "Peak torque over expected static friction, ≤ 0.1.",
    ),
    Field::default(
        "from",
        Shape::Quantity(Q::Frequency),
        "0.1 Hz",
        "Lowest line; its period is that of the whole.",
    ),
    Field::default("to", Shape::Quantity(Q::Frequency), "10 Hz", "Highest line."),
    Field::default("lines", Shape::Integer, "14", "Lines, log-spaced."),
    Field::default(
        "periods",
        Shape::Integer,
        "5",
        "Periods; the first is dropped, four or more must remain.",
    ),
];

const HOLD: &[Field] = &[
    Field::required("pose", Shape::Quantities(Q::Angle), "Poses."),
    Field::default("rate", Shape::Quantity(Q::CurrentRate), "1 A/s", "Rate of the ramps at each pose."),
    Field::default(
        "release",
        Shape::Quantity(Q::Time),
        "10 s",
        "How long the axis must stay put without torque.",
    ),
];

/// A breakaway procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) pose_rad: f64,
    pub(super) displacement_rad: f64,
    pub(super) holding_torque_nm: f64,
    pub(super) approach_rad_per_s: f64,
    pub(super) map: Option<MapKeys>,
    pub(super) ramps: Vec<RampKeys>,
    pub(super) multisine: Option<MultisineKeys>,
    pub(super) hold: Option<HoldKeys>,
    pub(super) dwell_constant_s: f64,
}

/// The stroke that shows the load.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapKeys {
    pub(super) velocity_rad_per_s: f64,
    pub(super) periods: u32,
    pub(super) cycles: u32,
}

/// Ramps of every rate with every dwell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RampKeys {
    pub(super) rates_a_per_s: Vec<f64>,
    pub(super) dwells_s: Vec<f64>,
    pub(super) repeats: u32,
}

/// The presliding multisine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MultisineKeys {
    pub(super) level_ratio: f64,
    pub(super) from_hz: f64,
    pub(super) to_hz: f64,
    pub(super) lines: u32,
    pub(super) periods: u32,
}

/// Poses that must hold.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HoldKeys {
    pub(super) poses_rad: Vec<f64>,
    pub(super) rate_a_per_s: f64,
    pub(super) release_s: f64,
}

impl Keys {
    /// Reads the kind's keys; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let pose_rad = table.quantity("pose");
        let displacement_rad = table.positive("displacement");
        let holding_torque_nm = table.quantity("holding-torque");
        let approach_rad_per_s = table.positive("approach-velocity");
        let dwell_constant_s = table.positive("dwell-constant");
        let map = table.table("map", MapKeys::read);
        let ramps = table.tables("ramp", RampKeys::read);
        let multisine = table.table("multisine", MultisineKeys::read);
        let hold = table.table("hold", HoldKeys::read);
        let cells = |r: &RampKeys| r.rates_a_per_s.len() * r.dwells_s.len() * r.repeats as usize;
        table.check_steps("ramp", &[ramps.iter().flatten().map(cells).sum(), 2]);
        let written = |key| table.has(key);
        if !["ramp", "multisine", "hold"].into_iter().any(written) {
            let help = "add [[ramp]] with `rate = [\"1 A/s\"]`, [multisine], or [hold] with poses";
            table.mistake(
                "ramp",
                "nothing to do: no ramps, no multisine, no poses to hold",
                Some(help.to_owned()),
            );
        }
        if (table.has("ramp") || table.has("multisine")) && !table.has("map") {
            let help =
                "add [map]: a slow stroke shows cogging, unbalance and spring, which are taken off the ramps";
            table.mistake(
                "map",
                "missing table `map`, which ramps and the multisine need",
                Some(help.to_owned()),
            );
        }
        Some(Self {
            pose_rad: pose_rad?,
            displacement_rad: displacement_rad?,
            holding_torque_nm: holding_torque_nm?,
            approach_rad_per_s: approach_rad_per_s?,
            map,
            ramps: ramps.unwrap_or_default(),
            multisine,
            hold,
            dwell_constant_s: dwell_constant_s?,
        })
    }
}

impl MapKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let velocity_rad_per_s = table.positive("velocity");
        let periods = table.count("periods", 1);
        let cycles = table.count("cycles", 1);
        Some(Self { velocity_rad_per_s: velocity_rad_per_s?, periods: periods?, cycles: cycles? })
    }
}

impl RampKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let rates_a_per_s = all_positive(table, "rate");
        let dwells_s = all_positive(table, "dwell");
        let repeats = table.count("repeats", 1);
        Some(Self { rates_a_per_s: rates_a_per_s?, dwells_s: dwells_s?, repeats: repeats? })
    }
}

fn all_positive(table: &mut TableReader<'_>, key: &'static str) -> Option<Vec<f64>> {
    let values = table.quantities(key)?;
    if values.iter().any(|&v| v <= 0.0) {
        table.mistake(key, format!("every `{key}` must be greater than zero"), None);
        return None;
    }
    Some(values)
}

/// Largest ratio of the ends of a multisine times its lines: its peak is searched on a grid as fine as that.
const MOST_DESIGN: f64 = 1e5;

impl MultisineKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let level_ratio = table.positive("level");
        let from_hz = table.positive("from");
        let to_hz = table.positive("to");
        let lines = table.count("lines", 3);
        let periods = table.count("periods", 5);
        if let (Some(from), Some(to)) = (from_hz, to_hz)
            && to < 2.0 * from
        {
            table.mistake("to", "`to` must be at least twice `from`", None);
        }
        let design = |from: f64, to: f64, lines: u32| to / from * f64::from(lines);
        if let (Some(from), Some(to), Some(lines)) = (from_hz, to_hz, lines)
            // An overflow to infinity or to no number is too much as well.
            && !matches!(design(from, to, lines), work if work <= MOST_DESIGN)
        {
            let help = "raise `from`: all lines share the period 1/`from`".to_owned();
            let message = format!("`to` over `from`, times `lines`, must be at most {MOST_DESIGN}");
            table.mistake("from", message, Some(help));
        }
        Some(Self {
            level_ratio: level_ratio?,
            from_hz: from_hz?,
            to_hz: to_hz?,
            lines: lines?,
            periods: periods?,
        })
    }
}

impl HoldKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let poses_rad = table.quantities("pose");
        let rate_a_per_s = table.positive("rate");
        let release_s = table.positive("release");
        Some(Self { poses_rad: poses_rad?, rate_a_per_s: rate_a_per_s?, release_s: release_s? })
    }
}
