//! Every command: whom it selects, what it does to position, data and working counter.

use super::bench::*;
use super::toy::{Toy, toys};

const PLACE: u16 = 0x1000;

/// Three toys whose first byte of RAM is 1, 2, 4.
fn three() -> Bench<super::toy::ToyLine> {
    let mut bench = toys(vec![Toy::new(), Toy::new(), Toy::new()]);
    for k in 0..3 {
        assert_eq!(bench.write(FIRST + k, PLACE, &[1 << k]), 1);
    }
    bench
}

fn memory(bench: &mut Bench<super::toy::ToyLine>) -> [u8; 3] {
    [0, 1, 2].map(|k| bench.read(FIRST + k, PLACE, 1)[0])
}

/// A command and what it must do to three devices with 1, 2 and 4 in their memory.
struct Row {
    command: u8,
    adp: u16,
    sent: u8,
    back: u8,
    adp_back: u16,
    counter: u16,
    after: [u8; 3],
}

const fn row(command: u8, adp: u16, sent: u8, back: [u16; 3], after: [u8; 3]) -> Row {
    let [data, adp_back, counter] = back;
    Row { command, adp, sent, back: data as u8, adp_back, counter, after }
}

/// Position of the second device as the MainDevice sends it.
const SECOND: u16 = 0xFFFF;

const ROWS: [Row; 24] = [
    row(0, 0, 0x70, [0x70, 0, 0], [1, 2, 4]),
    row(1, 0, 0, [1, 3, 1], [1, 2, 4]),
    row(1, SECOND, 0, [2, 2, 1], [1, 2, 4]),
    row(1, 7, 0x70, [0x70, 10, 0], [1, 2, 4]),
    row(2, SECOND, 9, [9, 2, 1], [1, 9, 4]),
    row(3, SECOND, 9, [2, 2, 3], [1, 9, 4]),
    row(4, FIRST + 2, 0, [4, FIRST + 2, 1], [1, 2, 4]),
    row(4, 0x2000, 0x70, [0x70, 0x2000, 0], [1, 2, 4]),
    row(5, FIRST, 9, [9, FIRST, 1], [9, 2, 4]),
    row(6, FIRST, 9, [1, FIRST, 3], [9, 2, 4]),
    row(7, 0, 0, [7, 3, 3], [1, 2, 4]),
    row(7, 5, 0x70, [0x77, 8, 3], [1, 2, 4]),
    row(8, 0, 9, [9, 3, 3], [9, 9, 9]),
    // Each device adds its bits to the frame, and writes what had come in.
    row(9, 0, 0x70, [0x77, 3, 9], [0x70, 0x71, 0x73]),
    row(13, 0, 0x70, [1, 3, 3], [1, 1, 1]),
    // The device before the reference writes what the MainDevice sent.
    row(13, SECOND, 0x70, [2, 2, 3], [0x70, 2, 2]),
    row(13, 7, 0x70, [0x70, 10, 3], [0x70, 0x70, 0x70]),
    row(14, FIRST, 0x70, [1, FIRST, 3], [1, 1, 1]),
    row(14, FIRST + 1, 0x70, [2, FIRST + 1, 3], [0x70, 2, 2]),
    row(14, 0x2000, 0x70, [0x70, 0x2000, 3], [0x70, 0x70, 0x70]),
    row(15, FIRST, 0x70, [0x70, FIRST, 0], [1, 2, 4]),
    row(15, 0, 0x70, [0x70, 0, 0], [1, 2, 4]),
    row(0x84, FIRST, 0x70, [0x70, FIRST, 0], [1, 2, 4]),
    row(255, 0, 0x70, [0x70, 0, 0], [1, 2, 4]),
];

#[test]
fn every_command_selects_reads_writes_and_counts_as_the_standard_has_it() {
    for (k, row) in ROWS.iter().enumerate() {
        let mut bench = three();
        let answer = bench.one(at(row.command, row.adp, PLACE, &[row.sent]));
        let back = Answer { adp: row.adp_back, data: vec![row.back], counter: row.counter, events: 0 };
        assert_eq!(answer, back, "row {k}, command {}", row.command);
        assert_eq!(memory(&mut bench), row.after, "row {k}, command {}", row.command);
    }
}

