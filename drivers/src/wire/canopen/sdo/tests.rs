use super::*;
use proptest::prelude::*;

const NOW: Duration = Duration::from_secs(3);

/// A frame from its bytes in hexadecimal, as docs/protocols.md prints them.
fn bytes(text: &str) -> Vec<u8> {
    text.split(' ').map(|byte| u8::from_str_radix(byte, 16).expect("hexadecimal")).collect()
}

/// A transfer whose frames are listed, request and answer in turn; how it ends.
fn play(place: (u16, u8), write: Option<&[u8]>, rows: &[(&str, &str)]) -> Result<Vec<u8>, SdoAbort> {
    let mut client = SdoClient::new();
    let place = Place { index: place.0, sub: place.1 };
    let mut request = Some(client.start(NOW, 2, place, write));
    for (expected, answer) in rows {
        assert_eq!(request.map(|request| request.to_vec()), Some(bytes(expected)));
        request = client.take(&bytes(answer));
    }
    assert_eq!(request, None);
    client.take_outcome().expect("the transfer is over").map(<[u8]>::to_vec)
}

/// Section 4.2 of docs/protocols.md.
#[test]
fn expedited_transfers_have_the_published_frames() {
    let vendor = play((0x1018, 1), None, &[("40 18 10 01 00 00 00 00", "43 18 10 01 04 00 00 00")]);
    assert_eq!(vendor, Ok(vec![4, 0, 0, 0]));
    let heartbeat = 4000_u16.to_le_bytes();
    let rows = [("2B 17 10 00 A0 0F 00 00", "60 17 10 00 00 00 00 00")];
    assert_eq!(play((0x1017, 0), Some(&heartbeat), &rows), Ok(Vec::new()));
    let abort = play((0x1018, 1), None, &[("40 18 10 01 00 00 00 00", "80 18 10 01 11 00 09 06")]);
    assert_eq!(abort, Err(SdoAbort(0x0609_0011)));
    let mode = [("2F 60 60 00 09 00 00 00", "60 60 60 00 00 00 00 00")];
    assert_eq!(play((0x6060, 0), Some(&[9]), &mode), Ok(Vec::new()));
    let status = play((0x6041, 0), None, &[("40 41 60 00 00 00 00 00", "4B 41 60 00 37 06 00 00")]);
    assert_eq!(status, Ok(0x0637_u16.to_le_bytes().to_vec()));
}

#[test]
fn answers_that_are_shorter_or_tell_no_size_are_taken() {
    let short = play((0x1400, 2), None, &[("40 00 14 02 00 00 00 00", "4F 00 14 02 FE")]);
    assert_eq!(short, Ok(vec![0xFE]));
    let sizeless = play((0x1000, 0), None, &[("40 00 10 00 00 00 00 00", "42 00 10 00 92 01 02 00")]);
    assert_eq!(sizeless, Ok(vec![0x92, 0x01, 0x02, 0x00]));
    let both = play((0x6041, 0), None, &[("40 41 60 00 00 00 00 00", "42 41 60 00 37 06")]);
    assert_eq!(both, Ok(vec![0x37, 0x06]));
}

/// Section 4.2 of docs/protocols.md.
#[test]
fn segmented_transfers_have_the_published_frames() {
    let read = play(
        (0x1008, 0),
        None,
        &[
            ("40 08 10 00 00 00 00 00", "41 08 10 00 1A 00 00 00"),
            ("60 00 00 00 00 00 00 00", "00 54 69 6E 79 20 4E 6F"),
            ("70 00 00 00 00 00 00 00", "10 64 65 20 2D 20 4D 65"),
            ("60 00 00 00 00 00 00 00", "00 67 61 20 44 6F 6D 61"),
            ("70 00 00 00 00 00 00 00", "15 69 6E 73 20 21 00 00"),
        ],
    );
    assert_eq!(read, Ok(b"Tiny Node - Mega Domains !".to_vec()));
    let written = play(
        (0x2000, 0),
        Some(b"A long string"),
        &[
            ("21 00 20 00 0D 00 00 00", "60 00 20 00 00 00 00 00"),
            ("00 41 20 6C 6F 6E 67 20", "20 00 20 00 00 00 00 00"),
            ("13 73 74 72 69 6E 67 00", "30 00 20 00 00 00 00 00"),
        ],
    );
    assert_eq!(written, Ok(Vec::new()));
}

