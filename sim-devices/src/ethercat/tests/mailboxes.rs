//! Mailbox protocol on the wire: errors, counters, repetition, what is still waiting.

use super::super::application::Emergency;
use super::bench::*;
use super::toy::{Toy, toys};

const UPLOAD: [u8; 10] = [0, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0];

fn bench() -> Bench<super::toy::ToyLine> {
    let toy = Toy::new().with(0x1000, 0, &[0x92, 1, 2, 0]).with(0x2000, 0, &[7]);
    let mut bench = toys(vec![toy]);
    bench.reach_pre_op(FIRST);
    bench
}

#[test]
fn an_answer_carries_the_counter_of_its_request() {
    let mut bench = bench();
    for counter in [0, 0, 1, 4, 7, 1] {
        assert_eq!(bench.post(FIRST, 3 | counter << 4, &UPLOAD), 1);
        let (kind, body) = bench.fetch(FIRST).expect("an answer");
        assert_eq!(kind, 3 | counter << 4);
        assert_eq!(body, [0, 0x30, 0x43, 0x00, 0x10, 0, 0x92, 1, 2, 0]);
    }
}

#[test]
fn protocols_that_the_device_has_not_are_answered_by_a_mailbox_error() {
    let mut bench = bench();
    for (counter, kind) in (1..).zip([0, 1, 2, 4, 5, 15]) {
        bench.post(FIRST, kind | counter << 4, &[1, 2, 3, 4]);
        assert_eq!(bench.fetch(FIRST), Some((counter << 4, vec![1, 0, 2, 0])), "type {kind}");
    }
}

