use super::*;
use crate::shipped;

/// Rail and drone until the rail's first reversal is due, all that holds of Done-when 3 at once.
#[test]
fn rail_and_drone_leave_the_errors_of_the_study_and_those_that_the_fine_loop_predicts() {
    let gains = shipped::gains();
    for scenario in [Scenario::Rail, Scenario::Drone] {
        let unit = scenario.unit(&UnitSettings::default());
        let rows = track(&unit, &gains, 1, 47.0).expect("the drivers open their twins");
        for case in CASES.iter().filter(|case| case.scenario == scenario) {
            let seen = case.coarse_window(&rows);
            let coarse = deviation(seen.iter().map(|row| row.coarse_rad(case.axis))) / case.coarse_rad;
            assert!((1.0 / 1.5..1.5).contains(&coarse), "{}: coarse {coarse:.3} of the published", case.name);
            let fine = FineTracking::of(case.fine_window(&rows), case.axis, &unit, &gains);
            assert!((0.8..1.2).contains(&fine.ratio()), "{}: {fine:?}", case.name);
            assert!(case.fine_window(&rows).iter().all(|row| row.locked), "{} lost its target", case.name);
        }
        for axis in [0, 1] {
            let (errors, excluded) = quiet(&rows, axis);
            let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            assert!(rms <= 100e-6 && excluded <= 0.05, "{scenario:?}, axis {axis}: {rms:e}, {excluded}");
        }
        let dwell_s = longest_within(span(&rows, 5.0, 47.0), 5e-6);
        assert!(dwell_s >= 6.0, "{scenario:?}: {dwell_s} s of fine track");
    }
}

/// ATM-REJ in the study's two cases, everything moving and measuring as it does.
#[test]
fn the_mirror_rejects_the_atmosphere_as_required_with_the_whole_director_behind_it() {
    let gains = shipped::gains();
    for (wind_speed_m_per_s, strength_m_pow) in [(20.0, 1e-14), (25.0, 5e-14)] {
        let mut unit = Scenario::Star.unit(&UnitSettings::default());
        unit.atmosphere.wind_speed_m_per_s = wind_speed_m_per_s;
        unit.atmosphere.strength_m_pow = strength_m_pow;
        let rows = track(&unit, &gains, 1, 65.0).expect("the drivers open their twins");
        for axis in [0, 1] {
            let seen = rejection(span(&rows, 5.0, 65.0), axis);
            let text = format!("{wind_speed_m_per_s} m/s, axis {axis}: {seen:?}");
            assert!(seen.at_1_hz_db <= -15.0 && seen.at_3_hz_db <= -6.0, "{text}");
            assert!(seen.crossing_hz >= 7.0 && seen.amplification_db <= 6.0, "{text}");
        }
    }
}

/// A unit whose gyros have their constant bias and no other error that changes with time. Without noise the steps of the
/// output would swallow the bias.
fn biased() -> UnitSettings {
    let mut unit = UnitSettings::default();
    let imu = &mut unit.imu;
    (imu.gyro_noise_factor, imu.gyro_quantum_rad_per_s) = (0.0, 0.0);
    (imu.gyro_bias_instability_rad_per_s, imu.gyro_hourly_walk_rad_per_s) = (0.0, 0.0);
    unit
}

/// Slopes of both encoders over the second half of 8 s at a heading of east, where elevation sees most of the Earth.
fn drifts_rad_per_s(unit: &UnitSettings, gains: &DirectorGains) -> [f64; 2] {
    let angles_rad = [-std::f64::consts::FRAC_PI_2, 0.5];
    let rows = stand(unit, gains, 1, angles_rad, 8.0).expect("the drivers open their twins");
    let first = rows[rows.len() / 2];
    let last = rows[rows.len() - 1];
    [0, 1].map(|k| (last.encoder_rad[k] - first.encoder_rad[k]) / (last.time_s - first.time_s))
}

/// The rate loops null what the gyros read less the Earth: what is left is the bias, 0.5 to 1 µrad/s, against the
/// Earth's 46.9 (azimuth) and 55.9 µrad/s (elevation). In presliding the bristles want a torque that grows by σ0 per
/// angle, for which the integral needs an error: the axis creeps at 1/(1 + σ0/Ki) of the bias.
#[test]
fn axes_that_stand_by_their_gyros_drift_by_the_bias_and_not_with_the_earth() {
    let gains = shipped::gains();
    let unit = biased();
    let mount = controllers::line_of_sight::ImuMount::new(gains.elevation_sign);
    let bias = mount.axis_rates(unit.imu.gyro_bias_rad_per_s, 0.5);
    let creep = |axis: &sim_devices::unit::AxisSettings, gains: &controllers::AxisGains| {
        1.0 / (1.0 + axis.bristle_stiffness_nm_per_rad / gains.velocity_ki_nm_per_rad)
    };
    let expected =
        [-bias.az_rad_per_s * creep(&unit.az, &gains.az), -bias.el_rad_per_s * creep(&unit.el, &gains.el)];
    let found = drifts_rad_per_s(&unit, &gains);
    let near = |k: usize| (found[k] - expected[k]).abs() < 0.1e-6;
    assert!(near(0) && near(1), "{found:?} instead of {expected:?}");
}

/// The sign of either compensation turned round: the axes run away with twice the rate of the Earth, less the creep.
#[test]
fn a_wrong_sign_of_the_earth_shows_in_either_axis() {
    let gains = shipped::gains();
    let unit = biased();
    let mut south = gains;
    south.earth.latitude_rad = -gains.earth.latitude_rad;
    let found = drifts_rad_per_s(&unit, &south);
    assert!(found[0].abs() > 60e-6 && found[1].abs() < 3e-6, "{found:?}");
    let mut west = gains;
    west.earth.azimuth_zero_heading_rad += std::f64::consts::PI;
    let found = drifts_rad_per_s(&unit, &west);
    assert!(found[1].abs() > 80e-6 && found[0].abs() < 3e-6, "{found:?}");
}
