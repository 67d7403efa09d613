mod configure;

use super::*;
use crate::crc32::crc32;
use crate::framing::WaitingBytes;
use proptest::prelude::*;

/// Bytes as printed in documents.
fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|pair| u8::from_str_radix(pair, 16).expect("hex digits")).collect()
}

const EARLY: &str = "FE 81 FF 55 3B 04 1F 78 B9 B9 66 13 BA 23 4B 38 BB 7C 04 10 B8 DE F4 80 3F 7F 4B 7B 70 \
                     1F 00 1D F1 2F B6 EE";
const BASIC: &str = "FE 81 FF 55 B3 D0 BB E7 32 19 3E F4 30 AC 19 A5 BA 8F 78 D6 3A 29 05 94 3F 7E CB D4 77 \
                     68 00 1D AD C5 F6 51";
const BAD_CRC: &str = "FE 81 FF 55 B4 6B 86 C6 B4 4F 5B 83 B4 10 6D 09 BB 71 3C B7 BB AB D9 14 3F 7E 31 9A \
                       77 69 00 1D 95 BB DB 4F";
const SECOND: &str = "FE 81 FF 55 37 A9 6A 6E 38 58 6C 1F B7 5B F8 62 BF 80 3E 78 BB 65 0D 28 3B 0A 37 AC 77 \
                      3D 00 28 4B FA 34 D8";
const A: &str = "FE 81 FF 55 3C 23 D7 0A BC A3 D7 0A 3C F5 C2 8F 00 00 00 00 00 00 00 00 3F 80 00 00 77 00 00 \
                 19 5E E3 14 5D";
const B: &str = "FE 81 FF 56 3C 23 D7 0A BC A3 D7 0A 3C F5 C2 8F 00 00 00 00 00 00 00 00 3F 80 00 00 00 00 03 \
                 E8 77 01 00 19 C3 30 B7 4B";
const C: &str = "FE 81 FF 57 3C 23 D7 0A BC A3 D7 0A 3C F5 C2 8F 00 00 00 00 00 00 00 00 3F 80 00 00 41 C8 00 \
                 00 77 04 28 8E B4 F1";

fn settings() -> KvhSettings {
    KvhSettings {
        name: "imu".into(),
        baud: 4_147_200,
        format: Format::A,
        synchronisation: Synchronisation::External,
        message_rate_hz: 1000.0,
        rate_output: true,
        answer_timeout_s: 0.1,
    }
}

