//! Against noises that are known.

use super::*;

/// Rate with a flicker spectrum B²/(π·f) at 1 Hz sampling: the half-integrated white noise of Kasdin (*Proc. IEEE* 83,
/// 802, 1995), by the direct sum.
fn flicker(seed: u64, count: usize, b: f64) -> Vec<f64> {
    let mut weights = vec![1.0; count];
    for k in 1..count {
        weights[k] = weights[k - 1] * (k as f64 - 0.5) / k as f64;
    }
    let white = normals(seed, count);
    // One-sided 2σ²/(2πf) is B²/(πf).
    let filtered = |k: usize| b * (0..=k).map(|j| weights[j] * white[k - j]).sum::<f64>();
    (0..count).map(filtered).collect()
}

#[test]
fn noises_are_told_apart_by_their_neighbours() {
    let white = normals(11, 4096);
    let walk = cumulated(&white);
    let phase: Vec<f64> = white.windows(2).map(|x| x[1] - x[0]).collect();
    let cases = [
        (phase, Noise::WhitePhase),
        (white, Noise::WhiteRate),
        (flicker(12, 4096, 1.0), Noise::FlickerRate),
        (walk.clone(), Noise::WalkRate),
        (cumulated(&walk), Noise::RunRate),
    ];
    for (rate, expected) in cases {
        let series = Series::from_rate(&rate, 1.0).expect("noise");
        let found = identify(&series, &[1, 4, 16, 64]).expect("factors above 0");
        assert!(found.iter().all(|n| *n == expected), "{expected:?}: {found:?}");
    }
}

#[test]
fn white_noise_lies_in_its_interval_as_often_as_it_says() {
    let mut inside = 0;
    let mut all = 0;
    for seed in 0..100 {
        let series = Series::from_rate(&normals(100 + seed, 2000), 1.0).expect("noise");
        for point in bounded(&series, Statistic::Oadev, &[1, 8, 64, 300]).expect("allowed") {
            let [low, high] = point.interval.expect("white noise has one");
            let truth = 1.0 / (point.at.factor as f64).sqrt();
            inside += usize::from((low..high).contains(&truth));
            all += 1;
        }
    }
    assert!((all * 92 / 100..=all * 98 / 100).contains(&inside), "{inside} of {all}");
}

/// Mean and spread of the variances of 300 white records, against 1/m and √(2/ν).
#[test]
fn degrees_of_freedom_are_the_spread_of_the_variances() {
    let cases = [
        (Statistic::Oadev, 50),
        (Statistic::Mdev, 50),
        (Statistic::Ohdev, 50),
        (Statistic::Totdev, 100),
        (Statistic::Mtotdev, 20),
        (Statistic::Htotdev, 20),
        (Statistic::Theo1, 60),
    ];
    for (statistic, m) in cases {
        let squares: Vec<f64> = (0..300)
            .map(|seed| {
                let series = Series::from_rate(&normals(1000 + seed, 300), 1.0).expect("noise");
                deviations(&series, statistic, &[m]).expect("allowed")[0].deviation.powi(2)
            })
            .collect();
        let mean = squares.iter().sum::<f64>() / 300.0;
        let spread = squares.iter().map(|s| (s / mean - 1.0).powi(2)).sum::<f64>() / 299.0;
        let dof = freedom(statistic, Noise::WhiteRate, m, 300).expect("white noise has some");
        assert!((2.0 / spread / dof - 1.0).abs() < 0.35, "{statistic:?}: {dof}, found {}", 2.0 / spread);
        let modified = matches!(statistic, Statistic::Mdev | Statistic::Mtotdev);
        let truth = if modified { 0.5 } else { 1.0 } / statistic.tau_s(m, 1.0);
        let bias = statistic.bias_ratio(Noise::WhiteRate, m, 300).unwrap_or(1.0);
        let u = (2.0 / dof / 300.0).sqrt();
        assert!((mean / truth / bias - 1.0).abs() < 4.0 * u + 0.02, "{statistic:?}: {}", mean / truth);
    }
}

