//! Temperatures of heat sinks that drives tell by SDO alone: one reading at a time, between everything else.

use std::time::Duration;

use drivers::cia402::{Actuals, PowerState};

use super::ArmedRig;

/// States of a drive in which its temperature is asked for: not on the way up, and not in a fault.
const SETTLED: [PowerState; 3] =
    [PowerState::SwitchOnDisabled, PowerState::OperationEnabled, PowerState::QuickStopActive];

impl ArmedRig {
    /// Goes on with the reading that is under way, or begins the next one that is due. Nothing begins while a point is given
    /// its settings, and none while a drive is being enabled or has a fault.
    pub(super) fn poll_heat_sinks(&mut self, now: Duration) {
        let is_settled = |actuals: &Actuals| SETTLED.contains(&PowerState::of(actuals.statusword));
        let may_start = self.wanted.is_none() && self.actuals.iter().all(is_settled);
        for (index, drive) in self.drives.iter_mut().enumerate() {
            // One at a time: the drives share a bus.
            let is_free = self.reads_heat_sink.is_none();
            if drive.poll_heat_sink(&mut *self.bus, now, may_start && is_free) {
                self.reads_heat_sink = Some(index);
            } else if self.reads_heat_sink == Some(index) {
                self.reads_heat_sink = None;
            }
        }
    }
}
