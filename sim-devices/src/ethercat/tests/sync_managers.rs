//! Sync managers as the bus sees them: what they let through, and what they refuse.

use super::bench::*;
use super::toy::toy;

#[test]
fn a_mailbox_takes_a_message_when_it_is_empty_and_from_its_first_byte_on() {
    let mut bench = toy();
    bench.sync_manager(FIRST, 0, 0x1000, 128, 0x26);
    assert_eq!(bench.write(FIRST, 0x1001, &[1; 127]), 0, "not from its first byte on");
    assert_eq!(bench.write(FIRST, 0x1000, &[1; 100]), 1);
    assert_eq!(bench.read(FIRST, 0x0805, 1)[0] & 8, 0, "not complete");
    assert_eq!(bench.write(FIRST, 0x1064, &[1; 28]), 1);
    assert_eq!(bench.read(FIRST, 0x0805, 1)[0] & 8, 8);
    assert_eq!(bench.write(FIRST, 0x1000, &[2; 128]), 0, "full");
    assert_eq!(bench.one(at(FPRD, FIRST, 0x1000, &[0; 128])).counter, 0, "the other direction");
}

#[test]
fn an_empty_mailbox_refuses_to_be_read_and_that_opens_nothing() {
    let mut bench = toy();
    bench.reach_pre_op(FIRST);
    assert_eq!(bench.one(at(FPRD, FIRST, 0x1080, &[0x55; 128])).data, [0x55; 128]);
    assert!(bench.fetch(FIRST).is_none());
    bench.post(FIRST, 0x13, &[0, 0x20, 0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(bench.one(at(FPRD, FIRST, 0x10FF, &[0])).counter, 0, "only its last byte");
    assert_eq!(bench.read(FIRST, 0x080D, 1)[0] & 8, 8, "the message is still there");
    assert!(bench.fetch(FIRST).is_some());
    assert!(bench.fetch(FIRST).is_none(), "read once");
}

#[test]
fn a_sync_manager_that_is_enabled_keeps_its_place_until_it_is_disabled() {
    let mut bench = toy();
    bench.sync_manager(FIRST, 0, 0x1000, 128, 0x26);
    bench.write(FIRST, 0x0800, &[0, 0x18, 64, 0, 0x22, 0, 1, 0]);
    assert_eq!(bench.read(FIRST, 0x0800, 5), [0, 0x10, 128, 0, 0x26]);
    bench.write(FIRST, 0x0806, &[0]);
    bench.write(FIRST, 0x0800, &[0, 0x18, 64, 0, 0x22, 0, 1, 0]);
    assert_eq!(bench.read(FIRST, 0x0800, 5), [0, 0x18, 64, 0, 0x22]);
}

#[test]
fn a_message_is_gone_when_its_mailbox_was_disabled_and_enabled_again() {
    let mut bench = toy();
    bench.sync_manager(FIRST, 0, 0x1000, 128, 0x26);
    assert_eq!(bench.write(FIRST, 0x1000, &[1; 128]), 1);
    bench.sync_manager(FIRST, 0, 0x1000, 128, 0x26);
    assert_eq!(bench.read(FIRST, 0x0805, 1)[0] & 8, 0);
    assert_eq!(bench.write(FIRST, 0x1000, &[1; 128]), 1);
}

#[test]
fn a_buffer_never_blocks_and_gives_a_whole_picture() {
    let mut bench = toy();
    bench.reach_op(FIRST, 4, 4);
    for k in 0..3 {
        assert_eq!(bench.write(FIRST, 0x1100, &[k; 4]), 1);
        assert_eq!(bench.read(FIRST, 0x1400, 4), (bench.now.as_micros() as u32).to_le_bytes());
    }
    let first_half = bench.read(FIRST, 0x1400, 2);
    let sampled = bench.now;
    let second_half = bench.read(FIRST, 0x1402, 2);
    assert_eq!([first_half, second_half].concat(), (sampled.as_micros() as u32).to_le_bytes());
}

#[test]
fn outputs_reach_the_application_when_they_are_complete() {
    let mut bench = toy();
    bench.reach_op(FIRST, 4, 4);
    let count = bench.line.toys[0].taken.len();
    bench.write(FIRST, 0x1100, &[1, 2, 3]);
    assert_eq!(bench.line.toys[0].taken.len(), count);
    bench.write(FIRST, 0x1103, &[4]);
    assert_eq!(bench.line.toys[0].taken.last().map(|(_, bytes)| bytes.clone()), Some(vec![1, 2, 3, 4]));
    assert_eq!(bench.one(at(FPRD, FIRST, 0x1100, &[0; 4])).counter, 0, "outputs cannot be read back");
    assert_eq!(bench.write(FIRST, 0x1400, &[0; 4]), 0, "nor inputs written");
}

#[test]
fn an_access_across_two_sync_managers_and_free_memory_serves_each_part() {
    let mut bench = toy();
    bench.sync_manager(FIRST, 4, 0x2000, 2, 0x64);
    bench.sync_manager(FIRST, 5, 0x2002, 2, 0x64);
    assert_eq!(bench.write(FIRST, 0x1FFF, &[9, 1, 2, 3, 4, 8]), 1);
    assert_eq!(bench.read(FIRST, 0x1FFF, 1), [9]);
    assert_eq!(bench.read(FIRST, 0x2004, 1), [8]);
    let device = &mut bench.line.devices[0].esc;
    assert_eq!(device.sync_manager(4).device_takes(), Some(&[1, 2][..]));
    assert_eq!(device.sync_manager(5).device_takes(), Some(&[3, 4][..]));
    // Outputs cannot be read back: these bytes stay as they were sent, the free ones around them are read.
    let answer = bench.one(at(FPRD, FIRST, 0x1FFF, &[0x55; 6]));
    assert_eq!((answer.counter, answer.data), (1, vec![9, 0x55, 0x55, 0x55, 0x55, 8]));
}

#[test]
fn a_sync_manager_over_the_registers_covers_nothing() {
    let mut bench = toy();
    bench.sync_manager(FIRST, 7, 0x0000, 0x1000, 0x22);
    assert_eq!(bench.read(FIRST, 0x0010, 2), FIRST.to_le_bytes(), "the registers are still there");
    bench.sync_manager(FIRST, 7, 0xFFFF, 0xFFFF, 0x26);
    assert_eq!(bench.write(FIRST, 0xFFFF, &[1]), 0);
}

#[test]
fn two_devices_keep_their_sync_managers_apart() {
    let mut bench = super::toy::toys(vec![super::toy::Toy::new(), super::toy::Toy::new()]);
    bench.sync_manager(FIRST, 0, 0x1000, 4, 0x26);
    assert_eq!(bench.write(FIRST, 0x1000, &[1; 4]), 1);
    assert_eq!(bench.one(at(BWR, 0, 0x1000, &[2; 4])).counter, 1, "full here, free memory there");
    assert_eq!(bench.read(FIRST + 1, 0x1000, 4), [2; 4]);
}
