//! What a procedure says, and the points: one axis alone; or both at once, and both stopping together.

use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Companion, Mode, Request, Segment, Then};
use crate::condition::MOVING_AXES;
use crate::device::MIRROR_AXES;
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Profile, ProfileLimits, Stimulus};
use crate::table::{Field, Shape, TableReader};

/// Keys of `[slew]`: outer and inner axis.
const AXIS_KEYS: [&str; 2] = ["azimuth", "elevation"];
/// What files called them in older versions, and procedures in their logs still do.
const OLD_KEYS: [&str; 2] = MIRROR_AXES;

const SLEW: &[Field] = &[
    Field::optional(
        AXIS_KEYS[0],
        Shape::Range(Q::Angle),
        "Start and end of the slew of the carrying axis, or of the only axis of a rig.",
    ),
    Field::optional(AXIS_KEYS[1], Shape::Range(Q::Angle), "Start and end of the slew of the carried axis."),
    Field::optional(OLD_KEYS[0], Shape::Range(Q::Angle), "Older name of the key for the carrying axis."),
    Field::optional(OLD_KEYS[1], Shape::Range(Q::Angle), "Older name of the key for the carried axis."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "slew",
        Shape::Table(SLEW),
        "Ends of the slews: of one axis alone, or of both at once; the procedure's own axis must be among them.",
    ),
    Field::default("rate", Shape::Quantity(Q::AngularVelocity), "60 deg/s", "Rate of the slews."),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "80 deg/s^2",
        "Their acceleration; the cycle's requirement names none (E17, E22), and the largest possible one \
         needs all of the torque.",
    ),
    Field::default("track", Shape::Quantity(Q::Time), "6 s", "Tracking time between two slews."),
    Field::default(
        "track-rate",
        Shape::Quantity(Q::AngularVelocity),
        "0.674 deg/s",
        "Rate while tracking, out and back; the axis rests for less than 0.001 deg/s.",
    ),
    Field::default("cycles", Shape::Integer, "10", "Number of cycles without a pause."),
    Field::default(
        "continuous-current-az",
        Shape::Quantity(Q::Current),
        "14.2 A",
        "Continuous current of azimuth.",
    ),
    Field::default(
        "continuous-current-el",
        Shape::Quantity(Q::Current),
        "16.8 A",
        "Continuous current of elevation.",
    ),
    Field::default(
        "longest-heat-sink-time",
        Shape::Quantity(Q::Time),
        "30 min",
        "Upper bound of the time constant of a heat sink.",
    ),
    Field::default(
        "current-uncertainty",
        Shape::Quantity(Q::Ratio),
        "0.5 %",
        "Standard uncertainty of the scale of the currents of drives and clamps.",
    ),
    Field::default(
        "voltage-uncertainty",
        Shape::Quantity(Q::Voltage),
        "1 V",
        "Standard uncertainty of the voltage of the DC link.",
    ),
    Field::default(
        "temperature-uncertainty",
        Shape::Quantity(Q::Temperature),
        "1 degC",
        "Standard uncertainty of the sensors of the heat sinks.",
    ),
];

/// Slower than this there is nothing to track.
const REST_RAD_PER_S: f64 = 0.001 * std::f64::consts::PI / 180.0;

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    /// Azimuth, elevation; `None` where the axis rests.
    pub(super) slew_rad: [Option<[f64; 2]>; 2],
    pub(super) rate_rad_per_s: f64,
    pub(super) acceleration_rad_per_s2: f64,
    pub(super) track_s: f64,
    /// `None` for rest.
    pub(super) track_rad_per_s: Option<f64>,
    pub(super) cycles: u32,
    pub(super) continuous_a: [f64; 2],
    pub(super) longest_s: f64,
    pub(super) current_u_ratio: f64,
    pub(super) voltage_u_v: f64,
    pub(super) temperature_u_degc: f64,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let slew_rad = table.table("slew", |t| {
            let mut span = |index: usize| {
                let written = [AXIS_KEYS[index], OLD_KEYS[index]].into_iter().find(|key| t.has(key));
                written.map_or(Some(None), |key| t.range(key).map(Some))
            };
            Some([span(0)?, span(1)?])
        });
        if slew_rad == Some([None, None]) {
            let help = "name the axes that slew, e.g. `azimuth = \"-90 deg .. 90 deg\"`".to_owned();
            table.mistake("slew", "no axis slews", Some(help));
        }
        let slew_rate = table.positive("rate");
        let acceleration = table.positive("acceleration");
        let track_s = table.positive("track");
        let rate = table.quantity("track-rate");
        let cycles = table.count("cycles", 1);
        let continuous = [table.positive("continuous-current-az"), table.positive("continuous-current-el")];
        let longest_s = table.positive("longest-heat-sink-time");
        let current_u = table.positive("current-uncertainty");
        let voltage_u = table.positive("voltage-uncertainty");
        let temperature_u = table.positive("temperature-uncertainty");
        table.check_steps("cycles", &[cycles? as usize, 4]);
        Some(Self {
            slew_rad: slew_rad.filter(|slew| *slew != [None, None])?,
            rate_rad_per_s: slew_rate?,
            acceleration_rad_per_s2: acceleration?,
            track_s: track_s?,
            track_rad_per_s: Some(rate?.abs()).filter(|rate| *rate >= REST_RAD_PER_S),
            cycles: cycles?,
            continuous_a: [continuous[0]?, continuous[1]?],
            longest_s: longest_s?,
            current_u_ratio: current_u?,
            voltage_u_v: voltage_u?,
            temperature_u_degc: temperature_u?,
        })
    }
}

