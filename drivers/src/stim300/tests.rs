mod configure;
mod stream;

use super::datagram::{Announced, i24};
use super::*;
use crate::kvh::STANDARD_GRAVITY_M_PER_S2;

/// Calculated datagrams: gyros +1, −1, +0.5 °/s; accelerometers and inclinometers 0, 0, 1 g at 10 g range; counter 8; 321 µs.
const RATE: &str = "90 00 40 00 FF C0 00 00 20 00 00 08 01 41 08 91 17 D6";
const RATE_ACC: &str = "91 00 40 00 FF C0 00 00 20 00 00 00 00 00 00 00 00 08 00 00 00 08 01 41 72 2D 9F 01";
const RATE_ACC_INCL: &str = "93 00 40 00 FF C0 00 00 20 00 00 00 00 00 00 00 00 08 00 00 00 00 00 00 00 00 00 \
                             40 00 00 00 08 01 41 84 B6 4C 93 0D 0A";

fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|pair| u8::from_str_radix(pair, 16).expect("hex digits")).collect()
}

/// Identifier and payload with their checksum.
fn datagram(id: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![id];
    bytes.extend(payload);
    bytes.extend(checksum(&bytes).to_be_bytes());
    bytes
}

fn found(stream: &[u8]) -> (Vec<Found>, Tally) {
    let mut parser = Parser::default();
    parser.push(stream);
    let mut all = Vec::new();
    while let Some(one) = parser.next() {
        all.push(one);
    }
    (all, parser.tally())
}

fn only(stream: &[u8]) -> Found {
    let (all, tally) = found(stream);
    assert_eq!(tally, Tally::default(), "{stream:02X?}");
    match all.as_slice() {
        [one] => *one,
        other => panic!("{other:?}"),
    }
}

fn measurement(stream: &[u8]) -> Measurement {
    match only(stream) {
        Found::Measurement(measurement) => measurement,
        other => panic!("{other:?}"),
    }
}

fn special(stream: &[u8]) -> Special {
    match only(stream) {
        Found::Special(special) => special,
        other => panic!("{other:?}"),
    }
}

const RATE_ACC_CONTENT: Content =
    Content { accelerometers: true, inclinometers: false, temperatures: false, input: Input::None };

fn settings() -> Stim300Settings {
    Stim300Settings {
        name: "imu".into(),
        bit_rate: 921_600,
        content: RATE_ACC_CONTENT,
        sample_rate: SampleRate::Internal(1000),
        gyro_unit: GyroUnit::Rate,
        accelerometer_unit: ForceUnit::Acceleration,
        may_change_unit: true,
        answer_timeout_s: 0.1,
    }
}

/// Configuration datagram of a unit that is as [`settings`] want it: revision K, firmware 9, all axes, 262 Hz, 10 g.
const AS_WANTED: [u8; 21] =
    [b'K', 9, 0x62, 0x21, 0x70, 0x44, 0x40, 0x70, 0x44, 0x40, 0x70, 0x44, 0x43, 0x0C, 0, 0, 0, 0, 0, 0, 0];

/// A unit that was opened with this configuration datagram.
fn driver(payload: &[u8; 21]) -> Stim300 {
    let configuration = Configuration::decode(payload).expect("listed codes");
    let settings = Stim300Settings { content: configuration.content, ..settings() };
    let identity = Stim300Identity { part_number: "P".into(), serial: "N1".into(), configuration };
    Stim300::new(settings, identity)
}

/// A measurement 91h with counts in the first gyro and the last accelerometer.
fn numbered(gyro_x: i32, accelerometer_z: i32, counter: u8) -> Vec<u8> {
    let mut payload = [0; 23];
    payload[..3].copy_from_slice(&gyro_x.to_be_bytes()[1..]);
    payload[16..19].copy_from_slice(&accelerometer_z.to_be_bytes()[1..]);
    payload[20] = counter;
    datagram(0x91, &payload)
}