#[test]
fn an_hour_at_100_hz_shows_its_random_walk_and_its_floor() {
    // 100 Hz means of an hour: N = 1, floor from 10 s on, and a slow walk.
    let n = 1.0;
    let b = 0.45;
    let count = 36_000;
    let white = normals(21, count);
    let slow = flicker(22, count / 10, b);
    let rate: Vec<f64> =
        white.iter().enumerate().map(|(k, w)| n * w / 0.1_f64.sqrt() + slow[k / 10]).collect();
    let series = Series::from_rate(&rate, 0.1).expect("noise");
    let factors = series.factors(Spacing::Octave, Statistic::Oadev);
    let deviations = deviations(&series, Statistic::Oadev, &factors).expect("allowed");
    let found = fit(&deviations, series.rates(), 0.1).expect("six averaging times and more");
    let walk = found.random_walk();
    let floor = found.bias_instability();
    assert!((walk.value / n - 1.0).abs() < 0.015, "{walk:?}");
    assert!(walk.is_determined && walk.interval[0] < n && n < walk.interval[1], "{walk:?}");
    assert!((floor.value / b - 1.0).abs() < 0.3, "{floor:?}");
    assert!(floor.interval[0] < b && b < floor.interval[1], "{floor:?}");
    assert!(!found.goodness.is_misfit(), "{found:?}");
}

/// A spectrum of b/f by first-order processes, two a decade, from a period to thirty records.
fn stationary_flicker(seed: u64, count: usize, b: f64) -> Vec<f64> {
    let step = 0.5 * std::f64::consts::LN_10;
    let sd = b * (step / std::f64::consts::PI).sqrt();
    let processes = ((30.0 * count as f64).ln() / step).ceil() as u64 + 1;
    let mut sum = vec![0.0; count];
    for process in 0..processes {
        let keep = (-(-(process as f64) * step).exp()).exp();
        let kicks = normals(1000 * seed + process, count + 1);
        let mut x = sd * kicks[count];
        for (sum, kick) in sum.iter_mut().zip(&kicks) {
            let before = x;
            x = keep * x + sd * (1.0 - keep * keep).sqrt() * kick;
            *sum += 0.5 * (before + x);
        }
    }
    sum
}

/// An hour with a floor from 10 s on; `recovery_allan` does it with 400 seeds and other truths.
#[test]
fn the_floor_lies_in_its_interval_as_often_as_it_says() {
    let b = 0.45;
    let seeds = 100;
    let mut inside = 0;
    let mut square = 0.0;
    for seed in 0..seeds {
        let flicker = stationary_flicker(7000 + seed, 3600, b);
        let rate: Vec<f64> = normals(90_000 + seed, 3600).iter().zip(flicker).map(|(w, f)| w + f).collect();
        let series = Series::from_rate(&rate, 1.0).expect("noise");
        let factors = series.factors(Spacing::Octave, Statistic::Oadev);
        let deviations = deviations(&series, Statistic::Oadev, &factors).expect("allowed");
        let floor = fit(&deviations, 3600, 1.0).expect("many averaging times").bias_instability();
        inside += usize::from(floor.interval[0] <= b && b <= floor.interval[1]);
        square += (floor.value / b - 1.0).powi(2) / seeds as f64;
    }
    assert!((88..=99).contains(&inside), "{inside} of {seeds}");
    assert!(square.sqrt() < 0.2, "{}", square.sqrt());
}

#[test]
fn what_is_not_there_is_not_found() {
    let series = Series::from_rate(&normals(31, 60_000), 0.01).expect("noise");
    let factors = series.factors(Spacing::Octave, Statistic::Oadev);
    let deviations = deviations(&series, Statistic::Oadev, &factors).expect("allowed");
    let found = fit(&deviations, series.rates(), 0.01).expect("many averaging times");
    assert!((found.random_walk().value / 0.1 - 1.0).abs() < 0.02, "{found:?}");
    for absent in [found.bias_instability(), found.rate_walk(), found.ramp()] {
        assert!(!absent.is_determined && absent.interval[0] <= 0.0 && absent.interval[1] > 0.0, "{found:?}");
    }
    let few = fit(&deviations[..4], series.rates(), 0.01);
    assert_eq!(few, Err(AllanError::TooFewTimes { found: 4, least: 6 }));
}
