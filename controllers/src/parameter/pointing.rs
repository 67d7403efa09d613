//! Sensors' mount, Earth, keyhole and braking.

use core::f64::consts::{FRAC_PI_2, TAU};

use super::Parameter;
use crate::DirectorGains;

pub(super) const POINTING: &[Parameter<DirectorGains>] = &[
    Parameter {
        key: "imu.elevation-sign",
        quantity: "count",
        range_si: [-1.0, 1.0],
        default: "-1",
        doc: "Sign that converts the mapped elevation rate to d(el)/dt; only whether it is below 0 counts.",
        source: "the matrix as published gives -d(el)/dt: an azimuth spin shows it",
        set: |gains, value| gains.elevation_sign = value,
        get: |gains| gains.elevation_sign,
    },
    Parameter {
        key: "earth.latitude",
        quantity: "angle",
        range_si: [-FRAC_PI_2, FRAC_PI_2],
        default: "40 deg",
        doc: "Latitude of the site, north positive.",
        source: "ours: 46.9 urad/s about the vertical",
        set: |gains, value| gains.earth.latitude_rad = value,
        get: |gains| gains.earth.latitude_rad,
    },
    Parameter {
        key: "earth.azimuth-zero-heading",
        quantity: "angle",
        range_si: [-TAU, TAU],
        default: "0 deg",
        doc: "Compass heading of the line of sight at azimuth 0.",
        source: "ours",
        set: |gains, value| gains.earth.azimuth_zero_heading_rad = value,
        get: |gains| gains.earth.azimuth_zero_heading_rad,
    },
    Parameter {
        key: "keyhole.start",
        quantity: "angle",
        range_si: [0.1, FRAC_PI_2],
        default: "80 deg",
        doc: "Elevation from which the integrals of cross-elevation control are faded out.",
        source: "common practice: 80 to 85 deg",
        set: |gains, value| gains.keyhole.start_rad = value,
        get: |gains| gains.keyhole.start_rad,
    },
    Parameter {
        key: "keyhole.limit",
        quantity: "angle",
        range_si: [0.1, 1.57],
        default: "85 deg",
        doc: "Elevation beyond which the secant is limited to its value there (11.5).",
        source: "common practice: 80 to 85 deg",
        set: |gains, value| gains.keyhole.limit_rad = value,
        get: |gains| gains.keyhole.limit_rad,
    },
    Parameter {
        key: "keyhole.hysteresis",
        quantity: "angle",
        range_si: [0.0, 0.5],
        default: "1.5 deg",
        doc: "Hysteresis: distance below the limit at which the keyhole is left again.",
        source: "common practice: 1 to 2 deg",
        set: |gains, value| gains.keyhole.hysteresis_rad = value,
        get: |gains| gains.keyhole.hysteresis_rad,
    },
    Parameter {
        key: "envelope.deceleration",
        quantity: "angular-acceleration",
        range_si: [0.01, 100.0],
        default: "60 deg/s^2",
        doc: "Deceleration assumed for stopping before soft limits and masks.",
        source: "ours: two thirds of the required acceleration, friction not counted",
        set: |gains, value| gains.envelope.deceleration_rad_per_s2 = value,
        get: |gains| gains.envelope.deceleration_rad_per_s2,
    },
    Parameter {
        key: "envelope.reaction-time",
        quantity: "time",
        range_si: [0.0, 1.0],
        default: "50 ms",
        doc: "Time from a rate command to the rate, including one tick.",
        source: "ours: velocity loop of 3.5 Hz, 1/(2 pi f) = 45 ms",
        set: |gains, value| gains.envelope.reaction_time_s = value,
        get: |gains| gains.envelope.reaction_time_s,
    },
];
