//! Motor, encoder and its noise.

use super::AxisSetting;

pub(super) const MOTOR: &[AxisSetting] = &[
    AxisSetting {
        keys: ["az.torque-constant", "el.torque-constant"],
        quantity: "torque-constant",
        range_si: [0.1, 10_000.0],
        defaults: ["60 N*m/A", "52 N*m/A"],
        doc: "Torque constant: motor torque per ampere.",
        source: "ours: the study's current pairs contradict each other",
        set: [
            |unit, value| unit.az.torque_constant_nm_per_a = value,
            |unit, value| unit.el.torque_constant_nm_per_a = value,
        ],
        get: [|unit| unit.az.torque_constant_nm_per_a, |unit| unit.el.torque_constant_nm_per_a],
    },
    AxisSetting {
        keys: ["az.current-limit", "el.current-limit"],
        quantity: "current",
        range_si: [0.1, 65.0],
        defaults: ["42.6 A", "36.2 A"],
        doc: "Largest current the drive can give.",
        source: "study 2.3.1: peak currents",
        set: [|unit, value| unit.az.current_limit_a = value, |unit, value| unit.el.current_limit_a = value],
        get: [|unit| unit.az.current_limit_a, |unit| unit.el.current_limit_a],
    },
    AxisSetting {
        keys: ["az.current-noise", "el.current-noise"],
        quantity: "current",
        range_si: [0.0, 1.0],
        defaults: ["0.01 A", "0.005 A"],
        doc: "Standard deviation of the measured current, white per exchange.",
        source: "ours",
        set: [|unit, value| unit.az.current_noise_a = value, |unit, value| unit.el.current_noise_a = value],
        get: [|unit| unit.az.current_noise_a, |unit| unit.el.current_noise_a],
    },
    AxisSetting {
        keys: ["az.encoder-bits", "el.encoder-bits"],
        quantity: "count",
        range_si: [12.0, 30.0],
        defaults: ["26", "26"],
        doc: "Bits of the single-turn encoder.",
        source: "study 2.1.4",
        set: [
            |unit, value| unit.az.encoder_bits_count = value,
            |unit, value| unit.el.encoder_bits_count = value,
        ],
        get: [|unit| unit.az.encoder_bits_count, |unit| unit.el.encoder_bits_count],
    },
    AxisSetting {
        keys: ["az.encoder-zero", "el.encoder-zero"],
        quantity: "angle",
        range_si: [-7.0, 7.0],
        defaults: ["0 deg", "0 deg"],
        doc: "Angle at which the encoder counts zero.",
        source: "ours",
        set: [|unit, value| unit.az.encoder_zero_rad = value, |unit, value| unit.el.encoder_zero_rad = value],
        get: [|unit| unit.az.encoder_zero_rad, |unit| unit.el.encoder_zero_rad],
    },
    AxisSetting {
        keys: ["az.encoder-sign", "el.encoder-sign"],
        quantity: "ratio",
        range_si: [-1.0, 1.0],
        defaults: ["1", "1"],
        doc: "+1 or -1: whether counts grow with the angle.",
        source: "ours",
        set: [
            |unit, value| unit.az.encoder_sign_factor = value,
            |unit, value| unit.el.encoder_sign_factor = value,
        ],
        get: [|unit| unit.az.encoder_sign_factor, |unit| unit.el.encoder_sign_factor],
    },
    AxisSetting {
        keys: ["az.velocity-window", "el.velocity-window"],
        quantity: "time",
        range_si: [5.0e-5, 0.0016],
        defaults: ["1 ms", "1 ms"],
        doc: "Window of the backward difference from which the drive takes its velocity.",
        source: "ours",
        set: [
            |unit, value| unit.az.velocity_window_s = value,
            |unit, value| unit.el.velocity_window_s = value,
        ],
        get: [|unit| unit.az.velocity_window_s, |unit| unit.el.velocity_window_s],
    },
];
