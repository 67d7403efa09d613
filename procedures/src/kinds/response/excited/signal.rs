//! Signals of the realisations, and which lines each of them has when.

use analysis::excitation::{ExcitationError, Grid, Kind, Multisine, Offset, Phases, Selection, Spacing};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::course::Course;
use super::keys::{Excited, Form};
use crate::axis::AxisLimits;
use crate::diagnostic::Diagnostic;
use crate::excitation::{Excitation, Signal, Step};
use crate::quantity::QuantityKind as Q;

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
        Form::Multisine { grid, compressed } => {
            multisine(keys, limits, course, (realisation, grid, compressed), peak, uniform)
                .map_err(refused)?
        }
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

/// Lines of every other realisation lie between those of the one before; odd ones are the same in all, or products of odd
/// order would fall between the lines, and none would show what they do.
fn multisine(
    keys: &Excited,
    limits: &AxisLimits,
    course: &Course,
    (realisation, kind, compressed): (u32, Kind, bool),
    peak: f64,
    uniform: &mut dyn FnMut() -> f64,
) -> Result<Signal, ExcitationError> {
    let offset =
        if realisation.is_multiple_of(2) || kind != Kind::Full { Offset::Zero } else { Offset::Half };
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
        return Err(Diagnostic::new(message).help("ask for fewer `lines`, or a longer `duration`"));
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
