//! The trigger cable of the inertial unit: SYNC0 where it is active, frames with process data elsewhere.

use std::time::Duration;

use super::bench::*;
use super::faults::{RigLine, rig_and_bench};
use drivers::wire::ByteLine;

const MS: Duration = Duration::from_millis(1);
/// Bytes of a message in format A, and where its number stands.
const MESSAGE_BYTES: usize = 36;
const SEQUENCE: usize = 29;

/// A line of drives, and the host's end of the serial line of the inertial unit, which sends a message for each pulse.
fn triggered() -> (Bench<RigLine>, Box<dyn ByteLine>) {
    let (rig, bench) = rig_and_bench();
    let mut imu = rig.imu_line();
    let orders = b"=CONFIG,1\r=OUTPUTFMT,A\r=MSYNC,EXT\r=CONFIG,0\r";
    imu.write(bench.now, orders).expect("the line is there");
    (bench, imu)
}

/// Lets what is on the line arrive and gives the numbers of the messages.
fn numbers(bench: &mut Bench<RigLine>, imu: &mut dyn ByteLine) -> Vec<u8> {
    let mut bytes = [0; 4096];
    // A message takes 0.4 ms at 921600 bit/s.
    let count = imu.read(bench.now + MS / 2, &mut bytes).expect("the line is there");
    let starts = (0..count.saturating_sub(3)).filter(|&k| bytes[k..k + 4] == [0xFE, 0x81, 0xFF, 0x55]);
    starts.filter(|k| k + MESSAGE_BYTES <= count).map(|k| bytes[k + SEQUENCE]).collect()
}

#[test]
fn without_sync0_a_frame_with_process_data_triggers_and_one_for_registers_does_not() {
    let (mut bench, mut imu) = triggered();
    numbers(&mut bench, &mut *imu);
    for _ in 0..20 {
        bench.read(FIRST, 0x0130, 2);
        bench.wait(MS);
    }
    assert_eq!(numbers(&mut bench, &mut *imu), [] as [u8; 0]);
    for _ in 0..4 {
        bench.one(logical(LRW, 0, &[0; 4]));
        bench.wait(MS);
    }
    let found = numbers(&mut bench, &mut *imu);
    assert_eq!(found.len(), 4, "{found:?}");
}

#[test]
fn with_sync0_each_pulse_triggers_once_whatever_frames_pass_and_whoever_looks_late() {
    let (mut bench, mut imu) = triggered();
    bench.write(FIRST, 0x0990, &20_300_000_u64.to_le_bytes());
    bench.write(FIRST, 0x09A0, &1_000_000_u32.to_le_bytes());
    bench.write(FIRST, 0x0980, &[0, 3]);
    bench.wait(MS * 20);
    numbers(&mut bench, &mut *imu);
    let begun_at = bench.now;
    let mut found = Vec::new();
    for k in 0..30 {
        // Two frames with process data and two for registers a cycle, in every seventh none for three cycles.
        for _ in 0..2 {
            bench.one(logical(LRW, 0, &[0; 4]));
            bench.read(FIRST, 0x0130, 2);
        }
        bench.wait(if k % 7 == 0 { MS * 3 } else { MS * 6 / 10 });
        found.extend(numbers(&mut bench, &mut *imu));
    }
    let cycles = (bench.now - begun_at).as_secs_f64() / 1e-3;
    assert!((found.len() as f64 - cycles).abs() <= 1.0, "{} messages in {cycles} cycles", found.len());
    assert!(found.windows(2).all(|pair| pair[1] == (pair[0] + 1) % 128), "{found:?}");
}
