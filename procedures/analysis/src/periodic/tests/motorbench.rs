//! A real bench: lines measured by the Hori-Fujimoto laboratory (tests/data/motorbench), with values by numpy.

use crate::frf::{C64, Frf};
use crate::periodic::{errors_in_variables, times_jw, transient};

const LINES: &str = include_str!("../../../../../tests/data/motorbench/multisine_a_lines.csv");

/// Frequencies, and periods × lines of current, angle and speed.
fn record() -> (Vec<f64>, [Vec<Vec<C64>>; 3]) {
    let rows: Vec<Vec<f64>> = LINES
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|v| v.parse().expect("a number")).collect())
        .collect();
    let periods: Vec<&[Vec<f64>]> = rows.chunk_by(|a, b| (a[0] - b[0]).abs() < 0.5).collect();
    let frequencies_hz = periods[0].iter().map(|r| r[1]).collect();
    let channel = |c: usize| -> Vec<Vec<C64>> {
        periods.iter().map(|p| p.iter().map(|r| C64::new(r[c], r[c + 1])).collect()).collect()
    };
    (frequencies_hz, [channel(2), channel(4), channel(6)])
}

/// Gain, phase in degrees and standard deviation at a frequency, and the median of sd/|G|.
fn check(frf: &Frf, expected: &[[f64; 4]], median: f64) {
    for [frequency_hz, gain, phase_deg, sd] in expected {
        let line = frf.iter().find(|l| (l.frequency_hz - frequency_hz).abs() < 0.5).expect("a line");
        let digits: f64 = if *gain < 0.02 { 1e-5 } else { 1e-4 };
        assert!((line.value.norm() - gain).abs() < 0.51 * digits, "{line:?}");
        assert!((line.phase_rad().to_degrees() - phase_deg).abs() < 0.051, "{line:?}");
        assert!((line.variance.sqrt() / sd - 1.0).abs() < 1e-3, "{line:?}");
    }
    let mut ratios: Vec<f64> = frf.iter().map(|l| l.variance.sqrt() / l.value.norm()).collect();
    ratios.sort_by(f64::total_cmp);
    let found = 0.5 * (ratios[14] + ratios[15]);
    assert!((found - median).abs() < 0.6e-5, "{found}");
}

#[test]
fn angle_and_speed_per_current_of_the_motor_bench_match_numpy() {
    let (frequencies_hz, [current, angle, speed]) = record();
    assert_eq!((frequencies_hz.len(), current.len()), (30, 19));
    let angle = errors_in_variables(&frequencies_hz, &current, &angle).expect("19 periods");
    let rate = times_jw(&angle, 1).expect("no line at 0");
    check(
        &rate,
        &[
            [11.0, 1.5499, -79.49, 0.002289],
            [25.0, 0.5850, -85.40, 0.001115],
            [53.0, 0.0262, -60.81, 0.001082],
            [77.0, 6.4546, -44.46, 0.02497],
            [100.0, 0.5546, -93.43, 0.002540],
            [200.0, 0.1781, -97.67, 0.001206],
        ],
        0.0048016,
    );
    let speed = errors_in_variables(&frequencies_hz, &current, &speed).expect("19 periods");
    check(
        &speed,
        &[
            [11.0, 1.3647, -107.82, 0.001915],
            [25.0, 0.3700, -136.23, 0.0003754],
            [53.0, 0.00955, -129.77, 0.00008349],
            [77.0, 1.6536, -119.66, 0.006371],
            [100.0, 0.1110, -171.98, 0.0004617],
            [200.0, 0.01813, 178.07, 0.00002593],
        ],
        0.0036106,
    );
}

#[test]
fn the_lowest_and_highest_gain_are_at_53_and_77_hz() {
    let (frequencies_hz, [current, _, speed]) = record();
    let frf = errors_in_variables(&frequencies_hz, &current, &speed).expect("19 periods");
    let middle: Frf = frf.into_iter().filter(|l| (30.0..=90.0).contains(&l.frequency_hz)).collect();
    let by_gain = |a: &&crate::frf::Line, b: &&crate::frf::Line| a.value.norm().total_cmp(&b.value.norm());
    assert_eq!(middle.iter().min_by(by_gain).expect("lines").frequency_hz, 53.0);
    assert_eq!(middle.iter().max_by(by_gain).expect("lines").frequency_hz, 77.0);
    assert!(middle.iter().all(|l| l.coherence.is_some_and(|c| c > 0.99)), "{middle:?}");
}

#[test]
fn the_second_period_of_the_bench_is_in_steady_state() {
    let (_, [current, _, speed]) = record();
    for channel in [current, speed] {
        let found = transient(&channel).expect("19 periods");
        assert!(found.difference_ratio < 0.02, "{found:?}");
    }
}
