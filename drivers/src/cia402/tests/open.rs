//! Identification and configuration against the far end, and everything that can differ.

use super::dictionary::{VENDOR_OBJECTS, profile};
use super::*;
use crate::cia402::objects::{Access, DataType, OBJECTS, Object};
use crate::cia402::profile::ObjectPlace;

fn error(far_end: &mut Dictionary, settings: DriveSettings) -> DeviceError {
    open(far_end, settings).expect_err("this drive must be refused")
}

/// Objects that `open` touches: all but the process data.
fn touched() -> impl Iterator<Item = &'static Object> {
    let process_data = [
        0x603F, 0x6040, 0x6041, 0x6061, 0x6064, 0x606C, 0x6071, 0x6077, 0x6078, 0x6079, 0x60FD, 0x60FF,
        0x22A3,
    ];
    OBJECTS.iter().chain(&VENDOR_OBJECTS).filter(move |object| !process_data.contains(&object.index))
}

#[test]
fn table_is_in_order_and_has_no_object_twice() {
    assert!(OBJECTS.is_sorted_by(|a, b| (a.index, a.sub) < (b.index, b.sub)));
}

#[test]
fn identity_is_read_as_the_drive_tells_it() {
    let (_, identity) = open(&mut Dictionary::of(&azimuth()), azimuth()).expect("a good drive");
    let expected = Identity {
        device_name: "Twin Drive 100".to_owned(),
        vendor: 0x9A,
        product: 0x0003_0924,
        revision: 0x0001_0420,
        serial: 4_000_000_001,
        firmware: "1.16.5".to_owned(),
    };
    assert_eq!(identity, expected);
}

#[test]
fn settings_arrive_in_the_drives_counts() {
    let mut far_end = Dictionary::of(&azimuth());
    open(&mut far_end, azimuth()).expect("a good drive");
    let counts = |rad: f64| (rad * f64::from(1 << 26) / TAU).round() as i32;
    let expected: [(u16, u8, &[u8]); 14] = [
        (0x2F00, 0, &200_u16.to_le_bytes()),
        (0x6007, 0, &3_i16.to_le_bytes()),
        (0x605A, 0, &6_i16.to_le_bytes()),
        (0x605E, 0, &2_i16.to_le_bytes()),
        (0x6060, 0, &[10]),
        (0x6065, 0, &[0xFF; 4]),
        (0x6066, 0, &[0; 2]),
        (0x6072, 0, &21_300_u16.to_le_bytes()),
        (0x607D, 1, &counts(-2.79).to_le_bytes()),
        (0x607D, 2, &counts(2.79).to_le_bytes()),
        (0x6080, 0, &counts(1.2).to_le_bytes()),
        (0x6085, 0, &counts(1.5).to_le_bytes()),
        (0x60C2, 1, &[25]),
        (0x60C2, 2, &(-5_i8).to_le_bytes()),
    ];
    for (index, sub, bytes) in expected {
        assert_eq!(far_end.get(index, sub), bytes, "{index:04X}h:{sub}");
    }
}

#[test]
fn the_commissioned_current_limit_is_believed_and_never_written() {
    let mut far_end = Dictionary::of(&azimuth());
    let (whole, _) = open(&mut far_end, azimuth()).expect("a good drive");
    assert!((whole.available_torque_nm() - azimuth().max_torque_nm).abs() < 1e-9);
    far_end.put(0x6073, 0, &10_650_u16.to_le_bytes());
    let (limited, _) = open(&mut far_end, azimuth()).expect("a drive with half of its current");
    assert!((limited.available_torque_nm() / azimuth().max_torque_nm - 0.5).abs() < 1e-9);
    assert!(far_end.written.iter().all(|(index, ..)| *index != 0x6073));
}

