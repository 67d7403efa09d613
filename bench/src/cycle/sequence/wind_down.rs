//! From the last segment to the final state: parking where the rig says so, torque off where friction holds.

use std::time::Duration;

use drivers::cia402::PowerState;

use super::{Sequencer, State};
use crate::rig::ArmedRig;

/// Longest wait for a drive to give up its torque (safety.md: CiA 402 step).
const DISABLE_LIMIT_S: f64 = 2.0;
/// Longest slow move: from end to end of any travel, and time to settle.
const SLOW_MOVE_LIMIT_S: f64 = 180.0;

impl Sequencer<'_> {
    /// All segments ran.
    pub(super) fn wind_down(&mut self, now: Duration, rig: &ArmedRig) {
        let mut parks = false;
        if self.parks && !self.case.open_loop {
            for (axis, axis_loop) in self.loops.iter_mut().enumerate() {
                if let Some(pose_rad) = rig.axes()[axis].guard.safety.safe_pose_rad {
                    axis_loop.go_slowly(rig.actuals(axis), pose_rad);
                    parks = true;
                }
            }
        }
        if parks { self.go(State::Parking, now) } else { self.parked(now, rig) }
    }

    pub(super) fn park(&mut self, now: Duration, rig: &ArmedRig) {
        let there = (0..self.loops.len()).all(|axis| self.loops[axis].stopped(rig.actuals(axis)));
        // One that does not arrive is held where it is: nothing is released that was not parked.
        if there || self.waited_s(now) > self.slow_move_limit_s() {
            self.parked(now, rig);
        }
    }

    fn parked(&mut self, now: Duration, rig: &ArmedRig) {
        for (axis, releases) in self.releases.iter_mut().enumerate() {
            *releases = crate::cycle::safe::may_release(&rig.axes()[axis], rig.actuals(axis));
        }
        let orderly = self.releases.contains(&true) && !self.case.open_loop;
        self.go(if orderly { State::Disabling } else { State::Finished }, now);
    }

    pub(super) fn disable(&mut self, now: Duration, rig: &ArmedRig) {
        let off = |axis: usize| {
            let state = PowerState::of(rig.actuals(axis).statusword);
            !matches!(state, PowerState::OperationEnabled | PowerState::QuickStopActive)
        };
        let done = (0..self.loops.len()).all(|axis| !self.releases[axis] || off(axis));
        if done || self.waited_s(now) > DISABLE_LIMIT_S {
            self.go(State::Finished, now);
        }
    }

    pub(super) fn slow_move_limit_s(&self) -> f64 {
        SLOW_MOVE_LIMIT_S
    }
}
