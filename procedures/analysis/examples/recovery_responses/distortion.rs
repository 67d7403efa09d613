//! Row 3: noise and a cubic told apart; and the same without the cubic.

use analysis::excitation::{Grid, Kind, Multisine, Offset, Phases, Selection, Spacing};
use analysis::peaks::median;
use analysis::periodic::{Channel, Projection, Realisation, RobustLine, nonlinear_rms, robust};
use nalgebra::Complex;
use rayon::prelude::*;

use super::Row;
use super::plant::Noise;

const RATE_HZ: f64 = 512.0;
const LENGTH: usize = 512;
const REALISATIONS: usize = 7;
const PERIODS: usize = 4;
const CUBIC: f64 = 0.03;
const NOISE: f64 = 0.2;
/// Noise of which the distortion is a third.
const LOUD: f64 = 0.7;

type C64 = Complex<f64>;
type Lines = Vec<Vec<C64>>;

fn grid() -> Grid {
    let selection =
        Selection { band_hz: 2.0..=60.0, kind: Kind::Full, spacing: Spacing::Every, forbidden_hz: vec![] };
    Grid::new(1.0, Offset::Zero, RATE_HZ, &selection, &mut || 0.0).expect("a sound grid")
}

/// One realisation of rms 1 through the cubic, windows × lines.
fn measured(grid: &Grid, noise: &mut Noise, cubic: f64, sd: f64, periods: usize) -> [Lines; 2] {
    let level = (2.0 / grid.orders.len() as f64).sqrt();
    let phases = Phases::Random(&mut || noise.uniform());
    let multisine = Multisine::new(grid, &|_| level, phases).expect("flat");
    let input: Vec<f64> = (0..LENGTH).map(|i| multisine.at(i as f64 / RATE_HZ)).collect();
    let projection = Projection::new(RATE_HZ, LENGTH, &grid.frequencies_hz()).expect("on the grid");
    let prepared = projection.prepare(&[]).expect("offset and slope");
    let lines =
        |samples: &[f64]| prepared.amplitudes(Channel { name: "record", samples }, 0).expect("a window");
    let u = lines(&input);
    let output = (0..periods)
        .map(|_| {
            let y: Vec<f64> = input.iter().map(|u| u + cubic * u.powi(3) + sd * noise.normal()).collect();
            lines(&y)
        })
        .collect();
    [vec![u; periods], output]
}

/// Scatter of one realisation's response that the cubic makes: 2000 realisations without noise, rms of the lines.
fn truth(grid: &Grid) -> f64 {
    let responses: Vec<Vec<C64>> = (0..2000)
        .into_par_iter()
        .map(|seed| {
            let [u, y] = measured(grid, &mut Noise::new(1_000_000 + seed), CUBIC, 0.0, 1);
            y[0].iter().zip(&u[0]).map(|(y, u)| y / u).collect()
        })
        .collect();
    let n = responses.len() as f64;
    let variance = |l: usize| {
        let mean = responses.iter().map(|r| r[l]).sum::<C64>() / n;
        responses.iter().map(|r| (r[l] - mean).norm_sqr()).sum::<f64>() / (n - 1.0)
    };
    ((0..grid.orders.len()).map(variance).sum::<f64>() / grid.orders.len() as f64).sqrt()
}

fn separated(grid: &Grid, seed: u64, cubic: f64, sd: f64) -> Vec<RobustLine> {
    let mut noise = Noise::new(seed);
    let all: Vec<[Lines; 2]> =
        (0..REALISATIONS).map(|_| measured(grid, &mut noise, cubic, sd, PERIODS)).collect();
    let realisations: Vec<Realisation<'_>> = all.iter().map(|[u, y]| Realisation { u, y }).collect();
    robust(&grid.frequencies_hz(), &realisations).expect("7 realisations")
}

fn rms(lines: &[RobustLine], of: impl Fn(&RobustLine) -> f64) -> f64 {
    (lines.iter().map(of).sum::<f64>() / lines.len() as f64).sqrt()
}

fn flagged(all: &[Vec<RobustLine>]) -> f64 {
    let lines: usize = all.iter().map(Vec::len).sum();
    100.0 * all.iter().flatten().filter(|l| l.is_distorted()).count() as f64 / lines as f64
}

pub(crate) fn rows(seeds: u64) -> Vec<Row> {
    let grid = grid();
    let study = |cubic: f64, sd: f64, from: u64| -> Vec<Vec<RobustLine>> {
        (from..from + seeds).into_par_iter().map(|seed| separated(&grid, seed, cubic, sd)).collect()
    };
    let with = study(CUBIC, NOISE, 1);
    let linear = study(0.0, NOISE, 500_000);
    let below = study(CUBIC, LOUD, 700_000);
    let distortion = truth(&grid);
    let noise_variance = 4.0 * NOISE * NOISE / LENGTH as f64 / PERIODS as f64;
    let noise = (noise_variance * grid.orders.len() as f64 / 2.0).sqrt();
    let ratios = |of: &dyn Fn(&[RobustLine]) -> f64| -> Vec<f64> { with.iter().map(|l| of(l)).collect() };
    let noises = ratios(&|l| rms(l, |l| l.noise_variance * REALISATIONS as f64) / noise);
    let nonlinear = ratios(&|l| rms(l, |l| l.nonlinear_variance) / distortion);
    let within = |r: &[f64], far: f64| {
        100.0 * r.iter().filter(|r| (*r - 1.0).abs() <= far).count() as f64 / r.len() as f64
    };
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let mean_of = |of: &dyn Fn(&[RobustLine]) -> f64| -> f64 {
        (below.iter().map(|l| of(l).powi(2)).sum::<f64>() / seeds as f64).sqrt() / distortion
    };
    vec![
        Row::new("distortion over noise of one realisation, true", distortion / noise, free),
        Row::new(
            "noise sd over truth (rms of the lines), median of the runs",
            median(noises.clone()),
            [0.90, 1.10],
        ),
        Row::new("  runs within 10 %, %", within(&noises, 0.10), [95.0, 100.0]),
        Row::new("distortion sd over truth, median of the runs", median(nonlinear.clone()), [0.80, 1.20]),
        Row::new("  runs within 20 %, %", within(&nonlinear, 0.20), [95.0, 100.0]),
        Row::new("lines flagged with the cubic, %", flagged(&with), free),
        Row::new("lines flagged without it, %", flagged(&linear), [0.0, 5.0]),
        Row::new("distortion over noise, louder noise", distortion * NOISE / (noise * LOUD), free),
        Row::new(
            "  distortion sd over truth, rms of lines and runs",
            mean_of(&|l| nonlinear_rms(l).unwrap_or(0.0)),
            [0.80, 1.20],
        ),
        Row::new("  the same, cut off line by line", mean_of(&|l| rms(l, |l| l.nonlinear_variance)), free),
    ]
}
