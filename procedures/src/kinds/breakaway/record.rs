//! One point: what the log holds of it, reduced to what concluding needs.

use std::collections::BTreeMap;

use analysis::effort::{Effort, block_means};
use analysis::least_squares::LinearFit;

use super::plan::{DWELL, MULTISINE, RAMP, RELEASE, SETTLE, STROKE, sign};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::log::{EndedBy, PointStatus, Rows, SegmentSpan, Window};
use crate::measurement::{Exclusion, PointResult};
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

/// Numbers of a point, by name.
pub(super) type Numbers = BTreeMap<String, Vec<f64>>;

/// Reduces one point.
///
/// `run_in_rad` is the way after each turn of the stroke on which the contact still renews itself.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes, run_in_rad: f64) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    match reduce(case, window, axes, run_in_rad) {
        Ok(numbers) => {
            result.excluded = exclusions(&numbers);
            result.numbers = numbers;
        }
        Err(reason) => result.inconclusive = Some(reason),
    }
    result
}

fn reduce(case: &Case, window: &Window, axes: &Axes, run_in_rad: f64) -> Result<Numbers, String> {
    if window.status != PointStatus::Completed {
        let trips =
            if window.trips.is_empty() { String::new() } else { format!(": {}", window.trips.join("; ")) };
        return Err(format!("the point did not complete{trips}"));
    }
    let limits = axes.get(&case.axis).ok_or_else(|| format!("the log's rig has no axis `{}`", case.axis))?;
    let log = Columns::of(case, window, limits)?;
    let mut numbers = Numbers::new();
    for (index, planned) in case.segments.iter().enumerate() {
        let Some(span) = window.segments.iter().find(|s| s.segment == index) else {
            return Err(format!("segment `{}` is not in the log", planned.label));
        };
        if planned.label == STROKE {
            log.stroke(span, run_in_rad, &mut numbers)?;
        } else if planned.label == MULTISINE {
            log.multisine(span, &planned.stimulus, &mut numbers)?;
        } else if planned.label == RELEASE {
            log.release(span, &mut numbers)?;
        } else if let Some(direction) = direction_of(&planned.label) {
            log.ramp(case, window, index, direction, &mut numbers)?;
        }
    }
    Ok(numbers)
}

/// Direction of a ramp by its label.
fn direction_of(label: &str) -> Option<f64> {
    [1.0, -1.0].into_iter().find(|&d| label == format!("{RAMP}{}", sign(d)))
}

