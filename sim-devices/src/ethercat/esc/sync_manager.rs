//! Sync managers: mailboxes and buffered process data in the RAM of a SubDevice (ETG.1000.4, 6.7).

use std::ops::Range;

/// What a sync manager does with its part of the RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The newest process data, always readable and always writable.
    Buffered,
    /// One message at a time.
    Mailbox,
}

/// Configuration of a sync manager as its registers have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Configuration {
    /// First byte.
    pub(crate) start: u16,
    /// Bytes.
    pub(crate) length: u16,
    /// Mailbox or buffer.
    pub(crate) mode: Mode,
    /// Whether the MainDevice writes and the SubDevice reads.
    pub(crate) from_main: bool,
    /// Whether writing feeds the process data watchdog.
    pub(crate) feeds_watchdog: bool,
}

impl Configuration {
    /// From the eight bytes of its registers; `None` while it is not enabled or has no length.
    pub(crate) fn decode(bytes: &[u8]) -> Option<Self> {
        let length = u16::from_le_bytes([bytes[2], bytes[3]]);
        if bytes[6] & 1 == 0 || length == 0 {
            return None;
        }
        Some(Self {
            start: u16::from_le_bytes([bytes[0], bytes[1]]),
            length,
            mode: if bytes[4] & 3 == 2 { Mode::Mailbox } else { Mode::Buffered },
            from_main: bytes[4] >> 2 & 3 == 1,
            feeds_watchdog: bytes[4] & 1 << 6 != 0,
        })
    }

    /// The bytes that it covers.
    pub(crate) fn range(&self) -> Range<usize> {
        usize::from(self.start)..usize::from(self.start) + usize::from(self.length)
    }
}

/// A sync manager at work.
#[derive(Clone, Debug, Default)]
pub(crate) struct SyncManager {
    configuration: Option<Configuration>,
    /// What the MainDevice reads or writes.
    bus_side: Vec<u8>,
    /// What the SubDevice writes or reads; complete at any time.
    device_side: Vec<u8>,
    /// The MainDevice has begun with the first byte.
    opened: bool,
    /// A message waits for whoever reads; of a buffer: it was written since the SubDevice looked.
    full: bool,
    /// Has ever been written since it was enabled.
    was_written: bool,
}

impl SyncManager {
    /// Takes another configuration; a mailbox is empty and a buffer is zero after that.
    pub(crate) fn configure(&mut self, configuration: Option<Configuration>) {
        if self.configuration == configuration {
            return;
        }
        let length = configuration.map_or(0, |c| usize::from(c.length));
        let zero = vec![0; length];
        *self = Self { configuration, bus_side: zero.clone(), device_side: zero, ..Self::default() };
    }

    /// Its configuration; `None` while it is not enabled.
    pub(crate) fn configuration(&self) -> Option<Configuration> {
        self.configuration
    }

    /// The MainDevice reads these bytes, counted from the first one of the sync manager; false if it may not.
    pub(crate) fn bus_reads(&mut self, part: Range<usize>, into: &mut [u8]) -> bool {
        let Some(configuration) = self.configuration.filter(|c| !c.from_main) else { return false };
        let is_last = part.end == self.bus_side.len();
        match configuration.mode {
            Mode::Mailbox => {
                self.opened |= self.full && part.start == 0;
                if !self.full || !self.opened {
                    return false;
                }
                into.copy_from_slice(&self.device_side[part]);
                if is_last {
                    (self.full, self.opened) = (false, false);
                }
            }
            Mode::Buffered => {
                if part.start == 0 {
                    self.bus_side.copy_from_slice(&self.device_side);
                    self.full = false;
                }
                into.copy_from_slice(&self.bus_side[part]);
            }
        }
        true
    }

    /// The MainDevice writes these bytes; false if it may not.
    pub(crate) fn bus_writes(&mut self, part: Range<usize>, bytes: &[u8]) -> bool {
        let Some(configuration) = self.configuration.filter(|c| c.from_main) else { return false };
        let is_last = part.end == self.bus_side.len();
        if configuration.mode == Mode::Mailbox && self.full {
            return false;
        }
        self.opened |= part.start == 0;
        if configuration.mode == Mode::Mailbox && !self.opened {
            return false;
        }
        self.bus_side[part].copy_from_slice(bytes);
        if is_last {
            self.device_side.copy_from_slice(&self.bus_side);
            (self.full, self.opened, self.was_written) = (true, false, true);
        }
        true
    }

    /// A byte as the MainDevice last wrote it, complete or not.
    pub(crate) fn last_written(&self, k: usize) -> u8 {
        self.bus_side[k]
    }

