//! One point: what the log holds of it, reduced to what concluding needs.

use analysis::effort::{Effort, NoEffort, block_means};
use analysis::least_squares::LinearFit;

use super::Direction;
use super::plan::{MULTISINE, RELEASE, SETTLE, STROKE};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::log::{EndedBy, PointStatus, Rows, SegmentSpan, Window};
use crate::measurement::{Exclusion, PointResult, Reduced};
use crate::reason::{FrictionReason, Reason};
use crate::stimulus::Stimulus;

/// Rest before the ramp that goes into the record: it pins down the bristle's torque at the start.
const LEAD_S: f64 = 0.5;
/// Most blocks in which the time at rest is kept.
const REST_BLOCKS: usize = 2000;
/// Blocks a second of the multisine record: 20 a period at 10 Hz.
const MULTISINE_BLOCKS_HZ: f64 = 200.0;
/// Share of the axis' largest torque above which it counts as saturated.
const SATURATED_RATIO: f64 = 0.999;
/// Plateau given away on both sides: the differentiator's window spreads the ramps' acceleration that far.
const PLATEAU_MARGIN_S: f64 = 0.4;

/// What a point was reduced to: what its segments are for is there, all else is not.
#[derive(Debug, Default)]
pub(super) struct BreakawayPoint {
    pub(super) stroke: Option<Stroke>,
    pub(super) positive_ramp: Option<Ramp>,
    pub(super) negative_ramp: Option<Ramp>,
    pub(super) multisine: Option<Multisine>,
    pub(super) release: Option<Release>,
}

impl BreakawayPoint {
    /// The ramp in a direction.
    ///
    /// # Errors
    /// When the point holds none.
    pub(super) fn ramp(&self, direction: Direction) -> Result<&Ramp, Reason> {
        let ramp = match direction {
            Direction::Positive => &self.positive_ramp,
            Direction::Negative => &self.negative_ramp,
        };
        ramp.as_ref().ok_or_else(|| FrictionReason::NoRamp { label: direction.ramp_label() }.into())
    }
}

/// Start and end of a segment on the log's time axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeSpan {
    pub(super) start_s: f64,
    pub(super) end_s: f64,
}

impl From<&SegmentSpan> for TimeSpan {
    fn from(span: &SegmentSpan) -> Self {
        Self { start_s: span.start_s, end_s: span.end_s }
    }
}

/// Blocks of the slow stroke on its plateau.
#[derive(Debug)]
pub(super) struct Stroke {
    pub(super) position_rad: Vec<f64>,
    pub(super) velocity_rad_per_s: Vec<f64>,
    pub(super) effort_nm: Vec<f64>,
    /// Blocks that were left out.
    pub(super) excluded_count: usize,
}

/// A torque ramp, with a lead of the rest before.
#[derive(Debug)]
pub(super) struct Ramp {
    /// Time of each block on the log's axis.
    pub(super) time_s: Vec<f64>,
    pub(super) position_rad: Vec<f64>,
    pub(super) effort_nm: Vec<f64>,
    pub(super) span: TimeSpan,
    /// Mean angle just before the ramp.
    pub(super) start_rad: f64,
    /// Rate of the motor torque; `None` where no line can be fitted.
    pub(super) rate_nm_per_s: Option<f64>,
    /// Mean time from row to row; `None` for fewer than two rows.
    pub(super) sample_s: Option<f64>,
    /// Time and position of the rest before, from settling to the start of the ramp.
    pub(super) rest_time_s: Vec<f64>,
    pub(super) rest_position_rad: Vec<f64>,
    /// The dwell ended by motion.
    pub(super) slid_in_dwell: bool,
    /// The ramp ended by motion.
    pub(super) moved: bool,
}

/// A release at a pose that must hold.
#[derive(Debug)]
pub(super) struct Release {
    /// Time of each block on the log's axis.
    pub(super) time_s: Vec<f64>,
    pub(super) position_rad: Vec<f64>,
    pub(super) effort_nm: Vec<f64>,
    pub(super) span: TimeSpan,
    /// Mean angle just before the release.
    pub(super) start_rad: f64,
    /// The axis slid off.
    pub(super) slid: bool,
}

