//! Amplitudes in one window.

use std::f64::consts::TAU;

use super::plant::Noise;
use crate::frf::C64;
use crate::least_squares::LinearFit;
use crate::periodic::{Channel, Drift, PeriodicError, Projection, amplitudes};

const RATE_HZ: f64 = 200.0;
const LENGTH: usize = 400;

/// Lines at (m + φ)/T_w.
fn lines(offset: f64) -> Vec<f64> {
    [1.0, 2.0, 3.0, 5.0, 8.0, 21.0, 40.0].iter().map(|m| (m + offset) / 2.0).collect()
}

fn time(i: usize) -> f64 {
    i as f64 / RATE_HZ
}

/// Cosine and sine of a cogging order on a plateau.
fn cogging(frequency_hz: f64) -> [Vec<f64>; 2] {
    let column = |f: fn(f64) -> f64| (0..LENGTH).map(|i| f(TAU * frequency_hz * time(i))).collect();
    [column(f64::cos), column(f64::sin)]
}

/// The fit of the projection by the dense least squares of the crate.
fn dense(signal: &[f64], grid_hz: &[f64], nuisance: &[Vec<f64>]) -> Vec<C64> {
    let mut columns: Vec<Vec<f64>> = vec![];
    for f in grid_hz {
        columns.push((0..LENGTH).map(|i| (TAU * f * time(i)).cos()).collect());
        columns.push((0..LENGTH).map(|i| (TAU * f * time(i)).sin()).collect());
    }
    columns.push(vec![1.0; LENGTH]);
    columns.push((0..LENGTH).map(time).collect());
    columns.extend(nuisance.iter().cloned());
    let fit = LinearFit::new(&columns, signal, None).expect("independent columns");
    (0..grid_hz.len()).map(|k| C64::new(fit.coefficients[2 * k], -fit.coefficients[2 * k + 1])).collect()
}

#[test]
fn every_offset_gives_what_the_dense_least_squares_gives() {
    for offset in [0.0, 0.25, 0.5, 0.75, 0.3] {
        let mut noise = Noise::new(1);
        let signal: Vec<f64> = (0..LENGTH)
            .map(|i| 3.0 + 0.7 * time(i) + (TAU * 2.13 * time(i)).cos() + noise.normal())
            .collect();
        let grid_hz = lines(offset);
        let nuisance = cogging(2.13);
        let found = amplitudes(&signal, RATE_HZ, &grid_hz, &[&nuisance[0], &nuisance[1]]).expect("a window");
        for (a, b) in found.iter().zip(dense(&signal, &grid_hz, &nuisance)) {
            assert!((a - b).norm() < 1e-10, "offset {offset}: {a} {b}");
        }
    }
}

#[test]
fn a_microradian_on_a_large_moving_angle_comes_back() {
    let grid_hz = lines(0.5);
    let signal: Vec<f64> = (0..LENGTH)
        .map(|i| 500.0 + 2.0 * time(i) + 1e-6 * (TAU * grid_hz[3] * time(i) + 0.4).cos())
        .collect();
    let found = amplitudes(&signal, RATE_HZ, &grid_hz, &[]).expect("a window");
    assert!((found[3] / C64::from_polar(1e-6, 0.4) - 1.0).norm() < 1e-6, "{}", found[3]);
    assert!(found[0].norm() < 1e-12, "{}", found[0]);
}

#[test]
fn lines_off_the_grid_and_a_window_of_the_wrong_length_are_refused() {
    let signal: Vec<f64> = (0..LENGTH).map(|i| (TAU * 2.0 * time(i)).cos()).collect();
    let off = amplitudes(&signal, RATE_HZ, &[1.0, 2.0, 3.1], &[]);
    let Err(PeriodicError::NotOnGrid { frequency_hz, turns, .. }) = off else { panic!("{off:?}") };
    assert!((frequency_hz - 3.1).abs() < 1e-12 && (turns - 6.2).abs() < 1e-9);
    let short = amplitudes(&signal[..399], RATE_HZ, &[1.0, 2.0], &[]);
    assert!(matches!(short, Err(PeriodicError::NotOnGrid { samples: 399, .. })), "{short:?}");
    let descending = amplitudes(&signal, RATE_HZ, &[2.0, 1.0], &[]);
    assert!(matches!(descending, Err(PeriodicError::NotOnGrid { .. })));
}

#[test]
fn a_nuisance_that_is_a_line_or_an_offset_is_named() {
    let signal: Vec<f64> = (0..LENGTH).map(|i| (TAU * 2.0 * time(i)).cos()).collect();
    let [free, _] = cogging(1.23);
    let [on_line, _] = cogging(2.0);
    let found = amplitudes(&signal, RATE_HZ, &[1.0, 2.0], &[&free, &on_line]);
    assert_eq!(found, Err(PeriodicError::Dependent { column: 1 }));
    let constant = vec![4.0; LENGTH];
    assert_eq!(
        amplitudes(&signal, RATE_HZ, &[1.0], &[&constant]),
        Err(PeriodicError::Dependent { column: 0 })
    );
    let twice = amplitudes(&signal, RATE_HZ, &[1.0], &[&free, &free]);
    assert_eq!(twice, Err(PeriodicError::Dependent { column: 1 }));
}

/// Slow content that is no slope: a quarter of a period of a large sine, as friction makes an angle wander.
fn wandering() -> Vec<f64> {
    let wander = |i: usize| 3.0 + (TAU * 0.125 * time(i)).sin();
    (0..LENGTH).map(|i| wander(i) + 0.01 * (TAU * 4.0 * time(i) + 0.4).cos()).collect()
}

#[test]
fn without_a_slope_the_lines_are_those_of_the_plain_transform() {
    let signal = wandering();
    let grid_hz = lines(0.0);
    let projection = Projection::new(RATE_HZ, LENGTH, &grid_hz).expect("on the grid");
    let prepared = projection.prepare_with(Drift::Level, &[]).expect("an offset");
    let found = prepared.amplitudes(Channel { name: "angle", samples: &signal }, 0).expect("a window");
    let plain = |f: f64| -> C64 {
        let turn = |(i, v): (usize, &f64)| C64::from_polar(2.0 / LENGTH as f64 * v, -TAU * f * time(i));
        signal.iter().enumerate().map(turn).sum()
    };
    for (value, f) in found.iter().zip(&grid_hz) {
        assert!((value - plain(*f)).norm() < 1e-12, "{f} Hz: {value}, plain {}", plain(*f));
    }
    let with_slope = amplitudes(&signal, RATE_HZ, &grid_hz, &[]).expect("a window");
    assert!((with_slope[4] - found[4]).norm() > 1e-3, "the slope's saw-tooth sits on the lines");
}

#[test]
fn without_a_slope_a_nuisance_column_keeps_its_number() {
    let grid_hz = lines(0.0);
    let projection = Projection::new(RATE_HZ, LENGTH, &grid_hz).expect("on the grid");
    let [on_line, _] = cogging(4.0);
    let [free, _] = cogging(1.23);
    let refused = projection.prepare_with(Drift::Level, &[&free, &on_line]).map(|_| ());
    assert_eq!(refused, Err(PeriodicError::Dependent { column: 1 }));
}
