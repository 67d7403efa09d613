//! A point that ran: plateaus of every stroke become effort over angle on the same whole cogging periods.

use std::f64::consts::TAU;
use std::ops::Range;

use analysis::angle_map::{Grid, bin_means, period_means};
use analysis::cogging::Branch;
use analysis::derivative::Differentiator;
use analysis::friction::half_difference;
use analysis::gravity::HalfSum;
use analysis::plateau::{longest_steady, mean_velocity_rad_per_s};

use super::cogging;
use super::plan::STROKES;
use super::point::Finding;
use super::record::Record;
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::Exclusion;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Profile, Stimulus};

/// α is flat to 1 % up to this multiple of the cogging frequency: wider only lets in noise of the encoder.
const FLAT_HARMONICS: f64 = 5.0;
/// And within these bounds, Hz: below, its window would reach from the plateau into the ramps; above, the noise of the
/// encoder's quantum, differentiated twice, would rule.
const FLAT_HZ: [f64; 2] = [5.0, 25.0];
/// What is left out at both ends of a plateau at least.
const SETTLE_S: f64 = 0.25;
/// The same in cogging periods.
const SETTLE_PERIODS: f64 = 0.5;
/// Achieved velocity against the one asked for.
const STEADY_RATIO: f64 = 0.05;
/// Shortest window over which the achieved velocity is a mean.
const VELOCITY_WINDOW_S: f64 = 0.02;

/// Strokes of the point.
struct Strokes {
    rows: Range<usize>,
    sample_rate_hz: f64,
    period_rad: f64,
    velocity_rad_per_s: f64,
    /// Steady rows of each stroke, with its direction.
    steady: Vec<(bool, Range<usize>)>,
    /// Strokes without a steady stretch of one period.
    unsteady: usize,
}

/// Everything that the strokes say.
pub(super) fn find(case: &Case, window: &Window, record: &Record<'_>, limits: &AxisLimits) -> Finding {
    let mut finding = Finding::default();
    match strokes(case, window, record, limits) {
        Ok(strokes) => {
            finding.evidence = record.evidence(&strokes.rows);
            finding.quantum_u = record.quantum_u(strokes.rows.clone());
            if let Err(reason) = evaluate(&strokes, record, limits, &mut finding) {
                finding.trouble = Some(reason);
            }
        }
        Err(reason) => finding.trouble = Some(reason),
    }
    finding
}

fn strokes(
    case: &Case,
    window: &Window,
    record: &Record<'_>,
    limits: &AxisLimits,
) -> Result<Strokes, String> {
    let velocity_rad_per_s = case.requested("velocity").ok_or("the point names no velocity")?;
    let span = window
        .segments
        .iter()
        .find(|s| case.segments.get(s.segment).is_some_and(|c| c.label == STROKES))
        .ok_or("the strokes did not run")?;
    let rows = record.range(span.start_s, span.end_s);
    let sample_rate_hz =
        record.sample_rate_hz(&rows).ok_or("rows are missing in the strokes, or time does not advance")?;
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let settle_s = SETTLE_S.max(SETTLE_PERIODS * period_rad / velocity_rad_per_s);
    let (mut steady, mut unsteady) = (Vec::new(), 0);
    for (reverse, start_s, end_s) in plateaus(&case.segments[span.segment].stimulus) {
        let plateau = record.range(span.start_s + start_s + settle_s, span.start_s + end_s - SETTLE_S / 2.0);
        let plateau = plateau.start..plateau.end.min(rows.end).max(plateau.start);
        let angle = &record.angle_rad[plateau.clone()];
        let target = if reverse { -velocity_rad_per_s } else { velocity_rad_per_s };
        let quarter_s = (period_rad / velocity_rad_per_s / 4.0).max(VELOCITY_WINDOW_S);
        let window_count = (quarter_s * sample_rate_hz).round() as usize;
        let stretch = longest_steady(angle, sample_rate_hz, target, window_count, STEADY_RATIO);
        let covered = angle.get(stretch.clone()).map_or(0.0, |a| match a {
            [first, .., last] => (last - first).abs(),
            _ => 0.0,
        });
        if covered >= period_rad {
            steady.push((reverse, plateau.start + stretch.start..plateau.start + stretch.end));
        } else {
            unsteady += 1;
        }
    }
    Ok(Strokes { rows, sample_rate_hz, period_rad, velocity_rad_per_s, steady, unsteady })
}

