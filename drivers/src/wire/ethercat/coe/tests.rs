use super::*;
use proptest::prelude::*;

const CONTROLWORD: Place = Place { index: 0x6040, sub: 0 };

fn encoded(request: &Request<'_>, counter: u8) -> Vec<u8> {
    let mut message = vec![0xEE; 64];
    encode(request, counter, &mut message).expect("64 bytes are enough");
    let end = HEADER_BYTES + usize::from(word(&message, 0).expect("there is a header"));
    assert!(message[end..].iter().all(|&byte| byte == 0));
    message.truncate(end);
    message
}

#[test]
fn requests_have_the_bytes_of_the_specification() {
    assert_eq!(
        encoded(&Request::Upload(Place { index: 0x1018, sub: 2 }), 1),
        [10, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x18, 0x10, 2, 0, 0, 0, 0]
    );
    assert_eq!(
        encoded(&Request::Download { place: CONTROLWORD, size: 2, data: &[0x0F, 0] }, 7),
        [10, 0, 0, 0, 0, 0x73, 0, 0x20, 0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0]
    );
    assert_eq!(
        encoded(&Request::Download { place: CONTROLWORD, size: 6, data: &[1, 2, 3, 4, 5, 6] }, 2),
        [16, 0, 0, 0, 0, 0x23, 0, 0x20, 0x21, 0x40, 0x60, 0, 6, 0, 0, 0, 1, 2, 3, 4, 5, 6]
    );
    assert_eq!(
        encoded(&Request::DownloadSegment { toggle: true, is_last: true, data: &[9, 8] }, 3),
        [10, 0, 0, 0, 0, 0x33, 0, 0x20, 0x1B, 9, 8, 0, 0, 0, 0, 0]
    );
    assert_eq!(encoded(&Request::UploadSegment { toggle: true }, 4)[8], 0x70);
    assert_eq!(
        encoded(&Request::Abort { place: CONTROLWORD, code: 0x0503_0000 }, 5)[8..],
        [0x80, 0x40, 0x60, 0, 0, 0, 0x03, 0x05]
    );
}

#[test]
fn a_mailbox_that_is_too_short_takes_no_request() {
    assert_eq!(encode(&Request::Upload(CONTROLWORD), 1, &mut [0; 15]), None);
    let long = Request::Download { place: CONTROLWORD, size: 40, data: &[0; 40] };
    assert_eq!(encode(&long, 1, &mut [0; 40]), None);
}

fn message(service: u16, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![content.len() as u8 + 2, 0, 0, 0, 0, 0x13];
    bytes.extend((service << 12).to_le_bytes());
    bytes.extend(content);
    bytes
}

#[test]
fn answers_are_read_from_their_bytes() {
    let expedited = message(3, &[0x4B, 0x40, 0x60, 0, 0x37, 0x02, 0, 0]);
    let answer = Answer::Upload { place: CONTROLWORD, size: 2, data: &[0x37, 0x02] };
    assert_eq!(decode(&expedited), Some(Message::Sdo(answer)));
    let normal = message(3, &[0x41, 0x08, 0x10, 0, 5, 0, 0, 0, b'T', b'w', b'i', b'n', b'!', 0, 0]);
    let place = Place { index: 0x1008, sub: 0 };
    assert_eq!(decode(&normal), Some(Message::Sdo(Answer::Upload { place, size: 5, data: b"Twin!" })));
    let last = message(3, &[0x1B, 1, 2, 0, 0, 0, 0, 0]);
    let segment = Answer::UploadSegment { toggle: true, is_last: true, data: &[1, 2] };
    assert_eq!(decode(&last), Some(Message::Sdo(segment)), "five of seven bytes are unused");
    let abort = message(2, &[0x80, 0x40, 0x60, 0, 0, 0, 0x02, 0x06]);
    let refused = Answer::Abort { place: CONTROLWORD, code: 0x0602_0000 };
    assert_eq!(decode(&abort), Some(Message::Sdo(refused)));
    assert_eq!(
        decode(&message(3, &[0x60, 0x40, 0x60, 0, 0, 0, 0, 0])),
        Some(Message::Sdo(Answer::Download(CONTROLWORD)))
    );
}

#[test]
fn an_emergency_is_read_with_register_and_vendor_bytes() {
    let bytes = message(1, &[0x20, 0x73, 0x20, 1, 2, 3, 4, 5]);
    let emergency = Message::Emergency { code: 0x7320, register: 0x20, vendor: [1, 2, 3, 4, 5] };
    assert_eq!(decode(&bytes), Some(emergency));
    assert_eq!(decode(&[4, 0, 0, 0, 0, 0x10, 1, 0, 2, 0]), Some(Message::MailboxError { detail: 2 }));
    assert_eq!(decode(&message(3, &[])), None, "cut off");
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        prop_assert!(bytes.len() >= 6 || decode(&bytes).is_none(), "no whole header, no message");
    }

    #[test]
    fn arbitrary_coe_messages_never_panic(service in 0_u16..16, content in prop::collection::vec(any::<u8>(), 0..32), cut in 0_usize..42) {
        let mut bytes = message(service, &content);
        decode(&bytes);
        bytes.truncate(cut);
        decode(&bytes);
    }

    #[test]
    fn no_request_overruns_its_mailbox(size in 0_usize..80, room in 0_usize..120, toggle: bool) {
        let data = vec![0xA5; size];
        let mut mailbox = vec![0; room];
        let whole = Request::Download { place: CONTROLWORD, size, data: &data };
        if size > 4 {
            prop_assert_eq!(encode(&whole, 1, &mut mailbox).is_some(), size <= first_capacity(room) && room >= SHORTEST_BYTES);
        }
        let segment = Request::DownloadSegment { toggle, is_last: false, data: &data };
        prop_assert_eq!(encode(&segment, 1, &mut mailbox).is_some(), size <= segment_capacity(room) && room >= SHORTEST_BYTES);
    }
}
