//! Drives that follow SYNC0, as distributed clocks have it (ETG.1020): at each pulse they take the outputs of the last frame and
//! sample the inputs that the next frame carries away.
//!
//! A frame that passes `shift` after a pulse brings inputs of that age, and its outputs wait for the next pulse. From sample to
//! effect that is one cycle more than on a bus whose drives act when the frame passes.

use std::time::Duration;

use super::{Plant, VirtualBus};
use drivers::wire::{BusState, ProcessImage};

/// Pulses, and what waits for them. The pulses stand in a fixed grid of world time, `shift` before the multiples of the cycle.
#[derive(Debug)]
pub(super) struct Sync0 {
    cycle: Duration,
    next_pulse: Duration,
    /// Inputs of all stations as they were at the last pulse.
    sampled: Vec<u8>,
    /// Outputs of the last frame.
    outputs: Vec<u8>,
    /// They were not taken yet.
    outputs_wait: bool,
}

impl Sync0 {
    pub(super) fn new(cycle: Duration, shift: Duration) -> Self {
        let next_pulse = cycle.saturating_sub(shift);
        Self { cycle, next_pulse, sampled: Vec::new(), outputs: Vec::new(), outputs_wait: false }
    }

    /// Room for a process image.
    pub(super) fn lay_out(&mut self, image: &ProcessImage) {
        self.sampled = vec![0; image.inputs.len()];
        self.outputs = vec![0; image.outputs.len()];
        self.outputs_wait = false;
    }

    /// The next pulse, if it comes by `now`.
    pub(super) fn next_by(&mut self, now: Duration) -> Option<Duration> {
        if self.next_pulse > now {
            return None;
        }
        let pulse = self.next_pulse;
        self.next_pulse += self.cycle;
        Some(pulse)
    }
}

impl<P: Plant> VirtualBus<P> {
    /// From now on the drives follow SYNC0 with this cycle; frames are meant to pass `shift` after each pulse.
    pub(crate) fn follow_sync0(&mut self, cycle: Duration, shift: Duration) {
        self.sync0 = Some(Sync0::new(cycle, shift));
    }

    /// A pulse at the step that the world has reached: outputs first, as the hardware has it.
    pub(super) fn give_sync0(&mut self) {
        let Some(sync0) = &mut self.sync0 else { return };
        let takes = std::mem::take(&mut sync0.outputs_wait);
        for (k, station) in self.stations.as_mut().iter_mut().enumerate() {
            if !self.mapped || station.drive.bus_state() < BusState::SafeOp {
                continue;
            }
            let slot = station.slot.clone();
            if takes {
                station.drive.receive(self.steps_count, &sync0.outputs[slot.outputs]);
            }
            let seen_rad = station.seen_rad(self.plant.shaft_rad(k));
            station.drive.send(self.steps_count, seen_rad, &mut sync0.sampled[slot.inputs]);
        }
    }

    /// A frame passes: it takes along what was sampled, and leaves its outputs. Returns the number of stations that it passed,
    /// `None` where drives act when the frame passes.
    pub(super) fn pass_between_pulses(&mut self, image: &mut ProcessImage) -> Option<u16> {
        let sync0 = self.sync0.as_mut()?;
        let mut stations_count = 0;
        for station in self.stations.as_mut() {
            if station.drive.bus_state() < BusState::SafeOp {
                continue;
            }
            stations_count += 1;
            let slot = station.slot.clone();
            image.inputs[slot.inputs.clone()].copy_from_slice(&sync0.sampled[slot.inputs]);
            sync0.outputs[slot.outputs.clone()].copy_from_slice(&image.outputs[slot.outputs]);
            if self.op_requested {
                station.drive.start_watchdog(self.steps_count);
                station.drive.set_bus_state(BusState::Op);
            }
        }
        sync0.outputs_wait = true;
        Some(stations_count)
    }
}