fn driver(rate_output: bool) -> Kvh {
    Kvh::new(
        KvhSettings { rate_output, ..settings() },
        KvhIdentity { serial: "1".into(), configuration: Vec::new() },
    )
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

fn message(stream: &str) -> Message {
    match found(&bytes(stream)).0.as_slice() {
        [Found::Message(message)] => *message,
        other => panic!("{other:?}"),
    }
}

#[test]
fn captures_of_real_units_are_decoded() {
    let early = message(EARLY);
    assert_eq!((early.status, early.sequence), (0x70, 31));
    assert_eq!(early.temperature, Temperature::Degc(29.0));
    let basic = message(BASIC);
    assert_eq!((basic.status, basic.sequence), (0x77, 104));
    assert_printed(basic.rotation, [-9.719_934e-8, 8.920_086e-9, 1.252_194e-9]);
    assert_printed(basic.acceleration_g, [-1.094_605e-3, 6.447_67e-4, 0.995_297_7]);
    let second = message(SECOND);
    assert_eq!((second.status, second.sequence, second.temperature), (0x77, 61, Temperature::Degc(40.0)));
    assert_printed(second.rotation, [2.019_593e-5, 5.159_911e-5, -1.311_125e-5]);
    assert_printed(second.acceleration_g, [-1.001_906_4, -3.495_047e-3, 2.109_031e-3]);
}

/// Equal within half a unit of the seventh printed digit.
fn assert_printed(found: [f32; 3], printed: [f32; 3]) {
    for (found, printed) in found.into_iter().zip(printed) {
        assert!((found / printed - 1.0).abs() < 5e-7, "{found} is not {printed}");
    }
}

#[test]
fn a_capture_with_a_wrong_checksum_is_thrown_away_and_counted() {
    let (all, tally) = found(&bytes(BAD_CRC));
    assert!(all.is_empty());
    assert_eq!(tally.bad_checksums_count, 1);
    let mut repaired = bytes(BAD_CRC);
    repaired[32..].copy_from_slice(&[0x14, 0xDC, 0x0D, 0x3A]);
    assert_eq!(found(&repaired).0.len(), 1, "the document's own correction");
}

#[test]
fn all_three_formats_carry_the_same_motion() {
    for (text, format, sequence) in [(A, Format::A, 0), (B, Format::B, 1), (C, Format::C, 4)] {
        let message = message(text);
        assert_eq!((message.format, message.sequence, message.status), (format, sequence, 0x77));
        assert_eq!(message.rotation, [0.01, -0.02, 0.03]);
        assert_eq!(message.acceleration_g, [0.0, 0.0, 1.0]);
        assert_eq!(message.temperature, Temperature::Degc(25.0));
        assert_eq!(message.timestamp_us, (format == Format::B).then_some(1000));
    }
}

#[test]
fn format_c_brings_temperature_and_magnetic_field_in_turn() {
    let mut frame = bytes(C);
    for (sequence, expected) in [(4, None), (5, Some((0, 25.0))), (6, Some((1, 25.0))), (7, Some((2, 25.0)))]
    {
        frame[33] = sequence;
        let crc = crc32(&frame[..34]);
        frame[34..].copy_from_slice(&crc.to_be_bytes());
        let (all, _) = found(&frame);
        let [Found::Message(message)] = all.as_slice() else { panic!("{all:?}") };
        assert_eq!(message.magnetic_gauss, expected);
        assert_eq!(message.temperature == Temperature::NotInThisMessage, expected.is_some());
    }
}

#[test]
fn reports_of_the_built_in_test_are_checked_by_their_sum() {
    let good = |text: &str| match found(&bytes(text)).0.as_slice() {
        [Found::Bit(report)] => Some(*report),
        [] => None,
        other => panic!("{other:?}"),
    };
    assert!(good("FE 81 00 AA 7F 7F 7F 7F 7F 7F 23").expect("valid").passed());
    let magnetometer = good("FE 81 00 AB 7F 7F 7F 7F 7F 7F 37 7F DA").expect("valid");
    assert_eq!(magnetometer.failed().collect::<Vec<_>>(), [6 * 7 + 3, 6 * 7 + 6]);
    let flash = good("FE 81 00 AA 77 7F 7B 7F 7F 7F 17").expect("with the right sum");
    assert_eq!(flash.failed().collect::<Vec<_>>(), [3, 2 * 7 + 2]);
    assert_eq!(
        (BitReport::name(3), BitReport::name(41), BitReport::name(48)),
        ("gyro X flash", "software", "not named")
    );
    assert_eq!(flash.bytes().len(), 6);
    assert_eq!(good("FE 81 00 AA 77 7F 7B 7F 7F 7F 1E"), None, "as printed in the manual: wrong");
    assert_eq!(good("FE 81 00 AA 7F 7F 7F 7F 7F 7F 7F 7F 23"), None, "as printed in the manual: wrong");
}

#[test]
fn rates_and_increments_both_come_out_in_radians_per_second() {
    let mut rates = driver(true);
    assert_eq!(rates.take(&bytes(A)), 1);
    let sample = *rates.sample().expect("one message");
    assert_eq!(sample.rate_rad_per_s, [0.01_f32, -0.02, 0.03].map(f64::from));
    assert_eq!(sample.acceleration_m_per_s2, [0.0, 0.0, STANDARD_GRAVITY_M_PER_S2]);
    assert_eq!((sample.temperature_degc, sample.valid), (25.0, [true; 6]));
    let mut increments = driver(false);
    increments.take(&bytes(BASIC));
    let rate = increments.sample().expect("one message").rate_rad_per_s[0];
    assert!((rate / -9.719_934e-5 - 1.0).abs() < 1e-6, "1 kHz: {rate}");
}

#[test]
fn invalid_gyros_are_an_error_that_names_the_status() {
    let mut imu = driver(true);
    assert!(imu.valid_sample().is_err() && imu.is_stale(Duration::ZERO));
    imu.take(&bytes(EARLY));
    let error = imu.valid_sample().expect_err("70h").to_string();
    assert!(error.starts_with("imu: status byte: expected 77h, found 70h"), "{error}");
    assert_eq!(imu.sample().expect("it arrived").valid, [false, false, false, true, true, true]);
    imu.take(&bytes(BASIC));
    assert!(imu.valid_sample().is_ok());
}

/// 36 bytes at 4147200 bit/s take 86.8 µs (ICD 56-0298: 10 bits a character).
#[test]
fn a_message_was_sent_its_bytes_and_those_behind_it_before_the_poll() {
    let now = Duration::from_millis(7);
    for (behind, expected_us) in [(0, 86.806), (12, 86.806 + 28.935), (35, 86.806 + 84.394)] {
        let mut imu = driver(true);
        // Five messages: more than one read of the driver's buffer.
        let mut stream = bytes(&[A; 5].join(" "));
        stream.extend(&bytes(A)[..behind]);
        assert_eq!(imu.poll(&mut WaitingBytes(stream), now).expect("the line is there"), 5);
        let sent_us = (now - imu.sample().expect("five").sent_at).as_secs_f64() * 1e6;
        assert!((sent_us - expected_us).abs() < 2e-3, "{behind} bytes behind: {sent_us} µs");
        assert_eq!(imu.poll(&mut WaitingBytes(Vec::new()), 2 * now).expect("the line is there"), 0);
        assert!(imu.sample().expect("five").sent_at < now, "an old message keeps its time");
        // A unit with a pulse for each message is silent by polls that found none: one so far, ten are allowed.
        for polls in 2..=11 {
            assert!(!imu.is_stale(3 * now), "{polls}");
            imu.poll(&mut WaitingBytes(Vec::new()), 3 * now).expect("the line is there");
        }
        assert!(imu.is_stale(3 * now));
    }
}

/// A line that is gone.
struct Gone;

impl ByteLine for Gone {
    fn name(&self) -> &str {
        "line"
    }

    fn read(&mut self, _: Duration, _: &mut [u8]) -> Result<usize, DeviceError> {
        Err(DeviceError::Bus { device: "line".to_owned(), reason: "unplugged".to_owned() })
    }

    fn write(&mut self, _: Duration, _: &[u8]) -> Result<(), DeviceError> {
        self.read(Duration::ZERO, &mut []).map(|_| ())
    }
}

#[test]
fn the_newest_message_ages_on_a_line_that_is_gone() {
    let mut imu = driver(true);
    let at = Duration::from_millis;
    assert_eq!(imu.poll(&mut WaitingBytes(bytes(SECOND)), at(1)), Ok(1));
    for k in 1..=11 {
        imu.poll(&mut Gone, at(1 + k)).expect_err("it is gone");
        assert_eq!(u64::from(imu.age_ticks()), k);
    }
    assert!(imu.is_stale(at(12)) && (imu.silent_s(at(12)) - 0.011).abs() < 1e-12);
}

#[test]
fn lost_messages_are_counted_across_the_wrap() {
    let mut imu = driver(true);
    let numbered = |sequence: u8| {
        let mut frame = bytes(A);
        frame[29] = sequence;
        let crc = crc32(&frame[..32]);
        frame[32..].copy_from_slice(&crc.to_be_bytes());
        frame
    };
    for (sequence, missed) in [(126, 0), (127, 0), (0, 0), (1, 0), (4, 2), (3, 128)] {
        imu.take(&numbered(sequence));
        assert_eq!(imu.missed_count(), missed, "at {sequence}");
    }
}

#[test]
fn channels_are_ordered_widest_first_and_match_the_row() {
    let mut imu = driver(true);
    imu.take(&bytes(B));
    let row = imu.row();
    assert_eq!(row.len(), Kvh::CHANNELS.len());
    assert_eq!(row[6..], [25.0, f64::from(0x77), 1.0, 0.0]);
    assert_eq!(Kvh::CHANNELS[2].name, "rate_z_rad_per_s");
    assert_eq!(row[2], f64::from(0.03_f32));
    let narrow = Kvh::CHANNELS.iter().position(|channel| channel.width == Width::U16).expect("three");
    assert!(Kvh::CHANNELS[narrow..].iter().all(|channel| channel.width == Width::U16));
}

#[test]
fn a_flood_gives_up_the_oldest_bytes_and_finds_the_newest_frame() {
    let mut parser = Parser::default();
    let mut stream = vec![0x55; 5000];
    stream.extend(bytes(A));
    parser.push(&stream);
    assert!(matches!(parser.next(), Some(Found::Message(_))));
    parser.push(&bytes(B)[..20]);
    parser.push(&[0; 1020]);
    assert_eq!(parser.next(), None);
    assert_eq!(parser.tally().skipped_bytes_count, 5000 + 20 + 1020);
}

proptest! {
    #[test]
    fn no_bytes_make_the_parser_panic(pieces in prop::collection::vec(noise(), 0..20)) {
        let mut imu = driver(true);
        let bytes: usize = pieces.iter().map(Vec::len).sum();
        let messages: u32 = pieces.iter().map(|piece| imu.take(piece)).sum();
        prop_assert!(messages as usize * 36 <= bytes, "a message needs its bytes");
        prop_assert_eq!(imu.sample().is_some(), messages > 0);
    }

    /// Whatever came before, however it is cut: once the longest false frame is over, a valid one is found.
    #[test]
    fn a_valid_frame_after_garbage_is_found(garbage in noise(), cut in 1..50_usize, text in prop::sample::select(vec![A, B, C])) {
        let mut stream = garbage;
        stream.extend(bytes(text));
        let length = stream.len();
        stream.extend([0; 40]);
        let mut parser = Parser::default();
        let mut all = Vec::new();
        for piece in stream.chunks(cut) {
            parser.push(piece);
            while let Some(one) = parser.next() {
                all.push(one);
            }
        }
        prop_assert!(all.contains(&Found::Message(message(text))), "{length} bytes");
    }
}

/// Bytes at random, rich in pieces of headers.
fn noise() -> impl Strategy<Value = Vec<u8>> {
    let byte =
        prop_oneof![any::<u8>(), prop::sample::select(vec![0xFE, 0x81, 0xFF, 0x55, 0x56, 0x57, 0x00, 0xAA])];
    prop::collection::vec(byte, 0..150)
}
