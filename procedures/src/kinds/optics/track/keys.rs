//! What a procedure says, and the points: a target that stands until it is tracked, then moves; bounds hold the axes.

use crate::axis::{Axes, Gimbal};
use crate::case::{Bounds, Case, Condition, Mode, Segment, Then, Tracks};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned::{ELEVATION, gimbal_for, outside, poses, request};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};
use crate::table::{Field, Shape, TableReader, suggestion};
use crate::target::{Target, TargetCourse};

const RAILS: &[Field] = &[
    Field::required("distance", Shape::Quantity(Q::Length), "Distance to the middle of the rails."),
    Field::required("rail", Shape::Quantity(Q::Length), "Length of one rail; there is a joint after each."),
    Field::required("count", Shape::Integer, "Number of rails in line; the target starts at their end."),
    Field::default(
        "jolt",
        Shape::Quantity(Q::Time),
        "1.5 s",
        "Time after a joint during which it can explain a peak.",
    ),
];

pub(super) const FIELDS: &[Field] = &[
    Field::required("target", Shape::Choice(&["star", "rail", "drone"]), "Target to track."),
    Field::required("loops", Shape::Texts, "Loops to close, one point each: `coarse`, `fine`, `both`."),
    Field::required(
        "elevation",
        Shape::Quantities(Q::Angle),
        "Elevations at which the target starts, one point each.",
    ),
    Field::default("azimuth", Shape::Quantity(Q::Angle), "0 deg", "Azimuth at which the target starts."),
    Field::optional(
        "span",
        Shape::Range(Q::Angle),
        "Azimuth range of the target's course; both axes are bounded to half of it plus 3 deg. Default: 1 \
         deg about `azimuth`.",
    ),
    Field::default(
        "off-load",
        Shape::Boolean,
        "true",
        "With both loops closed: the axes take over the mean angle of the mirror.",
    ),
    Field::default(
        "settle",
        Shape::Quantity(Q::Time),
        "9 s",
        "Time from the first lock to the record; the target begins to move meanwhile.",
    ),
    Field::required("duration", Shape::Quantity(Q::Time), "Length of the record."),
    Field::required(
        "window-threshold",
        Shape::Quantity(Q::AngularAcceleration),
        "Acceleration of the target about an axis that opens a window of that axis.",
    ),
    Field::default(
        "window-before",
        Shape::Quantity(Q::Time),
        "0.3 s",
        "Lead time of a window before the threshold is exceeded.",
    ),
    Field::default(
        "window-after",
        Shape::Quantity(Q::Time),
        "0.8 s",
        "Time for which a window stays open afterwards.",
    ),
    Field::default(
        "most-in-windows",
        Shape::Quantity(Q::Ratio),
        "5 %",
        "Largest share of the record in windows; beyond it there is no verdict.",
    ),
    Field::default(
        "acceleration-bandwidth",
        Shape::Quantity(Q::Frequency),
        "1 Hz",
        "Bandwidth of the estimate of the target's acceleration (accurate to 1 % up to it).",
    ),
    Field::default(
        "cause-rate",
        Shape::Quantity(Q::AngularVelocity),
        "1 mrad/s",
        "Change of the target's rate within the length of a window that counts as the cause of a peak.",
    ),
    Field::default(
        "dwell-limit",
        Shape::Quantity(Q::Angle),
        "5 urad",
        "Largest root mean square of the error in a dwell.",
    ),
    Field::default(
        "dwell-window",
        Shape::Quantity(Q::Time),
        "6 s",
        "Length of the sliding window for the root mean square.",
    ),
    Field::optional("rails", Shape::Table(RAILS), "Geometry of the rails, to locate their joints."),
];

/// Shortest record with the fine loop: a dwell is at least as long (ENG-DWELL).
const LEAST_DWELL_S: f64 = 6.0;
/// Half of the span where none is given: 1 deg.
const HALF_SPAN_RAD: f64 = std::f64::consts::PI / 180.0;

/// Which loops are closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Loops {
    Coarse,
    Fine,
    Both,
}

const LOOPS: [(&str, Loops); 3] = [("coarse", Loops::Coarse), ("fine", Loops::Fine), ("both", Loops::Both)];

impl Loops {
    pub(super) fn coarse(self) -> bool {
        self != Self::Fine
    }

    pub(super) fn fine(self) -> bool {
        self != Self::Coarse
    }

    pub(super) fn name(self) -> &'static str {
        LOOPS.iter().find(|(_, loops)| *loops == self).map_or("", |(name, _)| name)
    }
}

