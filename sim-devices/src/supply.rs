//! A DC power supply with three outputs (Keysight E36300 command set, ratings of the E36313A).
//!
//! Every output feeds a resistance. It holds its voltage while the load takes less than the current limit, and its current
//! otherwise. Over-voltage and over-current protection switch an output off and stay tripped until they are cleared. The supply
//! stands as somebody left it: outputs 2 and 3 at 24 V and switched on.
//!
//! Ratings, reset state and the delay of the over-current protection are general knowledge of the series and were not compared
//! with its manual.

mod output;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::physics::noise::{Noise, SeedAddress};
use crate::scpi::{Error, Port, Unit, code, matches, nr3};
use crate::unit::InstrumentsSettings;
use output::{Output, Ratings};

/// What it says it is: no maker's instrument.
const IDENTITY: &str = "Simulated,E36313A-SIM,SIM0003,1.0";

/// Ratings of the outputs.
const RATINGS: [Ratings; 3] = [
    Ratings { voltage_v: 6.0, current_a: 10.0 },
    Ratings { voltage_v: 25.0, current_a: 2.0 },
    Ratings { voltage_v: 25.0, current_a: 2.0 },
];
/// Words of `APPLy` and `INSTrument` for the outputs.
const NAMES: [[&str; 2]; 3] = [["P6V", "CH1"], ["P25V", "CH2"], ["N25V", "CH3"]];

/// Noise of a read-back voltage, and of a current: a tenth of the accuracy that such instruments have.
const VOLTAGE_NOISE_V: f64 = 0.5e-3;
const CURRENT_NOISE_A: f64 = 0.2e-3;

/// The instrument.
#[derive(Clone, Debug)]
pub struct Supply {
    port: Port,
    outputs: [Output; 3],
    /// Output that commands without a channel list mean, from 0.
    selected: usize,
    voltage_noise: Noise,
    current_noise: Noise,
    measurements_count: u64,
}

impl Supply {
    /// As somebody left it: output 1 off, outputs 2 and 3 on at 24 V and 2 A.
    pub fn new(settings: &InstrumentsSettings, address: &SeedAddress) -> Self {
        let load_ohm = settings.dc_supply_load_ohm;
        let mut outputs = RATINGS.map(|ratings| Output::new(ratings, load_ohm));
        for output in &mut outputs[1..] {
            output.leave_on(24.0, 2.0);
        }
        Self {
            port: Port::new(IDENTITY),
            outputs,
            selected: 0,
            voltage_noise: Noise::new(address, "dc-supply.voltage", VOLTAGE_NOISE_V),
            current_noise: Noise::new(address, "dc-supply.current", CURRENT_NOISE_A),
            measurements_count: 0,
        }
    }

    /// The load of an output (from 0) has this resistance from now on.
    pub fn load(&mut self, now: Duration, output: usize, load_ohm: f64) {
        if let Some(output) = self.outputs.get_mut(output) {
            output.settle(now);
            output.set_load_ohm(load_ohm);
        }
    }

    /// Bytes from the host.
    pub fn receive(&mut self, now: Duration, bytes: &[u8]) {
        self.port.receive(bytes);
        while let Some(unit) = self.port.next_unit(now) {
            self.outputs.iter_mut().for_each(|output| output.settle(now));
            if let Err(error) = self.execute(&unit) {
                self.port.raise(error);
            }
        }
    }

    /// What has been answered by now; how much.
    pub fn take(&mut self, now: Duration, into: &mut [u8]) -> usize {
        self.port.take(now, into)
    }

    fn execute(&mut self, unit: &Unit) -> Result<(), Error> {
        if self.port.common(unit, false) {
            return Ok(());
        }
        let is = |pattern: &str| matches(pattern, &unit.header).is_some();
        if unit.query {
            return self.answer(unit);
        }
        match () {
            () if unit.header == "*RST" => {
                self.outputs.iter_mut().for_each(Output::reset);
                self.selected = 0;
                Ok(())
            }
            () if is("APPLy") => self.apply(unit),
            () if is("INSTrument") || is("INSTrument:SELect") => {
                self.selected = named(unit.only()?)?;
                Ok(())
            }
            () if is("INSTrument:NSELect") => {
                self.selected = unit.number([1.0, 3.0])? as usize - 1;
                Ok(())
            }
            () if is("OUTPut") || is("OUTPut:STATe") => self.set(unit, |output, word| {
                output.switch(boolean(word)?);
                Ok(())
            }),
            () if is("OUTPut:PROTection:CLEar") => self.clear(unit, Output::clear_both),
            () if is_voltage(&unit.header, ":PROTection:CLEar") => {
                self.clear(unit, Output::clear_over_voltage)
            }
            () if is_current(&unit.header, ":PROTection:CLEar") => {
                self.clear(unit, Output::clear_over_current)
            }
            () => self.set_point(unit),
        }
    }

