//! What can go wrong on the wire and at the SubDevices, and nowhere behind them.

use std::time::Duration;

use super::application::Emergency;

/// Something that goes wrong from now on, or is put right again. `device` counts from 0 in the order of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineFault {
    /// The next frames are not answered.
    Drop {
        /// How many.
        frames: u32,
    },
    /// The answers to the next frames come late.
    Delay {
        /// How many.
        frames: u32,
        /// How late.
        by: Duration,
    },
    /// The next frames are answered twice.
    Duplicate {
        /// How many.
        frames: u32,
    },
    /// A byte of each of the next answers is wrong.
    Corrupt {
        /// How many.
        frames: u32,
        /// Which byte, from the beginning of the frame; one beyond its end is its last.
        byte: usize,
    },
    /// The answers to the next frames are cut off.
    Truncate {
        /// How many.
        frames: u32,
        /// Bytes that are left.
        bytes: usize,
    },
    /// The working counters of all datagrams of the next frames are off.
    WorkingCounter {
        /// How many.
        frames: u32,
        /// By how much.
        by: i16,
    },
    /// The cable to a device breaks, or is plugged in again: the device and all behind it are gone.
    Unplugged {
        /// The first that is gone.
        device: usize,
        /// Whether the cable is broken.
        is_gone: bool,
    },
    /// A device reports an error of its state machine. It leaves OP if it is there.
    AlError {
        /// The device.
        device: usize,
        /// AL status code.
        code: u16,
    },
    /// A device refuses all transitions upwards.
    RefusesTransitions {
        /// The device.
        device: usize,
        /// AL status code; `None` puts it right.
        code: Option<u16>,
    },
    /// Transitions upwards take time.
    SlowTransitions {
        /// The device.
        device: usize,
        /// How long.
        take: Duration,
    },
    /// The process data watchdog of a device acts.
    Watchdog {
        /// The device.
        device: usize,
    },
    /// A device takes requests by mailbox and does not answer.
    Mute {
        /// The device.
        device: usize,
        /// Whether it is mute.
        is_mute: bool,
    },
    /// Answers by mailbox take time.
    SlowMailbox {
        /// The device.
        device: usize,
        /// How long.
        take: Duration,
    },
    /// Every SDO transfer that begins is aborted.
    RefusesSdo {
        /// The device.
        device: usize,
        /// Abort code; `None` puts it right.
        code: Option<u32>,
    },
    /// A device sends an emergency message.
    Emergency {
        /// The device.
        device: usize,
        /// What it says.
        emergency: Emergency,
    },
    /// The clock of a device jumps.
    ClockStep {
        /// The device.
        device: usize,
        /// By how much, ns.
        by_ns: i64,
    },
    /// The clock of a device runs at another rate.
    ClockDrift {
        /// The device.
        device: usize,
        /// Rate error, parts per million.
        rate_ppm: f64,
    },
    /// A device gives no SYNC0 any more, or again.
    Sync0Lost {
        /// The device.
        device: usize,
        /// Whether it is lost.
        is_lost: bool,
    },
}

/// What happens to the next frames.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameFaults {
    drop: u32,
    delay: u32,
    delay_by: Duration,
    duplicate: u32,
    corrupt: u32,
    corrupt_byte: usize,
    truncate: u32,
    truncate_to: usize,
    counter: u32,
    counter_by: i16,
}

/// What happens to one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Fate {
    pub(crate) is_dropped: bool,
    pub(crate) delay: Duration,
    pub(crate) is_doubled: bool,
    pub(crate) corrupt_byte: Option<usize>,
    pub(crate) truncate_to: Option<usize>,
    pub(crate) counter_by: i16,
}

impl FrameFaults {
    /// Takes over a fault of frames; false if it is one of devices.
    pub(crate) fn add(&mut self, fault: LineFault) -> bool {
        match fault {
            LineFault::Drop { frames } => self.drop = frames,
            LineFault::Delay { frames, by } => (self.delay, self.delay_by) = (frames, by),
            LineFault::Duplicate { frames } => self.duplicate = frames,
            LineFault::Corrupt { frames, byte } => (self.corrupt, self.corrupt_byte) = (frames, byte),
            LineFault::Truncate { frames, bytes } => (self.truncate, self.truncate_to) = (frames, bytes),
            LineFault::WorkingCounter { frames, by } => (self.counter, self.counter_by) = (frames, by),
            _ => return false,
        }
        true
    }

    /// What happens to the next frame.
    pub(crate) fn next(&mut self) -> Fate {
        Fate {
            is_dropped: counts_down(&mut self.drop),
            delay: if counts_down(&mut self.delay) { self.delay_by } else { Duration::ZERO },
            is_doubled: counts_down(&mut self.duplicate),
            corrupt_byte: counts_down(&mut self.corrupt).then_some(self.corrupt_byte),
            truncate_to: counts_down(&mut self.truncate).then_some(self.truncate_to),
            counter_by: if counts_down(&mut self.counter) { self.counter_by } else { 0 },
        }
    }
}

fn counts_down(left: &mut u32) -> bool {
    let is_due = *left > 0;
    *left = left.saturating_sub(1);
    is_due
}
