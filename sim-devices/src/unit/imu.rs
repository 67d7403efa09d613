//! Inertial measurement unit on the elevation frame.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// Inertial measurement unit on the elevation frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImuSettings {}

pub(super) const IMU: &[Parameter<UnitSettings>] = &[];
