//! Turbulence between director and target.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// Turbulence between director and target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtmosphereSettings {}

pub(super) const ATMOSPHERE: &[Parameter<UnitSettings>] = &[];
