//! What the log holds of a tracked target: frames, each once, where the target goes, and what explains peaks.

use analysis::derivative::Differentiator;
use analysis::tracking::{Cause, Happening, opened};

use super::keys::{Keys, Rails};
use crate::log::{Rows, Window};
use crate::reason::{OpticsReason, Reason};

/// The tracker measures its target.
const TRACKING: f64 = 2.0;
/// Fewest frames that make a record.
const LEAST_FRAMES: usize = 16;
/// Fewest distances between missing frames that show a period.
const LEAST_IN_TURN: usize = 5;
/// Rows must be so fast that no more frames than this are missed by them.
const MOST_UNSEEN_RATIO: f64 = 0.01;
/// Frames without the target after which it counts as lost, as the interlock `tracker lost` has it; half a frame more, as
/// exposures are no multiples of rows.
const FRAMES_TO_LOSE: f64 = 3.5;

/// Frames of one tracker.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frames {
    /// Centre of each exposure on the log's time axis.
    pub(super) time_s: Vec<f64>,
    /// Number of each frame, counted from the first of these.
    pub(super) number: Vec<f64>,
    /// Row in which it came.
    pub(super) row: Vec<usize>,
    /// Across the elevation axis, and in elevation.
    pub(super) error_rad: [Vec<f64>; 2],
    /// Whether it shows the target.
    pub(super) valid: Vec<bool>,
    /// Time between two exposures.
    pub(super) period_s: f64,
    /// From an exposure to its message.
    pub(super) latency_s: f64,
}

impl Frames {
    /// Those that came between two times.
    ///
    /// # Errors
    /// No topic, no channel, no numbers, too few frames, rows that are slower than frames.
    pub(super) fn read(window: &Window, topic: &str, [from_s, to_s]: [f64; 2]) -> Result<Self, Reason> {
        let rows = window.topic(topic)?;
        let within = rows.range(from_s, to_s);
        let column = |name: &str| -> Result<&[f64], Reason> {
            let values = rows.channel(name)?;
            match values[within.clone()].iter().all(|v| v.is_finite()) {
                true => Ok(values),
                false => {
                    Err(OpticsReason::NoNumber { topic: topic.to_owned(), channel: name.to_owned() }.into())
                }
            }
        };
        let counter = column("counter")?;
        let age = column("age_s")?;
        let lock = column("lock")?;
        let errors = [column("cross_elevation_rad")?, column("elevation_rad")?];
        let new = |k: &usize| *k > 0 && counter[*k] != counter[*k - 1];
        let row: Vec<usize> = within.clone().filter(new).collect();
        if row.len() < LEAST_FRAMES {
            return Err(OpticsReason::TooFewFrames {
                frames: row.len(),
                topic: topic.to_owned(),
                least: LEAST_FRAMES,
            }
            .into());
        }
        let pick = |values: &[f64]| -> Vec<f64> { row.iter().map(|&k| values[k]).collect() };
        let first = counter[row[0]];
        let number: Vec<f64> = row.iter().map(|&k| counter[k] - first).collect();
        let time_s: Vec<f64> = row.iter().map(|&k| rows.time_s[k] - age[k]).collect();
        let last = row.len() - 1;
        let period_s = (time_s[last] - time_s[0]) / number[last];
        let ascends = number.windows(2).all(|n| n[1] > n[0]) && time_s.windows(2).all(|t| t[1] > t[0]);
        if !(ascends && period_s > 0.0 && period_s.is_finite()) {
            return Err(OpticsReason::NotConsecutive { topic: topic.to_owned() }.into());
        }
        unseen(rows, &row, &number)?;
        let latency_s = pick(age).into_iter().fold(f64::INFINITY, f64::min);
        let valid = row.iter().map(|&k| lock[k] == TRACKING).collect();
        let error_rad = errors.map(pick);
        Ok(Self { time_s, number, row, error_rad, valid, period_s, latency_s })
    }

    /// Indices of the frames that show the target between two times.
    pub(super) fn shown(&self, [from_s, to_s]: [f64; 2]) -> Vec<usize> {
        let inside = |k: &usize| self.valid[*k] && (from_s..to_s).contains(&self.time_s[*k]);
        (0..self.time_s.len()).filter(inside).collect()
    }

    /// Longest time between two frames that may pass without a loss.
    pub(super) fn gap_s(&self) -> f64 {
        FRAMES_TO_LOSE * self.period_s
    }