#[test]
fn logical_commands_count_once_a_device_whatever_the_number_of_its_fmmus() {
    let mut bench = toys(vec![Toy::new(), Toy::new()]);
    for (k, station) in (0..).zip([FIRST, FIRST + 1]) {
        bench.reach_op(station, 4, 4);
        bench.fmmu(station, 0, k * 4, 4, 0x1100, 2);
        bench.fmmu(station, 1, 0x100 + k * 4, 2, 0x1400, 1);
        bench.fmmu(station, 2, 0x102 + k * 4, 2, 0x1402, 1);
    }
    let mut counters = Vec::new();
    for command in [LRD, LWR, LRW] {
        let both = bench.one(logical(command, 0x0, &[0; 0x108]));
        let outputs = bench.one(logical(command, 0x0, &[0; 8]));
        let inputs = bench.one(logical(command, 0x104, &[0; 4]));
        let nothing = bench.one(logical(command, 0x200, &[0; 8]));
        counters.push([both.counter, outputs.counter, inputs.counter, nothing.counter]);
    }
    assert_eq!(counters, [[2, 0, 1, 0], [2, 2, 0, 0], [6, 4, 1, 0]]);
}

#[test]
fn a_read_write_takes_the_outputs_that_came_in_and_puts_the_inputs_into_the_same_place() {
    let mut bench = super::toy::toy();
    bench.reach_op(FIRST, 4, 4);
    bench.fmmu(FIRST, 0, 0, 4, 0x1100, 2);
    bench.fmmu(FIRST, 1, 0, 4, 0x1400, 1);
    let answer = bench.one(logical(LRW, 0, &[9, 8, 7, 6]));
    assert_eq!(answer.counter, 3);
    assert_eq!(answer.data, (bench.now.as_micros() as u32).to_le_bytes());
    assert_eq!(bench.line.toys[0].taken.last(), Some(&(bench.now, vec![9, 8, 7, 6])));
}

#[test]
fn datagrams_of_a_frame_are_worked_on_in_order() {
    let mut bench = three();
    let answers = bench.pass(&[
        at(BRD, 0, PLACE, &[0]),
        at(BWR, 0, PLACE, &[8]),
        at(BRD, 0, PLACE, &[0]),
        at(FPRD, FIRST, PLACE, &[0, 0]),
    ]);
    let data: Vec<&[u8]> = answers.iter().map(|answer| &answer.data[..]).collect();
    assert_eq!(data, [&[7][..], &[8], &[8], &[8, 0]]);
    assert!(answers.iter().all(|answer| answer.counter == if answer.data.len() == 1 { 3 } else { 1 }));
}

#[test]
fn nothing_is_counted_where_there_is_no_memory() {
    let mut bench = three();
    for command in 1..=9 {
        let adp = if matches!(command, 4..=6) { FIRST } else { 0 };
        for (ado, count) in [(0x000A, 2), (0x0680, 16), (0x3000, 1), (0xFFFF, 1), (0xFFFF, 2), (0x2FFF, 2)] {
            let answer = bench.one(at(command, adp, ado, &vec![0x55; count]));
            assert_eq!(
                (answer.counter, answer.data),
                (0, vec![0x55; count]),
                "command {command}, {ado:04X}h"
            );
        }
    }
}

#[test]
fn a_datagram_without_data_does_nothing() {
    let mut bench = three();
    for command in 0..=14 {
        assert_eq!(bench.one(at(command, 0, PLACE, &[])).counter, 0, "command {command}");
    }
}

#[test]
fn registers_that_may_only_be_read_refuse_a_write_and_give_a_read_write_its_read() {
    let mut bench = three();
    let controller = bench.read(FIRST, 0x0000, 10);
    assert_eq!(bench.write(FIRST, 0x0000, &[0xEE; 10]), 0);
    assert_eq!(bench.one(at(6, FIRST, 0x0000, &[0xEE; 10])).counter, 1);
    assert_eq!(bench.read(FIRST, 0x0000, 10), controller);
}
