//! Oscilloscope: one triggered record of the motor current (Keysight InfiniiVision command set).
//!
//! Current probes hang on one channel per axis, the bench's synchronisation signal on another one: its rising edge
//! triggers. The record comes as words (WORD, little-endian, unsigned) with the preamble that scales them:
//! `t = (i − xref)·xinc + xorig`, `v = (code − yref)·yinc + yorig`; code 0 is a hole, a sample that was not taken.
//! `:SING` leaves the parser free, so the armed event and the run bit are asked for until they say what is wanted.

mod preamble;
mod script;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use preamble::Preamble;
use script::Want;

use crate::device::{Channel, DeviceError, Width};
use crate::scpi::{Dialogue, FormatError, Identity, Instrument, LONGEST_ANSWER, Session, number};

/// Slowest sampling that resolves the rise of a current loop of 1 kHz.
pub const LEAST_RATE_HZ: f64 = 100e3;
/// Models that speak these commands.
pub const MODELS: [&str; 4] = ["DSO-X", "MSO-X", "DSOX", "MSOX"];

/// What the driver must know of an oscilloscope.
#[derive(Clone, Debug, PartialEq)]
pub struct ScopeSettings {
    /// Name in errors and topics.
    pub name: String,
    /// Channels of the current probes: azimuth, elevation.
    pub current_channels: [u8; 2],
    /// Channel of the synchronisation signal.
    pub sync_channel: u8,
    /// Currents up to plus and minus this are on the screen.
    pub current_range_a: f64,
    /// Time allowed for an answer.
    pub reply_timeout_s: f64,
}

/// A record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capture {
    /// Axis whose current is looked at: 0 azimuth, 1 elevation.
    pub axis: usize,
    /// Least samples per second.
    pub sample_rate_hz: f64,
    /// Length of the record from the trigger on; a ninth of it more lies before.
    pub duration_s: f64,
}

/// An oscilloscope behind its line.
#[derive(Clone, Debug)]
pub struct Scope {
    settings: ScopeSettings,
    dialogue: Dialogue<Want>,
    capture: Option<Capture>,
    armed: bool,
    /// Current, synchronisation signal.
    preambles: [Preamble; 2],
    codes: [Vec<u16>; 2],
}

/// Between two looks at the instrument while it waits for its trigger.
const LOOK: Duration = Duration::from_millis(5);
/// Bit of the operation condition register that is 1 while the instrument runs.
const RUNNING: u32 = 1 << 3;
/// Codes of samples that are off the screen.
const CLIPPED: [u16; 2] = [1, u16::MAX];

