//! Types of drives: fixed PDOs with padding, objects that a type lacks, start-up lists, identities, scales, and temperatures that
//! come by SDO.

use super::dictionary::of_type;
use super::*;
use crate::cia402::objects;
use crate::cia402::profile::*;

/// PDOs as they were read out of a servo drive whose mappings are fixed: index, then mapping words.
const FIXED: [(u16, &[u32]); 9] = [
    (0x1602, &[0x6071_0010, 0x6040_0010]),
    (0x1605, &[0x607A_0020, 0x60FF_0020, 0x6071_0010, 0x6072_0010, 0x6040_0010, 0x6060_0008, 0x0000_0008]),
    (0x160B, &[0x6060_0008, 0x0000_0008]),
    (0x161C, &[0x60FF_0020]),
    (0x1A02, &[0x6064_0020, 0x6077_0010, 0x6041_0010, 0x6061_0008, 0x0000_0008]),
    (0x1A11, &[0x606C_0020]),
    (0x1A18, &[0x6079_0020]),
    (0x1A1C, &[0x60FD_0020]),
    (0x1A26, &[0x603F_0010]),
];

/// A drive with fixed PDOs whose torque objects are currents, and whose temperature is read by SDO.
fn fixed() -> DriveSettings {
    of_type(|profile| {
        profile.id = "fixed".to_owned();
        profile.outputs = ProcessData::Assigned(vec![0x1602, 0x161C, 0x160B]);
        profile.inputs = ProcessData::Assigned(vec![0x1A02, 0x1A11, 0x1A18, 0x1A1C, 0x1A26]);
        profile.torque_scale = TorqueScale::RatedCurrent;
        profile.watchdog = None;
        profile.heat_sink = Some(HeatSink {
            place: ObjectPlace { index: 0x22A3, sub: 1 },
            data_type: objects::DataType::I16,
            counts_per_degc: 1.0,
            by: ReadBy::Sdo,
        });
    })
}

/// The far end of such a drive.
fn far_end(settings: &DriveSettings) -> Dictionary {
    let mut far_end = Dictionary::of(settings);
    for (index, words) in FIXED {
        far_end.put(index, 0, &[words.len() as u8]);
        for (sub, word) in (1..).zip(words) {
            far_end.put(index, sub, &word.to_le_bytes());
        }
    }
    far_end.put(0x22A3, 1, &61_i16.to_le_bytes());
    far_end
}

fn refused(settings: DriveSettings) -> String {
    open(&mut far_end(&settings), settings).expect_err("this drive must be refused").to_string()
}

#[test]
fn fixed_pdos_are_assigned_and_their_offsets_come_from_the_mapping_of_the_drive() {
    let settings = fixed();
    let mut far_end = far_end(&settings);
    let (mut drive, _) = open(&mut far_end, settings).expect("a good drive");
    let assigned = |index: u16| {
        let count = far_end.get(index, 0)[0];
        (1..=count).map(|sub| u16::from_le_bytes(far_end.get(index, sub).try_into().expect("u16"))).collect()
    };
    let (outputs, inputs): (Vec<u16>, Vec<u16>) = (assigned(0x1C12), assigned(0x1C13));
    assert_eq!(outputs, [0x1602, 0x161C, 0x160B]);
    assert_eq!(inputs, [0x1A02, 0x1A11, 0x1A18, 0x1A1C, 0x1A26]);
    let untouched = |index: &u16| (0x1600..0x1700).contains(index) || (0x1A00..0x1B00).contains(index);
    assert!(!far_end.written.iter().any(|(index, ..)| untouched(index)), "mappings are fixed");

    drive.attach(Slot { outputs: 1..11, inputs: 0..24 });
    let mut image = [0; 24];
    image[..4].copy_from_slice(&(1_i32 << 24).to_le_bytes());
    image[4..6].copy_from_slice(&750_i16.to_le_bytes());
    image[6..8].copy_from_slice(&0x1637_u16.to_le_bytes());
    image[8] = 10;
    image[9] = 0xEE;
    image[10..14].copy_from_slice(&(1_i32 << 26).to_le_bytes());
    image[14..18].copy_from_slice(&48_102_u32.to_le_bytes());
    image[18..22].copy_from_slice(&8_u32.to_le_bytes());
    image[22..].copy_from_slice(&0x7305_u16.to_le_bytes());
    let actuals = drive.decode(&image);
    assert_eq!(actuals.position_rad, PI / 2.0);
    assert!((actuals.velocity_rad_per_s - TAU).abs() < 1e-12);
    assert_eq!((actuals.current_a, actuals.torque_nm), (1.5, 90.0), "750 ‰ of 2 A, at 60 N·m/A");
    assert_eq!((actuals.bus_v, actuals.digital_inputs), (48.102, 8));
    assert_eq!((actuals.statusword, actuals.error_code, actuals.mode), (0x1637, 0x7305, 10));
    assert_eq!(actuals.heat_sink_degc, 61.0, "read when the drive was opened");

    let mut sent = [0xEE; 12];
    let command = DriveCommand {
        controlword: 0x000F,
        mode: CyclicMode::Velocity,
        torque_nm: -60.0,
        velocity_rad_per_s: 0.0,
    };
    assert_eq!(drive.encode(&command, &mut sent), -60.0, "500 ‰ of 2 A");
    let torque = (-500_i16).to_le_bytes();
    assert_eq!(sent, [0xEE, torque[0], torque[1], 0x0F, 0, 0, 0, 0, 0, 9, 0, 0xEE]);
}