#[test]
fn a_length_beyond_the_mailbox_and_a_message_without_service_are_mailbox_errors() {
    let mut bench = bench();
    let mut message = [0; 128];
    (message[0], message[5]) = (123, 0x13);
    assert_eq!(bench.write(FIRST, 0x1000, &message), 1);
    assert_eq!(bench.fetch(FIRST), Some((0x10, vec![1, 0, 8, 0])), "invalid size");
    bench.post(FIRST, 0x23, &[0]);
    assert_eq!(bench.fetch(FIRST), Some((0x20, vec![1, 0, 6, 0])), "too short");
    bench.post(FIRST, 0x13, &[0, 0x90, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(bench.fetch(FIRST), Some((0x10, vec![1, 0, 5, 0])), "no such service");
}

#[test]
fn a_message_that_is_sent_twice_is_answered_once() {
    let mut bench = bench();
    assert_eq!(bench.post(FIRST, 0x13, &UPLOAD), 1);
    assert_eq!(bench.post(FIRST, 0x13, &UPLOAD), 1, "taken, and dropped");
    assert!(bench.fetch(FIRST).is_some());
    assert_eq!(bench.fetch(FIRST), None);
    assert_eq!(bench.asked(FIRST, 1), [1, 0]);
    assert_eq!(bench.asked(FIRST, 2), [2, 0]);
    bench.post(FIRST, 0x13, &UPLOAD);
    assert!(bench.fetch(FIRST).is_some(), "after INIT counters begin anew");
}

#[test]
fn an_answer_goes_to_the_address_that_the_request_came_from() {
    let mut bench = bench();
    let mut message = vec![10, 0, 0x34, 0x92, 0, 0x13];
    message.extend(UPLOAD);
    message.resize(128, 0);
    bench.write(FIRST, 0x1000, &message);
    assert_eq!(bench.read(FIRST, 0x1080, 128)[..6], [10, 0, 0x34, 0x92, 0, 0x13]);
    let emergency = Emergency { code: 1, register: 1, vendor: [0; 5] };
    bench.line.devices[0].send_emergency(emergency, bench.now);
    bench.wait(std::time::Duration::from_millis(1));
    assert_eq!(bench.read(FIRST, 0x1080, 128)[..6], [10, 0, 0, 0, 0, 0x13]);
}

#[test]
fn a_request_waits_until_the_answer_before_was_read() {
    let mut bench = bench();
    bench.post(FIRST, 0x13, &UPLOAD);
    assert_eq!(bench.post(FIRST, 0x23, &UPLOAD), 1, "the request itself was taken");
    assert_eq!(bench.fetch(FIRST).map(|(kind, _)| kind), Some(0x13));
    assert_eq!(bench.fetch(FIRST).map(|(kind, _)| kind), Some(0x23));
    assert_eq!(bench.fetch(FIRST), None);
}

#[test]
fn a_lost_answer_is_shown_again_on_request() {
    let mut bench = bench();
    bench.post(FIRST, 0x13, &UPLOAD);
    let first = bench.fetch(FIRST);
    bench.write(FIRST, 0x080E, &[0x03]);
    assert_eq!(bench.read(FIRST, 0x080F, 1), [0x02], "acknowledged");
    assert_eq!(bench.fetch(FIRST), first);
    assert_eq!(bench.fetch(FIRST), None, "once");
    bench.write(FIRST, 0x080E, &[0x01]);
    assert_eq!(bench.read(FIRST, 0x080F, 1), [0x00]);
    assert_eq!(bench.fetch(FIRST), first);
}

#[test]
fn a_repeat_request_does_not_lose_the_messages_behind() {
    let mut bench = bench();
    bench.post(FIRST, 0x13, &UPLOAD);
    bench.post(FIRST, 0x23, &UPLOAD);
    bench.write(FIRST, 0x080E, &[0x03]);
    let kinds = [(); 3].map(|()| bench.fetch(FIRST).map(|(kind, _)| kind));
    assert_eq!(kinds, [Some(0x13), Some(0x23), None]);
}

#[test]
fn a_mailbox_that_is_disabled_while_a_message_waits_ends_pre_op() {
    let mut bench = bench();
    bench.post(FIRST, 0x13, &UPLOAD);
    bench.write(FIRST, 0x080E, &[0]);
    assert_eq!(bench.state(FIRST), [0x11, 0x0016]);
    bench.ask(FIRST, 0x11);
    bench.reach_pre_op(FIRST);
    assert_eq!(bench.fetch(FIRST), None, "the message is gone");
}

#[test]
fn a_mailbox_of_two_bytes_takes_no_message_and_does_no_harm() {
    let mut bench = bench();
    bench.sync_manager(FIRST, 0, 0x1000, 2, 0x26);
    bench.write(FIRST, 0x1000, &[1, 2]);
    assert_eq!(bench.state(FIRST), [0x11, 0x0016]);
}

#[test]
fn messages_that_nobody_reads_are_forgotten_from_the_oldest_on() {
    let mut bench = bench();
    for code in 0..40 {
        let emergency = Emergency { code, register: 1, vendor: [0; 5] };
        bench.line.devices[0].send_emergency(emergency, bench.now);
    }
    bench.wait(std::time::Duration::from_millis(1));
    let mut codes = Vec::new();
    while let Some((_, body)) = bench.fetch(FIRST) {
        codes.push(u16::from_le_bytes([body[2], body[3]]));
    }
    assert_eq!(codes, (24..40).collect::<Vec<u16>>());
}

#[test]
fn there_is_no_mailbox_in_init() {
    let mut bench = bench();
    bench.post(FIRST, 0x13, &UPLOAD);
    assert_eq!(bench.asked(FIRST, 1), [1, 0]);
    assert_eq!(bench.fetch(FIRST), None, "emptied");
    assert_eq!(bench.post(FIRST, 0x13, &UPLOAD), 1, "the sync manager is still enabled");
    assert_eq!(bench.fetch(FIRST), None, "but nobody answers");
    assert_eq!(bench.asked(FIRST, 2), [2, 0]);
    assert_eq!(bench.fetch(FIRST), None, "nor later");
}