#[test]
fn the_calculated_datagrams_are_decoded() {
    for (text, id) in [(RATE, 0x90), (RATE_ACC, 0x91), (RATE_ACC_INCL, 0x93)] {
        let measurement = measurement(&bytes(text));
        assert_eq!(measurement.content.id(), id);
        assert_eq!(measurement.gyros, Triad { counts: [1 << 14, -(1 << 14), 1 << 13], status: 0 });
        assert_eq!((measurement.counter, measurement.latency_us), (8, 321));
        let acceleration = if measurement.content.accelerometers { 1 << 19 } else { 0 };
        assert_eq!(measurement.accelerometers.counts, [0, 0, acceleration]);
        let inclination = if measurement.content.inclinometers { 1 << 22 } else { 0 };
        assert_eq!(measurement.inclinometers.counts, [0, 0, inclination]);
    }
}

#[test]
fn the_calculated_datagrams_come_out_in_si_units() {
    let mut imu = driver(&AS_WANTED);
    assert_eq!(imu.take(&bytes(RATE_ACC)).expect("the right datagram"), 1);
    let sample = imu.sample().expect("one measurement");
    assert_eq!(sample.rate_rad_per_s, [1.0_f64, -1.0, 0.5].map(f64::to_radians));
    assert_eq!(sample.acceleration_m_per_s2, [0.0, 0.0, STANDARD_GRAVITY_M_PER_S2]);
    assert_eq!((sample.valid, sample.counter), ([true; 6], 8));
    assert_eq!((sample.temperature_degc, sample.inclination_m_per_s2), (None, None));
    assert!((sample.latency_s - 321e-6).abs() < 1e-12);
}

/// Table 2 of the protocol page (TS1524, tables 5-12, 5-21, 5-22): identifier, bytes without CR LF, zero bytes of the checksum.
const DATAGRAMS: [(u8, usize, usize); 34] = [
    (0x90, 18, 2),
    (0x91, 28, 0),
    (0x92, 28, 0),
    (0x93, 38, 2),
    (0x94, 25, 3),
    (0xA5, 42, 2),
    (0xA6, 42, 2),
    (0xA7, 59, 1),
    (0xF0, 22, 2),
    (0xF1, 32, 0),
    (0xF2, 32, 0),
    (0xF3, 42, 2),
    (0xF4, 29, 3),
    (0xF5, 46, 2),
    (0xF6, 46, 2),
    (0xF7, 63, 1),
    (0x98, 22, 2),
    (0x99, 32, 0),
    (0x9A, 32, 0),
    (0x9B, 42, 2),
    (0x9C, 29, 3),
    (0xAD, 46, 2),
    (0xAE, 46, 2),
    (0xAF, 63, 1),
    (0xB1, 20, 0),
    (0xB3, 20, 0),
    (0xB5, 20, 0),
    (0xB7, 20, 0),
    (0xBC, 26, 2),
    (0xBD, 26, 2),
    (0xD1, 40, 0),
    (0xD2, 40, 0),
    (0xBE, 21, 3),
    (0xBF, 21, 3),
];

#[test]
fn every_identifier_of_the_datasheet_has_its_length_and_its_zero_bytes() {
    for (id, length, zeros) in DATAGRAMS {
        assert_eq!(Announced::by_id(id).map(Announced::bytes), Some(length), "{id:02X}h");
        let bytes: Vec<u8> =
            std::iter::once(id).chain((0..length as u8 - 5).map(|k| k.wrapping_mul(73))).collect();
        let mut filled = bytes.clone();
        filled.extend(&[0; 3][..zeros]);
        assert_eq!(checksum(&bytes), crate::crc32::crc32(&filled), "{id:02X}h");
        assert_eq!(Content::by_id(id).map(Content::id), Content::by_id(id).map(|_| id), "{id:02X}h");
    }
    let known = (0..=255).filter(|&id| Announced::by_id(id).is_some()).count();
    assert_eq!(known, DATAGRAMS.len(), "and no others");
}

