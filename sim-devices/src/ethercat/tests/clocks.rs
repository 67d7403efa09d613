//! Distributed clocks: receive times, offset, the reference that passes by, SYNC0 and what the application does at it.

use std::time::Duration;

use super::super::esc::ClockError;
use super::super::subdevice::SubDevice;
use super::bench::*;
use super::toy::{Toy, ToyLine, description};

const MS: Duration = Duration::from_millis(1);

/// Two toys, the clock of the second one off by this.
fn two(error: ClockError) -> Bench<ToyLine> {
    let device = |error| SubDevice::new(&description(true), error);
    let devices = vec![device(ClockError::default()), device(error)];
    let mut bench = Bench::new(ToyLine { devices, toys: vec![Toy::new(), Toy::new()] });
    bench.number();
    bench
}

fn system_ns(bench: &mut Bench<ToyLine>, station: u16) -> u64 {
    let bytes = bench.read(station, 0x0910, 8);
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte))
}

#[test]
fn a_write_to_the_port_times_latches_them_at_all_devices() {
    let mut bench = super::faults::rig();
    let latched = bench.one(at(BWR, 0, 0x0900, &[0; 4]));
    assert_eq!(latched.counter, 3);
    let at_ns = bench.now.as_nanos() as u32;
    let times = bench.read(FIRST, 0x0900, 16);
    let time = |k: usize| u32::from_le_bytes([times[k], times[k + 1], times[k + 2], times[k + 3]]);
    assert_eq!([time(0), time(4), time(8), time(12)], [at_ns, at_ns + 1200, 0, 0]);
    assert_eq!(bench.read_u32(FIRST, 0x0918), at_ns, "receive time of the processing unit");
    let middle = [bench.read_u32(FIRST + 1, 0x0900), bench.read_u32(FIRST + 1, 0x0904)];
    assert_eq!(middle[1].wrapping_sub(middle[0]), 600, "two hops to the terminal and back");
    assert_eq!(bench.read_u32(FIRST + 2, 0x0904), 0, "nothing behind the terminal");
    assert_eq!(bench.read_u32(FIRST, 0x0900), at_ns, "they stay until the next write");
}

#[test]
fn system_time_is_local_time_plus_the_offset() {
    let mut bench = two(ClockError::default());
    bench.write(FIRST, 0x0920, &1_000_000_000_000_u64.to_le_bytes());
    let shown = system_ns(&mut bench, FIRST);
    assert_eq!(shown, 1_000_000_000_000 + bench.now.as_nanos() as u64);
    bench.write(FIRST, 0x0920, &u64::MAX.to_le_bytes());
    assert_eq!(system_ns(&mut bench, FIRST), bench.now.as_nanos() as u64 - 1, "an offset may be negative");
}

#[test]
fn the_reference_clock_pulls_the_others_towards_it() {
    let mut bench = two(ClockError { rate_ppm: 30.0, phase_ns: 5000 });
    for _ in 0..2000 {
        bench.wait(Duration::from_micros(900));
        let answer = bench.one(at(FRMW, FIRST, 0x0910, &[0; 8]));
        assert_eq!(answer.counter, 2);
        assert_eq!(answer.data, (bench.now.as_nanos() as u64).to_le_bytes());
    }
    let difference = bench.read_u32(FIRST + 1, 0x092C);
    assert!(difference & 0x7FFF_FFFF < 500, "{difference:08X}h");
    assert_eq!(bench.read_u32(FIRST, 0x092C), 0, "the reference compares itself with nobody");
}

#[test]
fn the_difference_says_whose_clock_is_ahead() {
    for (phase_ns, sign) in [(5000_i64, 0), (-5000, 1_u32 << 31)] {
        let mut bench = two(ClockError { rate_ppm: 0.0, phase_ns });
        bench.one(at(FRMW, FIRST, 0x0910, &[0; 8]));
        assert_eq!(bench.read_u32(FIRST + 1, 0x092C), sign | 5000);
        bench.write(FIRST + 1, 0x0930, &[0, 0x10]);
        assert_eq!(bench.read_u32(FIRST + 1, 0x092C), 0, "a write to the speed counter resets it");
    }
}

#[test]
fn the_delay_is_added_to_what_the_reference_says() {
    let mut bench = two(ClockError::default());
    bench.write(FIRST + 1, 0x0928, &300_u32.to_le_bytes());
    bench.one(at(FRMW, FIRST, 0x0910, &[0; 4]));
    assert_eq!(bench.read_u32(FIRST + 1, 0x092C), 1 << 31 | 300);
}

#[test]
fn devices_before_the_reference_are_given_what_the_main_device_sent() {
    let mut bench = two(ClockError::default());
    let answer = bench.one(at(FRMW, FIRST + 1, 0x0910, &777_u64.to_le_bytes()));
    assert_eq!(answer.counter, 2);
    let shown = bench.read_u32(FIRST, 0x092C);
    assert!(shown < 1 << 31 && shown > 0, "its own clock is ahead of 777 ns");
}

