//! Impedance analyser: one logarithmic sweep of resistance and reactance (Keysight E4990A command set).
//!
//! The order of commands is the union of three independent public drivers of the E4990A; the sweep is triggered over
//! the bus and `*OPC?` is answered at its end. A relay on the analyser's handler port A connects one axis of the mirror
//! and disconnects its amplifier meanwhile.
//!
//! The level of the instrument is in V RMS of the open terminals: 1 V peak to peak of a sine is 0.35355 V. Behind its
//! own 25 Ω the terminals see less, so voltage and current are read with every point.

mod model;
mod script;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use model::{LEVEL_V_RMS, MODELS, Model, POINTS};
use script::Want;

use crate::device::{Channel, DeviceError, Width};
use crate::scpi::{Dialogue, FormatError, Identity, Instrument, LONGEST_ANSWER, Session, number};

/// What the driver must know of an analyser.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalyserSettings {
    /// Name in errors and topics.
    pub name: String,
    /// Values of handler port A that connect the mirror's axes: azimuth, elevation.
    pub relay: [u8; 2],
    /// Time allowed for an answer, beyond what a sweep takes.
    pub reply_timeout_s: f64,
}

/// A sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Axis of the mirror: 0 azimuth, 1 elevation.
    pub axis: usize,
    /// Level of the sine, V peak to peak.
    pub level_v_ptp: f64,
    /// First frequency.
    pub from_hz: f64,
    /// Last frequency.
    pub to_hz: f64,
    /// Points, spaced logarithmically.
    pub points: usize,
}

/// A measured point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Frequency, as the instrument says.
    pub frequency_hz: f64,
    /// Real part of the impedance.
    pub resistance_ohm: f64,
    /// Imaginary part.
    pub reactance_ohm: f64,
    /// Voltage at the terminals, RMS.
    pub level_v: f64,
    /// Current through them, RMS.
    pub current_a: f64,
}

/// An analyser behind its line.
#[derive(Clone, Debug)]
pub struct Analyser {
    settings: AnalyserSettings,
    dialogue: Dialogue<Want>,
    sweep: Option<Sweep>,
    points: Vec<Point>,
    values: Vec<f64>,
}

/// Longest text of a value in a list, with its comma.
const VALUE_BYTES: usize = 24;