impl Keys {
    /// Indices of the axes that slew.
    pub(super) fn axes(&self) -> impl Iterator<Item = usize> {
        let slews = self.slew_rad.map(|slew| slew.is_some());
        (0..2).filter(move |&axis| slews[axis])
    }
}

/// The axes that slew, and which of them is the procedure's own.
#[derive(Clone, Copy)]
struct Pair<'a> {
    names: [Option<&'a str>; 2],
    own: usize,
}

/// Names of the axes that `azimuth` and `elevation` stand for: those of the gimbal, or a single axis as azimuth.
pub(super) fn names_of<'a>(axis: &'a str, axes: &'a Axes) -> [Option<&'a str>; 2] {
    match axes.gimbal() {
        Ok(gimbal) if gimbal.index_of(axis).is_some() => gimbal.names().map(Some),
        _ => [Some(axis), None],
    }
}

/// Segments of a cycle: out, track, home, track.
pub(super) const SEGMENTS_PER_CYCLE: usize = 4;
/// Point in which both axes slew as far as each has to.
const BOTH: &str = "both";
/// Point in which both slew equally far.
const TOGETHER: &str = "both together";
/// Tracking turns this gently: no structure is excited by it.
const TRACK_ACCELERATION: f64 = 10.0 * std::f64::consts::PI / 180.0;
const TRACK_JERK: f64 = 100.0 * std::f64::consts::PI / 180.0;
/// Beyond the profile's own duration a segment may last this much longer.
const SPARE_S: f64 = 0.1;

/// The points.
#[allow(clippy::result_large_err, reason = "a plan is refused once, before anything runs")]
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let names = names_of(axis, axes);
    if let Some(index) = keys.axes().find(|&index| names[index].is_none()) {
        let message =
            format!("`[slew]` gives the slew of `{}`, but the rig has no such axis", AXIS_KEYS[index]);
        return Err(vec![Diagnostic::new(message).help(format!("axis `{axis}` is `{}`", AXIS_KEYS[0]))]);
    }
    let own = names.iter().position(|name| *name == Some(axis)).filter(|&own| keys.slew_rad[own].is_some());
    let Some(own) = own else {
        let key =
            names.iter().position(|name| *name == Some(axis)).map_or(AXIS_KEYS[0], |own| AXIS_KEYS[own]);
        let message = format!("`[slew]` does not give the slew of axis `{axis}`");
        let help = format!("add `{key} = \"…\"` to it, or name another `axis`");
        return Err(vec![Diagnostic::new(message).help(help)]);
    };
    let pair = Pair { names, own };
    let point = |name: &str, spans: [Option<[f64; 2]>; 2]| case(keys, name, pair, spans, axes);
    let [az, el] = keys.slew_rad;
    let cases = match (az, el) {
        (Some(az), Some(el)) => vec![
            point(BOTH, [Some(az), Some(el)]),
            point(TOGETHER, [Some(about(az, el[1] - el[0])), Some(el)]),
        ],
        _ => vec![point(axis, keys.slew_rad)],
    };
    let (cases, mistakes): (Vec<_>, Vec<_>) = cases.into_iter().partition(Result::is_ok);
    let mistakes: Vec<Diagnostic> = mistakes.into_iter().filter_map(Result::err).collect();
    if mistakes.is_empty() { Ok(cases.into_iter().flatten().collect()) } else { Err(mistakes) }
}

/// A span of this length about the middle of another.
fn about([low, high]: [f64; 2], length_rad: f64) -> [f64; 2] {
    let middle = 0.5 * (low + high);
    [middle - 0.5 * length_rad, middle + 0.5 * length_rad]
}