#[test]
fn no_received_time_is_too_strange() {
    for received in [0, 1, u64::MAX, 1 << 63, i64::MAX as u64] {
        let mut bench = two(ClockError::default());
        bench.now += MS;
        // So that one difference is the smallest number there is.
        let received = received.wrapping_add((bench.now + Duration::from_micros(100)).as_nanos() as u64);
        assert_eq!(bench.one(at(BWR, 0, 0x0910, &received.to_le_bytes())).counter, 2);
        assert_eq!(bench.one(at(BWR, 0, 0x0910, &received.to_le_bytes()[..4])).counter, 2);
    }
}

#[test]
fn a_part_of_a_time_is_not_compared() {
    let mut bench = two(ClockError::default());
    bench.write(FIRST, 0x0910, &[0xFF, 0xFF]);
    assert_eq!(bench.read_u32(FIRST, 0x092C), 0);
}

/// A toy in SAFE-OP that is given SYNC0 every millisecond from this instant on.
fn synchronised(start_ns: u64) -> Bench<ToyLine> {
    synchronised_by(start_ns, ClockError::default())
}

fn synchronised_by(start_ns: u64, error: ClockError) -> Bench<ToyLine> {
    let devices = vec![SubDevice::new(&description(true), error)];
    let mut bench = Bench::new(ToyLine { devices, toys: vec![Toy::new()] });
    bench.number();
    bench.reach_pre_op(FIRST);
    bench.sync_manager(FIRST, 2, 0x1100, 4, 0x64);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    bench.write(FIRST, 0x0990, &start_ns.to_le_bytes());
    bench.write(FIRST, 0x09A0, &1_000_000_u32.to_le_bytes());
    bench.write(FIRST, 0x0980, &[0, 3]);
    assert_eq!(bench.asked(FIRST, 4), [4, 0]);
    bench
}

#[test]
fn inputs_are_those_of_the_last_pulse_and_outputs_act_at_the_next_one() {
    let mut bench = synchronised(10_000_000);
    bench.ask(FIRST, 8);
    bench.wait(MS * 20 + Duration::from_micros(250) - bench.now);
    bench.write(FIRST, 0x1100, &[1, 2, 3, 4]);
    assert_eq!(bench.state(FIRST), [8, 0]);
    assert_eq!(bench.read(FIRST, 0x1400, 4), 20_000_u32.to_le_bytes(), "of the pulse at 20 ms");
    assert!(bench.line.toys[0].taken.is_empty(), "outputs wait for the next pulse");
    bench.wait(MS * 21 + Duration::from_micros(100) - bench.now);
    assert_eq!(bench.line.toys[0].taken, [(MS * 21, vec![1, 2, 3, 4])]);
    assert_eq!(bench.read(FIRST, 0x1400, 4), 21_000_u32.to_le_bytes());
}

#[test]
fn a_clock_that_is_fast_or_slow_gives_each_pulse_once() {
    for rate_ppm in [-50.0, 20.0, 50.0] {
        let mut bench = synchronised_by(10_000_000, ClockError { rate_ppm, phase_ns: 0 });
        bench.ask(FIRST, 8);
        bench.wait(MS * 20 + Duration::from_micros(100) - bench.now);
        let before = bench.line.toys[0].sampled.len();
        for k in 0..100_u8 {
            bench.write(FIRST, 0x1100, &[k, 0, 0, 0]);
            bench.wait(Duration::from_micros(450));
            bench.wait(Duration::from_micros(450));
        }
        let toy = &bench.line.toys[0];
        let sampled = &toy.sampled[before..];
        assert!(sampled.len() >= 89, "{rate_ppm} ppm: {}", sampled.len());
        let closest = sampled.windows(2).map(|pair| pair[1] - pair[0]).min().expect("several");
        assert!(closest > Duration::from_micros(990), "{rate_ppm} ppm: {closest:?} between two pulses");
        let taken = toy.taken.windows(2).map(|pair| pair[1].0 - pair[0].0).min().expect("several");
        assert!(taken > Duration::from_micros(990), "{rate_ppm} ppm: outputs taken {taken:?} apart");
    }
}

#[test]
fn outputs_act_at_the_next_pulse_even_where_nobody_looked_for_several_cycles() {
    let mut bench = synchronised(10_000_000);
    bench.ask(FIRST, 8);
    bench.wait(MS * 20 + Duration::from_micros(250) - bench.now);
    bench.write(FIRST, 0x1100, &[1, 2, 3, 4]);
    bench.wait(MS * 25 + Duration::from_micros(700) - bench.now);
    assert_eq!(bench.line.toys[0].taken, [(MS * 21, vec![1, 2, 3, 4])]);
    assert_eq!(bench.line.toys[0].sampled.last(), Some(&(MS * 25)));
}

#[test]
fn nothing_is_sampled_before_the_first_pulse() {
    let mut bench = synchronised(50_000_000);
    let count = bench.line.toys[0].sampled.len();
    bench.wait(MS * 10);
    assert_eq!(bench.line.toys[0].sampled.len(), count);
    bench.wait(MS * 50);
    assert!(bench.line.toys[0].sampled.len() > count);
}

