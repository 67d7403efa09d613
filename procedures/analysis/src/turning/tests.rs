use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

const PERIOD_S: f64 = 2e-3;
const DELAY_S: f64 = 1.3e-3;

/// A swinging axis, means over periods: rate, angle, and the rate as gyros show it later.
fn swing(count: usize) -> [Vec<f64>; 3] {
    let angle = |t: f64| 0.3 * (1.1 * t).sin() + 0.05 * (2.9 * t).cos();
    let mean = |t: f64| (angle(t) - angle(t - PERIOD_S)) / PERIOD_S;
    let time: Vec<f64> = (0..count).map(|k| k as f64 * PERIOD_S).collect();
    let rate = time.iter().map(|t| mean(*t)).collect();
    let at = time.iter().map(|t| angle(t - 0.5 * PERIOD_S)).collect();
    let late = time.iter().map(|t| mean(t - DELAY_S)).collect();
    [rate, at, late]
}

fn noise(seed: u64, count: usize, sd: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (f64::from(random.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0);
    (0..count)
        .map(|_| sd * (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos())
        .collect()
}

fn seen(truth: [f64; 3], seed: u64) -> Turning {
    let [rate, angle, late] = swing(10_000);
    let rates: Vec<Vec<f64>> = (0..3)
        .map(|k| {
            let noise = noise(3 * seed + k as u64, late.len(), 1e-4);
            // The Earth's rate along a turning direction.
            let earth = angle.iter().map(|a| 5e-5 * (a + k as f64).sin());
            late.iter().zip(noise).zip(earth).map(|((w, n), e)| truth[k] * w + n + e).collect()
        })
        .collect();
    Turning::new([&rates[0], &rates[1], &rates[2]], &rate, &angle, PERIOD_S).expect("it swings both ways")
}

#[test]
fn scale_direction_and_delay_come_out_within_their_uncertainties() {
    let truth = [1.5e-4, 0.8 * (1.0 + 5e-5), 0.6 * (1.0 + 5e-5)];
    let mut scale = 0;
    let mut off = 0;
    let mut late = 0;
    for seed in 0..40 {
        let found = seen(truth, seed);
        let (error, u) = found.scale_error();
        let (angle, angle_u) = found.angle_from_rad([0.0, 0.8, 0.6]);
        assert!((error - 5e-5).abs() < 5.0 * u && u < 2e-5, "{error} {u}");
        assert!((angle - 1.5e-4).abs() < 5.0 * angle_u && angle_u < 2e-5, "{angle} {angle_u}");
        assert!(
            (found.delay_s - DELAY_S).abs() < 5.0 * found.delay_u_s && found.delay_u_s < 2e-5,
            "{found:?}"
        );
        scale += usize::from((error - 5e-5).abs() < 2.0 * u);
        off += usize::from((angle - 1.5e-4).abs() < 2.0 * angle_u);
        late += usize::from((found.delay_s - DELAY_S).abs() < 2.0 * found.delay_u_s);
    }
    assert!(scale >= 35 && off >= 35 && late >= 35, "{scale} {off} {late} of 40 within 2 u");
}

/// Rates beyond a structure of 10 Hz: Ω·(1 + (ω/ω₁)²) at motion of ω.
#[test]
fn flexure_between_encoder_and_gyros_does_not_read_as_scale() {
    let [rate, angle, late] = swing(10_000);
    let stiffness_s2 = (std::f64::consts::TAU * 10.0).powi(-2);
    let jerk = |k: usize| (late[k + 1] - 2.0 * late[k] + late[k - 1]) / (PERIOD_S * PERIOD_S);
    let jerk: Vec<f64> = (0..late.len()).map(|k| jerk(k.clamp(1, late.len() - 2))).collect();
    for seed in 0..20 {
        let noise = noise(100 + seed, late.len(), 1e-4);
        let bent: Vec<f64> =
            late.iter().zip(&jerk).zip(noise).map(|((w, j), n)| w - stiffness_s2 * j + n).collect();
        let still = vec![0.0; bent.len()];
        let found = Turning::new([&still, &bent, &still], &rate, &angle, PERIOD_S).expect("it turns");
        let (error, u) = found.scale_error();
        assert!(error.abs() < 4.0 * u && u < 2e-5, "{error} {u}");
        assert!((found.delay_s - DELAY_S).abs() < 5.0 * found.delay_u_s, "{found:?}");
    }
}

#[test]
fn a_wrong_sign_and_a_wrong_mapping_are_angles_not_scales() {
    let opposite = seen([0.0, -0.8, -0.6], 1);
    assert!((opposite.angle_from_rad([0.0, 0.8, 0.6]).0 - std::f64::consts::PI).abs() < 1e-3);
    assert!(opposite.scale_error().0.abs() < 1e-4 && (opposite.delay_s - DELAY_S).abs() < 1e-4);
    // The term in sin(el) with the other sign: off by twice the elevation.
    let mirrored = seen([0.0, 0.8, -0.6], 2).angle_from_rad([0.0, 0.8, 0.6]).0;
    assert!((mirrored - 2.0 * 0.6_f64.asin()).abs() < 1e-3, "{mirrored}");
}

#[test]
fn motion_that_does_not_tell_is_refused() {
    let [rate, angle, late] = swing(2000);
    let still = noise(9, 2000, 1e-4);
    let nothing = Turning::new([&still, &still, &still], &rate, &angle, PERIOD_S);
    assert_eq!(nothing, Err(TurningError::Nothing));
    let steady = vec![0.1; 2000];
    let found = Turning::new([&late, &late, &late], &steady, &angle, PERIOD_S);
    assert!(matches!(found, Err(TurningError::Fit(_))), "{found:?}");
    let short = Turning::new([&late[..50]; 3], &rate[..50], &angle[..50], PERIOD_S);
    assert_eq!(short, Err(TurningError::TooFew { found: 50, least: 100 }));
    let uneven = Turning::new([&late, &late, &late[1..]], &rate, &angle, PERIOD_S);
    assert_eq!(uneven, Err(TurningError::Length { expected: 2000, found: 1999 }));
}
