//! What the log holds of a point.

use std::ops::Range;

use super::plan::SEGMENTS_PER_CYCLE;
use crate::log::{PointStatus, Rows, Window};

/// Rows of a topic while segments ran.
pub(super) struct Course<'a> {
    pub(super) time_s: &'a [f64],
    rows: &'a Rows,
    within: Range<usize>,
}

impl<'a> Course<'a> {
    /// The rows of a topic from the first segment's start to the last one's end.
    pub(super) fn of(window: &'a Window, topic: &str) -> Result<Self, String> {
        let rows = window.topic(topic)?;
        let [Some(first), Some(last)] = [window.segments.first(), window.segments.last()] else {
            return Err("no segment ran".to_owned());
        };
        let within = rows.range(first.start_s, last.end_s);
        if within.is_empty() {
            return Err(format!("no rows of {topic} while segments ran"));
        }
        Ok(Self { time_s: &rows.time_s[within.clone()], rows, within })
    }

    /// A column of them; numbers only.
    pub(super) fn column(&self, channel: &str) -> Result<&'a [f64], String> {
        let topic = &self.rows.topic.name;
        let column = self.rows.channel(channel)?;
        let column = &column[self.within.clone()];
        match column.iter().all(|value| value.is_finite()) {
            true => Ok(column),
            false => Err(format!("`{channel}` in {topic} is not a number somewhere")),
        }
    }

    /// Rows between neighbouring instants.
    pub(super) fn between(&self, bounds_s: &[f64]) -> Vec<Range<usize>> {
        let place = |t_s: f64| self.time_s.partition_point(|&t| t < t_s);
        bounds_s.windows(2).map(|pair| place(pair[0])..place(pair[1])).collect()
    }
}

/// Instants at which cycles begin and end, of the cycles that are whole.
pub(super) fn cycle_bounds_s(window: &Window) -> Vec<f64> {
    let mut bounds: Vec<f64> = Vec::new();
    for cycle in window.segments.chunks_exact(SEGMENTS_PER_CYCLE) {
        let start_s = cycle[0].start_s;
        let end_s = cycle[SEGMENTS_PER_CYCLE - 1].end_s;
        if bounds.is_empty() {
            bounds.push(start_s);
        }
        bounds.push(end_s);
    }
    if window.status != PointStatus::Completed && window.segments.len().is_multiple_of(SEGMENTS_PER_CYCLE) {
        // The last one was cut.
        bounds.pop();
    }
    if bounds.len() < 2 { Vec::new() } else { bounds }
}
