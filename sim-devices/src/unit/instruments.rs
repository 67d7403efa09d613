//! Instruments on the bench: external angle references, force gauge, current probe, analyser, oscilloscope.

use super::UnitSettings;
use super::setting::{Field, Setting};

/// Instruments on the bench: external angle references, force gauge, current probe, analyser, oscilloscope.
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
    /// Scale error of the clamp-on current probe.
    pub current_probe_scale_error_ratio: f64,
    /// Zero error of the clamp-on current probe.
    pub current_probe_zero_a: f64,
    /// Noise of the clamp-on current probe.
    pub current_probe_noise_a: f64,
    /// Noise of the impedance analyser, relative to the impedance.
    pub analyser_noise_ratio: f64,
    /// Time of a point of the impedance analyser beside its periods.
    pub analyser_point_time_s: f64,
    /// Periods of the sine that a point of the impedance analyser takes.
    pub analyser_periods_count: f64,
    /// Noise of the oscilloscope, relative to the height of the screen.
    pub scope_noise_ratio: f64,
    /// Tilt per volt of the autocollimator that looks at the mirror.
    pub mirror_reference_scale_rad_per_v: f64,
    /// Largest tilt that it reads.
    pub mirror_reference_range_rad: f64,
    /// Scale error of the mirror's reference.
    pub mirror_reference_scale_error_ratio: f64,
    /// Noise of a reading of it.
    pub mirror_reference_noise_rad: f64,
    /// From the analog output that is looped back to its input, settling and conversion included.
    pub echo_delay_s: f64,
    /// Resistance that each output of the DC supply feeds.
    pub dc_supply_load_ohm: f64,
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
            current_probe_scale_error_ratio: 0.01,
            current_probe_zero_a: 0.02,
            current_probe_noise_a: 0.02,
            analyser_noise_ratio: 0.001,
            analyser_point_time_s: 0.003,
            analyser_periods_count: 2.0,
            scope_noise_ratio: 0.0003,
            mirror_reference_scale_rad_per_v: 200e-6,
            mirror_reference_range_rad: 1.5e-3,
            mirror_reference_scale_error_ratio: 0.002,
            mirror_reference_noise_rad: 0.2e-6,
            echo_delay_s: 20e-6,
            dc_supply_load_ohm: 24.0,
        }
    }
}

