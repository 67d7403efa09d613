//! An impedance analyser at the terminals of the mirror (Keysight E4990A command set).
//!
//! Its relay connects one axis, whose impedance is that of the equivalent circuit of the unit's mirror. The level is that of
//! the open source, which has 25 Ω. A sweep takes its time, `*OPC?` is answered at its end; with no axis connected, or
//! both, the answer is the mark of an overload.

mod state;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::mirror::Mirror;
use crate::physics::noise::{Noise, SeedAddress};
use crate::physics::piezo::Circuit;
use crate::scpi::{Error, Port, Unit, code, matches, nr3};
use crate::unit::InstrumentsSettings;
use state::{Parameter, State};

/// What it says it is: no maker's instrument.
const IDENTITY: &str = "Simulated,E4990A-SIM,SIM0001,1.0";
/// Resistance of the source.
const SOURCE_OHM: f64 = 25.0;
/// Mark of an overload.
const OVERLOAD: f64 = 9.9e37;
/// Bit of the operation condition register that is 1 while it measures.
const MEASURING: u32 = 1 << 4;
/// Values that one sweep may draw.
const DRAWS_PER_SWEEP: u64 = 4096;

/// A sweep that has begun.
#[derive(Clone, Debug)]
struct Sweep {
    done: Duration,
    frequencies_hz: Vec<f64>,
    /// Resistance, reactance, level, current of each point.
    values: Vec<[f64; 4]>,
}

/// The instrument.
#[derive(Clone, Debug)]
pub struct Analyser {
    port: Port,
    circuits: [Circuit; 2],
    noise: Noise,
    point_time_s: f64,
    periods_count: f64,
    state: State,
    /// Bits of handler port A: the relay of azimuth, that of elevation.
    relay: u8,
    sweep: Option<Sweep>,
    sweeps_count: u64,
}

impl Analyser {
    /// Just powered, no axis connected.
    pub fn new(settings: &InstrumentsSettings, address: &SeedAddress, mirror: &Mirror) -> Self {
        Self {
            port: Port::new(IDENTITY),
            circuits: [0, 1].map(|axis| mirror.circuit(axis)),
            noise: Noise::new(address, "analyser", settings.analyser_noise_ratio),
            point_time_s: settings.analyser_point_time_s,
            periods_count: settings.analyser_periods_count,
            state: State::default(),
            relay: 0,
            sweep: None,
            sweeps_count: 0,
        }
    }

    /// Bytes from the host.
    pub fn receive(&mut self, now: Duration, bytes: &[u8]) {
        self.settle(now);
        self.port.receive(bytes);
        while let Some(unit) = self.port.next_unit(now) {
            if let Err(error) = self.execute(&unit, now) {
                self.port.raise(error);
            }
        }
    }

    /// What has been answered by now; how much.
    pub fn take(&mut self, now: Duration, into: &mut [u8]) -> usize {
        self.settle(now);
        self.port.take(now, into)
    }

    fn sweeps(&self, now: Duration) -> bool {
        self.sweep.as_ref().is_some_and(|sweep| sweep.done > now)
    }

    fn settle(&mut self, now: Duration) {
        if !self.sweeps(now) {
            self.port.complete(now);
        }
    }

    fn execute(&mut self, unit: &Unit, now: Duration) -> Result<(), Error> {
        let busy = self.sweeps(now);
        if self.port.common(unit, busy) {
            return Ok(());
        }
        let is = |pattern: &str| matches(pattern, &unit.header);
        if unit.query {
            return match () {
                () if is("CALCulate#:DATA:FDATa").is_some() => self.answer_trace(now),
                () if is("SENSe#:FREQuency:DATA").is_some() => self.answer_frequencies(now),
                () if is("CONTrol:HANDler:A").is_some() => self.answer(&format!("{:+}", self.relay)),
                () if is("STATus:OPERation:CONDition").is_some() => {
                    self.answer(&format!("{:+}", if busy { MEASURING } else { 0 }))
                }
                () => self.state.answer(unit).and_then(|text| self.answer(&text)),
            };
        }
        match () {
            () if unit.header == "*RST" || is("SYSTem:PRESet").is_some() => {
                (self.state, self.sweep) = (State::default(), None);
            }
            () if is("ABORt").is_some() => self.sweep = None,
            () if is("CONTrol:HANDler:A").is_some() => {
                self.relay = unit.number([0.0, 255.0])? as u8;
                self.sweep = None;
            }
            () if is("TRIGger:SINGle").is_some() => return self.trigger(now),
            () => {
                // What is set anew makes the sweep before meaningless, unless it is only looked at.
                if self.state.set(unit)? {
                    self.sweep = None;
                }
            }
        }
        Ok(())
    }

    fn answer(&mut self, text: &str) -> Result<(), Error> {
        self.port.respond(text.as_bytes());
        Ok(())
    }

    fn trigger(&mut self, now: Duration) -> Result<(), Error> {
        if !self.state.takes_bus_triggers() {
            return Err(code::TRIGGER_IGNORED);
        }
        if self.sweeps(now) {
            return Err(code::INIT_IGNORED);
        }
        let frequencies_hz = self.state.frequencies_hz()?;
        let first = self.sweeps_count * DRAWS_PER_SWEEP;
        self.sweeps_count += 1;
        let values = (first..).zip(&frequencies_hz).map(|(draw, hz)| self.measured(draw, *hz)).collect();
        let lasts_s: f64 = frequencies_hz.iter().map(|hz| self.point_time_s + self.periods_count / hz).sum();
        let done = now + Duration::from_secs_f64(lasts_s);
        self.sweep = Some(Sweep { done, frequencies_hz, values });
        Ok(())
    }

    /// Resistance, reactance, voltage and current at the terminals; the noise is relative to the impedance.
    fn measured(&mut self, draw: u64, frequency_hz: f64) -> [f64; 4] {
        let level_v = self.state.level_v_rms;
        let circuit = match self.relay {
            1 => &self.circuits[0],
            2 => &self.circuits[1],
            _ => return [OVERLOAD, OVERLOAD, level_v, 0.0],
        };
        let z = circuit.impedance(frequency_hz);
        let [real, imaginary] = self.noise.pair_at(draw);
        let current_a = level_v / (z.resistance_ohm + SOURCE_OHM).hypot(z.reactance_ohm);
        [
            z.resistance_ohm * (1.0 + real) - z.reactance_ohm * imaginary,
            z.reactance_ohm * (1.0 + real) + z.resistance_ohm * imaginary,
            current_a * z.magnitude_ohm(),
            current_a,
        ]
    }

    fn swept(&self, now: Duration) -> Result<&Sweep, Error> {
        self.sweep.as_ref().filter(|sweep| sweep.done <= now).ok_or(code::STALE)
    }

    fn answer_trace(&mut self, now: Duration) -> Result<(), Error> {
        let which = match self.state.selected()? {
            Parameter::Resistance => 0,
            Parameter::Reactance => 1,
            Parameter::Level => 2,
            Parameter::Current => 3,
        };
        let values =
            self.swept(now)?.values.iter().map(|point| format!("{},{}", nr3(point[which], 11), nr3(0.0, 11)));
        let answer = values.collect::<Vec<_>>().join(",");
        self.port.respond(answer.as_bytes());
        Ok(())
    }

    fn answer_frequencies(&mut self, now: Duration) -> Result<(), Error> {
        let values = self.swept(now)?.frequencies_hz.iter().map(|hz| nr3(*hz, 11));
        let answer = values.collect::<Vec<_>>().join(",");
        self.port.respond(answer.as_bytes());
        Ok(())
    }
}