#[test]
fn an_output_that_nobody_knows_what_to_send_for_is_refused() {
    let settings = of_type(|profile| {
        profile.outputs = ProcessData::Assigned(vec![0x1605]);
    });
    let text = refused(settings);
    assert!(text.contains("607Ah:00 (mapped output)") && text.contains("always be sent as 0"), "{text}");
}

#[test]
fn an_object_that_the_assigned_pdos_lack_is_named() {
    let settings = of_type(|profile| {
        profile.outputs = ProcessData::Assigned(vec![0x1602, 0x160B]);
    });
    let text = refused(settings);
    assert!(text.contains("60FFh:00") && text.contains("32 bits among the outputs"), "{text}");
    let settings = of_type(|profile| {
        profile.inputs = ProcessData::Assigned(vec![0x1A02, 0x1A11, 0x1A18, 0x1A1C, 0x1A26]);
    });
    let text = refused(settings);
    assert!(
        text.contains("6078h:00") && text.contains("among the inputs"),
        "torque is no current here: {text}"
    );
    let text = refused(of_type(|profile| profile.inputs = ProcessData::Assigned(vec![0x1A07])));
    assert!(text.contains("1A07h:00"), "{text}");
}

#[test]
fn an_object_across_a_byte_boundary_is_not_decoded() {
    let settings = of_type(|profile| profile.outputs = ProcessData::Assigned(vec![0x1699]));
    let mut far_end = far_end(&settings);
    let words = [0x6040_0010_u32, 0x0000_0004, 0x6071_0010, 0x60FF_0020, 0x6060_0008, 0x0000_0004];
    far_end.put(0x1699, 0, &[words.len() as u8]);
    for (sub, word) in (1..).zip(words) {
        far_end.put(0x1699, sub, &word.to_le_bytes());
    }
    let text = open(&mut far_end, settings).expect_err("four bits of padding before it").to_string();
    assert!(text.contains("6071h:00") && text.contains("on a byte boundary"), "{text}");
}

#[test]
fn what_a_type_lacks_is_neither_read_nor_written() {
    let lacks: Vec<ObjectPlace> =
        MAY_LACK.iter().map(|may| ObjectPlace { index: may.object.index, sub: may.object.sub }).collect();
    let settings = of_type(|profile| profile.lacks.clone_from(&lacks));
    let mut far_end = far_end(&settings);
    for place in &lacks {
        far_end.aborting.push(((place.index, place.sub), 0x0602_0000));
    }
    let (mut drive, identity) = open(&mut far_end, settings).expect("it is not asked for what it lacks");
    assert_eq!((identity.device_name.as_str(), identity.firmware.as_str()), ("unknown", "unknown"));
    assert_eq!(drive.available_torque_nm(), 2556.0);
    assert_eq!(drive.settings().profile.consequences().len(), 8);
    let narrower = DriveLimits { max_torque_nm: 600.0, soft_limits_rad: [-1.0, 0.5] };
    drive.change_limits(narrower).expect("they fit");
    assert_eq!(drive.poll_change(&mut far_end, Duration::ZERO), Ok(true));
    assert_eq!(drive.limits(), narrower);
}

#[test]
fn what_keeps_an_axis_safe_without_the_bench_may_not_be_lacked() {
    for index in [0x6007, 0x605A, 0x605E, 0x6060, 0x6072, 0x6075, 0x6076, 0x6085] {
        assert!(!MAY_LACK.iter().any(|may| may.object.index == index), "{index:04X}h");
    }
}

