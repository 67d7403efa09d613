use std::f64::consts::TAU;

use super::*;

/// Times as a camera gives them that loses frames: steps of 5 ms, every seventh missing.
fn times() -> Vec<f64> {
    (0..400_u32).filter(|k| k % 7 != 3).map(|k| 12.0 + 0.005 * f64::from(k)).collect()
}

#[test]
fn sines_on_an_offset_that_drifts_come_out_exactly_whatever_frames_are_missing() {
    let time_s = times();
    let values: Vec<f64> = time_s
        .iter()
        .map(|t| {
            let turn = |hz: f64, phase: f64| TAU * hz * (t - 12.0) + phase;
            3.0 * turn(2.0, 0.4).cos() + 0.5 * turn(7.0, -1.0).cos() + 40.0 - 2.0 * t
        })
        .collect();
    let found = tones(Samples { time_s: &time_s, values: &values }, &[2.0, 7.0], 12.0).expect("a fit");
    for (x, (size, phase)) in found.amplitudes.iter().zip([(3.0, 0.4), (0.5, -1.0)]) {
        assert!((x - C64::from_polar(size, phase)).norm() < 1e-9, "{x}");
    }
    assert!(found.left < 1e-9);
}

#[test]
fn bad_samples_are_errors_and_no_numbers() {
    let time_s = times();
    let few = Samples { time_s: &time_s[..4], values: &[1.0; 4] };
    assert!(matches!(tones(few, &[2.0], 0.0), Err(FitError::TooFew { .. })));
    let unequal = Samples { time_s: &time_s, values: &[1.0; 4] };
    assert!(matches!(tones(unequal, &[2.0], 0.0), Err(FitError::Length { .. })));
    let values = vec![f64::NAN; time_s.len()];
    let broken = Samples { time_s: &time_s, values: &values };
    assert_eq!(tones(broken, &[2.0], 0.0), Err(FitError::NotFinite));
    let values = vec![1.0; time_s.len()];
    let twice = tones(Samples { time_s: &time_s, values: &values }, &[2.0, 2.0], 0.0);
    assert!(matches!(twice, Err(FitError::Dependent { .. })), "{twice:?}");
}
