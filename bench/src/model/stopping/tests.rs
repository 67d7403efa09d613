use super::*;

/// Azimuth of the simulated rig with the friction of the study.
fn azimuth() -> StopModel {
    StopModel {
        travel_rad: [-160.0, 160.0].map(f64::to_radians),
        soft_limits_rad: [-159.0, 159.0].map(f64::to_radians),
        inertia_kg_m2: 1200.0,
        deceleration_rad_per_s2: 100.0_f64.to_radians(),
        jerk_rad_per_s3: 9000.0_f64.to_radians(),
        reaction_s: 4.5e-3,
        blind_s: 23.5e-3,
        friction: LeastFriction { static_nm: 210.0, coulomb_nm: 167.75, viscous_nm_s_per_rad: 273.6 },
        ..StopModel::default()
    }
}

fn elevation() -> StopModel {
    StopModel {
        travel_rad: [-10.0, 90.0].map(f64::to_radians),
        soft_limits_rad: [-9.5, 89.5].map(f64::to_radians),
        inertia_kg_m2: 975.0,
        loads: Loads { unbalance_nm: 14.0, spring_nm_per_rad: 54.0, spring_rest_rad: 0.0 },
        friction: LeastFriction { static_nm: 43.0, coulomb_nm: 34.5, viscous_nm_s_per_rad: 68.4 },
        ..azimuth()
    }
}

fn deg(angle_rad: f64) -> f64 {
    angle_rad.to_degrees()
}

/// safety.md §1: azimuth coasts 18, 58 and 109 degrees from 20, 40 and 60 degrees per second.
#[test]
fn azimuth_coasts_as_far_as_the_study_says() {
    let model = azimuth();
    for (rate, published) in [(20.0_f64, 18.0), (40.0, 58.0), (60.0, 109.0)] {
        let coast = model.coast(-2.5, rate.to_radians());
        let way = deg(coast.end_rad + 2.5);
        // `J/σ2·(v − T_C/σ2·ln(1 + σ2·v/T_C))`, the closed form for Coulomb and viscous friction.
        let j = 1200.0;
        let t = 167.75;
        let s = 273.6;
        let v = rate.to_radians();
        let exact = deg(j / s * (v - t / s * (1.0 + s * v / t).ln()));
        assert!((way - exact).abs() < 0.02 * exact, "{rate} deg/s: {way} against {exact}");
        assert!((way - published).abs() < 0.1 * published, "{rate} deg/s: {way} against {published}");
        assert_eq!(coast.impact, None);
    }
}

#[test]
fn elevation_at_full_speed_meets_its_stop_with_a_known_energy() {
    let coast = elevation().coast(0.7, 60.0_f64.to_radians());
    let impact = coast.impact.expect("392 degrees of coasting in 100 degrees of travel");
    assert_eq!(coast.end_rad, 90.0_f64.to_radians());
    let energy = 0.5 * 975.0 * impact.speed_rad_per_s * impact.speed_rad_per_s;
    assert!((impact.energy_j - energy).abs() < 1e-9 * energy);
    assert!((200.0..500.0).contains(&impact.energy_j), "{impact:?}");
}

#[test]
fn the_cheap_bound_of_the_energy_is_never_below_the_integration() {
    for model in [azimuth(), elevation()] {
        let [low, high] = model.travel_rad;
        for place in 1..10 {
            let at = low + (high - low) * f64::from(place) / 10.0;
            for rate in [-1.0, -0.3, 0.1, 0.5, 1.0] {
                let energy = model.coast(at, rate).impact.map_or(0.0, |i| i.energy_j);
                let bound = model.coast_energy_bound_j(at, rate);
                assert!(bound >= energy - 1e-3 * energy - 0.1, "{at} {rate}: {bound} < {energy}");
            }
        }
    }
}

#[test]
fn an_axis_that_friction_holds_does_not_swing_and_one_at_a_stretched_spring_does() {
    let model = elevation();
    assert_eq!(model.swing(0.3), None);
    assert!(model.holds_without_torque(0.3));
    // 54 N·m/rad over 90 degrees pulls with 85 N·m: twice the static friction.
    let top = 90.0_f64.to_radians();
    assert!(!model.holds_without_torque(top));
    let swing = model.swing(top).expect("it swings back");
    assert!(swing.to_rad < top && swing.speed_rad_per_s > 0.0, "{swing:?}");
    // Energy: the spring's work is used up by friction where it stops.
    let spring = 27.0 * (top * top - swing.to_rad * swing.to_rad);
    let rest = 14.0 * (swing.to_rad.sin() - top.sin());
    let friction = 34.5 * (top - swing.to_rad);
    assert!(spring + rest - friction > 0.0, "viscous friction takes the rest");
    assert!(deg(swing.to_rad) > 0.0 && deg(swing.to_rad) < 60.0, "{}", deg(swing.to_rad));
}

#[test]
fn a_stop_under_control_is_a_jerk_limited_ramp_after_the_reaction() {
    let model = azimuth();
    let stop = model.controlled(60.0_f64.to_radians());
    // 60²/200 + 60·100/18000 + 60·0.0235 = 19.74 degrees, and the allowance for settling.
    assert!((deg(stop.angle_rad) - (1.02 * 19.743 + 0.05)).abs() < 0.01, "{}", deg(stop.angle_rad));
    assert!((stop.time_s - (0.6 + 100.0 / 9000.0 + 23.5e-3 + 1.5)).abs() < 1e-9);
    assert_eq!(model.controlled(0.0).angle_rad, 0.0);
    let speeds = (1..700).map(|k| f64::from(k) * 1.5e-3);
    let angles: Vec<f64> = speeds.map(|v| model.controlled(v).angle_rad).collect();
    assert!(angles.is_sorted(), "more speed needs more room");
    // What brakes already needs less: the plan that brakes with 90 deg/s² to 0.1 degree before the limit may fly.
    let a = 90.0_f64.to_radians();
    for v in [2.0_f64, 10.0, 20.0, 60.0] {
        let left = (v * v - 20.25) / 180.0 + 0.15 + 0.1;
        let needed = deg(model.controlled_from(v.to_radians(), -a, model.deceleration_rad_per_s2).angle_rad);
        assert!(v < 4.5 || needed < left, "{v} deg/s: {needed} of {left} deg");
    }
}
