//! What a sweep is asked for: the kind's own keys, and the points that come of them.
//!
//! One point a velocity (and pose), velocities ascending, each point from where the one before ends.

use std::f64::consts::{PI, TAU};

use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Profile, ProfileLimits, Stimulus};
use crate::table::{Field, Shape, TableReader};

use super::reach::{ramp_rad, span};
use super::strokes;

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

/// A sweep as its procedure file describes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sweep {
    /// Plateau velocities, ascending.
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
    Field::optional("span", Shape::Range(Q::Angle), "Angular range in which every velocity is run."),
    Field::optional("periods", Shape::Integer, "Whole cogging periods on each plateau, instead of `span`."),
    Field::default("centre", Shape::Quantity(Q::Angle), "0 deg", "Middle of the strokes, with `periods`."),
    Field::optional(
        "opposite-span",
        Shape::Range(Q::Angle),
        "The same span shifted by half a turn, to measure unbalance at two opposite poses.",
    ),
    Field::default("cycles", Shape::Integer, "2", "Strokes out and back at each velocity."),
    Field::optional("acceleration", Shape::Quantity(Q::AngularAcceleration), "Default: that of the axis."),
    Field::optional("jerk", Shape::Quantity(Q::AngularJerk), "Default: that of the axis."),
    Field::optional(
        "other-axis-pose",
        Shape::Quantity(Q::Angle),
        "Pose of the other axes; default: 0 inside their travel.",
    ),
];

/// Keys of the kind.
pub(super) const FIELDS: &[Field] = &[Field::optional(
    "sweep",
    Shape::Table(SWEEP),
    "Velocities and strokes; leave it out in procedures that only judge imported records.",
)];

/// Most points of a sweep.
const MOST_POINTS: i64 = 200;

impl ReadKeys for Sweep {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        if table.has("sweep") { table.table("sweep", read) } else { Some(Self::of_imported()) }
    }
}

impl Sweep {
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
        let help = "give a positive velocity; every velocity is run in both directions";
        table.mistake("velocity", "expected velocities above 0", Some(help.to_owned()));
        return None;
    }
    all.sort_by(f64::total_cmp);
    let count = all.len();
    all.dedup_by(|a, b| Q::AngularVelocity.format(*a) == Q::AngularVelocity.format(*b));
    if all.len() < count {
        table.mistake("velocity", "a velocity is given twice", None);
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
    let from_rad_per_s = table.positive("from");
    let to_rad_per_s = table.positive("to");
    let count = table.integer("count", 2);
    let from_rad_per_s = from_rad_per_s?;
    let to_rad_per_s = to_rad_per_s?;
    let count = count?;
    if from_rad_per_s >= to_rad_per_s {
        table.mistake("to", "`to` is not above `from`", None);
        return None;
    }
    if count > MOST_POINTS {
        table.mistake("count", format!("more than {MOST_POINTS} points"), None);
        return None;
    }
    let last = (count - 1) as f64;
    let ratio = to_rad_per_s / from_rad_per_s;
    Some((0..count).map(|k| from_rad_per_s * ratio.powf(k as f64 / last)).collect())
}

