//! Points: one an elevation and level.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::course::{self, Course};
use super::keys::Excited;
use super::{signal, tracked};
use crate::axis::Axes;
use crate::case::{Bounds, Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::excitation::Injection;
use crate::kinds::position::positioned::{self, Elevation};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};

/// Condition of a point: elevation that was asked for.
pub(in crate::kinds) const ELEVATION: &str = "elevation";
/// Condition of a point: level of the excitation, peak to peak.
pub(in crate::kinds) const LEVEL: &str = "level";
/// Condition of a point where there are several: gains of the velocity loop over the production ones.
pub(in crate::kinds) const GAINS: &str = "gains";
/// Label of segments that can be evaluated.
pub(super) const EXCITED: &str = "excited";
/// Rate between the strokes of two realisations.
const APPROACH_RAD_PER_S: f64 = 0.35;
/// Time at the background rate before a loop is loosened, beside that to speed up.
const RUN_UP_S: f64 = 0.15;
/// Time in which the axis gets used to the excitation again before each stroke of a loosened loop.
const REST_S: f64 = 1.2;
/// Speed, as a multiple of the background, that ends a point whose loop is too loose to hold its plan; and at least.
const LOOSE_SPEED_RATIO: f64 = 4.0;
const LEAST_LOOSE_RAD_PER_S: f64 = 0.45;
/// From there on, time in which the loose loop takes over.
pub(super) const TAKE_OVER_S: f64 = 0.15;

/// The points of an axis.
pub(in crate::kinds) fn plan(keys: &Excited, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    positioned::limits_of(axis, axes)?;
    if keys.background.target_turn_s.is_some() {
        // Nothing follows a target with one axis.
        axes.gimbal().map_err(|lacking| vec![Diagnostic::new(format!("behind a target, {lacking}"))])?;
    }
    let elevation = Elevation::of(axis, axes);
    // Without an elevation there is one point for each level.
    let elevations = if elevation.axis().is_some() { keys.elevations_rad.as_slice() } else { &[0.0] };
    let gains = keys.gain_ratios.iter().map(|ratio| Excited { gain_ratio: Some(*ratio), ..keys.clone() });
    let variants: Vec<Excited> =
        if keys.gain_ratios.len() > 1 { gains.collect() } else { vec![keys.clone()] };
    let mut cases = Vec::new();
    let mut mistakes = Vec::new();
    for (index, &elevation_rad) in elevations.iter().enumerate() {
        let middle = if elevation.is_own() { elevation_rad } else { keys.background.middle_rad };
        let pose = pose(keys, axis, axes, elevation_rad);
        let asked = elevation.axis().map(|_| elevation_rad);
        for (&level_v, keys) in
            keys.levels_v.iter().flat_map(|level| variants.iter().map(move |k| (level, k)))
        {
            // The same signal for all gains: what differs is not it.
            let seed = (index as u64) << 32 | (level_v * 1000.0) as u64;
            match case(keys, axis, axes, middle, level_v, seed) {
                Ok(mut case) => {
                    let several = keys.gain_ratio.filter(|_| variants.len() > 1);
                    case.point = name(asked, level_v, several);
                    case.requested = requests(asked, level_v, several);
                    let mut start = pose.clone();
                    start.extend(first_rad(&case).map(|first| (axis.to_owned(), first)));
                    if keys.background.target_turn_s.is_some() {
                        tracked::bring(&mut case, &start, axes);
                        let first = start.get(axis).copied().unwrap_or(0.0);
                        start.insert(axis.to_owned(), first - tracked::APPROACH_RAD);
                    }
                    case.start_pose_rad = start;
                    cases.push(case);
                }
                Err(mistake) => mistakes.push(mistake),
            }
        }
    }
    if mistakes.is_empty() { Ok(cases) } else { Err(mistakes) }
}

/// Where all axes stand: the moved one in the middle of its strokes, the one that it carries at the elevation of the point,
/// the others near zero.
fn pose(keys: &Excited, axis: &str, axes: &Axes, elevation_rad: f64) -> BTreeMap<String, f64> {
    let elevation = Elevation::of(axis, axes);
    let room = if elevation.is_own() { keys.background.half_width_rad } else { 0.0 };
    axes.pose(|own| {
        let [low, high] = own.limits.soft_limits_rad;
        match elevation.axis() {
            Some(inner) if inner.name == own.name => elevation_rad.max(low + room).min(high - room),
            _ if own.name == axis => keys.background.middle_rad,
            _ => positioned::rest_rad(&own.limits),
        }
    })
}

fn name(elevation_rad: Option<f64>, level_v: f64, gain_ratio: Option<f64>) -> String {
    let elevation =
        elevation_rad.map_or_else(String::new, |rad| format!("elevation={}, ", Q::Angle.format(rad)));
    let gains = gain_ratio.map_or_else(String::new, |ratio| format!(", gains={}", Q::Ratio.format(ratio)));
    format!("{elevation}level={}{gains}", Q::Voltage.format(level_v))
}

fn requests(elevation_rad: Option<f64>, level_v: f64, gain_ratio: Option<f64>) -> Vec<Request> {
    let request = |name: &str, value, kind| Request { name: name.to_owned(), value, kind };
    let elevation = elevation_rad.map(|rad| request(ELEVATION, rad, Q::Angle));
    let gains = gain_ratio.map(|ratio| request(GAINS, ratio, Q::Ratio));
    elevation.into_iter().chain([request(LEVEL, level_v, Q::Voltage)]).chain(gains).collect()
}

/// Where the first stroke begins, where there is one.
fn first_rad(case: &Case) -> Option<f64> {
    let start = |segment: &Segment| match &segment.stimulus {
        Stimulus::Reversals { from_rad, .. } => Some(*from_rad),
        Stimulus::Move { target_rad, .. } => Some(*target_rad),
        _ => None,
    };
    case.segments.iter().find_map(start)
}

