//! Back and forth, by itself or behind a target that sweeps: how far, how fast, which stretches can be evaluated.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::plan::approach;
use super::{Excited, Form, Level};
use crate::axis::{Axes, AxisLimits};
use crate::case::{Bounds, Case, Condition, Mode, Segment};
use crate::diagnostic::Diagnostic;
use crate::excitation::{Injection, Signal, Sine};
use crate::log::{EndedBy, SegmentSpan, Window};
use crate::quantity::QuantityKind as Q;
use crate::reason::ResponseReason;
use crate::stimulus::{Profile, ProfileLimits};
use crate::target::{Target, TargetCourse};

/// Strokes that are fitted into the soft limits keep this far from them: a stop from the peak of an excitation needs it.
const CLEARANCE_RAD: f64 = 0.45 * PI / 180.0;
/// Time in which the velocity loop and the contact forget a turn-round: eight times 1/(2π·3.5 Hz), VEL-BW.
const SETTLE_S: f64 = 0.35;
/// Windows that a plateau may hold, longest first: powers of two, so that lines fall on round frequencies.
const WINDOWS_S: [f64; 6] = [8.0, 4.0, 2.0, 1.0, 0.5, 0.25];
/// The background rate over the largest rate that the excitation can make.
const NO_REVERSAL: f64 = 1.25;
/// A stroke with a loosened loop takes this much longer: approach, rest, run-up.
const LOOSENING_S: f64 = 2.5;
/// Turn-rounds take this long at least.
const RAMP_S: f64 = 0.1;
/// And use this share of the axis' acceleration at the most: the excitation needs torque, too.
const RAMP_SHARE: f64 = 0.4;
/// Cogging orders whose frequencies lines keep away from, and how far.
const COGGING_ORDERS: u32 = 4;
const COGGING_ROOM_HZ: f64 = 0.3;
/// Time in which a track loop forgets a turn-round: its slowest poles are near 1/Tt, 0.5 s (modes.md, 6).
const TRACK_SETTLE_S: f64 = 3.0;
/// Sweeps that are fitted into the soft limits keep this far from them: an axis that tracks is held by bounds.
const TRACK_CLEARANCE_RAD: f64 = 6.0 * PI / 180.0;
/// At rest windows begin after this long.
const REST_S: f64 = 2.0;

/// The motion of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::kinds) struct Course {
    /// Rate on the plateaus; 0 at rest.
    pub(in crate::kinds) velocity_rad_per_s: f64,
    /// Ends of the strokes, before any is shifted.
    pub(in crate::kinds) ends_rad: [f64; 2],
    /// By how much a realisation may be shifted either way.
    pub(in crate::kinds) shift_rad: f64,
    pub(in crate::kinds) limits: ProfileLimits,
    /// One stroke, rest to rest.
    pub(in crate::kinds) stroke_s: f64,
    /// From the start of a stroke to its first window.
    pub(in crate::kinds) first_s: f64,
    pub(in crate::kinds) window_s: f64,
    /// Windows on a plateau (at rest: in a realisation).
    pub(in crate::kinds) windows: u32,
    /// Strokes there and back for each realisation; 0 at rest.
    pub(in crate::kinds) cycles: u32,
}

impl Course {
    /// The motion for a level at an elevation; `pose_rad` is the middle of the strokes.
    pub(in crate::kinds) fn new(
        keys: &Excited,
        limits: &AxisLimits,
        pose_rad: f64,
        level: &Level,
    ) -> Result<Self, Diagnostic> {
        let each_s = keys.duration_s / f64::from(keys.realisations);
        if keys.background.velocity_rad_per_s == 0.0 {
            return Self::at_rest(keys, pose_rad, each_s);
        }
        if let Some(turn_s) = keys.background.target_turn_s {
            return Self::behind_a_target(keys, limits, pose_rad, level, turn_s);
        }
        let velocity =
            keys.background.velocity_rad_per_s.max(NO_REVERSAL * largest_rate(keys, limits, level));
        let profile = profile(velocity, limits);
        let [low, high] = limits.soft_limits_rad;
        let low = low + CLEARANCE_RAD;
        let high = high - CLEARANCE_RAD;
        let half = keys.background.half_width_rad.min((high - low) / 2.0);
        let middle = pose_rad.max(low + half).min(high - half);
        let half = whole_rows(half, &profile, limits.row_rate_hz());
        let stroke = Profile::new(2.0 * half, &profile);
        let stroke_s = stroke.duration_s();
        let cruise_s = stroke.cruise_s();
        let first_s = (stroke_s - cruise_s) / 2.0 + SETTLE_S;
        let usable_s = cruise_s - SETTLE_S;
        let longest_s = longest_window_s(keys);
        let window_s = WINDOWS_S.into_iter().find(|w| *w <= usable_s.min(longest_s * (1.0 + 1e-9)));
        let Some(window_s) = window_s else { return Err(too_short(keys, velocity, level, usable_s)) };
        let loosening_s = if keys.gain_ratio.is_some() { LOOSENING_S } else { 0.0 };
        // Room that a shift of the strokes leaves.
        let shift_rad = (middle - half - low).min(high - middle - half).max(0.0);
        Ok(Self {
            velocity_rad_per_s: velocity,
            ends_rad: [middle - half, middle + half],
            shift_rad,
            limits: profile,
            stroke_s,
            first_s,
            window_s,
            windows: (usable_s / window_s * (1.0 + 1e-9)) as u32,
            cycles: ((each_s / (2.0 * (stroke_s + loosening_s))) as u32).max(1),
        })
    }

