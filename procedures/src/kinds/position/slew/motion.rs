//! What moves show: acceleration and velocity of each, overshoot and settling of repeats averaged.

use std::ops::Range;

use analysis::estimate::Estimate;
use analysis::local_fit::{derivative, largest};
use analysis::step::{StepError, StepResponse, StepSettings, step_response};

use super::plan::{REST, SLEW};
use crate::axis::AxisLimits;
use crate::case::{Case, Segment};
use crate::kinds::position::positioned::{FLOOR_RAD, Record};
use crate::log::{SegmentSpan, Window};
use crate::reason::{PositionReason, Reason};

/// A plan counts as constant within this part of its largest value.
const CONSTANT_RATIO: f64 = 1e-3;
/// After the beginning of a constant stretch the loops settle: of acceleration, of velocity.
const SETTLE_S: [f64; 2] = [0.1, 0.2];
/// Shortest stretch that a mean is taken over: of acceleration, of velocity.
const LEAST_S: [f64; 2] = [0.08, 0.2];
/// Window of what is reached, and of the torque at the end of a move that was broken off.
const WINDOW_S: f64 = 0.1;
/// Torque that is missing, as a part of the largest.
const MISSING_RATIO: f64 = 0.05;
/// Encoder and gyro agree within this part.
const AGREE_RATIO: f64 = 0.05;

/// A move with its rows.
pub(super) struct Move<'a> {
    record: &'a Record<'a>,
    rows: Range<usize>,
    /// Planned rate and acceleration at each row.
    planned: Vec<[f64; 2]>,
    /// +1 upwards, −1 downwards.
    sign: f64,
    lasts_s: f64,
}

/// What of the plan is constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    SpeedingUp,
    Cruise,
    Braking,
}

impl<'a> Move<'a> {
    /// `None` if there are hardly any rows.
    pub(super) fn new(record: &'a Record<'a>, segment: &Segment, span: &SegmentSpan) -> Option<Self> {
        let rows = record.range(span.start_s, span.end_s);
        if rows.len() < 8 {
            return None;
        }
        let prepared = segment.stimulus.prepare(span.start_position_rad);
        let lasts_s = segment.stimulus.duration_s(span.start_position_rad)?;
        let way = prepared.at(lasts_s).position_rad - span.start_position_rad;
        let planned = rows.clone().map(|row| {
            let at = prepared.at(record.time_s[row] - span.start_s);
            [at.velocity_rad_per_s, at.acceleration_rad_per_s2].map(|v| v * way.signum())
        });
        Some(Self { record, planned: planned.collect(), rows, sign: way.signum(), lasts_s })
    }

    /// Whether the record ends before the move does.
    pub(super) fn is_cut(&self) -> bool {
        let times = &self.record.time_s[self.rows.clone()];
        times[times.len() - 1] - times[0] < self.lasts_s - 0.05
    }

    /// In words, for flags.
    pub(super) fn direction(&self) -> &'static str {
        if self.sign > 0.0 { "upwards" } else { "downwards" }
    }

    /// Rows of a constant part, less the time in which loops settle; `None` where too little is left.
    fn constant(&self, part: Part) -> Option<Range<usize>> {
        let value = |p: &[f64; 2]| match part {
            Part::SpeedingUp => p[1],
            Part::Cruise => p[0],
            Part::Braking => -p[1],
        };
        let most = self.planned.iter().map(value).fold(0.0, f64::max);
        let holds = |p: &[f64; 2]| most > 0.0 && value(p) >= most * (1.0 - CONSTANT_RATIO);
        let first = self.rows.start + self.planned.iter().position(holds)?;
        let last = self.rows.start + self.planned.iter().rposition(holds)?;
        let which = usize::from(part == Part::Cruise);
        let times = self.record.time_s;
        let from = first + times[first..=last].partition_point(|t| *t < times[first] + SETTLE_S[which]);
        (from < last && times[last] - times[from] >= LEAST_S[which]).then_some(from..last + 1)
    }

    /// Mean acceleration of a part, in the direction in which it is positive, with what the gyro says; or why not.
    pub(super) fn acceleration(&self, part: Part) -> Result<(Estimate, f64), Reason> {
        let rows = self.constant(part).ok_or(PositionReason::NoConstantAcceleration)?;
        let along = if part == Part::Braking { -self.sign } else { self.sign };
        let time_s = &self.record.time_s[rows.clone()];
        let fit = |values: &[f64], order| derivative(time_s, values, order).ok_or(PositionReason::TooFewRows);
        let by_encoder = fit(&self.record.position_rad[rows.clone()], 2)?;
        let by_gyro = fit(&self.record.rate_rad_per_s[rows], 1)?.value * along;
        let value = by_encoder.value * along;
        if (by_gyro - value).abs() > AGREE_RATIO * value.abs().max(by_gyro.abs()) + 2.0 * by_encoder.u {
            return Err(PositionReason::SensorsDisagree { by_encoder: value, by_gyro }.into());
        }
        Ok((Estimate { value, ..by_encoder }, by_gyro))
    }

    /// Mean rate of the cruise; where an interlock cut the move before it, the largest that was reached.
    pub(super) fn velocity(&self) -> Result<Estimate, Reason> {
        let rows = match self.constant(Part::Cruise) {
            // A cut move has a largest planned rate, too, but it is no cruise.
            Some(rows) if !self.is_cut() => rows,
            _ if self.is_cut() => return self.peak(1),
            _ => return Err(PositionReason::NoCruise.into()),
        };
        let found = derivative(&self.record.time_s[rows.clone()], &self.record.position_rad[rows], 1);
        let found = found.ok_or(PositionReason::TooFewRows)?;
        Ok(Estimate { value: found.value * self.sign, ..found })
    }

    /// Largest rate (order 1) or acceleration (2) over 0.1 s, a magnitude.
    pub(super) fn peak(&self, order: usize) -> Result<Estimate, Reason> {
        let time_s = &self.record.time_s[self.rows.clone()];
        let period_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
        let window = ((WINDOW_S / period_s).round() as usize).max(8);
        let found = largest(time_s, &self.record.position_rad[self.rows.clone()], order, window);
        let found = found.ok_or(PositionReason::ShortMove)?;
        Ok(Estimate { value: found.value.abs(), ..found })
    }

    /// Torque told and shown over the last 0.1 s of the move, where clearly less was given than told.
    pub(super) fn short_of_torque(&self, limits: &AxisLimits) -> Option<[f64; 2]> {
        let end_s = self.record.time_s[self.rows.end - 1];
        let last = self.record.range(end_s - WINDOW_S, end_s);
        let mean = |values: &[f64]| values[last.clone()].iter().sum::<f64>() / last.len().max(1) as f64;
        let [told, shown] = [mean(self.record.sent_nm), mean(self.record.shown_nm)];
        let missing = told.abs() - shown * told.signum();
        (missing > MISSING_RATIO * limits.max_torque_nm).then_some([told, shown])
    }
}

