//! Inertial measurement unit on the elevation frame.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// Inertial measurement unit on the elevation frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ImuSettings {
    /// Age of rates when the host has them.
    pub delay_s: f64,
}

impl Default for ImuSettings {
    fn default() -> Self {
        Self { delay_s: 1.25e-3 }
    }
}

pub(super) const IMU: &[Parameter<UnitSettings>] = &[];
