//! Registers that no block of their own has: addresses, counters, SII.

use super::super::line::EtherCatLine;
use super::bench::*;
use super::toy::{Toy, toy, toys};

#[test]
fn a_station_answers_by_its_address_and_by_its_alias_where_that_is_enabled() {
    let mut bench = toy();
    // Alias 7 into the SII, then taken from there.
    assert_eq!(bench.write(FIRST, 0x0502, &[0x01, 0x02, 4, 0, 0, 0, 7, 0]), 1);
    assert_eq!(bench.write(FIRST, 0x0502, &[0x00, 0x04]), 1);
    assert_eq!(bench.read_u16(FIRST, 0x0012), 7);
    assert_eq!(bench.one(at(FPRD, 7, 0, &[0])).counter, 0);
    bench.write(FIRST, 0x0103, &[1]);
    assert_eq!(bench.one(at(FPRD, 7, 0, &[0])).counter, 1);
    assert_eq!(bench.one(at(FPRD, FIRST, 0, &[0])).counter, 1);
    assert_eq!(bench.write(FIRST, 0x0012, &[9, 0]), 0, "the alias comes from the SII alone");
}

#[test]
fn two_devices_with_the_same_alias_both_answer_and_the_last_one_is_read() {
    let mut bench = toys(vec![Toy::new(), Toy::new()]);
    for k in 0..2 {
        bench.write(FIRST + k, 0x0502, &[0x01, 0x02, 4, 0, 0, 0, 7, 0]);
        bench.write(FIRST + k, 0x0502, &[0x00, 0x04]);
        bench.write(FIRST + k, 0x0103, &[1]);
        bench.write(FIRST + k, 0x1000, &[k as u8 + 1]);
    }
    let answer = bench.one(at(FPRD, 7, 0x1000, &[0]));
    assert_eq!((answer.counter, answer.data), (2, vec![2]));
}

#[test]
fn devices_without_an_address_answer_to_no_station_address() {
    let mut bench = toys(vec![Toy::new(), Toy::new()]);
    for k in 0..2 {
        bench.write(FIRST + k, 0x0010, &[0, 0]);
    }
    assert_eq!(bench.one(at(FPRD, 0, 0, &[0])).counter, 0);
    assert_eq!(bench.one(at(BRD, 0, 0, &[0])).counter, 2);
}

#[test]
fn status_and_code_are_read_in_one_piece() {
    let mut bench = toy();
    bench.ask(FIRST, 8);
    assert_eq!(bench.read(FIRST, 0x0130, 6), [0x11, 0, 0, 0, 0x11, 0]);
}

#[test]
fn a_write_to_one_error_counter_clears_its_group() {
    let mut bench = super::faults::rig();
    let mut broken = frame(&[at(BRD, 0, 0, &[0])]);
    broken.truncate(20);
    bench.send(&mut broken);
    bench.line.inject(bench.now, super::faults::unplugged(1, true)).expect("a device");
    assert_eq!(bench.read(FIRST, 0x030C, 8), [1, 0, 0, 0, 0, 1, 0, 0], "the link at port 1 was lost");
    bench.write(FIRST, 0x0300, &[0]);
    assert_eq!(bench.read(FIRST, 0x030C, 8), [1, 0, 0, 0, 0, 1, 0, 0], "another group");
    bench.write(FIRST, 0x0310, &[0xFF]);
    assert_eq!(bench.read(FIRST, 0x030C, 8), [1, 0, 0, 0, 0, 0, 0, 0]);
    bench.write(FIRST, 0x0300, &[0; 20]);
    assert_eq!(bench.read(FIRST, 0x0300, 20), [0; 20]);
}

#[test]
fn the_sii_is_read_eight_bytes_at_a_time() {
    let mut bench = toy();
    bench.write(FIRST, 0x0500, &[2, 0]);
    bench.write(FIRST, 0x0500, &[0, 0]);
    assert_eq!(bench.write(FIRST, 0x0502, &[0, 1, 8, 0, 0, 0]), 1);
    assert_eq!(bench.read(FIRST, 0x0502, 2), [0x40, 0], "done, no error, eight bytes");
    assert_eq!(bench.read(FIRST, 0x0508, 8), [1, 0, 0, 0, 2, 0, 0, 0]);
}

#[test]
fn whoever_gave_the_sii_away_is_refused_until_it_is_taken_back() {
    let mut bench = toy();
    bench.write(FIRST, 0x0500, &[1]);
    bench.write(FIRST, 0x0502, &[0, 1, 8, 0, 0, 0]);
    assert_eq!(bench.read(FIRST, 0x0503, 1)[0] & 0x20, 0x20);
    bench.write(FIRST, 0x0500, &[2]);
    bench.write(FIRST, 0x0500, &[0]);
    bench.write(FIRST, 0x0502, &[0, 1, 8, 0, 0, 0]);
    assert_eq!(bench.read(FIRST, 0x0502, 2), [0x40, 0]);
}

#[test]
fn the_whole_size_that_the_sii_states_can_be_written() {
    let mut bench = toy();
    let [low, high] = 1023_u16.to_le_bytes();
    bench.write(FIRST, 0x0502, &[0x01, 0x02, low, high, 0, 0, 0x34, 0x12]);
    assert_eq!(bench.read(FIRST, 0x0502, 2), [0x40, 0]);
    bench.write(FIRST, 0x0502, &[0, 1, low, high, 0, 0]);
    assert_eq!(bench.read(FIRST, 0x0508, 4), [0x34, 0x12, 0xFF, 0xFF]);
    bench.write(FIRST, 0x0502, &[0x01, 0x02, 0, 4, 0, 0, 0x34, 0x12]);
    assert_eq!(bench.read(FIRST, 0x0503, 1)[0] & 0x40, 0x40, "beyond its end");
}

#[test]
fn blank_writes_to_slots_that_do_not_exist_do_no_harm() {
    let mut bench = toy();
    assert_eq!(bench.one(at(BWR, 0, 0x0600, &[0; 256])).counter, 1, "eight of sixteen exist");
    assert_eq!(bench.one(at(BWR, 0, 0x0800, &[0; 128])).counter, 1);
    assert_eq!(bench.write(FIRST, 0x0680, &[0; 16]), 0);
    assert_eq!(bench.write(FIRST, 0x0840, &[0; 8]), 0);
}

#[test]
fn an_alias_that_a_tool_has_written_is_what_the_device_says_from_then_on() {
    let mut bench = toy();
    assert_eq!(bench.read_u16(FIRST, 0x0012), 0);
    bench.line.set_alias(0, 2002).expect("there is a device 0");
    assert_eq!(bench.read_u16(FIRST, 0x0012), 2002);
    assert!(bench.line.set_alias(1, 2003).is_err(), "there is no device 1");
}
