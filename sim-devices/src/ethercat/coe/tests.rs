//! The SDO server and its list of objects, without a mailbox around them.

use super::*;
use crate::ethercat::tests::toy::Toy;

/// What a mailbox of 128 bytes holds beside its header.
const ROOM: usize = 122;

/// A server in front of a toy.
struct Bench {
    server: SdoServer,
    toy: Toy,
    room: usize,
}

fn bench(toy: Toy) -> Bench {
    Bench { server: SdoServer::default(), toy, room: ROOM }
}

impl Bench {
    /// Answers to a whole CoE message.
    fn all(&mut self, message: &[u8]) -> Vec<Vec<u8>> {
        self.server.answer(&mut self.toy, message, self.room).expect("a known service")
    }

    /// The answer to an SDO, without CoE header.
    fn sdo(&mut self, request: &[u8]) -> Vec<u8> {
        let message = [&[0, SDO_REQUEST << 4][..], request].concat();
        let mut answers = self.all(&message);
        assert_eq!(answers.len(), 1);
        let answer = answers.remove(0);
        let service = if answer[2] == 0x80 { SDO_REQUEST } else { SDO_RESPONSE };
        assert_eq!(answer[..2], [0, service << 4]);
        answer[2..].to_vec()
    }

    fn information(&mut self, opcode: u8, data: &[u8]) -> Vec<Vec<u8>> {
        let message = [&[0, SDO_INFORMATION << 4, opcode, 0, 0, 0][..], data].concat();
        self.all(&message)
    }

    fn object(&self, index: u16, sub: u8) -> &[u8] {
        &self.toy.objects[&(index, sub)]
    }
}

fn abort(index: u16, sub: u8, code: u32) -> Vec<u8> {
    let ([i0, i1], [c0, c1, c2, c3]) = (index.to_le_bytes(), code.to_le_bytes());
    vec![0x80, i0, i1, sub, c0, c1, c2, c3]
}

/// A text that is longer than two mailboxes.
fn text() -> Vec<u8> {
    (0..300_u16).map(|k| k as u8).collect()
}

#[test]
fn values_of_up_to_four_bytes_are_uploaded_at_once() {
    let widths: [(&[u8], u8); 4] = [(&[1], 0x4F), (&[1, 2], 0x4B), (&[1, 2, 3], 0x47), (&[1, 2, 3, 4], 0x43)];
    for (value, command) in widths {
        let mut bench = bench(Toy::new().with(0x2000, 3, value));
        let mut four = value.to_vec();
        four.resize(4, 0);
        let expected = [&[command, 0x00, 0x20, 3][..], &four].concat();
        assert_eq!(bench.sdo(&[0x40, 0x00, 0x20, 3, 0, 0, 0, 0]), expected);
    }
}

#[test]
fn longer_values_are_uploaded_in_one_answer_as_long_as_they_fit() {
    for count in [0, 5, 111, 112] {
        let value = text()[..count].to_vec();
        let mut bench = bench(Toy::new().with(0x2000, 0, &value));
        let answer = bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
        assert_eq!(answer[..8], [0x41, 0x00, 0x20, 0, count as u8, 0, 0, 0]);
        assert_eq!(answer[8..], value);
        assert_eq!(bench.sdo(&[0x60; 8]), abort(0, 0, 0x0504_0001), "no segment is left");
    }
}

#[test]
fn still_longer_values_are_uploaded_in_segments() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &text()));
    let first = bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(first[..8], [0x41, 0x00, 0x20, 0, 0x2C, 0x01, 0, 0]);
    let second = bench.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]);
    let third = bench.sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!((second[0], third[0]), (0x00, 0x11), "toggle, last");
    assert_eq!([&first[8..], &second[1..], &third[1..]].concat(), text());
}

#[test]
fn a_short_last_segment_says_how_many_bytes_are_unused() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &text()[..115]));
    bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    let last = bench.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(last, [4 << 1 | 1, 112, 113, 114, 0, 0, 0, 0], "seven bytes at least");
}

