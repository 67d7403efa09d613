//! Structure of the unit `nominal`: the fitted table with less of the first mode in the gyro and a narrower spread
//! of the rigid gain.

use super::{ModeCurves, StructureSettings};

const ELEVATION_DEG: [f64; 11] = [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0];

/// Curves of one mode: Hz, 1/(kg·m²), 1/(kg·m²).
struct Mode {
    frequency_hz: [f64; 11],
    damping_ratio: f64,
    gyro_per_kg_m2: [f64; 11],
    encoder_per_kg_m2: [f64; 11],
}

const AZIMUTH_RIGID_GAIN: [f64; 11] = [1.0362, 1.06, 1.06, 1.0536, 1.06, 0.97, 0.97, 0.97, 0.97, 0.97, 0.97];

const AZIMUTH_MODES: [Mode; 3] = [
    Mode {
        frequency_hz: [42.5, 42.304, 41.736, 40.851, 39.736, 38.5, 37.264, 36.149, 35.264, 34.696, 34.5],
        damping_ratio: 0.03,
        gyro_per_kg_m2: [
            -0.000110752,
            -0.000158768,
            -0.000303816,
            -0.000334168,
            -0.000259096,
            -0.000265416,
            -0.000263312,
            -0.000244704,
            -0.000206416,
            -0.000160376,
            -0.000114904,
        ],
        encoder_per_kg_m2: [
            0.00015382, 0.00022051, 0.00042197, 0.00046412, 0.00035986, 0.00036863, 0.00036571, 0.00033987,
            0.00028669, 0.00022274, 0.00015959,
        ],
    },
    Mode {
        frequency_hz: [56.0, 55.731, 54.95, 53.733, 52.2, 50.5, 48.8, 47.267, 46.05, 45.269, 45.0],
        damping_ratio: 0.03,
        gyro_per_kg_m2: [
            0.00020833, 0.00020833, 0.00020833, 0.00020833, 0.00020833, 0.00020833, 0.00020833, 0.00020833,
            0.00020833, 0.00020833, 0.00020833,
        ],
        encoder_per_kg_m2: [
            0.00026041, 0.00026041, 0.00026041, 0.00026041, 0.00026041, 0.00026041, 0.00026041, 0.00026041,
            0.00026041, 0.00026041, 0.00026041,
        ],
    },
    Mode {
        frequency_hz: [88.0, 87.706, 86.854, 85.527, 83.854, 82.0, 80.146, 78.473, 77.146, 76.294, 76.0],
        damping_ratio: 0.03,
        gyro_per_kg_m2: [
            0.00016667, 0.00016667, 0.00016667, 0.00016667, 0.00016667, 0.00016667, 0.00016667, 0.00016667,
            0.00016667, 0.00016667, 0.00016667,
        ],
        encoder_per_kg_m2: [
            0.00020834, 0.00020834, 0.00020834, 0.00020834, 0.00020834, 0.00020834, 0.00020834, 0.00020834,
            0.00020834, 0.00020834, 0.00020834,
        ],
    },
];

const ELEVATION_RIGID_GAIN: [f64; 11] =
    [0.9958, 0.98, 0.98, 0.9912, 0.98, 0.9952, 0.98, 0.98, 1.0043, 0.98, 1.0331];

const ELEVATION_MODES: [Mode; 4] = [
    Mode {
        frequency_hz: [17.004, 17.25, 17.459, 17.632, 17.767, 17.865, 17.927, 17.951, 17.938, 17.888, 17.802],
        damping_ratio: 0.035,
        gyro_per_kg_m2: [
            -0.000179048,
            -0.000165712,
            -0.00015456,
            -0.000145992,
            -0.000139624,
            -0.000137608,
            -9.7072e-05,
            -9.9264e-05,
            -0.00010196,
            -7.8392e-05,
            -9.94e-05,
        ],
        encoder_per_kg_m2: [
            0.00018651, 0.00017262, 0.000161, 0.00015207, 0.00014544, 0.00014334, 0.00010112, 0.0001034,
            0.00010621, 8.1658e-05, 0.00010354,
        ],
    },
    Mode {
        frequency_hz: [17.454, 18.0, 18.565, 19.151, 19.756, 20.38, 21.025, 21.689, 22.373, 23.077, 23.801],
        damping_ratio: 0.03,
        gyro_per_kg_m2: [
            8.8205e-05, 9.2308e-05, 9.641e-05, 0.00010051, 0.00010462, 0.00010872, 0.00011282, 0.00011692,
            0.00012103, 0.00012513, 0.00012923,
        ],
        encoder_per_kg_m2: [
            0.00011026, 0.00011538, 0.00012051, 0.00012564, 0.00013077, 0.0001359, 0.00014102, 0.00014615,
            0.00015129, 0.00015641, 0.00016154,
        ],
    },
    Mode {
        frequency_hz: [45.4, 46.0, 46.6, 47.2, 47.8, 48.4, 49.0, 49.6, 50.2, 50.8, 51.4],
        damping_ratio: 0.03,
        gyro_per_kg_m2: [
            0.00015385, 0.00015385, 0.00015385, 0.00015385, 0.00015385, 0.00015385, 0.00015385, 0.00015385,
            0.00015385, 0.00015385, 0.00015385,
        ],
        encoder_per_kg_m2: [
            0.00019231, 0.00019231, 0.00019231, 0.00019231, 0.00019231, 0.00019231, 0.00019231, 0.00019231,
            0.00019231, 0.00019231, 0.00019231,
        ],
    },
    Mode {
        frequency_hz: [9.7778, 10.0, 10.2222, 10.4444, 10.6667, 10.8889, 11.1, 11.3, 11.5, 11.7, 11.9],
        damping_ratio: 0.1,
        gyro_per_kg_m2: [1e-05, 1e-05, 1e-05, 1e-05, 1e-05, 1e-05, 1e-05, 1e-05, 1e-05, 1e-05, 1e-05],
        encoder_per_kg_m2: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    },
];

pub(in crate::unit) fn azimuth() -> StructureSettings {
    structure(&AZIMUTH_RIGID_GAIN, &AZIMUTH_MODES)
}

pub(in crate::unit) fn elevation() -> StructureSettings {
    structure(&ELEVATION_RIGID_GAIN, &ELEVATION_MODES)
}

fn structure(rigid_gain: &[f64; 11], modes: &[Mode]) -> StructureSettings {
    let modes = modes.iter().map(|mode| ModeCurves {
        frequency_hz: mode.frequency_hz.to_vec(),
        damping_ratio: vec![mode.damping_ratio; 11],
        gyro_per_kg_m2: mode.gyro_per_kg_m2.to_vec(),
        encoder_per_kg_m2: mode.encoder_per_kg_m2.to_vec(),
    });
    StructureSettings {
        elevation_rad: ELEVATION_DEG.iter().map(|deg| deg.to_radians()).collect(),
        rigid_gain_ratio: rigid_gain.to_vec(),
        modes: modes.collect(),
    }
}