/// Direction, start and end of each stroke's cruise, counted from the start of the segment.
fn plateaus(stimulus: &Stimulus) -> Vec<(bool, f64, f64)> {
    let Stimulus::Reversals { from_rad, to_rad, limits, cycles } = stimulus else { return Vec::new() };
    let stroke = Profile::new(to_rad - from_rad, limits);
    let (stroke_s, cruise_s) = (stroke.duration_s(), stroke.cruise_s());
    let ramp_s = (stroke_s - cruise_s) / 2.0;
    (0..2 * cycles)
        .map(|k| {
            let reverse = (k % 2 == 1) != (to_rad < from_rad);
            let start_s = f64::from(k) * stroke_s + ramp_s;
            (reverse, start_s, start_s + cruise_s)
        })
        .collect()
}

/// Maps, friction, half-sum and spectrum of the steady strokes.
fn evaluate(
    strokes: &Strokes,
    record: &Record<'_>,
    limits: &AxisLimits,
    finding: &mut Finding,
) -> Result<(), String> {
    exclude_strokes(strokes, finding);
    let range = |rows: &Range<usize>| {
        let (a, b) = (record.angle_rad[rows.start], record.angle_rad[rows.end - 1]);
        [a.min(b), a.max(b)]
    };
    let both = [false, true].iter().all(|side| strokes.steady.iter().any(|(reverse, _)| reverse == side));
    let ranges: Vec<[f64; 2]> = strokes.steady.iter().map(|(_, rows)| range(rows)).collect();
    let samples = strokes.sample_rate_hz * strokes.period_rad / strokes.velocity_rad_per_s;
    let grid = if both { Grid::common(&ranges, strokes.period_rad, samples) } else { None };
    let Some(grid) = grid else {
        finding.achieved_rad_per_s = Some(peak_velocity(strokes, record));
        return Err(not_steady(strokes, finding.achieved_rad_per_s));
    };
    let cogging_hz = strokes.velocity_rad_per_s / strokes.period_rad;
    let flat_hz = (FLAT_HARMONICS * cogging_hz).clamp(FLAT_HZ[0], FLAT_HZ[1]);
    let differentiator =
        Differentiator::new(strokes.sample_rate_hz, flat_hz.min(strokes.sample_rate_hz / 16.0))
            .ok_or("the log rate is too low for an acceleration")?;
    let maps = maps(strokes, record, limits, &grid, &differentiator)?;
    finding.achieved_rad_per_s = Some(mean_velocity(strokes, record));
    finding.flags.push("sliding".to_owned());
    exclude_samples(strokes, record, &grid, finding);
    conclude(&maps, &grid, finding);
    cogging::of_strokes(&maps, &grid, strokes.velocity_rad_per_s, &differentiator, limits, finding);
    Ok(())
}

/// The same for branches of an imported static map on part of a turn: all rows, nothing to take off.
pub(super) fn evaluate_branches(
    branches: &[Branch],
    limits: &AxisLimits,
    finding: &mut Finding,
) -> Result<(), String> {
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let ends = |b: &Branch| [b.angle_rad[0], b.angle_rad[b.angle_rad.len() - 1]];
    let ranges: Vec<[f64; 2]> = branches.iter().map(ends).collect();
    let per_period = |b: &Branch| b.angle_rad.len() as f64 * period_rad / (ends(b)[1] - ends(b)[0]);
    let samples = branches.iter().map(per_period).fold(f64::INFINITY, f64::min);
    let grid = Grid::common(&ranges, period_rad, samples)
        .ok_or("the branches share no whole cogging period, or have fewer than two points in one")?;
    let mut maps = Maps { forward: Vec::new(), reverse: Vec::new() };
    for branch in branches {
        let map = bin_means(&branch.angle_rad, &branch.value, &grid)
            .ok_or("a branch does not cover the common cogging periods")?;
        if branch.reverse { maps.reverse.push(map) } else { maps.forward.push(map) }
    }
    finding.one_sided = maps.forward.is_empty() || maps.reverse.is_empty();
    conclude(&maps, &grid, finding);
    cogging::of_map(&maps, &grid, limits, finding);
    if finding.one_sided { Err("one direction only: friction needs both".to_owned()) } else { Ok(()) }
}

/// Friction, half-sum and loop of binned maps.
fn conclude(maps: &Maps, grid: &Grid, finding: &mut Finding) {
    finding.flags.push(format!("{} whole cogging periods", grid.periods_count));
    finding.friction = half_difference(&maps.forward, &maps.reverse, grid.bins_per_period_count);
    let (forward, reverse) = (average(&maps.forward), average(&maps.reverse));
    finding.half_sum = half_sum(grid, &forward, &reverse);
    // A direction that was not recorded has no curve.
    let curve = |effort: Vec<f64>| {
        if effort.is_empty() { [Vec::new(), Vec::new()] } else { [grid.centres_rad(), effort] }
    };
    finding.forward = curve(forward);
    finding.reverse = curve(reverse);
}

