//! The kind's own keys.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// How far the strokes go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reach {
    /// Every velocity between these limits.
    Span([f64; 2]),
    /// Every velocity as far as it needs for whole cogging periods on its plateau.
    Periods {
        /// Whole periods.
        count: u32,
        /// Middle of the strokes.
        centre_rad: f64,
    },
    /// Nothing to run: the procedure judges imported records.
    Imported,
}

/// The keys, read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sweep {
    /// Ascending.
    pub(super) velocities_rad_per_s: Vec<f64>,
    pub(super) reach: Reach,
    /// Limits of the same strokes half a turn further on.
    pub(super) opposite_span_rad: Option<[f64; 2]>,
    pub(super) cycles: u32,
    pub(super) acceleration_rad_per_s2: Option<f64>,
    pub(super) jerk_rad_per_s3: Option<f64>,
    /// Where all other axes rest.
    pub(super) other_axis_pose_rad: Option<f64>,
}

/// Keys of the table `[sweep]`.
const SWEEP: &[Field] = &[
    Field::optional("velocity", Shape::Quantities(Q::AngularVelocity), "Plateau velocities, one point each."),
    Field::optional("from", Shape::Quantity(Q::AngularVelocity), "Slowest of log-spaced velocities."),
    Field::optional("to", Shape::Quantity(Q::AngularVelocity), "Fastest of log-spaced velocities."),
    Field::optional("count", Shape::Integer, "How many log-spaced velocities from `from` to `to`."),
    Field::optional("span", Shape::Range(Q::Angle), "Limits between which every velocity runs."),
    Field::optional("periods", Shape::Integer, "Whole cogging periods on each plateau, instead of `span`."),
    Field::default("centre", Shape::Quantity(Q::Angle), "0 deg", "Middle of the strokes, with `periods`."),
    Field::optional(
        "opposite-span",
        Shape::Range(Q::Angle),
        "The same span half a turn further on, for unbalance from two opposite poses.",
    ),
    Field::default("cycles", Shape::Integer, "2", "Strokes there and back at each velocity."),
    Field::optional("acceleration", Shape::Quantity(Q::AngularAcceleration), "Less than the axis allows."),
    Field::optional("jerk", Shape::Quantity(Q::AngularJerk), "Less than the axis allows."),
    Field::optional(
        "other-axis-pose",
        Shape::Quantity(Q::Angle),
        "Where the other axes rest; 0 inside travel.",
    ),
];

/// Keys of the kind.
pub(super) const FIELDS: &[Field] = &[Field::optional(
    "sweep",
    Shape::Table(SWEEP),
    "Velocities and strokes; left out in procedures that judge imported records only.",
)];

/// Most points of a sweep.
const MOST_POINTS: i64 = 200;

impl Sweep {
    /// Reads the keys; mistakes go into the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        if table.has("sweep") { table.table("sweep", read) } else { Some(Self::of_imported()) }
    }

    fn of_imported() -> Self {
        Self {
            velocities_rad_per_s: Vec::new(),
            reach: Reach::Imported,
            opposite_span_rad: None,
            cycles: 1,
            acceleration_rad_per_s2: None,
            jerk_rad_per_s3: None,
            other_axis_pose_rad: None,
        }
    }

    /// Whether there is nothing to run.
    pub(super) fn imported(&self) -> bool {
        self.reach == Reach::Imported
    }

    /// The slowest velocity.
    pub(super) fn slowest(&self) -> Option<f64> {
        self.velocities_rad_per_s.first().copied()
    }
}

fn read(table: &mut TableReader<'_>) -> Option<Sweep> {
    let velocities = velocities(table);
    let reach = reach(table);
    let cycles = table.count("cycles", 1);
    let optional = |table: &mut TableReader<'_>, key| {
        if table.has(key) { table.positive(key).map(Some) } else { Some(None) }
    };
    let acceleration = optional(table, "acceleration");
    let jerk = optional(table, "jerk");
    let other =
        if table.has("other-axis-pose") { table.quantity("other-axis-pose").map(Some) } else { Some(None) };
    let opposite = opposite(table, reach);
    Some(Sweep {
        velocities_rad_per_s: velocities?,
        reach: reach?,
        opposite_span_rad: opposite?,
        cycles: cycles?,
        acceleration_rad_per_s2: acceleration?,
        jerk_rad_per_s3: jerk?,
        other_axis_pose_rad: other?,
    })
}

