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
    let mut covered = 0;
    let mut u = 0.0;
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
    let value = |part: &Result<Rms, TrackingError>| part.as_ref().expect("long enough").value;
    assert!((value(&found.outside) - 1.0).abs() < 0.08, "{found:?}");
    assert!(value(&found.whole) > 3.0 && (found.inside_ratio - 0.025).abs() < 1e-12, "{found:?}");
    assert!(found.percentile_999 > 30.0 && found.peak_to_peak > 60.0, "{found:?}");
}

#[test]
fn ranks_and_squares_of_a_record_worked_by_hand() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let errors: Vec<f64> = (0..1000).map(|_| if random.next_u64() % 2 == 0 { 3.0 } else { -4.0 }).collect();
    let threes = errors.iter().filter(|e| **e > 0.0).count() as f64;
    let found = summarise(&errors, &[false; 1000], 1).expect("long enough");
    let expected = ((9.0 * threes + 16.0 * (1000.0 - threes)) / 1000.0).sqrt();
    let whole = found.whole.as_ref().expect("long enough");
    assert!((whole.value - expected).abs() < 1e-12 && found.whole == found.outside);
    let mean = (3.0 * threes - 4.0 * (1000.0 - threes)) / 1000.0;
    assert!((found.mean - mean).abs() < 1e-12 && found.largest == 4.0 && found.percentile_999_u == 0.0);
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
    assert_eq!(summarise(&[], &[], 1), Err(TrackingError::TooShort { samples: 0, blocks: 0 }));
    assert_eq!(summarise(&[f64::INFINITY; 9], &[false; 9], 1), Err(TrackingError::NotFinite(0)));
}

/// One swing is no record of its own, but the windows leave nothing of it.
#[test]
fn a_record_that_one_swing_governs_has_a_number_outside_it() {
    let mut errors = correlated(3000, 1.0, 8);
    let swing = |k: usize| 400.0 * ((k as f64 - 1000.0) / 900.0 * std::f64::consts::PI).sin();
    (1000..1900).for_each(|k| errors[k] += swing(k));
    let inside: Vec<bool> = (0..3000).map(|k| (1000..1900).contains(&k)).collect();
    let found = summarise(&errors, &inside, 1).expect("numbers");
    assert!((found.outside.expect("long enough").value - 1.0).abs() < 0.1);
    assert!(found.largest > 390.0 && (found.inside_ratio - 0.3).abs() < 1e-12);
}

/// A step of the rate at 5 s, known to 0.1 s; the windows are declared from 0.5 s before to 1 s after.
#[test]
fn windows_open_where_the_acceleration_is_beyond_the_threshold_and_merge() {
    let time: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
    let pulse =
        |from: f64, to: f64| time.iter().map(move |t| if (from..to).contains(t) { -3.0 } else { 0.1 });
    let one: Vec<f64> = pulse(5.0, 5.1).collect();
    let windows = opened(&time, &one, 2.0, 0.5, 1.0);
    assert_eq!(windows.len(), 1);
    assert!((windows[0][0] - 4.5).abs() < 0.021 && (windows[0][1] - 6.08).abs() < 0.021, "{windows:?}");
    let two: Vec<f64> = pulse(5.0, 5.1).zip(pulse(6.2, 6.3)).map(|(a, b): (f64, f64)| a.min(b)).collect();
    assert_eq!(opened(&time, &two, 2.0, 0.5, 1.0).len(), 1, "windows that touch are one");
    assert_eq!(opened(&time, &two, 4.0, 0.5, 1.0), Vec::<[f64; 2]>::new());
}

#[test]
fn a_dwell_is_as_long_as_frames_come_and_their_sliding_rms_is_small_on_both_axes() {
    let time: Vec<f64> = (0..4000).map(|k| 0.005 * f64::from(k)).collect();
    let quiet: Vec<f64> = (0..4000).map(|k| if k % 2 == 0 { 3.0 } else { -3.0 }).collect();
    let found = longest_dwell(&time, [&quiet, &quiet], 5.0, 1.0, 0.0175).expect("all of it");
    assert!((found.from_s, found.to_s) == (time[0], time[3999]) && (found.lasts_s() - 20.0).abs() < 0.02);
    // One axis is beyond the limit from 8 s to 9 s.
    let loud: Vec<f64> = time.iter().map(|t| if (8.0..9.0).contains(t) { 20.0 } else { 1.0 }).collect();
    let found = longest_dwell(&time, [&quiet, &loud], 5.0, 1.0, 0.0175).expect("behind it");
    assert!(found.from_s > 8.9 && found.to_s == time[3999], "{found:?}");
    // No frames from 12 s to 12.1 s: the track is not continuous.
    let gap = |t: &f64| !(12.0..12.1).contains(t);
    let (kept, values): (Vec<f64>, Vec<f64>) = time.iter().zip(&quiet).filter(|(t, _)| gap(t)).unzip();
    let found = longest_dwell(&kept, [&values, &values], 5.0, 1.0, 0.0175).expect("before it");
    assert!(found.from_s == 0.0 && (found.to_s - 11.995).abs() < 1e-9, "{found:?}");
    assert_eq!(longest_dwell(&time, [&quiet, &quiet], 2.9, 1.0, 0.0175), None);
    assert_eq!(longest_dwell(&time[..100], [&quiet[..100], &quiet[..100]], 5.0, 1.0, 0.0175), None, "0.5 s");
    assert_eq!(longest_dwell(&time[..10], [&quiet, &quiet], 5.0, 1.0, 0.0175), None, "unequal lengths");
}
