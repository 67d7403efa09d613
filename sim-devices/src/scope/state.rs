//! Settings of the oscilloscope.

use crate::scpi::{Error, Unit, code, matches, nr3};

/// Channels.
pub(super) const CHANNELS: usize = 4;
/// Channel of the synchronisation signal, from 0.
pub(super) const SYNC: usize = 1;
/// Divisions across the screen, and up it.
pub(super) const DIVISIONS: [f64; 2] = [10.0, 8.0];

/// One input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Channel {
    pub(super) displayed: bool,
    /// Per division.
    pub(super) scale: f64,
    pub(super) offset: f64,
    amperes: bool,
}

/// Where time zero stands on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reference {
    Left,
    Centre,
    Right,
}

/// Everything that a reset puts back.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub(super) channels: [Channel; CHANNELS],
    range_s: f64,
    reference: Reference,
    trigger_source: usize,
    pub(super) trigger_v: f64,
    /// Source of the record that is read, from 0, how it is read, and how much of it.
    pub(super) source: usize,
    pub(super) words: bool,
    pub(super) little_endian: bool,
    pub(super) unsigned: bool,
    raw: bool,
    pub(super) samples: u32,
}

impl Default for State {
    /// After a reset.
    fn default() -> Self {
        let channel = Channel { displayed: false, scale: 5.0, offset: 0.0, amperes: false };
        let mut channels = [channel; CHANNELS];
        channels[0].displayed = true;
        Self {
            channels,
            range_s: 1e-3,
            reference: Reference::Centre,
            trigger_source: 0,
            trigger_v: 0.0,
            source: 0,
            words: false,
            little_endian: false,
            unsigned: true,
            raw: false,
            samples: 1000,
        }
    }
}

impl State {
    /// Whether the synchronisation signal triggers.
    pub(super) fn triggers_on_sync(&self) -> bool {
        self.trigger_source == SYNC
    }

    /// Width of the screen.
    pub(super) fn range_s(&self) -> f64 {
        self.range_s
    }

    /// Length of a record before and after its trigger.
    pub(super) fn record_s(&self) -> [f64; 2] {
        let before_divisions = match self.reference {
            Reference::Left => 1.0,
            Reference::Centre => 0.5 * DIVISIONS[0],
            Reference::Right => DIVISIONS[0] - 1.0,
        };
        let before_s = self.range_s * before_divisions / DIVISIONS[0];
        [before_s, self.range_s - before_s]
    }

    /// Whether a record can be read as words, raw.
    pub(super) fn reads_words(&self) -> bool {
        self.words && self.raw && self.unsigned && self.channels[self.source].displayed
    }

    /// What a query of a setting is answered with.
    pub(super) fn answer(&self, unit: &Unit) -> Result<String, Error> {
        let is = |pattern: &str| matches(pattern, &unit.header).is_some();
        let word = |is_second: bool, words: [&str; 2]| words[usize::from(is_second)].to_owned();
        let channel = |k: usize| format!("CHAN{}", k + 1);
        let flag = |is_set: bool| u8::from(is_set).to_string();
        Ok(match () {
            () if unit.header.starts_with("CHAN") => return self.answer_channel(unit),
            () if is("TIMebase:MODE") => "MAIN".to_owned(),
            () if is("TIMebase:RANGe") => nr3(self.range_s, 3),
            () if is("TIMebase:POSition") => nr3(0.0, 3),
            () if is("TIMebase:REFerence") => match self.reference {
                Reference::Left => "LEFT",
                Reference::Centre => "CENT",
                Reference::Right => "RIGH",
            }
            .to_owned(),
            () if is("ACQuire:TYPE") => "HRES".to_owned(),
            () if is("TRIGger:MODE") => "EDGE".to_owned(),
            () if is("TRIGger:SWEep") => "NORM".to_owned(),
            () if is("TRIGger:EDGE:SLOPe") => "POS".to_owned(),
            () if is("TRIGger:EDGE:SOURce") => channel(self.trigger_source),
            () if is("TRIGger:EDGE:LEVel") => nr3(self.trigger_v, 3),
            () if is("WAVeform:SOURce") => channel(self.source),
            () if is("WAVeform:FORMat") => word(self.words, ["BYTE", "WORD"]),
            () if is("WAVeform:BYTeorder") => word(self.little_endian, ["MSBF", "LSBF"]),
            () if is("WAVeform:UNSigned") => flag(self.unsigned),
            () if is("WAVeform:POINts:MODE") => word(self.raw, ["NORM", "RAW"]),
            () if is("WAVeform:POINts") => format!("{:+}", self.samples),
            () => return Err(code::UNDEFINED_HEADER),
        })
    }

