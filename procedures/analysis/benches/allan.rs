//! Overlapping Allan deviation of 1e7 rates at 48 averaging times, against the formula written down as it stands: phase by
//! a running sum, and for each averaging time an array of second differences and its mean square, on one thread.

use analysis::allan::{Series, Spacing, Statistic, deviations};
use divan::counter::ItemsCount;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

const RATES: usize = 10_000_000;
const TIMES: usize = 48;
const PERIOD_S: f64 = 1e-3;

fn main() {
    divan::main();
}

/// Noise about the rate of the Earth.
fn rates() -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    (0..RATES).map(|_| 7.3e-5 + 1e-4 * (f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5)).collect()
}

fn factors(rate: &[f64]) -> Vec<usize> {
    let series = Series::from_rate(rate, PERIOD_S).expect("noise");
    let dense = series.factors(Spacing::PerDecade(8), Statistic::Oadev);
    assert!(dense.len() >= TIMES, "{}", dense.len());
    dense.into_iter().take(TIMES).collect()
}

#[divan::bench(sample_count = 15, sample_size = 1)]
fn overlapping(bencher: divan::Bencher<'_, '_>) {
    let rate = rates();
    let factors = factors(&rate);
    bencher.counter(ItemsCount::new(RATES * TIMES)).bench_local(|| {
        let series = Series::from_rate(&rate, PERIOD_S).expect("noise");
        deviations(&series, Statistic::Oadev, &factors).expect("factors that it allows")
    });
}

#[divan::bench(sample_count = 2, sample_size = 1)]
fn straightforward(bencher: divan::Bencher<'_, '_>) {
    let rate = rates();
    let factors = factors(&rate);
    bencher.counter(ItemsCount::new(RATES * TIMES)).bench_local(|| written_down(&rate, &factors));
}

fn written_down(rate: &[f64], factors: &[usize]) -> Vec<f64> {
    let mut phase = vec![0.0];
    for y in rate {
        phase.push(phase[phase.len() - 1] + y * PERIOD_S);
    }
    factors
        .iter()
        .map(|&m| {
            let starts = phase.iter().zip(&phase[m..]).zip(&phase[2 * m..]);
            let differences: Vec<f64> = starts.map(|((a, b), c)| c - 2.0 * b + a).collect();
            let square = differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64;
            (square / 2.0).sqrt() / (m as f64 * PERIOD_S)
        })
        .collect()
}
