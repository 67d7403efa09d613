#![no_std]
//! Production control laws of the director: no allocation, no I/O, no clock. Each law is a struct that is updated once
//! a tick; the sample period is given once, when it is made. Angles in rad, torques in N·m, times in s.
//!
//! The gains in use stand in `params/director.toml`; [`parameter::PARAMETERS`] says what may stand there.

#[cfg(test)]
extern crate std;

pub mod filters;
pub mod parameter;
pub mod position;
pub mod profile;
pub mod velocity;

/// Gains of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisGains {
    /// Proportional gain of the velocity loop.
    pub velocity_kp_nm_s_per_rad: f64,
    /// Integral gain of the velocity loop.
    pub velocity_ki_nm_per_rad: f64,
    /// Gain of the position loop around the velocity loop.
    pub position_gain_per_s: f64,
}

/// Gains of both axes, as in `params/director.toml`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectorGains {
    /// Azimuth.
    pub az: AxisGains,
    /// Elevation.
    pub el: AxisGains,
}

/// The value, or 0 for one that is not finite: a broken sample must not stay in the state of a law.
fn finite_or_zero(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