    fn set_point(&mut self, unit: &Unit) -> Result<(), Error> {
        let header = unit.header.as_str();
        match () {
            () if is_level(header, is_voltage) => self.set(unit, Output::set_voltage),
            () if is_level(header, is_current) => self.set(unit, Output::set_current),
            () if is_voltage(header, ":PROTection") || is_voltage(header, ":PROTection:LEVel") => {
                self.set(unit, Output::set_over_voltage)
            }
            () if is_voltage(header, ":PROTection:STATe") => self.set(unit, |output, word| {
                output.watches_voltage = boolean(word)?;
                Ok(())
            }),
            () if is_current(header, ":PROTection:STATe") => self.set(unit, |output, word| {
                output.watches_current = boolean(word)?;
                Ok(())
            }),
            () => Err(code::UNDEFINED_HEADER),
        }
    }

    /// Carries out a command with one value on the outputs of its channel list.
    fn set(&mut self, unit: &Unit, obey: fn(&mut Output, &str) -> Result<(), Error>) -> Result<(), Error> {
        let (value, list) = match &unit.parameters[..] {
            [] => return Err(code::MISSING_PARAMETER),
            [value] => (value, None),
            [value, list] => (value, Some(list.as_str())),
            _ => return Err(code::PARAMETER_NOT_ALLOWED),
        };
        for channel in self.channels(list)? {
            obey(&mut self.outputs[channel], value)?;
        }
        Ok(())
    }

    /// Carries out a command without a value on the outputs of its channel list.
    fn clear(&mut self, unit: &Unit, obey: fn(&mut Output)) -> Result<(), Error> {
        for channel in self.listed(unit)? {
            obey(&mut self.outputs[channel]);
        }
        Ok(())
    }

    /// `APPLy CH2,24,2`: voltage, then current, each of which may be left out.
    fn apply(&mut self, unit: &Unit) -> Result<(), Error> {
        let [name, values @ ..] = &unit.parameters[..] else { return Err(code::MISSING_PARAMETER) };
        let output = &mut self.outputs[named(name)?];
        match values {
            [] => Ok(()),
            [voltage] => output.set_voltage(voltage),
            [voltage, current] => {
                output.set_voltage(voltage)?;
                output.set_current(current)
            }
            _ => Err(code::PARAMETER_NOT_ALLOWED),
        }
    }

    /// Outputs of the only parameter, a channel list; the selected one without it.
    fn listed(&self, unit: &Unit) -> Result<Vec<usize>, Error> {
        match &unit.parameters[..] {
            [] => self.channels(None),
            [list] => self.channels(Some(list)),
            _ => Err(code::PARAMETER_NOT_ALLOWED),
        }
    }

    /// Outputs of a channel list such as `(@1,3)` or `(@1:3)`, from 0.
    fn channels(&self, list: Option<&str>) -> Result<Vec<usize>, Error> {
        let Some(list) = list else { return Ok(vec![self.selected]) };
        let inside = list.strip_prefix("(@").and_then(|rest| rest.strip_suffix(')'));
        let inside = inside.ok_or(code::SYNTAX)?;
        let place = |text: &str| match text.trim().parse::<usize>() {
            Ok(number @ 1..=3) => Ok(number - 1),
            Ok(_) => Err(code::OUT_OF_RANGE),
            Err(_) => Err(code::SYNTAX),
        };
        let mut all = Vec::new();
        for part in inside.split(',') {
            match part.split_once(':') {
                None => all.push(place(part)?),
                Some((first, last)) => all.extend(place(first)?..=place(last)?),
            }
        }
        Ok(all)
    }

    fn answer(&mut self, unit: &Unit) -> Result<(), Error> {
        let header = unit.header.as_str();
        let is = |pattern: &str| matches(pattern, header);
        let text = match () {
            () if is("INSTrument").or(is("INSTrument:SELect")).is_some() => {
                NAMES[self.selected][1].to_owned()
            }
            () if is("INSTrument:NSELect").is_some() => format!("{:+}", self.selected + 1),
            () if is("APPLy").is_some() => {
                let output = &self.outputs[named(unit.only()?)?];
                format!("\"{:.6},{:.6}\"", output.voltage_v, output.current_limit_a)
            }
            () => match is("STATus:QUEStionable:INSTrument:ISUMmary#:CONDition").as_deref() {
                Some([channel @ 1..=3]) => format!("{:+}", self.outputs[*channel as usize - 1].condition()),
                Some(_) => return Err(code::UNDEFINED_HEADER),
                None => self.of_each(unit)?,
            },
        };
        self.port.respond(text.as_bytes());
        Ok(())
    }

