//! The interlocks of a rig, tick by tick: what they see, what they remember, which was first.

use procedures::case::Bounds;

use super::{Trip, View, first_out};
use crate::rig::ArmedRig;

/// What the loop knows in a tick beside the rig itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Situation {
    /// Whether valid inputs have not come yet: nothing can be checked, nothing can move.
    pub waits_for_inputs: bool,
    /// Whether the drives must be in operation now.
    pub expects_operation: bool,
    /// Whether the loops are closed on the gyro (a stop is closed on the encoder).
    pub uses_feedback: bool,
    /// Position reference less position per axis, where a position loop is closed.
    pub following_error_rad: [Option<f64>; 2],
    /// Tighter bounds of this point.
    pub bounds: Option<Bounds>,
    /// Periods missed in a row before this tick.
    pub missed_periods: u32,
    /// Longest allowed run of missed periods.
    pub max_missed_periods: u32,
    /// Share of the ring to the log's writer that is taken.
    pub ring_ratio: f64,
    /// Time since the slowest part of the bench gave a sign of life.
    pub silent_s: f64,
}

/// Every interlock of every axis.
#[derive(Clone, Debug)]
pub struct Watch {
    period_s: f64,
}

impl Watch {
    /// Nothing seen yet.
    pub fn new(period_s: f64) -> Self {
        Self { period_s }
    }

    /// Once a tick, after the exchange: the first interlock that trips and is not the `latched` one.
    ///
    /// What was seen does not vanish in one tick: what has tripped is not told twice, and what both axes share must not
    /// count as a second trip when the other axis sees it, too.
    pub fn tick(&mut self, rig: &ArmedRig, situation: &Situation, latched: Option<&Trip>) -> Option<Trip> {
        if situation.waits_for_inputs {
            return None;
        }
        let (bad_exchanges_in_row, bad_exchanges_in_100) = rig.bad_exchanges();
        (0..rig.axes().len()).find_map(|axis| {
            let view = View {
                guard: &rig.axes()[axis].guard,
                actuals: rig.actuals(axis),
                expects_operation: situation.expects_operation,
                age_s: f64::from(rig.age_ticks(axis)) * self.period_s,
                bad_exchanges_in_row,
                bad_exchanges_in_100,
                missed_periods: situation.missed_periods,
                feedback_age_s: f64::from(rig.feedback(axis).1) * self.period_s,
                feedback_disagreement_rad_per_s: rig.feedback_disagreement(axis),
                max_missed_periods: situation.max_missed_periods,
            };
            let same = |t: &&Trip| t.axis == Some(axis) || t.shared;
            first_out(axis, &view, latched.filter(same).map(|t| t.interlock))
        })
    }
}
