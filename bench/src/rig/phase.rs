//! Ticks in phase with the clock of the bus, such as the SYNC0 pulses of an EtherCAT wire.

use std::time::Duration;

use crate::clock::Clock;
use crate::model::axis::RigAxis;
use crate::realtime::PhaseLock;

/// The loop's clock, and what keeps it in phase with that of the bus.
pub(super) struct Phase {
    clock: Clock,
    lock: PhaseLock,
}

impl Phase {
    /// Keeps a loop of these axes in phase; `None` in virtual time, which has no phase.
    pub(super) fn of(clock: &Clock, axes: &[RigAxis]) -> Option<Self> {
        let period = Duration::from_secs_f64(axes.first()?.drive.cycle_s);
        (!clock.is_virtual()).then(|| Self { clock: clock.clone(), lock: PhaseLock::new(period) })
    }

    /// Shifts the ticks to come by what an exchange passed too late by the clock of the bus.
    pub(super) fn follow(&mut self, late_ns: Option<i64>) {
        if let Some(late_ns) = late_ns {
            self.clock.nudge(self.lock.step(late_ns));
        }
    }
}
