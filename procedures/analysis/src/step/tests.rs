use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

const SETTINGS: StepSettings = StepSettings { band_ratio: 0.02, tail_s: 0.5, floor: 3e-6 };
const HEIGHT: f64 = 0.01;

fn times() -> Vec<f64> {
    (0..2000).map(|k| f64::from(k) * 2e-3).collect()
}

/// A response of second order with damping ζ, at 10 rad/s.
fn second_order(damping: f64) -> Vec<f64> {
    let omega = 10.0;
    let damped = 10.0 * (1.0 - damping * damping).sqrt();
    let phase = (damping * omega / damped).atan();
    let value = |t: f64| 1.0 - (-damping * omega * t).exp() * (damped * t - phase).cos() / phase.cos();
    times().iter().map(|&t| HEIGHT * value(t)).collect()
}

fn noisy(clean: &[f64], deviation: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = move || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    clean.iter().map(|v| v + deviation * normal()).collect()
}

#[test]
fn a_first_order_response_has_the_textbook_times_and_no_overshoot() {
    // 1 − e^(−4.5 t): ln 9/4.5 s from 10 % to 90 %, ln 50/4.5 s to 2 %.
    let clean: Vec<f64> = times().iter().map(|t| HEIGHT * (1.0 - (-4.5 * t).exp())).collect();
    let found = step_response(&times(), &[&clean], HEIGHT, &SETTINGS).expect("a step");
    assert!((found.rise_s - 9.0_f64.ln() / 4.5).abs() < 1e-4, "{}", found.rise_s);
    assert!((found.settling_s - 50.0_f64.ln() / 4.5).abs() < 1e-3, "{}", found.settling_s);
    assert!(found.overshoot < 1e-9 && found.threshold == 3e-6);
    assert!((found.final_value - HEIGHT).abs() < 1e-8);
}

#[test]
fn overshoot_of_a_weakly_damped_response_is_that_of_the_formula_in_both_directions() {
    let clean = second_order(0.6);
    let expected = HEIGHT * (-0.6 * std::f64::consts::PI / 0.8_f64).exp();
    let down: Vec<f64> = clean.iter().map(|v| -v).collect();
    for (record, height) in [(&clean, HEIGHT), (&down, -HEIGHT)] {
        let found = step_response(&times(), &[record], height, &SETTINGS).expect("a step");
        assert!((found.overshoot - expected).abs() < 1e-6, "{} of {expected}", found.overshoot);
        assert!((found.final_value - height).abs() < 1e-7);
    }
}

/// Five repeats, whose overshoots differ by far more than the noise: 95 % intervals with four degrees of freedom hold the true
/// mean in 91 % to 99 % of 400 draws (3 standard deviations of the binomial are 3.3 %).
#[test]
fn overshoots_that_scatter_from_repeat_to_repeat_are_covered_by_their_interval() {
    const T_95: f64 = 2.776;
    let (true_one, scatter, deviation) = (HEIGHT * 4e-3, HEIGHT * 1e-3, HEIGHT * 1e-4);
    let flat: Vec<f64> = times().iter().map(|t| HEIGHT * (1.0 - (-4.5 * t).exp())).collect();
    let mut held = 0;
    for draw in 0..400 {
        let sizes = noisy(&[true_one; 5], scatter, 7_000 + draw);
        let record = |(k, size): (u64, &f64)| {
            let bump = |t: f64| size * (-((t - 1.4) / 0.2).powi(2)).exp();
            let over: Vec<f64> = flat.iter().zip(times()).map(|(v, t)| v + bump(t)).collect();
            noisy(&over, deviation, 5 * draw + k)
        };
        let records: Vec<Vec<f64>> = (0..).zip(&sizes).map(record).collect();
        let all: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
        let found = step_response(&times(), &all, HEIGHT, &SETTINGS).expect("a step");
        // What the step itself still lacks at the peak of the bump.
        let lacks = HEIGHT * (-4.5 * 1.4_f64).exp();
        held += u32::from((found.overshoot + lacks - true_one).abs() <= T_95 * found.overshoot_u);
    }
    assert!((364..=396).contains(&held), "{held} of 400");
}

#[test]
fn noise_alone_is_no_overshoot_and_a_small_true_one_is_found_under_it() {
    let (flat, deviation): (Vec<f64>, f64) =
        (times().iter().map(|t| HEIGHT * (1.0 - (-4.5 * t).exp())).collect(), 2e-6);
    let mut called = 0;
    for seed in 0..40 {
        let records: Vec<Vec<f64>> = (0..6).map(|k| noisy(&flat, deviation, 100 * seed + k)).collect();
        let all: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
        let found = step_response(&times(), &all, HEIGHT, &SETTINGS).expect("a step");
        assert!((found.noise - deviation).abs() < 0.1 * deviation, "{}", found.noise);
        assert!((found.rise_s - 9.0_f64.ln() / 4.5).abs() < 5.0 * found.rise_u_s.max(1e-3));
        called += u32::from(found.overshoot > found.threshold);
    }
    assert_eq!(called, 0, "of 40");
    let true_one = HEIGHT * 2e-3;
    let bump = |t: f64| true_one * (-((t - 1.4) / 0.2).powi(2)).exp();
    let over: Vec<f64> = flat.iter().zip(times()).map(|(v, t)| v + bump(t)).collect();
    let records: Vec<Vec<f64>> = (0..6).map(|k| noisy(&over, deviation, k)).collect();
    let all: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
    let found = step_response(&times(), &all, HEIGHT, &SETTINGS).expect("a step");
    assert!(found.overshoot > found.threshold, "{} of {}", found.overshoot, found.threshold);
}

#[test]
fn what_is_no_step_is_refused_in_words() {
    let still = vec![1e-7; 2000];
    let error = step_response(&times(), &[&still], HEIGHT, &SETTINGS).expect_err("it did not move");
    assert!(matches!(error, StepError::NoStep { .. }), "{error}");
    let slow: Vec<f64> = times().iter().map(|t| HEIGHT * (1.0 - (-0.8 * t).exp())).collect();
    let error = step_response(&times(), &[&slow], HEIGHT, &SETTINGS).expect_err("it creeps");
    assert!(matches!(error, StepError::NotSettled { .. }), "{error}");
    let broken = vec![f64::NAN; 2000];
    assert_eq!(step_response(&times(), &[&broken], HEIGHT, &SETTINGS), Err(StepError::NotANumber));
    assert!(matches!(
        step_response(&times(), &[&still[..9]], HEIGHT, &SETTINGS),
        Err(StepError::Shape(9, 2000))
    ));
    assert!(matches!(step_response(&[], &[], HEIGHT, &SETTINGS), Err(StepError::Shape(..))));
}
