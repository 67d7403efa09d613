//! Settings of a simulated unit, SI units. Only the simulation obeys them; the bench never sees them.

use drivers::parameter::Parameter;

/// One axis of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSettings {
    /// Inertia.
    pub inertia_kg_m2: f64,
    // … Coulomb, static, Stribeck velocity/shape, viscous, bristle stiffness/damping, ageing, cogging (two harmonics:
    // order per rev, amplitude, phase), unbalance, spring stiffness and rest angle, stops, torque constant, current
    // limit, drive rated current/torque, heat sink, encoder bits, torque noise, …
}

/// A simulated unit.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitSettings {
    /// Azimuth.
    pub az: AxisSettings,
    /// Elevation.
    pub el: AxisSettings,
    /// World sub-step rate.
    pub step_rate_hz: f64,
}

impl Default for UnitSettings {
    /// The unit `nominal`.
    fn default() -> Self {
        todo!()
    }
}

/// Every setting there is; files are read, checked and documented from this table.
pub const PARAMETERS: &[Parameter<UnitSettings>] = &[];
