//! Instruments on the bench: external angle reference, force gauge, strain gauges, current probe.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// Instruments on the bench: external angle reference, force gauge, strain gauges, current probe.
#[derive(Clone, Debug, PartialEq)]
pub struct InstrumentsSettings {
    /// Faces of the polygon.
    pub polygon_faces_count: f64,
    /// Standard deviation of the faces' places; the calibration table holds them.
    pub polygon_face_error_rad: f64,
    /// Standard uncertainty of the calibration table.
    pub polygon_calibration_rad: f64,
    /// Largest angle off a face that is read.
    pub autocollimator_range_rad: f64,
    /// Resolution of the autocollimator.
    pub autocollimator_resolution_rad: f64,
    /// Noise of a reading.
    pub autocollimator_noise_rad: f64,
    /// Scale error of the autocollimator.
    pub autocollimator_scale_error_ratio: f64,
    /// Lever arm of the force gauge, as marked.
    pub lever_arm_m: f64,
    /// True lever arm minus the marked one.
    pub lever_arm_error_m: f64,
    /// Largest force that the gauge shows.
    pub force_range_n: f64,
    /// Scale error of the force gauge.
    pub force_scale_error_ratio: f64,
    /// Zero error of the force gauge.
    pub force_zero_n: f64,
    /// Noise of a reading of the force gauge.
    pub force_noise_n: f64,
    /// Strain per radian of the mode that the gauge follows.
    pub strain_per_rad: f64,
    /// Zero error of a strain gauge, m/m.
    pub strain_zero_ratio: f64,
    /// Noise of a strain gauge, m/m.
    pub strain_noise_ratio: f64,
    /// Scale error of the clamp-on current probe.
    pub current_probe_scale_error_ratio: f64,
    /// Zero error of the clamp-on current probe.
    pub current_probe_zero_a: f64,
    /// Noise of the clamp-on current probe.
    pub current_probe_noise_a: f64,
}

impl Default for InstrumentsSettings {
    /// The instruments of the nominal bench.
    fn default() -> Self {
        Self {
            polygon_faces_count: 36.0,
            polygon_face_error_rad: 25e-6,
            polygon_calibration_rad: 1.5e-6,
            autocollimator_range_rad: 400e-6,
            autocollimator_resolution_rad: 0.25e-6,
            autocollimator_noise_rad: 0.5e-6,
            autocollimator_scale_error_ratio: 0.002,
            lever_arm_m: 0.63,
            lever_arm_error_m: 0.001,
            force_range_n: 2000.0,
            force_scale_error_ratio: 0.003,
            force_zero_n: 0.5,
            force_noise_n: 1.0,
            strain_per_rad: 0.5,
            strain_zero_ratio: 2e-6,
            strain_noise_ratio: 0.2e-6,
            current_probe_scale_error_ratio: 0.01,
            current_probe_zero_a: 0.02,
            current_probe_noise_a: 0.02,
        }
    }
}