    /// The SubDevice takes what the MainDevice wrote since it last looked.
    pub(crate) fn device_takes(&mut self) -> Option<&[u8]> {
        std::mem::take(&mut self.full).then_some(&self.device_side[..])
    }

    /// The SubDevice writes; of a mailbox only while it is empty. Bytes beyond its length are cut off.
    pub(crate) fn device_writes(&mut self, write: impl FnOnce(&mut [u8])) {
        let is_open = self.configuration.is_some_and(|c| !c.from_main);
        let is_free = self.configuration.is_some_and(|c| c.mode == Mode::Buffered) || !self.full;
        if is_open && is_free {
            write(&mut self.device_side);
            self.full = true;
        }
    }

    /// Whether a message waits, or a buffer is fresh.
    pub(crate) fn is_full(&self) -> bool {
        self.full
    }

    /// Whether the MainDevice has ever written it since it was enabled.
    pub(crate) fn was_written(&self) -> bool {
        self.was_written
    }

    /// Forgets a message that waits.
    pub(crate) fn empty(&mut self) {
        (self.full, self.opened, self.was_written) = (false, false, false);
    }

    /// Its status register.
    pub(crate) fn status(&self) -> u8 {
        match self.configuration.map(|c| c.mode) {
            Some(Mode::Mailbox) => u8::from(self.full) << 3,
            // Bits 4 and 5: the buffer written last, 3 while none was.
            Some(Mode::Buffered) if self.full || self.was_written => 0x00,
            Some(Mode::Buffered) => 0x30,
            None => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manager(control: u8) -> SyncManager {
        let mut manager = SyncManager::default();
        manager.configure(Configuration::decode(&[0x00, 0x10, 4, 0, control, 0, 1, 0]));
        manager
    }

    #[test]
    fn a_mailbox_takes_one_message_and_refuses_the_next_until_it_was_read() {
        let mut mailbox = manager(0x26);
        assert!(!mailbox.bus_writes(1..4, &[2, 3, 4]), "begins beyond its first byte");
        assert!(mailbox.bus_writes(0..2, &[1, 2]));
        assert!(mailbox.device_takes().is_none(), "not complete");
        assert!(mailbox.bus_writes(2..4, &[3, 4]));
        assert_eq!(mailbox.status(), 0x08);
        assert!(!mailbox.bus_writes(0..4, &[9; 4]), "full");
        assert!(!mailbox.bus_reads(0..4, &mut [0; 4]), "the other direction");
        assert_eq!(mailbox.device_takes(), Some(&[1, 2, 3, 4][..]));
        assert_eq!(mailbox.status(), 0);
        assert!(mailbox.bus_writes(0..4, &[5; 4]));
    }

    #[test]
    fn an_answer_can_be_read_once() {
        let mut mailbox = manager(0x22);
        let mut read = [0; 4];
        assert!(!mailbox.bus_reads(0..4, &mut read), "empty");
        mailbox.device_writes(|bytes| bytes.copy_from_slice(&[1, 2, 3, 4]));
        mailbox.device_writes(|bytes| bytes.fill(9));
        assert!(mailbox.bus_reads(0..4, &mut read));
        assert_eq!(read, [1, 2, 3, 4], "the second one found it full");
        assert!(!mailbox.bus_reads(0..4, &mut read));
    }

    #[test]
    fn a_buffer_is_consistent_when_it_is_read_in_two_parts() {
        let mut buffer = manager(0x20);
        buffer.device_writes(|bytes| bytes.fill(1));
        let (mut first, mut second) = ([0; 2], [0; 2]);
        assert!(buffer.bus_reads(0..2, &mut first));
        buffer.device_writes(|bytes| bytes.fill(2));
        assert!(buffer.bus_reads(2..4, &mut second));
        assert_eq!((first, second), ([1; 2], [1; 2]));
        assert!(buffer.bus_reads(0..2, &mut first));
        assert_eq!(first, [2; 2]);
    }

    #[test]
    fn outputs_reach_the_device_when_their_last_byte_was_written() {
        let mut buffer = manager(0x64);
        assert!(buffer.configuration().is_some_and(|c| c.feeds_watchdog));
        assert!(buffer.bus_writes(0..3, &[1, 2, 3]));
        assert!(!buffer.was_written());
        assert!(buffer.bus_writes(3..4, &[4]));
        assert_eq!(buffer.device_takes(), Some(&[1, 2, 3, 4][..]));
        assert_eq!(buffer.device_takes(), None, "nothing new");
    }

    #[test]
    fn a_manager_without_length_or_activation_covers_nothing() {
        assert_eq!(Configuration::decode(&[0, 0x11, 0, 0, 0x64, 0, 1, 0]), None);
        assert_eq!(Configuration::decode(&[0, 0x11, 4, 0, 0x64, 0, 0, 0]), None);
    }
}
