//! Modes over elevation: 20 modes in one response at each of 17 elevations, 600 lines. Ours on the cores there are and
//! on one, and the straightforward version (one thread; it is told all poles to 0.3 % and only has to refine frequency,
//! damping and residues of all modes together, by Levenberg–Marquardt with a QR of the whole Jacobian at each step,
//! without uncertainty).

use std::f64::consts::TAU;

use analysis::frf::{C64, Frf, Line};
use analysis::modal::{Modal, Settings, modes, track};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rayon::prelude::*;

#[path = "modal/straightforward.rs"]
mod straightforward;

const ELEVATIONS: u32 = 17;
const MODES: u32 = 20;
const LINES: u32 = 600;
const MOST_ORDER: usize = 60;

fn main() {
    divan::main();
}

/// Frequencies from 10 Hz on, each 12 % above the one before, drifting with elevation.
fn own_hz(mode: u32, elevation: u32) -> f64 {
    10.0 * 1.12_f64.powi(mode as i32) * (1.0 + 0.002 * f64::from(elevation))
}

/// Modes of ζ 1 %.
fn row(elevation: u32) -> Vec<Frf> {
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(elevation));
    let mut normal = || {
        let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
        (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
    };
    let at = |hz: f64| -> C64 {
        let mode = |k: u32| {
            let x = hz / own_hz(k, elevation);
            C64::new(if k.is_multiple_of(2) { 1.0 } else { -0.7 }, 0.0) / C64::new(1.0 - x * x, 0.02 * x)
        };
        (0..MODES).map(mode).sum()
    };
    let sd = 0.02;
    let line = |k: u32| {
        let hz = 5.0 + 100.0 * f64::from(k) / f64::from(LINES - 1);
        let noise = C64::new(normal(), normal()) * sd / 2_f64.sqrt();
        Line { variance: sd * sd, ..Line::exact(hz, at(hz) + noise) }
    };
    vec![(0..LINES).map(line).collect()]
}

fn rows() -> Vec<Vec<Frf>> {
    (0..ELEVATIONS).map(row).collect()
}

fn ours(rows: &[Vec<Frf>]) -> Vec<Modal> {
    let settings = Settings { most_order: MOST_ORDER, ..Settings::default() };
    let of_row = |frfs: &Vec<Frf>| modes(frfs, &settings).expect("the lines are fine");
    let found: Vec<Modal> = rows.par_iter().map(of_row).collect();
    let full = track(&found).iter().filter(|t| t.steps.len() == ELEVATIONS as usize).count();
    assert_eq!(full, MODES as usize, "all modes are followed over all elevations");
    found
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn twenty_modes_over_seventeen_elevations(bencher: divan::Bencher<'_, '_>) {
    let rows = rows();
    bencher.bench_local(|| ours(&rows));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn twenty_modes_over_seventeen_elevations_on_one_core(bencher: divan::Bencher<'_, '_>) {
    let rows = rows();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    bencher.bench_local(|| pool.install(|| ours(&rows)));
}

#[divan::bench(sample_count = 2, sample_size = 1)]
fn straightforward_twenty_modes_over_seventeen_elevations(bencher: divan::Bencher<'_, '_>) {
    let rows = rows();
    bencher.bench_local(|| {
        for (elevation, frfs) in (0..).zip(&rows) {
            let own: Vec<f64> = (0..MODES).map(|mode| own_hz(mode, elevation)).collect();
            let begin_hz: Vec<f64> = own.iter().map(|hz| 1.003 * hz).collect();
            let found_hz = straightforward::frequencies_hz(&frfs[0], &begin_hz, 0.015);
            for (found, own) in found_hz.iter().zip(&own).filter(|(_, own)| **own < 100.0) {
                assert!((found / own - 1.0).abs() < 1e-3, "{own} Hz at {elevation}: {found_hz:?}");
            }
        }
    });
}
