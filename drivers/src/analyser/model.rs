//! What models of analysers can do.

use super::Sweep;
use crate::device::DeviceError;
use crate::scpi::Identity;

/// A model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// How its name in `*IDN?` begins.
    pub name: &'static str,
    /// Lowest frequency.
    pub lowest_hz: f64,
    /// Highest frequency that every option has.
    pub highest_hz: f64,
    /// Whether it speaks the commands of this driver.
    pub spoken: bool,
}

/// Levels of the open terminals, V RMS.
pub const LEVEL_V_RMS: [f64; 2] = [0.005, 1.0];
/// Points of a sweep.
pub const POINTS: [usize; 2] = [2, 1601];

/// Known models. The 4294A begins at 40 Hz and has commands of its own: it is known in order to be refused in words.
pub const MODELS: [Model; 2] = [
    Model { name: "E4990A", lowest_hz: 20.0, highest_hz: 10e6, spoken: true },
    Model { name: "4294A", lowest_hz: 40.0, highest_hz: 110e6, spoken: false },
];

/// The model that an instrument says it is.
pub(super) fn find(device: &str, identity: &Identity) -> Result<&'static Model, DeviceError> {
    let model = MODELS.iter().find(|model| identity.model.starts_with(model.name));
    let refused = |found: String, help| {
        let expected = "an E4990A".to_owned();
        Err(DeviceError::Field { device: device.to_owned(), field: "model in *IDN?", expected, found, help })
    };
    match model {
        Some(model) if model.spoken => Ok(model),
        Some(model) => refused(
            format!("{}, which begins at {} Hz", identity.model, model.lowest_hz),
            "it cannot sweep from 20 Hz on, and its commands differ",
        ),
        None => refused(format!("`{identity}`"), "check the address of the instrument"),
    }
}

impl Model {
    /// Whether it can do a sweep.
    pub(super) fn check(&self, device: &str, sweep: &Sweep) -> Result<(), DeviceError> {
        let rms = sweep.level_v_rms();
        let refused = |setting, value, allowed: String| {
            Err(DeviceError::Setting { device: device.to_owned(), setting, value, allowed })
        };
        let frequencies = self.lowest_hz..=self.highest_hz;
        match () {
            () if !frequencies.contains(&sweep.from_hz) => refused(
                "first frequency (Hz)",
                sweep.from_hz,
                format!("{} goes from {} Hz to {} Hz", self.name, self.lowest_hz, self.highest_hz),
            ),
            () if !frequencies.contains(&sweep.to_hz) || sweep.to_hz <= sweep.from_hz => refused(
                "last frequency (Hz)",
                sweep.to_hz,
                format!("it must lie above the first one and not above {} Hz", self.highest_hz),
            ),
            () if !(LEVEL_V_RMS[0]..=LEVEL_V_RMS[1]).contains(&rms) => refused(
                "level (V RMS)",
                rms,
                format!("{} gives {} V to {} V RMS", self.name, LEVEL_V_RMS[0], LEVEL_V_RMS[1]),
            ),
            () if !(POINTS[0]..=POINTS[1]).contains(&sweep.points) => refused(
                "points",
                sweep.points as f64,
                format!("a sweep has {} to {} points", POINTS[0], POINTS[1]),
            ),
            () if sweep.axis > 1 => {
                refused("axis", sweep.axis as f64, "0 is azimuth, 1 elevation".to_owned())
            }
            () => Ok(()),
        }
    }
}

impl Sweep {
    /// Level of a sine, V RMS: peak to peak over 2√2.
    pub fn level_v_rms(&self) -> f64 {
        self.level_v_ptp / (2.0 * std::f64::consts::SQRT_2)
    }
}