fn case(
    keys: &Excited,
    axis: &str,
    axes: &Axes,
    middle_rad: f64,
    level_v: f64,
    seed: u64,
) -> Result<Case, Diagnostic> {
    let limits = axes.get(axis).ok_or_else(|| Diagnostic::new(format!("the rig has no axis `{axis}`")))?;
    let keeps_its_place = Elevation::of(axis, axes).is_own();
    let course = Course::new(keys, limits, middle_rad, level_v)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let peak = course::peak(keys, limits, level_v);
    let mut excitations = Vec::new();
    let mut segments = Vec::new();
    if keys.background.target_turn_s.is_some() {
        segments.extend(tracked::acquire(&course));
    }
    for realisation in 0..keys.realisations {
        excitations.push(signal::excitation(keys, limits, &course, realisation, peak, &mut uniform)?);
        // Elevation stays where it was asked for: the structure changes with it.
        let room_rad = if keeps_its_place { 0.0 } else { course.shift_rad };
        let shift_rad = (2.0 * uniform() - 1.0) * room_rad;
        segments.extend(motion(keys, &course, realisation as usize, shift_rad));
    }
    if let Some(last) = segments.last_mut() {
        last.then = Then::Stop;
    }
    if let Some(turn_s) = keys.background.target_turn_s {
        let (bounds, target) = tracked::behind(keeps_its_place, &course, peak, turn_s);
        let bounds = Some(bounds);
        let target = Some(target);
        return Ok(Case { axis: axis.to_owned(), segments, excitations, bounds, target, ..Case::default() });
    }
    let bounds = keys.gain_ratio.map(|_| Bounds {
        displacement_rad: std::f64::consts::TAU,
        speed_rad_per_s: (LOOSE_SPEED_RATIO * course.velocity_rad_per_s).max(LEAST_LOOSE_RAD_PER_S),
    });
    Ok(Case { axis: axis.to_owned(), segments, excitations, bounds, ..Case::default() })
}

/// Segments of one realisation.
fn motion(keys: &Excited, course: &Course, index: usize, shift_rad: f64) -> Vec<Segment> {
    let excited = |label: &str, mode, stimulus, at_most_s| Segment {
        stimulus,
        excited: Some(index),
        // Windows that repeat exactly would repeat the rounding of the drive, too, and hide it.
        dithered: keys.into == Injection::Torque,
        ..Segment::hold(label, mode, at_most_s)
    };
    let [from_rad, to_rad] = course.ends_rad.map(|end| end + shift_rad);
    if keys.background.target_turn_s.is_some() {
        let lasts_s = keys.duration_s / f64::from(keys.realisations);
        return vec![excited(EXCITED, Mode::Track, Stimulus::Hold { torque_nm: 0.0 }, lasts_s)];
    }
    if course.cycles == 0 {
        return vec![excited(EXCITED, Mode::Position, Stimulus::Hold { torque_nm: 0.0 }, course.stroke_s)];
    }
    let approach = approach(from_rad, course);
    let Some(gain_ratio) = keys.gain_ratio else {
        let strokes = Stimulus::Reversals { from_rad, to_rad, limits: course.limits, cycles: course.cycles };
        let lasts_s = 2.0 * f64::from(course.cycles) * course.stroke_s;
        return vec![approach, excited(EXCITED, Mode::Position, strokes, lasts_s)];
    };
    let mut all = Vec::new();
    let run_up_s = course.velocity_rad_per_s / course.limits.acceleration_rad_per_s2 + RUN_UP_S;
    for stroke in 0..2 * course.cycles {
        let (start_rad, way) = if stroke % 2 == 0 { (from_rad, 1.0) } else { (to_rad, -1.0) };
        let velocity = way * course.velocity_rad_per_s;
        // The excitation goes on meanwhile, so that windows do not see it begin.
        let approach = self::approach(start_rad, course);
        all.push(Segment { excited: Some(index), then: Then::Next, ..approach });
        all.push(excited("rest", Mode::Position, Stimulus::Hold { torque_nm: 0.0 }, REST_S));
        all.push(Segment {
            stimulus: cruise([0.0, velocity], course),
            excited: Some(index),
            ..Segment::hold("run-up", Mode::Velocity, run_up_s)
        });
        let lasts_s = TAKE_OVER_S + f64::from(course.windows) * course.window_s;
        let loose = excited(EXCITED, Mode::Velocity, cruise([velocity; 2], course), lasts_s);
        all.push(Segment { gain_ratio: Some(gain_ratio), then: Then::Hold, ..loose });
    }
    all
}

fn cruise([from_rad_per_s, velocity_rad_per_s]: [f64; 2], course: &Course) -> Stimulus {
    let acceleration_rad_per_s2 = course.limits.acceleration_rad_per_s2;
    Stimulus::Cruise { from_rad_per_s, velocity_rad_per_s, acceleration_rad_per_s2 }
}

/// To where strokes begin. It takes no longer than its way at half of its rate and its ramps.
pub(super) fn approach(target_rad: f64, course: &Course) -> Segment {
    let limits = ProfileLimits { velocity_rad_per_s: APPROACH_RAD_PER_S, ..course.limits };
    let most_rad = (course.ends_rad[1] - course.ends_rad[0]) + 2.0 * course.shift_rad;
    let at_most_s = 2.0 + 2.0 * most_rad / APPROACH_RAD_PER_S;
    Segment {
        stimulus: Stimulus::Move { target_rad, limits },
        then: Then::Hold,
        ..Segment::hold("approach", Mode::Position, at_most_s)
    }
}
