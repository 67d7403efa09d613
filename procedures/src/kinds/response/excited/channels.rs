//! Signals of an excited axis in the log.

use crate::axis::{Axes, says_limited};
use crate::log::{Rows, Window};
use crate::measurement::Evidence;

/// What is read beside the excitation itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::kinds) enum Channel {
    /// Command of the velocity loop less the rate that it was closed on, rad/s.
    Error,
    /// Rate that the velocity loop was closed on, rad/s.
    Rate,
    /// Torque that was sent, N·m.
    Torque,
    /// Torque that the drive shows, from its current, N·m.
    Shown,
    /// Angle of the shaft by the encoder, rad.
    Angle,
    /// Rate of the other axis, rad/s.
    OtherRate,
    /// What the track loop asks of the velocity loop, before the excitation is added, rad/s.
    Asked,
    /// Command of the velocity loop, with the excitation, rad/s.
    Commanded,
}

/// Columns of one point.
pub(in crate::kinds) struct Record<'a> {
    rows: &'a Rows,
    pub(super) time_s: &'a [f64],
    pub(super) excitation: &'a [f64],
    pub(in crate::kinds) angle_rad: &'a [f64],
    pub(in crate::kinds) rate: &'a [f64],
    pub(super) torque_nm: &'a [f64],
    command: &'a [f64],
    asked: Option<&'a [f64]>,
    current_a: &'a [f64],
    /// Status of the drive, where the log has it.
    statusword: Option<&'a [f64]>,
    other: Option<&'a [f64]>,
    torque_constant: f64,
}

impl<'a> Record<'a> {
    /// The columns, or which of them is missing or holds something that is no number.
    pub(in crate::kinds) fn new(axis: &str, window: &'a Window, axes: &Axes) -> Result<Self, String> {
        let limits = axes.limits(axis)?;
        let topic = format!("/{axis}");
        let rows = window.topic(&topic)?;
        let column = |name: &str| rows.finite_channel(name);
        let other = axes.gimbal().ok().and_then(|gimbal| gimbal.other(axis));
        let other = other.and_then(|name| window.rows(&format!("/{name}")));
        let other = other.and_then(|rows| rows.column("velocity_feedback_rad_per_s"));
        Ok(Self {
            rows,
            time_s: &rows.time_s,
            excitation: column("excitation")?,
            angle_rad: column("position_rad")?,
            rate: column("velocity_feedback_rad_per_s")?,
            torque_nm: column("torque_command_nm")?,
            command: column("velocity_command_rad_per_s")?,
            asked: rows.column("velocity_setpoint_rad_per_s").filter(|a| a.iter().all(|v| v.is_finite())),
            current_a: column("current_a")?,
            statusword: rows.column("statusword"),
            other: other.filter(|o| o.len() == rows.time_s.len() && o.iter().all(|v| v.is_finite())),
            torque_constant: limits.torque_constant_nm_per_a.unwrap_or(1.0),
        })
    }

    /// Values of a channel in a range of rows.
    pub(super) fn values(&self, channel: Channel, range: std::ops::Range<usize>) -> Option<Vec<f64>> {
        let part = |column: &[f64]| column[range.clone()].to_vec();
        Some(match channel {
            Channel::Error => range.clone().map(|row| self.command[row] - self.rate[row]).collect(),
            Channel::Rate => part(self.rate),
            Channel::Torque => part(self.torque_nm),
            Channel::Shown => part(self.current_a).iter().map(|a| a * self.torque_constant).collect(),
            Channel::Angle => part(self.angle_rad),
            Channel::OtherRate => part(self.other?),
            Channel::Asked => part(self.asked?),
            Channel::Commanded => part(self.command),
        })
    }

    /// Whether the drive was at a limit of its own in any of these rows.
    pub(super) fn is_limited(&self, range: std::ops::Range<usize>) -> bool {
        self.statusword.is_some_and(|words| says_limited(&words[range]))
    }

    /// First row at or after a time.
    pub(super) fn row_at(&self, t_s: f64) -> usize {
        self.rows.range(t_s, f64::INFINITY).start
    }

    /// Where the numbers of the point come from.
    pub(in crate::kinds) fn evidence(&self) -> Vec<Evidence> {
        let (Some(t0), Some(t1)) = (self.time_s.first(), self.time_s.last()) else { return Vec::new() };
        let topic = &self.rows.topic.name;
        let names =
            ["excitation", "velocity_command_rad_per_s", "velocity_feedback_rad_per_s", "torque_command_nm"];
        let channels = names.iter().map(|name| format!("{topic} {name}")).collect();
        vec![Evidence::new(channels, [*t0, *t1])]
    }
}
