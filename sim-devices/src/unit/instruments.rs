//! Instruments on the bench: external angle reference, force gauge.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// Instruments on the bench: external angle reference, force gauge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstrumentsSettings {}

pub(super) const INSTRUMENTS: &[Parameter<UnitSettings>] = &[];