fn exclusions(numbers: &Numbers) -> Vec<Exclusion> {
    let turned = numbers.get("stroke.excluded").and_then(|v| v.first()).copied().unwrap_or(0.0);
    if turned > 0.0 {
        let reason =
            "turn-round of the stroke: off its velocity by 10 %, or the contact not renewed yet".to_owned();
        return vec![Exclusion { count: turned as usize, of: "blocks".to_owned(), reason }];
    }
    Vec::new()
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
    fn of(case: &Case, window: &'a Window, limits: &'a AxisLimits) -> Result<Self, String> {
        let topic = format!("/{}", case.axis);
        let rows = window.rows(&topic).ok_or_else(|| format!("topic `{topic}` is not in the log"))?;
        let column = |name: &str| rows.column(name);
        let position_rad = column("position_rad").ok_or("channel `position_rad` is not in the log")?;
        let torque_nm = match (column("current_a"), limits.torque_constant_nm_per_a, column("torque_nm")) {
            (Some(current), Some(constant), _) => current.iter().map(|i| constant * i).collect(),
            (_, _, Some(torque)) => torque.to_vec(),
            _ => {
                return Err(
                    "neither `current_a` with a torque constant nor `torque_nm` is in the log".to_owned()
                );
            }
        };
        if position_rad.iter().chain(&torque_nm).any(|v| !v.is_finite()) {
            return Err("position or torque holds values that are not numbers".to_owned());
        }
        Ok(Self { rows, position_rad, torque_nm, limits })
    }

    /// The effort between two instants.
    fn effort(&self, start_s: f64, end_s: f64) -> Result<Effort, String> {
        let range = self.rows.range(start_s, end_s);
        let time = &self.rows.time_s[range.clone()];
        let torque = &self.torque_nm[range.clone()];
        let most = torque.iter().map(|t| t.abs()).fold(0.0, f64::max);
        if most >= SATURATED_RATIO * self.limits.max_torque_nm {
            return Err(format!(
                "saturated: the motor torque reached its limit of {:.0} N·m",
                self.limits.max_torque_nm
            ));
        }
        Effort::new(time, &self.position_rad[range], torque, self.limits.inertia_kg_m2)
            .ok_or_else(|| format!("too few rows between {start_s:.3} s and {end_s:.3} s"))
    }

    fn stroke(&self, span: &SegmentSpan, run_in_rad: f64, numbers: &mut Numbers) -> Result<(), String> {
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
        numbers.insert("stroke.excluded".to_owned(), vec![(speeds.len() - kept.len()) as f64]);
        numbers.insert("stroke.position".to_owned(), pick(&effort.position_rad));
        numbers.insert("stroke.velocity".to_owned(), pick(&effort.velocity_rad_per_s));
        numbers.insert("stroke.effort".to_owned(), pick(&effort.effort_nm));
        numbers.insert("stroke.span".to_owned(), vec![span.start_s, span.end_s]);
        Ok(())
    }

    fn ramp(
        &self,
        case: &Case,
        window: &Window,
        index: usize,
        direction: f64,
        numbers: &mut Numbers,
    ) -> Result<(), String> {
        let before = |label: &str| {
            let place = case.segments[..index].iter().rposition(|s| s.label == label)?;
            window.segments.iter().find(|s| s.segment == place)
        };
        let span = window.segments.iter().find(|s| s.segment == index);
        let (Some(span), Some(settle), Some(dwell)) =
            (span, before(SETTLE), before(&format!("{DWELL}{}", sign(direction))))
        else {
            return Err("the ramp's settle and dwell are not in the log".to_owned());
        };
        let effort = self.effort((span.start_s - LEAD_S).max(dwell.start_s), span.end_s)?;
        let name = |part: &str| format!("{RAMP}{}.{part}", sign(direction));
        let rest = self.rows.range(settle.start_s, span.start_s);
        let block = rest.len() / REST_BLOCKS + 1;
        numbers.insert(name("rest-time"), block_means(&self.rows.time_s[rest.clone()], block));
        numbers.insert(name("rest-position"), block_means(&self.position_rad[rest], block));
        numbers.insert(name("time"), effort.time_s);
        numbers.insert(name("position"), effort.position_rad);
        numbers.insert(name("effort"), effort.effort_nm);
        numbers.insert(name("span"), vec![span.start_s, span.end_s]);
        numbers.insert(name("start"), vec![self.rest_position(span.start_s)?]);
        numbers.insert(name("rate"), self.torque_rate(span).into_iter().collect());
        numbers.insert(name("sample"), self.sample_s(span).into_iter().collect());
        let ended = |s: &SegmentSpan| f64::from(u8::from(s.ended_by == EndedBy::Condition));
        numbers.insert(name("ended"), vec![ended(dwell), ended(span)]);
        Ok(())
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
        match &self.rows.time_s[self.rows.range(span.start_s, span.end_s)] {
            [first, .., last] => {
                let rows = self.rows.range(span.start_s, span.end_s).len();
                Some((last - first) / (rows - 1) as f64)
            }
            _ => None,
        }
    }

    /// Mean position over the tenth of a second before an instant.
    fn rest_position(&self, at_s: f64) -> Result<f64, String> {
        let range = self.rows.range(at_s - 0.1, at_s);
        let values = &self.position_rad[range];
        if values.is_empty() {
            return Err(format!("no rows just before {at_s:.3} s"));
        }
        Ok(values.iter().sum::<f64>() / values.len() as f64)
    }

    fn release(&self, span: &SegmentSpan, numbers: &mut Numbers) -> Result<(), String> {
        let effort = self.effort(span.start_s, span.end_s)?;
        numbers.insert("release.start".to_owned(), vec![self.rest_position(span.start_s)?]);
        numbers.insert("release.time".to_owned(), effort.time_s);
        numbers.insert("release.position".to_owned(), effort.position_rad);
        numbers.insert("release.effort".to_owned(), effort.effort_nm);
        numbers.insert("release.span".to_owned(), vec![span.start_s, span.end_s]);
        let slid = f64::from(u8::from(span.ended_by == EndedBy::Condition));
        numbers.insert("release.slid".to_owned(), vec![slid]);
        Ok(())
    }

    fn multisine(
        &self,
        span: &SegmentSpan,
        stimulus: &Stimulus,
        numbers: &mut Numbers,
    ) -> Result<(), String> {
        let Stimulus::TorqueMultisine { period_s, lines, .. } = stimulus else {
            return Err("the multisine segment holds no multisine".to_owned());
        };
        if span.ended_by == EndedBy::Condition {
            return Err("the axis slid off during the multisine".to_owned());
        }
        let range = self.rows.range(span.start_s, span.end_s);
        let time = &self.rows.time_s[range.clone()];
        let [first, .., last] = time else { return Err("the multisine has no rows".to_owned()) };
        let rate = (time.len() - 1) as f64 / (last - first);
        let samples = rate * period_s;
        let whole = samples.round();
        if (samples - whole).abs() > 1e-3 * samples.max(1.0) / whole.max(1.0) || whole < 1.0 {
            return Err(format!("the multisine's period holds {samples:.3} rows, not a whole number"));
        }
        let most = ((rate / MULTISINE_BLOCKS_HZ) as usize).max(1);
        let block = (1..=most).rev().find(|&b| (whole as usize).is_multiple_of(b)).unwrap_or(1);
        let orders = lines.iter().map(|l| (l.frequency_hz * period_s).round()).collect();
        let rest = self.rows.range(span.start_s - LEAD_S, span.start_s);
        let rest_nm = self.torque_nm[rest.clone()].iter().sum::<f64>() / rest.len().max(1) as f64;
        numbers.insert("multisine.start".to_owned(), vec![self.rest_position(span.start_s)?]);
        numbers.insert("multisine.rest-torque".to_owned(), vec![rest_nm]);
        numbers
            .insert("multisine.position".to_owned(), block_means(&self.position_rad[range.clone()], block));
        numbers.insert("multisine.torque".to_owned(), block_means(&self.torque_nm[range], block));
        numbers.insert("multisine.period".to_owned(), vec![whole / block as f64, *period_s]);
        numbers.insert("multisine.orders".to_owned(), orders);
        numbers.insert("multisine.span".to_owned(), vec![span.start_s, span.end_s]);
        Ok(())
    }
}
