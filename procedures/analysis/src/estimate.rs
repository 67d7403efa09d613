//! A number with its standard uncertainty.

/// A number with its standard uncertainty, degrees of freedom (may be infinite) and count of observations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value; its unit is that of the quantity it estimates.
    pub value: f64,
    /// Standard uncertainty, same unit.
    pub u: f64,
    /// Degrees of freedom of u.
    pub dof: f64,
    /// Observations that went in.
    pub n: usize,
}
