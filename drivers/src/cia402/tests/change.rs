//! Other limits for a drive in operation: written and read back, a step a tick, and refused where they do not stick.

use super::*;
use crate::cia402::objects;

const TICK: Duration = Duration::from_millis(1);
const NARROWER: DriveLimits = DriveLimits { max_torque_nm: 600.0, soft_limits_rad: [-1.0, 0.5] };

/// Ticks until the drive has its limits.
fn ticks_to_change(drive: &mut Cia402, far_end: &mut Dictionary) -> Result<u32, DeviceError> {
    let mut now = Duration::from_secs(5);
    for tick in 0.. {
        if drive.poll_change(far_end, now)? {
            return Ok(tick);
        }
        now += TICK;
    }
    unreachable!("a transfer that is not answered is given up")
}

fn number_at(far_end: &Dictionary, index: u16, sub: u8) -> i32 {
    let bytes = &far_end.bytes[&(index, sub)];
    let mut whole = [0; 4];
    whole[..bytes.len()].copy_from_slice(bytes);
    i32::from_le_bytes(whole)
}

#[test]
fn limits_are_written_read_back_and_obeyed_from_then_on() {
    let mut far_end = Dictionary::of(&azimuth());
    let (mut drive, _) = open(&mut far_end, azimuth()).expect("a good drive");
    drive.attach(Slot { outputs: 3..13, inputs: 5..33 });
    let sent_nm = |drive: &Cia402| {
        let controlword = 0xF;
        let mode = CyclicMode::Torque;
        let command = DriveCommand { controlword, mode, torque_nm: 2000.0, velocity_rad_per_s: 0.0 };
        drive.encode(&command, &mut [0; 16])
    };
    let as_opened = drive.limits();
    assert_eq!((as_opened.max_torque_nm, sent_nm(&drive)), (2556.0, 2000.04));
    drive.change_limits(NARROWER).expect("they fit");
    assert_eq!(drive.limits(), as_opened, "nothing holds before it was read back");
    assert_eq!(ticks_to_change(&mut drive, &mut far_end).expect("the drive takes them"), 0, "all at once");
    assert_eq!((drive.limits(), sent_nm(&drive)), (NARROWER, 600.0));
    assert_eq!(number_at(&far_end, 0x6072, 0), 5000);
    let counts_per_rad = f64::from(1 << 26) / TAU;
    assert_eq!(f64::from(number_at(&far_end, 0x607D, 2)), (0.5 * counts_per_rad).round());
    drive.change_limits(as_opened).expect("they were there before");
    ticks_to_change(&mut drive, &mut far_end).expect("the drive takes them back");
    assert_eq!((drive.limits(), sent_nm(&drive)), (as_opened, 2000.04));
}

#[test]
fn a_mailbox_that_takes_its_time_holds_no_tick_up() {
    let mut far_end = Dictionary::of(&azimuth());
    let (mut drive, _) = open(&mut far_end, azimuth()).expect("a good drive");
    far_end.answers_after = 7 * TICK;
    drive.change_limits(NARROWER).expect("they fit");
    assert_eq!(ticks_to_change(&mut drive, &mut far_end).expect("it answers in the end"), 6 * 7);
}

#[test]
fn a_drive_that_keeps_its_old_limit_or_does_not_answer_is_an_error_that_names_the_object() {
    let mut far_end = Dictionary::of(&azimuth());
    let (mut drive, _) = open(&mut far_end, azimuth()).expect("a good drive");
    far_end.deaf.push((objects::SOFT_LIMIT_MAX.index, objects::SOFT_LIMIT_MAX.sub));
    drive.change_limits(NARROWER).expect("they fit");
    let error = ticks_to_change(&mut drive, &mut far_end).expect_err("it kept the old one");
    assert!(matches!(error, DeviceError::Mismatch { index: 0x607D, sub: 2, .. }), "{error}");
    far_end.answers_after = Duration::from_secs(60);
    drive.change_limits(NARROWER).expect("they fit");
    let error = ticks_to_change(&mut drive, &mut far_end).expect_err("nobody answers");
    assert!(matches!(error, DeviceError::Abort { index: 0x6072, code: 0x0504_0000, .. }), "{error}");
}