/// Blocks of the multisine, a whole number in each period.
#[derive(Debug)]
pub(super) struct Multisine {
    pub(super) position_rad: Vec<f64>,
    pub(super) torque_nm: Vec<f64>,
    pub(super) period_blocks: usize,
    pub(super) period_s: f64,
    /// The lines as multiples of 1/period.
    pub(super) orders: Vec<u32>,
    pub(super) span: TimeSpan,
    /// Mean angle just before the multisine.
    pub(super) start_rad: f64,
    /// Mean torque in the rest before.
    pub(super) rest_nm: f64,
    /// Inertia of the axis where the point is.
    pub(super) inertia_kg_m2: f64,
}

/// Reduces one point.
///
/// `run_in_rad` is the way after each turn of the stroke on which the contact still renews itself.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes, run_in_rad: f64) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    match reduce(case, window, axes, run_in_rad) {
        Ok(point) => {
            result.excluded = point.stroke.as_ref().and_then(exclusion).into_iter().collect();
            result.reduced = Reduced::to(point);
        }
        Err(reason) => result.inconclusive = Some(reason),
    }
    result
}

fn reduce(case: &Case, window: &Window, axes: &Axes, run_in_rad: f64) -> Result<BreakawayPoint, Reason> {
    if window.status != PointStatus::Completed {
        return Err(FrictionReason::NotCompleted { trips: window.trips.clone() }.into());
    }
    let limits = axes.limits(&case.axis)?;
    let log = Columns::new(case, window, limits)?;
    let mut point = BreakawayPoint::default();
    for (index, planned) in case.segments.iter().enumerate() {
        let Some(span) = window.segments.iter().find(|s| s.segment == index) else {
            return Err(FrictionReason::SegmentNotLogged { label: planned.label.clone() }.into());
        };
        let label = planned.label.as_str();
        if label == STROKE {
            point.stroke = Some(log.stroke(span, run_in_rad)?);
        } else if label == MULTISINE {
            point.multisine = Some(log.multisine(span, &planned.stimulus)?);
        } else if label == RELEASE {
            point.release = Some(log.release(span)?);
        } else if label == Direction::Positive.ramp_label() {
            point.positive_ramp = Some(log.ramp(case, window, index, Direction::Positive)?);
        } else if label == Direction::Negative.ramp_label() {
            point.negative_ramp = Some(log.ramp(case, window, index, Direction::Negative)?);
        }
    }
    Ok(point)
}

fn exclusion(stroke: &Stroke) -> Option<Exclusion> {
    (stroke.excluded_count > 0).then(|| Exclusion {
        count: stroke.excluded_count,
        of: "blocks".to_owned(),
        reason: "reversal of the stroke: velocity off by more than 10 %, or contact not yet renewed"
            .to_owned(),
    })
}

/// Way of each block since the last turn, rad.
fn since_turn(effort: &Effort) -> Vec<f64> {
    let mut turn_rad = effort.position_rad.first().copied().unwrap_or(0.0);
    let mut last = 0.0_f64;
    effort
        .position_rad
        .iter()
        .zip(&effort.velocity_rad_per_s)
        .map(|(&position, &velocity)| {
            if velocity.signum() != last.signum() {
                turn_rad = position;
            }
            last = velocity;
            (position - turn_rad).abs()
        })
        .collect()
}

/// The columns of the axis' topic that this kind reads.
struct Columns<'a> {
    rows: &'a Rows,
    position_rad: &'a [f64],
    torque_nm: Vec<f64>,
    limits: &'a AxisLimits,
}

