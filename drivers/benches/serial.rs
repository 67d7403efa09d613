//! How fast the parsers of serial lines are.
//!
//! `…_of_a_second` is one second of a line at its full message rate, read in pieces of 128 bytes as the drivers read: the time
//! over 1 s is the share of a core. `…_false_headers` are the streams on which a parser works most for a byte.

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use drivers::crc32::crc32;
use drivers::{kvh, stim300};

/// Bytes that a driver reads at once.
const READ_BYTES: usize = 128;

fn main() {
    divan::main();
}

/// Format A, numbered, with varying content.
fn kvh_messages(count: u32) -> Vec<u8> {
    let mut stream = Vec::new();
    for number in 0..count {
        let mut message = vec![0xFE, 0x81, 0xFF, 0x55];
        for axis in 0..6_u16 {
            message.extend((1e-3 * (number as f32 + f32::from(axis))).sin().to_be_bytes());
        }
        message.extend([0x77, (number & 0x7F) as u8, 0, 29]);
        message.extend(crc32(&message).to_be_bytes());
        stream.extend(message);
    }
    stream
}

/// The longest measurement, F7h with CR LF, with varying content.
fn stim300_datagrams(count: u32) -> Vec<u8> {
    let mut stream = Vec::new();
    for number in 0..count {
        let mut datagram = vec![0xF7];
        datagram.extend(
            (0..58_u32)
                .map(|place| (number.wrapping_mul(2_654_435_761).wrapping_add(place * 977) >> 13) as u8),
        );
        datagram.extend(stim300::checksum(&datagram).to_be_bytes());
        datagram.extend(b"\r\n");
        stream.extend(datagram);
    }
    stream
}

fn kvh_parse(stream: &[u8]) -> u32 {
    let mut parser = kvh::Parser::default();
    let mut found_count = 0;
    for piece in stream.chunks(READ_BYTES) {
        parser.push(black_box(piece));
        while let Some(found) = parser.next() {
            black_box(found);
            found_count += 1;
        }
    }
    found_count
}

fn stim300_parse(stream: &[u8]) -> u32 {
    let mut parser = stim300::Parser::default();
    let mut found_count = 0;
    for piece in stream.chunks(READ_BYTES) {
        parser.push(black_box(piece));
        while let Some(found) = parser.next() {
            black_box(found);
            found_count += 1;
        }
    }
    found_count
}

/// Format A at 1 kHz: 36 kB on a line of 921600 bit/s.
#[divan::bench]
fn kvh_of_a_second(bencher: Bencher<'_, '_>) {
    let stream = kvh_messages(1000);
    assert_eq!(kvh_parse(&stream), 1000, "every message is found");
    bencher.counter(BytesCount::new(stream.len())).bench_local(|| kvh_parse(&stream));
}

/// F7h at 2 kHz: 130 kB on a line of 1843200 bit/s.
#[divan::bench]
fn stim300_of_a_second(bencher: Bencher<'_, '_>) {
    let stream = stim300_datagrams(2000);
    assert_eq!(stim300_parse(&stream), 2000, "every datagram is found");
    bencher.counter(BytesCount::new(stream.len())).bench_local(|| stim300_parse(&stream));
}

/// Nothing but headers of the longest format: a checksum every four bytes.
#[divan::bench]
fn kvh_false_headers(bencher: Bencher<'_, '_>) {
    let stream = [0xFE, 0x81, 0xFF, 0x56].repeat(25_000);
    assert_eq!(kvh_parse(&stream), 0);
    bencher.counter(BytesCount::new(stream.len())).bench_local(|| kvh_parse(&stream));
}

/// Nothing but identifiers of the longest datagram: a checksum every byte.
#[divan::bench]
fn stim300_false_headers(bencher: Bencher<'_, '_>) {
    let stream = [0xF7].repeat(100_000);
    assert_eq!(stim300_parse(&stream), 0);
    bencher.counter(BytesCount::new(stream.len())).bench_local(|| stim300_parse(&stream));
}
