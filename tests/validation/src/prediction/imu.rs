//! Inertial measurement unit.

use super::{Expected, Subject, row};

/// Row 19: angle random walk 1.5 % from an hour's record, k = 2.
const WALK_U: f64 = 0.03;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let imu = &subject.unit.imu;
    let walk = imu.gyro_random_walk_rad_per_sqrt_s * imu.gyro_noise_factor;
    vec![row("GYR-ARW", None, "angle-random-walk", "", walk, WALK_U * walk)]
}
