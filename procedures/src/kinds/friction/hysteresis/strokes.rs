//! A point that ran: plateaus of every stroke become effort over angle on the same whole cogging periods.
//!
//! Other kinds run strokes of their own by [`Strokes`] and read by [`Branches`] what each direction shows.

use std::f64::consts::TAU;
use std::ops::Range;

use analysis::angle_map::{Grid, bin_means, period_means};
use analysis::cogging::Branch;
use analysis::derivative::Differentiator;
use analysis::friction::{SlowChange, half_difference};
use analysis::gravity::HalfSum;
use analysis::load_cycle::extremes;
use analysis::plateau::{longest_steady, mean_velocity_rad_per_s};

use super::cogging;
use super::point::{EffortCurve, EvenRecord, Finding, Record};
use super::sweep::{self, Reach, STROKES, Sweep};
use crate::axis::{Axes, AxisLimits, TorqueScale};
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::log::{Rows, SegmentSpan, Window};
use crate::measurement::{Evidence, Exclusion};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};
use crate::stimulus::{Profile, Stimulus};

/// α is flat to 1 % up to this multiple of the cogging frequency: wider only lets in noise of the encoder.
const FLAT_HARMONICS: f64 = 5.0;
/// α is flat to 1 % within these bounds, Hz. Below, the window of the differentiator would reach from the plateau into the
/// ramps; above, the noise of the encoder's quantum, differentiated twice, would rule.
const FLAT_HZ: [f64; 2] = [5.0, 25.0];
/// Missing rows are bridged where a cubic through the rows around them follows this multiple of the cogging frequency: what is
/// faster is small, and is averaged over whole periods.
const BRIDGED_HARMONICS: f64 = 2.0;
/// Time that is left out at both ends of a plateau at least.
const SETTLE_S: f64 = 0.25;
/// Time that is left out at the end of a plateau.
const END_S: f64 = SETTLE_S / 2.0;
/// Cogging periods that are left out at the start of a plateau at least.
const SETTLE_PERIODS: f64 = 0.5;
/// Unbalance and spring use no period that begins earlier than this after the start of a plateau. The loop still swings there. An
/// error of the inertia leaves a part of J·α in the torque, at one end of the span in each direction, and the fit takes that for
/// a load. (With an inertia that is 10 % off: 0.1 N·m in the first period, which moves the unbalance by 0.2 N·m.)
const SETTLE_FOR_GRAVITY_S: f64 = 0.6;
/// Largest departure of the achieved velocity from the one asked for, relative.
const STEADY_RATIO: f64 = 0.05;
/// Shortest window over which the achieved velocity is a mean.
const VELOCITY_WINDOW_S: f64 = 0.02;

/// Strokes that a point ran.
struct Ran<'a> {
    /// Rows of the strokes on an even raster.
    record: Record<'a>,
    rows: Range<usize>,
    sample_rate_hz: f64,
    /// Frequency up to which α is flat, Hz.
    flat_hz: f64,
    /// Longest time without a row, where rows are missing.
    bridged_s: Option<f64>,
    period_rad: f64,
    velocity_rad_per_s: f64,
    /// Mean rate at which the heat sink warmed up or cooled down, a magnitude; 0 where the log does not hold it.
    kelvin_per_s: f64,
    steady: Vec<SteadyStroke>,
    /// Strokes without a steady stretch of one cogging period.
    unsteady_count: usize,
}

/// Steady rows of one stroke.
struct SteadyStroke {
    reverse: bool,
    rows: Range<usize>,
    /// Where the axis was when the loop had settled for unbalance and spring.
    settled_rad: f64,
}

/// Everything that the strokes say.
pub(super) fn find(case: &Case, window: &Window, record: &Record<'_>, limits: &AxisLimits) -> Finding {
    let mut finding = Finding::default();
    match ran(case, window, record, limits) {
        Ok(ran) => {
            finding.evidence = ran.record.evidence(&ran.rows);
            finding.quantum_u = ran.record.quantum_u(ran.rows.clone());
            finding.trouble = evaluate(&ran, limits, &mut finding).err();
            finding.kelvin_per_rad =
                finding.achieved_rad_per_s.map_or(0.0, |rad_per_s| ran.kelvin_per_s / rad_per_s.abs());
        }
        Err(reason) => finding.trouble = Some(reason),
    }
    finding
}

