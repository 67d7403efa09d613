//! What instruments of the bench do in a segment.

use serde::{Deserialize, Serialize};

use crate::device_role::DeviceRole;

/// Words for azimuth and elevation in tasks and in names of channels: of the mirror, of the track loops, of the external angle
/// reference. They are words of these devices, whatever the axes of the rig are called.
pub const MIRROR_AXES: [&str; 2] = ["az", "el"];

/// An order to an instrument; what it measures becomes rows of a topic of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "instrument")]
pub enum Task {
    /// The impedance analyser sweeps one axis of the mirror, its amplifier disconnected; topic `/analyser`.
    Impedance {
        /// Axis of the mirror, one of [`MIRROR_AXES`].
        axis: String,
        /// Level of the sine, V peak to peak.
        level_v_ptp: f64,
        /// First frequency.
        from_hz: f64,
        /// Last frequency.
        to_hz: f64,
        /// Points, spaced logarithmically.
        points: u32,
    },
    /// The oscilloscope takes one record of the motor current of an axis, from the next change of the excitation of that
    /// axis on; topic `/scope`.
    Capture {
        /// Axis of the rig whose current probe is looked at.
        axis: String,
        /// Samples per second.
        sample_rate_hz: f64,
        /// Length of the record.
        duration_s: f64,
    },
}

impl Task {
    /// Role of the instrument that can do it.
    pub fn needs(&self) -> DeviceRole {
        match self {
            Self::Impedance { .. } => DeviceRole::ImpedanceAnalyser,
            Self::Capture { .. } => DeviceRole::Oscilloscope,
        }
    }

    /// Names of the axes that it may be about: axes of the mirror have words of their own, current probes hang on axes of the
    /// rig, `probed`.
    pub fn known_axes(&self, probed: &[Option<String>; 2]) -> [Option<String>; 2] {
        match self {
            Self::Impedance { .. } => MIRROR_AXES.map(|word| Some(word.to_owned())),
            Self::Capture { .. } => probed.clone(),
        }
    }

    /// Axis that it is about.
    pub fn axis(&self) -> &str {
        match self {
            Self::Impedance { axis, .. } | Self::Capture { axis, .. } => axis,
        }
    }
}