pub(super) const INSTRUMENTS: &[Parameter<UnitSettings>] = &[
    Parameter {
        key: "instruments.polygon-faces",
        quantity: "count",
        min_si: 1.0,
        max_si: 360.0,
        default: "36",
        doc: "Faces of the polygon.",
        source: "ours: one every 10 deg",
        set: |unit, value| unit.instruments.polygon_faces_count = value,
        get: |unit| unit.instruments.polygon_faces_count,
    },
    Parameter {
        key: "instruments.polygon-face-error",
        quantity: "angle",
        min_si: 0.0,
        max_si: 0.001,
        default: "25 urad",
        doc: "Standard deviation of the faces' places; the calibration table holds them.",
        source: "ours: 5 arcsec, a usual grade",
        set: |unit, value| unit.instruments.polygon_face_error_rad = value,
        get: |unit| unit.instruments.polygon_face_error_rad,
    },
    Parameter {
        key: "instruments.polygon-calibration",
        quantity: "angle",
        min_si: 0.0,
        max_si: 0.0001,
        default: "1.5 urad",
        doc: "Standard uncertainty of the calibration table.",
        source: "ours: 0.6 arcsec, k = 2, and its mounting",
        set: |unit, value| unit.instruments.polygon_calibration_rad = value,
        get: |unit| unit.instruments.polygon_calibration_rad,
    },
    Parameter {
        key: "instruments.autocollimator-range",
        quantity: "angle",
        min_si: 0.000001,
        max_si: 0.1,
        default: "400 urad",
        doc: "Largest angle off a face that is read.",
        source: "ours",
        set: |unit, value| unit.instruments.autocollimator_range_rad = value,
        get: |unit| unit.instruments.autocollimator_range_rad,
    },
    Parameter {
        key: "instruments.autocollimator-resolution",
        quantity: "angle",
        min_si: 0.0,
        max_si: 0.0001,
        default: "0.25 urad",
        doc: "Resolution of the autocollimator.",
        source: "ours: 0.05 arcsec",
        set: |unit, value| unit.instruments.autocollimator_resolution_rad = value,
        get: |unit| unit.instruments.autocollimator_resolution_rad,
    },
    Parameter {
        key: "instruments.autocollimator-noise",
        quantity: "angle",
        min_si: 0.0,
        max_si: 0.0001,
        default: "0.5 urad",
        doc: "Noise of a reading.",
        source: "ours: air and vibration",
        set: |unit, value| unit.instruments.autocollimator_noise_rad = value,
        get: |unit| unit.instruments.autocollimator_noise_rad,
    },
    Parameter {
        key: "instruments.autocollimator-scale-error",
        quantity: "ratio",
        min_si: -0.5,
        max_si: 0.5,
        default: "0.2 %",
        doc: "Scale error of the autocollimator.",
        source: "ours",
        set: |unit, value| unit.instruments.autocollimator_scale_error_ratio = value,
        get: |unit| unit.instruments.autocollimator_scale_error_ratio,
    },
    Parameter {
        key: "instruments.lever-arm",
        quantity: "length",
        min_si: 0.01,
        max_si: 10.0,
        default: "630 mm",
        doc: "Lever arm of the force gauge, as marked.",
        source: "study 3.1.1.1",
        set: |unit, value| unit.instruments.lever_arm_m = value,
        get: |unit| unit.instruments.lever_arm_m,
    },
    Parameter {
        key: "instruments.lever-arm-error",
        quantity: "length",
        min_si: -0.1,
        max_si: 0.1,
        default: "1 mm",
        doc: "True lever arm minus the marked one.",
        source: "ours",
        set: |unit, value| unit.instruments.lever_arm_error_m = value,
        get: |unit| unit.instruments.lever_arm_error_m,
    },
    Parameter {
        key: "instruments.force-range",
        quantity: "force",
        min_si: 1.0,
        max_si: 1e6,
        default: "2000 N",
        doc: "Largest force that the gauge shows.",
        source: "ours",
        set: |unit, value| unit.instruments.force_range_n = value,
        get: |unit| unit.instruments.force_range_n,
    },
    Parameter {
        key: "instruments.force-scale-error",
        quantity: "ratio",
        min_si: -0.5,
        max_si: 0.5,
        default: "0.3 %",
        doc: "Scale error of the force gauge.",
        source: "ours",
        set: |unit, value| unit.instruments.force_scale_error_ratio = value,
        get: |unit| unit.instruments.force_scale_error_ratio,
    },
    Parameter {
        key: "instruments.force-zero",
        quantity: "force",
        min_si: -100.0,
        max_si: 100.0,
        default: "0.5 N",
        doc: "Zero error of the force gauge.",
        source: "ours",
        set: |unit, value| unit.instruments.force_zero_n = value,
        get: |unit| unit.instruments.force_zero_n,
    },
    Parameter {
        key: "instruments.force-noise",
        quantity: "force",
        min_si: 0.0,
        max_si: 100.0,
        default: "1 N",
        doc: "Noise of a reading of the force gauge.",
        source: "ours",
        set: |unit, value| unit.instruments.force_noise_n = value,
        get: |unit| unit.instruments.force_noise_n,
    },
    Parameter {
        key: "instruments.strain-per-radian",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 1000.0,
        default: "0.5",
        doc: "Strain per radian of the mode that the gauge follows.",
        source: "ours: 50 um/m at 100 urad",
        set: |unit, value| unit.instruments.strain_per_rad = value,
        get: |unit| unit.instruments.strain_per_rad,
    },
    Parameter {
        key: "instruments.strain-zero",
        quantity: "ratio",
        min_si: -0.1,
        max_si: 0.1,
        default: "2 ppm",
        doc: "Zero error of a strain gauge, m/m.",
        source: "ours",
        set: |unit, value| unit.instruments.strain_zero_ratio = value,
        get: |unit| unit.instruments.strain_zero_ratio,
    },
    Parameter {
        key: "instruments.strain-noise",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 0.1,
        default: "0.2 ppm",
        doc: "Noise of a strain gauge, m/m.",
        source: "ours",
        set: |unit, value| unit.instruments.strain_noise_ratio = value,
        get: |unit| unit.instruments.strain_noise_ratio,
    },
    Parameter {
        key: "instruments.current-probe-scale-error",
        quantity: "ratio",
        min_si: -0.5,
        max_si: 0.5,
        default: "1 %",
        doc: "Scale error of the clamp-on current probe.",
        source: "ours",
        set: |unit, value| unit.instruments.current_probe_scale_error_ratio = value,
        get: |unit| unit.instruments.current_probe_scale_error_ratio,
    },
    Parameter {
        key: "instruments.current-probe-zero",
        quantity: "current",
        min_si: -10.0,
        max_si: 10.0,
        default: "0.02 A",
        doc: "Zero error of the clamp-on current probe.",
        source: "ours",
        set: |unit, value| unit.instruments.current_probe_zero_a = value,
        get: |unit| unit.instruments.current_probe_zero_a,
    },
    Parameter {
        key: "instruments.current-probe-noise",
        quantity: "current",
        min_si: 0.0,
        max_si: 10.0,
        default: "0.02 A",
        doc: "Noise of the clamp-on current probe.",
        source: "ours",
        set: |unit, value| unit.instruments.current_probe_noise_a = value,
        get: |unit| unit.instruments.current_probe_noise_a,
    },
];
