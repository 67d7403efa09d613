use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

/// Gaussian noise by Box and Muller.
struct Noise(ChaCha8Rng);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0;
        (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
    }
}

/// Orders, amplitudes, phases of the azimuth axis, with a subharmonic and a weak third.
const TRUTH: [(f64, f64, f64); 4] =
    [(36.0, 0.4, 1.0), (144.0, 8.45, -0.3), (288.0, 1.2, 2.0), (432.0, 0.17, 0.5)];

fn stroke(reverse: bool, turns: f64, noise: f64, seed: u64) -> Branch {
    let count = (turns * 144.0 * 64.0).round() as usize;
    let span = turns * TAU;
    let mut random = Noise(ChaCha8Rng::seed_from_u64(seed));
    let angle_rad: Vec<f64> =
        (0..count).map(|k| (k as f64 + 0.5) / count as f64 * span - span / 2.0).collect();
    let value = angle_rad
        .iter()
        .map(|a| {
            let ripple: f64 = TRUTH.iter().map(|(o, c, p)| c * (o * a + p).cos()).sum();
            let sign = if reverse { -1.0 } else { 1.0 };
            sign * 168.0 + 3.0 * a - 14.0 * a.cos() + ripple + noise * random.next()
        })
        .collect();
    Branch { reverse, weight: vec![1.0; count], angle_rad, value }
}

fn settings(turns: f64) -> Settings {
    Settings { span_rad: turns * TAU, full_turn: false, most_order_per_rev: 1152.0, bin_width_rad: 0.0 }
}

#[test]
fn hundred_periods_each_way_give_every_harmonic_and_no_other() {
    let turns = 100.0 / 144.0;
    for seed in 0..5 {
        let noise = 0.02 * 8.45;
        let branches = [stroke(false, turns, noise, 2 * seed), stroke(true, turns, noise, 2 * seed + 1)];
        let spectrum = Spectrum::new(&branches, &settings(turns)).expect("two strokes");
        let found: Vec<f64> = spectrum.harmonics.iter().map(|h| h.at_order_per_rev).collect();
        assert_eq!(found, [36.0, 144.0, 288.0, 432.0], "seed {seed}");
        for (h, (_, amplitude, phase)) in spectrum.harmonics.iter().zip(TRUTH) {
            let off = (h.mean.amplitude - amplitude).abs();
            assert!(off < 4.0 * h.mean.u, "seed {seed}: {h:?}");
            let turned = (h.mean.phase_rad - phase).abs();
            assert!(turned < 4.0 * h.mean.u / amplitude, "seed {seed}: {h:?}");
        }
        let main = spectrum.largest_in(100.0..200.0).expect("the slots");
        assert!((main.order_per_rev - 144.0).abs() < 4.0 * main.order_u_per_rev, "{main:?}");
        assert!(main.order_u_per_rev < 0.01);
        // White noise: u of the mean of 2 × 6400 values.
        let white = noise * (2.0 / 12_800.0_f64).sqrt();
        assert!((main.mean.u / white - 1.0).abs() < 0.5, "{} against {white}", main.mean.u);
    }
}

#[test]
fn noise_alone_has_no_harmonics() {
    let turns = 40.0 / 144.0;
    for seed in 0..20 {
        let mut branch = stroke(false, turns, 0.0, seed);
        let mut random = Noise(ChaCha8Rng::seed_from_u64(seed));
        branch.value.iter_mut().for_each(|v| *v = random.next());
        let spectrum = Spectrum::new(&[branch], &settings(turns)).expect("a stroke");
        assert!(spectrum.harmonics.is_empty(), "seed {seed}: {:?}", spectrum.harmonics);
    }
}

