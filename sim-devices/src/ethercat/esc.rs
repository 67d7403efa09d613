//! EtherCAT SubDevice controller (ESC): registers, RAM, sync managers, FMMUs, SII and clock (ETG.1000.4).

mod clock;
mod fmmu;
pub(crate) mod registers;
mod sii_port;
mod sync_manager;

use std::ops::Range;
use std::time::Duration;

pub(crate) use clock::{Clock, ClockError, Sync0Pulse};
use fmmu::{Fmmu, Window};
use registers::{Access, SYNC_MANAGERS};
use sii_port::{ALIAS_WORD, Effect, SiiPort};
pub(crate) use sync_manager::{Configuration, Mode, SyncManager};

/// ET1100: the controller that most drives had when their drivers were written.
const CONTROLLER: [u8; 10] = [
    0x11, // type
    0x00, // revision
    0x02, 0x00, // build
    0x08, // FMMUs
    0x08, // sync managers
    0x08, // RAM, KiB
    0x0F, // two ports by MII; features: distributed clocks, 64 bit, enhanced SYNC activation
    0xCC, 0x01,
];
/// Dividing 25 MHz by 2500: watchdogs count units of 100 µs.
const WATCHDOG_DIVIDER: u16 = 0x09C2;
/// 100 ms.
const WATCHDOG_UNITS: u16 = 1000;
/// Event: the DL status changed.
const DL_EVENT: u16 = 1 << 2;
/// Event: the AL status changed.
const AL_EVENT: u16 = 1 << 3;
/// Event of sync manager 0; the others follow.
const SYNC_MANAGER_EVENT: u16 = 1 << 4;
const ALIAS_ENABLED: usize = 0x0103;

/// A controller with its memory.
#[derive(Clone, Debug)]
pub(crate) struct Esc {
    memory: Vec<u8>,
    sii: SiiPort,
    /// Distributed clock.
    pub(crate) clock: Clock,
    sync_managers: [SyncManager; SYNC_MANAGERS],
    /// Time that a frame needs to the last SubDevice and back, as seen from here.
    pub(crate) behind_ns: u32,
    /// The AL control register was written.
    state_was_asked: bool,
    /// The AL status changed since it was read.
    state_changed: bool,
    /// A link came or went since the DL status was read.
    links_changed: bool,
    /// When outputs were last written to a sync manager that feeds the watchdog.
    fed_at: Option<Duration>,
}

impl Esc {
    /// A controller after power-up.
    pub(crate) fn new(sii: Vec<u16>, error: ClockError) -> Self {
        let mut memory = vec![0; usize::from(registers::RAM) + usize::from(registers::RAM_BYTES)];
        memory[..CONTROLLER.len()].copy_from_slice(&CONTROLLER);
        let mut esc = Self {
            memory,
            sii: SiiPort::new(sii),
            clock: Clock::new(error),
            sync_managers: Default::default(),
            behind_ns: 0,
            state_was_asked: false,
            state_changed: false,
            links_changed: false,
            fed_at: None,
        };
        esc.put_u16(registers::WATCHDOG_DIVIDER, WATCHDOG_DIVIDER);
        esc.put_u16(registers::PDI_WATCHDOG, WATCHDOG_UNITS);
        esc.put_u16(registers::DATA_WATCHDOG, WATCHDOG_UNITS);
        esc.put_u16(registers::WATCHDOG_STATUS, 1);
        esc.put_u16(registers::AL_CONTROL, 1);
        esc.put_u16(registers::AL_STATUS, 1);
        esc.put_u16(registers::SII_CONTROL, 0x0040);
        // SPI slave: a microcontroller answers behind this controller.
        esc.put_u16(registers::PDI_CONTROL, 0x0005);
        esc.load_alias();
        esc
    }

    /// The device has this alias from now on, as if it had been written and the supply switched off and on.
    pub(crate) fn set_alias(&mut self, alias: u16) {
        self.sii.set_alias(alias);
        self.load_alias();
    }