    /// The axis follows a target that sweeps about `pose_rad`.
    fn behind_a_target(
        keys: &Excited,
        limits: &AxisLimits,
        pose_rad: f64,
        level: &Level,
        turn_s: f64,
    ) -> Result<Self, Diagnostic> {
        let velocity = keys.background.velocity_rad_per_s;
        let needed = NO_REVERSAL * largest_rate(keys, limits, level);
        if velocity < needed {
            let message = format!(
                "level {} behind a target that moves at {} would reverse the axis: it needs {}",
                level,
                Q::AngularVelocity.format(velocity),
                Q::AngularVelocity.format(needed)
            );
            return Err(Diagnostic::new(message).help("use a lower level, or a faster target"));
        }
        let [low, high] = limits.soft_limits_rad;
        let low = low + TRACK_CLEARANCE_RAD;
        let high = high - TRACK_CLEARANCE_RAD;
        let half = keys.background.half_width_rad.min((high - low) / 2.0);
        let middle = pose_rad.max(low + half).min(high - half);
        let ramp_s = 0.5 * turn_s;
        let stroke_s = 2.0 * half / velocity + ramp_s;
        let usable_s = stroke_s - turn_s - TRACK_SETTLE_S;
        let longest_s = longest_window_s(keys);
        let window_s = WINDOWS_S.into_iter().find(|w| *w <= usable_s.min(longest_s * (1.0 + 1e-9)));
        let Some(window_s) = window_s else { return Err(too_short(keys, velocity, level, usable_s)) };
        Ok(Self {
            velocity_rad_per_s: velocity,
            ends_rad: [middle - half, middle + half],
            shift_rad: 0.0,
            limits: profile(velocity, limits),
            stroke_s,
            first_s: ramp_s + TRACK_SETTLE_S,
            window_s,
            windows: (usable_s / window_s * (1.0 + 1e-9)) as u32,
            cycles: 0,
        })
    }

    fn at_rest(keys: &Excited, pose_rad: f64, each_s: f64) -> Result<Self, Diagnostic> {
        let longest_s = longest_window_s(keys);
        let fits = |w: &f64| *w <= longest_s * (1.0 + 1e-9) && 3.0 * w + REST_S <= each_s;
        let Some(window_s) = WINDOWS_S.into_iter().find(fits) else {
            let message = format!(
                "{} for each realisation are too short for three windows with lines from {}",
                Q::Time.format(each_s),
                Q::Frequency.format(keys.band_hz[0])
            );
            return Err(Diagnostic::new(message).help("use a longer `duration` or a higher `from`"));
        };
        let still =
            ProfileLimits { velocity_rad_per_s: 0.0, acceleration_rad_per_s2: 0.0, jerk_rad_per_s3: 0.0 };
        Ok(Self {
            velocity_rad_per_s: 0.0,
            ends_rad: [pose_rad; 2],
            shift_rad: 0.0,
            limits: still,
            stroke_s: each_s,
            first_s: REST_S,
            window_s,
            windows: ((each_s - REST_S) / window_s * (1.0 + 1e-9)) as u32,
            cycles: 0,
        })
    }

    /// Behind a target: half of a turn-round.
    pub(super) fn ramp_s(&self) -> f64 {
        self.first_s - TRACK_SETTLE_S
    }

    /// Frequencies of cogging at the plateau's rate.
    pub(in crate::kinds) fn cogging_hz(&self, limits: &AxisLimits) -> Vec<f64> {
        let first_hz = limits.cogging_orders_per_rev * self.velocity_rad_per_s / TAU;
        let moves = self.velocity_rad_per_s > 0.0;
        (1..=COGGING_ORDERS).filter(|_| moves).map(|order| f64::from(order) * first_hz).collect()
    }

    /// Bands without lines.
    pub(in crate::kinds) fn forbidden_hz(&self, limits: &AxisLimits) -> Vec<std::ops::RangeInclusive<f64>> {
        self.cogging_hz(limits).into_iter().map(|hz| hz - COGGING_ROOM_HZ..=hz + COGGING_ROOM_HZ).collect()
    }
}

