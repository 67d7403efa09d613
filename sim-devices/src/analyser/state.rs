//! Settings of the analyser.

use crate::scpi::{Error, Unit, code, matches, nr3};

/// What a trace shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parameter {
    Resistance,
    Reactance,
    Level,
    Current,
}

const PARAMETERS: [(&str, Parameter); 4] = [
    ("R", Parameter::Resistance),
    ("X", Parameter::Reactance),
    ("VAC", Parameter::Level),
    ("IAC", Parameter::Current),
];

/// Frequencies, levels (V RMS) and points that it takes.
const FREQUENCIES_HZ: [f64; 2] = [20.0, 10e6];
const LEVELS_V: [f64; 2] = [0.005, 1.0];
const POINTS: [f64; 2] = [2.0, 1601.0];

/// Everything that a preset puts back.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    start_hz: f64,
    stop_hz: f64,
    points_count: f64,
    logarithmic: bool,
    pub(super) level_v_rms: f64,
    /// Definitions of the traces, and how many there are.
    traces: [Parameter; 4],
    traces_count: f64,
    selected: usize,
    continuous: bool,
    bus_trigger: bool,
}

impl Default for State {
    /// After a preset: it sweeps on its own, linearly, over everything.
    fn default() -> Self {
        Self {
            start_hz: FREQUENCIES_HZ[0],
            stop_hz: FREQUENCIES_HZ[1],
            points_count: 201.0,
            logarithmic: false,
            level_v_rms: 0.5,
            traces: [Parameter::Resistance; 4],
            traces_count: 2.0,
            selected: 0,
            continuous: true,
            bus_trigger: false,
        }
    }
}

impl State {
    /// Whether a trigger over the bus starts a sweep.
    pub(super) fn takes_bus_triggers(&self) -> bool {
        self.continuous && self.bus_trigger
    }

    /// What the selected trace shows.
    pub(super) fn selected(&self) -> Result<Parameter, Error> {
        if self.selected as f64 >= self.traces_count {
            return Err(code::SETTINGS_CONFLICT);
        }
        Ok(self.traces[self.selected])
    }

    /// Frequencies of a sweep.
    pub(super) fn frequencies_hz(&self) -> Result<Vec<f64>, Error> {
        if self.stop_hz <= self.start_hz {
            return Err(code::SETTINGS_CONFLICT);
        }
        let place = |k: u32| {
            let ratio = f64::from(k) / (self.points_count - 1.0);
            if self.logarithmic {
                self.start_hz * (self.stop_hz / self.start_hz).powf(ratio)
            } else {
                self.start_hz + ratio * (self.stop_hz - self.start_hz)
            }
        };
        Ok((0..self.points_count as u32).map(place).collect())
    }

    /// What a query of a setting is answered with.
    pub(super) fn answer(&self, unit: &Unit) -> Result<String, Error> {
        let is = |pattern: &str| matches(pattern, &unit.header);
        let flag = |is_set: bool| u8::from(is_set).to_string();
        Ok(match () {
            () if is("SENSe#:FREQuency:STARt").is_some() => nr3(self.start_hz, 11),
            () if is("SENSe#:FREQuency:STOP").is_some() => nr3(self.stop_hz, 11),
            () if is("SENSe#:SWEep:POINts").is_some() => format!("{:+}", self.points_count),
            () if is("SENSe#:SWEep:TYPE").is_some() => {
                if self.logarithmic { "LOG" } else { "LIN" }.to_owned()
            }
            () if is("SENSe#:SWEep:DIRection").is_some() => "UP".to_owned(),
            () if is("SOURce#:MODE").is_some() => "VOLT".to_owned(),
            () if is("SOURce#:VOLTage").is_some() => nr3(self.level_v_rms, 11),
            () if is("FORMat:DATA").is_some() => "ASC".to_owned(),
            () if is("INITiate#:CONTinuous").is_some() => flag(self.continuous),
            () if is("TRIGger:SOURce").is_some() => if self.bus_trigger { "BUS" } else { "INT" }.to_owned(),
            () if is("CALCulate#:PARameter:COUNt").is_some() => format!("{:+}", self.traces_count),
            () => match is("CALCulate#:PARameter#:DEFine").as_deref() {
                Some([1, trace @ 1..=4]) => {
                    let shown = self.traces[*trace as usize - 1];
                    let word = PARAMETERS.iter().find(|(_, parameter)| *parameter == shown);
                    word.map_or("R", |(word, _)| word).to_owned()
                }
                _ => return Err(code::UNDEFINED_HEADER),
            },
        })
    }

    /// Obeys a command; whether a sweep before is meaningless then.
    pub(super) fn set(&mut self, unit: &Unit) -> Result<bool, Error> {
        let is = |pattern: &str| matches(pattern, &unit.header);
        match () {
            () if is("FORMat:DATA").is_some() => {
                unit.choice(&["ASCii"])?;
                return Ok(false);
            }
            () if is("SENSe#:SWEep:TYPE").is_some() => {
                self.logarithmic = unit.choice(&["LINear", "LOGarithmic"])? == 1;
            }
            () if is("SENSe#:SWEep:DIRection").is_some() => {
                unit.choice(&["UP"])?;
            }
            () if is("SENSe#:SWEep:POINts").is_some() => self.points_count = unit.number(POINTS)?.round(),
            () if is("SENSe#:FREQuency:STARt").is_some() => self.start_hz = unit.number(FREQUENCIES_HZ)?,
            () if is("SENSe#:FREQuency:STOP").is_some() => self.stop_hz = unit.number(FREQUENCIES_HZ)?,
            () if is("SOURce#:MODE").is_some() => {
                unit.choice(&["VOLTage"])?;
            }
            () if is("SOURce#:VOLTage").is_some() => self.level_v_rms = unit.number(LEVELS_V)?,
            () if is("INITiate#:CONTinuous").is_some() => {
                self.continuous = unit.choice(&["OFF", "0", "ON", "1"])? >= 2;
            }
            () if is("TRIGger:SOURce").is_some() => {
                self.bus_trigger = unit.choice(&["INTernal", "BUS"])? == 1;
            }
            () => return self.set_trace(unit),
        }
        Ok(true)
    }

    fn set_trace(&mut self, unit: &Unit) -> Result<bool, Error> {
        let is = |pattern: &str| matches(pattern, &unit.header);
        if is("CALCulate#:PARameter:COUNt").is_some() {
            self.traces_count = unit.number([1.0, 4.0])?.round();
            return Ok(true);
        }
        let trace = |numbers: Vec<u32>| match numbers[..] {
            [1, trace @ 1..=4] => Ok(trace as usize - 1),
            _ => Err(code::UNDEFINED_HEADER),
        };
        if let Some(numbers) = is("CALCulate#:PARameter#:DEFine") {
            let words = PARAMETERS.map(|(word, _)| word);
            self.traces[trace(numbers)?] = PARAMETERS[unit.choice(&words)?].1;
            return Ok(true);
        }
        if let Some(numbers) = is("CALCulate#:PARameter#:SELect") {
            self.selected = trace(numbers)?;
            return Ok(false);
        }
        Err(code::UNDEFINED_HEADER)
    }
}
