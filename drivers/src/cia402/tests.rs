mod change;
pub(super) mod dictionary;
mod open;
mod types;

use std::f64::consts::{PI, TAU};

use super::*;
use dictionary::{Dictionary, azimuth};
use proptest::prelude::*;

/// Opens a drive, letting a millisecond pass between two looks at the mailbox.
fn open(far_end: &mut Dictionary, settings: DriveSettings) -> Result<(Cia402, Identity), DeviceError> {
    let mut at = Duration::ZERO;
    let mut pause = || {
        at += Duration::from_millis(1);
        at
    };
    Cia402::open(far_end, settings, &mut Waiting { now: Duration::ZERO, pause: &mut pause })
}

/// A drive opened on the far end, its slot in the middle of a larger image.
fn opened(settings: DriveSettings) -> Cia402 {
    let mut far_end = Dictionary::of(&settings);
    let (mut drive, _) =
        open(&mut far_end, settings).expect("the far end is commissioned for these settings");
    drive.attach(Slot { outputs: 3..13, inputs: 5..33 });
    drive
}

/// The far end's process data as the mapping lays them out, bytes counted by hand.
fn inputs(position_counts: i32) -> [u8; 36] {
    let mut image = [0xEE; 36];
    image[5..7].copy_from_slice(&0x1637_u16.to_le_bytes());
    image[7..9].copy_from_slice(&0x4310_u16.to_le_bytes());
    image[9] = 10;
    image[11..15].copy_from_slice(&position_counts.to_le_bytes());
    image[15..19].copy_from_slice(&(-11_184_811_i32).to_le_bytes());
    image[19..21].copy_from_slice(&(-1500_i16).to_le_bytes());
    image[21..23].copy_from_slice(&(750_i16).to_le_bytes());
    image[23..27].copy_from_slice(&540_123_u32.to_le_bytes());
    image[27..29].copy_from_slice(&(-57_i16).to_le_bytes());
    image[29..33].copy_from_slice(&0x0001_0008_u32.to_le_bytes());
    image
}

#[test]
fn channels_are_ordered_widest_first_and_named_with_units() {
    let bytes = |width| match width {
        Width::F64 => 8,
        Width::F32 | Width::I32 | Width::U32 => 4,
        Width::U16 => 2,
        Width::I8 => 1,
    };
    let widths: Vec<_> = Cia402::CHANNELS.iter().map(|channel| bytes(channel.width)).collect();
    assert!(widths.is_sorted_by(|a, b| a >= b), "{widths:?}");
    assert_eq!(Cia402::CHANNELS.len(), Actuals::default().row().len());
    assert_eq!(Cia402::CHANNELS[6].name, "position_counts");
}

#[test]
fn inputs_are_decoded_from_their_bytes_to_si() {
    let mut drive = opened(azimuth());
    let actuals = drive.decode(&inputs(1 << 24));
    assert_eq!(actuals.position_rad, PI / 2.0);
    assert!((actuals.velocity_rad_per_s + 11_184_811.0 * TAU / f64::from(1 << 26)).abs() < 1e-12);
    assert_eq!(actuals.current_a, 1.5, "750 ‰ of 2 A");
    assert_eq!(actuals.torque_nm, -180.0, "1500 ‰ of 120 N·m");
    assert_eq!(actuals.bus_v, 540.123);
    assert_eq!(actuals.heat_sink_degc, -5.7);
    assert_eq!(
        actuals.row()[6..],
        [f64::from(1 << 24), f64::from(0x0001_0008), f64::from(0x1637), f64::from(0x4310), 10.0]
    );
}

#[test]
fn image_without_the_slot_reads_as_not_ready_and_sends_nothing() {
    let mut drive = opened(azimuth());
    let before = drive.decode(&inputs(1000));
    for short in [&[][..], &inputs(2000)[..32]] {
        let actuals = drive.decode(short);
        assert_eq!(actuals, Actuals { statusword: 0, ..before });
        assert_eq!(PowerState::of(actuals.statusword), PowerState::NotReady);
    }
    let mut outputs = [0x77; 12];
    assert_eq!(drive.encode(&torque_command(100.0), &mut outputs), 0.0);
    assert_eq!(outputs, [0x77; 12]);
}

fn torque_command(torque_nm: f64) -> DriveCommand {
    DriveCommand { controlword: 0x000F, mode: CyclicMode::Torque, torque_nm, velocity_rad_per_s: 0.0 }
}

#[test]
fn command_is_encoded_into_its_bytes_and_nowhere_else() {
    let drive = opened(DriveSettings { encoder_sign: -1.0, ..azimuth() });
    let mut outputs = [0xEE; 16];
    let command = DriveCommand {
        controlword: 0x011F,
        mode: CyclicMode::Velocity,
        torque_nm: 60.0,
        velocity_rad_per_s: 0.5,
    };
    assert_eq!(drive.encode(&command, &mut outputs), 60.0);
    let velocity = (-(0.5 * f64::from(1 << 26) / TAU).round() as i32).to_le_bytes();
    assert_eq!(outputs[..3], [0xEE; 3]);
    assert_eq!(outputs[3..7], [0x1F, 0x01, 0xF4, 0x01]);
    assert_eq!(outputs[7..11], velocity);
    assert_eq!(outputs[11..], [9, 0, 0xEE, 0xEE, 0xEE]);
}

