use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

mod noises;
mod tables;

/// Standard normal numbers (Box & Muller).
fn normals(seed: u64, count: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (f64::from(random.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0);
    let mut pair = || {
        let r = (-2.0 * uniform().ln()).sqrt();
        let angle = std::f64::consts::TAU * uniform();
        [r * angle.cos(), r * angle.sin()]
    };
    (0..count.div_ceil(2)).flat_map(|_| pair()).take(count).collect()
}

fn cumulated(values: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    values
        .iter()
        .map(|v| {
            sum += v;
            sum
        })
        .collect()
}

#[test]
fn a_large_mean_and_a_small_scale_cost_no_digits() {
    let noise = normals(2, 200_000);
    let factors = [1, 10, 100, 10_000];
    let plain = Series::from_rate(&noise, 1.0).expect("noise");
    // A turning table at 1 rad/s behind noise of 1e-5: the sum of a day would eat five digits.
    let shifted: Vec<f64> = noise.iter().map(|v| 1.0 + 2.0_f64.powi(-16) * v).collect();
    let shifted = Series::from_rate(&shifted, 1.0).expect("noise");
    let tiny: Vec<f64> = noise.iter().map(|v| 1e-200 * v).collect();
    let tiny = Series::from_rate(&tiny, 1.0).expect("noise");
    let deviation = |series| deviations(series, Statistic::Oadev, &factors).expect("factors that it allows");
    for ((a, b), c) in deviation(&plain).iter().zip(deviation(&shifted)).zip(deviation(&tiny)) {
        assert!((65536.0 * b.deviation / a.deviation - 1.0).abs() < 1e-9, "{a:?} {b:?}");
        assert!((1e200 * c.deviation / a.deviation - 1.0).abs() < 1e-9, "{a:?} {c:?}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let rate = normals(3, 300_001);
    let bits = |threads: usize| -> Vec<u64> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of threads");
        pool.install(|| {
            let series = Series::from_rate(&rate, 1e-3).expect("noise");
            let all =
                [Statistic::Oadev, Statistic::Ohdev, Statistic::Mdev, Statistic::Pdev, Statistic::Totdev];
            let deviation =
                |statistic| deviations(&series, statistic, &[1, 7, 1000, 90_000]).expect("allowed");
            all.into_iter().flat_map(deviation).map(|d| d.deviation.to_bits()).collect()
        })
    };
    assert_eq!(bits(1), bits(2));
    assert_eq!(bits(1), bits(5));
}

#[test]
fn every_factor_that_is_offered_works_and_the_next_is_refused() {
    for rates in [2, 3, 10, 11, 12, 37] {
        let series = Series::from_rate(&normals(4, rates), 1.0).expect("noise");
        for statistic in Statistic::ALL {
            let factors = series.factors(Spacing::All, statistic);
            let found = deviations(&series, statistic, &factors).expect("factors that it allows");
            assert!(found.iter().all(|d| d.deviation.is_finite() && d.terms > 0), "{statistic:?} {rates}");
            let most = statistic.largest_factor(rates);
            let refused = deviations(&series, statistic, &[most + 1]);
            assert_eq!(refused, Err(AllanError::Factor { factor: most + 1, most, rates }), "{statistic:?}");
            assert!(deviations(&series, statistic, &[0]).is_err());
        }
    }
}

#[test]
fn a_record_that_is_no_record_is_refused_in_words() {
    let rate = |values: &[f64]| Series::from_rate(values, 0.5).map(|_| ());
    assert_eq!(rate(&[1.0]), Err(AllanError::TooShort { found: 1, least: 2 }));
    assert_eq!(rate(&[]), Err(AllanError::TooShort { found: 0, least: 2 }));
    assert_eq!(rate(&[1.0, 2.0, f64::NAN, 1.0]), Err(AllanError::NotFinite { index: 2 }));
    assert_eq!(rate(&[1.0, f64::INFINITY]), Err(AllanError::NotFinite { index: 1 }));
    assert_eq!(rate(&[f64::MAX, -f64::MAX]), Err(AllanError::NotFinite { index: 1 }));
    assert_eq!(rate(&[0.3; 100]), Err(AllanError::Constant));
    for period_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = Series::from_rate(&[1.0, 2.0, 1.0], period_s);
        assert!(matches!(found, Err(AllanError::Period { .. })), "{period_s}");
    }
}

/// Means of 40 readings on a grid, written with 32 bits: steps of a fortieth.
fn means_on_grid(seed: u64, count: usize, step: f64) -> Vec<f64> {
    let readings = normals(seed, 40 * count);
    let on_grid = |v: &f64| if step > 0.0 { (v / step).round() * step } else { *v };
    let mean = |own: &[f64]| own.iter().map(|v| 1.5e-4 * on_grid(v)).sum::<f64>() / 40.0;
    readings.chunks_exact(40).map(|own| f64::from(mean(own) as f32)).collect()
}

#[test]
fn steps_far_below_the_noise_and_about_as_large_are_found() {
    for step in [0.005, 0.1, 2.0, 6.0] {
        let found = output_step(&means_on_grid(6, 6000, step));
        let Some(OutputStep::Seen(found)) = found else { panic!("{step}: {found:?}") };
        let expected = 1.5e-4 * step / 40.0;
        assert!((found.value / expected - 1.0).abs() < 1e-6, "{step}: {found:?}");
        assert!((found.value - expected).abs() < 5.0 * found.u, "{step}: {found:?}");
    }
}

#[test]
fn numbers_without_a_step_tell_how_large_it_is_at_most() {
    let found = output_step(&means_on_grid(7, 6000, 0.0));
    let Some(OutputStep::AtMost(most)) = found else { panic!("{found:?}") };
    // Noise of 24e-6, and half of 6000 means within 0.67 of it either way.
    assert!((1e-8..2e-7).contains(&most), "{most}");
    // Two grids side by side are none, and the bound is not below either.
    let mixed = [means_on_grid(8, 3000, 1.0), means_on_grid(9, 3000, 1.03)].concat();
    let found = output_step(&mixed);
    let Some(OutputStep::AtMost(most)) = found else { panic!("{found:?}") };
    assert!(most > 0.9 * 1.5e-4 / 40.0, "{most}");
    for stuck in [vec![1e-5; 1000], vec![], vec![1e-5; 3]] {
        assert_eq!(output_step(&stuck), None);
    }
}

#[test]
fn quanta_and_drift_are_seen() {
    let noise = normals(5, 5000);
    assert_eq!(quantum_of(&noise), None);
    let coarse: Vec<f64> = noise.iter().map(|v| (v * 4.0).round() * 0.25).collect();
    let found = quantum_of(&coarse).expect("a quarter of the noise");
    assert!((found - 0.25).abs() < 1e-12, "{found}");
    assert_eq!(quantum_of(&[1.0; 100]), None);

    let still = drift(&noise, 0.01).expect("a long record");
    assert!(!still.is_significant(), "{still:?}");
    let warming: Vec<f64> = noise.iter().enumerate().map(|(k, v)| v + 1e-4 * k as f64).collect();
    let found = drift(&warming, 0.01).expect("a long record");
    assert!(found.is_significant() && (found.slope_per_s - 0.01).abs() < 4.0 * found.u, "{found:?}");
    assert_eq!(drift(&noise[..10], 0.01), None);
}
