//! One exchange.

use std::time::Duration;

use super::super::can::CanFrame;
use super::message;
use super::{CanOpenBus, Exchange, ProcessImage};
use crate::cia402::frames::PDOS;
use crate::device::DeviceError;

impl CanOpenBus {
    pub(super) fn cycle(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        self.reach(now);
        self.listen();
        self.nodes.iter_mut().for_each(|node| node.took_part = false);
        self.check()?;
        self.check_image(image)?;
        let mut working_counter = 0;
        for node in &mut self.nodes {
            working_counter += u16::from(node.hand_over(&mut image.inputs));
        }
        if self.commands {
            self.send_outputs(image)?;
        }
        self.send(&message::sync())?;
        self.beat()?;
        Ok(Exchange { working_counter, expected: self.nodes.len() as u16 })
    }

    /// Refuses the image of another bus, and an exchange before the bus was mapped.
    fn check_image(&self, image: &ProcessImage) -> Result<(), DeviceError> {
        let Some(expected) = self.mapped else {
            return Err(self.error("exchange before the bus was mapped".to_owned()));
        };
        let found = [image.outputs.len(), image.inputs.len()];
        if found == expected {
            return Ok(());
        }
        let reason = format!(
            "process image of {} bytes of outputs and {} of inputs, expected {} and {}: take the image that mapping the bus gave",
            found[0], found[1], expected[0], expected[1]
        );
        Err(self.error(reason))
    }

    /// RPDOs of the nodes that stand; one that has fallen is not commanded any more.
    fn send_outputs(&mut self, image: &ProcessImage) -> Result<(), DeviceError> {
        for place in 0..self.nodes.len() {
            if self.nodes[place].has_fallen {
                continue;
            }
            for k in 0..PDOS {
                let node = &self.nodes[place];
                let Some(bytes) = node.rpdo(usize::from(k), &image.outputs) else { continue };
                let Some(frame) = CanFrame::new(message::rpdo_id(node.id, k), bytes) else { continue };
                self.send(&frame)?;
            }
        }
        Ok(())
    }

    /// The heartbeat of the bench: it comes out of exchanges only, so that a loop that hangs falls silent.
    fn beat(&mut self) -> Result<(), DeviceError> {
        let now = self.link.now();
        if self.heartbeat_due.is_some_and(|due| now < due) {
            return Ok(());
        }
        self.heartbeat_due = Some(now + self.settings.heartbeat());
        self.send(&message::heartbeat(self.settings.own_node))
    }
}