#[test]
fn values_are_downloaded_at_once_in_one_request_or_in_segments() {
    let mut bench =
        bench(Toy::new().with(0x2000, 0, &[0; 2]).with(0x2001, 0, &[0; 5]).with(0x2002, 0, &[0; 20]));
    assert_eq!(bench.sdo(&[0x2B, 0x00, 0x20, 0, 7, 8, 0, 0])[..4], [0x60, 0x00, 0x20, 0]);
    assert_eq!(bench.object(0x2000, 0), [7, 8]);
    assert_eq!(bench.sdo(&[0x22, 0x00, 0x20, 0, 5, 6, 0, 0])[0], 0x60, "no size: as long as the object");
    assert_eq!(bench.object(0x2000, 0), [5, 6]);
    let normal = [0x21, 0x01, 0x20, 0, 5, 0, 0, 0, 1, 2, 3, 4, 5, 0xEE];
    assert_eq!(bench.sdo(&normal)[..4], [0x60, 0x01, 0x20, 0]);
    assert_eq!(bench.object(0x2001, 0), [1, 2, 3, 4, 5], "what is behind it is padding");
    let first = [0x21, 0x02, 0x20, 0, 20, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6];
    assert_eq!(bench.sdo(&first)[0], 0x60);
    assert_eq!(bench.sdo(&[0x00, 7, 8, 9, 10, 11, 12, 13])[0], 0x20);
    assert_eq!(bench.object(0x2002, 0), [0; 20], "not before the last segment");
    assert_eq!(bench.sdo(&[0x13, 14, 15, 16, 17, 18, 19, 0])[0], 0x30);
    assert_eq!(bench.object(0x2002, 0), (0..20).collect::<Vec<u8>>());
}

#[test]
fn a_segment_longer_than_seven_bytes_is_taken_whole() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &[0; 300]));
    bench.sdo(&[&[0x21, 0x00, 0x20, 0, 0x2C, 0x01, 0, 0][..], &text()[..112]].concat());
    bench.sdo(&[&[0x00][..], &text()[112..231]].concat());
    assert_eq!(bench.sdo(&[&[0x11][..], &text()[231..]].concat())[0], 0x30);
    assert_eq!(bench.object(0x2000, 0), text());
}

#[test]
fn a_wrong_toggle_bit_ends_the_transfer_both_ways() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &text()));
    bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(bench.sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]), abort(0x2000, 0, 0x0503_0000));
    assert_eq!(bench.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]), abort(0, 0, 0x0504_0001), "nothing is left of it");
    bench.sdo(&[0x21, 0x00, 0x20, 0, 0x2C, 0x01, 0, 0]);
    assert_eq!(bench.sdo(&[0x10, 0, 0, 0, 0, 0, 0, 0]), abort(0x2000, 0, 0x0503_0000));
    assert_eq!(bench.sdo(&[0x00, 0, 0, 0, 0, 0, 0, 0]), abort(0, 0, 0x0504_0001));
}

#[test]
fn wrong_lengths_are_refused() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &[0; 2]).with(0x2001, 0, &[0; 10]));
    assert_eq!(bench.sdo(&[0x23, 0x00, 0x20, 0, 1, 2, 3, 4]), abort(0x2000, 0, 0x0607_0010));
    assert_eq!(bench.sdo(&[0x2F, 0x00, 0x20, 0, 1, 0, 0, 0]), abort(0x2000, 0, 0x0607_0010));
    let start = [0x21, 0x01, 0x20, 0, 10, 0, 0, 0];
    bench.sdo(&start);
    assert_eq!(bench.sdo(&[0x01, 1, 2, 3, 4, 5, 6, 7]), abort(0x2001, 0, 0x0607_0010), "too few");
    bench.sdo(&start);
    let many = [&[0x00][..], &[1; 11]].concat();
    assert_eq!(bench.sdo(&many), abort(0x2001, 0, 0x0607_0010), "too many");
    let endless = [0x21, 0x01, 0x20, 0, 0xFF, 0xFF, 0xFF, 0xFF];
    assert_eq!(bench.sdo(&endless), abort(0x2001, 0, 0x0607_0010));
    assert_eq!(bench.object(0x2001, 0), [0; 10]);
}

