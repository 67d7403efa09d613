//! FMMUs in front of sync managers, of registers and of single bits.

use super::bench::*;
use super::toy::toy;

#[test]
fn a_datagram_may_hold_a_part_of_the_process_data() {
    let mut bench = toy();
    bench.reach_op(FIRST, 4, 4);
    bench.fmmu(FIRST, 0, 0x1000, 4, 0x1100, 2);
    bench.fmmu(FIRST, 1, 0x1004, 4, 0x1400, 1);
    assert_eq!(bench.one(logical(LWR, 0x0FFE, &[9, 9, 1, 2])).counter, 1);
    assert_eq!(bench.one(logical(LWR, 0x1002, &[3, 4, 9, 9])).counter, 1);
    assert_eq!(bench.line.toys[0].taken.last().map(|(_, bytes)| bytes.clone()), Some(vec![1, 2, 3, 4]));
    let first = bench.one(logical(LRD, 0x1002, &[0x55; 4]));
    let sampled = (bench.now.as_micros() as u32).to_le_bytes();
    let second = bench.one(logical(LRD, 0x1006, &[0x55; 4]));
    assert_eq!((first.counter, second.counter), (1, 1));
    assert_eq!(first.data, [0x55, 0x55, sampled[0], sampled[1]]);
    assert_eq!(second.data, [sampled[2], sampled[3], 0x55, 0x55]);
}

#[test]
fn the_state_of_a_mailbox_can_be_mapped_into_the_inputs() {
    let mut bench = toy();
    bench.reach_pre_op(FIRST);
    bench.fmmu(FIRST, 2, 0x40, 1, 0x080D, 1);
    assert_eq!(bench.one(logical(LRD, 0x40, &[0xFF])).data, [0]);
    bench.post(FIRST, 0x13, &[0, 0x20, 0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    let answer = bench.one(logical(LRW, 0x40, &[0xFF]));
    assert_eq!((answer.counter, answer.data), (1, vec![8]));
    bench.fetch(FIRST);
    assert_eq!(bench.one(logical(LRD, 0x40, &[0xFF])).data, [0]);
}

#[test]
fn single_bits_are_mapped_and_leave_their_neighbours_alone() {
    let mut bench = toy();
    bench.write(FIRST, 0x2000, &[0b1111_0000]);
    // Bits 3 to 6 of logical byte 10h lie at bits 1 to 4 of 2000h, both ways.
    for (n, kind) in [(0, 1), (1, 2)] {
        bench.fmmu(FIRST, n, 0x10, 1, 0x2000, kind);
        bench.write(FIRST, 0x0606 + 16 * n, &[3, 6]);
        bench.write(FIRST, 0x060A + 16 * n, &[1]);
    }
    let read = bench.one(logical(LRD, 0x10, &[0b1000_0111]));
    assert_eq!((read.counter, &read.data[..]), (1, &[0b1100_0111][..]));
    assert_eq!(bench.one(logical(LWR, 0x10, &[0b1010_1111])).counter, 1);
    assert_eq!(bench.read(FIRST, 0x2000, 1), [0b1110_1010]);
}

#[test]
fn bits_of_two_devices_share_a_byte() {
    let mut bench = super::toy::toys(vec![super::toy::Toy::new(), super::toy::Toy::new()]);
    for k in 0..2 {
        bench.write(FIRST + k, 0x2000, &[0b11]);
        bench.fmmu(FIRST + k, 0, 0, 1, 0x2000, 1);
        bench.write(FIRST + k, 0x0606, &[4 * k as u8, 4 * k as u8 + 1]);
    }
    let answer = bench.one(logical(LRD, 0, &[0]));
    assert_eq!((answer.counter, answer.data), (2, vec![0b0011_0011]));
}

#[test]
fn one_fmmu_may_serve_two_sync_managers_that_lie_side_by_side() {
    let mut bench = toy();
    bench.sync_manager(FIRST, 4, 0x2000, 2, 0x64);
    bench.sync_manager(FIRST, 5, 0x2002, 2, 0x64);
    bench.fmmu(FIRST, 0, 0, 4, 0x2000, 2);
    assert_eq!(bench.one(logical(LWR, 0, &[1, 2, 3, 4])).counter, 1);
    let device = &mut bench.line.devices[0].esc;
    assert_eq!(device.sync_manager(4).device_takes(), Some(&[1, 2][..]));
    assert_eq!(device.sync_manager(5).device_takes(), Some(&[3, 4][..]));
}

#[test]
fn units_that_are_inactive_empty_or_out_of_memory_hit_nothing() {
    let mut bench = toy();
    bench.fmmu(FIRST, 0, 0, 4, 0x2000, 3);
    bench.write(FIRST, 0x060C, &[0]);
    assert_eq!(bench.one(logical(LRW, 0, &[1; 4])).counter, 0, "inactive");
    bench.fmmu(FIRST, 0, 0, 0, 0x2000, 3);
    assert_eq!(bench.one(logical(LRW, 0, &[1; 4])).counter, 0, "empty");
    bench.fmmu(FIRST, 0, 0, 4, 0x3000, 3);
    assert_eq!(bench.one(logical(LRW, 0, &[1; 4])).counter, 0, "no memory");
    bench.fmmu(FIRST, 0, 0, 4, 0xFFFE, 3);
    assert_eq!(bench.one(logical(LRW, 0, &[1; 4])).counter, 0, "beyond the last address");
    bench.fmmu(FIRST, 0, 0, 4, 0x2000, 3);
    assert_eq!(bench.one(logical(LRW, 0, &[1; 4])).counter, 3);
}

#[test]
fn the_logical_address_space_does_not_wrap_around() {
    let mut bench = toy();
    bench.fmmu(FIRST, 0, u32::MAX - 1, 8, 0x2000, 3);
    assert_eq!(bench.one(logical(LRW, u32::MAX - 1, &[7; 4])).counter, 3);
    assert_eq!(bench.one(logical(LRW, 0, &[7; 4])).counter, 0);
    assert_eq!(bench.read(FIRST, 0x2000, 8), [7, 7, 7, 7, 0, 0, 0, 0]);
}
