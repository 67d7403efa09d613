//! Turbulence between director and target.

use super::UnitSettings;
use super::setting::{Field, Setting};

/// Turbulence between director and target.
#[derive(Clone, Debug, PartialEq)]
pub struct AtmosphereSettings {
    /// Refractive index structure constant Cn2, uniform along the path; 0 is vacuum.
    pub strength_m_pow: f64,
    /// Wavelength.
    pub wavelength_m: f64,
    /// Wind across the path.
    pub wind_speed_m_per_s: f64,
    /// Length of the path through turbulence.
    pub path_m: f64,
    /// Diameter of the aperture.
    pub aperture_m: f64,
}

impl Default for AtmosphereSettings {
    /// The unit `nominal`.
    fn default() -> Self {
        Self {
            strength_m_pow: 1e-14,
            wavelength_m: 0.808 * 1e-6,
            wind_speed_m_per_s: 20.0,
            path_m: 85.0,
            aperture_m: 0.75,
        }
    }
}

pub(super) const ATMOSPHERE: &[Setting<Field<UnitSettings>>] = &[
    Setting {
        key: "atmosphere.strength",
        quantity: "turbulence-strength",
        range_si: [0.0, 1.0e-11],
        default: "1e-14 m^(-2/3)",
        doc: "Refractive index structure constant Cn2, uniform along the path; 0 is vacuum.",
        source: "study 4.4",
        field: |unit| &mut unit.atmosphere.strength_m_pow,
    },
    Setting {
        key: "atmosphere.wavelength",
        quantity: "length",
        range_si: [1.0e-7, 2.0e-5],
        default: "0.808 um",
        doc: "Wavelength.",
        source: "study 4.4",
        field: |unit| &mut unit.atmosphere.wavelength_m,
    },
    Setting {
        key: "atmosphere.wind-speed",
        quantity: "speed",
        range_si: [0.1, 200.0],
        default: "20 m/s",
        doc: "Wind across the path.",
        source: "study 4.4: 8 Hz; 25 m/s is the 10 Hz case",
        field: |unit| &mut unit.atmosphere.wind_speed_m_per_s,
    },
    Setting {
        key: "atmosphere.path",
        quantity: "length",
        range_si: [1.0, 1.0e5],
        default: "85 m",
        doc: "Length of the path through turbulence.",
        source: "study 4.3: distance of the rail",
        field: |unit| &mut unit.atmosphere.path_m,
    },
    Setting {
        key: "atmosphere.aperture",
        quantity: "length",
        range_si: [0.01, 10.0],
        default: "0.75 m",
        doc: "Diameter of the aperture.",
        source: "ours: 0.3 v/D is then the study's 8 and 10 Hz",
        field: |unit| &mut unit.atmosphere.aperture_m,
    },
];