#[test]
fn the_start_register_shows_the_next_pulse_and_cannot_be_moved_while_they_come() {
    let mut bench = synchronised(10_000_000);
    assert_eq!(bench.read_u32(FIRST, 0x0990), 10_000_000);
    bench.wait(MS * 12 + Duration::from_micros(300) - bench.now);
    assert_eq!(bench.read_u32(FIRST, 0x0990), 13_000_000);
    assert_eq!(bench.write(FIRST, 0x0990, &[0; 8]), 0);
    assert_eq!(bench.read_u32(FIRST, 0x0990), 13_000_000);
    bench.write(FIRST, 0x0981, &[0]);
    assert_eq!(bench.write(FIRST, 0x0990, &[0; 8]), 1);
    assert_eq!(bench.read_u32(FIRST, 0x0990), 0);
}

#[test]
fn a_start_far_ahead_in_the_first_seconds_is_no_start_that_has_passed() {
    let mut bench = synchronised(4_000_000_000);
    bench.ask(FIRST, 8);
    bench.write(FIRST, 0x1100, &[0; 4]);
    assert_eq!(bench.state(FIRST), [8, 0]);
}

#[test]
fn a_start_of_32_bits_is_the_next_time_that_has_this_low_word() {
    let mut bench = super::toy::toy();
    bench.reach_pre_op(FIRST);
    bench.sync_manager(FIRST, 2, 0x1100, 4, 0x64);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    // System time 5·2³² and a little.
    bench.write(FIRST, 0x0920, &(5_u64 << 32).to_le_bytes());
    bench.write(FIRST, 0x0990, &10_000_000_u32.to_le_bytes());
    bench.write(FIRST, 0x09A0, &1_000_000_u32.to_le_bytes());
    bench.write(FIRST, 0x0980, &[0, 3]);
    assert_eq!(bench.asked(FIRST, 4), [4, 0]);
    bench.wait(MS * 12 + Duration::from_micros(500) - bench.now);
    assert_eq!(bench.read(FIRST, 0x1400, 4), 12_000_u32.to_le_bytes());
}

#[test]
fn a_drive_that_waited_long_for_op_is_given_time_for_its_first_pulse() {
    let mut bench = super::faults::rig();
    bench.reach_pre_op(FIRST);
    bench.write(FIRST, 0x0990, &700_000_000_u64.to_le_bytes());
    bench.write(FIRST, 0x09A0, &1_000_000_u32.to_le_bytes());
    bench.write(FIRST, 0x0980, &[0, 3]);
    bench.go_on_to_safe_op(FIRST, 10, 12);
    bench.wait(MS * 650);
    bench.write(FIRST, 0x1100, &[0; 10]);
    assert_eq!(bench.asked(FIRST, 8), [8, 0]);
    bench.wait(MS * 30);
    bench.write(FIRST, 0x1100, &[0; 10]);
    bench.wait(MS * 60);
    assert_eq!(bench.state(FIRST), [8, 0]);
}

#[test]
fn op_ends_when_sync0_fails_and_comes_back_with_it() {
    let mut bench = synchronised(5_000_000);
    bench.wait(MS * 8);
    bench.write(FIRST, 0x1100, &[0; 4]);
    assert_eq!(bench.asked(FIRST, 8), [8, 0]);
    bench.line.devices[0].esc.clock.lose_sync0(true);
    let count = bench.line.toys[0].sampled.len();
    for _ in 0..10 {
        bench.wait(MS);
        bench.write(FIRST, 0x1100, &[0; 4]);
    }
    assert_eq!(bench.state(FIRST), [0x14, 0x002C]);
    assert_eq!(bench.line.toys[0].sampled.len(), count, "nothing is sampled without it");
    assert_eq!(bench.asked(FIRST, 0x18), [0x14, 0x002D]);
    bench.line.devices[0].esc.clock.lose_sync0(false);
    bench.wait(MS * 2);
    assert_eq!(bench.asked(FIRST, 0x18), [8, 0]);
}

/// A second session sets the clock anew before it stops the pulses of the first.
#[test]
fn a_clock_that_is_moved_while_pulses_are_given_goes_on_giving_them() {
    let mut bench = synchronised(10_000_000);
    bench.ask(FIRST, 8);
    bench.wait(MS * 20 + Duration::from_micros(100) - bench.now);
    // By the moved clock the last pulse was 0.9 ms ago, before the one that was given 0.1 ms ago.
    bench.write(FIRST, 0x0920, &10_800_000_u64.to_le_bytes());
    let before = bench.line.toys[0].sampled.len();
    bench.wait(MS * 25 + Duration::from_micros(500) - bench.now);
    bench.write(FIRST, 0x1100, &[1, 2, 3, 4]);
    bench.wait(Duration::from_millis(1));
    let toy = &bench.line.toys[0];
    assert!(toy.sampled.len() > before && toy.taken.len() == 1, "{:?}", toy.taken);
}