#[test]
fn nothing_at_all_is_written_as_one_empty_segment() {
    let rows = [
        ("21 00 20 00 00 00 00 00", "60 00 20 00 00 00 00 00"),
        ("0F 00 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"),
    ];
    assert_eq!(play((0x2000, 0), Some(&[]), &rows), Ok(Vec::new()));
}

/// A client that has begun to read 1008h in segments.
fn reading(size: u8) -> SdoClient {
    let mut client = SdoClient::new();
    client.start(NOW, 2, Place { index: 0x1008, sub: 0 }, None);
    let segment = client.take(&[0x41, 0x08, 0x10, 0, size, 0, 0, 0]);
    assert_eq!(segment, Some([0x60, 0, 0, 0, 0, 0, 0, 0]));
    client
}

#[test]
fn a_wrong_toggle_bit_ends_a_transfer_and_the_server_is_told() {
    let mut client = reading(26);
    let told = client.take(&[0x10, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(told, Some([0x80, 0x08, 0x10, 0, 0, 0, 0x03, 0x05]));
    assert_eq!(client.take_outcome(), Some(Err(SdoAbort(0x0503_0000))));
    assert_eq!(client.take(&[0x00, 1, 2, 3, 4, 5, 6, 7]), None, "what comes later is passed over");

    let mut client = SdoClient::new();
    client.start(NOW, 2, Place { index: 0x2000, sub: 0 }, Some(b"A long string"));
    client.take(&bytes("60 00 20 00 00 00 00 00"));
    assert_eq!(client.take(&[0x30; 8]), Some([0x80, 0, 0x20, 0, 0, 0, 0x03, 0x05]));
}

#[test]
fn segments_that_do_not_add_up_to_the_announced_size_are_refused() {
    let mut client = reading(6);
    assert_eq!(client.take(&[0x01, 1, 2, 3, 4, 5, 6, 7]).map(|told| told[0]), Some(0x80));
    assert_eq!(client.take_outcome(), Some(Err(SdoAbort(0x0607_0010))));
    let mut client = reading(8);
    client.take(&[0x01, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(client.take_outcome(), Some(Err(SdoAbort(0x0607_0010))));
    let mut client = SdoClient::new();
    client.start(NOW, 2, Place { index: 0x1008, sub: 0 }, None);
    client.take(&[0x41, 0x08, 0x10, 0, 0, 0, 0, 1]);
    assert_eq!(client.take_outcome(), Some(Err(SdoAbort(0x0504_0005))), "16 MB");
}

#[test]
fn a_silent_server_is_given_up_after_a_second() {
    let mut client = SdoClient::new();
    client.start(NOW, 2, Place { index: 0x1018, sub: 1 }, None);
    assert_eq!(client.expire(NOW + TIMEOUT - Duration::from_millis(1)), None);
    assert_eq!(client.take_outcome(), None);
    assert_eq!(client.expire(NOW + TIMEOUT), Some([0x80, 0x18, 0x10, 1, 0, 0, 0x04, 0x05]));
    assert_eq!(client.take_outcome(), Some(Err(SdoAbort(0x0504_0000))));
    assert_eq!(client.take(&[0x43, 0x18, 0x10, 1, 4, 0, 0, 0]), None, "too late");
    assert_eq!(client.take_outcome(), None);
}

#[test]
fn an_answer_to_an_earlier_transfer_is_passed_over() {
    let mut client = SdoClient::new();
    client.start(NOW, 2, Place { index: 0x1018, sub: 1 }, None);
    assert_eq!(client.take(&[0x43, 0x18, 0x10, 2, 9, 0, 0, 0]), None);
    assert_eq!(client.take(&[0x80, 0x18, 0x10, 2, 0, 0, 2, 6]), None);
    assert_eq!(client.take_outcome(), None);
    client.take(&[0x43, 0x18, 0x10, 1, 4, 0, 0, 0]);
    assert_eq!(client.take_outcome(), Some(Ok(&[4, 0, 0, 0][..])));
}

#[test]
fn an_answer_of_another_kind_ends_a_transfer() {
    let mut client = SdoClient::new();
    client.start(NOW, 2, Place { index: 0x1018, sub: 1 }, None);
    assert_eq!(client.take(&[0x60, 0x18, 0x10, 1, 0, 0, 0, 0]).map(|told| told[0]), Some(0x80));
    assert_eq!(client.take_outcome(), Some(Err(SdoAbort(0x0504_0001))));
}

/// A server that does what CiA 301 says with one object of bytes.
struct Server {
    object: Vec<u8>,
    at: usize,
}

impl Server {
    fn answer(&mut self, request: [u8; 8]) -> [u8; 8] {
        let [command, a, b, sub, ..] = request;
        let toggle = command & 0x10;
        match command >> 5 {
            2 if (1..=4).contains(&self.object.len()) => {
                let mut answer = [0x43 | ((4 - self.object.len()) as u8) << 2, a, b, sub, 0, 0, 0, 0];
                answer[4..4 + self.object.len()].copy_from_slice(&self.object);
                answer
            }
            2 => {
                self.at = 0;
                let [s, t, u, v] = (self.object.len() as u32).to_le_bytes();
                [0x41, a, b, sub, s, t, u, v]
            }
            3 => {
                let left = &self.object[self.at..];
                let count = left.len().min(7);
                let mut answer =
                    [toggle | ((7 - count) as u8) << 1 | u8::from(count == left.len()), 0, 0, 0, 0, 0, 0, 0];
                answer[1..1 + count].copy_from_slice(&left[..count]);
                self.at += count;
                answer
            }
            1 if command & 2 != 0 => {
                self.object = request[4..8 - usize::from(command >> 2 & 3)].to_vec();
                [0x60, a, b, sub, 0, 0, 0, 0]
            }
            1 => {
                self.object.clear();
                [0x60, a, b, sub, 0, 0, 0, 0]
            }
            _ => {
                self.object.extend(&request[1..8 - usize::from(command >> 1 & 7)]);
                [0x20 | toggle, 0, 0, 0, 0, 0, 0, 0]
            }
        }
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(object in prop::collection::vec(any::<u8>(), 0..200), index in any::<u16>()) {
        let mut server = Server { object: Vec::new(), at: 0 };
        let mut client = SdoClient::new();
        for write in [Some(&object[..]), None] {
            let mut request = Some(client.start(NOW, 1, Place { index, sub: 3 }, write));
            while let Some(bytes) = request {
                request = client.take(&server.answer(bytes));
            }
            prop_assert_eq!(&server.object, &object);
        }
        prop_assert_eq!(client.take_outcome(), Some(Ok(&object[..])));
    }

    #[test]
    fn no_answer_is_too_strange(
        answers in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=8), 1..40),
        writes in any::<bool>(),
    ) {
        let mut client = SdoClient::new();
        client.start(NOW, 1, Place::default(), writes.then_some(&b"A long string"[..]));
        for answer in &answers {
            let mut answer = answer.clone();
            if let Some(place) = answer.get_mut(1..4) {
                place.fill(0);
            }
            client.take(&answer);
        }
        client.expire(NOW + TIMEOUT);
        prop_assert!(client.take_outcome().is_some());
    }
}
