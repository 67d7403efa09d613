//! Fast steering mirror.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// Fast steering mirror.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MirrorSettings {}

pub(super) const MIRROR: &[Parameter<UnitSettings>] = &[];
