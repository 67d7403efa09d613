//! Settings of the devices on the gimbal and of the instruments that a loop reads.

use drivers::analyser::AnalyserSettings;
use drivers::kvh::KvhSettings;
use drivers::mirror::MirrorSettings;
use drivers::scope::ScopeSettings;
use drivers::tracker::TrackerSettings;

/// Devices on the gimbal and instruments on the bench; those that a rig lacks are `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PayloadSettings {
    /// Inertial measurement unit.
    pub imu: Option<KvhSettings>,
    /// Fast steering mirror.
    pub mirror: Option<MirrorSettings>,
    /// Coarse tracker.
    pub coarse: Option<TrackerSettings>,
    /// Fine tracker.
    pub fine: Option<TrackerSettings>,
    /// Analog channels beside the mirror's own; there with the mirror.
    pub bystanders: Option<BystanderSettings>,
    /// Current clamps on the DC link, on the analog card.
    pub clamps: Option<ClampSettings>,
    /// Force gauge on the lever arm, on the analog card.
    pub force: Option<ForceSettings>,
    /// Impedance analyser.
    pub analyser: Option<AnalyserSettings>,
    /// Oscilloscope.
    pub scope: Option<ScopeSettings>,
    /// Frames per second of the coarse and the fine tracker; 0 where there is none.
    pub frame_rates_hz: [f64; 2],
    /// External angle reference.
    pub reference: Option<ReferenceSettings>,
}

impl PayloadSettings {
    /// Tables of the rig file behind which an instrument with a certificate stands: the roles of `[[instrument]]`.
    pub fn measuring(&self) -> Vec<&'static str> {
        [
            ("reference", self.reference.is_some()),
            ("analyser", self.analyser.is_some()),
            ("scope", self.scope.is_some()),
            ("supply", self.clamps.is_some()),
        ]
        .into_iter()
        .filter_map(|(role, there)| there.then_some(role))
        .collect()
    }
}

/// Where the signals hang on the analog card.
#[derive(Clone, Debug, PartialEq)]
pub struct BystanderSettings {
    /// Tilt of the mirror per volt of the autocollimator.
    pub reference_scale_rad_per_v: f64,
    /// Inputs of the autocollimator: azimuth, elevation.
    pub reference_inputs: [usize; 2],
    /// Output to the oscilloscope.
    pub sync_output: usize,
    /// Output that is looped back.
    pub echo_output: usize,
    /// Input that it is looped to.
    pub echo_input: usize,
}

/// Where the clamps hang on the analog card.
#[derive(Clone, Debug, PartialEq)]
pub struct ClampSettings {
    /// Inputs: supply, shunt.
    pub inputs: [usize; 2],
    /// Current per volt.
    pub scale_a_per_v: f64,
}

/// Where the gauge hangs on the analog card.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceSettings {
    /// Input.
    pub input: usize,
    /// Force per volt.
    pub scale_n_per_v: f64,
}

/// Where the autocollimators hang on the analog card.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceSettings {
    /// Angle per volt.
    pub scale_rad_per_v: f64,
    /// Inputs: azimuth, elevation.
    pub inputs: [usize; 2],
}
