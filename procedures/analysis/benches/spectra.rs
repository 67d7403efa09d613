//! H1 with uncertainty and coherence of two channels, Hann, segments of 8192 at half overlap: ours on the cores
//! there are and on one, and the straightforward version (one thread, a transform per channel and segment,
//! memory taken anew for each).

use analysis::frf::{C64, Frf, Line};
use analysis::spectra::{CrossSpectra, WelchSettings};
use divan::counter::ItemsCount;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

const SEGMENT_SAMPLES: usize = 8192;
const RATE_HZ: f64 = 4000.0;
const SAMPLES: [usize; 2] = [1_000_000, 10_000_000];

fn main() {
    divan::main();
}

/// White input, and an output that follows it with a pole, an offset and noise.
fn record(samples: usize) -> [Vec<f64>; 2] {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
    let x: Vec<f64> = (0..samples).map(|_| uniform()).collect();
    let mut slow = 0.0;
    let y = x.iter().map(|x| {
        slow = 0.9 * slow + 0.1 * x;
        slow + 0.05 * uniform() + 7.0
    });
    let y = y.collect();
    [x, y]
}

fn ours(x: &[f64], y: &[f64]) -> (Frf, usize) {
    let settings = WelchSettings::new(RATE_HZ, SEGMENT_SAMPLES);
    let spectra = CrossSpectra::welch(&[x, y], &settings).expect("a good record");
    let coherence = spectra.coherence(0, 1).expect("averaged");
    (spectra.h1(0, 1).expect("averaged"), coherence.len())
}

fn windowed(segment: &[f64]) -> Vec<f64> {
    let n = segment.len() as f64;
    let mean = segment.iter().sum::<f64>() / n;
    let weight = |k: usize| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / n).cos();
    let weights: Vec<f64> = (0..segment.len()).map(weight).collect();
    segment.iter().zip(&weights).map(|(v, w)| (v - mean) * w).collect()
}

/// As one writes it down.
fn straightforward(x: &[f64], y: &[f64]) -> Frf {
    let lines = SEGMENT_SAMPLES / 2 + 1;
    let fft = fourier::forward(SEGMENT_SAMPLES);
    let spectrum = |segment: &[f64]| -> Vec<C64> {
        let mut output = fft.make_output_vec();
        fft.process(&mut windowed(segment), &mut output).expect("lengths of the plan");
        output
    };
    let mut sums = vec![(0.0, 0.0, C64::ZERO); lines];
    let mut segments = 0.0;
    for start in (0..=x.len() - SEGMENT_SAMPLES).step_by(SEGMENT_SAMPLES / 2) {
        let [a, b] = [x, y].map(|channel| spectrum(&channel[start..start + SEGMENT_SAMPLES]));
        for (k, sum) in sums.iter_mut().enumerate() {
            sum.0 += a[k].norm_sqr();
            sum.1 += b[k].norm_sqr();
            sum.2 += a[k].conj() * b[k];
        }
        segments += 1.0;
    }
    let line = |(k, (xx, yy, xy)): (usize, &(f64, f64, C64))| {
        let coherence = xy.norm_sqr() / (xx * yy);
        let value = xy / xx;
        let averages = 0.947 * segments;
        Line {
            frequency_hz: k as f64 * RATE_HZ / SEGMENT_SAMPLES as f64,
            value,
            variance: value.norm_sqr() * (1.0 - coherence) / coherence / averages,
            dof: averages - 1.0,
            coherence: Some(coherence),
        }
    };
    sums.iter().enumerate().map(line).collect()
}

#[divan::bench(args = SAMPLES, sample_count = 10, sample_size = 1)]
fn h1_and_coherence(bencher: divan::Bencher<'_, '_>, samples: usize) {
    let [x, y] = record(samples);
    bencher.counter(ItemsCount::new(samples)).bench_local(|| ours(&x, &y));
}

#[divan::bench(args = SAMPLES, sample_count = 10, sample_size = 1)]
fn h1_and_coherence_on_one_core(bencher: divan::Bencher<'_, '_>, samples: usize) {
    let [x, y] = record(samples);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    bencher.counter(ItemsCount::new(samples)).bench_local(|| pool.install(|| ours(&x, &y)));
}

#[divan::bench(args = SAMPLES, sample_count = 10, sample_size = 1)]
fn straightforward_h1_and_coherence(bencher: divan::Bencher<'_, '_>, samples: usize) {
    let [x, y] = record(samples);
    bencher.counter(ItemsCount::new(samples)).bench_local(|| straightforward(&x, &y));
}
