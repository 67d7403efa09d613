//! Interlocks: what is checked every tick, in every state of the sequencer. First out is recorded.
//!
//! One interlock is one row of [`INTERLOCKS`]: a name, what it guards, and a pure function of what the tick sees
//! (with a small memory for those that count). Limits come from the rig file, never from the unit.

use drivers::cia402::{Actuals, PowerState};
use procedures::case::Bounds;

use crate::model::axis::AxisGuard;

mod data;
mod electrical;
mod memory;
mod motion;
mod rows;
mod watch;
mod zone;

pub(crate) use data::{FROZEN_ENCODER, FROZEN_GYRO, LIVENESS, LOG_RING, RATE_FEEDBACK};
pub(crate) use electrical::{BUS_VOLTAGE, UNCOMMANDED_TORQUE};
use memory::Memory;
pub(crate) use motion::{ACCELERATION, BRAKING_CURVE, POSITION, RESTRICTED_ZONE, RUNAWAY};
pub use rows::INTERLOCKS;
pub use watch::{Situation, Watch, per_axis};

/// What an interlock may look at: one axis in one tick.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Limits of the axis.
    pub guard: &'a AxisGuard,
    /// What the drive said.
    pub actuals: &'a Actuals,
    /// What was seen of the axis in the ticks before this one, and in this one.
    pub memory: &'a Memory,
    /// Whether the sequencer expects the drive to be in operation.
    pub expects_operation: bool,
    /// Whether the loop of the axis is closed on the gyro.
    pub uses_gyro: bool,
    /// Digital inputs of the first drive: emergency stop and enabling switch.
    pub rig_inputs: u32,
    /// Position reference less position, where a position loop is closed.
    pub following_error_rad: Option<f64>,
    /// Tighter bounds of this point.
    pub bounds: Option<Bounds>,
    /// How long the target that the axes follow has been missing, and how long it may be; `None` while none is followed.
    pub target_missing_s: Option<(f64, f64)>,
    /// Angle that a stop needs and angle that is left, where no axis could stop in front of a restricted zone.
    pub zone: Option<(f64, f64)>,
    /// How old the sample is.
    pub age_s: f64,
    /// Bad exchanges (no frame, wrong working counter) in a row.
    pub bad_exchanges_in_row: u32,
    /// Bad exchanges among the last 100.
    pub bad_exchanges_in_100: u32,
    /// For how long whatever the velocity loop is closed on has sent no valid sample.
    pub feedback_age_s: f64,
    /// Gyro rate less encoder rate, smoothed; 0 where the loop is closed on the encoder.
    pub feedback_disagreement_rad_per_s: f64,
    /// Periods missed in a row before this tick.
    pub missed_periods: u32,
    /// Longest allowed run of missed periods.
    pub max_missed_periods: u32,
    /// Share of the ring to the log's writer that is taken.
    pub ring_ratio: f64,
    /// Time since the slowest part of the bench gave a sign of life.
    pub silent_s: f64,
}

/// One interlock.
pub struct Interlock {
    /// Name in logs and reports.
    pub name: &'static str,
    /// What it guards against, one sentence.
    pub doc: &'static str,
    /// Unit of `seen` and `limit`.
    pub unit: &'static str,
    /// Whether it looks at something that all axes share: one cause, one trip.
    pub shared: bool,
    /// Whether the bench can still steer the axis to a stop: it sees it, and the drive follows. Where gyro and encoder
    /// contradict each other nobody knows which of them to steer by.
    pub steerable: bool,
    /// `Some((seen, limit))` where it trips.
    pub check: fn(&View<'_>) -> Option<(f64, f64)>,
}

/// What tripped first, as plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    /// Name of the interlock.
    pub interlock: &'static str,
    /// Axis index; `None` for the whole rig.
    pub axis: Option<usize>,
    /// What it saw.
    pub seen: f64,
    /// What it allows.
    pub limit: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// As in [`Interlock::shared`].
    pub shared: bool,
    /// As in [`Interlock::steerable`].
    pub steerable: bool,
}

impl Trip {
    /// One line with numbers.
    pub fn reason(&self, axes: &[String]) -> String {
        let axis = self.axis.and_then(|i| axes.get(i)).map_or("rig", String::as_str);
        let (seen, limit, unit) = readable(self.seen, self.limit, self.unit);
        format!("{axis}: {} {seen} {unit}, limit {limit} {unit}", self.interlock)
    }
}

fn readable(seen: f64, limit: f64, unit: &'static str) -> (String, String, &'static str) {
    let (factor, unit) = match unit {
        "rad" => (180.0 / std::f64::consts::PI, "deg"),
        "rad/s" => (180.0 / std::f64::consts::PI, "deg/s"),
        "rad/s^2" => (180.0 / std::f64::consts::PI, "deg/s^2"),
        "hex" => return (format!("{:04X}h", seen as u16), format!("{:04X}h", limit as u16), ""),
        other => (1.0, other),
    };
    (format!("{:.3}", seen * factor), format!("{:.3}", limit * factor), unit)
}

/// The first interlock that trips on this axis, other than the one that is `known` to have tripped.
pub fn first_out(axis: usize, view: &View<'_>, known: Option<&str>) -> Option<Trip> {
    INTERLOCKS.iter().filter(|lock| Some(lock.name) != known).find_map(|lock| {
        let (seen, limit) = (lock.check)(view)?;
        let &Interlock { name: interlock, unit, shared, steerable, .. } = lock;
        Some(Trip { interlock, axis: Some(axis), seen, limit, unit, shared, steerable })
    })
}

/// Trips above the limit, and on what is not a number.
fn above(seen: f64, limit: f64) -> Option<(f64, f64)> {
    (seen > limit || seen.is_nan()).then_some((seen, limit))
}

/// Trips below the limit, and on what is not a number.
fn below(seen: f64, limit: f64) -> Option<(f64, f64)> {
    (seen < limit || seen.is_nan()).then_some((seen, limit))
}

/// Whether the drive's state is one in which it follows commands.
fn operates(actuals: &Actuals) -> bool {
    PowerState::of(actuals.statusword) == PowerState::OperationEnabled
}

#[cfg(test)]
mod plant;
#[cfg(test)]
mod tests;
