//! What gyros read while the axes stand still on the turning Earth.

use crate::{EarthSettings, finite_or_zero};

/// Rate of the Earth against the stars (IERS Conventions 2010, table 1.2).
pub const EARTH_RATE_RAD_PER_S: f64 = 7.292_115e-5;

/// Rates that gyro-derived axis rates show for axes at rest on a level base.
///
/// The azimuth axis points up and azimuth grows counter-clockwise seen from above, as the 45° mount counts it, so the
/// compass heading of the line of sight is `heading of azimuth zero − azimuth`.
/// - Azimuth: Ω sin φ; 46.9 µrad/s at 40°.
/// - Elevation: −Ω cos φ sin(heading). Towards east the horizon sinks among the stars.
///
/// A velocity loop on gyros nulls these with the axis, i.e. it drifts; a position loop that adds them to its command
/// (feed-forward) leaves it no error to make up for them with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarthRate {
    vertical_rad_per_s: f64,
    north_rad_per_s: f64,
    azimuth_zero_heading_rad: f64,
}

impl EarthRate {
    /// For a place and the heading of azimuth zero.
    pub fn new(settings: &EarthSettings) -> Self {
        let latitude_rad = finite_or_zero(settings.latitude_rad);
        Self {
            vertical_rad_per_s: EARTH_RATE_RAD_PER_S * libm::sin(latitude_rad),
            north_rad_per_s: EARTH_RATE_RAD_PER_S * libm::cos(latitude_rad),
            azimuth_zero_heading_rad: finite_or_zero(settings.azimuth_zero_heading_rad),
        }
    }

    /// Reading of the azimuth rate; the same wherever the axes point.
    pub fn azimuth_rad_per_s(&self) -> f64 {
        self.vertical_rad_per_s
    }

    /// Reading of the elevation rate (of growing elevation) at this azimuth.
    pub fn elevation_rad_per_s(&self, azimuth_rad: f64) -> f64 {
        let heading_rad = self.azimuth_zero_heading_rad - finite_or_zero(azimuth_rad);
        -self.north_rad_per_s * libm::sin(heading_rad)
    }

    /// Reading of the cross-elevation rate, about the image's upward axis.
    pub fn cross_elevation_rad_per_s(&self, azimuth_rad: f64, elevation_rad: f64) -> f64 {
        let heading_rad = self.azimuth_zero_heading_rad - finite_or_zero(azimuth_rad);
        let elevation_rad = finite_or_zero(elevation_rad);
        self.vertical_rad_per_s * libm::cos(elevation_rad)
            - self.north_rad_per_s * libm::sin(elevation_rad) * libm::cos(heading_rad)
    }
}

#[cfg(test)]
mod tests;