    /// Stretches in which the target was lost, up to the end of the track: frames came without it, or none for too long.
    pub(super) fn losses(&self, end_s: f64) -> Vec<[f64; 2]> {
        let mut losses = Vec::new();
        let mut before: Option<usize> = None;
        for k in (0..self.time_s.len()).filter(|&k| self.valid[k]) {
            let since = before.map_or(0, |b| b + 1);
            let from_s = self.time_s[before.unwrap_or(0)];
            if since < k || self.time_s[k] - from_s > self.gap_s() {
                losses.push([from_s, self.time_s[k]]);
            }
            before = Some(k);
        }
        let from_s = self.time_s[before.unwrap_or(0)];
        let trails = before.is_none_or(|b| b + 1 < self.time_s.len());
        if trails || end_s - from_s > self.latency_s + self.gap_s() {
            losses.push([from_s, end_s]);
        }
        losses
    }

    /// Longest time between two frames that show the target.
    pub(super) fn longest_gap_s(&self) -> f64 {
        let shown: Vec<f64> =
            self.time_s.iter().zip(&self.valid).filter(|(_, valid)| **valid).map(|(t, _)| *t).collect();
        shown.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max)
    }

    /// How many frames never came.
    pub(super) fn missing(&self) -> usize {
        self.made() - self.number.len()
    }

    /// Frames that the tracker made from the first to the last of these.
    pub(super) fn made(&self) -> usize {
        let counted = self.number.last().map_or(0.0, |n| n + 1.0);
        (counted as usize).max(self.number.len())
    }

    /// Number of frames from one that never came to the next, where they are missing in turn: nine of ten distances agree.
    pub(super) fn missing_every(&self) -> Option<usize> {
        let gaps = self.number.windows(2).filter(|n| n[1] - n[0] > 1.5);
        let missed: Vec<usize> = gaps.flat_map(|n| n[0] as usize + 1..n[1] as usize).collect();
        let mut apart: Vec<usize> = missed.windows(2).map(|m| m[1] - m[0]).collect();
        apart.sort_unstable();
        let middle = *apart.get(apart.len() / 2)?;
        let same = apart.iter().filter(|&&frames| frames == middle).count();
        (apart.len() >= LEAST_IN_TURN && 10 * same >= 9 * apart.len()).then_some(middle)
    }
}

/// Frames that neither came in a row nor are counted as lost on their way were between two rows.
fn unseen(rows: &Rows, row: &[usize], number: &[f64]) -> Result<(), Reason> {
    let topic = &rows.topic.name;
    let lost = rows.channel("lost_frames")?;
    let last = row.len() - 1;
    let skipped = number[last] - last as f64;
    let unseen = skipped - (lost[row[last]] - lost[row[0]]);
    if unseen > MOST_UNSEEN_RATIO * number[last] {
        return Err(OpticsReason::FramesInNoRow { unseen, topic: topic.clone() }.into());
    }
    Ok(())
}

/// Direction of the target, rate and acceleration, at equal steps of time; azimuth, elevation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sight {
    pub(super) time_s: Vec<f64>,
    pub(super) angle_rad: [Vec<f64>; 2],
    pub(super) rate_rad_per_s: [Vec<f64>; 2],
    pub(super) acceleration_rad_per_s2: [Vec<f64>; 2],
}

