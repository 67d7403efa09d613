//! Terminals on an EtherCAT bus, in a slot of the process image: analog ones with signed 16-bit channels, digital ones with a
//! bit for each input.

use std::ops::Range;

use super::super::{ProcessImage, Slot};
use crate::device::DeviceError;

/// A channel of an analog terminal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerminalChannel {
    /// First byte of its signed 16-bit value within the terminal's inputs, or outputs.
    pub byte: usize,
    /// Volts of one step, e.g. 10 V / 32767.
    pub v_per_step: f64,
}

/// An analog terminal: where its channels lie in the process image and what their steps mean.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalogTerminal {
    name: String,
    slot: Slot,
    inputs: Vec<TerminalChannel>,
    outputs: Vec<TerminalChannel>,
}

impl AnalogTerminal {
    /// A terminal whose bytes lie at `slot`.
    ///
    /// # Errors
    /// When a channel does not lie within the slot, or its step is not a voltage.
    pub fn new(
        name: &str,
        slot: Slot,
        inputs: Vec<TerminalChannel>,
        outputs: Vec<TerminalChannel>,
    ) -> Result<Self, DeviceError> {
        for (field, channels, range) in
            [("inputs", &inputs, &slot.inputs), ("outputs", &outputs, &slot.outputs)]
        {
            for (k, channel) in channels.iter().enumerate() {
                let fits = channel.byte.checked_add(2).is_some_and(|end| end <= range.len());
                if !fits || !channel.v_per_step.is_finite() || channel.v_per_step == 0.0 {
                    return Err(DeviceError::Field {
                        device: name.to_owned(),
                        field,
                        expected: format!("channel {k} within {} bytes, with a step in volts", range.len()),
                        found: format!("byte {}, {} V a step", channel.byte, channel.v_per_step),
                        help: "correct the terminal's profile, or the mapping of its process data",
                    });
                }
            }
        }
        Ok(Self { name: name.to_owned(), slot, inputs, outputs })
    }

    /// Voltage of input `channel` in the last exchange.
    ///
    /// # Errors
    /// When there is no such channel, or the image is another bus's.
    pub fn read_v(&self, image: &ProcessImage, channel: usize) -> Result<f64, DeviceError> {
        let found =
            self.inputs.get(channel).ok_or_else(|| self.missing("input", channel, self.inputs.len()))?;
        let bytes = range(&self.slot.inputs, found.byte).and_then(|range| image.inputs.get(range));
        let steps = bytes.and_then(|bytes| <[u8; 2]>::try_from(bytes).ok()).map(i16::from_le_bytes);
        let steps = steps.ok_or_else(|| self.outside(image.inputs.len()))?;
        Ok(f64::from(steps) * found.v_per_step)
    }

    /// Sets output `channel` for the next exchange, within what the channel can give; gives back the voltage that is sent.
    /// Not a number is sent as 0 V.
    ///
    /// # Errors
    /// When there is no such channel, or the image is another bus's.
    pub fn write_v(&self, image: &mut ProcessImage, channel: usize, volts: f64) -> Result<f64, DeviceError> {
        let found =
            self.outputs.get(channel).ok_or_else(|| self.missing("output", channel, self.outputs.len()))?;
        // The cast saturates, and takes not-a-number for 0.
        let steps = (volts / found.v_per_step).round() as i16;
        let length = image.outputs.len();
        let bytes = range(&self.slot.outputs, found.byte).and_then(|range| image.outputs.get_mut(range));
        bytes.ok_or_else(|| self.outside(length))?.copy_from_slice(&steps.to_le_bytes());
        Ok(f64::from(steps) * found.v_per_step)
    }

    fn missing(&self, kind: &str, channel: usize, count: usize) -> DeviceError {
        let reason =
            format!("no {kind} {channel}: the terminal has {count}; correct the channel in the rig file");
        DeviceError::Bus { device: self.name.clone(), reason }
    }

    fn outside(&self, image_bytes: usize) -> DeviceError {
        let reason =
            format!("its slot is outside of a process image of {image_bytes} bytes: map the bus again");
        DeviceError::Bus { device: self.name.clone(), reason }
    }
}

/// The digital inputs of a terminal: input 0 is the lowest bit of its first byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DigitalTerminal {
    name: String,
    inputs: Range<usize>,
}

impl DigitalTerminal {
    /// A terminal whose inputs lie at `slot`.
    pub fn new(name: &str, slot: &Slot) -> Self {
        Self { name: name.to_owned(), inputs: slot.inputs.clone() }
    }