/// Peak of the signal at a level, in the unit of its place.
pub(super) fn peak(keys: &Excited, limits: &AxisLimits, level: &Level) -> f64 {
    let per_v = match keys.into {
        Injection::Torque => limits.torque_constant_nm_per_a.unwrap_or(0.0),
        _ => PI / 180.0,
    };
    0.5 * level.volts_v() * per_v
}

/// A window holds a period of the lowest line, and is not shorter than the shortest.
fn longest_window_s(keys: &Excited) -> f64 {
    keys.window_s.unwrap_or((1.0 / keys.band_hz[0]).max(WINDOWS_S[WINDOWS_S.len() - 1]))
}

/// Largest rate that a signal of this level can make: of a torque what it accelerates the bare inertia to at the lowest
/// line; a loop around it only makes that less.
fn largest_rate(keys: &Excited, limits: &AxisLimits, level: &Level) -> f64 {
    let peak = peak(keys, limits, level);
    match keys.into {
        Injection::Torque => {
            let lowest = Signal::Multisine {
                period_s: 1.0 / keys.band_hz[0],
                lines: vec![Sine { frequency_hz: keys.band_hz[0], amplitude: peak, phase_rad: 0.0 }],
            };
            share(keys) * lowest.peak() / (limits.inertia_kg_m2 * TAU * keys.band_hz[0])
        }
        _ => peak,
    }
}

/// Share of the peak that the lowest line may have: a multisine shares it among its lines, a fifth or less from 25 on; a
/// sweep and a step do not.
fn share(keys: &Excited) -> f64 {
    match keys.form {
        Form::Multisine { .. } => keys.lines.map_or(0.2, |lines| f64::from(lines).powf(-0.5).max(0.2)),
        Form::Sweep | Form::Stepped => 1.0,
    }
}

fn profile(velocity_rad_per_s: f64, limits: &AxisLimits) -> ProfileLimits {
    let acceleration = (velocity_rad_per_s / RAMP_S).min(RAMP_SHARE * limits.max_acceleration_rad_per_s2);
    ProfileLimits {
        velocity_rad_per_s,
        acceleration_rad_per_s2: acceleration,
        jerk_rad_per_s3: (2.0 * acceleration / RAMP_S).min(limits.max_jerk_rad_per_s3),
    }
}

/// The half width a little less, so that a stroke takes a whole number of rows: then all strokes are the same to the row,
/// and what they leave in the record repeats exactly.
fn whole_rows(half_rad: f64, profile: &ProfileLimits, row_rate_hz: f64) -> f64 {
    let rows = Profile::new(2.0 * half_rad, profile).duration_s() * row_rate_hz;
    let over_s = (rows - rows.floor()) / row_rate_hz.max(1.0);
    half_rad - 0.5 * over_s * profile.velocity_rad_per_s
}

fn too_short(keys: &Excited, velocity: f64, level: &Level, usable_s: f64) -> Diagnostic {
    let message = format!(
        "level {} needs a background of {}, at which each stroke of {} lasts {}: less than the shortest window, {}",
        level,
        Q::AngularVelocity.format(velocity),
        Q::Angle.format(2.0 * keys.background.half_width_rad),
        Q::Time.format(usable_s.max(0.0)),
        Q::Time.format(WINDOWS_S[WINDOWS_S.len() - 1]),
    );
    Diagnostic::new(message).help("use a lower level, or a larger `half-width`")
}

/// From here the axis comes to its target.
pub(super) const APPROACH_RAD: f64 = 1.0 * PI / 180.0;
/// Label of the segment in which the tracker takes the target up.
pub(in crate::kinds) const ACQUIRE: &str = "acquire";
/// The tracker must have had its target for so long.
const LOCKED_S: f64 = 0.5;
/// Longest wait for that.
const ACQUIRE_S: f64 = 8.0;
/// Power-up, and the rest that ends the approach.
const POWER_UP_S: f64 = 4.0;
/// What the point's bounds leave beyond the sweep: errors of a turn-round are below half a degree.
const BOUND_RAD: f64 = 2.0 * PI / 180.0;
/// And beyond target rate and excitation.
const BOUND_RATIO: f64 = 1.6;
/// Excitations grow by this near the crossover of the velocity loop.
const RESONANCE: f64 = 1.5;
/// Rates from this share of the planned one on belong to a sweep, not to a turn-round.
const STEADY_SHARE: f64 = 0.8;
/// Mean over which a rate is told from its excitation.
const SMOOTHING_S: f64 = 0.5;
/// A turn-round that is done by hand may begin more gently than planned.
const UNSEEN_RATIO: f64 = 1.25;