#[test]
fn a_client_that_aborts_is_not_answered_and_its_transfer_is_over() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &text()));
    bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    let message = [0, SDO_REQUEST << 4, 0x80, 0x00, 0x20, 0, 0, 0, 0x04, 0x05];
    assert_eq!(bench.all(&message), Vec::<Vec<u8>>::new());
    assert_eq!(bench.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]), abort(0, 0, 0x0504_0001));
}

#[test]
fn a_new_transfer_replaces_one_that_was_not_ended() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &text()).with(0x2001, 0, &[9]));
    bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(bench.sdo(&[0x40, 0x01, 0x20, 0, 0, 0, 0, 0])[4], 9);
    assert_eq!(bench.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]), abort(0, 0, 0x0504_0001));
}

#[test]
fn commands_that_do_not_exist_and_objects_that_do_not_exist_are_aborted() {
    let mut toy = Toy::new().with(0x2000, 0, &[1]);
    toy.constants.push((0x2000, 0));
    let mut bench = bench(toy);
    for command in [0xA0, 0xC0, 0xE0] {
        assert_eq!(bench.sdo(&[command, 0x00, 0x20, 0, 0, 0, 0, 0]), abort(0x2000, 0, 0x0504_0001));
    }
    assert_eq!(bench.sdo(&[0x40, 0x34, 0x12, 0, 0, 0, 0, 0]), abort(0x1234, 0, 0x0602_0000));
    assert_eq!(bench.sdo(&[0x40, 0x00, 0x20, 7, 0, 0, 0, 0]), abort(0x2000, 7, 0x0609_0011));
    assert_eq!(bench.sdo(&[0x2F, 0x00, 0x20, 0, 2, 0, 0, 0]), abort(0x2000, 0, 0x0601_0002));
    bench.server.refuses = Some(0x0800_0022);
    assert_eq!(bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]), abort(0x2000, 0, 0x0800_0022));
    assert_eq!(bench.sdo(&[0x2F, 0x00, 0x20, 0, 2, 0, 0, 0]), abort(0x2000, 0, 0x0800_0022));
}

#[test]
fn a_request_that_is_cut_short_is_no_panic() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &[1]));
    for count in 2..10 {
        let message = [0, SDO_REQUEST << 4, 0x40, 0x00, 0x20, 0, 0, 0, 0, 0];
        assert_eq!(bench.all(&message[..count]).len(), 1, "{count} bytes");
    }
    bench.sdo(&[0x21, 0x00, 0x20, 0, 200, 0, 0, 0]);
    assert_eq!(bench.sdo(&[]), abort(0x2000, 0, 0x0504_0001), "a segment without even a command");
    assert_eq!(bench.server.answer(&mut bench.toy, &[0], ROOM), Err(TOO_SHORT));
    assert_eq!(bench.server.answer(&mut bench.toy, &[0, 0xF0, 0], ROOM), Err(INVALID_HEADER));
    assert_eq!(bench.all(&[0, SDO_RESPONSE << 4, 0, 0]), Vec::<Vec<u8>>::new(), "nothing is asked");
}

/// A list of three words, of which the second is missing, with a count that may not be written.
fn record() -> Toy {
    let mut toy = Toy::new().with(0x2000, 0, &[3]).with(0x2000, 1, &[1, 2]).with(0x2000, 3, &[5, 6, 7, 8]);
    toy.constants.push((0x2000, 0));
    toy
}

