//! Emergency messages: a fault in the drive is told once, and that it is gone; beside an SDO nothing is lost.

use std::time::Duration;

use super::super::application::Emergency;
use super::super::faults::LineFault;
use super::super::line::EtherCatLine;
use super::bench::*;
use super::faults::rig_and_bench;
use super::toy::toy;
use crate::rig::Fault;

const MS: Duration = Duration::from_millis(1);

#[test]
fn a_fault_of_a_drive_becomes_a_message_and_its_end_another() {
    let (rig, mut bench) = rig_and_bench();
    bench.reach_pre_op(FIRST);
    assert_eq!(bench.fetch(FIRST), None);
    rig.schedule(bench.now, Fault::Drive { drive: 0, code: 0x7305 });
    bench.wait(MS * 20);
    let (kind, body) = bench.fetch(FIRST).expect("a message");
    assert_eq!(kind & 0x0F, 3);
    assert_eq!(body[..4], [0, 0x10, 0x05, 0x73]);
    assert_eq!(body.len(), 10);
    assert_eq!(body[4], bench.upload(FIRST, 0x1001, 0)[4], "the error register");
    bench.wait(MS * 20);
    assert_eq!(bench.fetch(FIRST), None, "told once");
    bench.go_on_to_safe_op(FIRST, 10, 12);
    bench.ask(FIRST, 8);
    // A rising edge of the fault reset bit; its effect comes after the delay of the drive.
    for controlword in [[0x00; 10], [0x80; 10]].concat() {
        let outputs = [controlword, 0, 0, 0, 0, 0, 0, 0, 10, 0];
        assert_eq!(bench.write(FIRST, 0x1100, &outputs), 1);
        bench.wait(MS * 20);
    }
    let (_, body) = bench.fetch(FIRST).expect("another message");
    assert_eq!(body[..5], [0, 0x10, 0, 0, 0], "no error any more");
}

#[test]
fn a_message_that_waits_comes_before_the_answer_to_an_sdo() {
    let mut bench = toy();
    bench.reach_pre_op(FIRST);
    let emergency = Emergency { code: 0x2310, register: 2, vendor: [1, 2, 3, 4, 5] };
    bench.line.toys[0].tells = Some(emergency);
    bench.wait(MS);
    bench.post(FIRST, 0x43, &[0, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    let (_, first) = bench.fetch(FIRST).expect("the emergency");
    assert_eq!(first, [0, 0x10, 0x10, 0x23, 2, 1, 2, 3, 4, 5]);
    let (kind, second) = bench.fetch(FIRST).expect("the answer");
    assert_eq!((kind, second[1]), (0x43, 0x20), "an abort: the toy has no objects");
}

#[test]
fn a_message_that_is_injected_takes_its_own_counter() {
    let (_, mut bench) = rig_and_bench();
    bench.reach_pre_op(FIRST + 1);
    let mut counters = Vec::new();
    for code in 0..9 {
        let emergency = Emergency { code, register: 1, vendor: [0; 5] };
        bench.line.inject(bench.now, LineFault::Emergency { device: 1, emergency }).expect("a device");
        bench.wait(MS);
        counters.push(bench.fetch(FIRST + 1).expect("a message").0 >> 4);
    }
    assert_eq!(counters, [1, 2, 3, 4, 5, 6, 7, 1, 2]);
}
