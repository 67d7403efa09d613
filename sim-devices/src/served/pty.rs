//! The far side of a pty.
//!
//! A read of a pty that finds nothing waits for a worker of the kernel, even where it must not wait (`tty_buffer_flush_work`), and so
//! does a look whether there is anything: for milliseconds on a busy computer. A thread of its own reads, and the simulation
//! takes what it has read. Writes wait for nobody.

use std::collections::VecDeque;
use std::io;
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::{Errno, retry_on_intr};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::line::{Arrived, PIECE_BYTES};

/// Pieces that may wait for the simulation; the host's side holds back more.
const MOST_PIECES: usize = 16;
/// How long the thread waits for bytes until it looks whether it is still needed.
const PATIENCE: Timespec = Timespec { tv_sec: 0, tv_nsec: 10_000_000 };
/// How long it waits where nobody has the host's side open.
const REST: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };

/// The far side of a pty.
pub(super) struct Pty {
    far: Arc<OwnedFd>,
    arrived: Receiver<Vec<u8>>,
    waiting: VecDeque<u8>,
    state: Arc<State>,
    reader: Option<JoinHandle<()>>,
}

/// What reader and simulation tell each other.
#[derive(Debug, Default)]
struct State {
    /// The host has its side open.
    is_open: AtomicBool,
    /// The reader is no longer needed.
    is_over: AtomicBool,
}

impl Pty {
    /// A new pty.
    ///
    /// # Errors
    /// When the operating system has no pty or no thread left.
    pub(super) fn new() -> io::Result<Self> {
        let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&far)?;
        unlockpt(&far)?;
        rustix::io::ioctl_fionbio(&far, true)?;
        // The settings are those of the host's end: a terminal would send the device's bytes back to it.
        let mut settings = tcgetattr(&far)?;
        settings.make_raw();
        tcsetattr(&far, OptionalActions::Now, &settings)?;
        let (far, state) = (Arc::new(far), Arc::new(State::default()));
        let (sender, arrived) = sync_channel(MOST_PIECES);
        let reader = Builder::new().name("pty".to_owned()).spawn({
            let (far, state) = (Arc::clone(&far), Arc::clone(&state));
            move || read_on(&far, &state, &sender)
        })?;
        Ok(Self { far, arrived, waiting: VecDeque::new(), state, reader: Some(reader) })
    }

    /// Path of the host's side.
    ///
    /// # Errors
    /// When the operating system does not say.
    pub(super) fn path(&self) -> io::Result<PathBuf> {
        Ok(PathBuf::from(ptsname(&*self.far, Vec::new())?.to_string_lossy().into_owned()))
    }

    /// Takes what the host has written. Never waits.
    pub(super) fn read(&mut self, into: &mut [u8]) -> Arrived {
        if self.waiting.is_empty()
            && let Ok(piece) = self.arrived.try_recv()
        {
            self.waiting.extend(piece);
        }
        let count = self.waiting.len().min(into.len());
        if count > 0 {
            into.iter_mut().zip(self.waiting.drain(..count)).for_each(|(place, byte)| *place = byte);
            return Arrived::Bytes(count);
        }
        if self.state.is_open.load(Ordering::Acquire) { Arrived::Nothing } else { Arrived::Nobody }
    }

    /// Bytes that the host's side took. Never waits.
    pub(super) fn write(&self, bytes: &[u8]) -> usize {
        retry_on_intr(|| rustix::io::write(&*self.far, bytes)).unwrap_or(0)
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        self.state.is_over.store(true, Ordering::Release);
        // A reader that waits for room finds nobody there any more.
        self.arrived = sync_channel(0).1;
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

/// Hands over what the host writes, until nobody takes it any more.
fn read_on(far: &OwnedFd, state: &State, sender: &SyncSender<Vec<u8>>) {
    let mut piece = [0; PIECE_BYTES];
    while !state.is_over.load(Ordering::Acquire) {
        let _ = poll(&mut [PollFd::new(far, PollFlags::IN)], Some(&PATIENCE));
        let read = retry_on_intr(|| rustix::io::read(far, &mut piece));
        // Input/output error: nobody has the other end open (pty(7)).
        state.is_open.store(matches!(read, Ok(1..) | Err(Errno::AGAIN)), Ordering::Release);
        match read {
            Ok(count @ 1..) if sender.send(piece[..count].to_vec()).is_err() => return,
            Ok(1..) | Err(Errno::AGAIN) => {}
            Ok(_) | Err(_) => {
                let _ = poll(&mut [], Some(&REST));
            }
        }
    }
}