    /// What a query with a channel list is answered with, the outputs joined by commas.
    fn of_each(&mut self, unit: &Unit) -> Result<String, Error> {
        let what = Asked::of(&unit.header).ok_or(code::UNDEFINED_HEADER)?;
        let mut all = Vec::new();
        for channel in self.listed(unit)? {
            let output = &self.outputs[channel];
            let flag = |is_set: bool| u8::from(is_set).to_string();
            all.push(match what {
                Asked::MeasuredVoltage => {
                    self.measurements_count += 1;
                    nr3(output.volts() + self.voltage_noise.at(self.measurements_count), 8)
                }
                Asked::MeasuredCurrent => {
                    self.measurements_count += 1;
                    nr3(output.amperes() + self.current_noise.at(self.measurements_count), 8)
                }
                Asked::Voltage => nr3(output.voltage_v, 8),
                Asked::CurrentLimit => nr3(output.current_limit_a, 8),
                Asked::OverVoltage => nr3(output.over_voltage_v, 8),
                Asked::IsOn => flag(output.is_on()),
                Asked::WatchesVoltage => flag(output.watches_voltage),
                Asked::WatchesCurrent => flag(output.watches_current),
                Asked::OverVoltageTripped => flag(output.over_voltage_tripped()),
                Asked::OverCurrentTripped => flag(output.over_current_tripped()),
            });
        }
        Ok(all.join(","))
    }
}

/// What a query about outputs asks for.
#[derive(Clone, Copy, Debug)]
enum Asked {
    MeasuredVoltage,
    MeasuredCurrent,
    Voltage,
    CurrentLimit,
    OverVoltage,
    IsOn,
    WatchesVoltage,
    WatchesCurrent,
    OverVoltageTripped,
    OverCurrentTripped,
}

impl Asked {
    fn of(header: &str) -> Option<Self> {
        let is = |pattern: &str| matches(pattern, header).is_some();
        Some(match () {
            () if is("MEASure:VOLTage") || is("MEASure:VOLTage:DC") => Self::MeasuredVoltage,
            () if is("MEASure:CURRent") || is("MEASure:CURRent:DC") => Self::MeasuredCurrent,
            () if is("OUTPut") || is("OUTPut:STATe") => Self::IsOn,
            () if is_level(header, is_voltage) => Self::Voltage,
            () if is_level(header, is_current) => Self::CurrentLimit,
            () if is_voltage(header, ":PROTection") || is_voltage(header, ":PROTection:LEVel") => {
                Self::OverVoltage
            }
            () if is_voltage(header, ":PROTection:STATe") => Self::WatchesVoltage,
            () if is_current(header, ":PROTection:STATe") => Self::WatchesCurrent,
            () if is_voltage(header, ":PROTection:TRIPped") => Self::OverVoltageTripped,
            () if is_current(header, ":PROTection:TRIPped") => Self::OverCurrentTripped,
            () => return None,
        })
    }
}

/// Whether a header is `[SOURce:]VOLTage` with this behind it.
fn is_voltage(header: &str, rest: &str) -> bool {
    is_source("VOLTage", header, rest)
}

/// Whether a header is `[SOURce:]CURRent` with this behind it.
fn is_current(header: &str, rest: &str) -> bool {
    is_source("CURRent", header, rest)
}

fn is_source(node: &str, header: &str, rest: &str) -> bool {
    ["", "SOURce:"].iter().any(|source| matches(&format!("{source}{node}{rest}"), header).is_some())
}

/// Whether a header is a set point, `VOLTage[:LEVel][:IMMediate][:AMPLitude]`.
fn is_level(header: &str, is_of: fn(&str, &str) -> bool) -> bool {
    ["", ":LEVel", ":LEVel:IMMediate", ":LEVel:IMMediate:AMPLitude"].iter().any(|rest| is_of(header, rest))
}

/// Output of this name, from 0.
fn named(word: &str) -> Result<usize, Error> {
    NAMES.iter().position(|names| names.contains(&word)).ok_or(code::ILLEGAL_PARAMETER)
}

fn boolean(word: &str) -> Result<bool, Error> {
    match word {
        "0" | "OFF" => Ok(false),
        "1" | "ON" => Ok(true),
        _ => Err(code::ILLEGAL_PARAMETER),
    }
}