fn reach(table: &mut TableReader<'_>) -> Option<Reach> {
    match (table.has("span"), table.has("periods")) {
        (true, false) => {
            if table.has("centre") {
                table.mistake(
                    "centre",
                    "`centre` together with `span`",
                    Some("use it with `periods`".into()),
                );
            }
            table.range("span").map(Reach::Span)
        }
        (false, true) => {
            let count = table.count("periods", 2);
            let centre_rad = table.quantity("centre");
            Some(Reach::Periods { count: count?, centre_rad: centre_rad? })
        }
        (both, _) => {
            let message = if both { "both `span` and `periods`" } else { "neither `span` nor `periods`" };
            let help =
                "give `span = \"-60 deg .. 60 deg\"`, or `periods = 2` for the span that each velocity needs";
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
        let help = "shift both limits of `span` by 180 deg, so that only A_u·cos θ changes its sign";
        table.mistake("opposite-span", "must be half a turn from `span`", Some(help.to_owned()));
        return None;
    }
    Some(Some(opposite))
}

/// Label of the segment that goes to the start of the strokes.
pub(super) const APPROACH: &str = "approach";
/// Label of the segment with all strokes.
pub(super) const STROKES: &str = "strokes";
/// Approaches use this share of the largest velocity.
const APPROACH_SHARE: f64 = 0.5;
/// Static friction over torque quantum that friction needs (director study, settings of the drive scaling).
const QUANTA_IN_FRICTION: f64 = 300.0;

/// The points of a sweep on an axis.
pub(super) fn plan(sweep: &Sweep, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let Some(limits) = axes.get(axis) else {
        let known = axes.names().collect::<Vec<_>>().join(", ");
        return Err(vec![
            Diagnostic::new(format!("the rig has no axis `{axis}`")).help(format!("it has {known}")),
        ]);
    };
    let refused = refuse(sweep, limits);
    if !refused.is_empty() {
        return Err(refused);
    }
    let mut pose = axes.pose(|own| rest(sweep, &own.limits, own.name == axis));
    let mut cases = Vec::new();
    for round in rounds(sweep) {
        for &velocity_rad_per_s in &sweep.velocities_rad_per_s {
            let profile = profile(sweep, limits, velocity_rad_per_s);
            let span_rad = round.span_rad.unwrap_or_else(|| span(sweep, limits, &profile));
            if let (Reach::Span(_), Some(short)) = (sweep.reach, too_short(span_rad, &profile, limits)) {
                return Err(vec![short]);
            }
            let start_rad = pose.get(axis).copied().unwrap_or(0.0);
            cases.push(Case {
                point: name(velocity_rad_per_s, round.pose_rad),
                axis: axis.to_owned(),
                requested: requests(velocity_rad_per_s, round.pose_rad),
                start_pose_rad: pose.clone(),
                segments: segments(limits, start_rad, span_rad, profile, sweep.cycles),
                ..Case::default()
            });
            pose.insert(axis.to_owned(), span_rad[0]);
        }
    }
    Ok(cases)
}

/// One round over all velocities.
struct Round {
    /// Pose that the points name, where there are two.
    pose_rad: Option<f64>,
    /// Limits of the strokes, where they are not those of the sweep's reach.
    span_rad: Option<[f64; 2]>,
}

/// One round without a named pose; with an opposite span, one at 0 and one half a turn further on.
fn rounds(sweep: &Sweep) -> Vec<Round> {
    match sweep.opposite_span_rad {
        None => vec![Round { pose_rad: None, span_rad: None }],
        Some(opposite_rad) => vec![
            Round { pose_rad: Some(0.0), span_rad: None },
            Round { pose_rad: Some(PI), span_rad: Some(opposite_rad) },
        ],
    }
}

fn name(velocity_rad_per_s: f64, pose_rad: Option<f64>) -> String {
    let velocity = format!("velocity={}", Q::AngularVelocity.format(velocity_rad_per_s));
    match pose_rad {
        Some(pose) => format!("{velocity}, pose={}", Q::Angle.format(pose)),
        None => velocity,
    }
}

fn requests(velocity_rad_per_s: f64, pose_rad: Option<f64>) -> Vec<Request> {
    let mut all =
        vec![Request { name: "velocity".into(), value: velocity_rad_per_s, kind: Q::AngularVelocity }];
    all.extend(pose_rad.map(|value| Request { name: "pose".into(), value, kind: Q::Angle }));
    all
}

/// Where an axis rests before the first point: 0, or as asked for the other axes, inside its soft limits.
fn rest(sweep: &Sweep, limits: &AxisLimits, moves: bool) -> f64 {
    let [low, high] = limits.soft_limits_rad;
    let wanted = if moves { 0.0 } else { sweep.other_axis_pose_rad.unwrap_or(0.0) };
    wanted.max(low).min(high)
}

pub(super) fn profile(sweep: &Sweep, limits: &AxisLimits, velocity_rad_per_s: f64) -> ProfileLimits {
    ProfileLimits {
        velocity_rad_per_s,
        acceleration_rad_per_s2: sweep.acceleration_rad_per_s2.unwrap_or(limits.max_acceleration_rad_per_s2),
        jerk_rad_per_s3: sweep.jerk_rad_per_s3.unwrap_or(limits.max_jerk_rad_per_s3),
    }
}

fn segments(
    limits: &AxisLimits,
    start_rad: f64,
    [from_rad, to_rad]: [f64; 2],
    profile: ProfileLimits,
    cycles: u32,
) -> Vec<Segment> {
    let approach = ProfileLimits {
        velocity_rad_per_s: APPROACH_SHARE * limits.max_velocity_rad_per_s,
        acceleration_rad_per_s2: profile.acceleration_rad_per_s2,
        jerk_rad_per_s3: profile.jerk_rad_per_s3,
    };
    vec![
        segment(APPROACH, Stimulus::Move { target_rad: from_rad, limits: approach }, start_rad, Then::Hold),
        segment(
            STROKES,
            Stimulus::Reversals { from_rad, to_rad, limits: profile, cycles },
            from_rad,
            Then::Stop,
        ),
    ]
}

fn segment(label: &str, stimulus: Stimulus, start_rad: f64, then: Then) -> Segment {
    Segment {
        label: label.to_owned(),
        mode: Mode::Position,
        at_most_s: stimulus.duration_s(start_rad).unwrap_or(0.0) * 1.05 + 1.0,
        stimulus,
        until: None,
        then,
        dithered: false,
        ..Segment::default()
    }
}

/// A span whose plateau at this velocity holds no whole cogging period after what is left out at both of its ends.
fn too_short(span_rad: [f64; 2], profile: &ProfileLimits, limits: &AxisLimits) -> Option<Diagnostic> {
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let velocity = profile.velocity_rad_per_s;
    let left_out_rad = velocity * strokes::left_out_s(velocity, period_rad);
    let cruise_rad = velocity * Profile::new(span_rad[1] - span_rad[0], profile).cruise_s();
    if cruise_rad - left_out_rad >= period_rad {
        return None;
    }
    let least_rad = 2.0 * ramp_rad(profile) + left_out_rad + period_rad;
    let message = format!(
        "span {} .. {} is too short for velocity {}: with ramps and settling its plateau is shorter than \
         one cogging period ({})",
        Q::Angle.format(span_rad[0]),
        Q::Angle.format(span_rad[1]),
        Q::AngularVelocity.format(velocity),
        Q::Angle.format(period_rad)
    );
    let help = format!("use a span of at least {}, or slower velocities", Q::Angle.format(least_rad));
    Some(Diagnostic::new(message).help(help))
}

/// What the axis cannot do.
fn refuse(sweep: &Sweep, limits: &AxisLimits) -> Vec<Diagnostic> {
    if sweep.imported() {
        let help = "add `[sweep]` with velocities and a span to run it";
        let message = "the procedure has no `[sweep]`: it judges imported records only";
        return vec![Diagnostic::new(message).help(help)];
    }
    let mut found = too_much(sweep, limits);
    let spans = match sweep.reach {
        Reach::Span(span) => [("span", Some(span)), ("opposite-span", sweep.opposite_span_rad)],
        Reach::Periods { centre_rad, .. } => [("centre", Some([centre_rad; 2])), ("opposite-span", None)],
        Reach::Imported => [("span", None), ("opposite-span", None)],
    };
    for (name, span) in spans {
        found.extend(span.and_then(|span| outside(name, span, limits)));
    }
    let quantum = limits.torque_quantum_nm;
    let finest = limits.expected_static_friction_nm / QUANTA_IN_FRICTION;
    if quantum > finest {
        let message = format!(
            "torque quantum {} is coarser than 1/300 of the expected static friction, {}",
            Q::Torque.format(quantum),
            Q::Torque.format(finest)
        );
        found.push(Diagnostic::new(message).help("reduce the drive's rated torque (6076h)"));
    }
    found
}

/// Velocities, acceleration and jerk above those of the axis.
fn too_much(sweep: &Sweep, limits: &AxisLimits) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = sweep
        .velocities_rad_per_s
        .iter()
        .filter_map(|&v| excess("velocity", Q::AngularVelocity, v, limits.max_velocity_rad_per_s))
        .collect();
    found.extend(
        sweep.acceleration_rad_per_s2.and_then(|a| {
            excess("acceleration", Q::AngularAcceleration, a, limits.max_acceleration_rad_per_s2)
        }),
    );
    found.extend(
        sweep.jerk_rad_per_s3.and_then(|j| excess("jerk", Q::AngularJerk, j, limits.max_jerk_rad_per_s3)),
    );
    found
}

fn excess(name: &str, kind: Q, asked: f64, most: f64) -> Option<Diagnostic> {
    (asked > most * (1.0 + 1e-9)).then(|| {
        let asked = kind.format(asked);
        let most = kind.format(most);
        Diagnostic::new(format!("{name} {asked} is above the axis' {most}"))
            .help(format!("use at most {most}"))
    })
}

fn outside(name: &str, span: [f64; 2], limits: &AxisLimits) -> Option<Diagnostic> {
    let [low, high] = limits.soft_limits_rad;
    if span[0] >= low - 1e-9 && span[1] <= high + 1e-9 {
        return None;
    }
    let text = |range: [f64; 2]| format!("{} .. {}", Q::Angle.format(range[0]), Q::Angle.format(range[1]));
    let soft = text(limits.soft_limits_rad);
    let message = format!("{name} {} exceeds the axis' soft limits {soft}", text(span));
    Some(Diagnostic::new(message).help(format!("stay inside {soft}")))
}