/// See [`Ran::kelvin_per_s`].
fn kelvin_per_s(window: &Window, axis: &str, span: &SegmentSpan) -> f64 {
    let seen = |rows: &Rows| {
        let degc = rows.column("heat_sink_degc")?[rows.range(span.start_s, span.end_s)].iter().copied();
        extremes(&degc.filter(|degc| degc.is_finite()).collect::<Vec<_>>())
    };
    let extremes_degc = window.rows(&format!("/{axis}")).and_then(seen);
    extremes_degc.map_or(0.0, |[low, high]| (high - low) / (span.end_s - span.start_s))
}

fn ran<'a>(
    case: &Case,
    window: &Window,
    record: &Record<'a>,
    limits: &AxisLimits,
) -> Result<Ran<'a>, Reason> {
    let velocity_rad_per_s = case.requested("velocity").ok_or(FrictionReason::NoVelocity)?;
    let span = window
        .segments
        .iter()
        .find(|s| case.segments.get(s.segment).is_some_and(|c| c.label == STROKES))
        .ok_or(FrictionReason::StrokesNotRun)?;
    let rows = record.range(span.start_s, span.end_s);
    let EvenRecord { record, rows } = record.even(rows).ok_or(FrictionReason::RowsMissingInStrokes)?;
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let cogging_hz = velocity_rad_per_s / period_rad;
    let flat_hz = (FLAT_HARMONICS * cogging_hz).clamp(FLAT_HZ[0], FLAT_HZ[1]);
    if rows.unbridged((BRIDGED_HARMONICS * cogging_hz).clamp(FLAT_HZ[0], flat_hz)).is_some() {
        return Err(FrictionReason::RowsMissingInStrokes.into());
    }
    let mut ran = Ran {
        rows: 0..record.angle_rad.len(),
        record,
        sample_rate_hz: 1.0 / rows.sample_s(),
        flat_hz,
        bridged_s: rows.missing().map(|gap| gap.lasted_s),
        period_rad,
        velocity_rad_per_s,
        kelvin_per_s: kelvin_per_s(window, &case.axis, span),
        steady: Vec::new(),
        unsteady_count: 0,
    };
    let settle_s = settle_s(velocity_rad_per_s, period_rad);
    for plateau in plateaus(&case.segments[span.segment].stimulus) {
        let from_s = span.start_s + plateau.start_s + settle_s;
        let to_s = span.start_s + plateau.end_s - END_S;
        let rows = ran.record.range(from_s, to_s);
        match steady_rows(&ran, &ran.record.angle_rad[rows.clone()], plateau.reverse) {
            Some(stretch) => {
                let settled_s = span.start_s + plateau.start_s + SETTLE_FOR_GRAVITY_S;
                let row = ran.record.range(settled_s, f64::INFINITY).start.min(ran.rows.end - 1);
                ran.steady.push(SteadyStroke {
                    reverse: plateau.reverse,
                    rows: rows.start + stretch.start..rows.start + stretch.end,
                    settled_rad: ran.record.angle_rad[row],
                });
            }
            None => ran.unsteady_count += 1,
        }
    }
    Ok(ran)
}

/// Time that is left out at the start of a plateau.
fn settle_s(velocity_rad_per_s: f64, period_rad: f64) -> f64 {
    SETTLE_S.max(SETTLE_PERIODS * period_rad / velocity_rad_per_s)
}

/// Time of a plateau that is left out at both of its ends.
pub(super) fn left_out_s(velocity_rad_per_s: f64, period_rad: f64) -> f64 {
    settle_s(velocity_rad_per_s, period_rad) + END_S
}

/// The steady stretch of a plateau, if it covers a cogging period.
fn steady_rows(ran: &Ran<'_>, angle_rad: &[f64], reverse: bool) -> Option<Range<usize>> {
    let target = if reverse { -ran.velocity_rad_per_s } else { ran.velocity_rad_per_s };
    let quarter_s = (ran.period_rad / ran.velocity_rad_per_s / 4.0).max(VELOCITY_WINDOW_S);
    let window_count = (quarter_s * ran.sample_rate_hz).round() as usize;
    let stretch = longest_steady(angle_rad, ran.sample_rate_hz, target, window_count, STEADY_RATIO);
    let covered_rad = match angle_rad.get(stretch.clone()) {
        Some([first, .., last]) => (last - first).abs(),
        _ => 0.0,
    };
    (covered_rad >= ran.period_rad).then_some(stretch)
}

/// Cruise of one stroke, counted from the start of the segment.
struct Plateau {
    reverse: bool,
    start_s: f64,
    end_s: f64,
}

