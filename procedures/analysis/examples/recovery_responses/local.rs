//! Row 5: a lightly damped mode under random excitation, few lines in its bandwidth.

use analysis::frf::{C64, Line};
use analysis::periodic::{LocalModel, lpm};
use nalgebra::Complex;
use rayon::prelude::*;

use super::Row;
use super::plant::{Mode, Noise};

const RATE_HZ: f64 = 1000.0;
const MODE: Mode = Mode { natural_hz: 120.0, zeta: 0.01 };
/// 0.48 Hz a line, a fifth of the 3 dB bandwidth.
const LENGTH: usize = 2083;
/// Noise of the output, 1 % of the plant's rms: 40 dB.
const NOISE: f64 = 0.035;

/// Input and output of a record that begins and ends in motion.
fn record(seed: u64, length: usize) -> [Vec<f64>; 2] {
    let mut noise = Noise::new(seed);
    let input: Vec<f64> = (0..length + 2000).map(|_| noise.normal()).collect();
    let output: Vec<f64> = MODE.run(&input, RATE_HZ).iter().map(|v| v + NOISE * noise.normal()).collect();
    [input[2000..].to_vec(), output[2000..].to_vec()]
}

fn truth(frequency_hz: f64) -> C64 {
    MODE.sampled_at(frequency_hz, RATE_HZ)
}

fn nearest(frf: &[Line]) -> Line {
    let far = |l: &Line| (l.frequency_hz - MODE.natural_hz).abs();
    *frf.iter().min_by(|a, b| far(a).total_cmp(&far(b))).expect("lines in the band")
}

struct Found {
    /// |mean Ĝ/G − 1| at the peak, %.
    bias: f64,
    /// rms of Ĝ/G − 1 there, %.
    rms: f64,
    /// 95 % circles that hold the truth, %.
    covered: f64,
}

fn study(seeds: u64, model: LocalModel, length: usize) -> Found {
    let lines: Vec<Line> = (1..=seeds)
        .into_par_iter()
        .map(|seed| {
            let [input, output] = record(seed, length);
            nearest(&lpm(&input, &output, RATE_HZ, &(118.0..=122.0), model).expect("a record"))
        })
        .collect();
    let n = seeds as f64;
    let error = |l: &Line| l.value / truth(l.frequency_hz) - 1.0;
    let inside =
        lines.iter().filter(|l| (l.value - truth(l.frequency_hz)).norm() <= l.circle_radius(0.95)).count();
    Found {
        bias: 100.0 * (lines.iter().map(error).sum::<C64>() / n).norm(),
        rms: 100.0 * (lines.iter().map(|l| error(l).norm_sqr()).sum::<f64>() / n).sqrt(),
        covered: 100.0 * inside as f64 / n,
    }
}

/// The usual way: Hann windows of the same resolution, averaged over the seeds; its error of the peak, %.
fn hann(seeds: u64) -> f64 {
    let plan = fourier::forward(LENGTH);
    let bin = (MODE.natural_hz * LENGTH as f64 / RATE_HZ).round() as usize;
    let line = |values: &[f64]| -> Complex<f64> {
        let turn = |i: usize| std::f64::consts::TAU * i as f64 / LENGTH as f64;
        let mut weighed: Vec<f64> =
            values.iter().enumerate().map(|(i, v)| v * (0.5 - 0.5 * turn(i).cos())).collect();
        let mut spectrum = plan.make_output_vec();
        plan.process(&mut weighed, &mut spectrum).expect("lengths of the plan");
        spectrum[bin]
    };
    let products: Vec<(C64, f64)> = (1..=seeds)
        .into_par_iter()
        .map(|seed| {
            let [input, output] = record(seed, LENGTH);
            let u = line(&input);
            let y = line(&output);
            (y * u.conj(), u.norm_sqr())
        })
        .collect();
    let cross: C64 = products.iter().map(|p| p.0).sum();
    let g = cross / products.iter().map(|p| p.1).sum::<f64>();
    100.0 * (g.norm() / truth(bin as f64 * RATE_HZ / LENGTH as f64).norm() - 1.0)
}

pub(crate) fn rows(seeds: u64) -> Vec<Row> {
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let mut rows = vec![Row::new("Hann H1 of the same resolution: error of the peak, %", hann(seeds), free)];
    for n in [3, 4, 6] {
        let found = study(seeds, LocalModel::polynomial(n), LENGTH);
        rows.push(Row::new(&format!("local polynomial, n = {n}: bias of the peak, %"), found.bias, free));
    }
    for n in [4, 6, 8] {
        let found = study(seeds, LocalModel::rational(n), LENGTH);
        let demand = if n == 4 { free } else { [0.0, 2.0] };
        rows.push(Row::new(&format!("local rational, n = {n}: bias of the peak, %"), found.bias, demand));
        rows.push(Row::new("  rms", found.rms, free));
        rows.push(Row::new("  95 % circles that hold the truth, %", found.covered, free));
    }
    let fine = study(seeds, LocalModel::polynomial(4), 4 * LENGTH);
    rows.push(Row::new(
        "local polynomial, n = 4, Δf/B_3dB = 0.05: bias of the peak, %",
        fine.bias,
        [0.0, 2.0],
    ));
    rows
}
