//! Kind `breakaway`: torque ramps, small periodic torque and release show how the contact holds and lets go.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, ReadKeys};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

mod conclude;
mod findings;
mod hold;
mod plan;
mod point;
mod ramps;
#[cfg(test)]
mod tests;

const DOC: &str = "\
# What it finds
The torque at which an axis at rest breaks away (`breakaway-torque`, per ramp and per rate and dwell), how it grows
with the time at rest (`dwell-slope`), the stiffness and damping of the contact before it slides (`bristle-stiffness`,
`presliding-damping`), and by how much static friction exceeds unbalance and spring where the axis must hold itself
without torque (`hold-margin`).

# How it excites
First a slow stroke back and forth around the pose. Each ramp: approach from below by more than 8 z_ss, settle, dwell at
constant torque, then motor torque at a constant rate, dithered by half a quantum, until the axis has moved by
`displacement`. The multisine stays at or below 0.1 of static friction. Hold points release the axis for a while, then
ramp in both directions: three points for each judged pose, a third of a cogging period apart, and one for each further
pose.

# How it computes
F̂ = Kt·i − J·α = Kt·(i − (J/Kt)·α), with Kt from the force gauge and J/Kt from a response of the sliding axis where the
run has them, otherwise from the rig file. The uncertainty of J is included in that of each result. Half the sum of both
directions of the stroke is cogging, unbalance and spring near the pose; it is subtracted from every ramp and from the
multisine. Bristle stiffness σ0 and plateau T_∞ come from an exponential fit with free initial bristle state and rate
term, z_ss = T_∞/σ0 (mean over the ramps). Breakaway is the maximum over 0.5…8 z_ss of F̂ smoothed by one polynomial of
degree 10 over 0.3…9 z_ss; the displacement there is given in the result's flag. The dwell counts from the last motion to
3 z_ss. The dwell law T = T0 + slope·ln(1 + t/τ_d) is that of this maximum, which lies where the contact has mostly
renewed itself: its slope is smaller than the growth of static friction itself. Means that deviate from the law by more than
their repeats explain (χ² per degree of freedom) widen the uncertainty of the slope. Where the fit of the load leaves more
of the half sum than of the half difference of both directions, that widens the uncertainty of the load. Multisine: T + Jω²X = (σ0 + jω(σ1 + σ2))·Z
on the excited lines, Z the bristle along the measured path. Hold: breakaway in the direction of the load, with the load
not subtracted (where the axis slides by itself, minus the torque that accelerates it), mean over the three phases of the
cogging; the amplitude A of the cogging that they show is included in the uncertainty, u = A/√2 (cosine at an unknown
phase).

# Fails when
No breakaway within the time; less than 8 z_ss of displacement; torque at its limit; fit not converged; map missing;
the axis slides during the dwell; χ²/dof beyond 20 for the dwell law or the load, unless the residuals are below a tenth of
the growth with the dwell or of the torque.

# Source
estimators.md §1.5; Canudas de Wit et al. 1995 (LuGre); director.md §3, §8, E23, E24.
";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        "breakaway-torque",
        Q::Torque,
        "Largest friction torque over 0.5…8 z_ss of a torque ramp from rest.",
    ),
    Measurand::new(
        "bristle-stiffness",
        Q::Stiffness,
        "Bristle stiffness σ0: initial slope of friction torque over displacement from rest.",
    ),
    Measurand::new(
        "presliding-damping",
        Q::Damping,
        "Sum of bristle damping σ1 and viscous coefficient σ2 in presliding.",
    ),
    Measurand::new(
        "dwell-slope",
        Q::Torque,
        "Growth of the breakaway torque per unit of ln(1 + t/τ_d) of the time at rest.",
    ),
    Measurand::new(
        "hold-margin",
        Q::Torque,
        "Margin by which static friction exceeds unbalance and spring at a pose, mean over the cogging; \
         negative where the axis slides.",
    ),
];

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>("breakaway", DOC, FIELDS, MEASURANDS);

/// Slowest rate at which the dwell law is judged, A/s: a slower ramp ages the contact while it lasts.
const DWELL_LAW_RATE: f64 = 1.0;
/// Fewest dwell times for a law.
const FEWEST_DWELLS: usize = 3;

/// Whether the ramps ask for a dwell law: three dwells, with repeats, at one rate of 1 A/s or more.
fn asks_for_dwell_law(keys: &Keys) -> bool {
    keys.ramps.iter().any(|r| {
        let mut dwells: Vec<u64> = r.dwells_s.iter().map(|d| d.to_bits()).collect();
        dwells.sort_unstable();
        dwells.dedup();
        let fast = r.rates_a_per_s.iter().any(|&rate| rate >= DWELL_LAW_RATE);
        dwells.len() >= FEWEST_DWELLS && r.repeats >= 2 && fast
    })
}

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let mut names = Vec::new();
        if !self.ramps.is_empty() {
            names.push("breakaway-torque");
        }
        if !self.ramps.is_empty() || self.multisine.is_some() {
            names.push("bristle-stiffness");
        }
        if self.multisine.is_some() {
            names.push("presliding-damping");
        }
        if asks_for_dwell_law(self) {
            names.push("dwell-slope");
        }
        if self.hold.is_some() {
            names.push("hold-margin");
        }
        Some(names)
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(case, window, axes, self.displacement_rad)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        conclude::conclude(self, cases, points, axes)
    }
}

/// Direction of a ramp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Positive,
    Negative,
}

impl Direction {
    /// Both, in the order in which they are run.
    const BOTH: [Self; 2] = [Self::Positive, Self::Negative];

