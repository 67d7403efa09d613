//! What a device of a rig is to procedures: they ask for a role, never for a make or a name.

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
