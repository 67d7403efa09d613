//! What hangs on the analog channels of the bench, whoever carries their voltages: see [`crate::analog_card`].

use std::time::Duration;

use drivers::reader::{Measured, Readings};

use super::Director;
use crate::analog_card::{
    CLAMP_INPUTS, ECHO_INPUT, ECHO_OUTPUT, FORCE_INPUT, POLYGON_INPUTS, REFERENCE_INPUTS, SYNC_OUTPUT,
};
use crate::payload::MIRROR_AXES;

impl Director {
    /// An output takes a voltage; false where there is no such output.
    pub(super) fn take_v(&mut self, now: Duration, output: usize, volts: f64) -> bool {
        match output {
            0..MIRROR_AXES => self.payload.mirror.command_analog_v(output, volts),
            SYNC_OUTPUT => self.instruments.scope.sync(now, volts),
            ECHO_OUTPUT => self.instruments.channels.write_echo(now, volts),
            _ => return false,
        }
        true
    }

    /// Voltage at an input; `None` where there is no such input.
    pub(super) fn give_v(&mut self, now: Duration, input: usize) -> Option<f64> {
        let channels = &mut self.instruments.channels;
        match input {
            0..MIRROR_AXES => return Some(self.payload.mirror.mirror().gauge_v()[input]),
            ECHO_INPUT => return Some(channels.echo_v(now)),
            FORCE_INPUT => {
                let pulled_nm = self.pulled_nm();
                return Some(self.instruments.channels.force_v(now, pulled_nm));
            }
            _ => {}
        }
        let place = |inputs: [usize; 2]| inputs.iter().position(|&own| own == input);
        if let Some(axis) = place(REFERENCE_INPUTS) {
            let tilt_rad = self.payload.mirror.mirror().angle_rad()[axis];
            return Some(channels.reference_v(axis, now, tilt_rad));
        }
        if let Some(axis) = place(POLYGON_INPUTS) {
            let angle_rad = self.truth_of_axes().angle_rad[axis];
            return Some(self.instruments.channels.polygon_v(axis, now, angle_rad));
        }
        let clamp = place(CLAMP_INPUTS)?;
        let current_a = self.dc_link_a()[clamp];
        Some(self.instruments.channels.clamp_v(clamp, now, current_a))
    }

    /// What the autocollimators at the polygons and the force gauge show to an instrument that sends its readings as text.
    pub(crate) fn readings(&mut self, now: Duration) -> Readings {
        let angles_rad = self.truth_of_axes().angle_rad;
        let pulled_nm = self.pulled_nm();
        let channels = &mut self.instruments.channels;
        Readings::default()
            .with(Measured::Azimuth, channels.polygon_rad(0, now, angles_rad[0]))
            .with(Measured::Elevation, channels.polygon_rad(1, now, angles_rad[1]))
            .with(Measured::Force, Some(channels.force_n(now, pulled_nm)))
    }
}