impl<'a> Columns<'a> {
    fn new(case: &Case, window: &'a Window, limits: &'a AxisLimits) -> Result<Self, Reason> {
        let topic = format!("/{}", case.axis);
        let rows = window.rows(&topic).ok_or(FrictionReason::TopicNotLogged { topic })?;
        let column = |name: &str| rows.column(name);
        let position_rad = column("position_rad").ok_or(FrictionReason::AngleNotLogged)?;
        let torque_nm = match (column("current_a"), limits.torque_constant(), column("torque_nm")) {
            (Some(current), Some(constant), _) => current.iter().map(|i| constant * i).collect(),
            (_, _, Some(torque)) => torque.iter().map(|t| limits.torque_ratio() * t).collect(),
            _ => {
                return Err(FrictionReason::TorqueNotLogged.into());
            }
        };
        if position_rad.iter().chain(&torque_nm).any(|v| !v.is_finite()) {
            return Err(FrictionReason::NoNumbers.into());
        }
        Ok(Self { rows, position_rad, torque_nm, limits })
    }

    /// The effort between two instants.
    fn effort(&self, start_s: f64, end_s: f64) -> Result<Effort, Reason> {
        let range = self.rows.range(start_s, end_s);
        let time = &self.rows.time_s[range.clone()];
        let torque = &self.torque_nm[range.clone()];
        let most = torque.iter().map(|t| t.abs()).fold(0.0, f64::max);
        let limit_nm = self.limits.torque_ratio() * self.limits.max_torque_nm;
        if most >= SATURATED_RATIO * limit_nm {
            return Err(FrictionReason::Saturated { limit_nm }.into());
        }
        let effort = Effort::new(time, &self.position_rad[range], torque, self.limits.inertia_kg_m2);
        effort.map_err(|why| match why {
            NoEffort::TooFewRows => FrictionReason::TooFewRows { start_s, end_s }.into(),
            gap @ NoEffort::Gap { .. } => FrictionReason::NoEffort(gap).into(),
        })
    }

