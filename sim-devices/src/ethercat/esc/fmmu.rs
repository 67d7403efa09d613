//! Fieldbus memory management units: which logical addresses lie where in the memory of a SubDevice (ETG.1000.4, 6.6).

use super::registers::{FMMU, FMMU_BYTES};

/// One unit as its registers have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fmmu {
    logical: u32,
    length: u16,
    start_bit: u8,
    end_bit: u8,
    physical: u16,
    physical_bit: u8,
    pub(crate) reads: bool,
    pub(crate) writes: bool,
}

/// A part of a datagram that lies behind a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Window {
    /// Whole bytes: first byte in the datagram, first byte in memory, number of bytes.
    Bytes {
        /// In the datagram.
        data: usize,
        /// In memory.
        physical: u16,
        /// Number.
        count: usize,
    },
    /// Single bits: first bit in the datagram, first bit in memory, number of bits.
    Bits {
        /// In the datagram, from its first byte.
        data: usize,
        /// In memory, from address 0.
        physical: usize,
        /// Number.
        count: usize,
    },
}

impl Fmmu {
    /// Unit `n`; `None` if it is not active or maps nothing.
    pub(crate) fn decode(memory: &[u8], n: usize) -> Option<Self> {
        let at = usize::from(FMMU) + n * FMMU_BYTES;
        let bytes = &memory[at..at + FMMU_BYTES];
        let length = u16::from_le_bytes([bytes[4], bytes[5]]);
        if bytes[12] & 1 == 0 || length == 0 {
            return None;
        }
        Some(Self {
            logical: u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            length,
            start_bit: bytes[6] & 7,
            end_bit: bytes[7] & 7,
            physical: u16::from_le_bytes([bytes[8], bytes[9]]),
            physical_bit: bytes[10] & 7,
            reads: bytes[11] & 1 != 0,
            writes: bytes[11] & 2 != 0,
        })
    }

    /// What of a datagram of `count` bytes at a logical address lies behind this unit.
    pub(crate) fn window(&self, logical: u32, count: usize) -> Option<Window> {
        // Bits from logical address 0: no sum overflows.
        let first = u64::from(self.logical) * 8 + u64::from(self.start_bit);
        let last = (u64::from(self.logical) + u64::from(self.length) - 1) * 8 + u64::from(self.end_bit);
        let datagram = u64::from(logical) * 8;
        let begin = first.max(datagram);
        let end = (last + 1).min(datagram + count as u64 * 8);
        if begin >= end {
            return None;
        }
        let physical = u64::from(self.physical) * 8 + u64::from(self.physical_bit) + (begin - first);
        let data = begin - datagram;
        let bits = end - begin;
        if [physical, data, bits].iter().all(|n| n % 8 == 0) {
            let physical = u16::try_from(physical / 8).ok()?;
            return Some(Window::Bytes { data: (data / 8) as usize, physical, count: (bits / 8) as usize });
        }
        Some(Window::Bits { data: data as usize, physical: physical as usize, count: bits as usize })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(logical: u32, length: u16, bits: [u8; 2], physical: u16, physical_bit: u8) -> Fmmu {
        let [start_bit, end_bit] = bits;
        Fmmu { logical, length, start_bit, end_bit, physical, physical_bit, reads: true, writes: false }
    }

    #[test]
    fn whole_bytes_are_mapped_where_datagram_and_unit_overlap() {
        let fmmu = unit(0x1000, 10, [0, 7], 0x1100, 0);
        let bytes = |data, physical, count| Some(Window::Bytes { data, physical, count });
        assert_eq!(fmmu.window(0x1000, 10), bytes(0, 0x1100, 10));
        assert_eq!(fmmu.window(0x0FFC, 8), bytes(4, 0x1100, 4));
        assert_eq!(fmmu.window(0x1008, 8), bytes(0, 0x1108, 2));
        assert_eq!(fmmu.window(0x100A, 8), None);
        assert_eq!(fmmu.window(0x0FF0, 0x10), None);
    }

    #[test]
    fn bits_of_a_terminal_share_a_byte_of_the_datagram() {
        let fmmu = unit(0x2000, 1, [2, 3], 0x0F00, 0);
        assert_eq!(fmmu.window(0x2000, 1), Some(Window::Bits { data: 2, physical: 0x0F00 * 8, count: 2 }));
        let across = unit(0x2000, 2, [6, 1], 0x0F00, 4);
        assert_eq!(
            across.window(0x2000, 2),
            Some(Window::Bits { data: 6, physical: 0x0F00 * 8 + 4, count: 4 })
        );
    }

    #[test]
    fn the_end_of_the_logical_address_space_overflows_nothing() {
        let fmmu = unit(u32::MAX, u16::MAX, [0, 7], u16::MAX, 0);
        assert!(fmmu.window(u32::MAX, 1486).is_some());
        assert!(fmmu.window(0, 1486).is_none());
    }
}