impl Sight {
    /// From the frames that show the target: encoder at the exposure plus error, azimuth's over the cosine of elevation.
    /// Where frames are missing it is on straight lines.
    ///
    /// # Errors
    /// No encoder, too few frames for the bandwidth.
    pub(super) fn new(
        frames: &Frames,
        window: &Window,
        axes: [&str; 2],
        bandwidth_hz: f64,
    ) -> Result<Self, Reason> {
        let shown: Vec<usize> = (0..frames.time_s.len()).filter(|&k| frames.valid[k]).collect();
        let [Some(&first), Some(&last)] = [shown.first(), shown.last()] else {
            return Err(OpticsReason::NoCoarseFrame.into());
        };
        let mut angles = [Vec::new(), Vec::new()];
        for &k in &shown {
            let at_s = frames.time_s[k];
            let [az, el] = [place(window, axes[0], at_s)?, place(window, axes[1], at_s)?];
            angles[0].push(az + frames.error_rad[0][k] / el.cos());
            angles[1].push(el + frames.error_rad[1][k]);
        }
        let numbers: Vec<f64> = shown.iter().map(|&k| frames.number[k]).collect();
        let steps = (frames.number[last] - frames.number[first]) as usize;
        let time_s = (0..=steps).map(|n| frames.time_s[first] + n as f64 * frames.period_s).collect();
        let angle_rad = angles.map(|angle| filled(&numbers, &angle, steps));
        let rate_hz = 1.0 / frames.period_s;
        let differentiator = Differentiator::new(rate_hz, bandwidth_hz)
            .ok_or(OpticsReason::SlowFrames { rate_hz, bandwidth_hz })?;
        let derived = |order: usize| -> Result<[Vec<f64>; 2], Reason> {
            let derivative = |angle: &Vec<f64>| match order {
                1 => differentiator.velocity(angle),
                _ => differentiator.acceleration(angle),
            };
            let [az, el] = [derivative(&angle_rad[0]), derivative(&angle_rad[1])];
            let both = az.zip(el).ok_or(OpticsReason::TooFewCoarse)?;
            Ok([both.0, both.1].map(|values| without_ends(values, differentiator.window() / 2)))
        };
        let rate_rad_per_s = derived(1)?;
        let acceleration_rad_per_s2 = derived(2)?;
        Ok(Self { time_s, angle_rad, rate_rad_per_s, acceleration_rad_per_s2 })
    }

    /// Rate about an axis at a time, of the nearest sample.
    pub(super) fn rate_at(&self, axis: usize, at_s: f64) -> f64 {
        let k = self.time_s.partition_point(|&t| t < at_s).min(self.time_s.len() - 1);
        self.rate_rad_per_s[axis][k]
    }
}

/// Half a window from either end the polynomial is read off its centre, where noise governs it: what is last known stands.
fn without_ends(mut values: Vec<f64>, half: usize) -> Vec<f64> {
    let n = values.len();
    let low = half.min(n - 1);
    let high = n - 1 - half.min(n - 1);
    let first = values[low];
    let last = values[high];
    values[..low].fill(first);
    values[high..].fill(last);
    values
}

/// Values at whole numbers from the first on.
fn filled(numbers: &[f64], values: &[f64], steps: usize) -> Vec<f64> {
    let mut before = 0;
    let value = |n: usize| {
        let wanted = numbers[0] + n as f64;
        while before + 1 < numbers.len() && numbers[before + 1] <= wanted {
            before += 1;
        }
        let Some(next) = numbers.get(before + 1) else { return values[before] };
        let share = (wanted - numbers[before]) / (next - numbers[before]);
        values[before] + share * (values[before + 1] - values[before])
    };
    (0..=steps).map(value).collect()
}

/// Where the encoder has an axis at a time.
fn place(window: &Window, axis: &str, at_s: f64) -> Result<f64, Reason> {
    let topic = format!("/{axis}");
    let rows = window.topic(&topic)?;
    let angle = rows.channel("position_rad")?;
    let after = rows.time_s.partition_point(|&t| t < at_s).clamp(1, rows.time_s.len().max(2) - 1);
    let [Some(t), Some(a)] = [rows.time_s.get(after - 1..=after), angle.get(after - 1..=after)] else {
        return Err(OpticsReason::NoRows { topic }.into());
    };
    let share = ((at_s - t[0]) / (t[1] - t[0])).clamp(0.0, 1.0);
    let value = a[0] + share * (a[1] - a[0]);
    value.is_finite().then_some(value).ok_or_else(|| OpticsReason::NoAngleNumber { topic }.into())
}

/// Loops need so long after a loss or the end of the stroke until they follow again.
const RECOVERY_S: f64 = 0.5;
/// A joint may come so much earlier than the geometry says: rails are put down by hand.
const JOINT_EARLY_S: f64 = 0.2;
/// Rates of either sign of this share of their change belong to a turn-round.
const TURN_SHARE: f64 = 0.25;

/// A stretch of time in which something happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Event {
    pub(super) cause: Cause,
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

impl Event {
    fn new(cause: Cause, [from_s, to_s]: [f64; 2]) -> Self {
        Self { cause, from_s, to_s }
    }
}

/// Windows of an axis as declared: stretches opened by the acceleration of the target.
pub(super) fn windows(keys: &Keys, sight: &Sight, axis: usize) -> Vec<[f64; 2]> {
    let acceleration = &sight.acceleration_rad_per_s2[axis];
    opened(&sight.time_s, acceleration, keys.threshold_rad_per_s2, keys.before_s, keys.after_s)
}

