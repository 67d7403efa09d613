//! Interlocks: what is checked every tick, in every state of the sequencer. The first one to trip is recorded (first out).
//!
//! One interlock is one row of [`INTERLOCKS`]: a name, what it guards against, and a pure function of the [`View`] of one
//! axis in one tick. Interlocks on what lasts use [`View::memory`]. Limits come from the rig file, never from the unit file.

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

pub(crate) use data::{FROZEN_ENCODER, FROZEN_GYRO, LIVENESS, LOG_RING, RATE_FEEDBACK, TRACKER_LOST};
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
    /// Newest actual values of the drive.
    pub actuals: &'a Actuals,
    /// History of the axis up to and including this tick.
    pub memory: &'a Memory,
    /// Whether the sequencer expects the drive to be in operation.
    pub expects_operation: bool,
    /// Whether the loop of the axis is closed on the gyro.
    pub uses_gyro: bool,
    /// Digital inputs (60FDh) of the first drive, to which emergency stop and enabling switch are wired.
    pub rig_inputs: u32,
    /// Whether the emergency stop chain is open by the input of a terminal; `false` where it is wired to a drive.
    pub emergency_stop_is_open: bool,
    /// Position reference minus actual position; `None` where no position loop is closed.
    pub following_error_rad: Option<f64>,
    /// Bounds of displacement and speed for this point alone, tighter than the limits of the rig.
    pub bounds: Option<Bounds>,
    /// Time for which the followed target has been missing, and the longest time allowed. `None` while no target is
    /// followed.
    pub target_missing_s: Option<(f64, f64)>,
    /// Angle that a stop of the axis needs and angle left to the restricted zone, rad. `None` as long as one axis of the
    /// gimbal can still stop in front of each zone.
    pub zone: Option<(f64, f64)>,
    /// Age of `actuals`.
    pub age_s: f64,
    /// Bad exchanges (no frame, wrong working counter) in a row.
    pub bad_exchanges_in_row: u32,
    /// Bad exchanges among the last 100.
    pub bad_exchanges_in_100: u32,
    /// Time since the sensor that the velocity loop is closed on last sent a valid sample.
    pub feedback_age_s: f64,
    /// Gyro rate minus encoder rate, smoothed; 0 where the loop is closed on the encoder.
    pub feedback_disagreement_rad_per_s: f64,
    /// Periods missed in a row before this tick.
    pub missed_periods: u32,
    /// Longest allowed run of missed periods.
    pub max_missed_periods: u32,
    /// Fill level of the ring buffer to the log writer, 0 to 1.
    pub ring_ratio: f64,
    /// Longest time for which any watched part of the bench has given no sign of life.
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
    /// Whether it checks something that all axes share. Then the trips of several axes have one cause and count as one.
    pub shared: bool,
    /// Whether the bench can still bring the axis to a controlled stop after a trip: feedback can be trusted, and the drive
    /// obeys. Example for `false`: gyro and encoder contradict each other, and nobody knows which one is right.
    pub steerable: bool,
    /// `Some((seen, limit))` where it trips.
    pub check: fn(&View<'_>) -> Option<(f64, f64)>,
}

/// The trip of one interlock, as plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    /// Name of the interlock.
    pub interlock: &'static str,
    /// Axis index; `None` for the whole rig.
    pub axis: Option<usize>,
    /// Value that violated the limit.
    pub seen: f64,
    /// The limit.
    pub limit: f64,
    /// Unit of `seen` and `limit`.
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

/// Both values as text with the unit that people read: degrees for radians, no unit for words of bits (`hex`).
fn readable(seen: f64, limit: f64, unit: &'static str) -> (String, String, &'static str) {
    const DEG_PER_RAD: f64 = 180.0 / std::f64::consts::PI;
    let (factor, unit) = match unit {
        "rad" => (DEG_PER_RAD, "deg"),
        "rad/s" => (DEG_PER_RAD, "deg/s"),
        "rad/s^2" => (DEG_PER_RAD, "deg/s^2"),
        "hex" => return (format!("{:04X}h", seen as u16), format!("{:04X}h", limit as u16), ""),
        other => (1.0, other),
    };
    (format!("{:.3}", seen * factor), format!("{:.3}", limit * factor), unit)
}

/// The first interlock that trips on this axis, other than the one that is `known` to have tripped.
pub fn first_out(axis: usize, view: &View<'_>, known: Option<&str>) -> Option<Trip> {
    INTERLOCKS.iter().filter(|interlock| Some(interlock.name) != known).find_map(|interlock| {
        let (seen, limit) = (interlock.check)(view)?;
        let &Interlock { name, unit, shared, steerable, .. } = interlock;
        Some(Trip { interlock: name, axis: Some(axis), seen, limit, unit, shared, steerable })
    })
}

/// `Some((seen, limit))` where `seen` is above the limit. NaN trips, too: a value that is not known is not safe.
fn above(seen: f64, limit: f64) -> Option<(f64, f64)> {
    (seen > limit || seen.is_nan()).then_some((seen, limit))
}

/// `Some((seen, limit))` where `seen` is below the limit. NaN trips, too.
fn below(seen: f64, limit: f64) -> Option<(f64, f64)> {
    (seen < limit || seen.is_nan()).then_some((seen, limit))
}

/// Whether the drive follows commands: its state is "operation enabled".
fn operates(actuals: &Actuals) -> bool {
    PowerState::of(actuals.statusword) == PowerState::OperationEnabled
}

#[cfg(test)]
mod plant;
#[cfg(test)]
mod tests;
