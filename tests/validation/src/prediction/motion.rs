//! Acceleration, rate, envelope, soft limits, masks, slew to cue.

use super::drivetrain::{Drivetrain, POSES_DEG, REQUIRED_RAD_PER_S};
use super::{Expected, Subject, rig_limits, row, servo};

/// Acceleration by a straight line through encoder rates over 0.1 s or more, and the torque limit's own spread.
const ACCELERATION_U: f64 = 5e-3;
/// Rate over a whole second by encoder: a count per second, and the clock.
const RATE_U: f64 = 1e-4;
/// External reference (director.md, POS-ACC).
const ANGLE_U_RAD: f64 = 6e-6;
/// Torque constant in the rig file.
const TORQUE_U: f64 = 5e-3;
/// 3σ of an encoder at rest.
const ENCODER_U_RAD: f64 = 0.3e-6;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let mut rows = envelope(subject);
    for axis in 0..2 {
        for pose_deg in POSES_DEG {
            let train = Drivetrain::new(subject, axis, pose_deg);
            let condition = format!("elevation {pose_deg} deg, at 60 deg/s");
            let acceleration = train.acceleration_rad_per_s2(REQUIRED_RAD_PER_S);
            let u = ACCELERATION_U * acceleration.abs();
            rows.push(row("MOT-ACC", axis, "acceleration", condition, acceleration, u));
            let needed = rig_limits::ACCELERATION_RAD_PER_S2 * train.inertia_kg_m2
                + train.friction_nm(REQUIRED_RAD_PER_S)
                + train.worst_load_nm();
            let left_nm = train.torque_nm() - needed;
            let u = TORQUE_U * train.torque_nm();
            let condition = format!("elevation {pose_deg} deg, 93 deg/s^2 at 60 deg/s");
            rows.push(row("MOT-CUE", axis, "torque-reserve", condition, left_nm, u));
        }
        let train = Drivetrain::new(subject, axis, POSES_DEG[0]);
        let reachable = train.reachable_rad_per_s();
        rows.push(row("MOT-VEL", axis, "velocity", "", reachable, RATE_U * reachable));
        let overrun_rad = overrun_rad(subject, &train);
        let past = if subject.axis(axis).soft_limits_enforced() {
            overrun_rad
        } else {
            // Followed to where the bench itself stops it: the end of the travel.
            overrun_rad + rig_limits::TRAVEL_RAD[axis][1] - rig_limits::SOFT_RAD[axis][1]
        };
        rows.push(row("MOT-SOFT", axis, "travel-past-limit", "", past, ENCODER_U_RAD));
        rows.push(row("MOT-MASK", axis, "travel-past-limit", "", overrun_rad, ENCODER_U_RAD));
        let overshoot_rad = servo::overshoot_rad(subject, axis);
        rows.push(row("MOT-CUE", axis, "overshoot", "", overshoot_rad, ENCODER_U_RAD));
    }
    rows
}

/// What the stops leave; the bench itself stays half a degree inside.
fn envelope(subject: &Subject<'_>) -> Vec<Expected> {
    let az = &subject.unit.az;
    let el = &subject.unit.el;
    vec![
        row("MOT-RNG-AZ", 0, "travel", "", az.upper_stop_rad - az.lower_stop_rad, ANGLE_U_RAD),
        row("MOT-RNG-EL", 1, "lower-end", "", el.lower_stop_rad, ANGLE_U_RAD),
        row("MOT-RNG-EL", 1, "upper-end", "", el.upper_stop_rad, ANGLE_U_RAD),
    ]
}

/// How much further an axis brakes than the controllers rely on, from the highest rate that it reaches.
fn overrun_rad(subject: &Subject<'_>, train: &Drivetrain<'_>) -> f64 {
    let relied = subject.gains.envelope.deceleration_rad_per_s2;
    let rate = train.reachable_rad_per_s();
    let real = train.deceleration_rad_per_s2(0.5 * rate);
    (0.5 * rate * rate * (1.0 / real - 1.0 / relied)).max(0.0)
}
