use super::*;
use proptest::prelude::*;

const NAME: Place = Place { index: 0x1008, sub: 0 };

fn reading(place: Place) -> Transfer {
    let mut transfer = Transfer::idle();
    transfer.begin(place, None, 32);
    transfer
}

#[test]
fn an_object_in_one_message_is_read_at_once() {
    let mut transfer = reading(NAME);
    assert_eq!(transfer.request(), Request::Upload(NAME));
    assert_eq!(transfer.take(&Answer::Upload { place: NAME, size: 4, data: b"Twin" }), Next::Complete);
    assert_eq!(transfer.data(), b"Twin");
}

#[test]
fn a_long_object_is_read_in_segments_with_alternating_toggle() {
    let mut transfer = reading(NAME);
    assert_eq!(transfer.take(&Answer::Upload { place: NAME, size: 6, data: b"Tw" }), Next::Send);
    assert_eq!(transfer.request(), Request::UploadSegment { toggle: false });
    assert_eq!(
        transfer.take(&Answer::UploadSegment { toggle: false, is_last: false, data: b"in" }),
        Next::Send
    );
    assert_eq!(transfer.request(), Request::UploadSegment { toggle: true });
    assert_eq!(
        transfer.take(&Answer::UploadSegment { toggle: true, is_last: true, data: b"ed" }),
        Next::Complete
    );
    assert_eq!(transfer.data(), b"Twined");
}

#[test]
fn a_segment_with_the_wrong_toggle_or_length_ends_the_transfer() {
    let begun = || {
        let mut transfer = reading(NAME);
        transfer.take(&Answer::Upload { place: NAME, size: 6, data: b"" });
        transfer
    };
    let segment = |toggle, is_last, data| Answer::UploadSegment { toggle, is_last, data };
    assert_eq!(begun().take(&segment(true, false, b"ab")), Next::Abort(TOGGLE));
    assert_eq!(begun().take(&segment(false, true, b"ab")), Next::Abort(LENGTH));
    assert_eq!(begun().take(&segment(false, false, b"abcdefg")), Next::Abort(LENGTH));
    assert_eq!(begun().take(&segment(false, false, b"")), Next::Abort(LENGTH), "it would never end");
    let huge = Answer::Upload { place: NAME, size: usize::MAX, data: b"" };
    assert_eq!(reading(NAME).take(&huge), Next::Abort(MEMORY));
}

#[test]
fn answers_to_an_older_transfer_are_passed_over() {
    let mut transfer = reading(NAME);
    let other = Place { index: 0x1009, sub: 0 };
    assert_eq!(transfer.take(&Answer::Upload { place: other, size: 1, data: b"x" }), Next::Wait);
    assert_eq!(transfer.take(&Answer::Abort { place: other, code: 1 }), Next::Wait);
    assert_eq!(transfer.take(&Answer::Download(NAME)), Next::Wait);
    assert_eq!(
        transfer.take(&Answer::UploadSegment { toggle: false, is_last: true, data: b"x" }),
        Next::Wait
    );
    assert_eq!(
        transfer.take(&Answer::Abort { place: NAME, code: 0x0602_0000 }),
        Next::Aborted(SdoAbort(0x0602_0000))
    );
}

/// A server that stores what is written to it and gives it back, over mailboxes of a given size.
fn serve(transfer: &mut Transfer, stored: &mut Vec<u8>, mailbox_bytes: usize) -> Result<(), SdoAbort> {
    let mut read_bytes = 0;
    loop {
        let mut message = vec![0; mailbox_bytes];
        coe::encode(&transfer.request(), 1, &mut message).expect("requests fit their mailbox");
        let next = match transfer.request() {
            Request::Upload(place) => {
                let size = stored.len();
                read_bytes = size.min(coe::first_capacity(mailbox_bytes));
                let data = stored[..read_bytes].to_vec();
                transfer.take(&Answer::Upload { place, size, data: &data })
            }
            Request::UploadSegment { toggle } => {
                let end = stored.len().min(read_bytes + coe::segment_capacity(mailbox_bytes));
                let data = stored[read_bytes..end].to_vec();
                read_bytes = end;
                transfer.take(&Answer::UploadSegment { toggle, is_last: end == stored.len(), data: &data })
            }
            Request::Download { place, data, .. } => {
                *stored = data.to_vec();
                transfer.take(&Answer::Download(place))
            }
            Request::DownloadSegment { toggle, data, .. } => {
                stored.extend_from_slice(data);
                transfer.take(&Answer::DownloadSegment { toggle })
            }
            Request::Abort { code, .. } => return Err(SdoAbort(code)),
        };
        match next {
            Next::Send => {}
            Next::Complete => return Ok(()),
            Next::Aborted(abort) | Next::Abort(abort) => return Err(abort),
            Next::Wait => panic!("the server answers what was asked"),
        }
    }
}

proptest! {
    #[test]
    fn objects_of_every_length_are_written_and_read_back(data in prop::collection::vec(any::<u8>(), 0..300), mailbox_bytes in 17_usize..140) {
        let mut stored = Vec::new();
        let mut transfer = Transfer::idle();
        transfer.begin(NAME, Some(&data), mailbox_bytes);
        prop_assert_eq!(serve(&mut transfer, &mut stored, mailbox_bytes), Ok(()));
        prop_assert_eq!(&stored, &data);
        prop_assert!(transfer.data().is_empty());
        transfer.begin(NAME, None, mailbox_bytes);
        prop_assert_eq!(serve(&mut transfer, &mut stored, mailbox_bytes), Ok(()));
        prop_assert_eq!(transfer.data(), &data[..]);
    }

    #[test]
    fn arbitrary_answers_never_panic(messages in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), 0..20), write: bool) {
        let mut transfer = Transfer::idle();
        transfer.begin(NAME, write.then_some(&[7; 90][..]), 40);
        for message in &messages {
            if let Some(coe::Message::Sdo(answer)) = coe::decode(message) {
                transfer.take(&answer);
                transfer.request();
            }
        }
    }
}
