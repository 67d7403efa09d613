//! A bus whose stations are reached one by one, by frames that pass them: what the EtherCAT SubDevices in front of the drives
//! ask of it.

use std::time::Duration;

use super::{Plant, VirtualBus};
use crate::cia402::Drive;
use drivers::wire::BusState;

impl<P: Plant> VirtualBus<P> {
    /// A frame arrives: the world is brought to that instant. False if a fault takes the frame.
    pub(crate) fn frame_arrives(&mut self, now: Duration) -> bool {
        self.advance_to(now);
        !self.lost_frames.takes_next(now)
    }

    /// The inertial unit is triggered at an instant, which must not lie before the last one.
    pub(crate) fn trigger(&mut self, now: Duration) {
        self.advance_to(now);
        self.plant.trigger(now);
    }

    /// A drive, first station 0.
    pub(crate) fn drive(&self, k: usize) -> &Drive {
        &self.stations.as_ref()[k].drive
    }

    /// A drive, first station 0.
    pub(crate) fn drive_mut(&mut self, k: usize) -> &mut Drive {
        &mut self.stations.as_mut()[k].drive
    }

    /// A drive samples its inputs at an instant, which must not lie before the last one.
    pub(crate) fn sample(&mut self, k: usize, now: Duration, inputs: &mut [u8]) {
        self.advance_to(now);
        let shaft_rad = self.plant.shaft_rad(k);
        let station = &mut self.stations.as_mut()[k];
        let seen_rad = station.seen_rad(shaft_rad);
        station.drive.send(self.steps_count, seen_rad, inputs);
    }

    /// A drive takes outputs at an instant, which must not lie before the last one.
    pub(crate) fn take(&mut self, k: usize, now: Duration, outputs: &[u8]) {
        self.advance_to(now);
        self.stations.as_mut()[k].drive.receive(self.steps_count, outputs);
    }

    /// A drive's end of the bus enters a state. In OP it waits for outputs from now on, and not from the last ones.
    pub(crate) fn enter(&mut self, k: usize, state: BusState) {
        let step = self.steps_count;
        let drive = &mut self.stations.as_mut()[k].drive;
        if state == BusState::Op {
            drive.start_watchdog(step);
        }
        drive.set_bus_state(state);
    }
}