impl Scope {
    /// What a sample adds to the log, in the order of [`Scope::row`].
    pub const CHANNELS: &'static [Channel] = &[
        Channel { name: "time_s", unit: "s", width: Width::F64 },
        Channel { name: "current_a", unit: "A", width: Width::F64 },
        Channel { name: "sync_v", unit: "V", width: Width::F64 },
    ];

    /// A driver that has not spoken to its instrument yet; its first dialogue asks who it is.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] for a range or timeout that cannot be, or a channel with two cables.
    pub fn new(settings: ScopeSettings) -> Result<Self, DeviceError> {
        let refused = |setting, value, allowed: &str| {
            let device = settings.name.clone();
            let allowed = allowed.to_owned();
            Err(DeviceError::Setting { device, setting, value, allowed })
        };
        for (setting, value) in
            [("current_range_a", settings.current_range_a), ("reply_timeout_s", settings.reply_timeout_s)]
        {
            if !(value.is_finite() && value > 0.0) {
                return refused(setting, value, "it must be finite and above 0");
            }
        }
        let [az, el] = settings.current_channels;
        let sync = settings.sync_channel;
        if let Some(&channel) = [az, el, sync].iter().find(|channel| !(1..=4).contains(*channel)) {
            return refused("channel", f64::from(channel), "channels are 1 to 4");
        }
        if az == el || az == sync || el == sync {
            return refused("sync_channel", f64::from(sync), "every signal needs its own channel");
        }
        let dialogue = Dialogue::new(&settings.name, Want::Identity, settings.reply_timeout_s);
        Ok(Self {
            settings,
            dialogue,
            capture: None,
            armed: false,
            preambles: [Preamble::default(); 2],
            codes: [Vec::new(), Vec::new()],
        })
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &ScopeSettings {
        &self.settings
    }

    /// Readies everything for a record, so that nothing is left to be reserved while it is taken.
    ///
    /// # Errors
    /// A record that this instrument cannot take.
    pub fn prepare(&mut self, capture: &Capture) -> Result<(), DeviceError> {
        let samples = script::samples(&self.settings.name, capture)?;
        let script = script::of(&self.settings, capture, samples);
        let timeout_s = self.settings.reply_timeout_s;
        let longest = (2 * samples as usize + 64).max(LONGEST_ANSWER);
        self.dialogue.session = Session::new(&self.settings.name, script, longest, timeout_s);
        self.codes = [0, 1].map(|_| Vec::with_capacity(samples as usize));
        self.capture = Some(*capture);
        self.armed = false;
        Ok(())
    }

    /// Whether the instrument waits for its trigger.
    pub fn is_armed(&self) -> bool {
        self.armed && self.dialogue.session.is_running()
    }

    /// Samples of the record that is done, holes included.
    pub fn samples_count(&self) -> usize {
        self.codes[0].len()
    }

    /// A sample in the order of [`Scope::CHANNELS`], its time from the trigger on; `None` beyond the end and for holes.
    pub fn row(&self, sample: usize) -> Option<[f64; 3]> {
        let [current, sync] = [0, 1].map(|k| self.preambles[k].value(*self.codes[k].get(sample)?));
        Some([self.preambles[0].time_s(sample), current?, sync?])
    }

    fn bits(&self) -> Result<u32, DeviceError> {
        let bits = number::number(self.dialogue.session.answer(), 1)
            .map_err(|source| self.dialogue.unusable(source))?;
        Ok(bits as u32)
    }

    fn take_preamble(&mut self, which: usize) -> Result<(), DeviceError> {
        let preamble = Preamble::parse(self.dialogue.session.answer())
            .map_err(|source| self.dialogue.unusable(source))?;
        self.preambles[which] = preamble;
        let Some(capture) = self.capture else { return Ok(()) };
        if preamble.x_increment_s > 1.0 / capture.sample_rate_hz {
            let expected = format!("at least {} samples/s", capture.sample_rate_hz);
            let found = format!("{} samples/s", 1.0 / preamble.x_increment_s);
            return Err(mismatch(&self.settings.name, "sample rate", &expected, found));
        }
        let [current, sync] = &self.preambles;
        let same = current.x_origin_s == sync.x_origin_s && current.x_increment_s == sync.x_increment_s;
        if which == 1 && !same {
            return Err(mismatch(
                &self.settings.name,
                "time axis of the trigger channel",
                "that of the current",
                "another one".to_owned(),
            ));
        }
        Ok(())
    }

    fn take_data(&mut self, which: usize) -> Result<(), DeviceError> {
        let bytes = self.dialogue.session.answer();
        let expected = self.preambles[which].points;
        if bytes.len() != 2 * expected {
            return Err(self.dialogue.unusable(FormatError::Count { expected, found: bytes.len() / 2 }));
        }
        let codes = &mut self.codes[which];
        codes.clear();
        codes.extend(bytes.as_chunks::<2>().0.iter().map(|word| u16::from_le_bytes(*word)));
        let clipped = codes.iter().filter(|code| CLIPPED.contains(code)).count();
        if clipped > 0 {
            let what = ["current", "synchronisation signal"][which];
            let found = format!("{clipped} off the screen");
            return Err(mismatch(
                &self.settings.name,
                what,
                "every sample on the screen (`current-range`)",
                found,
            ));
        }
        Ok(())
    }
}

impl Instrument for Scope {
    type Query = Want;

    const ABORT: &'static str = script::ABORT;

    fn dialogue(&mut self) -> &mut Dialogue<Want> {
        &mut self.dialogue
    }

    fn check(&self, identity: &Identity) -> Result<(), DeviceError> {
        if MODELS.iter().any(|model| identity.model.starts_with(model)) {
            return Ok(());
        }
        Err(mismatch(&self.settings.name, "model in *IDN?", "an InfiniiVision", format!("`{identity}`")))
    }

    fn forget(&mut self) {
        self.armed = false;
        self.codes.iter_mut().for_each(Vec::clear);
    }

    fn take(&mut self, want: Want, now: Duration) -> Result<(), DeviceError> {
        match want {
            Want::Identity => Ok(()),
            Want::Ready => self.bits().map(|_| ()),
            Want::Armed => {
                self.armed = self.bits()? & 1 != 0;
                if !self.armed {
                    self.dialogue.session.again(now + LOOK);
                }
                Ok(())
            }
            Want::Running => {
                if self.bits()? & RUNNING != 0 {
                    self.dialogue.session.again(now + LOOK);
                } else {
                    self.armed = false;
                }
                Ok(())
            }
            Want::Preamble(which) => self.take_preamble(which),
            Want::Data(which) => self.take_data(which),
        }
    }
}

fn mismatch(name: &str, field: &'static str, expected: &str, found: String) -> DeviceError {
    DeviceError::Field {
        device: name.to_owned(),
        field,
        expected: expected.to_owned(),
        found,
        help: "check range, probes, memory and address of the instrument",
    }
}
