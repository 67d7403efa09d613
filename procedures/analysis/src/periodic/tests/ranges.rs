//! Numbers at the ends of their range, frequencies out of order, plants that do not answer: an error, never a number.

use super::plant::Noise;
use crate::frf::{C64, Line};
use crate::periodic::{
    LineKind, LocalModel, PeriodicError, Realisation, Timing, errors_in_variables, fast, lpm, robust, snr_db,
    stepped_line, times_jw, transient,
};

const RATE_HZ: f64 = 100.0;
const HZ: [f64; 3] = [1.0, 2.0, 3.0];

/// Four windows of three lines that scatter by a percent.
fn scattered(size: f64, seed: u64) -> Vec<Vec<C64>> {
    let mut noise = Noise::new(seed);
    let mut value = || C64::new(1.0 + 0.01 * noise.normal(), 0.01 * noise.normal()) * size;
    (0..4).map(|_| (0..3).map(|_| value()).collect()).collect()
}

fn record(seed: u64) -> Vec<f64> {
    let mut noise = Noise::new(seed);
    (0..400).map(|_| noise.normal()).collect()
}

#[test]
fn amplitudes_whose_squares_overflow_or_vanish_are_refused_and_not_divided() {
    let small = scattered(1e-200, 1);
    let one = scattered(1.0, 2);
    let large = scattered(1e200, 3);
    let ratio = |u: &[Vec<C64>], y: &[Vec<C64>]| errors_in_variables(&HZ, u, y);
    assert!(matches!(ratio(&small, &one), Err(PeriodicError::MissingReference { .. })));
    assert!(matches!(ratio(&one, &large), Err(PeriodicError::TooLarge { what: "response" })));
    assert!(matches!(ratio(&large, &large), Err(PeriodicError::TooLarge { .. })));
    let twice = [Realisation { u: &small, y: &small }; 2];
    assert!(matches!(robust(&HZ, &twice), Err(PeriodicError::MissingReference { .. })));
    assert_eq!(transient(&large), Err(PeriodicError::TooLarge { what: "amplitudes" }));
    let kinds = [(1.0, LineKind::Excited), (2.0, LineKind::Even), (3.0, LineKind::Odd)];
    assert_eq!(fast(&kinds, &one, &large), Err(PeriodicError::TooLarge { what: "output" }));
    assert_eq!(fast(&kinds, &one, &scattered(0.0, 4)), Err(PeriodicError::Silent));
    let loud: Vec<f64> = record(1).iter().map(|v| 1e200 * v).collect();
    assert!(matches!(stepped_line(&record(2), &loud, RATE_HZ, 5.0), Err(PeriodicError::TooLarge { .. })));
    let local = lpm(&record(2), &loud, RATE_HZ, &(5.0..=10.0), LocalModel::rational(6));
    assert!(matches!(local, Err(PeriodicError::TooLarge { .. })), "{local:?}");
}

#[test]
fn lines_out_of_order_or_nowhere_are_named() {
    let one = scattered(1.0, 1);
    for (hz, line) in
        [([1.0, 1.0, 2.0], 1), ([3.0, 2.0, 1.0], 1), ([1.0, 2.0, f64::NAN], 2), ([-1.0, 0.0, 1.0], 0)]
    {
        let Err(PeriodicError::NotAscending { line: found, .. }) = errors_in_variables(&hz, &one, &one)
        else {
            panic!("{hz:?} must be refused")
        };
        assert_eq!(found, line);
        let kinds = hz.map(|f| (f, LineKind::Excited));
        assert!(matches!(fast(&kinds, &one, &one), Err(PeriodicError::NotAscending { .. })));
    }
    let nowhere = [Line::exact(f64::NAN, C64::new(1.0, 0.0))];
    assert!(matches!(times_jw(&nowhere, 1), Err(PeriodicError::NotPositive { .. })));
    let never = Timing { hold_s: f64::NAN, command_delay_s: 0.0, sensor_delay_s: 0.0 };
    assert!(matches!(never.removed(&[]), Err(PeriodicError::Timing { .. })));
    assert!(snr_db(1.1).is_infinite() && snr_db(-0.1).is_infinite());
}

#[test]
fn a_neighbourhood_of_any_size_is_refused_and_not_counted_past_the_end() {
    let u = record(1);
    let y = record(2);
    for model in [
        LocalModel::polynomial(usize::MAX),
        LocalModel { order: usize::MAX, ..LocalModel::polynomial(4) },
        LocalModel { denominator_order: usize::MAX, ..LocalModel::polynomial(4) },
    ] {
        assert!(lpm(&u, &y, RATE_HZ, &(5.0..=10.0), model).is_err(), "{model:?}");
    }
}

/// Without noise the output is the input times 2: as a column of the denominator it says nothing new.
#[test]
fn a_rational_model_of_a_static_plant_without_noise_is_the_polynomial_one() {
    let u = record(1);
    let y: Vec<f64> = u.iter().map(|u| 2.0 * u).collect();
    let found = lpm(&u, &y, RATE_HZ, &(5.0..=10.0), LocalModel::rational(6)).expect("a gain");
    assert!(found.iter().all(|l| (l.value - 2.0).norm() < 1e-12 && l.dof > 6.5), "{found:?}");
}