#[allow(clippy::result_large_err, reason = "a plan is refused once, before anything runs")]
fn case(
    keys: &Keys,
    point: &str,
    pair: Pair<'_>,
    spans: [Option<[f64; 2]>; 2],
    axes: &Axes,
) -> Result<Case, Diagnostic> {
    let start_pose_rad = axes.pose(|axis| {
        let span =
            pair.names.iter().position(|name| *name == Some(axis.name.as_str())).and_then(|k| spans[k]);
        let [low, high] = axis.limits.soft_limits_rad;
        span.map_or(0.0_f64.max(low).min(high), |span| span[0])
    });
    let mut segments = Vec::new();
    for _ in 0..keys.cycles {
        for (label, end) in [("slew out", 1), ("slew home", 0)] {
            let slew = |index: usize| Some(slew(keys, axes.get(pair.names[index]?)?, spans[index]?, end));
            segments.push(segment(label, pair, slew, spans));
            let track = |index: usize| Some(track(keys, spans[index]?, end));
            segments
                .push(Segment { at_most_s: keys.track_s + SPARE_S, ..segment("track", pair, track, spans) });
        }
    }
    if let Some(last) = segments.last_mut() {
        last.then = Then::Stop;
    }
    if keys.track_rad_per_s.is_some_and(|rate| way_rad(rate, keys.track_s) <= 0.0) {
        let message = "`track` is too short to go out and back at `track-rate`";
        return Err(Diagnostic::new(message).help("use a longer `track` or a lower `track-rate`"));
    }
    let axis = pair.names[pair.own].unwrap_or_default().to_owned();
    // Peaks of the DC link are those of every row.
    let logs_payload_fully = true;
    let moving = spans.iter().flatten().count() as f64;
    Ok(Case {
        point: point.to_owned(),
        axis,
        requested: vec![Request { name: MOVING_AXES.to_owned(), value: moving, kind: Q::Count }],
        start_pose_rad,
        segments,
        logs_payload_fully,
        ..Case::default()
    })
}

/// One segment of all axes, as long as the longest of them.
fn segment(
    label: &str,
    pair: Pair<'_>,
    stimulus: impl Fn(usize) -> Option<Stimulus>,
    spans: [Option<[f64; 2]>; 2],
) -> Segment {
    let own = pair.own;
    let other = 1 - pair.own;
    let along = pair.names[other].zip(stimulus(other));
    let companion = along.map(|(name, stimulus)| Companion { axis: name.to_owned(), stimulus });
    let own_stimulus = stimulus(own).unwrap_or(Stimulus::Hold { torque_nm: 0.0 });
    let from = |stimulus: &Stimulus, index: usize| {
        let [low, high] = spans[index].unwrap_or_default();
        [low, high].into_iter().filter_map(|from| stimulus.duration_s(from)).fold(0.0, f64::max)
    };
    let along_s = companion.as_ref().map_or(0.0, |c| from(&c.stimulus, other));
    let at_most_s = from(&own_stimulus, own).max(along_s) + SPARE_S;
    Segment { stimulus: own_stimulus, companion, ..Segment::hold(label, Mode::Position, at_most_s) }
}

fn slew(keys: &Keys, limits: &AxisLimits, span: [f64; 2], end: usize) -> Stimulus {
    let limits = ProfileLimits {
        velocity_rad_per_s: keys.rate_rad_per_s,
        acceleration_rad_per_s2: keys.acceleration_rad_per_s2,
        jerk_rad_per_s3: limits.max_jerk_rad_per_s3,
    };
    Stimulus::Move { target_rad: span[end], limits }
}

/// Out of the span and back, in the time there is.
fn track(keys: &Keys, span: [f64; 2], end: usize) -> Stimulus {
    let Some(rate) = keys.track_rad_per_s else { return Stimulus::Hold { torque_nm: 0.0 } };
    let outward = if end == 1 { 1.0 } else { -1.0 };
    let from_rad = span[end];
    let way = way_rad(rate, keys.track_s).max(0.0);
    Stimulus::Reversals { from_rad, to_rad: from_rad + outward * way, limits: track_limits(rate), cycles: 1 }
}

fn track_limits(rate: f64) -> ProfileLimits {
    ProfileLimits {
        velocity_rad_per_s: rate,
        acceleration_rad_per_s2: TRACK_ACCELERATION,
        jerk_rad_per_s3: TRACK_JERK,
    }
}

/// Way of a stroke that takes half of the time: `v·(t − t_0)`, where a stroke of way 0 at full rate would take t_0.
fn way_rad(rate: f64, track_s: f64) -> f64 {
    // The time that starting and stopping cost, from a stroke that is long enough to reach the rate.
    let long = Profile::new(rate * 100.0, &track_limits(rate)).duration_s() - 100.0;
    rate * (0.5 * track_s - long)
}