#[test]
fn a_start_up_list_comes_first_in_its_order_and_a_value_that_does_not_stick_is_refused() {
    let entry = |index, sub, value| StartUp {
        place: ObjectPlace { index, sub },
        data_type: objects::DataType::U16,
        value,
        why: "a test".to_owned(),
    };
    let settings = of_type(|profile| profile.start_up = vec![entry(0x6073, 0, 5000), entry(0x6066, 0, 20)]);
    let mut far_end = far_end(&settings);
    let (drive, _) = open(&mut far_end, settings.clone()).expect("a good drive");
    let first: Vec<_> =
        far_end.written.iter().take(2).map(|(index, _, data)| (*index, data.clone())).collect();
    let bytes = |value: u16| value.to_le_bytes().to_vec();
    assert_eq!(first, [(0x6073, bytes(5000)), (0x6066, bytes(20))]);
    assert!(
        (drive.available_torque_nm() - 600.0).abs() < 1e-9,
        "the limit that was just written is read: 10 A"
    );
    far_end.deaf.push((0x6073, 0));
    far_end.put(0x6073, 0, &1_u16.to_le_bytes());
    let text = open(&mut far_end, settings).expect_err("it keeps 1").to_string();
    assert!(text.contains("6073h:00 (start-up list): expected 5000, found 1"), "{text}");
}

#[test]
fn a_drive_of_another_type_is_refused_before_anything_is_written() {
    let of = |identity| of_type(|profile| profile.identity = identity);
    let any = ProfileIdentity::default();
    let identities = [
        (ProfileIdentity { vendor: Some(0x9B), ..any }, "1018h:01 (vendor id): expected 0000009Bh"),
        (ProfileIdentity { product: Some(1), ..any }, "1018h:02 (product code): expected 00000001h"),
        (
            ProfileIdentity { revisions: Some([0x1_0000, 0x1_0410]), ..any },
            "1018h:03 (revision number): expected 00010000h to 00010410h (profile `twin`), found 00010420h",
        ),
    ];
    for (identity, expected) in identities {
        let settings = of(identity);
        let mut far_end = far_end(&settings);
        let text = open(&mut far_end, settings).expect_err("another type").to_string();
        assert!(text.contains(expected), "{text}");
        assert!(far_end.written.is_empty());
    }
    let fitting = ProfileIdentity { vendor: Some(0x9A), revisions: Some([0x1_0420, 0x1_0420]), ..any };
    let settings = of(fitting);
    assert!(open(&mut far_end(&settings), settings).is_ok());
}

#[test]
fn a_heat_sink_is_read_by_sdo_once_a_second_and_is_not_known_after_ten_seconds_of_silence() {
    let settings = fixed();
    let mut far_end = far_end(&settings);
    let (mut drive, _) = open(&mut far_end, settings).expect("a good drive");
    drive.attach(Slot { outputs: 0..10, inputs: 0..24 });
    let seen = |drive: &mut Cia402| drive.decode(&[0; 24]).heat_sink_degc;
    far_end.put(0x22A3, 1, &70_i16.to_le_bytes());
    let at = Duration::from_millis;
    assert!(!drive.poll_heat_sink(&mut far_end, at(900), true), "not due yet");
    assert!(!drive.poll_heat_sink(&mut far_end, at(1200), false), "not now");
    assert!(drive.poll_heat_sink(&mut far_end, at(1300), true), "begun");
    assert_eq!(seen(&mut drive), 61.0);
    assert!(!drive.poll_heat_sink(&mut far_end, at(1301), false), "what was begun is brought to its end");
    assert_eq!(seen(&mut drive), 70.0);
    far_end.aborting.push(((0x22A3, 1), 0x0800_0000));
    for ms in (2000..11_300).step_by(100) {
        drive.poll_heat_sink(&mut far_end, at(ms), true);
        assert_eq!(seen(&mut drive), 70.0, "at {ms} ms");
    }
    drive.poll_heat_sink(&mut far_end, at(11_400), true);
    assert!(seen(&mut drive).is_nan());
    far_end.aborting.clear();
    for ms in (12_000..14_000).step_by(100) {
        drive.poll_heat_sink(&mut far_end, at(ms), true);
    }
    assert_eq!(seen(&mut drive), 70.0, "it answers again");
}

#[test]
fn a_type_that_does_not_tell_its_temperature_shows_none() {
    let settings = of_type(|profile| {
        profile.heat_sink = None;
        let ProcessData::Mapped(entries) = &mut profile.inputs else { unreachable!("a mapping") };
        entries.retain(|entry| entry.index != 0x22A3);
    });
    let (mut drive, _) = open(&mut far_end(&settings), settings).expect("a good drive");
    drive.attach(Slot { outputs: 0..10, inputs: 0..26 });
    assert!(drive.decode(&[0; 26]).heat_sink_degc.is_nan());
    assert!(!drive.poll_heat_sink(&mut Dictionary::default(), Duration::from_secs(60), true));
}