#[test]
fn temperatures_and_the_last_field_stand_behind_all_sensors() {
    let mut payload = [0; 58];
    payload[30..32].copy_from_slice(&(25 * 256_i16).to_be_bytes());
    payload[32..34].copy_from_slice(&(28 * 256_i16).to_be_bytes());
    payload[34..36].copy_from_slice(&(-2 * 256_i16).to_be_bytes());
    payload[44..46].copy_from_slice(&(-256_i16).to_be_bytes());
    payload[51..54].copy_from_slice(&[0x01, 0xE2, 0x40]);
    payload[55] = 7;
    let measurement = measurement(&datagram(0xF7, &payload));
    assert_eq!(measurement.temperatures[0].counts, [6400, 7168, -512]);
    assert_eq!(measurement.temperatures[2].counts, [-256, 0, 0]);
    assert_eq!((measurement.input, measurement.counter), (123_456, 7));
    let mut unit = AS_WANTED;
    unit[2] = 0x7E;
    let mut imu = driver(&unit);
    imu.take(&datagram(0xF7, &payload)).expect("as configured");
    let sample = imu.sample().expect("one measurement");
    assert_eq!(sample.temperature_degc, Some(17.0));
    assert!(sample.since_pps_s.is_some_and(|s| (s - 0.123_456).abs() < 1e-12));
    assert_eq!(imu.row()[0], 17.0);
    payload[54] = 0x10;
    imu.take(&datagram(0xF7, &payload)).expect("as configured");
    assert_eq!(imu.sample().expect("another").since_pps_s, None, "no edge for more than 8.4 s");
    unit[13] = 0;
    let mut older = driver(&unit);
    older.take(&datagram(0xAF, &payload)).expect("as configured");
    let volts = older.sample().expect("one").aux_v.expect("AUX");
    assert!((volts - 123_456.0 * 5.0 / 16_777_216.0).abs() < 1e-12);
}

/// Counts of 1 g, and of 1 m/s per measurement at 1 kHz, by range (TS1524, section 7.5.2.2).
#[test]
fn the_scale_of_the_accelerometers_is_that_of_the_reported_range() {
    for (code, per_g, per_m_per_s) in
        [(0x3, 1 << 20, 1 << 23), (0x0, 1 << 19, 1 << 22), (0x4, 1 << 18, 1 << 21), (0x6, 1 << 16, 1 << 19)]
    {
        let mut unit = AS_WANTED;
        (unit[16], unit[17]) = (code << 4 | code, code << 4);
        let mut imu = driver(&unit);
        imu.take(&numbered(0, per_g, 0)).expect("as configured");
        let z = imu.sample().expect("one").acceleration_m_per_s2[2];
        assert_eq!(z, STANDARD_GRAVITY_M_PER_S2, "code {code}");
        unit[7] = 0x71;
        let mut imu = driver(&unit);
        imu.take(&numbered(0, per_m_per_s / 1000, 0)).expect("as configured");
        let z = imu.sample().expect("one").acceleration_m_per_s2[2];
        let expected = 1000.0 * f64::from(per_m_per_s / 1000) / f64::from(per_m_per_s);
        assert!((z - expected).abs() < 1e-12, "code {code}: {z} for {expected}");
    }
}

#[test]
fn every_gyro_unit_gives_rates() {
    let rates = |unit_code: u8, first: i32, second: i32| {
        let mut unit = AS_WANTED;
        unit[4] = 0x70 | unit_code;
        let mut imu = driver(&unit);
        imu.take(&numbered(first, 0, 10)).expect("as configured");
        let valid = imu.sample().expect("one").valid[0];
        imu.take(&numbered(second, 0, 12)).expect("as configured");
        (valid, imu.sample().expect("two").rate_rad_per_s[0].to_degrees())
    };
    for delayed in [0, 8] {
        for unit_code in [0, 2] {
            let (valid, rate) = rates(unit_code | delayed, 0, 3 << 14);
            assert!(valid && (rate - 3.0).abs() < 1e-12, "{rate}");
        }
        // 2²¹ counts a degree, 1 ms a measurement.
        let (valid, increment) = rates(1 | delayed, 0, 2097);
        assert!(valid && (increment - 2097.0 / 2_097_152.0 * 1000.0).abs() < 1e-9, "{increment}");
        // Across the wrap at ± 4°.
        let (valid, integrated) = rates(3 | delayed, (1 << 23) - 1000, -(1 << 23) + 1097);
        assert!(!valid, "one angle is no rate");
        assert!((integrated - 2097.0 / 2_097_152.0 * 1000.0).abs() < 1e-9, "{integrated}");
    }
}

