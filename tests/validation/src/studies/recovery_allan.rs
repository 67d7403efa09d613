//! Monte-Carlo recovery of the noises of a gyro: truth in, fit of the Allan variance out, against what is demanded.
//!
//! `cargo run --release -p validation -- recovery_allan [seeds]` prints one table over 400 seeds fixed beforehand.
//! Each record lasts an hour. Units are those of a gyro in which N is 1.

use std::f64::consts::{LN_10, PI, TAU};

use analysis::allan::{NoiseFit, NoiseTerm, Series, Spacing, Statistic, deviations, fit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rayon::prelude::*;

const RECORD_S: f64 = 3600.0;

/// What a record is made of.
#[derive(Clone, Copy)]
struct Truth {
    label: &'static str,
    rate_hz: f64,
    /// Random walk, bias instability, rate random walk.
    coefficients: [f64; 3],
    /// Step of the output; 0 for none.
    quantum: f64,
}

const TRUTHS: [Truth; 6] = [
    Truth { label: "white, 100 Hz", rate_hz: 100.0, coefficients: [1.0, 0.0, 0.0], quantum: 0.0 },
    Truth { label: "floor from 10 s, 100 Hz", rate_hz: 100.0, coefficients: [1.0, 0.45, 0.0], quantum: 0.0 },
    Truth { label: "floor from 10 s", rate_hz: 10.0, coefficients: [1.0, 0.45, 0.0], quantum: 0.0 },
    Truth { label: "floor and walk", rate_hz: 10.0, coefficients: [1.0, 0.3, 0.02], quantum: 0.0 },
    Truth { label: "floor from 50 s", rate_hz: 10.0, coefficients: [1.0, 0.2, 0.0], quantum: 0.0 },
    Truth { label: "quantum of the noise", rate_hz: 10.0, coefficients: [1.0, 0.45, 0.0], quantum: 3.0 },
];

pub(crate) fn study() {
    let seeds = crate::arguments().next().and_then(|n| n.parse().ok()).unwrap_or(400);
    println!("{seeds} seeds; demanded: N within 1.5 %, B within 20 % (one sd), coverage 90 to 98 %\n");
    println!("| record | what | truth | mean | sd | mean u | coverage | within 20 % | determined |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for truth in TRUTHS {
        let fits: Vec<NoiseFit> = (0..seeds).into_par_iter().map(|seed| recovered(&truth, seed)).collect();
        // Rounding adds white noise of a twelfth of the step squared to each sample.
        let rounding = truth.quantum.powi(2) / 12.0 / truth.rate_hz;
        let walk = truth.coefficients[0].hypot(rounding.sqrt());
        row(&truth, "N", walk, &fits, NoiseFit::random_walk);
        row(&truth, "B", truth.coefficients[1], &fits, NoiseFit::bias_instability);
        row(&truth, "K", truth.coefficients[2], &fits, NoiseFit::rate_walk);
    }
}

fn row(truth: &Truth, name: &str, value: f64, fits: &[NoiseFit], term: fn(&NoiseFit) -> NoiseTerm) {
    let terms: Vec<NoiseTerm> = fits.iter().map(term).collect();
    let share = |count: usize| 100.0 * count as f64 / terms.len() as f64;
    let mean_of =
        |number: &dyn Fn(&NoiseTerm) -> f64| terms.iter().map(number).sum::<f64>() / terms.len() as f64;
    let mean = mean_of(&|t| t.value);
    let sd = mean_of(&|t| (t.value - mean).powi(2)).sqrt();
    let u = mean_of(&|t| t.u);
    let covered = terms.iter().filter(|t| t.interval[0] <= value && value <= t.interval[1]).count();
    let near = terms.iter().filter(|t| (t.value - value).abs() < 0.2 * value).count();
    let determined = terms.iter().filter(|t| t.is_determined).count();
    println!(
        "| {} | {name} | {value} | {mean:.4} | {sd:.4} | {u:.4} | {:.1} % | {:.0} % | {:.0} % |",
        truth.label,
        share(covered),
        share(near),
        share(determined)
    );
}

fn recovered(truth: &Truth, seed: u64) -> NoiseFit {
    let period_s = 1.0 / truth.rate_hz;
    let series = Series::from_rate(&record(truth, seed), period_s).expect("noise");
    let factors = series.factors(Spacing::Octave, Statistic::Oadev);
    let deviations = deviations(&series, Statistic::Oadev, &factors).expect("factors that it allows");
    fit(&deviations, series.rates(), period_s).expect("an hour has enough averaging times")
}

fn record(truth: &Truth, seed: u64) -> Vec<f64> {
    let period_s = 1.0 / truth.rate_hz;
    let count = (RECORD_S * truth.rate_hz) as usize;
    let [n, b, k] = truth.coefficients;
    let mut random = Normals::new(seed);
    let mut walk = 0.0;
    let mut rate: Vec<f64> = (0..count)
        .map(|_| {
            walk += k * period_s.sqrt() * random.next();
            n / period_s.sqrt() * random.next() + walk
        })
        .collect();
    add_flicker(&mut rate, b, period_s, &mut random);
    if truth.quantum > 0.0 {
        rate.iter_mut().for_each(|y| *y = (*y / truth.quantum).round() * truth.quantum);
    }
    rate
}

/// Adds a one-sided spectrum B²/(π·f): first-order processes, two a decade, whose time constants reach from a period to
/// thirty records, each with the variance B²·ln √10/π; each sample is its mean over the period.
fn add_flicker(rate: &mut [f64], b: f64, period_s: f64, random: &mut Normals) {
    let step = 0.5 * LN_10;
    let sd = b * (step / PI).sqrt();
    let shortest_s = period_s;
    let longest_s = 30.0 * RECORD_S;
    let count = ((longest_s / shortest_s).ln() / step).ceil() as usize + 1;
    for process in 0..count {
        let constant_s = shortest_s * (process as f64 * step).exp();
        // Mean of a process over a period: that of its ends, the better the slower it is.
        let keep = (-period_s / constant_s).exp();
        let kick = sd * (1.0 - keep * keep).sqrt();
        let mut x = sd * random.next();
        for y in rate.iter_mut() {
            let before = x;
            x = keep * x + kick * random.next();
            *y += 0.5 * (before + x);
        }
    }
}

/// Standard normal numbers (Box & Muller).
struct Normals {
    random: ChaCha8Rng,
    spare: Option<f64>,
}

impl Normals {
    fn new(seed: u64) -> Self {
        Self { random: ChaCha8Rng::seed_from_u64(seed), spare: None }
    }

    fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let mut uniform = || (f64::from(self.random.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0);
        let size = (-2.0 * uniform().ln()).sqrt();
        let angle = TAU * uniform();
        self.spare = Some(size * angle.sin());
        size * angle.cos()
    }
}
