//! Shutting a bus down in order: OP, SAFE-OP, PRE-OP, INIT.

use std::time::Duration;

use super::EtherCatBus;
use super::al::{self, AlState};
use crate::device::DeviceError;

/// Longest wait for one step down.
const STEP_LIMIT: Duration = Duration::from_millis(500);
/// Time between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(1);

impl EtherCatBus {
    /// Brings all stations down to INIT, one state after the other. Takes at most 1.5 s.
    ///
    /// # Errors
    /// When a station does not follow; the others have been brought down as far as they go.
    pub fn close(mut self) -> Result<(), DeviceError> {
        self.shut_down()
    }

    fn shut_down(&mut self) -> Result<(), DeviceError> {
        self.is_closed = true;
        for target in [AlState::SafeOp, AlState::PreOp, AlState::Init] {
            self.lower(target)?;
        }
        self.supervisor.set_all(AlState::Init);
        Ok(())
    }

    /// Brings every station that is higher down to `target`.
    fn lower(&mut self, target: AlState) -> Result<(), DeviceError> {
        let deadline = self.pump.link.now() + STEP_LIMIT;
        for k in 0..self.stations.len() {
            let address = self.stations[k].configured_address;
            let mut is_asked = false;
            loop {
                let [status, ..] = self.read_register::<6>(address, al::STATUS)?;
                let state = AlState::of(status);
                if state <= target {
                    break;
                }
                let now = self.pump.link.now();
                if now >= deadline {
                    let (number, name) = (self.stations[k].station, state.name());
                    let target = target.name();
                    return Err(self
                        .failure(format!("station {number} stays in {name} instead of going to {target}")));
                }
                if !is_asked {
                    self.write_register(address, al::CONTROL, &[target as u8 | (status & al::ERROR), 0])?;
                    is_asked = true;
                }
                self.pump.reach(now + LOOK_EVERY).map_err(|error| self.failure(error.to_string()))?;
            }
        }
        Ok(())
    }
}

impl Drop for EtherCatBus {
    fn drop(&mut self) {
        if !self.is_closed {
            // Nobody is left to tell; the stations' own watchdogs stop what still moves.
            let _ = self.shut_down();
        }
    }
}