#[test]
fn a_status_byte_says_which_axes_are_valid() {
    for (status, expected) in [
        (0x00, [true, true, true]),
        (0x40, [false; 3]),
        (0x80, [false; 3]),
        (0x20, [false; 3]),
        (0x11, [false, true, true]),
        (0x0A, [true, false, true]),
        (0x1C, [true, true, false]),
        (0x08, [false; 3]),
    ] {
        let mut payload = [0; 23];
        (payload[9], payload[19]) = (status, 0x12);
        let mut imu = driver(&AS_WANTED);
        imu.take(&datagram(0x91, &payload)).expect("as configured");
        let sample = imu.sample().expect("one");
        assert_eq!((&sample.valid[..3], &sample.valid[3..]), (&expected[..], &[true, false, true][..]));
        assert_eq!(imu.valid_sample().is_ok(), status == 0);
        assert_eq!(imu.row()[8], f64::from(status) + 256.0 * 18.0);
    }
    let error = driver(&AS_WANTED).valid_sample().expect_err("nothing came").to_string();
    assert!(
        error.starts_with("imu: status byte of the gyros: expected 00h, found no measurement;"),
        "{error}"
    );
}

/// At 1 kHz the counter goes by 2 from measurement to measurement.
#[test]
fn gaps_of_the_counter_are_lost_measurements() {
    let mut imu = driver(&AS_WANTED);
    for (counter, missed) in [(250, 0), (252, 0), (254, 0), (0, 0), (2, 0), (8, 2), (6, 128)] {
        imu.take(&numbered(0, 0, counter)).expect("as configured");
        assert_eq!(imu.missed_count(), missed, "at {counter}");
    }
}

#[test]
fn what_special_datagrams_replace_is_not_lost() {
    let mut imu = driver(&AS_WANTED);
    imu.take(&numbered(0, 0, 0)).expect("as configured");
    imu.take(&datagram(0xBE, &[0; 16])).expect("no configuration");
    imu.take(&numbered(0, 0, 4)).expect("as configured");
    assert_eq!((imu.missed_count(), imu.replaced_count()), (0, 1));
    imu.take(&numbered(0, 0, 8)).expect("as configured");
    assert_eq!((imu.missed_count(), imu.replaced_count()), (1, 1), "nothing came in its place");
    // 26 bytes at 921600 bit/s need 282 µs: one place. More is a loss.
    imu.take(&datagram(0xBC, &AS_WANTED)).expect("the same configuration");
    imu.take(&numbered(0, 0, 14)).expect("as configured");
    assert_eq!((imu.missed_count(), imu.replaced_count()), (2, 2));
    assert_eq!(imu.special().map(Special::kind), Some(SpecialKind::Configuration));
}

/// Increments between external triggers are divided by the time that the counter shows; behind a special datagram it is not
/// known what an increment covers.
#[test]
fn with_an_external_trigger_the_counter_gives_the_interval() {
    let mut unit = AS_WANTED;
    (unit[2], unit[4]) = (0xA2, 0x71);
    let mut imu = driver(&unit);
    let mut next = |gyro_x, counter| {
        imu.take(&numbered(gyro_x, 0, counter)).expect("as configured");
        let sample = imu.sample().expect("one");
        (sample.valid[0], sample.rate_rad_per_s[0].to_degrees())
    };
    assert!(!next(2097, 0).0);
    assert_eq!(next(2 << 21, 20), (true, 200.0));
    imu.take(&datagram(0xBE, &[0; 16])).expect("no configuration");
    imu.take(&numbered(2097, 0, 40)).expect("as configured");
    assert!(!imu.sample().expect("one").valid[0]);
    assert_eq!(imu.missed_count(), 0);
}

#[test]
fn another_configuration_ends_the_use_of_the_unit() {
    let mut imu = driver(&AS_WANTED);
    let mut other = AS_WANTED;
    other[16] = 0x66;
    let error = imu.take(&datagram(0xBD, &other)).expect_err("80 g").to_string();
    assert!(
        error.starts_with("imu: configuration: expected that of the opening, found another one;"),
        "{error}"
    );
    let error = imu.take(&bytes(RATE)).expect_err("no accelerometers").to_string();
    assert!(error.starts_with("imu: datagram: expected 91h, found 90h;"), "{error}");
}

