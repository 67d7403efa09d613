//! Leaving a bus in order: OP, SAFE-OP, and where nothing is held any more PRE-OP and INIT.

use std::time::Duration;

use super::EtherCatBus;
use super::al::{self, AlState};
use crate::device::DeviceError;

/// Longest wait for one step down.
const STEP_LIMIT: Duration = Duration::from_millis(500);
/// Time between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(1);

impl EtherCatBus {
    /// Brings all stations down to INIT, one state after the other; for a rig on which no axis is held by its drive. Takes at
    /// most 1.5 s, and 40 ms for each station that does not answer.
    ///
    /// # Errors
    /// When a station does not follow; the others have been brought down as far as they go.
    pub fn close(mut self) -> Result<(), DeviceError> {
        self.shut_down(&[AlState::SafeOp, AlState::PreOp, AlState::Init])
    }

    fn shut_down(&mut self, steps: &[AlState]) -> Result<(), DeviceError> {
        self.is_closed = true;
        let mut present: Vec<usize> = (0..self.stations.len()).collect();
        let mut outcome = Ok(());
        for &target in steps {
            let deadline = self.pump.link.now() + STEP_LIMIT;
            // All are asked before any is waited for: a station must not miss its outputs meanwhile.
            for step in [Self::ask_down, Self::wait_down] {
                present.retain(|&k| {
                    let done = step(self, k, target, deadline);
                    let is_done = done.is_ok();
                    if outcome.is_ok() {
                        outcome = done;
                    }
                    is_done
                });
            }
        }
        outcome
    }

    /// Asks a station that is higher for `target`.
    fn ask_down(&mut self, k: usize, target: AlState, _deadline: Duration) -> Result<(), DeviceError> {
        let address = self.stations[k].configured_address;
        let [status, ..] = self.read_register::<6>(address, al::STATUS)?;
        if AlState::of(status) <= target {
            return Ok(());
        }
        self.write_register(address, al::CONTROL, &[target as u8 | (status & al::ERROR), 0])
    }

    /// Waits until a station is no higher than `target`.
    fn wait_down(&mut self, k: usize, target: AlState, deadline: Duration) -> Result<(), DeviceError> {
        let address = self.stations[k].configured_address;
        loop {
            let [status, ..] = self.read_register::<6>(address, al::STATUS)?;
            let state = AlState::of(status);
            if state <= target {
                return Ok(());
            }
            let now = self.pump.link.now();
            if now >= deadline {
                let number = self.stations[k].station;
                let [state, target] = [state, target].map(AlState::name);
                return Err(
                    self.failure(format!("station {number} stays in {state} instead of going to {target}"))
                );
            }
            self.pump.reach(now + LOOK_EVERY).map_err(|error| self.failure(error.to_string()))?;
        }
    }
}

impl Drop for EtherCatBus {
    /// Stations stay in SAFE-OP, unless nothing is held any more: a drive that holds its axis in quick stop goes on holding it
    /// there, and lets go below.
    fn drop(&mut self) {
        if self.is_closed {
            return;
        }
        let steps = [AlState::SafeOp, AlState::PreOp, AlState::Init];
        // Nobody is left to tell; the stations' own watchdogs stop what still moves.
        let _ = self.shut_down(if self.is_free { &steps } else { &steps[..1] });
    }
}