    fn stroke(&self, span: &SegmentSpan, run_in_rad: f64) -> Result<Stroke, Reason> {
        let effort = self.effort(span.start_s, span.end_s)?;
        let speeds: Vec<f64> = effort.velocity_rad_per_s.iter().map(|v| v.abs()).collect();
        // Half of the blocks at least are on the plateau: the median speed is its velocity.
        let mut sorted = speeds.clone();
        sorted.sort_by(f64::total_cmp);
        let plateau = sorted[sorted.len() / 2];
        let run = since_turn(&effort);
        let steady: Vec<bool> = speeds.iter().map(|v| (0.9..1.1).contains(&(v / plateau))).collect();
        let block_s = (span.end_s - span.start_s) / speeds.len() as f64;
        let margin = (PLATEAU_MARGIN_S / block_s).ceil() as usize;
        let inside = |i: usize| {
            let around = i.saturating_sub(margin)..(i + margin + 1).min(steady.len());
            steady[around].iter().all(|&s| s)
        };
        let on_plateau = |i: &usize| inside(*i) && run[*i] >= run_in_rad;
        let kept: Vec<usize> = (0..speeds.len()).filter(on_plateau).collect();
        let pick = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&i| values[i]).collect() };
        Ok(Stroke {
            position_rad: pick(&effort.position_rad),
            velocity_rad_per_s: pick(&effort.velocity_rad_per_s),
            effort_nm: pick(&effort.effort_nm),
            excluded_count: speeds.len() - kept.len(),
        })
    }

    fn ramp(&self, case: &Case, window: &Window, index: usize, direction: Direction) -> Result<Ramp, Reason> {
        let before = |label: &str| {
            let place = case.segments[..index].iter().rposition(|s| s.label == label)?;
            window.segments.iter().find(|s| s.segment == place)
        };
        let span = window.segments.iter().find(|s| s.segment == index);
        let (Some(span), Some(settle), Some(dwell)) =
            (span, before(SETTLE), before(&direction.dwell_label()))
        else {
            return Err(FrictionReason::NoSettleOrDwell.into());
        };
        let effort = self.effort((span.start_s - LEAD_S).max(dwell.start_s), span.end_s)?;
        let rest = self.rows.range(settle.start_s, span.start_s);
        let block = rest.len() / REST_BLOCKS + 1;
        Ok(Ramp {
            time_s: effort.time_s,
            position_rad: effort.position_rad,
            effort_nm: effort.effort_nm,
            span: span.into(),
            start_rad: self.rest_position(span.start_s)?,
            rate_nm_per_s: self.torque_rate(span),
            sample_s: self.sample_s(span),
            rest_time_s: block_means(&self.rows.time_s[rest.clone()], block),
            rest_position_rad: block_means(&self.position_rad[rest], block),
            slid_in_dwell: dwell.ended_by == EndedBy::Condition,
            moved: span.ended_by == EndedBy::Condition,
        })
    }

    /// Rate of the motor torque over a segment, N·m/s, by a straight line.
    fn torque_rate(&self, span: &SegmentSpan) -> Option<f64> {
        let range = self.rows.range(span.start_s, span.end_s);
        let time: Vec<f64> = self.rows.time_s[range.clone()].iter().map(|t| t - span.start_s).collect();
        let line = LinearFit::new(&[vec![1.0; time.len()], time], &self.torque_nm[range], None).ok()?;
        Some(line.coefficients[1])
    }

    /// Mean time from row to row in a segment, s.
    fn sample_s(&self, span: &SegmentSpan) -> Option<f64> {
        let time_s = &self.rows.time_s[self.rows.range(span.start_s, span.end_s)];
        match time_s {
            [first, .., last] => Some((last - first) / (time_s.len() - 1) as f64),
            _ => None,
        }
    }

    /// Mean position over the tenth of a second before an instant.
    fn rest_position(&self, at_s: f64) -> Result<f64, Reason> {
        let range = self.rows.range(at_s - 0.1, at_s);
        let values = &self.position_rad[range];
        if values.is_empty() {
            return Err(FrictionReason::NoRowsBefore { at_s }.into());
        }
        Ok(values.iter().sum::<f64>() / values.len() as f64)
    }

    fn release(&self, span: &SegmentSpan) -> Result<Release, Reason> {
        let effort = self.effort(span.start_s, span.end_s)?;
        Ok(Release {
            start_rad: self.rest_position(span.start_s)?,
            time_s: effort.time_s,
            position_rad: effort.position_rad,
            effort_nm: effort.effort_nm,
            span: span.into(),
            slid: span.ended_by == EndedBy::Condition,
        })
    }

    fn multisine(&self, span: &SegmentSpan, stimulus: &Stimulus) -> Result<Multisine, Reason> {
        let Stimulus::TorqueMultisine { period_s, lines, .. } = stimulus else {
            return Err(FrictionReason::NotAMultisine.into());
        };
        if span.ended_by == EndedBy::Condition {
            return Err(FrictionReason::SlidInMultisine.into());
        }
        let range = self.rows.range(span.start_s, span.end_s);
        let time = &self.rows.time_s[range.clone()];
        let [first, .., last] = time else { return Err(FrictionReason::MultisineWithoutRows.into()) };
        let rate = (time.len() - 1) as f64 / (last - first);
        let samples = rate * period_s;
        let whole = samples.round();
        if (samples - whole).abs() > 1e-3 * samples.max(1.0) / whole.max(1.0) || whole < 1.0 {
            return Err(FrictionReason::MultisinePeriod { samples }.into());
        }
        let most = ((rate / MULTISINE_BLOCKS_HZ) as usize).max(1);
        let block = (1..=most).rev().find(|&b| (whole as usize).is_multiple_of(b)).unwrap_or(1);
        let rest = self.rows.range(span.start_s - LEAD_S, span.start_s);
        let rest_nm = self.torque_nm[rest.clone()].iter().sum::<f64>() / rest.len().max(1) as f64;
        Ok(Multisine {
            start_rad: self.rest_position(span.start_s)?,
            rest_nm,
            inertia_kg_m2: self.limits.inertia_kg_m2,
            position_rad: block_means(&self.position_rad[range.clone()], block),
            torque_nm: block_means(&self.torque_nm[range], block),
            period_blocks: whole as usize / block,
            period_s: *period_s,
            orders: lines.iter().map(|l| (l.frequency_hz * period_s).round() as u32).collect(),
            span: span.into(),
        })
    }
}