/// Part and serial number of the listing in TS1524, figure 8-1.
#[test]
fn part_and_serial_number_are_those_of_the_listing() {
    // Digit 12 stands in the low half of byte 11, digits 13 and 14 in byte 9, digit 15 in the high half of byte 10.
    let part = bytes("08 41 67 2D 44 00 00 2D 32 10 03 00 00 00 4B");
    let text = special(&datagram(0xB1, &part)).part_number();
    assert_eq!(text.as_deref(), Some("84167-4400003-321 REV K"));
    let serial = bytes("4E 25 58 24 05 00 20 02 00 00 00 00 00 00 00");
    let special_serial = special(&datagram(0xB7, &serial));
    assert_eq!(special_serial.serial_number().as_deref(), Some("N25582405002002"));
    assert_eq!((special_serial.part_number(), special_serial.bias_trim()), (None, None));
    let mut simulated = serial;
    simulated[8..11].copy_from_slice(b"SIM");
    assert_eq!(special(&datagram(0xB5, &simulated)).serial_number().as_deref(), Some("N25582405002002-SIM"));
    let strange = special(&datagram(0xB1, &[0xFF; 15])).part_number().expect("a part number");
    assert!(strange.is_ascii(), "{strange}");
}

#[test]
fn bias_trim_and_errors_are_told_by_name() {
    let mut payload = [0; 35];
    payload[0..3].copy_from_slice(&[0x00, 0x40, 0x00]);
    payload[15..18].copy_from_slice(&[0xF8, 0x00, 0x00]);
    payload[24..27].copy_from_slice(&[0x40, 0x00, 0x00]);
    payload[27..33].copy_from_slice(&[0, 0, 0xAA, 0x77, 0x27, 0x0F]);
    let mut imu = driver(&AS_WANTED);
    imu.take(&datagram(0xD1, &payload)).expect("no configuration");
    let trim = imu.bias_trim().expect("it came");
    assert_eq!(trim.gyro_rad_per_s, [1.0_f64.to_radians(), 0.0, 0.0]);
    assert_eq!((trim.accelerometer_g, trim.inclinometer_g), ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]));
    assert_eq!((trim.reference, trim.saves_left_count), (43_639, 9999));
    assert!(imu.extended_errors().is_none());
    let mut payload = [0; 16];
    (payload[0], payload[3], payload[13], payload[15]) = (0x80, 0x20, 0x01, 0x01);
    imu.take(&datagram(0xBF, &payload)).expect("no configuration");
    let errors = imu.extended_errors().expect("it came");
    assert_eq!(errors.numbers().collect::<Vec<_>>(), [0, 16, 101, 127]);
    assert!(!errors.is_empty() && ExtendedErrors::meaning(101).contains("overload"));
    assert!((0..=127).all(|number| !ExtendedErrors::meaning(number).is_empty()));
}

#[test]
fn codes_that_the_datasheet_does_not_list_are_not_guessed() {
    for (byte, value, field) in [
        (2, 0xE2, "sample rate"),
        (3, 0x41, "bit rate"),
        (3, 0x27, "parity"),
        (4, 0x77, "gyro output unit"),
        (5, 0x54, "low-pass filter"),
        (7, 0x75, "accelerometer output unit"),
        (10, 0x79, "inclinometer output unit"),
        (12, 0x44, "PPS output unit"),
        (17, 0x10, "accelerometer range"),
    ] {
        let mut payload = AS_WANTED;
        payload[byte] = value;
        let result = Configuration::decode(&payload);
        assert_eq!(result.map_err(|unknown| unknown.field), Err(field), "byte {byte}");
    }
}

#[test]
fn signed_numbers_of_24_bits_keep_their_sign() {
    for (bytes, value) in [([0x7F, 0xFF, 0xFF], 8_388_607), ([0x80, 0, 0], -8_388_608), ([0xFF; 3], -1)] {
        assert_eq!(i24(bytes), value);
    }
}

#[test]
fn channels_are_ordered_widest_first_and_match_the_row() {
    let imu = driver(&AS_WANTED);
    assert_eq!(imu.row().len(), Stim300::CHANNELS.len());
    assert!(imu.row()[0].is_nan(), "no temperature in this datagram");
    assert!(Stim300::CHANNELS_WITHOUT_TEMPERATURE.iter().all(|one| one.name != "temperature_degc"));
    let narrow = Stim300::CHANNELS.iter().position(|one| one.width == Width::U16).expect("three");
    assert!(Stim300::CHANNELS[narrow..].iter().all(|one| one.width == Width::U16));
}
