//! Row 1: windows at any start, line offset ½, on a moving axis with cogging, noise on both channels.

use std::f64::consts::TAU;

use analysis::excitation::{Grid, Kind, Multisine, Offset, Phases, Selection, Sine, Spacing};
use analysis::frf::Line;
use analysis::peaks::median;
use analysis::periodic::{Channel, Windows, errors_in_variables, transfer};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;

use super::Row;
use super::plant::{Mode, Noise};

const RATE_HZ: f64 = 500.0;
const LENGTH: usize = 2000;
const WINDOWS: usize = 8;
/// Standard deviation of the noise on input and output samples: 20 to 50 dB a line.
const NOISE: [f64; 2] = [0.3, 0.3];
const COGGING_HZ: f64 = 7.1;

type C64 = Complex<f64>;

fn actuator(f: f64) -> C64 {
    C64::new(1.0, f / 80.0).inv()
}

fn plant(f: f64) -> C64 {
    Mode { natural_hz: 40.0, zeta: 0.03 }.at(f)
}

fn answer(multisine: &Multisine, response: impl Fn(f64) -> C64) -> Multisine {
    let line = |l: &Sine| {
        let g = response(l.frequency_hz);
        Sine { amplitude: l.amplitude * g.norm(), phase_rad: l.phase_rad + g.arg(), ..*l }
    };
    Multisine { lines: multisine.lines.iter().map(line).collect(), ..multisine.clone() }
}

fn excitation() -> Multisine {
    let selection = Selection {
        band_hz: 1.0..=100.0,
        kind: Kind::Full,
        spacing: Spacing::Logarithmic(60),
        forbidden_hz: vec![COGGING_HZ - 0.3..=COGGING_HZ + 0.3],
    };
    let grid = Grid::new(LENGTH as f64 / RATE_HZ, Offset::Half, RATE_HZ, &selection, &mut || 0.0)
        .expect("a sound grid");
    Multisine::new(&grid, &|_| 1.0, Phases::Compressed).expect("flat")
}

/// A record without noise: reference, input, output, and the cogging columns.
struct Clean {
    reference: Vec<f64>,
    input: Vec<f64>,
    output: Vec<f64>,
    cogging: [Vec<f64>; 2],
    windows: Windows,
}

fn clean(multisine: &Multisine) -> Clean {
    let starts: Vec<usize> = (0..WINDOWS).map(|w| 2317 * w + 11).collect();
    let samples = 2317 * WINDOWS;
    let time = |i: usize| i as f64 / RATE_HZ;
    let sampled = |m: &Multisine| -> Vec<f64> { (0..samples).map(|i| m.at(time(i))).collect() };
    // Every second window runs backwards: the cogging's angle turns round.
    let angle = |i: usize| {
        let direction = if (i / 2317).is_multiple_of(2) { 1.0 } else { -1.0 };
        direction * TAU * COGGING_HZ * time(i % 2317)
    };
    let cogging = [f64::cos, f64::sin].map(|f| (0..samples).map(|i| f(angle(i))).collect::<Vec<f64>>());
    let mut input = sampled(&answer(multisine, actuator));
    let mut output = sampled(&answer(multisine, |f| actuator(f) * plant(f)));
    for i in 0..samples {
        input[i] += 2.0 + 1.5 * cogging[1][i];
        output[i] += 30.0 + 0.2 * angle(i) + 0.7 * cogging[0][i];
    }
    let windows = Windows { sample_rate_hz: RATE_HZ, length: LENGTH, starts };
    Clean { reference: sampled(multisine), input, output, cogging, windows }
}

/// Cramér–Rao bound of a line's amplitude, E|·|² per σ², beside offset, slope and cogging: of (XᵀX)⁻¹.
fn amplitude_bound(grid_hz: &[f64]) -> Vec<f64> {
    let time = |i: usize| i as f64 / RATE_HZ;
    let frequencies: Vec<f64> = grid_hz.iter().copied().chain([COGGING_HZ]).collect();
    let design = DMatrix::from_fn(LENGTH, 2 * frequencies.len() + 2, |i, c| match c.checked_sub(2) {
        None if c == 0 => 1.0,
        None => 2.0 * i as f64 / LENGTH as f64 - 1.0,
        Some(k) if k % 2 == 0 => (TAU * frequencies[k / 2] * time(i)).cos(),
        Some(k) => (TAU * frequencies[k / 2] * time(i)).sin(),
    });
    let inverse = design.tr_mul(&design).try_inverse().expect("independent columns");
    (0..grid_hz.len()).map(|k| inverse[(2 * k + 2, 2 * k + 2)] + inverse[(2 * k + 3, 2 * k + 3)]).collect()
}

fn recovered(clean: &Clean, grid_hz: &[f64], seed: u64) -> Vec<Line> {
    let mut noise = Noise::new(seed);
    let mut noisy =
        |values: &[f64], sd: f64| -> Vec<f64> { values.iter().map(|v| v + sd * noise.normal()).collect() };
    let input = noisy(&clean.input, NOISE[0]);
    let output = noisy(&clean.output, NOISE[1]);
    let channels =
        [Channel { name: "current", samples: &input }, Channel { name: "angle", samples: &output }];
    let nuisance: Vec<&[f64]> = clean.cogging.iter().map(Vec::as_slice).collect();
    let z = transfer(&clean.windows, grid_hz, &clean.reference, &channels, &nuisance).expect("a record");
    errors_in_variables(grid_hz, &z[0], &z[1]).expect("8 windows")
}

pub(crate) fn rows(seeds: u64) -> Vec<Row> {
    let multisine = excitation();
    let grid_hz: Vec<f64> = multisine.lines.iter().map(|l| l.frequency_hz).collect();
    let clean = clean(&multisine);
    let all: Vec<Vec<Line>> =
        (1..=seeds).into_par_iter().map(|seed| recovered(&clean, &grid_hz, seed)).collect();
    let bounds = amplitude_bound(&grid_hz);
    let n = seeds as f64;
    let mut ratios = vec![];
    let mut stated = vec![];
    let mut biases = vec![];
    let mut inside = 0;
    for (l, f) in grid_hz.iter().enumerate() {
        let truth = plant(*f);
        let u = actuator(*f).norm_sqr();
        let power = NOISE[1].powi(2) + truth.norm_sqr() * NOISE[0].powi(2);
        let bound = bounds[l] * power / (u * WINDOWS as f64);
        let mean = all.iter().map(|frf| frf[l].value - truth).sum::<C64>() / n;
        let square = all.iter().map(|frf| (frf[l].value - truth - mean).norm_sqr()).sum::<f64>() / (n - 1.0);
        ratios.push(square / bound);
        stated.push(all.iter().map(|frf| frf[l].variance).sum::<f64>() / n / bound);
        biases.push(mean.norm() / bound.sqrt());
        inside +=
            all.iter().filter(|frf| (frf[l].value - truth).norm() <= frf[l].circle_radius(0.95)).count();
    }
    let covered = 100.0 * inside as f64 / (n * grid_hz.len() as f64);
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    vec![
        Row::new("lines", grid_hz.len() as f64, free),
        Row::new("crest factor of the excitation", multisine.crest_factor(), free),
        Row::new("variance over Cramér–Rao bound, median of the lines", median(ratios.clone()), [0.95, 1.10]),
        Row::new("  worst line", ratios.into_iter().fold(0.0, f64::max), free),
        Row::new("stated variance over the bound, median", median(stated), [0.95, 1.10]),
        Row::new("|bias| over sd, median", median(biases), [0.0, 0.15]),
        Row::new("95 % circles that hold the truth, %", covered, [93.5, 96.5]),
    ]
}
