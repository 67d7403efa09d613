use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

/// Noise whose samples resemble their neighbours, of standard deviation 1.
fn correlated(n: usize, seed: u64) -> Vec<f64> {
    const KEPT: f64 = 0.95;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = move || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let mut x = normal();
    let fresh = (1.0 - KEPT * KEPT).sqrt();
    (0..n)
        .map(|_| {
            x = KEPT * x + fresh * normal();
            x
        })
        .collect()
}

#[test]
fn a_sine_has_its_textbook_numbers() {
    let sine: Vec<f64> = (0..20_000).map(|k| 3.0 * (f64::from(k) * 0.01).sin()).collect();
    let found = following(&sine, 1000).expect("long enough");
    assert!((found.rms.value - 3.0 / 2.0_f64.sqrt()).abs() < 0.01);
    assert!((found.peak.value - 3.0).abs() < 1e-3 && found.percentile.value <= found.peak.value);
    // |sin| exceeds cos(0.0005·π) for a thousandth of the time.
    assert!((found.percentile.value - 3.0).abs() < 1e-3);
}

#[test]
fn the_spread_of_correlated_errors_is_what_repetition_shows() {
    let all: Vec<Following> =
        (0..60).map(|seed| following(&correlated(6000, seed), 300).expect("long enough")).collect();
    let values: Vec<f64> = all.iter().map(|f| f.rms.value).collect();
    let shown = crate::positioning::deviation(&values).1;
    let told = all.iter().map(|f| f.rms.u).sum::<f64>() / all.len() as f64;
    assert!((0.75..1.25).contains(&(told / shown)), "{told} told, {shown} shown");
    // As if they were independent it would be a sixth of that.
    assert!(told > 3.0 / (2.0 * 6000.0_f64).sqrt());
}

#[test]
fn the_same_record_gives_the_same_bits() {
    let errors = correlated(3000, 1);
    assert_eq!(following(&errors, 200), following(&errors, 200));
}

#[test]
fn a_pure_delay_is_found_and_is_all_of_the_error() {
    // Whole periods: over a part of one the ends of the record would count.
    let tau = 1.5e-3;
    let omega = std::f64::consts::PI;
    let time: Vec<f64> = (0..5000).map(|k| f64::from(k) * 2e-3).collect();
    let errors: Vec<f64> = time.iter().map(|t| (omega * t).sin() - (omega * (t - tau)).sin()).collect();
    let rates: Vec<f64> = time.iter().map(|t| omega * (omega * t).cos()).collect();
    let found = delay(&errors, &rates).expect("it moves");
    assert!((found - tau).abs() < 1e-7, "{found}");
    assert_eq!(delay(&errors, &vec![0.0; 5000]), None);
}

#[test]
fn short_and_broken_records_are_refused() {
    assert_eq!(following(&[1.0; 40], 10), Err(FollowingError::Short { found: 40, block: 10 }));
    assert_eq!(following(&[f64::NAN; 100], 10), Err(FollowingError::NotANumber));
}