#[test]
fn complete_access_gives_sub_index_0_two_bytes_and_leaves_no_gaps() {
    let mut bench = bench(record());
    let answer = bench.sdo(&[0x50, 0x00, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(answer, [0x51, 0x00, 0x20, 0, 8, 0, 0, 0, 3, 0, 1, 2, 5, 6, 7, 8]);
    let from_one = bench.sdo(&[0x50, 0x00, 0x20, 1, 0, 0, 0, 0]);
    assert_eq!(from_one, [0x51, 0x00, 0x20, 1, 6, 0, 0, 0, 1, 2, 5, 6, 7, 8]);
    assert_eq!(bench.sdo(&[0x50, 0x00, 0x20, 2, 0, 0, 0, 0]), abort(0x2000, 2, 0x0601_0004));
}

#[test]
fn complete_access_needs_a_list() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &[0]).with(0x2001, 0, &[1, 2, 3, 4]));
    assert_eq!(bench.sdo(&[0x50, 0x00, 0x20, 0, 0, 0, 0, 0]), abort(0x2000, 0, 0x0601_0004));
    assert_eq!(bench.sdo(&[0x50, 0x01, 0x20, 0, 0, 0, 0, 0]), abort(0x2001, 0, 0x0601_0004));
    assert_eq!(bench.sdo(&[0x50, 0x02, 0x20, 0, 0, 0, 0, 0]), abort(0x2002, 0, 0x0602_0000));
}

#[test]
fn complete_access_writes_the_entries_of_a_record_as_long_as_they_are() {
    let mut bench = bench(record());
    let whole = [0x31, 0x00, 0x20, 0, 8, 0, 0, 0, 3, 0, 11, 12, 15, 16, 17, 18];
    assert_eq!(bench.sdo(&whole)[..4], [0x60, 0x00, 0x20, 0]);
    assert_eq!((bench.object(0x2000, 1), bench.object(0x2000, 3)), (&[11, 12][..], &[15, 16, 17, 18][..]));
    let from_one = [0x31, 0x00, 0x20, 1, 6, 0, 0, 0, 21, 22, 25, 26, 27, 28];
    assert_eq!(bench.sdo(&from_one)[0], 0x60);
    assert_eq!((bench.object(0x2000, 1), bench.object(0x2000, 3)), (&[21, 22][..], &[25, 26, 27, 28][..]));
    let another_count = [0x31, 0x00, 0x20, 0, 4, 0, 0, 0, 1, 0, 11, 12];
    assert_eq!(bench.sdo(&another_count), abort(0x2000, 0, 0x0601_0002));
    let too_short = [0x31, 0x00, 0x20, 0, 5, 0, 0, 0, 3, 0, 11, 12, 15];
    assert_eq!(bench.sdo(&too_short), abort(0x2000, 0, 0x0607_0010));
    let too_long = [0x31, 0x00, 0x20, 1, 7, 0, 0, 0, 21, 22, 25, 26, 27, 28, 29];
    assert_eq!(bench.sdo(&too_long), abort(0x2000, 1, 0x0607_0010));
}

#[test]
fn complete_access_writes_a_list_that_can_be_resized_count_last() {
    let toy = Toy::new().with(0x1C12, 0, &[1]).with(0x1C12, 1, &[0, 0x16]).with(0x1C12, 2, &[0, 0]);
    let mut bench = bench(toy);
    let whole = [0x31, 0x12, 0x1C, 0, 6, 0, 0, 0, 2, 0, 0x00, 0x16, 0x01, 0x16];
    assert_eq!(bench.sdo(&whole)[0], 0x60);
    assert_eq!((bench.object(0x1C12, 0), bench.object(0x1C12, 2)), (&[2][..], &[0x01, 0x16][..]));
    let none = [0x33, 0x12, 0x1C, 0, 0, 0, 0, 0];
    assert_eq!(bench.sdo(&none)[0], 0x60);
    assert_eq!(bench.object(0x1C12, 0), [0]);
    let uneven = [0x31, 0x12, 0x1C, 0, 5, 0, 0, 0, 2, 0, 0x00, 0x16, 0x01];
    assert_eq!(bench.sdo(&uneven), abort(0x1C12, 0, 0x0607_0010));
}