/// Settled is what stays this near to its final place (POS-ACC).
pub(super) const BAND_RAD: f64 = 75e-6;
/// The final place is the mean over this last time.
const TAIL_S: f64 = 0.5;

/// The end of a slew.
pub(super) struct End {
    /// Number of its cue.
    pub(super) cue: usize,
    /// Where the axis was last, after the first slew to it.
    pub(super) reached_rad: f64,
    /// Overshoot and noise; `None` if it did not settle.
    pub(super) response: Option<StepResponse>,
    /// From the planned end of the move; a lower bound if it did not settle.
    pub(super) settling_s: f64,
    pub(super) settling_u_s: f64,
    /// Time since the planned end, and place less cue, of the first repeat: for the picture.
    pub(super) course: [Vec<f64>; 2],
}

/// The ends of all slews of a point, by cue.
pub(super) fn ends(case: &Case, window: &Window, record: &Record<'_>) -> Result<Vec<End>, Reason> {
    let mut all = Vec::new();
    for cue in 0.. {
        let slews = Record::spans(case, window, &format!("{SLEW} {cue}"));
        let rests = Record::spans(case, window, &format!("{REST} {cue}"));
        if slews.is_empty() && cue > 0 {
            break;
        }
        if !slews.is_empty() {
            all.push(end(case, record, cue, &slews, &rests)?);
        }
    }
    if all.is_empty() { Err(PositionReason::NoSlew.into()) } else { Ok(all) }
}

fn end(
    case: &Case,
    record: &Record<'_>,
    cue: usize,
    slews: &[&SegmentSpan],
    rests: &[&SegmentSpan],
) -> Result<End, Reason> {
    let whole: Vec<(&SegmentSpan, f64)> =
        slews.iter().zip(rests).map(|(slew, rest)| (*slew, rest.end_s - slew.start_s)).collect();
    let shortest_s = whole.iter().map(|(_, lasts_s)| *lasts_s).fold(f64::INFINITY, f64::min);
    let (first, _) = whole.first().ok_or(PositionReason::NoRestAfter { cue })?;
    let stimulus = &case.segments[first.segment].stimulus;
    let planned_s = stimulus.duration_s(first.start_position_rad).ok_or(PositionReason::NoPlannedEnd)?;
    let target = stimulus.at(first.start_position_rad, planned_s).position_rad;
    let count = record.range(first.start_s, first.start_s + shortest_s).len().saturating_sub(2);
    let grid: Vec<f64> = (0..count).map(|k| shortest_s * k as f64 / (count + 1) as f64).collect();
    let height = target - first.start_position_rad;
    let mut repeats = Vec::new();
    for (slew, _) in &whole {
        let places = record.places_rad(grid.iter().map(|t| slew.start_s + t));
        let places = places.ok_or(PositionReason::RowsMissingInSlew { cue })?;
        repeats.push(places.iter().map(|p| p - first.start_position_rad).collect::<Vec<f64>>());
    }
    let reached_rad = first.start_position_rad + repeats[0].last().copied().unwrap_or(0.0);
    let settings = StepSettings { band_ratio: BAND_RAD / height.abs(), tail_s: TAIL_S, floor: FLOOR_RAD };
    let all: Vec<&[f64]> = repeats.iter().map(Vec::as_slice).collect();
    let after = grid.partition_point(|t| *t < planned_s - 0.2);
    let course = [
        grid[after..].iter().map(|t| t - planned_s).collect(),
        repeats[0][after..].iter().map(|v| v - height).collect(),
    ];
    match step_response(&grid, &all, height, &settings) {
        Ok(found) => Ok(End {
            cue,
            reached_rad,
            settling_s: (found.settling_s - planned_s).max(0.0),
            settling_u_s: found.settling_u_s,
            response: Some(found),
            course,
        }),
        Err(StepError::NotSettled { seconds }) => {
            let settling_u_s = shortest_s / (count + 1) as f64 / 12.0_f64.sqrt();
            let settling_s = seconds - planned_s;
            Ok(End { cue, reached_rad, response: None, settling_s, settling_u_s, course })
        }
        Err(error) => Err(PositionReason::SlewNotRead { cue, error }.into()),
    }
}
