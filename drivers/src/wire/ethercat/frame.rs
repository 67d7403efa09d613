//! EtherCAT frames as bytes: the tag that tells one frame's reply from every other, and whether a reply fits what was sent.
//!
//! SubDevices change one bit of a frame's source address (the "locally administered" bit of its first byte) and leave the
//! rest alone. Bytes 2 to 5 of that address therefore carry a number that no other frame of this program has: a late or
//! repeated reply can never be taken for the reply to a newer frame, although EtherCAT's own index is one byte and wraps.

use super::super::MAX_FRAME_BYTES;

const ETHERTYPE: [u8; 2] = [0x88, 0xA4];
/// First byte of the source address as it is sent.
const SOURCE: u8 = 0x10;
/// The bit of that byte which every first SubDevice sets.
const PASSED: u8 = 0x02;
/// Command that writes to a station by its configured address.
const FPWR: u8 = 5;
/// Ethernet header, then the EtherCAT header.
const HEADERS_BYTES: usize = 16;
/// Header of a datagram.
const DATAGRAM_HEADER_BYTES: usize = 10;
const WORKING_COUNTER_BYTES: usize = 2;
/// Length, circulating bit and "more" bit of a datagram.
const LENGTH_MASK: u16 = 0x07FF;
const CIRCULATED: u16 = 0x4000;
const MORE: u16 = 0x8000;

/// Writes the tag into a frame that is about to be sent.
pub(super) fn put_tag(frame: &mut [u8], tag: u32) {
    if let Some(bytes) = frame.get_mut(8..12) {
        bytes.copy_from_slice(&tag.to_be_bytes());
    }
}

/// The tag of a frame that has passed a SubDevice; `None` for every other frame.
pub(super) fn reply_tag(frame: &[u8]) -> Option<u32> {
    let (source, ethertype) = (frame.get(6..12)?, frame.get(12..14)?);
    let passed = source[0] == SOURCE | PASSED && source[1] == SOURCE && ethertype == ETHERTYPE;
    passed.then(|| u32::from_be_bytes([source[2], source[3], source[4], source[5]]))
}

/// Whether a frame is one of this program's that no SubDevice has passed on: a loopback plug, or a cable between two ports.
pub(super) fn is_own(frame: &[u8]) -> bool {
    frame.get(6..8) == Some(&[SOURCE, SOURCE])
}

/// Byte `offset` of what the first datagram of a frame writes to `register` of the station with this address (FPWR); `None`
/// if that is not what it does.
pub(super) fn written_byte(frame: &mut [u8], address: u16, register: u16, offset: usize) -> Option<&mut u8> {
    let at = HEADERS_BYTES;
    let is_it = *frame.get(at)? == FPWR
        && word(frame, at + 2)? == address
        && word(frame, at + 4)? == register
        && offset < usize::from(word(frame, at + 6)? & LENGTH_MASK);
    frame.get_mut(at + DATAGRAM_HEADER_BYTES + offset).filter(|_| is_it)
}

/// Whether a reply has the datagrams of the frame that was sent: the same commands, indices and lengths in the same order.
pub(super) fn fits(reply: &[u8], sent: &[u8]) -> bool {
    let (Some(header), Some(sent_header)) = (word(reply, 14), word(sent, 14)) else { return false };
    if header != sent_header || reply.len() > MAX_FRAME_BYTES {
        return false;
    }
    let end = HEADERS_BYTES + usize::from(header & LENGTH_MASK);
    if end > reply.len() || end > sent.len() {
        return false;
    }
    let mut at = HEADERS_BYTES;
    loop {
        let same_command = reply.get(at..at + 2).is_some() && reply.get(at..at + 2) == sent.get(at..at + 2);
        let (Some(length), Some(sent_length)) = (word(reply, at + 6), word(sent, at + 6)) else {
            return false;
        };
        if !same_command || length != sent_length || length & CIRCULATED != 0 {
            return false;
        }
        at += DATAGRAM_HEADER_BYTES + usize::from(length & LENGTH_MASK) + WORKING_COUNTER_BYTES;
        if at > end {
            return false;
        }
        if length & MORE == 0 {
            return true;
        }
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    let bytes = bytes.get(at..at + 2)?;
    Some(u16::from_le_bytes([bytes[0], bytes[1]]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A frame of two datagrams: a read of one byte and a logical exchange of four.
    fn frame() -> Vec<u8> {
        let mut frame = vec![0xFF; 6];
        frame.extend([0x10; 6]);
        frame.extend(ETHERTYPE);
        let datagrams = [
            &[0x04, 7, 0x00, 0x10, 0x30, 0x01, 0x01, 0x80, 0, 0, 0xAA, 0, 0][..],
            &[0x0C, 8, 0, 0, 0, 0, 0x04, 0x00, 0, 0, 1, 2, 3, 4, 0, 0],
        ]
        .concat();
        frame.extend((datagrams.len() as u16 | 0x1000).to_le_bytes());
        frame.extend(datagrams);
        frame
    }

    /// What a chain of SubDevices makes of a frame.
    fn reply() -> Vec<u8> {
        let mut reply = frame();
        put_tag(&mut reply, 0x0102_0304);
        reply[6] |= PASSED;
        reply[26] = 0x08;
        reply[27] = 1;
        reply
    }

    #[test]
    fn a_reply_carries_the_tag_of_the_frame_that_was_sent() {
        assert_eq!(reply_tag(&reply()), Some(0x0102_0304));
        assert_eq!(reply_tag(&frame()), None, "no SubDevice has passed it");
        assert!(is_own(&frame()) && !is_own(&reply()));
    }

    #[test]
    fn a_reply_of_another_shape_does_not_fit() {
        assert!(fits(&reply(), &frame()));
        let mut padded = reply();
        padded.resize(60, 0);
        assert!(fits(&padded, &frame()), "Ethernet pads short frames");
        for changed in [14, 16, 17, 22, 23, 29, 30, 35] {
            let mut other = reply();
            other[changed] ^= 0x41;
            assert!(!fits(&other, &frame()), "byte {changed}");
        }
        assert!(!fits(&reply()[..40], &frame()), "cut off");
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic(reply in prop::collection::vec(any::<u8>(), 0..80), sent in prop::collection::vec(any::<u8>(), 0..80)) {
            prop_assert!(reply.len() >= 14 || reply_tag(&reply).is_none(), "no whole header, no tag");
            prop_assert!(reply.len() >= 8 || !is_own(&reply), "no source address, nobody's frame");
            prop_assert!(reply.len() >= 16 || !fits(&reply, &sent), "what has no header fits nothing");
        }

        #[test]
        fn a_damaged_reply_never_panics(at in 0_usize..45, value in any::<u8>(), cut in 0_usize..45) {
            let mut other = reply();
            let last = other.len() - 1;
            other[at.min(last)] = value;
            other.truncate(cut.max(1));
            prop_assert!(other.len() >= 16 || !fits(&other, &frame()), "what has no header fits nothing");
        }
    }
}
