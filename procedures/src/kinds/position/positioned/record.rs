//! Rows of a moved axis.

use std::ops::Range;

use crate::case::Case;
use crate::log::{Rows, SegmentSpan, Window};
use crate::measurement::Evidence;
use crate::reason::Reason;

/// The columns of one point.
pub(in crate::kinds) struct Record<'a> {
    rows: &'a Rows,
    pub(in crate::kinds) time_s: &'a [f64],
    /// By the encoder.
    pub(in crate::kinds) position_rad: &'a [f64],
    /// Command of the position loop.
    pub(in crate::kinds) setpoint_rad: &'a [f64],
    /// Rate that the velocity loop was closed on.
    pub(in crate::kinds) rate_rad_per_s: &'a [f64],
    /// Torque that was sent.
    pub(in crate::kinds) sent_nm: &'a [f64],
    /// Torque that the drive shows, from its current.
    pub(in crate::kinds) shown_nm: &'a [f64],
}

impl<'a> Record<'a> {
    /// The columns, or which of them is missing or holds something that is no number.
    pub(in crate::kinds) fn new(axis: &str, window: &'a Window) -> Result<Self, Reason> {
        let topic = format!("/{axis}");
        let rows = window.topic(&topic)?;
        let column = |name: &str| rows.finite_channel(name);
        Ok(Self {
            rows,
            time_s: &rows.time_s,
            position_rad: column("position_rad")?,
            setpoint_rad: column("position_setpoint_rad")?,
            rate_rad_per_s: column("velocity_feedback_rad_per_s")?,
            sent_nm: column("torque_command_nm")?,
            shown_nm: column("torque_nm")?,
        })
    }

    /// The segments of a label that ran, in order.
    pub(in crate::kinds) fn spans<'w>(case: &Case, window: &'w Window, label: &str) -> Vec<&'w SegmentSpan> {
        let named = |span: &&SegmentSpan| case.segments.get(span.segment).is_some_and(|s| s.label == label);
        window.segments.iter().filter(named).collect()
    }

    /// Rows in a stretch of time.
    pub(in crate::kinds) fn range(&self, start_s: f64, end_s: f64) -> Range<usize> {
        self.rows.range(start_s, end_s)
    }

    /// Mean place over a stretch of time; `None` if there are no rows.
    pub(in crate::kinds) fn mean_rad(&self, start_s: f64, end_s: f64) -> Option<f64> {
        mean(&self.position_rad[self.range(start_s, end_s)])
    }

    /// Places at instants, on straight lines between the rows; `None` beyond their ends.
    pub(in crate::kinds) fn places_rad(&self, at_s: impl Iterator<Item = f64>) -> Option<Vec<f64>> {
        at_s.map(|t| interpolated(self.time_s, self.position_rad, t)).collect()
    }

    /// Where numbers of a stretch of time come from.
    pub(in crate::kinds) fn evidence(&self, channels: &[&str], [t0_s, t1_s]: [f64; 2]) -> Vec<Evidence> {
        let topic = &self.rows.topic.name;
        let channels = channels.iter().map(|name| format!("{topic} {name}")).collect();
        vec![Evidence::new(channels, [t0_s, t1_s])]
    }
}

/// Mean place of an axis over a stretch of time, by its encoder; `None` if the log does not hold it.
pub(in crate::kinds) fn mean_rad(window: &Window, axis: &str, [start_s, end_s]: [f64; 2]) -> Option<f64> {
    let rows = window.rows(&format!("/{axis}"))?;
    mean(&rows.finite_channel("position_rad").ok()?[rows.range(start_s, end_s)])
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// A value between two samples; `None` beyond the ends.
pub(in crate::kinds) fn interpolated(x: &[f64], y: &[f64], at: f64) -> Option<f64> {
    let after = x.partition_point(|&x| x < at);
    if after < x.len() && x[after] == at {
        return Some(y[after]);
    }
    let before = after.checked_sub(1).filter(|_| after < x.len())?;
    let ratio = (at - x[before]) / (x[after] - x[before]);
    Some(y[before] + ratio * (y[after] - y[before]))
}
