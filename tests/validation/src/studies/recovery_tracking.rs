//! Root mean squares of synthetic track errors of known spectrum: do their intervals of 95 % cover the truth?
//!
//! `cargo run --release -p validation -- recovery_tracking`

use std::io::Write as _;

use analysis::tracking::rms;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Fixed beforehand.
const SEEDS: u64 = 400;
/// Demand on the share of intervals that cover.
const COVERAGE: std::ops::RangeInclusive<f64> = 0.90..=0.98;

pub(crate) fn study() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    let mut all_covered = true;
    writeln!(out, "samples  tau  resonance  coverage  u found / true")?;
    for (n, tau, resonance) in [
        (6000, 1.0, 0.0),
        (6000, 10.0, 0.0),
        (6000, 30.0, 0.0),
        (24_000, 40.0, 0.0),
        (6000, 10.0, 0.02),
        (6000, 30.0, 0.05),
    ] {
        let (covered, ratio) = table_of(n, tau, resonance)?;
        all_covered &= COVERAGE.contains(&covered);
        writeln!(out, "{n:7} {tau:4.0} {resonance:10.2} {:8.1} % {ratio:8.3}", 100.0 * covered)?;
    }
    writeln!(out, "{}", if all_covered { "as demanded" } else { "NOT as demanded" })?;
    if all_covered { Ok(()) } else { Err("coverage outside 90 to 98 %".into()) }
}

/// Coverage, and the mean of the uncertainty over the scatter that was found.
fn table_of(n: usize, tau: f64, resonance: f64) -> Result<(f64, f64), Box<dyn std::error::Error>> {
    let mut covered = 0;
    let mut u = 0.0;
    let mut scatter = 0.0;
    for seed in 0..SEEDS {
        let found = rms(&errors(n, tau, resonance, seed), seed)?;
        let expanded = StudentsT::new(0.0, 1.0, found.dof)?.inverse_cdf(0.975) * found.u;
        covered += u64::from((found.value - 1.0).abs() <= expanded);
        u += found.u;
        scatter += (found.value - 1.0).powi(2);
    }
    let seeds = SEEDS as f64;
    Ok((covered as f64 / seeds, u / seeds / (scatter / seeds).sqrt()))
}

/// Errors of standard deviation 1 with correlation `exp(−k/τ)·cos(2π·resonance·k)`: real part of a complex first-order
/// process.
fn errors(n: usize, tau: f64, resonance: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(7_000 + seed);
    let mut uniform = || ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let mut normal = || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let phi = (-1.0 / tau).exp();
    let turn = (std::f64::consts::TAU * resonance).sin_cos();
    let push = (1.0 - phi * phi).sqrt();
    let mut state = [normal(), normal()];
    (0..n)
        .map(|_| {
            let [x, y] = state;
            let (sine, cosine) = turn;
            state = [
                phi * (cosine * x - sine * y) + push * normal(),
                phi * (sine * x + cosine * y) + push * normal(),
            ];
            x
        })
        .collect()
}
