//! Analog channels beside the mirror's own: autocollimator, synchronisation of the oscilloscope, loop-back.
//!
//! The loop-back carries a maximum-length sequence of ±1 V, a new bit every tick (x¹⁰ + x⁷ + 1, 1023 ticks long): its
//! correlation with what comes back is 1 at the delay of the path and −1/1023 anywhere else. Inputs are read before
//! outputs are written, as a control computer does: a path that is faster than a tick comes back one tick late.

use std::time::Duration;

use drivers::device::{Channel, DeviceError, Width};
use drivers::mirror::Mirror;
use drivers::wire::AnalogPort;

/// Where the signals hang on the analog card.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AuxiliarySettings {
    /// Tilt of the mirror per volt of the autocollimator.
    pub(super) reference_scale_rad_per_v: f64,
    /// Inputs of the autocollimator: azimuth, elevation.
    pub(super) reference_inputs: [usize; 2],
    /// Output to the oscilloscope.
    pub(super) sync_output: usize,
    /// Output that is looped back.
    pub(super) echo_output: usize,
    /// Input that it is looped to.
    pub(super) echo_input: usize,
}

/// Level of the synchronisation signal.
const SYNC_V: f64 = 5.0;
/// Level of the loop-back signal.
const ECHO_V: f64 = 1.0;

/// The signals as they were seen last.
#[derive(Clone, Debug)]
pub(super) struct AuxiliaryChannels {
    settings: AuxiliarySettings,
    reference_rad: [f64; 2],
    echo_out_v: f64,
    echo_in_v: f64,
    /// State of the shift register, never 0.
    register: u16,
    sync_is_high: bool,
}

impl AuxiliaryChannels {
    /// Channels of the mirror's topic: the mirror's own, then these.
    pub(super) const MIRROR_CHANNELS: &'static [Channel] = {
        const fn f32(name: &'static str, unit: &'static str) -> Channel {
            Channel { name, unit, width: Width::F32 }
        }
        const WHOLE: [Channel; 9] = {
            let own = Mirror::CHANNELS;
            [
                own[0],
                own[1],
                own[2],
                own[3],
                own[4],
                f32("reference_az_rad", "rad"),
                f32("reference_el_rad", "rad"),
                f32("echo_out_v", "V"),
                f32("echo_in_v", "V"),
            ]
        };
        &WHOLE
    };

    /// Nothing was seen yet.
    pub(super) fn new(settings: AuxiliarySettings) -> Self {
        Self {
            settings,
            reference_rad: [0.0; 2],
            echo_out_v: 0.0,
            echo_in_v: 0.0,
            register: 1,
            sync_is_high: false,
        }
    }

    /// One tick: reads, then writes the next bit.
    ///
    /// # Errors
    /// When the card is gone or lacks a channel.
    pub(super) fn exchange(&mut self, analog: &mut dyn AnalogPort, now: Duration) -> Result<(), DeviceError> {
        let settings = &self.settings;
        for (axis, &input) in settings.reference_inputs.iter().enumerate() {
            self.reference_rad[axis] = settings.reference_scale_rad_per_v * analog.read_v(now, input)?;
        }
        self.echo_in_v = analog.read_v(now, settings.echo_input)?;
        self.echo_out_v = if self.next_bit() { ECHO_V } else { -ECHO_V };
        analog.write_v(now, self.settings.echo_output, self.echo_out_v)
    }

    /// Fibonacci form of x¹⁰ + x⁷ + 1 (primitive).
    fn next_bit(&mut self) -> bool {
        let bit = (self.register ^ (self.register >> 3)) & 1;
        self.register = (self.register >> 1) | (bit << 9);
        bit == 1
    }

    /// Raises the synchronisation signal or lets it fall; nothing is written where it stands so already.
    ///
    /// # Errors
    /// When the card is gone or lacks the channel.
    pub(super) fn synchronise(
        &mut self,
        analog: &mut dyn AnalogPort,
        now: Duration,
        high: bool,
    ) -> Result<(), DeviceError> {
        if self.sync_is_high == high {
            return Ok(());
        }
        self.sync_is_high = high;
        analog.write_v(now, self.settings.sync_output, if high { SYNC_V } else { 0.0 })
    }

    /// Channels of the mirror's row that are read here.
    pub(super) fn row(&self) -> [f64; 4] {
        let [az, el] = self.reference_rad;
        [az, el, self.echo_out_v, self.echo_in_v]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_repeats_after_1023_ticks_and_resembles_itself_at_no_other_delay() {
        let settings = AuxiliarySettings {
            reference_scale_rad_per_v: 1.0,
            reference_inputs: [2, 3],
            sync_output: 2,
            echo_output: 3,
            echo_input: 4,
        };
        let mut auxiliary = AuxiliaryChannels::new(settings);
        let bits: Vec<i32> = (0..2046).map(|_| if auxiliary.next_bit() { 1 } else { -1 }).collect();
        for delay in 0..1023 {
            let sum: i32 = (0..1023).map(|k| bits[k] * bits[k + delay]).sum();
            assert_eq!(sum, if delay == 0 { 1023 } else { -1 }, "delay {delay}");
        }
    }
}