#[test]
fn mapping_is_written_count_zero_first_and_holds_the_agreed_bytes() {
    let mut far_end = Dictionary::of(&azimuth());
    open(&mut far_end, azimuth()).expect("a good drive");
    let rx = [0x6040_0010_u32, 0x6071_0010, 0x60FF_0020, 0x6060_0008, 0x0000_0008];
    let tx = [
        0x6041_0010_u32,
        0x603F_0010,
        0x6061_0008,
        0x0000_0008,
        0x6064_0020,
        0x606C_0020,
        0x6077_0010,
        0x6078_0010,
        0x6079_0020,
        0x22A3_0010,
        0x60FD_0020,
    ];
    for (index, words) in [(0x1600, &rx[..]), (0x1A00, &tx[..])] {
        assert_eq!(far_end.get(index, 0), [words.len() as u8]);
        for (sub, word) in (1..).zip(words) {
            assert_eq!(far_end.get(index, sub), word.to_le_bytes());
        }
    }
    let heat_sink = ObjectPlace { index: 0x22A3, sub: 0 };
    assert_eq!(profile().inputs.offset_of(heat_sink), Some(22));
    assert_eq!(far_end.get(0x1C12, 1), 0x1600_u16.to_le_bytes());
    assert_eq!(far_end.get(0x1C13, 1), 0x1A00_u16.to_le_bytes());
    let order: Vec<_> = far_end.written.iter().take(9).map(|(index, sub, _)| (*index, *sub)).collect();
    let list = (1..=5).map(|sub| (0x1600, sub));
    let expected: Vec<_> =
        [(0x1C12, 0), (0x1600, 0)].into_iter().chain(list).chain([(0x1600, 0), (0x1C12, 1)]).collect();
    assert_eq!(order, expected);
}

#[test]
fn every_written_object_that_keeps_another_value_is_named() {
    // The commissioned current limit could be written, and never is.
    let written = |object: &&Object| object.access == Access::ReadWrite && object.index != 0x6073;
    let writable = touched().filter(written);
    for object in writable {
        let mut far_end = Dictionary::of(&azimuth());
        far_end.deaf.push((object.index, object.sub));
        match error(&mut far_end, azimuth()) {
            DeviceError::Mismatch { device, index, sub, name, expected, found, .. } => {
                assert_eq!(
                    (device.as_str(), index, sub, name),
                    ("az", object.index, object.sub, object.name)
                );
                assert_ne!(expected, found);
            }
            other => panic!("{other}"),
        }
    }
}

#[test]
fn every_object_that_aborts_is_named_with_the_meaning_of_the_code() {
    for object in touched() {
        let mut far_end = Dictionary::of(&azimuth());
        far_end.aborting.push(((object.index, object.sub), 0x0800_0021));
        match error(&mut far_end, azimuth()) {
            DeviceError::Abort { device, index, sub, meaning, .. } => {
                assert_eq!((device.as_str(), index, sub), ("az", object.index, object.sub));
                assert_eq!(meaning, "refused: local control");
            }
            other => panic!("{other}"),
        }
    }
}

#[test]
fn every_answer_of_another_width_is_named() {
    for object in touched().filter(|object| object.data_type != DataType::Text) {
        let width = object.data_type.bytes().expect("texts are filtered out");
        for wrong in [0, width - 1, width + 1, 8] {
            let mut far_end = Dictionary::of(&azimuth());
            far_end.deaf.push((object.index, object.sub));
            far_end.put(object.index, object.sub, &vec![0; wrong]);
            match error(&mut far_end, azimuth()) {
                DeviceError::Mismatch { index, sub, expected, found, .. } => {
                    assert_eq!((index, sub), (object.index, object.sub));
                    assert_eq!(expected, format!("{} bits", 8 * width));
                    assert!(found.starts_with(&format!("{} bits", 8 * wrong)), "{found}");
                }
                other => panic!("{other}"),
            }
        }
    }
}

#[test]
fn every_wrong_scale_is_refused_before_anything_is_written() {
    for (index, sub, value) in
        [(0x6075, 0, 5000_u32), (0x6076, 0, 104_000), (0x608F, 1, 1 << 24), (0x608F, 2, 3)]
    {
        let mut far_end = Dictionary::of(&azimuth());
        far_end.put(index, sub, &value.to_le_bytes());
        match error(&mut far_end, azimuth()) {
            DeviceError::Mismatch { index: at, sub: at_sub, .. } => assert_eq!((at, at_sub), (index, sub)),
            other => panic!("{other}"),
        }
        assert!(far_end.written.is_empty());
    }
}