#[test]
fn torque_rounds_to_the_nearest_permille_and_saturates() {
    let drive = opened(azimuth());
    let mut outputs = [0; 16];
    let mut sent = |torque_nm| drive.encode(&torque_command(torque_nm), &mut outputs);
    assert_eq!(sent(0.059), 0.0);
    assert_eq!(sent(0.061), 0.12);
    assert_eq!(sent(-0.061), -0.12);
    assert_eq!(sent(2556.0), 2556.0);
    assert_eq!(sent(1e9), 2556.0);
    assert_eq!(sent(f64::NEG_INFINITY), -2556.0);
    assert_eq!(sent(f64::NAN), 0.0);
}

#[test]
fn torque_beyond_the_word_saturates_at_the_word() {
    let drive = opened(DriveSettings { max_torque_nm: 6000.0, ..azimuth() });
    let sent = drive.encode(&torque_command(6000.0), &mut [0; 16]);
    assert!((sent - 32_767.0 * 0.12).abs() < 1e-9);
}

#[test]
fn velocity_saturates_at_the_speed_limit() {
    let drive = opened(azimuth());
    let mut outputs = [0; 16];
    let command =
        DriveCommand { mode: CyclicMode::Velocity, velocity_rad_per_s: -9.0, ..torque_command(0.0) };
    drive.encode(&command, &mut outputs);
    let counts = i32::from_le_bytes(outputs[7..11].try_into().expect("four bytes"));
    assert_eq!(counts, -(1.2 * f64::from(1 << 26) / TAU).round() as i32);
}

#[test]
fn attach_forgets_the_wrap_count() {
    let mut drive = opened(azimuth());
    drive.decode(&inputs((1 << 25) - 1));
    let over = drive.decode(&inputs(1 << 25)).position_rad;
    assert_eq!(over, PI);
    let past = drive.decode(&inputs((1 << 25) + 1)).position_rad;
    assert!(past > PI);
    drive.attach(Slot { outputs: 3..13, inputs: 5..33 });
    assert!(drive.decode(&inputs((1 << 25) + 1)).position_rad < -3.0);
}

#[test]
fn first_sample_half_a_turn_away_reads_plus_pi_whatever_the_sign() {
    for encoder_sign in [1.0, -1.0] {
        for count in [1 << 25, -(1 << 25)] {
            let mut drive = opened(DriveSettings { encoder_sign, ..azimuth() });
            assert_eq!(drive.decode(&inputs(count)).position_rad, PI);
        }
    }
}

proptest! {
    #[test]
    fn torque_survives_the_wire_within_half_a_permille(torque_nm in -2556.0..2556.0_f64) {
        let drive = opened(azimuth());
        let mut outputs = [0; 16];
        let sent = drive.encode(&torque_command(torque_nm), &mut outputs);
        let permille = i16::from_le_bytes([outputs[5], outputs[6]]);
        prop_assert!((sent - torque_nm).abs() <= 0.06 + 1e-9);
        prop_assert!((sent - f64::from(permille) * 0.12).abs() < 1e-9);
    }

    #[test]
    fn position_is_followed_over_many_turns(
        bits in 10_u32..=26,
        negative in any::<bool>(),
        offset_rad in -3.0..3.0_f64,
        start in any::<u32>(),
        steps in prop::collection::vec(-0.499..0.499_f64, 1..60),
        signed in any::<bool>(),
    ) {
        let counts_per_rev = 1_u32 << bits;
        let sign = if negative { -1.0 } else { 1.0 };
        let settings = DriveSettings {
            encoder_counts_per_rev: counts_per_rev,
            encoder_offset_rad: offset_rad,
            encoder_sign: sign,
            soft_limits_rad: [offset_rad - 1.0, offset_rad + 1.0],
            ..azimuth()
        };
        let mut drive = opened(settings);
        let modulus = i64::from(counts_per_rev);
        let wire = |count: i64| {
            let turn = count.rem_euclid(modulus);
            inputs(if signed && 2 * turn >= modulus { turn - modulus } else { turn } as i32)
        };
        let mut count = i64::from(start);
        let first = drive.decode(&wire(count)).position_rad;
        prop_assert!(first - offset_rad > -PI - 1e-9 && first - offset_rad <= PI + 1e-9);
        let mut expected = first;
        for step in steps {
            let moved = (step * modulus as f64) as i64;
            count += moved;
            expected += sign * moved as f64 * TAU / modulus as f64;
            prop_assert!((drive.decode(&wire(count)).position_rad - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn no_bytes_make_the_codec_panic(bytes in prop::collection::vec(any::<u8>(), 0..40)) {
        let mut drive = opened(azimuth());
        let actuals = drive.decode(&bytes);
        prop_assert!(actuals.row().iter().all(|value| value.is_finite()));
    }
}
