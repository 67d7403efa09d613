//! Numbers at the ends of their range, frequencies out of order, plants that do not answer: an error, never a number.

use super::plant::Noise;
use crate::frf::{C64, Line};
use crate::periodic::{
    LineKind, PeriodicError, Realisation, Timing, errors_in_variables, fast, robust, snr_db, times_jw,
    transient,
};

const HZ: [f64; 3] = [1.0, 2.0, 3.0];

/// Four windows of three lines that scatter by a percent.
fn scattered(size: f64, seed: u64) -> Vec<Vec<C64>> {
    let mut noise = Noise::new(seed);
    let mut value = || C64::new(1.0 + 0.01 * noise.normal(), 0.01 * noise.normal()) * size;
    (0..4).map(|_| (0..3).map(|_| value()).collect()).collect()
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
