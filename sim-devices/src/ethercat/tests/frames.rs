//! Frames as a whole: what is passed on, what is dropped, and what every frame carries back.

use super::bench::*;
use super::toy::toy;

/// Frame of one datagram that reads the first byte of all devices.
fn survey() -> Vec<u8> {
    frame(&[at(BRD, 0, 0x0000, &[0])])
}

#[test]
fn the_answer_is_as_long_as_the_frame_and_its_source_address_says_that_it_is_one() {
    let mut bench = toy();
    let sent = survey();
    let mut back = sent.clone();
    assert_eq!(bench.send(&mut back).bytes, sent.len());
    assert_eq!(back[6], sent[6] | 0x02);
    assert_eq!(back[..6], sent[..6]);
    assert_eq!(back[7..18], sent[7..18], "rest of the address, type, header, command, index");
}

#[test]
fn padding_to_the_smallest_ethernet_frame_is_accepted_and_left_alone() {
    let mut bench = toy();
    let mut back = survey();
    back.resize(60, 0xA5);
    let passage = bench.send(&mut back);
    assert_eq!((passage.answers, passage.bytes), (1, 60));
    assert_eq!(answers(&back)[0].counter, 1);
    assert!(back[29..].iter().all(|&byte| byte == 0xA5));
}

#[test]
fn frames_of_other_protocols_and_types_are_not_answered_and_are_no_errors() {
    let mut bench = super::faults::rig();
    let mut other = survey();
    other[12..14].copy_from_slice(&[0x08, 0x00]);
    let mut network_variables = survey();
    network_variables[15] = network_variables[15] & 0x0F | 4 << 4;
    for mut sent in [other, network_variables] {
        assert_eq!(bench.send(&mut sent).answers, 0);
    }
    assert_eq!(bench.read(FIRST, 0x030C, 1), [0]);
}

#[test]
fn malformed_frames_are_dropped_and_counted() {
    let mut bench = super::faults::rig();
    let whole = survey();
    let change = |at: usize, byte: u8| {
        let mut frame = whole.clone();
        frame[at] = byte;
        frame
    };
    let longer_than_frame = change(14, 0xFF);
    let data_beyond_header = change(22, 0x02);
    let data_beyond_frame = change(23, 0x07);
    let more_that_does_not_come = change(23, 0x80);
    let no_datagram = change(14, 0x00);
    let cut = whole[..20].to_vec();
    let (no_header, no_type) = (whole[..15].to_vec(), whole[..13].to_vec());
    let bad = [
        longer_than_frame,
        data_beyond_header,
        data_beyond_frame,
        more_that_does_not_come,
        no_datagram,
        cut,
        no_header,
        no_type,
        Vec::new(),
    ];
    for (k, mut sent) in bad.into_iter().enumerate() {
        let before = sent.clone();
        assert_eq!(bench.send(&mut sent).answers, 0, "frame {k}");
        assert_eq!(sent, before, "nothing was worked on in frame {k}");
    }
    assert_eq!(bench.read(FIRST, 0x030C, 1), [9]);
    assert_eq!(bench.write(FIRST, 0x030C, &[0]), 1);
    assert_eq!(bench.read(FIRST, 0x030C, 1), [0], "a write clears the counter");
}

#[test]
fn the_interrupt_field_carries_the_events_of_the_mask_until_the_status_was_read() {
    let mut bench = toy();
    assert_eq!(bench.one(at(BRD, 0, 0, &[0])).events, 0, "no event is enabled");
    bench.write(FIRST, 0x0200, &[0x08, 0]);
    bench.reach_pre_op(FIRST);
    bench.ask(FIRST, 1);
    assert_eq!(bench.one(at(BRD, 0, 0, &[0])).events, 0x08, "the AL status changed");
    assert_eq!(bench.one(at(FPRD, 0x2000, 0, &[0])).events, 0x08, "a frame for others carries it too");
    assert_eq!(bench.one(at(0, 0, 0, &[0])).events, 0, "nothing happens to NOP");
    bench.state(FIRST);
    assert_eq!(bench.one(at(BRD, 0, 0, &[0])).events, 0);
}

#[test]
fn a_mailbox_that_holds_a_message_is_an_event() {
    let mut bench = toy();
    bench.reach_pre_op(FIRST);
    bench.write(FIRST, 0x0200, &[0x20, 0]);
    bench.post(FIRST, 0x13, &[0, 0x20, 0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(bench.one(at(BRD, 0, 0, &[0])).events, 0x20);
    bench.fetch(FIRST);
    assert_eq!(bench.one(at(BRD, 0, 0, &[0])).events, 0);
}

#[test]
fn the_event_request_shows_what_the_mask_hides() {
    let mut bench = toy();
    bench.reach_pre_op(FIRST);
    bench.post(FIRST, 0x13, &[0, 0x20, 0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(bench.read_u16(FIRST, 0x0200), 0);
    assert_eq!(bench.read_u16(FIRST, 0x0210) & 0x20, 0x20);
}