    /// Direction of a number by its sign.
    fn from_ratio(ratio: f64) -> Self {
        if ratio < 0.0 { Self::Negative } else { Self::Positive }
    }

    /// Direction that a ramp point asks for; `None` for all other points.
    fn requested(case: &Case) -> Option<Self> {
        case.requested("direction").map(Self::from_ratio)
    }

    /// +1 or −1.
    fn ratio(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }

    /// The direction in words.
    fn word(self) -> &'static str {
        match self {
            Self::Positive => "positive",
            Self::Negative => "negative",
        }
    }

    fn sign(self) -> char {
        match self {
            Self::Positive => '+',
            Self::Negative => '-',
        }
    }

    /// Label of a ramp's segment.
    fn ramp_label(self) -> String {
        format!("ramp{}", self.sign())
    }

    /// Label of the dwell before a ramp.
    fn dwell_label(self) -> String {
        format!("dwell{}", self.sign())
    }
}

/// The kind's own keys.
const FIELDS: &[Field] = &[
    Field::default(
        "pose",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Pose at which the ramps start; the load should be balanced there.",
    ),
    Field::default(
        "other-axis-pose",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Pose of the other axes, inside their soft limits; the inertia of an axis depends on it.",
    ),
    Field::required(
        "displacement",
        Shape::Quantity(Q::Angle),
        "Movement that ends a ramp: more than 1.1 × 8 z_ss, where z_ss is the expected static friction \
         over bristle stiffness.",
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
        "Velocity of the approach, always from below, which gives the contact a defined history.",
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
    Field::optional(
        "multisine",
        Shape::Table(MULTISINE),
        "Small multisine torque for stiffness and damping.",
    ),
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
    Field::default("cycles", Shape::Integer, "1", "Strokes out and back."),
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
        "Peak torque as a share of the expected static friction, ≤ 0.1.",
    ),
    Field::default(
        "from",
        Shape::Quantity(Q::Frequency),
        "0.1 Hz",
        "Lowest line; its period is the period of the signal.",
    ),
    Field::default("to", Shape::Quantity(Q::Frequency), "10 Hz", "Highest line."),
    Field::default("lines", Shape::Integer, "14", "Lines, log-spaced."),
    Field::default(
        "periods",
        Shape::Integer,
        "5",
        "Periods; the first is dropped, at least four must remain.",
    ),
];

const HOLD: &[Field] = &[
    Field::required(
        "pose",
        Shape::Quantities(Q::Angle),
        "Poses to be judged, each measured at three phases of the cogging.",
    ),
    Field::optional(
        "further-pose",
        Shape::Quantities(Q::Angle),
        "Poses for the curve over the travel only, each measured once.",
    ),
    Field::default("rate", Shape::Quantity(Q::CurrentRate), "1 A/s", "Rate of the ramps at each pose."),
    Field::default(
        "release",
        Shape::Quantity(Q::Time),
        "10 s",
        "Time for which the axis must hold its position without torque.",
    ),
];

/// A breakaway procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
struct Keys {
    pose_rad: f64,
    other_axis_pose_rad: f64,
    displacement_rad: f64,
    holding_torque_nm: f64,
    approach_rad_per_s: f64,
    map: Option<MapKeys>,
    ramps: Vec<RampKeys>,
    multisine: Option<MultisineKeys>,
    hold: Option<HoldKeys>,
    dwell_constant_s: f64,
}

/// The stroke that shows the load.
#[derive(Clone, Debug, PartialEq)]
struct MapKeys {
    velocity_rad_per_s: f64,
    periods: u32,
    cycles: u32,
}

/// Ramps of every rate with every dwell.
#[derive(Clone, Debug, PartialEq)]
struct RampKeys {
    rates_a_per_s: Vec<f64>,
    dwells_s: Vec<f64>,
    repeats: u32,
}

/// The presliding multisine.
#[derive(Clone, Debug, PartialEq)]
struct MultisineKeys {
    level_ratio: f64,
    from_hz: f64,
    to_hz: f64,
    lines: u32,
    periods: u32,
}

/// Poses that must hold.
#[derive(Clone, Debug, PartialEq)]
struct HoldKeys {
    /// Judged, at three phases of the cogging each.
    poses_rad: Vec<f64>,
    /// For the curve over the travel alone, once each.
    further_poses_rad: Vec<f64>,
    rate_a_per_s: f64,
    release_s: f64,
}

impl HoldKeys {
    /// All poses, in the order of the file.
    fn all_poses_rad(&self) -> impl Iterator<Item = f64> {
        self.poses_rad.iter().chain(&self.further_poses_rad).copied()
    }
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let pose_rad = table.quantity("pose");
        let other_axis_pose_rad = table.quantity("other-axis-pose");
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
                "no ramps, no multisine and no hold poses: nothing to run",
                Some(help.to_owned()),
            );
        }
        if (table.has("ramp") || table.has("multisine")) && !table.has("map") {
            let help = "add [map]: a slow stroke that measures cogging, unbalance and spring, which are \
                        subtracted from the ramps";
            table.mistake(
                "map",
                "missing table `map`, which ramps and the multisine need",
                Some(help.to_owned()),
            );
        }
        Some(Self {
            pose_rad: pose_rad?,
            other_axis_pose_rad: other_axis_pose_rad?,
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
        let further_poses_rad = table.quantities("further-pose");
        let rate_a_per_s = table.positive("rate");
        let release_s = table.positive("release");
        Some(Self {
            poses_rad: poses_rad?,
            further_poses_rad: further_poses_rad.unwrap_or_default(),
            rate_a_per_s: rate_a_per_s?,
            release_s: release_s?,
        })
    }
}
