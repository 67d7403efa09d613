use super::*;

#[test]
fn schroeder_phases_keep_the_peak_well_below_the_sum() {
    let design = Design::log_spaced(100, 14);
    assert_eq!(design.orders, [1, 2, 3, 4, 6, 8, 12, 17, 24, 35, 49, 70, 100]);
    assert!(design.peak_ratio < 0.75 * design.orders.len() as f64, "{}", design.peak_ratio);
}

/// A path and the torque that the bristle model asks for along it, sampled finely.
fn course(sigma0: f64, damping: f64, z_ss: f64, inertia: f64) -> (Vec<f64>, Vec<f64>, Vec<u32>, usize) {
    course_of_share(0.04, sigma0, damping, z_ss, inertia)
}

/// The same with displacements of this share of the bending length.
fn course_of_share(
    share: f64,
    sigma0: f64,
    damping: f64,
    z_ss: f64,
    inertia: f64,
) -> (Vec<f64>, Vec<f64>, Vec<u32>, usize) {
    let design = Design::log_spaced(50, 10);
    let n = 2000;
    let periods = 5;
    let period_s = 10.0;
    let step = period_s / f64::from(n);
    let value = |i: i32| -> f64 {
        let t = f64::from(i) * step;
        let fade = (t / period_s).min(1.0);
        let wave: f64 = design
            .orders
            .iter()
            .zip(&design.phases_rad)
            .map(|(&k, p)| (TAU * f64::from(k) * t / period_s + p).cos() / f64::from(k))
            .sum();
        fade * share * z_ss * wave
    };
    // The blocks of the estimator are coarser than what bends the bristle.
    let x: Vec<f64> = (0..n * periods).map(value).collect();
    let z = bristle(&x, z_ss, 0.0);
    let derivative = |v: &[f64], i: usize| {
        let a = i.saturating_sub(1);
        let b = (i + 1).min(v.len() - 1);
        (v[b] - v[a]) / ((b - a) as f64 * step)
    };
    let velocity: Vec<f64> = (0..x.len()).map(|i| derivative(&x, i)).collect();
    let torque = (0..x.len())
        .map(|i| inertia * derivative(&velocity, i) + sigma0 * z[i] + damping * derivative(&z, i))
        .collect();
    (x, torque, design.orders, n as usize)
}

#[test]
fn stiffness_damping_and_bending_length_come_back_in_spite_of_hysteresis() {
    let z_ss = 210.0 / 90_000.0;
    let (x, torque, orders, n) = course(90_000.0, 16_600.0, z_ss, 1200.0);
    let record = Record {
        x_rad: &x,
        torque_nm: &torque,
        period_blocks: n,
        period_s: 10.0,
        orders: &orders,
        inertia: 1200.0,
        start_nm: 0.0,
    };
    let found = Presliding::new(&record).expect("converges");
    assert!((found.sigma0 / 90_000.0 - 1.0).abs() < 2e-3, "{found:?}");
    assert!((found.damping / 16_600.0 - 1.0).abs() < 3e-3, "{found:?}");
    assert!((found.z_ss_rad / z_ss - 1.0).abs() < 0.05, "{found:?}");
}

#[test]
fn two_periods_are_too_few() {
    let (x, torque, orders, n) = course(90_000.0, 16_600.0, 2e-3, 1200.0);
    let record = Record {
        x_rad: &x[..2 * n],
        torque_nm: &torque[..2 * n],
        period_blocks: n,
        period_s: 10.0,
        orders: &orders,
        inertia: 1200.0,
        start_nm: 0.0,
    };
    assert_eq!(Presliding::new(&record), None);
}

#[test]
fn contacts_of_drawn_units_are_found_from_starts_far_off() {
    // Stiffness, damping, static friction and inertia; displacements of several shares of the bending length.
    let contacts = [
        [53_400.0, 9_660.0, 45.8, 918.0],
        [58_430.0, 7_910.0, 47.0, 950.0],
        [41_700.0, 7_830.0, 50.0, 1000.0],
    ];
    for [sigma0, damping, static_nm, inertia] in contacts {
        for share in [0.002, 0.005, 0.02, 0.1, 0.2] {
            let z_ss = static_nm / sigma0;
            let (x, torque, orders, n) = course_of_share(share, sigma0, damping, z_ss, inertia);
            let record = Record {
                x_rad: &x,
                torque_nm: &torque,
                period_blocks: n,
                period_s: 10.0,
                orders: &orders,
                inertia,
                start_nm: 0.0,
            };
            let found = Presliding::new(&record).unwrap_or_else(|| panic!("{sigma0} at {share}: no fit"));
            assert!((found.sigma0 / sigma0 - 1.0).abs() < 5e-3, "{share}: {found:?}");
            assert!((found.damping / damping - 1.0).abs() < 1e-2, "{share}: {found:?}");
        }
    }
}
