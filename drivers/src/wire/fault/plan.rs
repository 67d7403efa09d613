//! Which frames have which fault.

use std::time::Duration;

use super::super::Way;

/// Shortest frame that is left of one that is cut off: its Ethernet header.
pub const MIN_TRUNCATED_BYTES: usize = 14;

/// What goes wrong with a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// It is lost.
    Drop,
    /// It comes late.
    Delay {
        /// How late.
        by: Duration,
    },
    /// It comes twice.
    Duplicate,
    /// One of its bits is wrong.
    Corrupt {
        /// In which byte, from the beginning of the frame; one beyond its end is its last. `None`: in any.
        byte: Option<usize>,
    },
    /// It is cut off.
    Truncate {
        /// Bytes that are left; the Ethernet header always is.
        bytes: usize,
    },
    /// It comes behind the next frame of its way.
    Reorder,
}

/// When a fault occurs. Frames (datagrams of a port, bytes of a line) are counted from 1, each way for itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Occurrence {
    /// To each frame with this probability.
    Chance(f64),
    /// To frames n, 2 n, 3 n, …; never if 0.
    Every(u64),
    /// To consecutive frames.
    At {
        /// The first.
        first: u64,
        /// How many.
        count: u64,
    },
}

/// A fault of an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameFault {
    /// Which way the frames go that have it.
    pub way: Way,
    /// What goes wrong.
    pub kind: FaultKind,
    /// When.
    pub when: Occurrence,
}

/// All faults of an interface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultPlan {
    /// Seed of everything random.
    pub seed: u64,
    /// The faults. Several may befall the same frame; a lost one is lost whatever else there is.
    pub faults: Vec<FrameFault>,
}

/// What befalls one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fate {
    pub(super) is_dropped: bool,
    /// The longest, where there are several.
    pub(super) delay: Option<Duration>,
    pub(super) is_doubled: bool,
    /// Place and mask of the wrong bit.
    pub(super) flip: Option<(usize, u8)>,
    pub(super) truncate_to: Option<usize>,
    pub(super) is_behind_next: bool,
}

/// What a number is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drawn {
    Whether,
    Bit,
    Garbage,
}

impl FaultPlan {
    /// What befalls the frame with this number, from 1, that has so many bytes.
    pub(super) fn fate(&self, way: Way, number: u64, bytes: usize) -> Fate {
        let mut fate = Fate::default();
        for (k, fault) in self.faults.iter().enumerate().filter(|(_, fault)| fault.way == way) {
            if !self.occurs(k, fault, number) {
                continue;
            }
            match fault.kind {
                FaultKind::Drop => fate.is_dropped = true,
                FaultKind::Delay { by } => fate.delay = fate.delay.max(Some(by)),
                FaultKind::Duplicate => fate.is_doubled = true,
                FaultKind::Corrupt { byte } => {
                    let drawn = self.draw(k, way, number, Drawn::Bit);
                    let last = bytes.saturating_sub(1);
                    let any = (drawn >> 8) as usize % bytes.max(1);
                    fate.flip = Some((byte.map_or(any, |byte| byte.min(last)), 1 << (drawn % 8)));
                }
                FaultKind::Truncate { bytes } => {
                    let bytes = bytes.max(MIN_TRUNCATED_BYTES);
                    fate.truncate_to = Some(fate.truncate_to.map_or(bytes, |other| other.min(bytes)));
                }
                FaultKind::Reorder => fate.is_behind_next = true,
            }
        }
        fate
    }

    fn occurs(&self, index: usize, fault: &FrameFault, number: u64) -> bool {
        fault.when.includes(number, || self.draw(index, fault.way, number, Drawn::Whether))
    }

    fn draw(&self, index: usize, way: Way, number: u64, what: Drawn) -> u64 {
        draw(self.seed, index, way, number, what)
    }
}

impl Occurrence {
    /// Whether the unit with this number, from 1, has the fault; `draw` gives the number that chance decides by.
    pub(super) fn includes(self, number: u64, draw: impl FnOnce() -> u64) -> bool {
        match self {
            Self::Chance(probability) => {
                /// Values of a fraction with 53 bits.
                const STEPS: f64 = (1_u64 << 53) as f64;
                ((draw() >> 11) as f64 / STEPS) < probability
            }
            Self::Every(period) => period > 0 && number.is_multiple_of(period),
            Self::At { first, count } => number.checked_sub(first).is_some_and(|after| after < count),
        }
    }
}

/// A number that depends on its address alone: no draw changes another.
pub(super) fn draw(seed: u64, index: usize, way: Way, number: u64, what: Drawn) -> u64 {
    let stream = (index as u64) << 8 | (way as u64) << 4 | what as u64;
    mixed(mixed(mixed(seed) ^ stream) ^ number)
}

/// Mixes the bits of a number (the finaliser of `SplitMix64`).
pub(super) fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