/// Where rails have their joints. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rails {
    pub(super) distance_m: f64,
    pub(super) rail_m: f64,
    pub(super) count: u32,
    pub(super) jolt_s: f64,
}

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) target: TargetCourse,
    pub(super) loops: Vec<Loops>,
    pub(super) elevations_rad: Vec<f64>,
    pub(super) azimuth_rad: f64,
    pub(super) span_rad: [f64; 2],
    pub(super) off_load: bool,
    pub(super) settle_s: f64,
    pub(super) duration_s: f64,
    pub(super) threshold_rad_per_s2: f64,
    pub(super) before_s: f64,
    pub(super) after_s: f64,
    pub(super) most_in_windows: f64,
    pub(super) bandwidth_hz: f64,
    pub(super) cause_rad_per_s: f64,
    pub(super) dwell_limit_rad: f64,
    pub(super) dwell_window_s: f64,
    pub(super) rails: Option<Rails>,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let target = table.text("target").map(|word| match word.as_str() {
            "rail" => TargetCourse::Rail,
            "drone" => TargetCourse::Drone,
            _ => TargetCourse::Star,
        });
        let loops = loops(table);
        let elevations_rad = table.quantities("elevation");
        let azimuth_rad = table.quantity("azimuth");
        let around = azimuth_rad.map(|at| [at - HALF_SPAN_RAD, at + HALF_SPAN_RAD]);
        let span_rad = if table.has("span") { table.range("span") } else { around };
        let off_load = table.boolean("off-load");
        let settle_s = table.positive("settle");
        let duration_s = table.positive("duration");
        let threshold = table.positive("window-threshold");
        let before_s = table.quantity("window-before");
        let after_s = table.quantity("window-after");
        let most = table.positive("most-in-windows");
        let bandwidth_hz = table.positive("acceleration-bandwidth");
        let dwell_limit = table.positive("dwell-limit");
        let dwell_window = table.positive("dwell-window");
        let cause_rate = table.positive("cause-rate");
        let rails = if table.has("rails") { Some(table.table("rails", Rails::read)?) } else { None };
        let keys = Self {
            target: target?,
            loops: loops?,
            elevations_rad: elevations_rad?,
            azimuth_rad: azimuth_rad?,
            span_rad: span_rad?,
            off_load: off_load?,
            settle_s: settle_s?,
            duration_s: duration_s?,
            threshold_rad_per_s2: threshold?,
            before_s: before_s?,
            after_s: after_s?,
            most_in_windows: most?,
            bandwidth_hz: bandwidth_hz?,
            cause_rad_per_s: cause_rate?,
            dwell_limit_rad: dwell_limit?,
            dwell_window_s: dwell_window?,
            rails,
        };
        keys.refuse(table);
        Some(keys)
    }
}

impl Keys {
    /// What cannot be measured so.
    fn refuse(&self, table: &mut TableReader<'_>) {
        if self.loops.contains(&Loops::Fine) && self.target != TargetCourse::Star {
            let help = "use `target = \"star\"`, or close both loops".to_owned();
            table.mistake("loops", "the fine loop alone cannot follow a target that moves", Some(help));
        }
        if self.loops.iter().any(|loops| loops.fine()) && self.duration_s < LEAST_DWELL_S {
            let help = "record at least 6 s (ENG-DWELL)".to_owned();
            table.mistake("duration", "the record is shorter than the shortest dwell", Some(help));
        }
        let [low, high] = self.span_rad;
        if !(low..=high).contains(&self.azimuth_rad) {
            table.mistake("span", "the target does not start inside `span`", None);
        }
        if self.before_s < 0.0 || self.after_s < 0.0 {
            table.mistake("window-before", "a window does not end before it begins", None);
        }
    }
}

impl Rails {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let distance_m = table.positive("distance");
        let rail_m = table.positive("rail");
        let count = table.count("count", 1);
        let jolt_s = table.positive("jolt");
        Some(Self { distance_m: distance_m?, rail_m: rail_m?, count: count?, jolt_s: jolt_s? })
    }
}

fn loops(table: &mut TableReader<'_>) -> Option<Vec<Loops>> {
    let given = table.spanned_texts("loops")?;
    let mut all = Vec::new();
    for (name, span) in &given {
        match LOOPS.iter().find(|(known, _)| known == name) {
            Some((_, loops)) if !all.contains(loops) => all.push(*loops),
            Some(_) => table.mistake_at(span.clone(), format!("`{name}` is given twice"), None),
            None => {
                let help = suggestion(name, LOOPS.iter().map(|(known, _)| *known));
                table.mistake_at(span.clone(), format!("unknown loops `{name}`"), Some(help));
            }
        }
    }
    if given.is_empty() {
        table.mistake("loops", "`loops` is an empty list", None);
    }
    (!all.is_empty() && all.len() == given.len()).then_some(all)
}

