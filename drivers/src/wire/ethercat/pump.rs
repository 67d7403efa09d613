//! The pump: polls a future by hand, sends the frames that it makes and gives it the replies, on one thread.

use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicU32, Ordering};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use ethercrab::error::Error;
use ethercrab::{PduRx, PduTx};

use super::super::{EthernetLink, MAX_FRAME_BYTES};
use super::counters::MailCounter;
use super::{clock, frame};

/// Frames that may be under way at once: one cyclic and one acyclic; a power of two.
pub(super) const SLOTS: usize = 4;
/// Waits in a row that neither bring a frame nor let time pass, after which the link is taken for dead.
const IDLE_WAITS: u32 = 10_000;

/// Frames that are taken before the time is looked at again: foreign traffic cannot hold up a tick.
const MOST_FRAMES: usize = 32;

/// Tag of the next frame, for all buses of this program.
static NEXT_TAG: AtomicU32 = AtomicU32::new(0);

/// What an EtherCAT interface has carried since its bus was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Frames that were sent.
    pub sent: u64,
    /// Replies that were used.
    pub received: u64,
    /// Replies that came too late, or again: nobody waited for them any more.
    pub late: u64,
    /// Frames that are no replies to this program's, or are damaged.
    pub foreign: u64,
    /// The bus's own frames, which came back without passing a SubDevice.
    pub own: u64,
}

/// Why a future was given up.
#[derive(Debug)]
pub(super) enum Stopped {
    /// It was not ready in time.
    Deadline,
    /// The interface failed.
    Link(io::Error),
}

/// A frame that was sent and has no reply yet.
#[derive(Debug)]
struct UnderWay {
    tag: u32,
    bytes: Vec<u8>,
}

/// An interface and ethercrab's two ends of it.
pub(super) struct Pump {
    pub(super) link: Box<dyn EthernetLink>,
    tx: PduTx<'static>,
    rx: PduRx<'static>,
    /// The last frames that were sent; one that has its reply is empty.
    under_way: [UnderWay; SLOTS],
    next_slot: usize,
    received: Box<[u8; MAX_FRAME_BYTES]>,
    pub(super) counts: LinkCounts,
    /// Mailboxes into which ethercrab writes; empty while it does not.
    pub(super) mail_counters: Vec<MailCounter>,
}

impl Pump {
    pub(super) fn new(link: Box<dyn EthernetLink>, tx: PduTx<'static>, rx: PduRx<'static>) -> Self {
        let slot = || UnderWay { tag: 0, bytes: Vec::with_capacity(MAX_FRAME_BYTES) };
        Self {
            link,
            tx,
            rx,
            under_way: [slot(), slot(), slot(), slot()],
            next_slot: 0,
            received: Box::new([0; MAX_FRAME_BYTES]),
            counts: LinkCounts::default(),
            mail_counters: Vec::new(),
        }
    }

    /// Polls a future until it is ready. At `deadline` (time since the start of the run) it is given up; the frames that it
    /// was waiting for are forgotten, and their replies will count as late.
    pub(super) fn run<F: Future>(
        &mut self,
        deadline: Duration,
        mut future: Pin<&mut F>,
    ) -> Result<F::Output, Stopped> {
        let mut idle_waits = 0;
        loop {
            let now = self.link.now();
            clock::set(now);
            if let Poll::Ready(output) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
                return Ok(output);
            }
            let sent = self.send();
            if let Err(error) = sent {
                self.forget();
                return Err(Stopped::Link(error));
            }
            if now >= deadline || idle_waits > IDLE_WAITS {
                self.forget();
                return Err(Stopped::Deadline);
            }
            let until = clock::earliest_timer().map_or(deadline, |timer| timer.min(deadline));
            let received = self.receive_or_wait(until);
            match received {
                Ok(0) if self.link.now() == now => idle_waits += 1,
                Ok(_) => idle_waits = 0,
                Err(error) => {
                    self.forget();
                    return Err(Stopped::Link(error));
                }
            }
        }
    }

    /// Lets time pass until `until`, where the link is not there yet: in process, time passes while somebody waits.
    pub(super) fn reach(&mut self, until: Duration) -> io::Result<()> {
        for _ in 0..IDLE_WAITS {
            if self.link.now() >= until {
                break;
            }
            self.receive_or_wait(until)?;
        }
        Ok(())
    }

    /// Sends what is ready. A full queue is no failure: the frame is offered again until the deadline.
    fn send(&mut self) -> io::Result<()> {
        while let Some(sendable) = self.tx.next_sendable_frame() {
            let slot = &mut self.under_way[self.next_slot];
            let mut failure = None;
            let link = &mut self.link;
            let mail_counters = &mut self.mail_counters;
            let sent = sendable.send_blocking(|bytes| {
                slot.tag = NEXT_TAG.fetch_add(1, Ordering::Relaxed);
                slot.bytes.clear();
                slot.bytes.extend_from_slice(bytes);
                frame::put_tag(&mut slot.bytes, slot.tag);
                mail_counters.iter_mut().for_each(|mailbox| mailbox.put_into(&mut slot.bytes));
                link.send(&slot.bytes).map(|()| bytes.len()).map_err(|error| {
                    failure = Some(error);
                    Error::SendFrame
                })
            });
            if sent.is_err() {
                slot.bytes.clear();
                return match failure {
                    Some(error) if error.kind() != io::ErrorKind::WouldBlock => Err(error),
                    _ => Ok(()),
                };
            }
            self.counts.sent += 1;
            self.next_slot = (self.next_slot + 1) % SLOTS;
        }
        Ok(())
    }

    /// Takes the frames that have arrived; waits for one if none has. Gives the number of replies that were used.
    fn receive_or_wait(&mut self, until: Duration) -> io::Result<usize> {
        let received = self.receive()?;
        if received > 0 {
            return Ok(received);
        }
        self.link.wait(until)?;
        self.receive()
    }

    fn receive(&mut self) -> io::Result<usize> {
        let mut used_count = 0;
        for _ in 0..MOST_FRAMES {
            let Some(length) = self.link.receive(&mut self.received[..])? else { break };
            used_count += usize::from(self.take(length.min(MAX_FRAME_BYTES)));
        }
        Ok(used_count)
    }

    /// Gives a frame to ethercrab if it is the reply to one under way; no frame from outside is an error.
    fn take(&mut self, length: usize) -> bool {
        let bytes = &self.received[..length];
        let Some(tag) = frame::reply_tag(bytes) else {
            if frame::is_own(bytes) {
                self.counts.own += 1;
            } else {
                self.counts.foreign += 1;
            }
            return false;
        };
        let awaited = self.under_way.iter_mut().find(|sent| sent.tag == tag && !sent.bytes.is_empty());
        let Some(awaited) = awaited else {
            self.counts.late += 1;
            return false;
        };
        if !frame::fits(bytes, &awaited.bytes) {
            self.counts.foreign += 1;
            return false;
        }
        awaited.bytes.clear();
        let used = self.rx.receive_frame(bytes).is_ok();
        if used {
            self.counts.received += 1;
        } else {
            self.counts.late += 1;
        }
        used
    }

    /// Nobody waits any more for what is under way.
    fn forget(&mut self) {
        for sent in &mut self.under_way {
            sent.bytes.clear();
        }
    }
}
