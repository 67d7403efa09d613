//! Bad input: each mistake has its error, with what was expected and what was found.

use std::f64::consts::TAU;

use crate::frf::C64;
use crate::periodic::{
    Channel, LineKind, PeriodicError, Realisation, Windows, errors_in_variables, fast, robust, spectra,
    transfer, transient,
};

const RATE_HZ: f64 = 100.0;

fn sine(frequency_hz: f64, samples: usize) -> Vec<f64> {
    (0..samples).map(|i| (TAU * frequency_hz * i as f64 / RATE_HZ).cos()).collect()
}

fn windows() -> Windows {
    Windows { sample_rate_hz: RATE_HZ, length: 100, starts: vec![3, 110] }
}

/// Transfer of a channel for a reference of 5 Hz.
fn told(samples: &[f64], grid_hz: &[f64]) -> PeriodicError {
    let channel = [Channel { name: "angle", samples }];
    transfer(&windows(), grid_hz, &sine(5.0, 300), &channel, &[]).expect_err("must be refused")
}

#[test]
fn a_dead_channel_a_hole_and_a_short_record_are_named() {
    let mut stuck = sine(5.0, 300);
    stuck[110..210].fill(2.5);
    let error = told(&stuck, &[5.0]);
    assert_eq!(error, PeriodicError::Constant { channel: "angle".to_owned(), from: 110, to: 209 });
    assert!(error.to_string().contains("`angle`") && error.to_string().contains("110…209"));
    let mut hole = sine(5.0, 300);
    hole[150] = f64::NAN;
    assert_eq!(told(&hole, &[5.0]), PeriodicError::NotFinite { channel: "angle".to_owned(), sample: 150 });
    assert_eq!(
        told(&sine(5.0, 150), &[5.0]),
        PeriodicError::Length { channel: "angle".to_owned(), expected: 210, found: 150 }
    );
}

#[test]
fn a_line_that_is_not_excited_is_named() {
    let error = told(&sine(5.0, 300), &[5.0, 9.0]);
    let PeriodicError::MissingReference { frequency_hz, found, .. } = error else { panic!("{error}") };
    assert!((frequency_hz - 9.0).abs() < 1e-12 && found < 1e-12);
}

#[test]
fn lines_above_the_limit_are_refused() {
    assert_eq!(
        told(&sine(5.0, 300), &[5.0, 41.0]),
        PeriodicError::TooFast { frequency_hz: 41.0, limit_hz: 40.0 }
    );
}

#[test]
fn one_window_has_no_scatter() {
    let single = Windows { starts: vec![0], ..windows() };
    let reference = sine(5.0, 300);
    let channel = [Channel { name: "angle", samples: &reference }];
    let few = Err(PeriodicError::TooFew { what: "windows", expected: 2, found: 1 });
    assert_eq!(transfer(&single, &[5.0], &reference, &channel, &[]), few);
    let one = vec![vec![C64::new(1.0, 0.0)]];
    assert!(matches!(errors_in_variables(&[1.0], &one, &one), Err(PeriodicError::TooFew { .. })));
    assert!(matches!(fast(&[(1.0, LineKind::Excited)], &one, &one), Err(PeriodicError::TooFew { .. })));
    let two = vec![one[0].clone(), one[0].clone()];
    assert!(matches!(transient(&two), Err(PeriodicError::TooFew { expected: 3, .. })));
    let alone = [Realisation { u: &two, y: &two }];
    assert!(matches!(robust(&[1.0], &alone), Err(PeriodicError::TooFew { what: "realisations", .. })));
    assert!(matches!(
        fast(&[(1.0, LineKind::Excited)], &two, &two),
        Err(PeriodicError::TooFew { what: "detection lines", .. })
    ));
}

#[test]
fn arrays_of_other_shapes_and_an_input_of_zero_are_refused() {
    let ones = vec![vec![C64::new(1.0, 0.0); 2]; 3];
    let narrow = vec![vec![C64::new(1.0, 0.0)]; 3];
    let zero = vec![vec![C64::new(0.0, 0.0); 2]; 3];
    let hz = [1.0, 2.0];
    assert_eq!(
        errors_in_variables(&hz, &ones, &narrow),
        Err(PeriodicError::Length { channel: "output".to_owned(), expected: 2, found: 1 })
    );
    assert!(matches!(errors_in_variables(&hz, &zero, &ones), Err(PeriodicError::MissingReference { .. })));
    let exact = errors_in_variables(&hz, &ones, &ones).expect("no noise is no mistake");
    assert!(exact[0].variance.abs() < 1e-30 && exact[0].coherence == Some(1.0));
}

#[test]
fn a_nuisance_shorter_than_the_record_is_named() {
    let reference = sine(5.0, 300);
    let channel = [Channel { name: "angle", samples: &reference }];
    let short = sine(1.3, 120);
    let error = spectra(&windows(), &[5.0], &channel, &[&short]).expect_err("too short");
    assert_eq!(
        error,
        PeriodicError::Length { channel: "nuisance column 0".to_owned(), expected: 210, found: 120 }
    );
}
