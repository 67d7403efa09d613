//! Coarse and fine video tracker.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// Coarse and fine video tracker.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackersSettings {}

pub(super) const TRACKER: &[Parameter<UnitSettings>] = &[];