/// Velocities as listed, or log-spaced; ascending, each once.
fn velocities(table: &mut TableReader<'_>) -> Option<Vec<f64>> {
    let spaced = ["from", "to", "count"].iter().any(|key| table.has(key));
    let mut all = match (table.has("velocity"), spaced) {
        (true, false) => table.quantities("velocity")?,
        (false, true) => log_spaced(table)?,
        (both, _) => {
            let message = if both { "both `velocity` and `from`/`to`/`count`" } else { "no velocities" };
            let help = "give `velocity = [..]`, or `from`, `to` and `count` for log-spaced velocities";
            table.mistake("velocity", message, Some(help.to_owned()));
            return None;
        }
    };
    if all.iter().any(|v| *v <= 0.0) {
        let help = "both directions of every velocity are run, so give it as a positive number";
        table.mistake("velocity", "a velocity that is not above 0", Some(help.to_owned()));
        return None;
    }
    all.sort_by(f64::total_cmp);
    let count = all.len();
    all.dedup_by(|a, b| Q::AngularVelocity.format(*a) == Q::AngularVelocity.format(*b));
    if all.len() < count {
        table.mistake("velocity", "a velocity stands twice", None);
        return None;
    }
    Some(all)
}

fn log_spaced(table: &mut TableReader<'_>) -> Option<Vec<f64>> {
    let mut required = |key| {
        if !table.has(key) {
            table.mistake(
                "from",
                format!("`{key}` is missing"),
                Some("log-spaced velocities need `from`, `to`, `count`".into()),
            );
        }
        table.has(key)
    };
    if !["from", "to", "count"].map(&mut required).iter().all(|&there| there) {
        return None;
    }
    let (from, to, count) = (table.positive("from"), table.positive("to"), table.integer("count", 2));
    let (from, to, count) = (from?, to?, count?);
    if from >= to {
        table.mistake("to", "`to` is not above `from`", None);
        return None;
    }
    if count > MOST_POINTS {
        table.mistake("count", format!("more than {MOST_POINTS} points"), None);
        return None;
    }
    let last = (count - 1) as f64;
    Some((0..count).map(|k| from * (to / from).powf(k as f64 / last)).collect())
}

fn reach(table: &mut TableReader<'_>) -> Option<Reach> {
    match (table.has("span"), table.has("periods")) {
        (true, false) => {
            if table.has("centre") {
                table.mistake("centre", "`centre` with `span`", Some("`centre` belongs to `periods`".into()));
            }
            table.range("span").map(Reach::Span)
        }
        (false, true) => {
            let (count, centre) = (table.count("periods", 2), table.quantity("centre"));
            Some(Reach::Periods { count: count?, centre_rad: centre? })
        }
        (both, _) => {
            let message = if both { "both `span` and `periods`" } else { "neither `span` nor `periods`" };
            let help =
                "give `span = \"-60 deg .. 60 deg\"`, or `periods = 2` for as much as each velocity needs";
            table.mistake(if both { "periods" } else { "span" }, message, Some(help.to_owned()));
            None
        }
    }
}

/// `opposite-span`, half a turn from `span`.
fn opposite(table: &mut TableReader<'_>, reach: Option<Reach>) -> Option<Option<[f64; 2]>> {
    if !table.has("opposite-span") {
        return Some(None);
    }
    let opposite = table.range("opposite-span")?;
    let Some(Reach::Span(span)) = reach else {
        table.mistake("opposite-span", "`opposite-span` without `span`", None);
        return None;
    };
    let turned = |k: usize| ((opposite[k] - span[k]).abs() - std::f64::consts::PI).abs() < 1e-6;
    if !(turned(0) && turned(1)) {
        let help =
            "both limits 180 deg from those of `span`, so that A_u·cos θ changes its sign and nothing else";
        table.mistake("opposite-span", "not half a turn from `span`", Some(help.to_owned()));
        return None;
    }
    Some(Some(opposite))
}
