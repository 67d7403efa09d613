use super::*;

/// Largest velocity and acceleration, and largest error of both against differences of the setpoints.
fn walk(stimulus: &Stimulus, start_rad: f64) -> ([f64; 2], [f64; 2]) {
    const H: f64 = 1e-4;
    let prepared = stimulus.prepare(start_rad);
    let mut most = [0.0_f64; 2];
    let mut off = [0.0_f64; 2];
    let lasts_s = stimulus.duration_s(start_rad).expect("an end");
    for k in 0..(lasts_s / H) as u32 {
        let [before, now, after] = [-1.0, 0.0, 1.0].map(|d| prepared.at((f64::from(k) + d) * H));
        most = [most[0].max(now.velocity_rad_per_s.abs()), most[1].max(now.acceleration_rad_per_s2.abs())];
        let rate = (after.position_rad - before.position_rad) / (2.0 * H);
        let acceleration = (after.velocity_rad_per_s - before.velocity_rad_per_s) / (2.0 * H);
        off = [
            off[0].max((rate - now.velocity_rad_per_s).abs()),
            off[1].max((acceleration - now.acceleration_rad_per_s2).abs()),
        ];
    }
    (most, off)
}

#[test]
fn a_sine_begins_and_ends_at_rest_and_stays_inside_its_envelope() {
    let sine = Stimulus::Sine { amplitude_rad: 0.02, frequency_hz: 0.5, cycles: 6, fade_s: 2.0 };
    let (most, off) = walk(&sine, 0.3);
    let reach = sine.envelope(&Envelope::at(0.3), 20.0);
    assert!(off[0] < 1e-6 && off[1] < 1e-3, "{off:?}");
    assert!(most[0] <= reach.velocity_rad_per_s && most[0] > 0.02 * std::f64::consts::PI * 0.999);
    assert!(most[1] <= reach.acceleration_rad_per_s2);
    assert!((reach.position_rad[0] - 0.28).abs() < 1e-12 && (reach.position_rad[1] - 0.32).abs() < 1e-12);
    for t in [0.0, 12.0, 30.0] {
        assert_eq!(sine.at(0.3, t), Setpoint { position_rad: 0.3, ..Setpoint::default() });
    }
}

#[test]
fn a_trajectory_passes_its_places_without_a_jump_of_acceleration() {
    let times = [0.0, 1.0, 2.5, 4.0];
    let places = [0.1, 0.2, -0.1, 0.0];
    let path = Stimulus::Trajectory { knots: knots(&times, &places).expect("a path") };
    for (t, place) in times.iter().zip(places) {
        assert!((path.at(9.0, *t).position_rad - place).abs() < 1e-12);
    }
    let (most, off) = walk(&path, 0.1);
    // At rest before it begins: the acceleration itself may begin at once, like that of a drive.
    assert!(off[0] < 1e-4, "{off:?}");
    for t in [1.0, 2.5] {
        let [before, after] = [-1e-7, 1e-7].map(|d| path.at(0.1, t + d).acceleration_rad_per_s2);
        assert!((before - after).abs() < 1e-5, "{before} {after}");
    }
    let reach = path.envelope(&Envelope::at(0.1), 4.0);
    assert!(most[0] <= 1.001 * reach.velocity_rad_per_s && most[1] <= 1.001 * reach.acceleration_rad_per_s2);
    assert!(
        path.at(0.1, 0.0).velocity_rad_per_s == 0.0 && path.at(0.1, 4.0).velocity_rad_per_s.abs() < 1e-12
    );
}

#[test]
fn a_path_that_jumps_or_goes_back_in_time_is_refused() {
    let jump = knots(&[0.0, 1.0, 1.0, 2.0], &[0.0, 0.1, 0.2, 0.2]).expect_err("two places at 1 s");
    assert!(matches!(jump, KnotsError::Jump { .. }), "{jump}");
    assert!(matches!(knots(&[0.0, 2.0, 1.0], &[0.0; 3]), Err(KnotsError::Order { .. })));
    assert!(matches!(knots(&[0.5, 1.0], &[0.0; 2]), Err(KnotsError::Order { .. })));
    assert!(matches!(knots(&[0.0, f64::NAN], &[0.0; 2]), Err(KnotsError::Order { .. })));
    assert!(matches!(knots(&[0.0], &[0.0]), Err(KnotsError::Count { .. })));
    assert!(matches!(knots(&[0.0, 1.0], &[0.0]), Err(KnotsError::Count { .. })));
}

#[test]
fn a_step_asks_for_what_the_position_loop_makes_of_it() {
    let step = Stimulus::Step { target_rad: 0.01 };
    assert_eq!(step.at(0.0, 0.0).position_rad, 0.01);
    let reach = step.envelope(&Envelope::at(0.0), 2.0);
    assert!((reach.velocity_rad_per_s - 0.05).abs() < 1e-12 && reach.acceleration_rad_per_s2 > 1.0);
    assert!((reach.position_rad[1] - 0.011).abs() < 1e-12 && reach.position_rad[0] <= 0.0);
}

/// Erratum E12: a move of constant acceleration and braking over θ within t takes α = 4θ/t².
#[test]
fn a_triangular_move_takes_four_times_the_angle_over_the_square_of_its_time() {
    let limits =
        ProfileLimits { velocity_rad_per_s: 100.0, acceleration_rad_per_s2: 1.5, jerk_rad_per_s3: 1e7 };
    let duration_s = Profile::new(2.0, &limits).duration_s();
    assert!((4.0 * 2.0 / (duration_s * duration_s) - 1.5).abs() < 1e-5, "{duration_s}");
}
