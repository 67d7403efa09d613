//! One row a quantity: bias, rms, the 95 % quantile of the error, the limit, coverage of 95 % intervals.

use std::f64::consts::TAU;

use analysis::frf::{C64, Line};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Normal numbers.
pub(crate) struct Gauss(ChaCha8Rng);

impl Gauss {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0
    }

    pub(crate) fn next(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }

    /// A measured line: relative standard deviation of the complex value.
    pub(crate) fn line(&mut self, frequency_hz: f64, value: C64, ratio: f64) -> Line {
        let sd = ratio * value.norm();
        let noise = C64::new(self.next(), self.next()) * (sd * 0.5_f64.sqrt());
        Line { variance: sd * sd, ..Line::exact(frequency_hz, value + noise) }
    }
}

/// What is demanded of a quantity.
#[derive(Clone, Copy)]
pub(crate) struct Demand {
    pub(crate) truth: f64,
    /// Largest rms error in the unit of the quantity; infinite where none is demanded.
    pub(crate) rms: f64,
    /// Unit that the columns are printed in.
    pub(crate) unit: f64,
}

/// An estimate of one seed: value, u, degrees of freedom (u ≤ 0: no interval).
pub(crate) type Estimate = Option<[f64; 3]>;

pub(crate) fn head(seeds: u64) {
    println!(
        "{seeds} seeds; coverage of 95 % intervals, demanded 90 … 98 %; a line that misses its demand ends in <<<\n"
    );
    println!(
        "{:<48} {:>10} {:>9} {:>9} {:>9} {:>9} {:>7} {:>6}",
        "quantity", "truth", "bias", "rms", "95 %", "limit", "cover", "missed"
    );
}

/// Runs all seeds in parallel (order kept) and prints a row a quantity.
pub(crate) fn study(rows: &[(String, Demand)], seeds: u64, run: impl Fn(u64) -> Vec<Estimate> + Sync + Send) {
    // A second argument keeps the rows that contain it.
    let wanted = crate::arguments().nth(1).unwrap_or_default();
    if !rows.iter().any(|(name, _)| name.contains(&wanted)) {
        return;
    }
    // A third argument begins with another seed: fresh ones for who doubts that the limits were chosen after seeing these.
    let first = crate::arguments().nth(2).and_then(|n| n.parse().ok()).unwrap_or(0);
    let all: Vec<Vec<Estimate>> = (first..first + seeds).into_par_iter().map(run).collect();
    for (k, (name, demand)) in rows.iter().enumerate() {
        let found: Vec<[f64; 3]> = all.iter().filter_map(|seed| seed[k]).collect();
        print(name, demand, &found, all.len() - found.len());
    }
}

fn print(name: &str, demand: &Demand, found: &[[f64; 3]], missed: usize) {
    let n = found.len().max(1) as f64;
    let mut errors: Vec<f64> = found.iter().map(|e| (e[0] - demand.truth) / demand.unit).collect();
    let bias = errors.iter().sum::<f64>() / n;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    let with_u: Vec<&[f64; 3]> = found.iter().filter(|e| e[1] > 0.0).collect();
    let inside = |e: &&&[f64; 3]| {
        let k = StudentsT::new(0.0, 1.0, e[2].min(1e6)).map_or(2.0, |t| t.inverse_cdf(0.975));
        (e[0] - demand.truth).abs() <= k * e[1]
    };
    let cover = 100.0 * with_u.iter().filter(inside).count() as f64 / with_u.len().max(1) as f64;
    errors.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let most = errors.get((0.95 * n) as usize).map_or(f64::NAN, |e| e.abs());
    let limit = demand.rms / demand.unit;
    let fine = rms <= limit && missed == 0 && (with_u.is_empty() || (90.0..=98.0).contains(&cover));
    println!(
        "{name:<48} {:>10.4} {bias:>9.4} {rms:>9.4} {most:>9.4} {limit:>9.4} {:>7} {missed:>6} {}",
        demand.truth / demand.unit,
        if with_u.is_empty() { "-".to_owned() } else { format!("{cover:.1}") },
        if fine { "" } else { "<<<" }
    );
}
