//! Points: one an elevation and level, with the signals of their realisations and the lines each of these has when.

use std::collections::BTreeMap;

use analysis::excitation::{ExcitationError, Grid, Kind, Multisine, Offset, Phases, Selection, Spacing};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::course::{self, Course};
use super::{Excited, Form, Level};
use crate::axis::{Axes, AxisLimits};
use crate::case::{Bounds, Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::excitation::{Excitation, Injection, Signal, Step};
use crate::kinds::position::positioned::{self, Elevation};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};

/// Condition of a point: elevation that was asked for.
pub(in crate::kinds) const ELEVATION: &str = "elevation";
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
        axes.gimbal()
            .map_err(|lacking| vec![Diagnostic::new(format!("while a target is tracked, {lacking}"))])?;
    }
    let elevation = Elevation::of(axis, axes);
    // Without an elevation there is one point for each level.
    let elevations = if elevation.axis().is_some() { keys.elevations_rad.as_slice() } else { &[0.0] };
    let gains = keys.gain_ratios.iter().map(|ratio| Excited { gain_ratio: Some(*ratio), ..keys.clone() });
    let variants: Vec<Excited> =
        if keys.gain_ratios.len() > 1 { gains.collect() } else { vec![keys.clone()] };
    let mut mistakes = out_of_reach(keys, axis, axes);
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let mut cases = Vec::new();
    for (index, &elevation_rad) in elevations.iter().enumerate() {
        let middle = if elevation.is_own() { elevation_rad } else { keys.background.middle_rad };
        let pose = pose(keys, axis, axes, elevation_rad);
        let asked = elevation.axis().map(|_| elevation_rad);
        for (level, keys) in keys.levels.iter().flat_map(|level| variants.iter().map(move |k| (level, k))) {
            // The same signal for all gains: what differs is not it.
            let seed = (index as u64) << 32 | (level.volts_v() * 1000.0).round() as u64;
            match case(keys, axis, axes, middle, level, seed) {
                Ok(mut case) => {
                    let several = keys.gain_ratio.filter(|_| variants.len() > 1);
                    case.point = name(asked, level, several);
                    case.requested = requests(asked, level, several);
                    let mut start = pose.clone();
                    start.extend(first_rad(&case).map(|first| (axis.to_owned(), first)));
                    if keys.background.target_turn_s.is_some() {
                        course::bring(&mut case, &start, axes);
                        let first = start.get(axis).copied().unwrap_or(0.0);
                        start.insert(axis.to_owned(), first - course::APPROACH_RAD);
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

/// Places that the travel does not have. Elevations at its ends are moved inside the soft limits, see [`moved`].
fn out_of_reach(keys: &Excited, axis: &str, axes: &Axes) -> Vec<Diagnostic> {
    let Some(limits) = axes.get(axis) else { return Vec::new() };
    let mut all = Vec::new();
    let elevation = Elevation::of(axis, axes);
    for &asked_rad in &keys.elevations_rad {
        all.extend(elevation.axis().and_then(|own| positioned::beyond_travel("elevation", asked_rad, own)));
    }
    if !elevation.is_own() {
        all.extend(positioned::outside("middle", keys.background.middle_rad, axis, limits));
    }
    let [low, high] = limits.soft_limits_rad;
    if keys.background.velocity_rad_per_s > 0.0 && 2.0 * keys.background.half_width_rad > high - low {
        let [half, low, high] = [keys.background.half_width_rad, low, high].map(|rad| Q::Angle.format(rad));
        let message = format!(
            "half-width {half} is more than half of what axis `{axis}` has between its soft limits {low} .. {high}"
        );
        all.push(Diagnostic::new(message).help("ask for less; strokes go to both sides of their middle"));
    }
    all
}

/// Elevations that are moved inside the soft limits, a sentence each.
pub(in crate::kinds) fn moved(keys: &Excited, axis: &str, axes: &Axes) -> Vec<String> {
    let Some(inner) = Elevation::of(axis, axes).axis() else { return Vec::new() };
    let at =
        |asked_rad: f64| pose(keys, axis, axes, asked_rad).get(&inner.name).copied().unwrap_or(asked_rad);
    let moved = keys.elevations_rad.iter().map(|&asked_rad| [asked_rad, at(asked_rad)]);
    moved
        .filter(|[asked_rad, at_rad]| (asked_rad - at_rad).abs() > 1e-6)
        .map(|both| {
            let [asked, at] = both.map(|rad| Q::Angle.format(rad));
            format!("elevation {asked} is measured at {at}, inside the soft limits")
        })
        .collect()
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

fn name(elevation_rad: Option<f64>, level: &Level, gain_ratio: Option<f64>) -> String {
    let elevation =
        elevation_rad.map_or_else(String::new, |rad| format!("elevation={}, ", Q::Angle.format(rad)));
    let gains = gain_ratio.map_or_else(String::new, |ratio| format!(", gains={}", Q::Ratio.format(ratio)));
    format!("{elevation}level={level}{gains}")
}

fn requests(elevation_rad: Option<f64>, level: &Level, gain_ratio: Option<f64>) -> Vec<Request> {
    let request = |name: &str, value, kind| Request { name: name.to_owned(), value, kind };
    let elevation = elevation_rad.map(|rad| request(ELEVATION, rad, Q::Angle));
    let gains = gain_ratio.map(|ratio| request(GAINS, ratio, Q::Ratio));
    elevation.into_iter().chain([level.request()]).chain(gains).collect()
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
    level: &Level,
    seed: u64,
) -> Result<Case, Diagnostic> {
    let limits = axes.get(axis).ok_or_else(|| Diagnostic::new(format!("the rig has no axis `{axis}`")))?;
    let keeps_its_place = Elevation::of(axis, axes).is_own();
    let course = Course::new(keys, limits, middle_rad, level)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let peak = course::peak(keys, limits, level);
    let mut excitations = Vec::new();
    let mut segments = Vec::new();
    if keys.background.target_turn_s.is_some() {
        segments.extend(course::acquire(&course));
    }
    for realisation in 0..keys.realisations {
        excitations.push(excitation(keys, limits, &course, realisation, peak, &mut uniform)?);
        // Elevation stays where it was asked for: the structure changes with it.
        let room_rad = if keeps_its_place { 0.0 } else { course.shift_rad };
        let shift_rad = (2.0 * uniform() - 1.0) * room_rad;
        segments.extend(motion(keys, &course, realisation as usize, shift_rad));
    }
    if let Some(last) = segments.last_mut() {
        last.then = Then::Stop;
    }
    if let Some(turn_s) = keys.background.target_turn_s {
        let (bounds, target) = course::behind(keeps_its_place, &course, peak, turn_s);
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

/// Time in which a signal grows to its full size.
const FADE_S: f64 = 0.5;
/// Windows that each of the steps gets at rest, the first of which is not used.
const WINDOWS_A_STEP: f64 = 3.0;
/// Seed of which odd lines are left out.
const THINNING: u64 = 4;
/// Steps that are asked for where `lines` does not say.
const USUAL_STEPS: u32 = 24;

/// The excitation of a realisation; `peak` is its largest value in the unit of its place.
pub(super) fn excitation(
    keys: &Excited,
    limits: &AxisLimits,
    course: &Course,
    realisation: u32,
    peak: f64,
    uniform: &mut dyn FnMut() -> f64,
) -> Result<Excitation, Diagnostic> {
    let [from_hz, to_hz] = keys.band_hz;
    let signal = match keys.form {
        Form::Multisine { grid, compressed } => multisine(
            keys,
            limits,
            course,
            &Realisation { number: realisation, kind: grid, compressed },
            peak,
            uniform,
        )
        .map_err(refused)?,
        Form::Sweep => {
            Signal::Sweep { from_hz, to_hz, duration_s: course.window_s, logarithmic: true, amplitude: peak }
        }
        Form::Stepped => Signal::Stepped { steps: steps(keys, limits, course, realisation, peak)? },
    };
    Ok(Excitation { into: keys.into, signal, fade_s: FADE_S, every_ticks: 1 })
}

fn refused(error: ExcitationError) -> Diagnostic {
    Diagnostic::new(error.to_string())
}

/// A multisine among the realisations of a point.
struct Realisation {
    number: u32,
    kind: Kind,
    compressed: bool,
}

/// Lines of every other realisation lie between those of the one before; odd ones are the same in all, or products of odd
/// order would fall between the lines, and none would show what they do.
fn multisine(
    keys: &Excited,
    limits: &AxisLimits,
    course: &Course,
    &Realisation { number, kind, compressed }: &Realisation,
    peak: f64,
    uniform: &mut dyn FnMut() -> f64,
) -> Result<Signal, ExcitationError> {
    let offset = if number.is_multiple_of(2) || kind != Kind::Full { Offset::Zero } else { Offset::Half };
    // Less than a period in a window cannot be told from its slope.
    let lowest_hz = keys.band_hz[0].max(1.0 / course.window_s);
    let wanted = Selection {
        band_hz: lowest_hz..=keys.band_hz[1],
        kind,
        spacing: keys.lines.map_or(Spacing::Every, |count| Spacing::Logarithmic(count as usize)),
        forbidden_hz: course.forbidden_hz(limits),
    };
    // Every realisation leaves out the same lines, or none would share theirs.
    let mut thinning = ChaCha8Rng::seed_from_u64(THINNING);
    let mut thin = || f64::from(thinning.next_u32()) / 4_294_967_296.0;
    let grid = Grid::new(course.window_s, offset, limits.row_rate_hz(), &wanted, &mut thin)?;
    let phases = if compressed { Phases::Compressed } else { Phases::Random(uniform) };
    let multisine = Multisine::new(&grid, &|_| 1.0, phases)?.scaled_to(2.0 * peak)?;
    Ok(Signal::Multisine { period_s: multisine.period_s, lines: multisine.lines })
}

/// This realisation's part of all steps: each lasts one cycle, so that it has plateaus both ways.
fn steps(
    keys: &Excited,
    limits: &AxisLimits,
    course: &Course,
    realisation: u32,
    amplitude: f64,
) -> Result<Vec<Step>, Diagnostic> {
    let (for_s, fit) = if course.cycles == 0 {
        let for_s = WINDOWS_A_STEP * course.window_s;
        (for_s, (course.stroke_s / for_s) as u32)
    } else {
        (2.0 * course.stroke_s, course.cycles)
    };
    let wanted = keys.lines.unwrap_or(USUAL_STEPS);
    if fit * keys.realisations < wanted {
        let message = format!(
            "{wanted} steps of {} each do not fit: {} do",
            Q::Time.format(for_s),
            fit * keys.realisations
        );
        return Err(Diagnostic::new(message).help("use fewer `lines`, or a longer `duration`"));
    }
    let [from_hz, to_hz] = keys.band_hz;
    let forbidden = course.forbidden_hz(limits);
    let frequency = |k: u32| from_hz * (to_hz / from_hz).powf(f64::from(k) / f64::from(wanted.max(2) - 1));
    let free = |hz: &f64| !forbidden.iter().any(|band| band.contains(hz));
    let share = wanted.div_ceil(keys.realisations);
    let own = (realisation * share..((realisation + 1) * share).min(wanted)).map(frequency).filter(free);
    Ok(own.map(|frequency_hz| Step { frequency_hz, amplitude, for_s }).collect())
}

/// Lines that a signal has all through a window that begins `t_s` after its start; none if it changes meanwhile, or less
/// than `settle_s` before.
pub(super) fn lines_hz(signal: &Signal, t_s: f64, window_s: f64, settle_s: f64) -> Vec<f64> {
    match signal {
        Signal::Multisine { lines, .. } => lines.iter().map(|l| l.frequency_hz).collect(),
        // A sweep that repeats with the window has all harmonics of it, those below its band, too: it jumps back.
        Signal::Sweep { to_hz, .. } => {
            let last = (to_hz * window_s * (1.0 + 1e-12)).floor() as u32;
            (1..=last).map(|k| f64::from(k) / window_s).collect()
        }
        Signal::Stepped { steps } => {
            let mut begin_s = 0.0;
            for step in steps {
                if t_s >= begin_s + settle_s - 1e-9 && t_s + window_s <= begin_s + step.for_s + 1e-9 {
                    return vec![step.frequency_hz];
                }
                begin_s += step.for_s;
            }
            Vec::new()
        }
        Signal::Square { .. } => Vec::new(),
    }
}
