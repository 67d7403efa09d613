//! DC link and power supply of both drives.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// DC link and power supply of both drives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SupplySettings {}

pub(super) const SUPPLY: &[Parameter<UnitSettings>] = &[];