    fn load_alias(&mut self) {
        let alias = self.sii.word(ALIAS_WORD);
        self.put_u16(registers::ALIAS, alias);
    }

    /// A register of 16 bits.
    pub(crate) fn u16(&self, register: u16) -> u16 {
        let at = usize::from(register);
        u16::from_le_bytes([self.memory[at], self.memory[at + 1]])
    }

    /// Sets a register of 16 bits from the side of the device.
    pub(crate) fn put_u16(&mut self, register: u16, value: u16) {
        let at = usize::from(register);
        self.memory[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }

    /// A register of 8 bits.
    pub(crate) fn u8(&self, register: u16) -> u8 {
        self.memory[usize::from(register)]
    }

    /// Sets a register of 8 bits from the side of the device.
    pub(crate) fn put_u8(&mut self, register: u16, value: u8) {
        self.memory[usize::from(register)] = value;
    }

    /// Whether this is the device with a station address, or with this alias where that is enabled. Address 0 is nobody's.
    pub(crate) fn has_station(&self, address: u16) -> bool {
        if address == 0 {
            return false;
        }
        let by_alias = self.memory[ALIAS_ENABLED] & 1 != 0 && self.u16(registers::ALIAS) == address;
        self.u16(registers::STATION) == address || by_alias
    }

    /// The sync managers.
    pub(crate) fn sync_manager(&mut self, n: usize) -> &mut SyncManager {
        &mut self.sync_managers[n]
    }

    /// Configuration of a sync manager; `None` while it is not enabled.
    pub(crate) fn configuration(&self, n: usize) -> Option<Configuration> {
        self.sync_managers[n].configuration()
    }

    /// The state that was asked for since this was last called: AL control.
    pub(crate) fn take_asked_state(&mut self) -> Option<u16> {
        std::mem::take(&mut self.state_was_asked).then(|| self.u16(registers::AL_CONTROL))
    }

    /// Sets AL status and code.
    pub(crate) fn set_state(&mut self, status: u16, code: u16) {
        self.state_changed |= self.u16(registers::AL_STATUS) != status;
        self.put_u16(registers::AL_STATUS, status);
        self.put_u16(registers::AL_STATUS_CODE, code);
    }

    /// Sets the DL status. What it was after power-up is no change.
    pub(crate) fn set_links(&mut self, status: u16) {
        let before = self.u16(registers::DL_STATUS);
        self.links_changed |= before != 0 && before != status;
        self.put_u16(registers::DL_STATUS, status);
    }

    /// When the process data watchdog was last fed.
    pub(crate) fn fed_at(&self) -> Option<Duration> {
        self.fed_at
    }

    /// Starts the process data watchdog at this instant, or takes it out of service.
    pub(crate) fn feed(&mut self, at: Option<Duration>) {
        self.fed_at = at;
    }

    /// A process data watchdog's time; `None` where it is switched off.
    pub(crate) fn watchdog(&self) -> Option<Duration> {
        let unit_ns = (u64::from(self.u16(registers::WATCHDOG_DIVIDER)) + 2) * 40;
        let units = self.u16(registers::DATA_WATCHDOG);
        (units > 0).then(|| Duration::from_nanos(unit_ns * u64::from(units)))
    }

    /// The last instant at or before `now` at which SYNC0 was given.
    pub(crate) fn last_sync0(&self, now: Duration) -> Option<Sync0Pulse> {
        self.clock.last_sync0(&self.memory, now)
    }

    /// Events for the interrupt field of a datagram.
    pub(crate) fn events(&self) -> u16 {
        self.requested_events() & self.u16(registers::EVENT_MASK)
    }

    /// Events whether the mask lets them through or not.
    fn requested_events(&self) -> u16 {
        let mailboxes = self.sync_managers.iter().enumerate().filter(|(_, manager)| manager.is_full());
        let pending = mailboxes.fold(0, |bits, (n, _)| bits | SYNC_MANAGER_EVENT << n);
        let state = if self.state_changed { AL_EVENT } else { 0 };
        pending | state | if self.links_changed { DL_EVENT } else { 0 }
    }

    /// The bus reads memory; false if nothing of it is there, or sync managers refuse all of it. What is refused stays as it
    /// was in `into`.
    pub(crate) fn read(&mut self, first: u16, into: &mut [u8], now: Duration) -> bool {
        let Some(range) = self.range(first, into.len()) else { return false };
        self.refresh(now);
        let mut is_read = false;
        let mut rest = into;
        for part in self.parts(range) {
            let (bytes, behind) = rest.split_at_mut(part.range.len());
            is_read |= match part.manager {
                Some(n) => self.sync_managers[n].bus_reads(part.inside, bytes),
                None => self.read_memory(part.range, bytes),
            };
            rest = behind;
        }
        is_read
    }

    fn read_memory(&mut self, range: Range<usize>, into: &mut [u8]) -> bool {
        let mut is_there = false;
        for (at, byte) in range.clone().zip(into.iter_mut()) {
            let exists = registers::access(at as u16).is_some();
            is_there |= exists;
            *byte = if exists { self.memory[at] } else { 0 };
        }
        self.state_changed &= !range.contains(&usize::from(registers::AL_STATUS));
        self.links_changed &= !range.contains(&usize::from(registers::DL_STATUS));
        is_there
    }

    /// The bus writes memory; false if nothing of it is there or may be written, or sync managers refuse all of it.
    pub(crate) fn write(&mut self, first: u16, bytes: &[u8], now: Duration) -> bool {
        let Some(range) = self.range(first, bytes.len()) else { return false };
        let mut is_written = false;
        let mut rest = bytes;
        for part in self.parts(range) {
            let (bytes, behind) = rest.split_at(part.range.len());
            is_written |= match part.manager {
                Some(n) => self.write_managed(n, part.inside, bytes, now),
                None => self.write_memory(part.range, bytes, now),
            };
            rest = behind;
        }
        is_written
    }

    /// Outputs that are complete feed the watchdog.
    fn write_managed(&mut self, n: usize, inside: Range<usize>, bytes: &[u8], now: Duration) -> bool {
        let manager = &mut self.sync_managers[n];
        let feeds =
            manager.configuration().is_some_and(|c| c.feeds_watchdog && inside.end == usize::from(c.length));
        let is_written = manager.bus_writes(inside, bytes);
        if is_written && feeds {
            self.fed_at = Some(now);
            self.put_u16(registers::WATCHDOG_STATUS, 1);
        }
        is_written
    }

    fn write_memory(&mut self, range: Range<usize>, bytes: &[u8], now: Duration) -> bool {
        let mut is_written = false;
        for (at, &byte) in range.clone().zip(bytes) {
            let address = at as u16;
            match registers::access(address) {
                Some(Access::ReadWrite) if self.is_locked(address) => continue,
                Some(Access::ReadWrite) => self.memory[at] = byte,
                Some(Access::Clear) => self.memory[registers::group(address)].fill(0),
                Some(Access::Read)
                    if (registers::PORT_TIMES..registers::SYSTEM_TIME + 8).contains(&address) => {}
                Some(Access::Read) | None => continue,
            }
            is_written = true;
        }
        self.after_write(range.start as u16, bytes, now);
        is_written
    }

    /// Status and device side control of a sync manager cannot be written from the bus, and where it lies only while it is
    /// not enabled. The start of SYNC0 cannot be written while it is given.
    fn is_locked(&self, address: u16) -> bool {
        if (registers::SYNC_START..registers::SYNC_START + 8).contains(&address) {
            return self.u8(registers::SYNC_ACTIVATION) & 1 != 0;
        }
        let end = registers::SYNC_MANAGER + (SYNC_MANAGERS * registers::SYNC_MANAGER_BYTES) as u16;
        (registers::SYNC_MANAGER..end).contains(&address)
            && match address % 8 {
                5 | 7 => true,
                6 => false,
                _ => self.u8(address / 8 * 8 + 6) & 1 != 0,
            }
    }

    fn range(&self, first: u16, count: usize) -> Option<Range<usize>> {
        let end = usize::from(first) + count;
        (count > 0 && end <= self.memory.len()).then_some(usize::from(first)..end)
    }

    /// Cuts a part of the memory at the borders of the sync managers. Where two cover the same byte, it is the first one's.
    fn parts(&self, range: Range<usize>) -> Vec<Part> {
        let covered = |n: usize| self.sync_managers[n].configuration().map(|c| c.range());
        let mut parts = Vec::new();
        let mut at = range.start;
        while at < range.end {
            let ranges = (0..SYNC_MANAGERS).filter_map(|n| Some((n, covered(n)?)));
            let (mut manager, mut end) = (None, range.end);
            let mut inside = 0..0;
            for (n, covers) in ranges {
                if covers.contains(&at) {
                    end = end.min(covers.end);
                    (manager, inside) = (Some(n), at - covers.start..end - covers.start);
                    break;
                }
                if covers.start > at {
                    end = end.min(covers.start);
                }
            }
            parts.push(Part { manager, range: at..end, inside });
            at = end;
        }
        parts
    }

    /// What follows from registers that were written.
    fn after_write(&mut self, first: u16, bytes: &[u8], now: Duration) {
        let (from, end) = (usize::from(first), usize::from(first) + bytes.len());
        let touches = |register: u16| from <= usize::from(register) && usize::from(register) < end;
        if touches(registers::AL_CONTROL) {
            self.state_was_asked = true;
        }
        if touches(registers::SII_CONTROL + 1) && self.sii.obey(&mut self.memory) == Effect::ReloadAlias {
            self.load_alias();
        }
        let managers = usize::from(registers::SYNC_MANAGER);
        let managers_end = managers + SYNC_MANAGERS * registers::SYNC_MANAGER_BYTES;
        if from < managers_end && end > managers {
            self.configure_sync_managers();
        }
        if touches(registers::PORT_TIMES) {
            self.clock.latch(&mut self.memory, now, self.behind_ns);
        }
        if touches(registers::SYSTEM_TIME) {
            let offset = usize::from(registers::SYSTEM_TIME) - from;
            self.compare(&bytes[offset..], now);
        }
        self.clock.written(&mut self.memory, first, bytes.len(), now);
    }

    /// The system time of the reference clock, whole or only its low word; less is no time.
    fn compare(&mut self, received: &[u8], now: Duration) {
        if received.len() < 4 {
            return;
        }
        let mut whole = [0; 8];
        let count = received.len().min(8);
        whole[..count].copy_from_slice(&received[..count]);
        self.clock.compare(&mut self.memory, now, u64::from_le_bytes(whole), count == 8);
    }

    fn configure_sync_managers(&mut self) {
        for (n, manager) in self.sync_managers.iter_mut().enumerate() {
            let at = usize::from(registers::SYNC_MANAGER) + n * registers::SYNC_MANAGER_BYTES;
            let found = Configuration::decode(&self.memory[at..at + registers::SYNC_MANAGER_BYTES]);
            // There is nothing to manage in the registers, nor beyond the RAM.
            manager
                .configure(found.filter(|c| c.start >= registers::RAM && c.range().end <= self.memory.len()));
        }
    }

    /// Puts what changes by itself into the registers.
    fn refresh(&mut self, now: Duration) {
        self.clock.show(&mut self.memory, now);
        let events = self.requested_events();
        self.put_u16(registers::EVENT_REQUEST, events);
        for n in 0..SYNC_MANAGERS {
            let status = self.sync_managers[n].status();
            self.put_u8(sync_manager_status(n), status);
        }
    }

    /// Whether the MainDevice asks to see the last message of a mailbox again; the request is acknowledged by this.
    pub(crate) fn take_repeat_request(&mut self, n: usize) -> bool {
        let activate = registers::SYNC_MANAGER + (n * registers::SYNC_MANAGER_BYTES) as u16 + 6;
        let asked = self.u8(activate) & 2;
        let acknowledged = self.u8(activate + 1) & 2;
        if asked == acknowledged {
            return false;
        }
        let control = self.u8(activate + 1) & !2 | asked;
        self.put_u8(activate + 1, control);
        true
    }

    /// A logical datagram passes; whether inputs were put in, and whether outputs were taken out.
    pub(crate) fn exchange(
        &mut self,
        logical: u32,
        data: &mut [u8],
        direction: Direction,
        now: Duration,
    ) -> Hits {
        let mut hits = Hits::default();
        for n in 0..registers::FMMUS {
            let Some(fmmu) = Fmmu::decode(&self.memory, n) else { continue };
            let Some(window) = fmmu.window(logical, data.len()) else { continue };
            if direction.writes && fmmu.writes {
                hits.written |= self.write_window(window, data, now);
            }
        }
        for n in 0..registers::FMMUS {
            let Some(fmmu) = Fmmu::decode(&self.memory, n) else { continue };
            let Some(window) = fmmu.window(logical, data.len()) else { continue };
            if direction.reads && fmmu.reads {
                hits.read |= self.read_window(window, data, now);
            }
        }
        hits
    }

    fn write_window(&mut self, window: Window, data: &[u8], now: Duration) -> bool {
        match window {
            Window::Bytes { data: at, physical, count } => self.write(physical, &data[at..at + count], now),
            Window::Bits { data: at, physical, count } => (0..count).fold(false, |hit, k| {
                let bit = data[(at + k) / 8] >> ((at + k) % 8) & 1;
                let Ok(address) = u16::try_from((physical + k) / 8) else { return hit };
                let place = (physical + k) % 8;
                let mut byte = [self.last_written(address)];
                byte[0] = byte[0] & !(1 << place) | bit << place;
                self.write(address, &byte, now) || hit
            }),
        }
    }

    fn read_window(&mut self, window: Window, data: &mut [u8], now: Duration) -> bool {
        match window {
            Window::Bytes { data: at, physical, count } => {
                self.read(physical, &mut data[at..at + count], now)
            }
            Window::Bits { data: at, physical, count } => (0..count).fold(false, |hit, k| {
                let Ok(address) = u16::try_from((physical + k) / 8) else { return hit };
                let mut byte = [0];
                let is_read = self.read(address, &mut byte, now);
                let bit = byte[0] >> ((physical + k) % 8) & 1;
                let place = (at + k) % 8;
                if is_read {
                    data[(at + k) / 8] = data[(at + k) / 8] & !(1 << place) | bit << place;
                }
                is_read || hit
            }),
        }
    }

    /// A byte as the bus last wrote it.
    fn last_written(&self, address: u16) -> u8 {
        let at = usize::from(address);
        match self.parts(at..at + 1)[..] {
            [Part { manager: Some(n), ref inside, .. }] => self.sync_managers[n].last_written(inside.start),
            _ => self.memory.get(at).copied().unwrap_or(0),
        }
    }
}

/// A part of the memory that belongs to one sync manager, or to none.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    manager: Option<usize>,
    range: Range<usize>,
    /// Counted from the first byte of the sync manager.
    inside: Range<usize>,
}

/// Whether a logical command reads, writes or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Direction {
    /// Inputs go into the frame.
    pub(crate) reads: bool,
    /// Outputs are taken out of the frame.
    pub(crate) writes: bool,
}

/// What a logical datagram did at a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Hits {
    /// Something was read.
    pub(crate) read: bool,
    /// Something was written.
    pub(crate) written: bool,
}

/// Status register of a sync manager.
pub(crate) fn sync_manager_status(n: usize) -> u16 {
    registers::SYNC_MANAGER + (n * registers::SYNC_MANAGER_BYTES) as u16 + 5
}
