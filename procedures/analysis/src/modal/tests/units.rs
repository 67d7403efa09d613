//! Modes do not depend on the unit of the response, nor on whether noise is there at all or known well.

use super::*;

/// Two close modes and one apart, noise of a thousandth of the peak.
fn three() -> Frf {
    let truth = [[75.0, 0.02, 1.0], [120.0, 0.01, 1.0], [121.8, 0.01, -1.0]];
    lines(&truth, [60.0, 180.0], 300, 1e-3 * structure(&truth, 120.0).norm(), 3)
}

#[test]
fn a_unit_a_thousand_million_times_larger_changes_no_digit_that_counts() {
    let frf = three();
    let one = modes(std::slice::from_ref(&frf), &Settings::default()).expect("modes");
    for unit in [1e-100, 1e-12, 1e-9, 1e9, 1e12, 1e100] {
        let scaled: Frf = frf
            .iter()
            .map(|l| Line { value: l.value * unit, variance: l.variance * unit * unit, ..*l })
            .collect();
        let other = modes(&[scaled], &Settings::default()).expect("modes");
        assert_eq!((one.modes.len(), other.modes.len()), (3, 3), "unit {unit}");
        for (x, y) in one.modes.iter().zip(&other.modes) {
            assert!((x.frequency_hz / y.frequency_hz - 1.0).abs() < 1e-12, "unit {unit}: {x:?} {y:?}");
            assert!((ratio(x).ratio / ratio(y).ratio - 1.0).abs() < 1e-10, "unit {unit}: {x:?} {y:?}");
            assert!((x.residues[0] * unit / y.residues[0] - 1.0).norm() < 1e-10, "unit {unit}: {x:?} {y:?}");
            assert!((x.residue_u[0] * unit / y.residue_u[0] - 1.0).abs() < 1e-8, "unit {unit}: {x:?} {y:?}");
        }
    }
}

/// What rounding leaves of an exact response is no mode.
#[test]
fn a_response_without_noise_has_its_one_mode_and_no_other() {
    let exact = lines(&[[120.0, 0.01, 1.0]], [60.0, 180.0], 300, 0.0, 1);
    let found = modes(&[exact], &Settings::default()).expect("modes");
    assert_eq!(found.modes.len(), 1, "{:?}", found.modes);
    assert!((found.modes[0].frequency_hz / 120.0 - 1.0).abs() < 1e-12);
    assert!((ratio(&found.modes[0]).ratio / 0.01 - 1.0).abs() < 1e-10);
}

/// Variances from two windows have one complex degree of freedom each: some are a hundredth of the truth by chance.
#[test]
fn variances_of_two_windows_make_no_modes_of_their_own() {
    let mut square = 0.0;
    let mut stated = 0.0;
    for seed in 0..12 {
        let mut noise = Noise::new(500 + seed);
        let mut frf = lines(&[[120.0, 0.01, 1.0]], [60.0, 180.0], 400, 4e-7, seed);
        for line in &mut frf {
            line.variance *= noise.next().norm_sqr();
            line.dof = 1.0;
        }
        let found = modes(&[frf], &Settings::default()).expect("modes");
        assert_eq!(found.modes.len(), 1, "seed {seed}: {:?}", found.modes);
        square += (ratio(&found.modes[0]).ratio - 0.01).powi(2);
        stated += ratio(&found.modes[0]).u.powi(2);
    }
    assert!((0.4..2.5).contains(&(stated / square)), "stated variance over scatter {}", stated / square);
}