    fn answer_channel(&self, unit: &Unit) -> Result<String, Error> {
        let find = |pattern: &str| {
            let number = *matches(pattern, &unit.header)?.first()? as usize;
            self.channels.get(number.checked_sub(1)?)
        };
        if let Some(own) = find("CHANnel#:DISPlay") {
            return Ok(u8::from(own.displayed).to_string());
        }
        if let Some(own) = find("CHANnel#:UNITs") {
            return Ok(if own.amperes { "AMP" } else { "VOLT" }.to_owned());
        }
        if find("CHANnel#:PROBe").is_some() {
            return Ok(nr3(1.0, 2));
        }
        if let Some(own) = find("CHANnel#:SCALe") {
            return Ok(nr3(own.scale, 3));
        }
        find("CHANnel#:OFFSet").map(|own| nr3(own.offset, 3)).ok_or(code::UNDEFINED_HEADER)
    }

    /// Obeys a command.
    pub(super) fn set(&mut self, unit: &Unit) -> Result<(), Error> {
        let is = |pattern: &str| matches(pattern, &unit.header).is_some();
        match () {
            () if unit.header.starts_with("CHAN") => return self.set_channel(unit),
            () if unit.header.starts_with("WAV") => return self.set_waveform(unit),
            () if is("TIMebase:MODE") => drop(unit.choice(&["MAIN"])?),
            () if is("TIMebase:RANGe") => self.range_s = unit.number([20e-9, 500.0])?,
            () if is("TIMebase:POSition") => drop(unit.number([0.0, 0.0])?),
            () if is("TIMebase:REFerence") => {
                let places = [Reference::Left, Reference::Centre, Reference::Right];
                self.reference = places[unit.choice(&["LEFT", "CENTer", "RIGHt"])?];
            }
            () if is("ACQuire:TYPE") => drop(unit.choice(&["HRESolution"])?),
            () if is("TRIGger:MODE") => drop(unit.choice(&["EDGE"])?),
            () if is("TRIGger:SWEep") => drop(unit.choice(&["NORMal"])?),
            () if is("TRIGger:EDGE:SLOPe") => drop(unit.choice(&["POSitive"])?),
            () if is("TRIGger:EDGE:SOURce") => self.trigger_source = channel_named(unit.only()?)?,
            () if is("TRIGger:EDGE:LEVel") => {
                let channel = self.channels[self.trigger_source];
                let most = 0.75 * DIVISIONS[1] * channel.scale;
                self.trigger_v = unit.number([channel.offset - most, channel.offset + most])?;
            }
            () => return Err(code::UNDEFINED_HEADER),
        }
        Ok(())
    }

    fn set_channel(&mut self, unit: &Unit) -> Result<(), Error> {
        let find = |pattern: &str| {
            let number = *matches(pattern, &unit.header)?.first()?;
            (1..=CHANNELS as u32).contains(&number).then(|| number as usize - 1)
        };
        if let Some(k) = find("CHANnel#:DISPlay") {
            self.channels[k].displayed = unit.choice(&["0", "OFF", "1", "ON"])? >= 2;
        } else if let Some(k) = find("CHANnel#:UNITs") {
            self.channels[k].amperes = unit.choice(&["VOLT", "AMPere"])? == 1;
        } else if find("CHANnel#:PROBe").is_some() {
            unit.number([1.0, 1.0])?;
        } else if let Some(k) = find("CHANnel#:SCALe") {
            self.channels[k].scale = unit.number([1e-3, 100.0])?;
        } else if let Some(k) = find("CHANnel#:OFFSet") {
            self.channels[k].offset = unit.number([-100.0, 100.0])?;
        } else {
            return Err(code::UNDEFINED_HEADER);
        }
        Ok(())
    }

    fn set_waveform(&mut self, unit: &Unit) -> Result<(), Error> {
        let is = |pattern: &str| matches(pattern, &unit.header).is_some();
        match () {
            () if is("WAVeform:SOURce") => self.source = channel_named(unit.only()?)?,
            () if is("WAVeform:FORMat") => self.words = unit.choice(&["BYTE", "WORD"])? == 1,
            () if is("WAVeform:BYTeorder") => {
                self.little_endian = unit.choice(&["MSBFirst", "LSBFirst"])? == 1;
            }
            () if is("WAVeform:UNSigned") => self.unsigned = unit.choice(&["0", "OFF", "1", "ON"])? >= 2,
            () if is("WAVeform:POINts:MODE") => self.raw = unit.choice(&["NORMal", "RAW"])? == 1,
            () if is("WAVeform:POINts") => {
                let count = unit.number([100.0, 500_000.0])?;
                // 1, 2 or 5 times a power of ten.
                let digit = count / 10_f64.powf(count.log10().floor());
                if ![1.0, 2.0, 5.0].iter().any(|known| (digit - known).abs() < 1e-9) {
                    return Err(code::OUT_OF_RANGE);
                }
                self.samples = count as u32;
            }
            () => return Err(code::UNDEFINED_HEADER),
        }
        Ok(())
    }
}

/// `CHAN2` or `CHANNEL2`, from 0.
fn channel_named(word: &str) -> Result<usize, Error> {
    let numbers = matches("CHANnel#", word).ok_or(code::ILLEGAL_PARAMETER)?;
    let number = numbers.first().map_or(0, |n| *n as usize);
    if (1..=CHANNELS).contains(&number) { Ok(number - 1) } else { Err(code::ILLEGAL_PARAMETER) }
}
