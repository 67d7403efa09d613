//! Velocity, position and coarse track loop of each axis.

use super::Parameter;
use crate::{AxisGains, DirectorGains};

const VELOCITY_FIT: &str = "fit of the discrete loop to the published margins, elevation -10 to 90 deg";
const POSITION_FIT: &str = "fit to the published step responses of azimuth";
const TRACK_FIT: &str = "study's fit";
const TRACK_TIME_FIT: &str = "fit to the published coarse track margins, elevation -10 to 90 deg";
const LEAD_FIT: &str = "fit of the gain margin, 1.0 ms, + 1.5 ms age of the gyro sample";
const OF_THE_RIG: &str = "designed for the axis";
const KP_DOC: &str = "Proportional gain: torque per velocity error.";
const KI_DOC: &str = "Integral gain: torque per integrated velocity error; 0 switches the integral off.";
const POSITION_DOC: &str = "Velocity command per position error.";
const TRACK_DOC: &str = "Velocity command per coarse track error.";
const TRACK_TIME_DOC: &str = "Integral time of the coarse track loop; 0 = no integral.";
const LEAD_DOC: &str = "Lead time of the coarse track error relative to the gyro rate.";

pub(super) const AXES: &[Parameter<DirectorGains>] = &[
    Parameter {
        key: "az.velocity-kp",
        quantity: "damping",
        range_si: [0.0, 1e6],
        default: "23600 N*m*s/rad",
        doc: KP_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.az.velocity_kp_nm_s_per_rad = value,
        get: |gains| gains.az.velocity_kp_nm_s_per_rad,
    },
    Parameter {
        key: "az.velocity-ki",
        quantity: "stiffness",
        range_si: [0.0, 1e8],
        default: "447500 N*m/rad",
        doc: KI_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.az.velocity_ki_nm_per_rad = value,
        get: |gains| gains.az.velocity_ki_nm_per_rad,
    },
    Parameter {
        key: "az.position-gain",
        quantity: "gain",
        range_si: [0.0, 100.0],
        default: "4.5 1/s",
        doc: POSITION_DOC,
        source: POSITION_FIT,
        set: |gains, value| gains.az.position_gain_per_s = value,
        get: |gains| gains.az.position_gain_per_s,
    },
    Parameter {
        key: "az.track-gain",
        quantity: "gain",
        range_si: [0.0, 100.0],
        default: "4.95 1/s",
        doc: TRACK_DOC,
        source: TRACK_FIT,
        set: |gains, value| gains.az.track.gain_per_s = value,
        get: |gains| gains.az.track.gain_per_s,
    },
    Parameter {
        key: "az.track-integral-time",
        quantity: "time",
        range_si: [0.0, 100.0],
        default: "0.246 s",
        doc: TRACK_TIME_DOC,
        source: TRACK_TIME_FIT,
        set: |gains, value| gains.az.track.integral_time_s = value,
        get: |gains| gains.az.track.integral_time_s,
    },
    Parameter {
        key: "az.track-gyro-lead",
        quantity: "time",
        range_si: [0.0, 0.1],
        default: "2.25 ms",
        doc: LEAD_DOC,
        source: LEAD_FIT,
        set: |gains, value| gains.az.track.gyro_lead_s = value,
        get: |gains| gains.az.track.gyro_lead_s,
    },
    Parameter {
        key: "el.velocity-kp",
        quantity: "damping",
        range_si: [0.0, 1e6],
        default: "18250 N*m*s/rad",
        doc: KP_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.el.velocity_kp_nm_s_per_rad = value,
        get: |gains| gains.el.velocity_kp_nm_s_per_rad,
    },
    Parameter {
        key: "el.velocity-ki",
        quantity: "stiffness",
        range_si: [0.0, 1e8],
        default: "361400 N*m/rad",
        doc: KI_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.el.velocity_ki_nm_per_rad = value,
        get: |gains| gains.el.velocity_ki_nm_per_rad,
    },
    Parameter {
        key: "el.position-gain",
        quantity: "gain",
        range_si: [0.0, 100.0],
        default: "4.5 1/s",
        doc: POSITION_DOC,
        source: "as azimuth: elevation steps of 0.3 deg settle as azimuth's with it",
        set: |gains, value| gains.el.position_gain_per_s = value,
        get: |gains| gains.el.position_gain_per_s,
    },
    Parameter {
        key: "el.track-gain",
        quantity: "gain",
        range_si: [0.0, 100.0],
        default: "5.51 1/s",
        doc: TRACK_DOC,
        source: TRACK_FIT,
        set: |gains, value| gains.el.track.gain_per_s = value,
        get: |gains| gains.el.track.gain_per_s,
    },
    Parameter {
        key: "el.track-integral-time",
        quantity: "time",
        range_si: [0.0, 100.0],
        default: "0.543 s",
        doc: TRACK_TIME_DOC,
        source: TRACK_TIME_FIT,
        set: |gains, value| gains.el.track.integral_time_s = value,
        get: |gains| gains.el.track.integral_time_s,
    },
    Parameter {
        key: "el.track-gyro-lead",
        quantity: "time",
        range_si: [0.0, 0.1],
        default: "2.25 ms",
        doc: LEAD_DOC,
        source: LEAD_FIT,
        set: |gains, value| gains.el.track.gyro_lead_s = value,
        get: |gains| gains.el.track.gyro_lead_s,
    },
];

/// The gains of one axis of any name, as a section `[axis.<name>]` has them. They have no defaults: what fits an axis
/// depends on its inertia.
pub const AXIS_PARAMETERS: &[Parameter<AxisGains>] = &[
    Parameter {
        key: "velocity-kp",
        quantity: "damping",
        range_si: [0.0, 1e6],
        default: "0 N*m*s/rad",
        doc: KP_DOC,
        source: OF_THE_RIG,
        set: |gains, value| gains.velocity_kp_nm_s_per_rad = value,
        get: |gains| gains.velocity_kp_nm_s_per_rad,
    },
    Parameter {
        key: "velocity-ki",
        quantity: "stiffness",
        range_si: [0.0, 1e8],
        default: "0 N*m/rad",
        doc: KI_DOC,
        source: OF_THE_RIG,
        set: |gains, value| gains.velocity_ki_nm_per_rad = value,
        get: |gains| gains.velocity_ki_nm_per_rad,
    },
    Parameter {
        key: "position-gain",
        quantity: "gain",
        range_si: [0.0, 100.0],
        default: "0 1/s",
        doc: POSITION_DOC,
        source: OF_THE_RIG,
        set: |gains, value| gains.position_gain_per_s = value,
        get: |gains| gains.position_gain_per_s,
    },
];
