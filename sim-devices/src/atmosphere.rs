//! Turbulence: tip-tilt of the line of sight.
//!
//! Variance of the tilt per axis over a circular aperture D, Kolmogorov turbulence, Zernike tilt:
//! `σ² = 0.182·(D/r0)^{5/3}·(λ/D)²` (half of the two-axis 0.364 of Tyler, "Bandwidth considerations for tracking
//! through turbulence", J. Opt. Soc. Am. A 11, 358, 1994), r0 of a spherical wave over a uniform path, erratum E10.
//! Its one-sided PSD rises as f^(−2/3) towards low frequencies and falls as f^(−11/3) above a knee at 0.3·v/D
//! (Tyler 1994; Hardy, Adaptive Optics for Astronomical Telescopes, 1998, ch. 3). With an aperture of 0.75 m the knee
//! is at 8 Hz for 20 m/s and at 10 Hz for 25 m/s, the study's two cases, and Tyler's tracking frequency of the first
//! is 7.9 Hz. Greenwood's own formula would give 30 Hz on 85 m.

mod shaping;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::physics::noise::{Noise, SeedAddress};
use crate::unit::AtmosphereSettings;

use shaping::Shaping;

/// Rate at which the tilt is drawn; it stands still in between.
pub const TICK_RATE_HZ: f64 = 2000.0;
/// Knee frequency in units of v/D.
const KNEE: f64 = 0.3;

/// Fried parameter of a spherical wave over a uniform path (E10): `0.185·[λ²/(3/8·Cn²·L)]^{3/5}`, m.
pub fn fried_parameter_m(settings: &AtmosphereSettings) -> f64 {
    let integral = 0.375 * settings.strength_m_pow * settings.path_m;
    0.185 * (settings.wavelength_m.powi(2) / integral).powf(0.6)
}

/// Variance of the tilt, each axis, rad².
pub fn tilt_variance_rad2(settings: &AtmosphereSettings) -> f64 {
    if settings.strength_m_pow == 0.0 {
        return 0.0;
    }
    let diffraction = settings.wavelength_m / settings.aperture_m;
    0.182 * (settings.aperture_m / fried_parameter_m(settings)).powf(5.0 / 3.0) * diffraction * diffraction
}

/// Frequency at which the two branches meet, `0.3·v/D`.
pub fn knee_hz(settings: &AtmosphereSettings) -> f64 {
    KNEE * settings.wind_speed_m_per_s / settings.aperture_m
}

/// One-sided PSD of the tilt of each axis, rad²/Hz (E10): `A·x^{−2/3}/(1 + x³)`, `x = f/knee`; its integral over all
/// frequencies is the variance, as `∫x^{−2/3}/(1 + x³) = (π/3)/sin(π/9)`.
pub fn tilt_psd_rad2_per_hz(settings: &AtmosphereSettings, frequency_hz: f64) -> f64 {
    use std::f64::consts::PI;
    let knee = knee_hz(settings);
    let integral = (PI / 3.0) / (PI / 9.0).sin();
    tilt_variance_rad2(settings) / (integral * knee) * branches(frequency_hz / knee)
}

/// Shape of the PSD over frequency in units of the knee.
fn branches(x: f64) -> f64 {
    x.cbrt().powi(-2) / (1.0 + x.powi(3))
}

/// Tip and tilt as they happen.
#[derive(Clone, Debug)]
pub struct TipTilt {
    axes: [Axis; 2],
    /// Tick of the values that stand.
    tick: u64,
}

#[derive(Clone, Debug)]
struct Axis {
    shaping: Shaping,
    noise: Noise,
    value_rad: f64,
}

impl TipTilt {
    /// Turbulence that has been blowing for ever.
    pub fn new(settings: &AtmosphereSettings, address: &SeedAddress) -> Self {
        let axis = |name: &str| Axis::new(settings, address, name);
        Self { axes: [axis("atmosphere.cross-elevation"), axis("atmosphere.elevation")], tick: 0 }
    }

    /// Tilt across the elevation axis and in elevation at a time, which must not go back.
    pub fn at(&mut self, now: Duration) -> [f64; 2] {
        // A hair more than the product, so that a time on a tick belongs to it.
        let tick = (now.as_secs_f64() * TICK_RATE_HZ + 1e-6) as u64;
        while self.tick < tick {
            self.tick += 1;
            self.axes.iter_mut().for_each(|axis| axis.step(self.tick));
        }
        [self.axes[0].value_rad, self.axes[1].value_rad]
    }
}

impl Axis {
    fn new(settings: &AtmosphereSettings, address: &SeedAddress, name: &str) -> Self {
        let deviation = if settings.strength_m_pow == 0.0 { 0.0 } else { 1.0 };
        let mut shaping = Shaping::new(knee_hz(settings), TICK_RATE_HZ, |frequency_hz| {
            tilt_psd_rad2_per_hz(settings, frequency_hz)
        });
        let mut start = Noise::new(address, &format!("{name}.start"), deviation);
        let value_rad = shaping.settle(|index| start.at(index));
        Self { shaping, noise: Noise::new(address, name, deviation), value_rad }
    }

    fn step(&mut self, tick: u64) {
        self.value_rad = self.shaping.step(self.noise.at(tick));
    }
}