/// Label of the segment in which the trackers take the target up.
pub(super) const ACQUIRE: &str = "acquire";
/// Label of the one in which the target begins to move.
pub(super) const SETTLE: &str = "settle";
/// Label of the one that is evaluated.
pub(super) const TRACK: &str = "track";

/// From the middle of the course to where the target stands: slower than the bounds of the point.
const APPROACH: ProfileLimits =
    ProfileLimits { velocity_rad_per_s: 0.1, acceleration_rad_per_s2: 0.2, jerk_rad_per_s3: 2.0 };
/// The trackers must have had their target for so long.
const LOCKED_S: f64 = 0.5;
/// Longest wait for that.
const ACQUIRE_S: f64 = 8.0;
/// Power-up, and the rest that ends the approach.
const POWER_UP_S: f64 = 4.0;
/// What the bounds leave beyond half of the span: 3 deg.
const BOUND_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Ten times the rate of the rail target (0.674 deg/s), and half as much again as the approach.
const BOUND_RAD_PER_S: f64 = 0.15;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let Gimbal { outer, inner } = gimbal_for("track", axes)?;
    if axis != outer.name {
        let message = format!("`track` needs `axis = \"{}\"`, found `{axis}`", outer.name);
        return Err(vec![
            Diagnostic::new(message).help("write that axis: both axes follow the target in every point"),
        ]);
    }
    let places = keys.span_rad.iter().filter_map(|&at| outside("azimuth", at, &outer.name, &outer.limits));
    let heights =
        keys.elevations_rad.iter().filter_map(|&at| outside("elevation", at, &inner.name, &inner.limits));
    let mistakes: Vec<Diagnostic> = places.chain(heights).collect();
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let each = |elevation: f64| keys.loops.iter().map(move |&loops| case(keys, loops, elevation, axis, axes));
    Ok(keys.elevations_rad.iter().flat_map(|&elevation| each(elevation)).collect())
}

/// A point. The outer axis is moved to the target; the inner one follows it, too.
fn case(keys: &Keys, loops: Loops, elevation_rad: f64, axis: &str, axes: &Axes) -> Case {
    let [low, high] = keys.span_rad;
    let middle_rad = 0.5 * (low + high);
    let approach = approach(middle_rad, keys.azimuth_rad);
    let stands_s = POWER_UP_S + approach.at_most_s;
    let mut segments = vec![approach];
    segments.extend(tracked(keys, loops));
    let elevation = Q::Angle.format(elevation_rad);
    Case {
        point: format!("{}, {}, elevation={elevation}", keys.target.word(), loops.name()),
        axis: axis.to_owned(),
        requested: vec![request(ELEVATION, elevation_rad, Q::Angle)],
        start_pose_rad: poses(axes, [middle_rad, elevation_rad]),
        segments,
        bounds: Some(Bounds {
            displacement_rad: 0.5 * (high - low) + BOUND_RAD,
            speed_rad_per_s: BOUND_RAD_PER_S,
        }),
        target: Some(Target { course: keys.target, azimuth_rad: keys.azimuth_rad, elevation_rad, stands_s }),
        // Frames come up to 200 times a second: each must be seen.
        logs_payload_fully: true,
        ..Case::default()
    }
}

fn approach(from_rad: f64, target_rad: f64) -> Segment {
    let stimulus = Stimulus::Move { target_rad, limits: APPROACH };
    let at_most_s = stimulus.duration_s(from_rad).unwrap_or(0.0) + 0.5;
    Segment { stimulus, then: Then::Hold, ..Segment::hold("approach", Mode::Position, at_most_s) }
}

/// Acquisition, the time in which the target sets off, and the record.
fn tracked(keys: &Keys, loops: Loops) -> [Segment; 3] {
    let mode = if loops.coarse() { Mode::Track } else { Mode::Position };
    let off_load = keys.off_load && loops == Loops::Both;
    let tracks = Some(Tracks { others: loops.coarse(), fine: loops.fine(), off_load });
    let segment = |label: &str, at_most_s| Segment { tracks, ..Segment::hold(label, mode, at_most_s) };
    let until = Some(Condition::Locked { for_s: LOCKED_S });
    [
        Segment { until, ..segment(ACQUIRE, ACQUIRE_S) },
        segment(SETTLE, keys.settle_s),
        Segment { then: Then::Stop, ..segment(TRACK, keys.duration_s) },
    ]
}

/// The loops of a planned point.
pub(super) fn loops_of(case: &Case) -> Loops {
    let track = case.segments.iter().find(|s| s.label == TRACK);
    match track.map(|s| (s.mode == Mode::Track, s.is_fine())) {
        Some((true, true)) => Loops::Both,
        Some((false, _)) => Loops::Fine,
        _ => Loops::Coarse,
    }
}
