//! The counters of mailbox messages while ethercrab writes into mailboxes too.
//!
//! A station takes a message with the counter of the one before for its repeat, and answers nothing (ETG.1000.4, mailbox
//! header). ethercrab counts for itself, from 1: its messages are sent with the counters that follow on those of
//! [`Mailboxes`](super::mailbox::Mailboxes), which goes on behind them.

use super::frame;

/// Counters are from 1 to this.
const MOST: u8 = 7;

/// The mailbox of a station, while ethercrab writes into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MailCounter {
    /// Station (counted from 0).
    pub(super) station: usize,
    /// Configured station address, and first byte of the mailbox.
    pub(super) address: u16,
    pub(super) write_at: u16,
    /// Counter of the last message that was not ethercrab's; 0 if there was none.
    pub(super) before: u8,
    /// Counter of the last message.
    pub(super) last: u8,
}

impl MailCounter {
    /// Puts the right counter into a frame that writes into this mailbox; leaves every other frame alone. A frame that is
    /// sent again gets the counter that it had.
    pub(super) fn put_into(&mut self, frame: &mut [u8]) {
        let Some(kind) = frame::written_byte(frame, self.address, self.write_at, 5) else { return };
        let counter = *kind >> 4 & MOST;
        if counter == 0 {
            return;
        }
        self.last = (counter - 1 + self.before) % MOST + 1;
        *kind = *kind & 0x8F | self.last << 4;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message with this counter, written to a station's mailbox.
    fn frame(address: u16, counter: u8) -> Vec<u8> {
        let mut frame = vec![0; 14];
        let [low, high] = address.to_le_bytes();
        frame.extend([22, 0x10, 5, 9, low, high, 0x00, 0x10, 10, 0, 0, 0]);
        frame.extend([4, 0, 0, 0, 0, 3 | counter << 4, 0, 0x20, 0x40, 0, 0, 0]);
        frame
    }

    #[test]
    fn messages_of_both_count_on() {
        for before in 0..=MOST {
            let mut mailbox =
                MailCounter { station: 0, address: 0x1001, write_at: 0x1000, before, last: before };
            let mut last = before;
            for counter in (1..=MOST).cycle().take(20) {
                let mut sent = frame(0x1001, counter);
                mailbox.put_into(&mut sent);
                last = last % MOST + 1;
                assert_eq!(sent, frame(0x1001, last), "{counter} after {before}");
                let mut again = frame(0x1001, counter);
                mailbox.put_into(&mut again);
                assert_eq!(again, sent, "sent again");
                assert_eq!(mailbox.last, last);
            }
        }
    }

    #[test]
    fn other_frames_stay_as_they_are() {
        let mut mailbox = MailCounter { station: 0, address: 0x1001, write_at: 0x1000, before: 3, last: 3 };
        let mut read = frame(0x1001, 1);
        read[16] = 4;
        for other in [frame(0x1002, 1), frame(0x1001, 0), read, frame(0x1001, 1)[..30].to_vec(), Vec::new()] {
            let mut sent = other.clone();
            mailbox.put_into(&mut sent);
            assert_eq!((sent, mailbox.last), (other, 3));
        }
    }
}
