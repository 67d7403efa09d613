//! An analog terminal on the bus of the drives, in this process: what its ports write leaves with the next frame, and what they
//! read came with the last one.

use super::{Plant, VirtualBus};

/// Analog outputs of the terminal.
const OUTPUTS: usize = 4;
/// Analog inputs of the terminal.
const INPUTS: usize = 10;

/// Voltages of the terminal on their way.
#[derive(Clone, Debug, Default)]
pub(super) struct Terminal {
    /// Outputs that were written since the last frame.
    written_v: [Option<f64>; OUTPUTS],
    /// Outputs that the last frame has brought, for the next pulse.
    sent_v: [Option<f64>; OUTPUTS],
    /// Inputs at the last pulse.
    sampled_v: [f64; INPUTS],
    /// Inputs that the last frame has taken along.
    seen_v: [f64; INPUTS],
}

impl<P: Plant> VirtualBus<P> {
    /// From now on there is a terminal behind the drives.
    pub(crate) fn add_terminal(&mut self) {
        self.terminal.get_or_insert_default();
    }

    /// An output of the terminal gets a voltage with the next frame; false where there is no such output.
    pub(crate) fn write_terminal_v(&mut self, output: usize, volts: f64) -> bool {
        let place = self.terminal.as_mut().and_then(|terminal| terminal.written_v.get_mut(output));
        place.map(|place| *place = Some(volts)).is_some()
    }

    /// Voltage at an input of the terminal, as the last frame has brought it; `None` where there is no such input.
    pub(crate) fn terminal_v(&self, input: usize) -> Option<f64> {
        self.terminal.as_ref().and_then(|terminal| terminal.seen_v.get(input).copied())
    }

    /// A frame passes the terminal, which acts at once or, if the drives follow SYNC0, at the pulses.
    pub(super) fn pass_terminal(&mut self) {
        let Some(terminal) = &mut self.terminal else { return };
        for (sent, written) in terminal.sent_v.iter_mut().zip(&mut terminal.written_v) {
            *sent = written.take().or(*sent);
        }
        if self.sync0.is_none() {
            self.pulse_terminal();
        }
        if let Some(terminal) = &mut self.terminal {
            terminal.seen_v = terminal.sampled_v;
        }
    }

    /// The terminal puts its outputs out and samples its inputs, at the instant that the world has reached.
    pub(super) fn pulse_terminal(&mut self) {
        let Some(terminal) = &mut self.terminal else { return };
        for (output, volts) in terminal.sent_v.iter_mut().enumerate() {
            if let Some(volts) = volts.take() {
                self.plant.write_v(self.now, output, volts);
            }
        }
        for (input, volts) in terminal.sampled_v.iter_mut().enumerate() {
            *volts = self.plant.read_v(self.now, input).unwrap_or(0.0);
        }
    }
}
