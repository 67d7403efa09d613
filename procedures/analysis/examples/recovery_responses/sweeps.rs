//! Row 6: whole sweeps at any speed, and demodulated slow ones.

use analysis::excitation::{Law, Sweep};
use analysis::frf::Line;
use analysis::periodic::{Demodulation, demodulate, fft_ratio};
use rayon::prelude::*;

use super::Row;
use super::plant::{Mode, Noise};

const RATE_HZ: f64 = 1000.0;
/// 0.02 % of the peak at ζ = 0.01.
const NOISE: f64 = 0.01;

struct Scene {
    mode: Mode,
    sweep: Sweep,
    input: Vec<f64>,
    output: Vec<f64>,
}

/// A mode and a sweep past it, both of them drawn.
fn scene(seed: u64, eta: f64) -> Scene {
    let mut noise = Noise::new(seed);
    let mode = Mode { natural_hz: 100.0 + 40.0 * noise.uniform(), zeta: 0.005 * 4_f64.powf(noise.uniform()) };
    let law = if noise.uniform() < 0.5 { Law::Linear } else { Law::Logarithmic };
    let ends = [0.88 * mode.natural_hz, 1.12 * mode.natural_hz];
    let [from_hz, to_hz] = if noise.uniform() < 0.5 { ends } else { [ends[1], ends[0]] };
    let unit = Sweep { from_hz, to_hz, duration_s: 1.0, law, amplitude: 1.0 };
    let sweep = Sweep { duration_s: unit.eta(mode.zeta, mode.natural_hz) / eta, ..unit };
    // Down to 10⁻⁶ of the end.
    let ring_down_s = 13.8 / (mode.zeta * std::f64::consts::TAU * mode.natural_hz);
    let samples = ((sweep.duration_s + ring_down_s) * RATE_HZ) as usize;
    let input: Vec<f64> = (0..samples).map(|i| sweep.at(i as f64 / RATE_HZ)).collect();
    let output = mode.run(&input, RATE_HZ).iter().map(|v| v + NOISE * noise.normal()).collect();
    Scene { mode, sweep, input, output }
}

/// Highest gain over that of the truth at the same lines, less 1, %.
fn peak_error(frf: &[Line], mode: Mode) -> f64 {
    let highest = |gain: &dyn Fn(&Line) -> f64| frf.iter().map(gain).fold(0.0, f64::max);
    let truth = highest(&|l| mode.sampled_at(l.frequency_hz, RATE_HZ).norm());
    100.0 * (highest(&|l| l.value.norm()) / truth - 1.0)
}

fn whole(seed: u64, eta: f64) -> f64 {
    let scene = scene(seed, eta);
    let f = scene.mode.natural_hz;
    let found = fft_ratio(&[&scene.input], &[&scene.output], RATE_HZ, &(0.95 * f..=1.05 * f));
    peak_error(&found.expect("a whole record").frf, scene.mode)
}

fn demodulated(seed: u64, eta: f64) -> f64 {
    let scene = scene(seed, eta);
    let Mode { natural_hz, zeta } = scene.mode;
    let lines: Vec<f64> = (-100..=100).map(|k| natural_hz * (1.0 + 0.05 * zeta * f64::from(k))).collect();
    let settings = Demodulation { natural_hz, zeta, periods: 8.0 };
    let frf = demodulate(&scene.sweep, &scene.input, &scene.output, RATE_HZ, &lines, settings);
    peak_error(&frf.expect("slow enough"), scene.mode)
}

/// A slow and wide mode: eight periods pass a good part of its bandwidth.
fn wide(seed: u64, eta: f64) -> f64 {
    const SLOW_RATE_HZ: f64 = 50.0;
    let mut noise = Noise::new(seed);
    let mode = Mode { natural_hz: 1.0 + noise.uniform(), zeta: 0.03 + 0.03 * noise.uniform() };
    let f = mode.natural_hz;
    let zeta = mode.zeta;
    let unit = Sweep { from_hz: 0.5 * f, to_hz: 1.5 * f, duration_s: 1.0, law: Law::Linear, amplitude: 1.0 };
    let sweep = Sweep { duration_s: unit.eta(zeta, f) / eta, ..unit };
    let samples = (sweep.duration_s * SLOW_RATE_HZ) as usize;
    let input: Vec<f64> = (0..samples).map(|i| sweep.at(i as f64 / SLOW_RATE_HZ)).collect();
    let output: Vec<f64> =
        mode.run(&input, SLOW_RATE_HZ).iter().map(|v| v + 3.0 + NOISE * noise.normal()).collect();
    let lines: Vec<f64> = (-100..=100).map(|k| f * (1.0 + 0.02 * zeta * f64::from(k))).collect();
    let settings = Demodulation { natural_hz: f, zeta, periods: 8.0 };
    let frf = demodulate(&sweep, &input, &output, SLOW_RATE_HZ, &lines, settings).expect("slow enough");
    let highest = |gain: &dyn Fn(&Line) -> f64| frf.iter().map(gain).fold(0.0, f64::max);
    let truth = highest(&|l| mode.sampled_at(l.frequency_hz, SLOW_RATE_HZ).norm());
    100.0 * (highest(&|l| l.value.norm()) / truth - 1.0)
}

pub(crate) fn rows(seeds: u64) -> Vec<Row> {
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let mut rows = vec![];
    let mut study = |name: &str, eta: f64, limit: f64, of: fn(u64, f64) -> f64| {
        let errors: Vec<f64> = (1..=seeds).into_par_iter().map(|seed| of(seed, eta)).collect();
        let worst = errors.iter().map(|e| e.abs()).fold(0.0, f64::max);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        rows.push(Row::new(&format!("{name}, η = {eta}: mean error of the peak, %"), mean, [-limit, limit]));
        rows.push(Row::new("  worst run", worst, free));
    };
    for eta in [0.1, 0.57, 2.0, 10.0] {
        study("whole record's transforms", eta, 0.3, whole);
    }
    for eta in [0.05, 0.1] {
        study("demodulated", eta, 1.0, demodulated);
        study("demodulated, ζ 0.03 … 0.06 at 1 … 2 Hz", eta, 1.0, wide);
    }
    rows
}