    /// Whether an input was on in the last exchange.
    ///
    /// # Errors
    /// When there is no such input, or the image is another bus's.
    pub fn is_on(&self, image: &ProcessImage, input: usize) -> Result<bool, DeviceError> {
        let byte = input / 8;
        let bytes = image.inputs.get(self.inputs.clone());
        match bytes.and_then(|bytes| bytes.get(byte)) {
            Some(bits) => Ok(bits >> (input % 8) & 1 == 1),
            None => Err(DeviceError::Field {
                device: self.name.clone(),
                field: "input",
                expected: match 8 * self.inputs.len() {
                    0 => "a terminal with digital inputs".to_owned(),
                    count => format!("0 to {} within the process data of the terminal", count - 1),
                },
                found: input.to_string(),
                help: "correct the terminal or its input in the rig file",
            }),
        }
    }
}

/// The two bytes at `byte` of a slot.
fn range(slot: &Range<usize>, byte: usize) -> Option<Range<usize>> {
    let start = slot.start.checked_add(byte)?;
    Some(start..start.checked_add(2)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STEP_V: f64 = 10.0 / 32767.0;

    fn terminal() -> AnalogTerminal {
        let channel = |byte| TerminalChannel { byte, v_per_step: STEP_V };
        let slot = Slot { outputs: 4..6, inputs: 1..9 };
        AnalogTerminal::new("E-stop terminal", slot, vec![channel(2), channel(6)], vec![channel(0)])
            .expect("the channels lie within the slot")
    }

    #[test]
    fn inputs_are_read_at_their_bytes_in_volts() {
        let image = ProcessImage { outputs: vec![0; 6], inputs: vec![0, 9, 9, 0xFF, 0x7F, 9, 9, 0x01, 0x80] };
        assert_eq!(terminal().read_v(&image, 0), Ok(10.0));
        assert!((terminal().read_v(&image, 1).expect("there are two") + 10.0).abs() < 1e-9);
        let text = terminal().read_v(&image, 2).expect_err("there are two").to_string();
        assert_eq!(
            text,
            "E-stop terminal: no input 2: the terminal has 2; correct the channel in the rig file"
        );
    }

    #[test]
    fn outputs_saturate_and_say_what_is_sent() {
        let mut image = ProcessImage { outputs: vec![7; 6], inputs: Vec::new() };
        assert_eq!(terminal().write_v(&mut image, 0, 99.0), Ok(32767.0 * STEP_V));
        assert_eq!(image.outputs, [7, 7, 7, 7, 0xFF, 0x7F]);
        assert_eq!(terminal().write_v(&mut image, 0, f64::NAN), Ok(0.0));
        assert!(terminal().read_v(&image, 0).is_err(), "the image has no inputs");
    }

    #[test]
    fn digital_inputs_are_the_bits_of_the_slot_and_others_are_refused() {
        let terminal = DigitalTerminal::new("inputs", &Slot { outputs: 0..0, inputs: 1..3 });
        let image = ProcessImage { outputs: Vec::new(), inputs: vec![0xFF, 0b1000_0001, 0b10] };
        let on: Vec<usize> = (0..16).filter(|&input| terminal.is_on(&image, input) == Ok(true)).collect();
        assert_eq!(on, [0, 7, 9]);
        let text = terminal.is_on(&image, 16).expect_err("there are sixteen").to_string();
        assert!(text.contains("expected 0 to 15") && text.contains("found 16"), "{text}");
        assert!(terminal.is_on(&ProcessImage::default(), 0).is_err(), "the image is another bus's");
    }

    #[test]
    fn a_channel_outside_of_its_slot_is_refused() {
        let channel = TerminalChannel { byte: 7, v_per_step: STEP_V };
        let slot = Slot { outputs: 0..0, inputs: 1..9 };
        assert!(AnalogTerminal::new("terminal", slot, vec![channel], Vec::new()).is_err());
    }

    proptest! {
        #[test]
        fn no_image_makes_it_panic(inputs in prop::collection::vec(any::<u8>(), 0..16), outputs in prop::collection::vec(any::<u8>(), 0..16), channel in 0_usize..4, volts: f64) {
            let mut image = ProcessImage { outputs, inputs };
            let read = terminal().read_v(&image, channel);
            prop_assert!(read.is_err() || read.is_ok_and(f64::is_finite));
            let before = image.inputs.clone();
            let _ = terminal().write_v(&mut image, channel, volts);
            prop_assert_eq!(before, image.inputs, "an output changes no input");
        }
    }
}
