//! Whatever comes in: nothing panics, a frame keeps its length, and no memory grows without bound.

use std::time::Duration;

use proptest::prelude::*;

use super::super::line::EtherCatLine;
use super::bench::*;
use super::faults::rig;

/// A datagram that is likely to find something: any command, mostly addresses that exist.
fn datagram() -> impl Strategy<Value = Datagram> {
    let adp = prop_oneof![Just(0_u16), Just(FIRST), Just(FIRST + 1), Just(FIRST + 2), any::<u16>()];
    let register = prop_oneof![
        0_u16..0x0A00,
        Just(0x0120),
        Just(0x0502),
        0x0600_u16..0x0680,
        0x0800_u16..0x0840,
        Just(0x0910),
        0x0980_u16..0x09A8,
        0x1000_u16..0x1500,
        any::<u16>(),
    ];
    let data = prop::collection::vec(prop_oneof![Just(0_u8), Just(1), 0_u8..16, any::<u8>()], 0..160);
    (0_u8..16, adp, register, data).prop_map(|(command, adp, ado, data)| at(command, adp, ado, &data))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_a_frame_or_are_dropped(mut bytes in prop::collection::vec(any::<u8>(), 0..1600), is_ours: bool) {
        let mut bench = rig();
        if is_ours && bytes.len() >= 16 {
            bytes[12..14].copy_from_slice(&[0x88, 0xA4]);
            bytes[15] = bytes[15] & 0x07 | 0x10;
        }
        let count = bytes.len();
        let passage = bench.send(&mut bytes);
        prop_assert_eq!(bytes.len(), count);
        prop_assert!(passage.answers == 0 || passage.bytes == count);
    }

    #[test]
    fn any_datagrams_come_back_in_a_frame_of_the_same_length(
        frames in prop::collection::vec(prop::collection::vec(datagram(), 1..6), 1..40),
        pause_us in 0_u64..2000,
    ) {
        let mut bench = rig();
        bench.reach_safe_op(FIRST, 10, 12);
        bench.reach_op(FIRST + 1, 10, 12);
        for datagrams in frames {
            let sent = frame(&datagrams);
            let mut back = sent.clone();
            let passage = bench.send(&mut back);
            prop_assert_eq!((passage.answers, passage.bytes), (1, sent.len()));
            prop_assert_eq!(&back[12..18], &sent[12..18]);
            bench.wait(Duration::from_micros(pause_us));
        }
    }

    #[test]
    fn any_message_is_taken_and_what_waits_to_be_sent_is_bounded(
        messages in prop::collection::vec((any::<u8>(), prop::collection::vec(any::<u8>(), 0..122)), 1..60),
        sdo: bool,
    ) {
        let mut bench = rig();
        bench.reach_pre_op(FIRST);
        for (k, (kind, mut body)) in messages.into_iter().enumerate() {
            let kind = if sdo { 3 | (k as u8 % 7 + 1) << 4 } else { kind };
            if sdo && body.len() > 3 {
                body[1] = if k % 3 == 0 { 0x80 } else { 0x20 };
                body[2] &= 0x71;
            }
            prop_assert_eq!(bench.post(FIRST, kind, &body), 1);
        }
        let mut count = 0;
        while bench.fetch(FIRST).is_some() {
            count += 1;
        }
        prop_assert!(count <= 17, "{} messages", count);
        bench.line.advance(bench.now);
    }
}
