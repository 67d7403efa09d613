//! The emergency stop where it is wired to an input of a digital terminal.
//!
//! The input is on while the chain is closed. It counts as pressed where it is off, which a broken wire or a terminal without
//! field supply looks like, where the terminal has no such input, and before it was sampled for the first time. A bad exchange
//! leaves the last good sample, as it does with the drives: a terminal that is lost makes the working counter wrong, and that trips
//! by itself after three exchanges.

use std::time::Duration;

use drivers::device::DeviceError;

use super::wires::Ports;
use crate::model::rig::Rig;

/// An input of a digital terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct EmergencyStop {
    input: usize,
    is_open: bool,
}

impl EmergencyStop {
    /// The emergency stop of a rig; `None` where it is not wired to a terminal.
    ///
    /// # Errors
    /// When the site has no such terminal.
    pub(super) fn of(rig: &Rig, ports: &mut Ports) -> Result<Option<Self>, DeviceError> {
        let Some(wired) = rig.emergency_stop_input else { return Ok(None) };
        if ports.emergency_stop().is_none() {
            let reason = format!("no digital terminal at station {} on this site", wired.station);
            return Err(DeviceError::Bus { device: "emergency stop".to_owned(), reason });
        }
        Ok(Some(Self { input: usize::from(wired.input), is_open: true }))
    }

    /// Refuses a terminal without this input, once the bus is mapped and its inputs are known.
    ///
    /// # Errors
    /// That there is no such input.
    pub(super) fn check(self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        ports.emergency_stop().map_or(Ok(()), |terminal| terminal.is_on(now, self.input).map(|_| ()))
    }

    /// Takes the newest sample.
    pub(super) fn poll(&mut self, ports: &mut Ports, now: Duration) {
        let sample = ports.emergency_stop().map(|terminal| terminal.is_on(now, self.input));
        self.is_open = !matches!(sample, Some(Ok(Some(true))));
    }

    /// Whether the chain is open.
    pub(super) fn is_open(self) -> bool {
        self.is_open
    }
}
