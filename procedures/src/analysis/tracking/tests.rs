use super::*;

/// Errors of standard deviation 1 with correlation `exp(−k/τ)`, by Box and Muller.
fn correlated(n: usize, tau: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let mut normal = || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let phi = (-1.0 / tau).exp();
    let mut state = normal();
    (0..n)
        .map(|_| {
            let now = state;
            state = phi * state + (1.0 - phi * phi).sqrt() * normal();
            now
        })
        .collect()
}

/// Share of seeds whose interval of 95 % (Student, many blocks: 2.0 to 2.2) covers 1.
fn coverage(n: usize, tau: f64, seeds: u64) -> (f64, f64) {
    let (mut covered, mut u) = (0, 0.0);
    for seed in 0..seeds {
        let found = rms(&correlated(n, tau, 1000 + seed), seed).expect("long enough");
        let k = 1.96 * (1.0 + (1.96 * 1.96 + 1.0) / (4.0 * found.dof));
        covered += u64::from((found.value - 1.0).abs() <= k * found.u);
        u += found.u;
    }
    (covered as f64 / seeds as f64, u / seeds as f64)
}

/// Squares of such errors are correlated by exp(−2k/τ): the mean square of n scatters by √(2τ/n), its root by half of it.
#[test]
fn the_uncertainty_is_that_of_correlated_samples_and_covers() {
    for (n, tau) in [(6000, 1.0), (6000, 10.0), (6000, 30.0)] {
        let (share, u) = coverage(n, tau, 60);
        let phi2 = (-2.0 / tau).exp();
        let expected = 0.5 * (2.0 * (1.0 + phi2) / (1.0 - phi2) / n as f64).sqrt();
        // 60 seeds: four standard deviations below 95 %; the whole number of seeds is the example's.
        assert!(share >= 0.84, "tau {tau}: {share}");
        assert!((u / expected - 1.0).abs() < 0.1, "tau {tau}: {u} against {expected}");
    }
}

#[test]
fn the_same_data_and_seed_give_the_same_bits_and_another_seed_others() {
    let errors = correlated(2000, 5.0, 3);
    assert_eq!(rms(&errors, 7), rms(&errors, 7));
    assert_ne!(rms(&errors, 7).expect("long enough").u, rms(&errors, 8).expect("long enough").u);
}

#[test]
fn windows_declared_beforehand_are_told_apart() {
    let mut errors = correlated(4000, 2.0, 11);
    let inside: Vec<bool> = (0..4000).map(|k| (1000..1100).contains(&k)).collect();
    errors.iter_mut().zip(&inside).filter(|(_, inside)| **inside).for_each(|(e, _)| *e *= 30.0);
    let found = summarise(&errors, &inside, 1).expect("long enough");
    assert!((found.outside.value - 1.0).abs() < 0.08, "{found:?}");
    assert!(found.whole.value > 3.0 && (found.inside_ratio - 0.025).abs() < 1e-12, "{found:?}");
    assert!(found.percentile_999 > 30.0 && found.peak_to_peak > 60.0, "{found:?}");
}

#[test]
fn ranks_and_squares_of_a_record_worked_by_hand() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let errors: Vec<f64> = (0..1000).map(|_| if random.next_u64() % 2 == 0 { 3.0 } else { -4.0 }).collect();
    let threes = errors.iter().filter(|e| **e > 0.0).count() as f64;
    let found = summarise(&errors, &[false; 1000], 1).expect("long enough");
    let expected = ((9.0 * threes + 16.0 * (1000.0 - threes)) / 1000.0).sqrt();
    assert!((found.whole.value - expected).abs() < 1e-12 && found.whole == found.outside);
    assert_eq!((found.percentile_999, found.peak_to_peak, found.inside), (4.0, 7.0, None));
}

#[test]
fn injected_reversal_saturation_and_loss_are_found_and_attributed() {
    let mut errors = correlated(5000, 5.0, 2);
    for (at, size) in [(500, 12.0), (1500, -20.0), (3000, 40.0), (4200, 15.0)] {
        (at..at + 20).for_each(|k| errors[k] = size);
    }
    let happening = |cause, from, to| Happening { cause, from, to };
    let happenings = [
        happening(Cause::Reversal, 480, 560),
        happening(Cause::Reversal, 1480, 1560),
        happening(Cause::Saturation, 1505, 1512),
        happening(Cause::Loss, 2990, 3010),
    ];
    let found: Vec<(usize, Cause)> =
        peaks(&errors, 8.0, 50, &happenings).iter().map(|p| (p.at, p.cause)).collect();
    let expected =
        [(500, Cause::Reversal), (1500, Cause::Saturation), (3000, Cause::Loss), (4200, Cause::Unknown)];
    assert_eq!(found, expected);
}

#[test]
fn bad_input_gives_no_number() {
    assert_eq!(rms(&[1.0, f64::NAN, 2.0], 1), Err(TrackingError::NotFinite(1)));
    assert!(matches!(rms(&[], 1), Err(TrackingError::TooShort { samples: 0, .. })));
    // One slow swing: the record does not say how large the next one is.
    let swing: Vec<f64> = (0..400).map(|k| (f64::from(k) / 400.0 * std::f64::consts::PI).sin()).collect();
    assert!(matches!(rms(&swing, 1), Err(TrackingError::TooShort { .. })));
    let lengths = summarise(&[1.0; 10], &[false; 9], 1);
    assert_eq!(lengths, Err(TrackingError::Lengths { errors: 10, flags: 9 }));
}