fn plateaus(stimulus: &Stimulus) -> Vec<Plateau> {
    let Stimulus::Reversals { from_rad, to_rad, limits, cycles } = stimulus else { return Vec::new() };
    let stroke = Profile::new(to_rad - from_rad, limits);
    let stroke_s = stroke.duration_s();
    let cruise_s = stroke.cruise_s();
    let ramp_s = (stroke_s - cruise_s) / 2.0;
    (0..2 * cycles)
        .map(|k| {
            let start_s = f64::from(k) * stroke_s + ramp_s;
            Plateau { reverse: (k % 2 == 1) != (to_rad < from_rad), start_s, end_s: start_s + cruise_s }
        })
        .collect()
}

/// Maps, friction, half-sum and spectrum of the steady strokes.
fn evaluate(ran: &Ran<'_>, limits: &AxisLimits, finding: &mut Finding) -> Result<(), Reason> {
    exclude_strokes(ran, finding);
    let Some(grid) = common_grid(ran) else {
        finding.achieved_rad_per_s = Some(peak_velocity(ran));
        return Err(not_steady(ran, finding.achieved_rad_per_s).into());
    };
    let differentiator = Differentiator::new(ran.sample_rate_hz, ran.flat_hz.min(ran.sample_rate_hz / 16.0))
        .ok_or(FrictionReason::LogTooSlow)?;
    let maps = maps(ran, limits, &grid, &differentiator)?;
    finding.achieved_rad_per_s = Some(mean_velocity(ran));
    finding.flags.push("sliding".to_owned());
    if let Some(gap_s) = ran.bridged_s {
        finding.flags.push(format!("rows missing for up to {:.0} ms, bridged", 1e3 * gap_s));
    }
    exclude_samples(ran, &grid, finding);
    reduce(&maps, &grid, finding);
    let settled = settled_periods(ran, &grid);
    finding.unsettled_counts = [settled.start, grid.periods_count - settled.end];
    cogging::add_of_strokes(&maps, &grid, ran.velocity_rad_per_s, &differentiator, limits, finding);
    if let Some(spectrum) = &finding.spectrum {
        let rates = differentiator.velocity(&ran.record.angle_rad).ok_or(FrictionReason::StrokesTooShort)?;
        match cogging::rates_at(spectrum, &binned(ran, &rates, &grid)?, &grid) {
            Some(lines) => finding.rate_lines_rad_per_s = lines,
            None => finding.spectrum = None,
        }
    }
    Ok(())
}

/// Periods of the grid in which the loop had settled in both directions.
fn settled_periods(ran: &Ran<'_>, grid: &Grid) -> Range<usize> {
    let of = |reverse: bool| ran.steady.iter().filter(move |s| s.reverse == reverse).map(|s| s.settled_rad);
    let low_rad = of(false).fold(f64::NEG_INFINITY, f64::max);
    let high_rad = of(true).fold(f64::INFINITY, f64::min);
    let edge_rad = |period: usize| grid.edge_rad(period * grid.bins_per_period_count);
    let from = (0..grid.periods_count).find(|&k| edge_rad(k) >= low_rad).unwrap_or(grid.periods_count);
    let to = (from..grid.periods_count).rev().find(|&k| edge_rad(k + 1) <= high_rad).map_or(from, |k| k + 1);
    from..to
}

/// Whole cogging periods that all steady strokes share; `None` where one direction has no steady stroke.
fn common_grid(ran: &Ran<'_>) -> Option<Grid> {
    let both = [false, true].iter().all(|side| ran.steady.iter().any(|stroke| stroke.reverse == *side));
    if !both {
        return None;
    }
    let range_rad = |stroke: &SteadyStroke| {
        let first = ran.record.angle_rad[stroke.rows.start];
        let last = ran.record.angle_rad[stroke.rows.end - 1];
        [first.min(last), first.max(last)]
    };
    let ranges_rad: Vec<[f64; 2]> = ran.steady.iter().map(range_rad).collect();
    let samples = ran.sample_rate_hz * ran.period_rad / ran.velocity_rad_per_s;
    Grid::common(&ranges_rad, ran.period_rad, samples)
}

