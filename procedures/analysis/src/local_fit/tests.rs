use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

fn times() -> Vec<f64> {
    (0..400).map(|k| 3.0 + f64::from(k) * 1e-3).collect()
}

#[test]
fn a_parabola_gives_its_acceleration_and_a_line_its_rate_exactly() {
    let parabola: Vec<f64> = times().iter().map(|t| 2.0 + 0.3 * t - 0.8 * t * t).collect();
    let found = derivative(&times(), &parabola, 2).expect("a fit");
    assert!((found.value + 1.6).abs() < 1e-9 && found.u < 1e-9);
    let line: Vec<f64> = times().iter().map(|t| 1e3 + 0.7 * t).collect();
    assert!((derivative(&times(), &line, 1).expect("a fit").value - 0.7).abs() < 1e-9);
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    let mut inside = 0;
    for seed in 0..400 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut uniform = move || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
        let noisy: Vec<f64> = times().iter().map(|t| 0.8 * t * t + 1e-4 * normal()).collect();
        let found = derivative(&times(), &noisy, 2).expect("a fit");
        inside += u32::from((found.value - 1.6).abs() <= 1.96 * found.u);
    }
    assert!((364..=392).contains(&inside), "{inside} of 400");
}

#[test]
fn the_largest_rate_is_found_where_it_is() {
    let bump: Vec<f64> = times().iter().map(|t| 0.05 * ((t - 3.2) / 0.02).tanh()).collect();
    let found = largest(&times(), &bump, 1, 9).expect("windows fit");
    assert!((found.value - 2.5).abs() < 0.1, "{}", found.value);
    assert!(largest(&times()[..5], &bump[..5], 1, 9).is_none());
}

#[test]
fn broken_records_give_nothing() {
    let flat = vec![0.0; 400];
    assert!(derivative(&times()[..7], &flat[..7], 1).is_none());
    assert!(derivative(&times(), &vec![f64::NAN; 400], 1).is_none());
    assert!(derivative(&[1.0; 400], &flat, 1).is_none());
    assert!(derivative(&times(), &flat, 3).is_none());
}
