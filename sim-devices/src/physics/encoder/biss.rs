//! BiSS-C frames of a single-turn encoder (unidirectional; Renishaw L-9709-9005): position, nE, nW, CRC.
//!
//! Bits in the order sent, most significant first: position ‖ nE ‖ nW ‖ inverted CRC-6. Error and warning are active
//! low. Ack, start and CDS are not part of the word.

/// Faults of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncoderFault {
    /// The encoder reports that its position cannot be trusted (nE low); drives name it 7305h.
    Error,
    /// The encoder reports that it nears its limits, the position is still right (nW low).
    Warning,
    /// A bit of the frame was lost on the way: the checksum is wrong; drives name it 7306h or a link error.
    Crc,
}

/// A frame that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Position, counts.
    pub position_counts: u64,
    /// nE is low.
    pub error: bool,
    /// nW is low.
    pub warning: bool,
}

/// CRC-6 of the lowest `bits_count` bits, most significant first: x⁶ + x + 1, initial 0, before the inversion.
pub fn crc6(bits: u64, bits_count: u32) -> u8 {
    (0..bits_count).rev().fold(0, |crc: u8, place| {
        let carry = (crc >> 5) ^ (bits >> place & 1) as u8;
        ((crc << 1) & 0x3F) ^ if carry & 1 == 1 { 0x03 } else { 0 }
    })
}

/// The word of a position of `position_bits` (at most 56) with its flags and checksum.
pub fn frame_word(position_counts: u64, position_bits: u32, fault: Option<EncoderFault>) -> u64 {
    let mask = (1_u64 << position_bits) - 1;
    let flag = |low: EncoderFault| u64::from(fault != Some(low));
    let payload =
        (position_counts & mask) << 2 | flag(EncoderFault::Error) << 1 | flag(EncoderFault::Warning);
    let crc = u64::from(crc6(payload, position_bits + 2) ^ 0x3F);
    let word = payload << 6 | crc;
    // One wrong bit within the position, so that whoever does not check takes a jump for true.
    if fault == Some(EncoderFault::Crc) { word ^ 1 << (8 + position_bits / 2) } else { word }
}

/// Reads a word; `None` if the checksum is wrong.
pub fn read_word(word: u64, position_bits: u32) -> Option<Reading> {
    let payload = word >> 6 & ((1 << (position_bits + 2)) - 1);
    let right = u64::from(crc6(payload, position_bits + 2) ^ 0x3F) == word & 0x3F;
    right.then_some(Reading {
        position_counts: payload >> 2,
        error: payload & 2 == 0,
        warning: payload & 1 == 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Words computed for protocols.md §6 by two algorithms.
    #[test]
    fn words_of_the_document_are_met() {
        use EncoderFault::{Error, Warning};
        for (position, fault, crc, word) in [
            (0x000_0000, None, 0x05, 0x0_0000_00FA),
            (0x000_0000, Some(Error), 0x03, 0x0_0000_007C),
            (0x000_0000, Some(Warning), 0x06, 0x0_0000_00B9),
            (0x000_0001, None, 0x09, 0x0_0000_01F6),
            (0x123_4567, None, 0x14, 0x1_2345_67EB),
            (0x200_0000, None, 0x17, 0x2_0000_00E8),
            (0x3FF_FFFF, None, 0x1D, 0x3_FFFF_FFE2),
        ] {
            assert_eq!(frame_word(position, 26, fault), word, "{position:07X} {fault:?}");
            assert_eq!(crc6(word >> 6, 28), crc);
            let expected = Reading {
                position_counts: position,
                error: fault == Some(Error),
                warning: fault == Some(Warning),
            };
            assert_eq!(read_word(word, 26), Some(expected));
        }
    }

    #[test]
    fn an_injected_checksum_fault_is_not_read() {
        assert_eq!(read_word(frame_word(0x123_4567, 26, Some(EncoderFault::Crc)), 26), None);
    }

    proptest! {
        #[test]
        fn every_single_wrong_bit_is_found(position in 0..1_u64 << 26, bits in 12..31_u32, place in 0..20_u32) {
            let word = frame_word(position, bits, None);
            let turn = position & ((1 << bits) - 1);
            prop_assert_eq!(read_word(word, bits).map(|reading| reading.position_counts), Some(turn));
            prop_assert_eq!(read_word(word ^ 1 << place, bits), None);
        }
    }
}
