//! What a procedure says, and the points: the sequence of ISO 230-2, and poses.

use analysis::positioning::{LEAST_RUNS, targets_needed};

use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Segment};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned::{self, Elevation};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::ProfileLimits;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "targets",
        Shape::Quantities(Q::Angle),
        "Targets, ascending; faces of the polygon where there is one.",
    ),
    Field::default("runs", Shape::Integer, "5", "Number of runs in each direction, at least 5."),
    Field::default("elevation", Shape::Quantity(Q::Angle), "0 deg", "Elevation while azimuth moves."),
    Field::default(
        "velocity",
        Shape::Quantity(Q::AngularVelocity),
        "40 deg/s",
        "Limit for the moves between targets.",
    ),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "60 deg/s^2",
        "Limit for the moves between targets.",
    ),
    Field::default(
        "overrun",
        Shape::Quantity(Q::Angle),
        "1 deg",
        "Distance beyond the last target at which a run reverses.",
    ),
    Field::default("settle", Shape::Quantity(Q::Time), "1.5 s", "Rest at a target before it is measured."),
    Field::default("measure", Shape::Quantity(Q::Time), "0.3 s", "Time over which a position is averaged."),
    Field::optional("poses", Shape::Quantities(Q::Angle), "Poses to ISO 9283, measured in their own point."),
    Field::default("pose-cycles", Shape::Integer, "30", "Number of visits to each pose, at least 5."),
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

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
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
        table.mistake("targets", "list the targets in ascending order, each once", None);
        return;
    }
    let span_rad = targets_rad[targets_rad.len() - 1] - targets_rad[0];
    let needed = targets_needed(span_rad);
    if targets_rad.len() < needed {
        let message = format!(
            "{} targets over {}, but ISO 230-2 requires {needed}",
            targets_rad.len(),
            Q::Angle.format(span_rad)
        );
        table.mistake("targets", message, Some("add targets between them".to_owned()));
    }
}

/// What a point goes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sequence {
    /// All targets, from both sides.
    Targets,
    /// The poses, from below.
    Poses,
}

impl Sequence {
    /// The point's name.
    const fn name(self) -> &'static str {
        match self {
            Self::Targets => "targets",
            Self::Poses => "poses",
        }
    }

    /// The sequence that a point was planned for.
    pub(super) fn of(case: &Case) -> Self {
        if case.point == Self::Poses.name() { Self::Poses } else { Self::Targets }
    }
}

/// Part of the autocollimator's range that a target may be off its face.
const RANGE_RATIO: f64 = 0.75;

/// Label of a rest at a target.
pub(super) fn visit(target: usize, upwards: bool) -> String {
    format!("target {target} from {}", if upwards { "below" } else { "above" })
}

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = positioned::limits_of(axis, axes)?;
    let mut mistakes = Vec::new();
    mistakes.extend(Elevation::of(axis, axes).held_outside(keys.elevation_rad));
    let poses = keys.poses_rad.as_deref().unwrap_or_default();
    for (what, place) in
        keys.targets_rad.iter().map(|t| ("target", t)).chain(poses.iter().map(|p| ("pose", p)))
    {
        mistakes.extend(no_face(what, *place, axis, limits));
        mistakes.extend(positioned::outside(what, *place, axis, limits));
    }
    let [first, last] = [keys.targets_rad[0], keys.targets_rad[keys.targets_rad.len() - 1]];
    for turn in [first - keys.overrun_rad, last + keys.overrun_rad] {
        mistakes.extend(positioned::outside("turning at", turn, axis, limits));
    }
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let profile = positioned::profile(limits, keys.velocity_rad_per_s, keys.acceleration_rad_per_s2);
    let case = |sequence: Sequence, start_rad: f64, segments: Vec<Segment>| Case {
        point: sequence.name().to_owned(),
        axis: axis.to_owned(),
        start_pose_rad: positioned::start_pose(axes, axis, start_rad, keys.elevation_rad),
        segments: positioned::ended(segments),
        ..Case::default()
    };
    let start_rad = first - keys.overrun_rad;
    let mut cases = vec![case(Sequence::Targets, start_rad, runs(keys, start_rad, profile))];
    if !poses.is_empty() {
        let start_rad = poses[0] - keys.overrun_rad;
        cases.push(case(Sequence::Poses, start_rad, cycles(keys, poses, start_rad, profile)));
    }
    Ok(cases)
}

/// A target must be where a face can be read.
fn no_face(what: &str, target_rad: f64, axis: &str, limits: &AxisLimits) -> Option<Diagnostic> {
    let reference = limits.reference.as_ref()?;
    let face_rad = reference.nearest_rad(target_rad)?;
    if (face_rad - target_rad).abs() <= RANGE_RATIO * reference.range_rad {
        return None;
    }
    let message = format!(
        "{what} {} is not a face of the polygon on axis `{axis}`; the nearest is at {}",
        Q::Angle.format(target_rad),
        Q::Angle.format(face_rad)
    );
    let part_rad = std::f64::consts::TAU / reference.faces_rad.len() as f64;
    Some(Diagnostic::new(message).help(format!("use multiples of {}", Q::Angle.format(part_rad))))
}

struct Course {
    at_rad: f64,
    profile: ProfileLimits,
    rest_s: f64,
    segments: Vec<Segment>,
}

impl Course {
    fn visit(&mut self, label: &str, target_rad: f64) {
        self.turn(target_rad);
        self.segments.push(positioned::stay(label, self.rest_s));
    }

    fn turn(&mut self, target_rad: f64) {
        self.segments.push(positioned::move_to("move", self.at_rad, target_rad, self.profile));
        self.at_rad = target_rad;
    }
}

fn runs(keys: &Keys, start_rad: f64, profile: ProfileLimits) -> Vec<Segment> {
    let rest_s = keys.settle_s + keys.measure_s;
    let mut course =
        Course { at_rad: start_rad, profile, rest_s, segments: vec![positioned::stay("before", 1.0)] };
    let count = keys.targets_rad.len();
    for _ in 0..keys.runs {
        for (k, &target_rad) in keys.targets_rad.iter().enumerate() {
            course.visit(&visit(k, true), target_rad);
        }
        course.turn(keys.targets_rad[count - 1] + keys.overrun_rad);
        for (k, &target_rad) in keys.targets_rad.iter().enumerate().rev() {
            course.visit(&visit(k, false), target_rad);
        }
        course.turn(start_rad);
    }
    course.segments
}

fn cycles(keys: &Keys, poses: &[f64], start_rad: f64, profile: ProfileLimits) -> Vec<Segment> {
    let rest_s = keys.settle_s + keys.measure_s;
    let mut course =
        Course { at_rad: start_rad, profile, rest_s, segments: vec![positioned::stay("before", 1.0)] };
    for _ in 0..keys.pose_cycles {
        for (k, &pose_rad) in poses.iter().enumerate() {
            let below_rad = pose_rad - keys.overrun_rad;
            if course.at_rad != below_rad {
                course.turn(below_rad);
            }
            course.visit(&visit(k, true), pose_rad);
        }
    }
    course.segments
}
