//! Gyros whose scale errors differ: healthy as long as polarity accepts each of them.

use super::*;

/// Scale errors of X, Y and Z inside the 2 % that polarity accepts.
const WITHIN: [[f64; 3]; 4] =
    [[0.019, -0.019, 0.0], [-0.019, 0.019, 0.019], [0.019, 0.0, -0.019], [-0.019, -0.019, 0.019]];

#[test]
fn gyros_with_different_scale_errors_freeze_no_encoder_of_an_axis_at_rest() {
    let limits = ProfileLimits {
        velocity_rad_per_s: 60_f64.to_radians(),
        acceleration_rad_per_s2: 90_f64.to_radians(),
        jerk_rad_per_s3: 900_f64.to_radians(),
    };
    let slew = Stimulus::Move { target_rad: 1.5, limits };
    for errors in WITHIN {
        let mut unit = UnitSettings::default();
        unit.imu.gyro_scale_error_ratio = errors;
        let wanted = case(vec![segment(Mode::Position, slew.clone(), 8.0, Then::Hold)]);
        let (outcome, _) = run_case(&wanted, &unit, &[], 0);
        assert_eq!(outcome.status, PointStatus::Completed, "{errors:?}: {outcome:?}");
    }
}
