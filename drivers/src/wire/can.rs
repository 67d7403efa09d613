//! CAN interfaces: whole classic frames with 11-bit identifiers, error frames of the controller, and the time that passes while
//! somebody waits.
//!
//! CANopen needs nothing else of CAN: frames with 29-bit identifiers, remote frames and CAN FD frames are skipped.

mod error_frame;
#[cfg(target_os = "linux")]
mod socket;

use std::io;
use std::time::Duration;

pub use error_frame::CanErrorFrame;
#[cfg(target_os = "linux")]
pub use socket::SocketCan;

/// Largest identifier of 11 bits.
const MOST_ID: u16 = 0x7FF;
/// Most data bytes of a classic frame.
const MOST_BYTES: usize = 8;

/// A classic CAN data frame with an 11-bit identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanFrame {
    id: u16,
    length: u8,
    /// Zero beyond the length.
    data: [u8; MOST_BYTES],
}

impl CanFrame {
    /// A frame; `None` if the identifier has more than 11 bits or the data more than 8 bytes.
    pub fn new(id: u16, data: &[u8]) -> Option<Self> {
        if id > MOST_ID || data.len() > MOST_BYTES {
            return None;
        }
        let mut frame = Self { id, length: data.len() as u8, data: [0; MOST_BYTES] };
        frame.data[..data.len()].copy_from_slice(data);
        Some(frame)
    }

    /// A frame of a length that is known when the program is compiled; only the lower 11 bits of the identifier count.
    pub fn of<const N: usize>(id: u16, bytes: [u8; N]) -> Self {
        const { assert!(N <= MOST_BYTES, "a classic frame holds 8 bytes") };
        let mut data = [0; MOST_BYTES];
        data[..N].copy_from_slice(&bytes);
        Self { id: id & MOST_ID, length: N as u8, data }
    }

    /// Identifier.
    pub const fn id(&self) -> u16 {
        self.id
    }

    /// Data.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.length)]
    }
}

/// Most bits that a frame with an 11-bit identifier takes on the wire, with all stuff bits and the pause behind it (ISO
/// 11898-1): 55 without data, 135 with 8 bytes.
pub const fn most_frame_bits(data_bytes: usize) -> u32 {
    /// From the start of the frame to the end of its check sequence, where stuff bits are inserted, without data.
    const STUFFED: u32 = 34;
    /// Delimiters, acknowledgement, end of frame and pause.
    const UNSTUFFED: u32 = 13;
    let stuffed = STUFFED + 8 * data_bytes as u32;
    stuffed + UNSTUFFED + (stuffed - 1) / 4
}

/// What a CAN interface receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CanEvent {
    /// A frame of another node.
    Frame(CanFrame),
    /// The interface's own controller reports an error.
    Error(CanErrorFrame),
}

/// A CAN interface.
///
/// The interface owns the time of its bus: on a real interface it passes by itself, in process it passes while somebody waits.
pub trait CanLink {
    /// Name for errors, e.g. `can0`.
    fn name(&self) -> &str;

    /// Sends a frame. Never waits.
    ///
    /// # Errors
    /// When the interface is down or gone, or its queue is full.
    fn send(&mut self, frame: &CanFrame) -> io::Result<()>;

    /// Takes the oldest frame or error that has arrived; `None` if none has. Never waits.
    ///
    /// # Errors
    /// When the interface is down or gone.
    fn receive(&mut self) -> io::Result<Option<CanEvent>>;

    /// Time since the start of the run.
    fn now(&self) -> Duration;

    /// Waits until something can be taken, at the latest until `until` (time since the start of the run).
    ///
    /// # Errors
    /// When the interface is gone.
    fn wait(&mut self, until: Duration) -> io::Result<()>;
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn frames_hold_11_bits_and_8_bytes_and_no_more() {
        assert_eq!(CanFrame::new(0x800, &[]), None);
        assert_eq!(CanFrame::new(0x7FF, &[0; 9]), None);
        assert_eq!(CanFrame::new(0x602, &[0x40, 0x18]), Some(CanFrame::of(0x602, [0x40, 0x18])));
        assert_eq!(CanFrame::of(0x080, []).data(), []);
    }

    #[test]
    fn the_longest_frames_take_the_bits_of_the_literature() {
        assert_eq!([0, 1, 8].map(most_frame_bits), [55, 65, 135]);
    }

    proptest! {
        #[test]
        fn a_frame_keeps_identifier_and_data(id in 0_u16..0x800, data in prop::collection::vec(any::<u8>(), 0..=8)) {
            let frame = CanFrame::new(id, &data).expect("within the limits");
            prop_assert_eq!((frame.id(), frame.data()), (id, &data[..]));
        }
    }
}
