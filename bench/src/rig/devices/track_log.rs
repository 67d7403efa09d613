//! The rows of the loops that are closed on trackers.

use std::time::Duration;

use drivers::device::DeviceError;

use crate::rig::device::{Device, Group, LookedAt};
use crate::rig::tracking::Tracking;
use crate::rig::wires::Ports;

/// What the track loops did last. It hangs on no port: it has its place in the list for the sake of the log.
#[derive(Default)]
pub struct TrackLog {
    row: [f64; 8],
}

impl TrackLog {
    /// Takes what the loops did in this tick, in the order of [`Tracking::CHANNELS`].
    pub(super) fn take(&mut self, row: [f64; 8]) {
        self.row = row;
    }
}

impl Device for TrackLog {
    fn name(&self) -> &str {
        "track loops"
    }

    fn open(&mut self, _ports: &mut Ports, _now: Duration) -> Result<Option<()>, DeviceError> {
        Ok(Some(()))
    }

    fn poll(&mut self, _ports: &mut Ports, _now: Duration) -> Result<(), DeviceError> {
        Ok(())
    }

    fn group(&self) -> Group {
        Group { topic: "track", message: "Tracking", channels: Tracking::CHANNELS }
    }

    fn is_looked_at(&self, looked_at: LookedAt) -> bool {
        looked_at.trackers
    }

    fn row(&mut self, row: &mut [f64]) {
        row[..self.row.len()].copy_from_slice(&self.row);
    }

    fn track_log(&mut self) -> Option<&mut TrackLog> {
        Some(self)
    }
}