impl Analyser {
    /// What a point adds to the log, in the order of [`Analyser::row`].
    pub const CHANNELS: &'static [Channel] = &[
        Channel { name: "frequency_hz", unit: "Hz", width: Width::F64 },
        Channel { name: "resistance_ohm", unit: "ohm", width: Width::F64 },
        Channel { name: "reactance_ohm", unit: "ohm", width: Width::F64 },
        Channel { name: "level_v", unit: "V", width: Width::F64 },
        Channel { name: "current_a", unit: "A", width: Width::F64 },
        Channel { name: "point", unit: "count", width: Width::U32 },
    ];

    /// A driver that has not spoken to its instrument yet; its first dialogue asks who it is.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] for a timeout that cannot be.
    pub fn new(settings: AnalyserSettings) -> Result<Self, DeviceError> {
        let timeout_s = settings.reply_timeout_s;
        if !(timeout_s.is_finite() && timeout_s > 0.0) {
            let allowed = "it must be finite and above 0".to_owned();
            let device = settings.name;
            let setting = "reply_timeout_s";
            return Err(DeviceError::Setting { device, setting, value: timeout_s, allowed });
        }
        let dialogue = Dialogue::new(&settings.name, Want::Identity, timeout_s);
        Ok(Self { settings, dialogue, sweep: None, points: Vec::new(), values: Vec::new() })
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &AnalyserSettings {
        &self.settings
    }

    /// Readies everything for a sweep, so that nothing is left to be reserved while it runs.
    ///
    /// # Errors
    /// A sweep that this instrument cannot do; an instrument that was not asked who it is.
    pub fn prepare(&mut self, sweep: &Sweep) -> Result<(), DeviceError> {
        let identity = self.dialogue.identity.as_ref().ok_or_else(|| DeviceError::Bus {
            device: self.settings.name.clone(),
            reason: "a sweep was requested before the instrument was identified".to_owned(),
        })?;
        model::find(&self.settings.name, identity)?.check(&self.settings.name, sweep)?;
        let script = script::of(&self.settings, sweep);
        let longest = (2 * sweep.points * VALUE_BYTES).max(LONGEST_ANSWER);
        self.dialogue.session =
            Session::new(&self.settings.name, script, longest, self.settings.reply_timeout_s);
        self.points = vec![Point::default(); sweep.points];
        self.values = Vec::with_capacity(2 * sweep.points);
        self.sweep = Some(*sweep);
        Ok(())
    }

    /// Whether a sweep is under way.
    pub fn is_running(&self) -> bool {
        self.dialogue.session.is_running()
    }

    /// Points of the sweep that is done, in order of frequency.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// A point in the order of [`Analyser::CHANNELS`].
    pub fn row(&self, point: usize) -> Option<[f64; 6]> {
        let Point { frequency_hz, resistance_ohm, reactance_ohm, level_v, current_a } =
            *self.points.get(point)?;
        Some([frequency_hz, resistance_ohm, reactance_ohm, level_v, current_a, point as f64])
    }

    /// Formatted data come in pairs, value and 0.
    fn take_trace(&mut self, put: impl Fn(&mut Point, f64)) -> Result<(), FormatError> {
        number::list(self.dialogue.session.answer(), 2 * self.points.len(), &mut self.values)?;
        for (point, pair) in self.points.iter_mut().zip(self.values.as_chunks::<2>().0) {
            put(point, pair[0]);
        }
        Ok(())
    }

    fn take_frequencies(&mut self) -> Result<(), DeviceError> {
        number::list(self.dialogue.session.answer(), self.points.len(), &mut self.values)
            .map_err(|source| self.dialogue.unusable(source))?;
        let Some(sweep) = self.sweep else { return Ok(()) };
        for (k, (point, &found_hz)) in self.points.iter_mut().zip(&self.values).enumerate() {
            let expected_hz = sweep.frequency_hz(k);
            if (found_hz / expected_hz - 1.0).abs() > FREQUENCY_TOLERANCE {
                return Err(DeviceError::Field {
                    device: self.settings.name.clone(),
                    field: "frequency of a point",
                    expected: format!("{expected_hz:.4} Hz at point {k}"),
                    found: format!("{found_hz:.4} Hz"),
                    help: "the instrument did not accept the sweep settings",
                });
            }
            point.frequency_hz = found_hz;
        }
        Ok(())
    }
}

impl Instrument for Analyser {
    type Query = Want;

    const ABORT: &'static str = script::ABORT;

    fn dialogue(&mut self) -> &mut Dialogue<Want> {
        &mut self.dialogue
    }

    fn check(&self, identity: &Identity) -> Result<(), DeviceError> {
        model::find(&self.settings.name, identity).map(|_| ())
    }

    fn take(&mut self, want: Want, _: Duration) -> Result<(), DeviceError> {
        let taken = match want {
            Want::Complete => complete(self.dialogue.session.answer()),
            Want::Identity => Ok(()),
            Want::Resistance => self.take_trace(|point, value| point.resistance_ohm = value),
            Want::Reactance => self.take_trace(|point, value| point.reactance_ohm = value),
            Want::Level => self.take_trace(|point, value| point.level_v = value),
            Want::Current => self.take_trace(|point, value| point.current_a = value),
            Want::Frequency => return self.take_frequencies(),
        };
        taken.map_err(|source| self.dialogue.unusable(source))
    }
}

/// Rounding of frequencies in the instrument: 1 mHz at 20 Hz.
const FREQUENCY_TOLERANCE: f64 = 1e-4;

impl Sweep {
    /// Frequency of a point.
    pub fn frequency_hz(&self, point: usize) -> f64 {
        let last = self.points.saturating_sub(1).max(1);
        self.from_hz * (self.to_hz / self.from_hz).powf(point as f64 / last as f64)
    }
}

fn complete(answer: &[u8]) -> Result<(), FormatError> {
    if number::number(answer, 1)? == 1.0 {
        return Ok(());
    }
    let found = String::from_utf8_lossy(answer).into_owned();
    Err(FormatError::Text { expected: "`1`, all operations complete", found })
}
