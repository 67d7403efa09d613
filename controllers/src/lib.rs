#![no_std]
//! Production control laws of the director: no allocation, no I/O, no clock. Each law is a struct that is updated once
//! a tick; the sample period is given once, when it is made. A loop that missed periods updates a law once for each of
//! them, so that integrals and filters follow time. Angles in rad, torques in N·m, times in s.
//!
//! From the outside in: [`envelope`] keeps a rate within limits and out of masks; [`coarse_track`] or [`position`]
//! (with [`profile`] and [`earth_rate`]) make the rate, [`off_load`] adds to it, [`keyhole`] serves cross-elevation;
//! [`velocity`] makes torque of it from the gyros ([`line_of_sight`]). [`fine_track`] moves the mirror, whose own
//! loop is [`mirror`]. [`linearise`] tells the frequency response of each.
//!
//! The gains in use stand in `params/director.toml`; [`parameter::PARAMETERS`] says what may stand there.

#[cfg(test)]
extern crate std;

pub mod camera;
pub mod coarse_track;
pub mod complex;
pub mod earth_rate;
pub mod envelope;
pub mod filters;
pub mod fine_track;
mod gains;
pub mod keyhole;
pub mod line_of_sight;
pub mod linearise;
pub mod mask;
pub mod mirror;
pub mod off_load;
pub mod parameter;
pub mod position;
pub mod profile;
pub mod target;
pub mod velocity;

pub use gains::{
    AxisGains, DirectorGains, EarthSettings, EnvelopeSettings, FineTrackGains, KeyholeSettings, MirrorGains,
    OffLoadGains, Prediction, TrackGains, TrackSettings,
};

/// The value, or 0 for one that is not finite: a broken sample must not stay in the state of a law.
fn finite_or_zero(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
