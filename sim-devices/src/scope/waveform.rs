//! Samples of a record, digitised, and the preamble that scales them.

use std::time::Duration;

use super::Scope;
use super::record::Record;
use super::state::{DIVISIONS, SYNC};
use crate::physics::noise::Noise;
use crate::scpi::{Error, code, nr3};

/// Codes of a word, and how many of them one step of the converter is: 12 bits.
const CODES: f64 = 65_536.0;
const CODES_PER_STEP: f64 = 16.0;
const MIDDLE: f64 = 32_768.0;
/// Codes of what is off the screen.
const BELOW: u16 = 1;
const ABOVE: u16 = u16::MAX;
/// `type` of high resolution.
const HIGH_RESOLUTION: u32 = 3;
/// Values that one record may draw.
const DRAWS_PER_RECORD: u64 = 1 << 20;

/// What stands between a signal and its samples.
#[derive(Clone, Debug)]
pub(super) struct Probe {
    pub(super) scale: f64,
    pub(super) zero_a: f64,
    pub(super) noise: Noise,
    /// Relative to the height of the screen.
    pub(super) vertical: Noise,
}

impl Scope {
    /// The record, once it is done, and the time of its trigger.
    fn done(&self, now: Duration) -> Result<(&Record, f64), Error> {
        if !self.state.reads_words() {
            return Err(code::SETTINGS_CONFLICT);
        }
        let record = self.record.as_ref().filter(|record| !record.runs(now)).ok_or(code::STALE)?;
        Ok((record, record.trigger().ok_or(code::STALE)?.as_secs_f64()))
    }

    fn increment_s(&self) -> f64 {
        self.state.range_s() / f64::from(self.state.samples)
    }

    /// Number of the first sample since power-on: the sample clock knows nothing of the trigger.
    fn first_sample(&self, record: &Record, trigger_s: f64) -> f64 {
        ((trigger_s - record.before_s) / self.increment_s()).ceil()
    }

    pub(super) fn answer_preamble(&mut self, now: Duration) -> Result<(), Error> {
        let (record, trigger_s) = self.done(now)?;
        let increment_s = self.increment_s();
        let origin_s = self.first_sample(record, trigger_s) * increment_s - trigger_s;
        let channel = self.state.channels[self.state.source];
        let y_increment = DIVISIONS[1] * channel.scale / CODES;
        let points = self.state.samples;
        let offset = channel.offset;
        let text = format!(
            "+1,+{HIGH_RESOLUTION},+{points},+1,{},{},+0,{},{},+{MIDDLE}",
            nr3(increment_s, 12),
            nr3(origin_s, 12),
            nr3(y_increment, 12),
            nr3(offset, 6)
        );
        self.port.respond(text.as_bytes());
        Ok(())
    }

    pub(super) fn answer_data(&mut self, now: Duration) -> Result<(), Error> {
        let (record, trigger_s) = self.done(now)?;
        let (record, first) = (record.clone(), self.first_sample(record, trigger_s));
        let draw = self.records_count * DRAWS_PER_RECORD;
        let count = self.state.samples as usize;
        let mut content = Vec::with_capacity(2 * count);
        for k in 0..count {
            let time_s = (first + k as f64) * self.increment_s();
            let code = self.sample(&record, time_s, draw + k as u64);
            content.extend(if self.state.little_endian { code.to_le_bytes() } else { code.to_be_bytes() });
        }
        let mut block = format!("#8{:08}", content.len()).into_bytes();
        block.append(&mut content);
        self.port.respond(&block);
        Ok(())
    }

    /// The code of the selected channel at a time.
    fn sample(&mut self, record: &Record, time_s: f64, draw: u64) -> u16 {
        let source = self.state.source;
        let channel = self.state.channels[source];
        let height = DIVISIONS[1] * channel.scale;
        let value = match source {
            0 | 2 => {
                let drive = source / 2;
                let true_a = record.current_a(drive, self.current_bandwidth_hz[drive], time_s);
                self.probe.scale * true_a + self.probe.zero_a + self.probe.noise.at(draw)
            }
            SYNC => record.sync_v(time_s),
            _ => 0.0,
        };
        // Every channel has a converter, and noise, of its own.
        let vertical = self.probe.vertical.at(draw ^ ((source as u64) << 40));
        let steps = ((value - channel.offset) / height + vertical) * CODES / CODES_PER_STEP;
        let code = CODES_PER_STEP * steps.round() + MIDDLE;
        match () {
            () if code < CODES_PER_STEP => BELOW,
            () if code >= CODES => ABOVE,
            () => code as u16,
        }
    }
}