/// A toy with this many objects from 2000h on.
fn many(count: u16) -> Toy {
    (0..count).fold(Toy::new(), |toy, k| toy.with(0x2000 + k, 0, &[1]))
}

#[test]
fn the_list_of_objects_comes_in_as_many_messages_as_it_needs() {
    let mut bench = bench(many(100));
    let answers = bench.information(1, &[1, 0]);
    let heads: Vec<&[u8]> = answers.iter().map(|answer| &answer[1..6]).collect();
    assert_eq!(heads, [&[0x80, 0x82, 0, 1, 0][..], &[0x80, 0x02, 0, 0, 0]]);
    assert!(answers.iter().all(|answer| answer.len() <= ROOM));
    let data = [&answers[0][6..], &answers[1][6..]].concat();
    let words: Vec<u16> = data.chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    assert_eq!(words, [vec![1], (0x2000..0x2064).collect()].concat());
    let lengths = bench.information(1, &[0, 0]);
    assert_eq!(lengths[0][6..], [0, 0, 100, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(bench.information(1, &[2, 0])[0][6..], [2, 0], "nothing is mappable");
    assert_eq!(bench.information(1, &[6, 0])[0][1..3], [0x80, 7], "no such list");
}

#[test]
fn objects_and_entries_that_nobody_described_are_described_by_their_bytes() {
    let mut bench = bench(record().with(0x2001, 0, &[1, 2, 3, 4]));
    let object = bench.information(3, &[0x00, 0x20]).remove(0);
    assert_eq!(object[2..12], [4, 0, 0, 0, 0x00, 0x20, 5, 0, 3, 9]);
    let variable = bench.information(3, &[0x01, 0x20]).remove(0);
    assert_eq!(variable[6..12], [0x01, 0x20, 7, 0, 0, 7]);
    assert_eq!(variable[12..], *b"Object 2001h");
    let entry = bench.information(5, &[0x00, 0x20, 1, 0]).remove(0);
    assert_eq!(entry[2..16], [6, 0, 0, 0, 0x00, 0x20, 1, 0, 6, 0, 16, 0, 0b111, 0]);
    assert_eq!(entry[16..], *b"Sub-index 1");
}

#[test]
fn information_about_nothing_is_an_error() {
    let mut bench = bench(record());
    let error = |code: u32| {
        let [a, b, c, d] = code.to_le_bytes();
        vec![0, 0x80, 7, 0, 0, 0, a, b, c, d]
    };
    assert_eq!(bench.information(3, &[0x34, 0x12]), [error(0x0602_0000)]);
    assert_eq!(bench.information(5, &[0x00, 0x20, 9, 0]), [error(0x0609_0011)]);
    assert_eq!(bench.information(9, &[0, 0]), [error(0x0601_0000)]);
    assert_eq!(bench.information(5, &[]), [error(0x0602_0000)]);
    assert_eq!(bench.all(&[0, SDO_INFORMATION << 4]), [error(0x0601_0000)]);
}

#[test]
fn a_mailbox_with_hardly_any_room_still_gets_its_answers() {
    let mut bench = bench(Toy::new().with(0x2000, 0, &text()));
    for room in [0, 1, 6, 10, 12] {
        bench.room = room;
        let mut got = bench.sdo(&[0x40, 0x00, 0x20, 0, 0, 0, 0, 0])[8..].to_vec();
        let mut toggle = 0;
        loop {
            let segment = bench.sdo(&[0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
            let unused = usize::from(segment[0] >> 1 & 7);
            got.extend(&segment[1..segment.len() - unused]);
            toggle ^= 0x10;
            if segment[0] & 1 != 0 {
                break;
            }
        }
        assert_eq!(got, text(), "room for {room}");
        assert!(!bench.information(1, &[1, 0]).is_empty());
    }
}
