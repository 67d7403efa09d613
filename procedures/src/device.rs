//! What procedures know of a rig's devices: the roles that they ask for, never a make or a name, and the tasks that they give
//! to instruments.

use serde::{Deserialize, Serialize};

/// What a device is to procedures. A rig has at most one device of each role.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceRole {
    /// Gyros and accelerometers on the frame that carries the payload.
    InertialUnit,
    /// Fast steering mirror with its strain gauges.
    Mirror,
    /// Tracker of the wide camera, which steers the axes.
    CoarseTracker,
    /// Tracker of the narrow camera behind the mirror.
    FineTracker,
    /// External reference of the axes' angles.
    AngleReference,
    /// Current clamps on the leads of the DC link.
    LinkClamps,
    /// Force gauge on a lever arm.
    ForceGauge,
    /// Impedance analyser at the terminals of the mirror.
    ImpedanceAnalyser,
    /// Oscilloscope with current probes on the motors.
    Oscilloscope,
}

impl DeviceRole {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::InertialUnit,
        Self::Mirror,
        Self::CoarseTracker,
        Self::FineTracker,
        Self::AngleReference,
        Self::LinkClamps,
        Self::ForceGauge,
        Self::ImpedanceAnalyser,
        Self::Oscilloscope,
    ];

    /// The role in words after `no`.
    pub fn bare(self) -> &'static str {
        let noun = self.noun();
        noun.strip_prefix("an ").or(noun.strip_prefix("a ")).unwrap_or(noun)
    }

    /// The role in words, with its article where it has one.
    pub const fn noun(self) -> &'static str {
        match self {
            Self::InertialUnit => "an inertial unit",
            Self::Mirror => "a steering mirror",
            Self::CoarseTracker => "a coarse tracker",
            Self::FineTracker => "a fine tracker",
            Self::AngleReference => "an external angle reference",
            Self::LinkClamps => "current clamps on the DC link",
            Self::ForceGauge => "a force gauge",
            Self::ImpedanceAnalyser => "an impedance analyser",
            Self::Oscilloscope => "an oscilloscope",
        }
    }
}

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