#[test]
fn errors_say_device_object_expected_found_and_what_to_do() {
    let mut far_end = Dictionary::of(&azimuth());
    far_end.put(0x6076, 0, &104_000_u32.to_le_bytes());
    assert_eq!(
        error(&mut far_end, azimuth()).to_string(),
        "az: object 6076h:00 (motor rated torque): expected 120000 (mN*m), found 104000 (mN*m); \
         every torque would be scaled wrongly: correct the rig file or commission the drive"
    );
    let mut far_end = Dictionary::of(&azimuth());
    far_end.aborting.push(((0x2F00, 0), 0x0602_0000));
    assert_eq!(
        error(&mut far_end, azimuth()).to_string(),
        "az: object 2F00h:00 (process data watchdog): expected an object that takes the torque away when process data stay out, \
         found no such object; correct `[watchdog]` in the profile of the drive; without it the drive would go on with its last \
         command when the bench falls silent"
    );
    let mut far_end = Dictionary::of(&azimuth());
    far_end.put(0x60C2, 2, &[]);
    far_end.deaf.push((0x60C2, 2));
    assert_eq!(
        error(&mut far_end, azimuth()).to_string(),
        "az: object 60C2h:02 (interpolation time index): expected 8 bits, found 0 bits []; \
         the drive's object has another type: check drive type and firmware"
    );
}

#[test]
fn station_that_is_no_drive_or_lacks_a_mode_is_refused() {
    let mut far_end = Dictionary::of(&azimuth());
    far_end.put(0x1000, 0, &0x0003_0191_u32.to_le_bytes());
    let text = error(&mut far_end, azimuth()).to_string();
    assert!(text.contains("1000h:00 (device type): expected 402 in the low word, found 401"), "{text}");
    let mut far_end = Dictionary::of(&azimuth());
    far_end.put(0x6502, 0, &0x0000_01E5_u32.to_le_bytes());
    let text = error(&mut far_end, azimuth()).to_string();
    assert!(text.contains("expected bits 300h (CSV, CST) set, found 1E5h"), "{text}");
}

#[test]
fn settings_that_no_drive_can_be_given_are_named() {
    let cases: [(&str, DriveSettings); 12] = [
        ("rated_torque_nm", DriveSettings { rated_torque_nm: 0.0, ..azimuth() }),
        ("rated_current_a", DriveSettings { rated_current_a: f64::NAN, ..azimuth() }),
        ("max_torque_nm", DriveSettings { max_torque_nm: 9000.0, ..azimuth() }),
        ("max_velocity_rad_per_s", DriveSettings { max_velocity_rad_per_s: 1e9, ..azimuth() }),
        ("encoder_counts_per_rev", DriveSettings { encoder_counts_per_rev: 0, ..azimuth() }),
        ("encoder_sign", DriveSettings { encoder_sign: 0.0, ..azimuth() }),
        ("encoder_offset_rad", DriveSettings { encoder_offset_rad: f64::INFINITY, ..azimuth() }),
        ("soft_limits_rad", DriveSettings { soft_limits_rad: [1.0, -1.0], ..azimuth() }),
        ("soft_limits_rad", DriveSettings { encoder_offset_rad: 0.5, ..azimuth() }),
        ("watchdog_s", DriveSettings { watchdog_s: 10.0, ..azimuth() }),
        ("cycle_s", DriveSettings { cycle_s: 1.0 / 3.0, ..azimuth() }),
        ("transition_timeout_s", DriveSettings { transition_timeout_s: -1.0, ..azimuth() }),
    ];
    for (name, settings) in cases {
        match error(&mut Dictionary::of(&azimuth()), settings) {
            DeviceError::Setting { device, setting, .. } => {
                assert_eq!((device.as_str(), setting), ("az", name))
            }
            other => panic!("{name}: {other}"),
        }
    }
}

#[test]
fn reversed_encoder_keeps_the_soft_limits_in_ascending_counts() {
    let settings = DriveSettings {
        encoder_sign: -1.0,
        soft_limits_rad: [-0.2, 1.6],
        encoder_offset_rad: 0.1,
        ..azimuth()
    };
    let mut far_end = Dictionary::of(&settings);
    open(&mut far_end, settings).expect("a good drive");
    let counts = |rad: f64| (rad * f64::from(1 << 26) / TAU).round() as i32;
    assert_eq!(far_end.get(0x607D, 1), counts(-1.5).to_le_bytes());
    assert_eq!(far_end.get(0x607D, 2), counts(0.3).to_le_bytes());
}

#[test]
fn cycle_time_becomes_mantissa_and_power_of_ten() {
    for (cycle_s, mantissa, exponent) in
        [(1e-3, 1, -3_i8), (250e-6, 25, -5), (125e-6, 125, -6), (2e-3, 2, -3)]
    {
        let mut far_end = Dictionary::of(&azimuth());
        open(&mut far_end, DriveSettings { cycle_s, ..azimuth() }).expect("a good drive");
        assert_eq!(
            (far_end.get(0x60C2, 1), far_end.get(0x60C2, 2)),
            (&[mantissa][..], &exponent.to_le_bytes()[..])
        );
    }
}
