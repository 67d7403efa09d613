//! Somebody pulls at an axis without torque, with a force gauge on a lever arm. On metal a person does; a simulated operator
//! takes it from here.

use serde::{Deserialize, Serialize};

/// A pull at the axis of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pull {
    /// Constant rate at which the axis is to be pulled, signed.
    pub rate_rad_per_s: f64,
    /// The pull begins so long after the point's power-up, at the earliest.
    pub begins_s: f64,
    /// How far.
    pub way_rad: f64,
    /// Torque that nobody pulls harder than.
    pub at_most_nm: f64,
}
