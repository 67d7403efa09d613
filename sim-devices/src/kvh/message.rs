//! A message as bytes (ICD 56-0298): written here on its own, the driver's reader must agree.

use drivers::crc32::crc32;
use drivers::kvh::Format;

/// What a message says, in the units that are configured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Content {
    pub(super) rotation: [f32; 3],
    pub(super) acceleration: [f32; 3],
    pub(super) temperature: f32,
    pub(super) time_s: f64,
    pub(super) status: u8,
    pub(super) sequence: u8,
}

/// Bytes of one message.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    bytes: [u8; 40],
    length: usize,
}

impl Content {
    /// The message in a format.
    pub(super) fn frame(&self, format: Format) -> Frame {
        let mut frame = Frame { bytes: [0; 40], length: 0 };
        let last = match format {
            Format::A => 0x55,
            Format::B => 0x56,
            Format::C => 0x57,
        };
        frame.put([0xFE, 0x81, 0xFF, last]);
        self.rotation.iter().for_each(|value| frame.put(value.to_be_bytes()));
        self.acceleration.iter().for_each(|value| frame.put(value.to_be_bytes()));
        match format {
            Format::A => {}
            // The unit counts microseconds and wraps.
            Format::B => frame.put(((self.time_s * 1e6).round_ties_even() as u64 as u32).to_be_bytes()),
            Format::C => frame.put(self.interleaved().to_be_bytes()),
        }
        frame.put([self.status, self.sequence]);
        if format != Format::C {
            frame.put((self.temperature.round_ties_even() as i16).to_be_bytes());
        }
        let crc = crc32(frame.bytes());
        frame.put(crc.to_be_bytes());
        frame
    }

    /// Format C: temperature, then a magnetic field along X, Y, Z, gauss. The field is a fixed one of the site.
    fn interleaved(&self) -> f32 {
        match self.sequence % 4 {
            0 => self.temperature,
            1 => 0.17,
            2 => -0.17,
            _ => 0.4,
        }
    }
}

/// A report of the built-in test with six or eight bytes, and its sum.
pub(super) fn bit_report(tests: &[u8; 8], length: usize) -> Frame {
    let mut frame = Frame { bytes: [0; 40], length: 0 };
    frame.put([0xFE, 0x81, 0x00, if length == 6 { 0xAA } else { 0xAB }]);
    tests.iter().take(length).for_each(|&byte| frame.put([byte]));
    let sum = frame.bytes().iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
    frame.put([sum]);
    frame
}

impl Frame {
    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.bytes[self.length..self.length + N].copy_from_slice(&bytes);
        self.length += N;
    }

    /// All bytes, header and checksum included.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Turns one bit of the checksum.
    pub(super) fn spoil_checksum(&mut self) {
        self.bytes[self.length - 1] ^= 1;
    }
}