/// Binned effort of all strokes, by direction.
pub(super) struct Maps {
    pub(super) forward: Vec<Vec<f64>>,
    pub(super) reverse: Vec<Vec<f64>>,
}

fn maps(
    strokes: &Strokes,
    record: &Record<'_>,
    limits: &AxisLimits,
    grid: &Grid,
    differentiator: &Differentiator,
) -> Result<Maps, String> {
    let all = strokes.rows.clone();
    let mut effort = record.motor(all.clone());
    if record.kind == Q::Torque {
        let acceleration = differentiator
            .acceleration(&record.angle_rad[all.clone()])
            .ok_or("the strokes are shorter than the differentiator's window")?;
        effort.iter_mut().zip(acceleration).for_each(|(e, a)| *e -= limits.inertia_kg_m2 * a);
    }
    let mut maps = Maps { forward: Vec::new(), reverse: Vec::new() };
    for (reverse, rows) in &strokes.steady {
        let effort = &effort[rows.start - all.start..rows.end - all.start];
        let map = bin_means(&record.angle_rad[rows.clone()], effort, grid)
            .ok_or("a stroke does not cover the common cogging periods")?;
        if *reverse { maps.reverse.push(map) } else { maps.forward.push(map) }
    }
    Ok(maps)
}

fn average(maps: &[Vec<f64>]) -> Vec<f64> {
    let count = maps.len() as f64;
    let bins = maps.first().map_or(0, Vec::len);
    (0..bins).map(|k| maps.iter().map(|m| m[k]).sum::<f64>() / count).collect()
}

/// Half the sum of both directions, one value a cogging period, with the same means of angle and cosine.
fn half_sum(grid: &Grid, forward: &[f64], reverse: &[f64]) -> HalfSum {
    let halves: Vec<f64> = forward.iter().zip(reverse).map(|(f, r)| (f + r) / 2.0).collect();
    let centres = grid.centres_rad();
    // The mean of a cosine over a bin is the cosine of its middle times this.
    let half = grid.width_rad() / 2.0;
    let cosines: Vec<f64> = centres.iter().map(|a| a.cos() * half.sin() / half).collect();
    let bins = grid.bins_per_period_count;
    HalfSum {
        angle_rad: period_means(&centres, bins),
        cosine_ratio: period_means(&cosines, bins),
        torque_nm: period_means(&halves, bins),
    }
}

/// Mean speed over all steady strokes.
fn mean_velocity(strokes: &Strokes, record: &Record<'_>) -> f64 {
    let speed = |rows: &Range<usize>| {
        mean_velocity_rad_per_s(&record.angle_rad[rows.clone()], strokes.sample_rate_hz).abs()
    };
    strokes.steady.iter().map(|(_, rows)| speed(rows)).sum::<f64>() / strokes.steady.len() as f64
}

/// Largest mean speed over a short window: what was reached where nothing was steady.
fn peak_velocity(strokes: &Strokes, record: &Record<'_>) -> f64 {
    let window = (4.0 * VELOCITY_WINDOW_S * strokes.sample_rate_hz).round().max(1.0) as usize;
    let angle = &record.angle_rad[strokes.rows.clone()];
    let way = angle.windows(window + 1).map(|w| (w[window] - w[0]).abs()).fold(0.0, f64::max);
    way * strokes.sample_rate_hz / window as f64
}

fn not_steady(strokes: &Strokes, achieved: Option<f64>) -> String {
    let speed = |v: f64| Q::AngularVelocity.format(v);
    format!(
        "the plateau is shorter than one cogging period ({}) within 5 % of {} in both directions; the axis reached {}",
        Q::Angle.format(strokes.period_rad),
        speed(strokes.velocity_rad_per_s),
        speed(achieved.unwrap_or(0.0)),
    )
}

fn exclude_strokes(strokes: &Strokes, finding: &mut Finding) {
    if strokes.unsteady > 0 {
        finding.excluded.push(Exclusion {
            count: strokes.unsteady,
            of: "strokes".to_owned(),
            reason: "no cogging period within 5 % of the velocity asked for".to_owned(),
        });
    }
}

fn exclude_samples(strokes: &Strokes, record: &Record<'_>, grid: &Grid, finding: &mut Finding) {
    let inside = grid.edge_rad(0)..grid.edge_rad(grid.bins_count());
    let used: usize = strokes
        .steady
        .iter()
        .map(|(_, rows)| record.angle_rad[rows.clone()].iter().filter(|a| inside.contains(a)).count())
        .sum();
    finding.excluded.push(Exclusion {
        count: strokes.rows.len() - used.min(strokes.rows.len()),
        of: "samples".to_owned(),
        reason: "turn-rounds, settling and broken periods: outside the whole cogging periods of the plateaus"
            .to_owned(),
    });
}