#[test]
fn a_mean_over_bins_is_undone() {
    let turns = 40.0 / 144.0;
    let mut branches = [stroke(false, turns, 0.0, 1), stroke(true, turns, 0.0, 2)];
    let width = TAU / 144.0 / 16.0;
    for branch in &mut branches {
        branch.value = branch
            .angle_rad
            .iter()
            .map(|a| {
                TRUTH
                    .iter()
                    .map(|(o, c, p)| c * (o * a + p).cos() * (o * width / 2.0).sin() / (o * width / 2.0))
                    .sum()
            })
            .collect();
    }
    let spectrum =
        Spectrum::new(&branches, &Settings { bin_width_rad: width, ..settings(turns) }).expect("strokes");
    let third = spectrum.largest_in(400.0..460.0).expect("the third harmonic");
    assert!((third.mean.amplitude - 0.17).abs() < 1e-6, "{third:?}");
}

#[test]
fn strokes_that_disagree_widen_u() {
    let turns = 40.0 / 144.0;
    let mut branches: Vec<Branch> = (0..4).map(|k| stroke(k % 2 == 1, turns, 0.05, k)).collect();
    let calm = Spectrum::new(&branches, &settings(turns)).expect("strokes");
    for k in [2, 3] {
        let angle = branches[k].angle_rad.clone();
        branches[k].value.iter_mut().zip(angle).for_each(|(v, a)| *v += (144.0 * a).cos());
    }
    let wild = Spectrum::new(&branches, &settings(turns)).expect("strokes");
    let u = |s: &Spectrum| s.largest_in(100.0..200.0).map_or(0.0, |h| h.mean.u);
    assert!(u(&wild) > 50.0 * u(&calm), "{} against {}", u(&wild), u(&calm));
}

/// Means over bins; the ripple of the rate lags behind the effort in time, which is the other way round over the angle in reverse.
#[test]
fn another_quantity_has_its_own_lines_at_the_orders_of_the_effort_and_they_can_be_taken_off() {
    let turns = 40.0 / 144.0;
    let width = TAU / 144.0 / 16.0;
    let binned = |amplitude: f64, order: f64, phase: f64, angle: f64| {
        let half = order * width / 2.0;
        amplitude * (order * angle + phase).cos() * half.sin() / half
    };
    let mut efforts = [stroke(false, turns, 0.0, 1), stroke(true, turns, 0.0, 2)];
    for branch in &mut efforts {
        let effort = |a: &f64| TRUTH.iter().map(|(o, c, p)| binned(*c, *o, *p, *a)).sum();
        branch.value = branch.angle_rad.iter().map(effort).collect();
    }
    let settings = Settings { bin_width_rad: width, ..settings(turns) };
    let spectrum = Spectrum::new(&efforts, &settings).expect("strokes");
    let mut rates = efforts;
    for branch in &mut rates {
        let lag = if branch.reverse { -0.7 } else { 0.7 };
        let rate = |a: &f64| 0.035 + binned(-2e-5, 288.0, 2.0 + lag, *a);
        branch.value = branch.angle_rad.iter().map(rate).collect();
    }
    let lines = spectrum.beside(&rates, &settings).expect("strokes");
    assert_eq!(lines.len(), TRUTH.len());
    for (harmonic, line) in spectrum.harmonics.iter().zip(&lines) {
        let is_second = harmonic.at_order_per_rev == 288.0;
        let [mean, largest] = if is_second { [-2e-5 * 0.7_f64.cos(), 2e-5] } else { [0.0; 2] };
        assert!((line.mean - Complex::from_polar(mean, 2.0)).norm() < 1e-9, "{harmonic:?}: {line:?}");
        assert!((line.largest - largest).abs() < 1e-9, "{harmonic:?}: {line:?}");
        let left = harmonic.mean.less(1e4 * line.mean);
        assert!((left.amplitude - harmonic.mean.amplitude + 1e4 * mean).abs() < 1e-4, "{left:?}");
        assert!((left.phase_rad - harmonic.mean.phase_rad).abs() < 1e-4 && left.u == harmonic.mean.u);
    }
}
