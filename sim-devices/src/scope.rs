//! An oscilloscope on the bench (Keysight InfiniiVision command set).
//!
//! Channel 1 looks at the motor current of azimuth, 3 at that of elevation, each through a clamp-on probe; channel 2 at the
//! bench's synchronisation signal; nothing hangs on 4. Its sample clock is its own: between two steps of the world the
//! current is the exponential of the drive's current loop. Single records, high resolution (12 bits).

mod record;
mod state;
#[cfg(test)]
mod tests;
mod waveform;

use std::time::Duration;

use crate::physics::current_loop::Lag;
use crate::physics::noise::{Noise, SeedAddress};
use crate::scpi::{Error, Port, Unit, matches};
use crate::unit::UnitSettings;
use record::Record;
use state::State;
use waveform::Probe;

/// What it says it is: no maker's instrument.
const IDENTITY: &str = "Simulated,DSO-X-SIM,SIM0002,1.0";
/// Bit of the operation condition register that is 1 while it runs.
const RUNNING: u32 = 1 << 3;

/// The instrument.
#[derive(Clone, Debug)]
pub struct Scope {
    port: Port,
    state: State,
    record: Option<Record>,
    step_rate_hz: f64,
    current_bandwidth_hz: [f64; 2],
    probe: Probe,
    sync_v: f64,
    armed_event_read: bool,
    records_count: u64,
}

impl Scope {
    /// Just powered.
    pub fn new(unit: &UnitSettings, address: &SeedAddress) -> Self {
        let settings = &unit.instruments;
        Self {
            port: Port::new(IDENTITY),
            state: State::default(),
            record: None,
            step_rate_hz: unit.step_rate_hz,
            current_bandwidth_hz: [unit.az.current_bandwidth_hz, unit.el.current_bandwidth_hz],
            probe: Probe {
                scale: 1.0 + settings.current_probe_scale_error_ratio,
                zero_a: settings.current_probe_zero_a,
                noise: Noise::new(address, "scope.probe", settings.current_probe_noise_a),
                vertical: Noise::new(address, "scope.vertical", settings.scope_noise_ratio),
            },
            sync_v: 0.0,
            armed_event_read: false,
            records_count: 0,
        }
    }

    /// Bytes from the host.
    pub fn receive(&mut self, now: Duration, bytes: &[u8]) {
        self.port.receive(bytes);
        while let Some(unit) = self.port.next_unit(now) {
            if let Err(error) = self.execute(&unit, now) {
                self.port.raise(error);
            }
        }
    }

    /// What has been answered by now; how much.
    pub fn take(&mut self, now: Duration, into: &mut [u8]) -> usize {
        self.port.take(now, into)
    }

    /// Whether steps of the world matter now.
    #[inline]
    pub fn observes(&self) -> bool {
        self.record.as_ref().is_some_and(Record::observes)
    }

    /// What the currents of both drives do during a step of the world.
    pub fn observe(&mut self, step: u64, currents: [Lag; 2]) {
        if let Some(record) = &mut self.record {
            record.observe(step, currents);
        }
    }

    /// The synchronisation signal has this voltage from now on.
    pub fn sync(&mut self, now: Duration, volts: f64) {
        let before_v = std::mem::replace(&mut self.sync_v, volts);
        let rises = before_v < self.state.trigger_v && volts >= self.state.trigger_v;
        if let Some(record) = &mut self.record {
            record.sync(now, volts, rises && self.state.triggers_on_sync());
        }
    }

    fn execute(&mut self, unit: &Unit, now: Duration) -> Result<(), Error> {
        if self.port.common(unit, false) {
            return Ok(());
        }
        let is = |pattern: &str| matches(pattern, &unit.header).is_some();
        match unit.query {
            true if is("AER") => {
                let armed = self.record.as_ref().is_some_and(|record| record.is_armed(now));
                let event = armed && !std::mem::replace(&mut self.armed_event_read, armed);
                self.port.respond(if event { b"+1" } else { b"+0" });
            }
            true if is("OPERegister:CONDition") => {
                let runs = self.record.as_ref().is_some_and(|record| record.runs(now));
                self.port.respond(format!("{:+}", if runs { RUNNING } else { 0 }).as_bytes());
            }
            true if is("WAVeform:PREamble") => self.answer_preamble(now)?,
            true if is("WAVeform:DATA") => self.answer_data(now)?,
            true => {
                let text = self.state.answer(unit)?;
                self.port.respond(text.as_bytes());
            }
            false if is("TRIGger:FORCe") => {
                if let Some(record) = &mut self.record {
                    record.force(now);
                }
            }
            false if unit.header == "*RST" => (self.state, self.record) = (State::default(), None),
            false if is("STOP") => self.record = None,
            false if is("SINGle") => {
                let [before_s, after_s] = self.state.record_s();
                let record = Record::new(now, before_s, after_s, self.step_rate_hz, self.sync_v);
                (self.record, self.armed_event_read) = (Some(record), false);
                self.records_count += 1;
            }
            false => self.state.set(unit)?,
        }
        Ok(())
    }
}
