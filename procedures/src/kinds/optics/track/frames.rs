//! Frames of a video tracker, each once.

use crate::log::{Rows, Window};

/// The tracker measures its target.
const TRACKING: f64 = 2.0;
/// Fewest frames that make a record.
const LEAST_FRAMES: usize = 16;
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
    /// In words: no topic, no channel, no numbers, too few frames, rows that are slower than frames.
    pub(super) fn read(window: &Window, topic: &str, [from_s, to_s]: [f64; 2]) -> Result<Self, String> {
        let rows = window.topic(topic)?;
        let within = rows.range(from_s, to_s);
        let column = |name: &str| -> Result<&[f64], String> {
            let values = rows.channel(name)?;
            match values[within.clone()].iter().all(|v| v.is_finite()) {
                true => Ok(values),
                false => Err(format!("{topic} {name} is no number somewhere")),
            }
        };
        let counter = column("counter")?;
        let age = column("age_s")?;
        let lock = column("lock")?;
        let errors = [column("cross_elevation_rad")?, column("elevation_rad")?];
        let new = |k: &usize| *k > 0 && counter[*k] != counter[*k - 1];
        let row: Vec<usize> = within.clone().filter(new).collect();
        if row.len() < LEAST_FRAMES {
            return Err(format!("{} frames of {topic}, at least {LEAST_FRAMES} are needed", row.len()));
        }
        let pick = |values: &[f64]| -> Vec<f64> { row.iter().map(|&k| values[k]).collect() };
        let first = counter[row[0]];
        let number: Vec<f64> = row.iter().map(|&k| counter[k] - first).collect();
        let time_s: Vec<f64> = row.iter().map(|&k| rows.time_s[k] - age[k]).collect();
        let last = row.len() - 1;
        let period_s = (time_s[last] - time_s[0]) / number[last];
        let ascends = number.windows(2).all(|n| n[1] > n[0]) && time_s.windows(2).all(|t| t[1] > t[0]);
        if !(ascends && period_s > 0.0 && period_s.is_finite()) {
            return Err(format!("frames of {topic} do not follow each other: was the tracker restarted?"));
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
        let counted = self.number.last().map_or(0.0, |n| n + 1.0);
        (counted - self.number.len() as f64).max(0.0) as usize
    }
}

/// Frames that neither came in a row nor are counted as lost on their way were between two rows.
fn unseen(rows: &Rows, row: &[usize], number: &[f64]) -> Result<(), String> {
    let topic = &rows.topic.name;
    let lost = rows.channel("lost_frames")?;
    let last = row.len() - 1;
    let skipped = number[last] - last as f64;
    let unseen = skipped - (lost[row[last]] - lost[row[0]]);
    if unseen > MOST_UNSEEN_RATIO * number[last] {
        return Err(format!("{unseen:.0} frames of {topic} are in no row: log faster than they come"));
    }
    Ok(())
}