/// To the middle of the sweep, then until the target is there.
pub(super) fn acquire(course: &Course) -> [Segment; 2] {
    let middle_rad = 0.5 * (course.ends_rad[0] + course.ends_rad[1]);
    let until = Some(Condition::Locked { for_s: LOCKED_S });
    // From a degree away, whatever the sweep: four seconds are enough.
    let approach = Segment { at_most_s: 4.0, ..approach(middle_rad, course) };
    [approach, Segment { until, ..Segment::hold(ACQUIRE, Mode::Track, ACQUIRE_S) }]
}

/// What holds the axis, and the target, which stands in the middle at first and then sweeps in elevation or in azimuth.
pub(super) fn behind(
    in_elevation: bool,
    course: &Course,
    peak_rad_per_s: f64,
    turn_s: f64,
) -> (Bounds, Target) {
    let [low, high] = course.ends_rad;
    let rate = course.velocity_rad_per_s;
    let bounds = Bounds {
        displacement_rad: 0.5 * (high - low) + APPROACH_RAD + BOUND_RAD,
        speed_rad_per_s: BOUND_RATIO * (rate + RESONANCE * peak_rad_per_s),
    };
    let sweep = TargetCourse::Sweep {
        azimuth_rad_per_s: if in_elevation { 0.0 } else { rate },
        elevation_rad_per_s: if in_elevation { rate } else { 0.0 },
        leg_s: course.stroke_s,
        turn_s,
    };
    (bounds, Target { course: sweep, azimuth_rad: 0.0, elevation_rad: 0.0, stands_s: 0.0 })
}

/// Puts the target of a point where its axes will stand, until they do.
pub(super) fn bring(case: &mut Case, pose: &BTreeMap<String, f64>, axes: &Axes) {
    let Ok(gimbal) = axes.gimbal() else { return };
    let [azimuth_rad, elevation_rad] = gimbal.names().map(|name| pose.get(name).copied().unwrap_or(0.0));
    let approach_s: f64 = case.segments.iter().take(1).map(|s| s.at_most_s).sum();
    if let Some(target) = &mut case.target {
        (target.azimuth_rad, target.elevation_rad) = (azimuth_rad, elevation_rad);
        target.stands_s = POWER_UP_S + approach_s;
    }
}

/// Why a point has no windows, if its target was not found.
pub(super) fn not_found(case: &Case, window: &Window) -> Option<ResponseReason> {
    let timeout = |span: &&SegmentSpan| {
        let segment = case.segments.get(span.segment);
        span.ended_by == EndedBy::Timeout && segment.is_some_and(|s| s.label == ACQUIRE)
    };
    window.segments.iter().find(timeout)?;
    Some(ResponseReason::NeverAcquired)
}

/// Rows at which windows of `length` begin between two rows: where the rate has been that of the sweep for long enough. The
/// target turns round when it likes; the record says when.
pub(super) fn steady(
    rate: &[f64],
    rows: std::ops::Range<usize>,
    length: usize,
    course: &Course,
) -> Vec<usize> {
    let rate_hz = length as f64 / course.window_s;
    let in_rows = |s: f64| (s * rate_hz).round() as usize;
    // Until a turn-round shows in the mean, it has lasted for so long.
    let unseen = in_rows(UNSEEN_RATIO * (1.0 - STEADY_SHARE) * course.ramp_s() + 0.5 * SMOOTHING_S);
    let settle = in_rows(course.first_s - course.ramp_s());
    let mut starts = Vec::new();
    for stretch in fast(rate, rows, STEADY_SHARE * course.velocity_rad_per_s, in_rows(SMOOTHING_S)) {
        let first = stretch.start + unseen + settle;
        let last = stretch.end.saturating_sub(unseen);
        let windows = last.saturating_sub(first) / length;
        starts.extend((0..windows).map(|k| first + k * length));
    }
    starts
}

/// Stretches in which the mean of a rate over so many rows is at least this, either way.
fn fast(rate: &[f64], rows: std::ops::Range<usize>, least: f64, over: usize) -> Vec<std::ops::Range<usize>> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    sums.extend(rate.iter().map(|value| {
        sum += value;
        sum
    }));
    let mean = |row: usize| {
        let from = row.saturating_sub(over / 2);
        let to = (row + over / 2 + 1).min(rate.len());
        (sums[to] - sums[from]) / (to - from).max(1) as f64
    };
    let mut stretches = Vec::new();
    let mut begun = None;
    let end = rows.end.min(rate.len());
    for row in rows.start..end {
        let is_fast = mean(row).abs() >= least;
        match begun {
            None if is_fast => begun = Some(row),
            Some(from) if !is_fast => {
                stretches.push(from..row);
                begun = None;
            }
            _ => {}
        }
    }
    stretches.extend(begun.map(|from| from..end));
    stretches
}