/// Maps, friction, half-sum and spectrum of an imported static map on part of a turn: all rows, nothing to take off.
pub(super) fn evaluate_branches(
    branches: &[Branch],
    limits: &AxisLimits,
    finding: &mut Finding,
) -> Result<(), Reason> {
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let ends = |b: &Branch| [b.angle_rad[0], b.angle_rad[b.angle_rad.len() - 1]];
    let ranges: Vec<[f64; 2]> = branches.iter().map(ends).collect();
    let per_period = |b: &Branch| b.angle_rad.len() as f64 * period_rad / (ends(b)[1] - ends(b)[0]);
    let samples = branches.iter().map(per_period).fold(f64::INFINITY, f64::min);
    let grid = Grid::common(&ranges, period_rad, samples).ok_or(FrictionReason::NoSharedPeriod)?;
    let mut maps = Maps { forward: Vec::new(), reverse: Vec::new() };
    for branch in branches {
        let map =
            bin_means(&branch.angle_rad, &branch.value, &grid).ok_or(FrictionReason::BranchNotCovering)?;
        if branch.reverse { maps.reverse.push(map) } else { maps.forward.push(map) }
    }
    finding.one_sided = maps.forward.is_empty() || maps.reverse.is_empty();
    reduce(&maps, &grid, finding);
    cogging::add_of_map(&maps, &grid, limits, finding);
    if finding.one_sided { Err(FrictionReason::OneDirection.into()) } else { Ok(()) }
}

/// Friction, half-sum and loop of binned maps.
fn reduce(maps: &Maps, grid: &Grid, finding: &mut Finding) {
    finding.flags.push(format!("{} whole cogging periods", grid.periods_count));
    let bins = grid.bins_per_period_count;
    finding.friction = half_difference(&maps.forward, &maps.reverse, bins, SlowChange::OfAxis);
    let forward = average(&maps.forward);
    let reverse = average(&maps.reverse);
    finding.half_sum = half_sum(grid, &forward, &reverse);
    // A direction that was not recorded has no curve.
    let curve = |effort: Vec<f64>| {
        let angle_rad = if effort.is_empty() { Vec::new() } else { grid.centres_rad() };
        EffortCurve { angle_rad, effort }
    };
    finding.forward = curve(forward);
    finding.reverse = curve(reverse);
}

/// Something over the bins of the angle, effort mostly, of all strokes, by direction.
pub(super) struct Maps {
    pub(super) forward: Vec<Vec<f64>>,
    pub(super) reverse: Vec<Vec<f64>>,
}

fn maps(
    ran: &Ran<'_>,
    limits: &AxisLimits,
    grid: &Grid,
    differentiator: &Differentiator,
) -> Result<Maps, Reason> {
    let mut effort = ran.record.motor(ran.rows.clone());
    if ran.record.kind == Q::Torque {
        let acceleration = differentiator
            .acceleration(&ran.record.angle_rad[ran.rows.clone()])
            .ok_or(FrictionReason::StrokesTooShort)?;
        effort.iter_mut().zip(acceleration).for_each(|(e, a)| *e -= limits.inertia_kg_m2 * a);
    }
    binned(ran, &effort, grid)
}

