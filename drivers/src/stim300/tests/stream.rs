//! Datagrams in streams that begin, break and resume anywhere.

use proptest::prelude::*;

use super::*;
use crate::framing::WaitingBytes;

#[test]
fn line_ends_behind_datagrams_belong_to_them() {
    let mut stream = bytes(RATE_ACC_INCL);
    stream.extend(bytes(RATE));
    stream.extend(b"\r\n");
    stream.extend(bytes(RATE_ACC));
    let (all, tally) = found(&stream);
    assert_eq!((all.len(), tally), (3, Tally::default()));
    stream.extend(b"\n\r\n");
    assert_eq!(found(&stream).1.skipped_bytes_count, 3, "a line end that stands alone belongs to nothing");
}

#[test]
fn a_datagram_with_a_wrong_checksum_is_counted_and_the_next_one_is_found() {
    let mut stream = bytes(RATE_ACC);
    *stream.last_mut().expect("not empty") ^= 1;
    stream.extend(bytes(RATE_ACC));
    let (all, tally) = found(&stream);
    assert_eq!(all.len(), 1);
    assert_eq!((tally.bad_checksums_count, tally.skipped_bytes_count), (1, 28));
}

/// The gyro field holds an identifier: a parser that loses the first byte meets a false datagram inside the true one.
#[test]
fn a_datagram_inside_a_false_one_is_found() {
    let mut stream = vec![0xA7];
    stream.extend(numbered(0x0093_9091, 0, 2));
    stream.extend([0; 63]);
    let (all, _) = found(&stream);
    assert!(
        matches!(all.as_slice(), [Found::Measurement(one)] if one.gyros.counts[0] == i24([0x93, 0x90, 0x91]))
    );
}

#[test]
fn the_time_of_a_sample_is_that_of_the_poll_less_wire_and_latency() {
    let byte_s = 10.0 / 921_600.0;
    for behind in [0, 5, 20, 27] {
        let mut imu = driver(&AS_WANTED);
        // More than one read of the driver's buffer.
        let mut stream =
            [bytes(RATE_ACC), bytes(RATE_ACC), bytes(RATE_ACC), bytes(RATE_ACC), bytes(RATE_ACC)].concat();
        stream.extend(&bytes(RATE_ACC)[..behind]);
        assert_eq!(imu.poll(&mut WaitingBytes(stream), Duration::from_millis(50)).expect("it lives"), 5);
        let expected_s = 50e-3 - (28 + behind) as f64 * byte_s - 321e-6;
        let sampled_s = imu.sample().expect("five").sampled_at.as_secs_f64();
        assert_eq!([60, 61].map(|ms| imu.is_stale(Duration::from_millis(ms))), [false, true], "ten periods");
        assert!((sampled_s - expected_s).abs() < 3e-9, "{behind} bytes behind: {sampled_s} for {expected_s}");
    }
    // Even parity and two stop bits: 12 bits a character.
    let mut unit = AS_WANTED;
    unit[3] |= 0b1010;
    let mut imu = driver(&unit);
    imu.poll(&mut WaitingBytes(bytes(RATE_ACC)), Duration::from_millis(50)).expect("it lives");
    let sampled_s = imu.sample().expect("one").sampled_at.as_secs_f64();
    assert!((sampled_s - (50e-3 - 28.0 * 1.2 * byte_s - 321e-6)).abs() < 3e-9, "{sampled_s}");
}

proptest! {
    #[test]
    fn no_bytes_make_the_parser_panic(pieces in prop::collection::vec(noise(), 0..20)) {
        let mut imu = driver(&AS_WANTED);
        let bytes: usize = pieces.iter().map(Vec::len).sum();
        let mut measurements = 0;
        for piece in &pieces {
            measurements += imu.take(piece).unwrap_or(0) as usize;
        }
        prop_assert!(measurements * 28 <= bytes, "a measurement needs its bytes");
        prop_assert_eq!(imu.sample().is_some(), measurements > 0);
    }

    /// Whatever came before, however it is cut: once the longest false datagram is over, a valid one is found.
    #[test]
    fn a_valid_datagram_after_garbage_is_found(
        garbage in noise(),
        cut in 1..80_usize,
        place in 0..DATAGRAMS.len(),
        fill in any::<u8>(),
    ) {
        let (id, length, _) = DATAGRAMS[place];
        let good = datagram(id, &vec![fill; length - 5]);
        let mut stream = garbage;
        stream.extend(&good);
        stream.extend([0; 63]);
        let mut parser = Parser::default();
        let mut all = Vec::new();
        for piece in stream.chunks(cut) {
            parser.push(piece);
            while let Some(one) = parser.next() {
                all.push(one);
            }
        }
        prop_assert!(all.contains(&only(&good)), "{id:02X}h");
    }

    #[test]
    fn any_configuration_is_decoded_or_refused(payload in prop::array::uniform21(any::<u8>())) {
        if let Ok(configuration) = Configuration::decode(&payload) {
            prop_assert_eq!(configuration.content.id() & 0x80, 0x80);
            prop_assert!((10.0..=12.0).contains(&configuration.bits_per_byte()));
        }
    }
}

/// Bytes at random, rich in identifiers.
fn noise() -> impl Strategy<Value = Vec<u8>> {
    let byte =
        prop_oneof![any::<u8>(), prop::sample::select(vec![0x90, 0x91, 0xA7, 0xAF, 0xBC, 0xF7, 0x0D, 0x0A])];
    prop::collection::vec(byte, 0..200)
}
