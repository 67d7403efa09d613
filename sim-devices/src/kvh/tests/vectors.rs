//! Bytes of the simulated unit: captures of real units, calculated messages, and whatever it can say through the driver's parser.

use proptest::prelude::*;

use super::*;
use crate::kvh::message::{Content, bit_report};
use drivers::kvh::{Found, Parser, Temperature};

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ")
}

fn only(bytes: &[u8]) -> Found {
    let mut parser = Parser::default();
    parser.push(bytes);
    let found = parser.next().expect("a frame");
    assert_eq!((parser.next(), parser.tally()), (None, drivers::kvh::Tally::default()));
    found
}

/// Rotation (0.01, -0.02, 0.03), acceleration (0, 0, 1), all valid, 25 degC.
const CALCULATED: Content = Content {
    rotation: [0.01, -0.02, 0.03],
    acceleration: [0.0, 0.0, 1.0],
    temperature: 25.0,
    time_s: 1e-3,
    status: 0x77,
    sequence: 0,
};

#[test]
fn the_calculated_messages_are_what_the_unit_sends() {
    for (format, sequence, expected) in [
        (
            Format::A,
            0,
            "FE 81 FF 55 3C 23 D7 0A BC A3 D7 0A 3C F5 C2 8F 00 00 00 00 00 00 00 00 3F 80 00 00 77 00 00 19 5E E3 \
             14 5D",
        ),
        (
            Format::B,
            1,
            "FE 81 FF 56 3C 23 D7 0A BC A3 D7 0A 3C F5 C2 8F 00 00 00 00 00 00 00 00 3F 80 00 00 00 00 03 E8 77 01 \
             00 19 C3 30 B7 4B",
        ),
        (
            Format::C,
            4,
            "FE 81 FF 57 3C 23 D7 0A BC A3 D7 0A 3C F5 C2 8F 00 00 00 00 00 00 00 00 3F 80 00 00 41 C8 00 00 77 04 \
             28 8E B4 F1",
        ),
    ] {
        assert_eq!(hex(Content { sequence, ..CALCULATED }.frame(format).bytes()), expected, "{format:?}");
    }
}

/// What the driver reads of a capture is what the unit must be told to send the same bytes.
#[test]
fn captures_of_real_units_are_sent_again_byte_for_byte() {
    for capture in [
        "FE 81 FF 55 3B 04 1F 78 B9 B9 66 13 BA 23 4B 38 BB 7C 04 10 B8 DE F4 80 3F 7F 4B 7B 70 1F 00 1D F1 2F B6 EE",
        "FE 81 FF 55 B3 D0 BB E7 32 19 3E F4 30 AC 19 A5 BA 8F 78 D6 3A 29 05 94 3F 7E CB D4 77 68 00 1D AD C5 F6 51",
        "FE 81 FF 55 37 A9 6A 6E 38 58 6C 1F B7 5B F8 62 BF 80 3E 78 BB 65 0D 28 3B 0A 37 AC 77 3D 00 28 4B FA 34 D8",
    ] {
        let bytes: Vec<u8> =
            capture.split(' ').map(|pair| u8::from_str_radix(pair, 16).expect("hex digits")).collect();
        let Found::Message(read) = only(&bytes) else { panic!("a message") };
        let Temperature::Degc(temperature) = read.temperature else { panic!("format A has it") };
        let content = Content {
            rotation: read.rotation,
            acceleration: read.acceleration_g,
            temperature,
            time_s: 0.0,
            status: read.status,
            sequence: read.sequence,
        };
        assert_eq!(hex(content.frame(read.format).bytes()), capture);
    }
}

#[test]
fn reports_of_the_built_in_test_carry_their_sum() {
    let good = [0x7F; 8];
    assert_eq!(hex(bit_report(&good, 6).bytes()), "FE 81 00 AA 7F 7F 7F 7F 7F 7F 23");
    let magnetometer = [0x7F, 0x7F, 0x7F, 0x7F, 0x7F, 0x7F, 0x37, 0x7F];
    assert_eq!(hex(bit_report(&magnetometer, 8).bytes()), "FE 81 00 AB 7F 7F 7F 7F 7F 7F 37 7F DA");
    let flash = [0x77, 0x7F, 0x7B, 0x7F, 0x7F, 0x7F, 0x7F, 0x7F];
    assert_eq!(hex(bit_report(&flash, 6).bytes()), "FE 81 00 AA 77 7F 7B 7F 7F 7F 17");
}

#[test]
fn a_self_test_that_fails_reaches_the_host_by_number() {
    let mut pair = Pair::open(&perfect(), driver_settings(), &Motion::default());
    [3, 45, 48, 99].into_iter().for_each(|test| pair.unit.borrow_mut().fail_self_test(test));
    pair.driver.request_bit(&mut pair.line, at(pair.tick)).expect("the line is there");
    (0..4).for_each(|_| {
        pair.tick(&Motion::default());
    });
    let report = pair.driver.bit().expect("within 100 ms");
    assert_eq!(report.failed().collect::<Vec<_>>(), [3, 45, 48]);
}

proptest! {
    #[test]
    fn every_message_is_read_as_it_was_meant(
        rotation in prop::array::uniform3(-10.0..10.0_f32),
        acceleration in prop::array::uniform3(-10.0..10.0_f32),
        temperature in -50..100_i8,
        time_us in any::<u32>(),
        status in any::<u8>(),
        sequence in 0..128_u8,
        format in prop::sample::select(vec![Format::A, Format::B, Format::C]),
    ) {
        let temperature = f32::from(temperature);
        let time_s = f64::from(time_us) * 1e-6;
        let content = Content { rotation, acceleration, temperature, time_s, status, sequence };
        let Found::Message(read) = only(content.frame(format).bytes()) else { panic!("a message") };
        prop_assert_eq!((read.format, read.status, read.sequence), (format, status, sequence));
        prop_assert_eq!((read.rotation, read.acceleration_g), (rotation, acceleration));
        prop_assert_eq!(read.timestamp_us, (format == Format::B).then_some(time_us));
        if format != Format::C || sequence % 4 == 0 {
            prop_assert_eq!(read.temperature, Temperature::Degc(temperature));
        }
    }

    /// Whatever stands in front of a message, it is found once the longest false frame is over.
    #[test]
    fn behind_a_cut_the_next_message_is_found(cut in 0..36_usize, sequence in 0..128_u8) {
        let content = Content { sequence, ..CALCULATED };
        let frame = content.frame(Format::A);
        let mut parser = Parser::default();
        parser.push(&frame.bytes()[cut..]);
        parser.push(frame.bytes());
        parser.push(&[0; 40]);
        let mut all = Vec::new();
        while let Some(found) = parser.next() {
            all.push(found);
        }
        prop_assert!(all.contains(&only(frame.bytes())));
    }
}