/// Means of one value a row over the bins of the grid, stroke by stroke.
fn binned(ran: &Ran<'_>, values: &[f64], grid: &Grid) -> Result<Maps, Reason> {
    let mut maps = Maps { forward: Vec::new(), reverse: Vec::new() };
    for SteadyStroke { reverse, rows, .. } in &ran.steady {
        let map = bin_means(&ran.record.angle_rad[rows.clone()], &values[rows.clone()], grid)
            .ok_or(FrictionReason::StrokeNotCovering)?;
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
fn mean_velocity(ran: &Ran<'_>) -> f64 {
    let speed = |stroke: &SteadyStroke| {
        mean_velocity_rad_per_s(&ran.record.angle_rad[stroke.rows.clone()], ran.sample_rate_hz).abs()
    };
    ran.steady.iter().map(speed).sum::<f64>() / ran.steady.len() as f64
}

/// Largest mean speed over a short window: what was reached where nothing was steady.
fn peak_velocity(ran: &Ran<'_>) -> f64 {
    let window = (4.0 * VELOCITY_WINDOW_S * ran.sample_rate_hz).round().max(1.0) as usize;
    let angle = &ran.record.angle_rad[ran.rows.clone()];
    let way = angle.windows(window + 1).map(|w| (w[window] - w[0]).abs()).fold(0.0, f64::max);
    way * ran.sample_rate_hz / window as f64
}

fn not_steady(ran: &Ran<'_>, achieved: Option<f64>) -> FrictionReason {
    FrictionReason::NotSteady {
        period_rad: ran.period_rad,
        asked_rad_per_s: ran.velocity_rad_per_s,
        reached_rad_per_s: achieved.unwrap_or(0.0),
    }
}

fn exclude_strokes(ran: &Ran<'_>, finding: &mut Finding) {
    if ran.unsteady_count > 0 {
        finding.excluded.push(Exclusion {
            count: ran.unsteady_count,
            of: "strokes".to_owned(),
            reason: "no cogging period within 5 % of the requested velocity".to_owned(),
        });
    }
}

fn exclude_samples(ran: &Ran<'_>, grid: &Grid, finding: &mut Finding) {
    let inside = grid.edge_rad(0)..grid.edge_rad(grid.bins_count());
    let used: usize = ran
        .steady
        .iter()
        .map(|stroke| ran.record.angle_rad[stroke.rows.clone()].iter().filter(|a| inside.contains(a)).count())
        .sum();
    finding.excluded.push(Exclusion {
        count: ran.rows.len() - used.min(ran.rows.len()),
        of: "samples".to_owned(),
        reason:
            "reversals, settling and incomplete periods: outside the whole cogging periods of the plateaus"
                .to_owned(),
    });
}

/// Strokes at one velocity between two limits, each kind's own keys apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::kinds) struct Strokes {
    pub(in crate::kinds) velocity_rad_per_s: f64,
    pub(in crate::kinds) span_rad: [f64; 2],
    pub(in crate::kinds) cycles: u32,
    /// Acceleration at the turns; `None` for that of the axis.
    pub(in crate::kinds) acceleration_rad_per_s2: Option<f64>,
}

/// Motor torque less inertia over angle, one branch a direction, on the same whole cogging periods.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::kinds) struct Branches {
    /// Middles of the bins, ascending.
    pub(in crate::kinds) angle_rad: Vec<f64>,
    /// Torque of each bin with growing and with falling angle, N·m.
    pub(in crate::kinds) torque_nm: [Vec<f64>; 2],
    pub(in crate::kinds) bins_per_period: usize,
    /// Mean rate of the plateaus, a magnitude.
    pub(in crate::kinds) achieved_rad_per_s: f64,
    /// Standard uncertainty that the drive's quantum leaves in a mean.
    pub(in crate::kinds) quantum_u_nm: f64,
    /// How well the torques are known.
    pub(in crate::kinds) scale: TorqueScale,
    pub(in crate::kinds) flags: Vec<String>,
    pub(in crate::kinds) excluded: Vec<Exclusion>,
    pub(in crate::kinds) evidence: Vec<Evidence>,
}

/// Why strokes show nothing, and how fast the axis was, where that is known.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::kinds) struct NoBranches {
    pub(in crate::kinds) reason: Reason,
    pub(in crate::kinds) achieved_rad_per_s: Option<f64>,
}

impl Strokes {
    /// The one point of the strokes on an axis.
    pub(in crate::kinds) fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        let sweep = Sweep {
            velocities_rad_per_s: vec![self.velocity_rad_per_s],
            reach: Reach::Span(self.span_rad),
            opposite_span_rad: None,
            cycles: self.cycles,
            acceleration_rad_per_s2: self.acceleration_rad_per_s2,
            jerk_rad_per_s3: None,
            other_axis_pose_rad: None,
        };
        sweep::plan(&sweep, axis, axes)
    }
}

impl Branches {
    /// What a point that [`Strokes::plan`] planned shows, or why nothing.
    pub(in crate::kinds) fn read(
        case: &Case,
        window: &Window,
        limits: &AxisLimits,
    ) -> Result<Self, NoBranches> {
        let nothing = |reason: Reason| NoBranches { reason, achieved_rad_per_s: None };
        let record = Record::new(&case.axis, window, limits).map_err(nothing)?;
        if record.kind != Q::Torque {
            return Err(nothing(FrictionReason::InAmpere.into()));
        }
        let found = find(case, window, &record, limits);
        let achieved_rad_per_s = found.achieved_rad_per_s;
        if let Some(reason) = found.trouble {
            return Err(NoBranches { reason, achieved_rad_per_s });
        }
        let angle_rad = found.forward.angle_rad;
        let [first, second, ..] = angle_rad[..] else {
            return Err(nothing(FrictionReason::StrokesShareNone.into()));
        };
        let period_rad = TAU / limits.cogging_orders_per_rev;
        Ok(Self {
            bins_per_period: (period_rad / (second - first)).round() as usize,
            angle_rad,
            torque_nm: [found.forward.effort, found.reverse.effort],
            achieved_rad_per_s: achieved_rad_per_s.unwrap_or(0.0),
            quantum_u_nm: found.quantum_u,
            scale: record.torque_scale,
            flags: found.flags,
            excluded: found.excluded,
            evidence: found.evidence,
        })
    }
}
