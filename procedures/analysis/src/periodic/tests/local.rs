//! Local polynomial and rational models on random excitation.

use super::plant::{Mode, Noise};
use crate::frf::Line;
use crate::periodic::{LocalModel, Segment, lpm, lpm_segments};

const RATE_HZ: f64 = 1000.0;
const MODE: Mode = Mode { natural_hz: 120.0, zeta: 0.01 };
/// Lines 0.48 Hz apart: a fifth of the 3 dB bandwidth 2·0.01·120 Hz.
const LENGTH: usize = 2083;

/// Random input with a past, so that the record begins and ends in motion, and output with noise.
fn record(seed: u64, length: usize, sd: f64) -> (Vec<f64>, Vec<f64>) {
    let mut noise = Noise::new(seed);
    let input: Vec<f64> = (0..length + 2000).map(|_| noise.normal()).collect();
    let output: Vec<f64> = MODE.run(&input, RATE_HZ).iter().map(|v| v + sd * noise.normal()).collect();
    (input[2000..].to_vec(), output[2000..].to_vec())
}

fn peak(frf: &[Line]) -> &Line {
    frf.iter()
        .min_by(|a, b| (a.frequency_hz - 120.0).abs().total_cmp(&(b.frequency_hz - 120.0).abs()))
        .expect("lines")
}

/// Mean of Ĝ/G − 1 at the line next to the resonance.
fn bias(length: usize, model: LocalModel, seeds: u64) -> f64 {
    let sum: crate::frf::C64 = (0..seeds)
        .map(|seed| {
            let (input, output) = record(seed, length, 0.02);
            let frf = lpm(&input, &output, RATE_HZ, &(115.0..=125.0), model).expect("a record");
            let line = peak(&frf);
            line.value / MODE.sampled_at(line.frequency_hz, RATE_HZ) - 1.0
        })
        .sum();
    (sum / seeds as f64).norm()
}

#[test]
fn with_five_lines_in_the_bandwidth_the_rational_model_finds_the_peak_and_the_polynomial_does_not() {
    let rational = bias(LENGTH, LocalModel::rational(6), 30);
    assert!(rational < 0.02, "{rational}");
    let polynomial = bias(LENGTH, LocalModel::polynomial(4), 30);
    assert!(polynomial > 0.02, "{polynomial}: estimators.md row 5 would hold with it");
}

#[test]
fn with_twenty_lines_in_the_bandwidth_the_polynomial_model_suffices() {
    let polynomial = bias(4 * LENGTH, LocalModel::polynomial(4), 10);
    assert!(polynomial < 0.02, "{polynomial}");
}

#[test]
fn segments_share_the_response_and_their_circles_cover() {
    let mut inside = 0;
    let mut total = 0;
    for seed in 0..12 {
        let records: Vec<_> = (0..4).map(|k| record(1000 * seed + k, LENGTH, 0.5)).collect();
        let segments: Vec<Segment<'_>> =
            records.iter().map(|(u, y)| Segment { input: u, output: y }).collect();
        let model = LocalModel::polynomial(4);
        let frf = lpm_segments(&segments, RATE_HZ, &(10.0..=90.0), model).expect("segments");
        assert_eq!(frf[0].dof, 4.0 * 9.0 - 15.0);
        for line in &frf {
            let error = (line.value - MODE.sampled_at(line.frequency_hz, RATE_HZ)).norm();
            inside += usize::from(error <= line.circle_radius(0.95));
            total += 1;
        }
    }
    let covered = inside as f64 / f64::from(total);
    assert!((0.93..0.97).contains(&covered), "{covered} of {total}");
}

#[test]
fn leakage_of_a_record_cut_out_of_motion_is_taken_off() {
    let (input, output) = record(5, LENGTH, 0.0);
    let frf = lpm(&input, &output, RATE_HZ, &(20.0..=100.0), LocalModel::polynomial(3)).expect("a record");
    let worst = frf
        .iter()
        .map(|l| (l.value / MODE.sampled_at(l.frequency_hz, RATE_HZ) - 1.0).norm())
        .fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst}");
}