pub(super) const INSTRUMENTS: &[Setting<Field<UnitSettings>>] = &[
    Setting {
        key: "instruments.polygon-faces",
        quantity: "count",
        range_si: [1.0, 360.0],
        default: "36",
        doc: "Faces of the polygon.",
        source: "ours: one every 10 deg",
        field: |unit| &mut unit.instruments.polygon_faces_count,
    },
    Setting {
        key: "instruments.polygon-face-error",
        quantity: "angle",
        range_si: [0.0, 0.001],
        default: "25 urad",
        doc: "Standard deviation of the face angles; the calibration table contains them.",
        source: "ours: 5 arcsec, a usual grade",
        field: |unit| &mut unit.instruments.polygon_face_error_rad,
    },
    Setting {
        key: "instruments.polygon-calibration",
        quantity: "angle",
        range_si: [0.0, 0.0001],
        default: "1.5 urad",
        doc: "Standard uncertainty of the calibration table.",
        source: "ours: 0.6 arcsec, k = 2, and its mounting",
        field: |unit| &mut unit.instruments.polygon_calibration_rad,
    },
    Setting {
        key: "instruments.autocollimator-range",
        quantity: "angle",
        range_si: [0.000001, 0.1],
        default: "400 urad",
        doc: "Largest deviation from a face that can be read.",
        source: "ours",
        field: |unit| &mut unit.instruments.autocollimator_range_rad,
    },
    Setting {
        key: "instruments.autocollimator-resolution",
        quantity: "angle",
        range_si: [0.0, 0.0001],
        default: "0.25 urad",
        doc: "Resolution of the autocollimator.",
        source: "ours: 0.05 arcsec",
        field: |unit| &mut unit.instruments.autocollimator_resolution_rad,
    },
    Setting {
        key: "instruments.autocollimator-noise",
        quantity: "angle",
        range_si: [0.0, 0.0001],
        default: "0.5 urad",
        doc: "Noise of a reading.",
        source: "ours: air and vibration",
        field: |unit| &mut unit.instruments.autocollimator_noise_rad,
    },
    Setting {
        key: "instruments.autocollimator-scale-error",
        quantity: "ratio",
        range_si: [-0.5, 0.5],
        default: "0.2 %",
        doc: "Scale error of the autocollimator.",
        source: "ours",
        field: |unit| &mut unit.instruments.autocollimator_scale_error_ratio,
    },
    Setting {
        key: "instruments.lever-arm",
        quantity: "length",
        range_si: [0.01, 10.0],
        default: "630 mm",
        doc: "Lever arm of the force gauge, as marked.",
        source: "study 3.1.1.1",
        field: |unit| &mut unit.instruments.lever_arm_m,
    },
    Setting {
        key: "instruments.lever-arm-error",
        quantity: "length",
        range_si: [-0.1, 0.1],
        default: "1 mm",
        doc: "True lever arm minus the marked one.",
        source: "ours",
        field: |unit| &mut unit.instruments.lever_arm_error_m,
    },
    Setting {
        key: "instruments.force-range",
        quantity: "force",
        range_si: [1.0, 1e6],
        default: "2000 N",
        doc: "Largest force that the gauge can show.",
        source: "ours",
        field: |unit| &mut unit.instruments.force_range_n,
    },
    Setting {
        key: "instruments.force-scale-error",
        quantity: "ratio",
        range_si: [-0.5, 0.5],
        default: "0.3 %",
        doc: "Scale error of the force gauge.",
        source: "ours",
        field: |unit| &mut unit.instruments.force_scale_error_ratio,
    },
    Setting {
        key: "instruments.force-zero",
        quantity: "force",
        range_si: [-100.0, 100.0],
        default: "0.5 N",
        doc: "Zero error of the force gauge.",
        source: "ours",
        field: |unit| &mut unit.instruments.force_zero_n,
    },
    Setting {
        key: "instruments.force-noise",
        quantity: "force",
        range_si: [0.0, 100.0],
        default: "1 N",
        doc: "Noise of a reading of the force gauge.",
        source: "ours",
        field: |unit| &mut unit.instruments.force_noise_n,
    },
    Setting {
        key: "instruments.current-probe-scale-error",
        quantity: "ratio",
        range_si: [-0.5, 0.5],
        default: "1 %",
        doc: "Scale error of the clamp-on current probe.",
        source: "ours",
        field: |unit| &mut unit.instruments.current_probe_scale_error_ratio,
    },
    Setting {
        key: "instruments.current-probe-zero",
        quantity: "current",
        range_si: [-10.0, 10.0],
        default: "0.02 A",
        doc: "Zero error of the clamp-on current probe.",
        source: "ours",
        field: |unit| &mut unit.instruments.current_probe_zero_a,
    },
    Setting {
        key: "instruments.current-probe-noise",
        quantity: "current",
        range_si: [0.0, 10.0],
        default: "0.02 A",
        doc: "Noise of the clamp-on current probe.",
        source: "ours",
        field: |unit| &mut unit.instruments.current_probe_noise_a,
    },
    Setting {
        key: "instruments.analyser-noise",
        quantity: "ratio",
        range_si: [0.0, 0.1],
        default: "0.1 %",
        doc: "Noise of the impedance analyser, relative to the impedance.",
        source: "ours: its basic accuracy is 0.08 %",
        field: |unit| &mut unit.instruments.analyser_noise_ratio,
    },
    Setting {
        key: "instruments.analyser-point-time",
        quantity: "time",
        range_si: [0.0, 10.0],
        default: "3 ms",
        doc: "Time per point of the impedance analyser in addition to its periods.",
        source: "ours: shortest aperture",
        field: |unit| &mut unit.instruments.analyser_point_time_s,
    },
    Setting {
        key: "instruments.analyser-periods",
        quantity: "count",
        range_si: [1.0, 100.0],
        default: "2",
        doc: "Periods of the sine per point of the impedance analyser.",
        source: "ours: one to settle, one to measure",
        field: |unit| &mut unit.instruments.analyser_periods_count,
    },
    Setting {
        key: "instruments.scope-noise",
        quantity: "ratio",
        range_si: [0.0, 0.1],
        default: "0.03 %",
        doc: "Noise of the oscilloscope, relative to the height of the screen.",
        source: "ours: about one step of 12 bits",
        field: |unit| &mut unit.instruments.scope_noise_ratio,
    },
    Setting {
        key: "instruments.mirror-reference-scale",
        quantity: "angle-scale",
        range_si: [1e-6, 0.01],
        default: "200 urad/V",
        doc: "Tilt per volt of the autocollimator that looks at the mirror.",
        source: "ours: 10 V are 2 mrad",
        field: |unit| &mut unit.instruments.mirror_reference_scale_rad_per_v,
    },
    Setting {
        key: "instruments.mirror-reference-range",
        quantity: "angle",
        range_si: [1e-5, 0.1],
        default: "1.5 mrad",
        doc: "Largest tilt that it can read.",
        source: "ours: stroke of the mirror, 1.05 mrad, and room for overshoot",
        field: |unit| &mut unit.instruments.mirror_reference_range_rad,
    },
    Setting {
        key: "instruments.mirror-reference-scale-error",
        quantity: "ratio",
        range_si: [-0.5, 0.5],
        default: "0.2 %",
        doc: "Scale error of the autocollimator that looks at the mirror.",
        source: "ours",
        field: |unit| &mut unit.instruments.mirror_reference_scale_error_ratio,
    },
    Setting {
        key: "instruments.mirror-reference-noise",
        quantity: "angle",
        range_si: [0.0, 0.0001],
        default: "0.2 urad",
        doc: "Noise of a reading of the autocollimator that looks at the mirror.",
        source: "ours: resolution of the mirror, 0.2 urad",
        field: |unit| &mut unit.instruments.mirror_reference_noise_rad,
    },
    Setting {
        key: "instruments.echo-delay",
        quantity: "time",
        range_si: [0.0, 0.001],
        default: "0.02 ms",
        doc: "Delay from the looped-back analog output to its input, including settling and conversion.",
        source: "ours: settling 10 us, conversion 10 us",
        field: |unit| &mut unit.instruments.echo_delay_s,
    },
    Setting {
        key: "instruments.dc-supply-load",
        quantity: "resistance",
        range_si: [0.1, 1e6],
        default: "24 ohm",
        doc: "Resistance that each output of the DC supply feeds.",
        source: "ours: 24 W at 24 V",
        field: |unit| &mut unit.instruments.dc_supply_load_ohm,
    },
];
