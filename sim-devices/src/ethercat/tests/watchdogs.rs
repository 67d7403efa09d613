//! The process data watchdog: what feeds it, when it acts, what it does.

use std::time::Duration;

use drivers::wire::BusState;

use super::bench::*;
use super::toy::{ToyLine, toy};

const MS: Duration = Duration::from_millis(1);

fn in_op() -> Bench<ToyLine> {
    let mut bench = toy();
    bench.reach_op(FIRST, 4, 4);
    bench
}

/// Watchdog status, and how often it expired.
fn watchdog(bench: &mut Bench<ToyLine>) -> [u8; 2] {
    [bench.read(FIRST, 0x0440, 1)[0] & 1, bench.read(FIRST, 0x0442, 1)[0]]
}

#[test]
fn without_outputs_for_100_ms_the_device_leaves_op() {
    let mut bench = in_op();
    bench.write(FIRST, 0x1100, &[1; 4]);
    bench.wait(MS * 99);
    assert_eq!(bench.state(FIRST), [8, 0]);
    bench.wait(MS * 2);
    assert_eq!(bench.state(FIRST), [0x14, 0x001B]);
    assert_eq!(watchdog(&mut bench), [0, 1]);
    assert_eq!(bench.line.toys[0].state, BusState::SafeOp);
    bench.write(FIRST, 0x1100, &[1; 4]);
    assert_eq!(watchdog(&mut bench), [1, 1], "outputs content it again");
    assert_eq!(bench.asked(FIRST, 0x18), [8, 0]);
    bench.write(FIRST, 0x0442, &[0]);
    assert_eq!(watchdog(&mut bench), [1, 0]);
}

#[test]
fn frames_without_complete_outputs_do_not_feed_it() {
    let mut bench = in_op();
    for _ in 0..15 {
        bench.wait(MS * 10);
        assert_eq!(bench.write(FIRST, 0x1100, &[1; 3]), 1, "not the last byte");
        bench.one(logical(LRW, 0x5000, &[0; 4]));
        bench.read(FIRST, 0x1400, 4);
    }
    assert_eq!(bench.state(FIRST), [0x14, 0x001B]);
}

#[test]
fn outputs_by_fmmu_feed_it() {
    let mut bench = in_op();
    bench.fmmu(FIRST, 0, 0, 4, 0x1100, 2);
    for _ in 0..15 {
        bench.wait(MS * 10);
        bench.one(logical(LRW, 0, &[0; 4]));
    }
    assert_eq!(bench.state(FIRST), [8, 0]);
}

#[test]
fn its_time_is_set_by_divider_and_units() {
    let mut bench = in_op();
    // 25 MHz by 250, 100 times: 1 ms.
    bench.write(FIRST, 0x0400, &23_u16.to_le_bytes());
    bench.write(FIRST, 0x0420, &1000_u16.to_le_bytes());
    bench.write(FIRST, 0x1100, &[1; 4]);
    bench.wait(Duration::from_micros(900));
    assert_eq!(bench.state(FIRST), [8, 0]);
    bench.wait(Duration::from_micros(200));
    assert_eq!(bench.state(FIRST), [0x14, 0x001B]);
}

#[test]
fn zero_switches_it_off_and_so_does_a_sync_manager_that_does_not_trigger_it() {
    let mut bench = in_op();
    bench.write(FIRST, 0x0420, &[0, 0]);
    bench.wait(MS * 10_000);
    assert_eq!(bench.state(FIRST), [8, 0]);
    let mut bench = toy();
    bench.reach_pre_op(FIRST);
    bench.sync_manager(FIRST, 2, 0x1100, 4, 0x24);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    bench.ask(FIRST, 4);
    bench.write(FIRST, 0x1100, &[0; 4]);
    bench.ask(FIRST, 8);
    bench.wait(MS * 10_000);
    assert_eq!(bench.state(FIRST), [8, 0]);
}

#[test]
fn it_waits_for_op() {
    let mut bench = toy();
    bench.reach_safe_op(FIRST, 4, 4);
    bench.write(FIRST, 0x1100, &[0; 4]);
    bench.wait(MS * 300);
    assert_eq!(bench.asked(FIRST, 8), [8, 0]);
    assert_eq!(watchdog(&mut bench), [1, 0]);
}

#[test]
fn a_drive_that_is_enabled_faults_when_its_outputs_stop() {
    let mut bench = super::faults::rig();
    bench.reach_op(FIRST, 10, 12);
    // Shutdown, switch on, enable operation: each held until the drive has had time for it.
    for controlword in [[0x06; 20], [0x07; 20], [0x0F; 20]].concat() {
        bench.write(FIRST, 0x1100, &[controlword, 0, 0, 0, 0, 0, 0, 0, 10, 0]);
        bench.wait(MS * 20);
    }
    let statusword = |bench: &mut Bench<super::faults::RigLine>| bench.read(FIRST, 0x1400, 1)[0];
    assert_eq!(statusword(&mut bench) & 0x6F, 0x27, "operation enabled");
    bench.wait(MS * 200);
    assert_eq!(bench.state(FIRST), [0x14, 0x001B]);
    for _ in 0..50 {
        bench.wait(MS * 20);
    }
    assert_eq!(statusword(&mut bench) & 0x4F, 0x08, "fault");
    let (_, emergency) = bench.fetch(FIRST).expect("an emergency message");
    assert_eq!(emergency[..4], [0, 0x10, 0x00, 0x75], "communication");
    assert_eq!(bench.upload(FIRST, 0x603F, 0)[4..6], [0x00, 0x75]);
}