/// Where the target's rate about an axis changed quickly: with its sign, or without.
pub(super) fn turns(keys: &Keys, sight: &Sight, axis: usize) -> Vec<Event> {
    let half_s = 0.5 * (keys.before_s + keys.after_s);
    let sides = |t_s: f64| [t_s - half_s, t_s + half_s].map(|at_s| sight.rate_at(axis, at_s));
    let changes: Vec<f64> = sight.time_s.iter().map(|&t_s| sides(t_s)).map(|[a, b]| b - a).collect();
    let stretches = opened(&sight.time_s, &changes, keys.cause_rad_per_s, keys.before_s, keys.after_s);
    let event = |stretch: [f64; 2]| {
        let within = |k: &usize| (stretch[0]..=stretch[1]).contains(&sight.time_s[*k]);
        let most =
            (0..changes.len()).filter(within).max_by(|&a, &b| changes[a].abs().total_cmp(&changes[b].abs()));
        let [before, after] = most.map_or([0.0; 2], |k| sides(sight.time_s[k]));
        let change = (after - before).abs();
        let turned = before * after < 0.0 && before.abs().min(after.abs()) > TURN_SHARE * change;
        Event::new(if turned { Cause::Reversal } else { Cause::Jump }, stretch)
    };
    stretches.into_iter().map(event).collect()
}

/// Joints that the target went over: where the geometry of the rails says, from where it stood at first.
pub(super) fn joints(keys: &Keys, rails: &Rails, sight: &Sight) -> Vec<Event> {
    let azimuth = &sight.angle_rad[0];
    let Some(&stood_rad) = azimuth.first() else { return Vec::new() };
    let [low, high] = keys.span_rad;
    let onward = if 0.5 * (low + high) < keys.azimuth_rad { -1.0 } else { 1.0 };
    let length_m = rails.rail_m * f64::from(rails.count);
    let end_rad = (0.5 * length_m / rails.distance_m).atan();
    // From the end at which it stood.
    let along = |az: f64| rails.distance_m * (onward * (az - stood_rad) - end_rad).tan() + 0.5 * length_m;
    let rail = |az: f64| (along(az) / rails.rail_m).floor();
    let crosses = |k: &usize| {
        let a = rail(azimuth[*k - 1]);
        let b = rail(azimuth[*k]);
        a != b && (1.0..f64::from(rails.count)).contains(&a.max(b))
    };
    (1..azimuth.len())
        .filter(crosses)
        .map(|k| [sight.time_s[k] - JOINT_EARLY_S, sight.time_s[k] + rails.jolt_s])
        .map(|stretch| Event::new(Cause::Joint, stretch))
        .collect()
}

/// Stretches in which the mirror stood at the end of its stroke, with the time that its loop needs afterwards.
pub(super) fn stroke_ends(window: &Window, axis: usize, [from_s, to_s]: [f64; 2]) -> Vec<Event> {
    let Some(rows) = window.rows("/track") else { return Vec::new() };
    let Some(saturated) = rows.column(["az_saturated", "el_saturated"][axis]) else { return Vec::new() };
    let within = rows.range(from_s, to_s);
    let stretches = opened(&rows.time_s[within.clone()], &saturated[within], 0.5, 0.0, RECOVERY_S);
    stretches.into_iter().map(|stretch| Event::new(Cause::Saturation, stretch)).collect()
}

/// Losses, with the time that loops need afterwards.
pub(super) fn losses(stretches: &[[f64; 2]]) -> Vec<Event> {
    stretches.iter().map(|&[from_s, to_s]| Event::new(Cause::Loss, [from_s, to_s + RECOVERY_S])).collect()
}

/// Events as samples of a record.
pub(super) fn among(events: &[Event], time_s: &[f64]) -> Vec<Happening> {
    let place = |t_s: f64| time_s.partition_point(|&t| t < t_s);
    events.iter().map(|e| Happening { cause: e.cause, from: place(e.from_s), to: place(e.to_s) }).collect()
}

/// The word for a cause.
pub(super) fn word(cause: Cause) -> &'static str {
    match cause {
        Cause::Loss => "loss",
        Cause::Saturation => "stroke",
        Cause::Reversal => "reversal",
        Cause::Jump => "jump",
        Cause::Joint => "rail joint",
        Cause::Unknown => "unknown",
    }
}
