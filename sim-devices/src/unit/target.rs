//! What the director points at.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// What the director points at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetSettings {}

pub(super) const TARGET: &[Parameter<UnitSettings>] = &[];
