use std::f64::consts::TAU;

use super::super::frf::Line;
use super::super::rational::tests::{Noise, columns, measured, scipy};
use super::*;

mod disturbance;
mod units;

/// c/(s² + 2ζω_n·s + ω_n²) of each mode.
fn structure(modes: &[[f64; 3]], hz: f64) -> C64 {
    let s = C64::new(0.0, TAU * hz);
    let mode = |[own, damping, c]: &[f64; 3]| {
        let omega = TAU * own;
        C64::new(*c, 0.0) / (s * (s + 2.0 * damping * omega) + omega * omega)
    };
    modes.iter().map(mode).sum()
}

/// Lines with the same noise on each.
fn lines(truth: &[[f64; 3]], [from_hz, to_hz]: [f64; 2], count: usize, sd: f64, seed: u64) -> Frf {
    let mut noise = Noise::new(seed);
    let line = |k: usize| {
        let hz = from_hz + (to_hz - from_hz) * k as f64 / (count - 1) as f64;
        Line { variance: sd * sd, ..Line::exact(hz, structure(truth, hz) + noise.next() * sd) }
    };
    (0..count).map(line).collect()
}

fn ratio(mode: &Mode) -> Damping {
    mode.damping.expect("resolved")
}

#[test]
fn a_single_mode_in_two_percent_of_noise_is_found_to_a_hundred_thousandth() {
    let truth = [[120.0, 0.01, 1.0]];
    let sd = 0.02 * structure(&truth, 0.0).norm();
    let mut frequency = 0.0;
    let mut damping = 0.0;
    let mut stated = 0.0;
    for seed in 0..10 {
        let found =
            modes(&[lines(&truth, [60.0, 180.0], 400, sd, seed)], &Settings::default()).expect("modes");
        assert_eq!(found.modes.len(), 1, "seed {seed}");
        let mode = &found.modes[0];
        frequency += (mode.frequency_hz / 120.0 - 1.0).powi(2) / 10.0;
        damping += (ratio(mode).ratio / 0.01 - 1.0).powi(2) / 10.0;
        stated += (ratio(mode).u / 0.01).powi(2) / 10.0;
    }
    assert!(frequency.sqrt() < 4e-6 && damping.sqrt() < 4e-4, "{} {}", frequency.sqrt(), damping.sqrt());
    assert!((0.4..2.5).contains(&(stated / damping)), "stated variance over scatter {}", stated / damping);
}

#[test]
fn two_modes_one_and_a_half_half_bandwidths_apart_are_both_found() {
    let truth = [[100.0, 0.01, 1.0], [101.5, 0.01, 1.0]];
    let sd = 1e-3 * structure(&truth, 100.5).norm();
    for seed in 0..4 {
        let found =
            modes(&[lines(&truth, [50.0, 150.0], 400, sd, seed)], &Settings::default()).expect("modes");
        assert_eq!(found.modes.len(), 2, "seed {seed}");
        for (mode, [hz, damping, c]) in found.modes.iter().zip(truth) {
            assert!((mode.frequency_hz / hz - 1.0).abs() < 2e-4, "{mode:?}");
            assert!((ratio(mode).ratio / damping - 1.0).abs() < 0.03, "{mode:?}");
            let expected = C64::new(0.0, -c / (2.0 * TAU * hz * (1.0 - damping * damping).sqrt()));
            assert!((mode.residues[0] - expected).norm() < 0.05 * expected.norm(), "{mode:?}");
            assert!((mode.residues[0] - expected).norm() < 5.0 * mode.residue_u[0], "{mode:?}");
        }
    }
}

#[test]
fn noise_alone_has_no_modes_and_says_why() {
    let found = modes(&[lines(&[], [10.0, 100.0], 400, 1.0, 5)], &Settings::default()).expect("a fit");
    assert!(found.modes.is_empty(), "{:?}", found.modes);
    assert!(!found.rejected.is_empty() && !found.diagram.orders.is_empty());
}

#[test]
fn the_modes_of_the_azimuth_axis_stand_beside_its_rigid_body() {
    let truth = [[40.851, -4.1771e-4], [53.733, 2.0833e-4], [85.527, 1.6667e-4]];
    let response = |hz: f64| {
        let s = C64::new(0.0, TAU * hz);
        let velocity = truth.map(|[own, c]| structure(&[[own, 0.03, c]], hz) * s);
        ((s * 1138.95 + 273.6).inv() + velocity.into_iter().sum::<C64>()) * (-s * 0.003).exp()
    };
    let settings =
        Settings { delay_s: 0.003, lower: Lower::Viscous, upper: Upper::None, ..Settings::default() };
    for seed in 0..3 {
        let found = modes(&[measured(response, 100.0, 100, 0.01, seed)], &settings).expect("modes");
        assert_eq!(found.modes.len(), 3, "{:?}", found.modes);
        for (mode, [hz, _]) in found.modes.iter().zip(truth) {
            assert!((mode.frequency_hz / hz - 1.0).abs() < 1e-3 && mode.orders > 0, "{mode:?}");
            assert!((ratio(mode).ratio / 0.03 - 1.0).abs() < 0.05, "{mode:?}");
        }
    }
}

#[test]
fn frequencies_and_dampings_are_those_of_scipy() {
    let settings = Settings { delay_s: 0.0015, lower: Lower::Rigid, ..Settings::default() };
    let found = modes(&[scipy()], &settings).expect("modes");
    let expected = [
        [14.001_977_820_050_01, 0.003_062_511, 0.020_073_563_293, 0.000_214_552],
        [15.095_084_472_364_45, 0.004_264_490, 0.030_229_201_312, 0.000_275_562],
        [40.998_851_519_977_826, 0.002_531_974, 0.009_827_398_547, 0.000_061_271_6],
    ];
    assert_eq!(found.modes.len(), 3);
    for (mode, [hz, hz_u, damping, damping_u]) in found.modes.iter().zip(expected) {
        assert!((mode.frequency_hz - hz).abs() < 1e-3 * hz_u, "{mode:?}");
        assert!((mode.frequency_u_hz / hz_u - 1.0).abs() < 1e-3, "{mode:?}");
        assert!((ratio(mode).ratio - damping).abs() < 1e-3 * damping_u, "{mode:?}");
        assert!((ratio(mode).u / damping_u - 1.0).abs() < 1e-3, "{mode:?}");
    }
}

/// `tests/data/impact_frf`, a real impact test. Its coherence is that of an unstated number of averages and exceeds 1
/// on some lines: the noise is taken from the residual, around each peak of its own.
#[test]
fn a_real_impact_test_of_poor_coherence_gives_frequencies_but_no_damping() {
    let frf: Frf = columns(include_str!("../../../../tests/data/impact_frf/frf.csv"))
        .skip(1)
        .map(|[hz, re, im, _]| Line::exact(hz, C64::new(re, im)))
        .collect();
    for (band_hz, peak_hz) in [([20.0, 60.0], 34.0625), ([150.0, 300.0], 212.1875)] {
        let settings = Settings { band_hz: Some(band_hz), ..Settings::default() };
        let found = modes(std::slice::from_ref(&frf), &settings).expect("modes");
        let largest = found.modes.iter().max_by(|x, y| x.residues[0].norm().total_cmp(&y.residues[0].norm()));
        let mode = largest.expect("a mode");
        assert!((mode.frequency_hz - peak_hz).abs() < 0.3125, "{peak_hz} Hz: {:?}", found.modes);
        if peak_hz < 100.0 {
            assert!(mode.damping.is_err(), "{mode:?}");
        }
    }
}

#[test]
fn a_resonance_between_two_lines_has_no_damping() {
    let found = modes(&[lines(&[[50.3, 0.001, 1.0]], [10.0, 100.0], 91, 1e-7, 1)], &Settings::default());
    let found = found.expect("modes");
    assert_eq!(found.modes.len(), 1);
    assert!((found.modes[0].frequency_hz - 50.3).abs() < 0.01);
    let reason = found.modes[0].damping.expect_err("0.1 Hz wide, lines of 1 Hz");
    assert!(matches!(reason, Unresolved::Spacing { .. }), "{reason}");
}

#[test]
fn modes_are_followed_through_a_crossing() {
    let pose = |k: i32| {
        let step = f64::from(k);
        let one = [20.0 + 0.5 * step, 0.01, 1.0];
        let other = [23.1 - 0.4 * step, 0.012, -1.0];
        vec![lines(&[one, other], [5.0, 60.0], 300, 1e-6, 30 + k as u64)]
    };
    let rows: Vec<Vec<Frf>> = (0..8).map(pose).collect();
    let found: Vec<Modal> =
        rows.iter().map(|frfs| modes(frfs, &Settings::default()).expect("modes")).collect();
    let tracks = track(&found);
    assert_eq!(tracks.len(), 2, "{tracks:?}");
    for (track, sign) in tracks.iter().zip([-1.0, 1.0]) {
        assert_eq!(track.steps.len(), 8);
        assert!(track.steps.iter().all(|s| found[s.row].modes[s.mode].residues[0].im * sign > 0.0));
    }
}

#[test]
fn settings_and_lines_out_of_range_are_refused() {
    let frf = lines(&[[50.0, 0.01, 1.0]], [10.0, 100.0], 100, 1e-6, 1);
    let refused =
        |frf: &Frf, settings: Settings| modes(std::slice::from_ref(frf), &settings).expect_err("refused");
    let error = refused(&frf, Settings { most_damping: f64::NAN, ..Settings::default() });
    assert!(matches!(error, ModalError::Setting { name: "most_damping", .. }), "{error}");
    let error = refused(&frf, Settings { band_hz: Some([9.0, 3.0]), ..Settings::default() });
    assert!(matches!(error, ModalError::Setting { name: "band_hz", .. }), "{error}");
    let error = refused(&frf, Settings { band_hz: Some([200.0, 300.0]), ..Settings::default() });
    assert_eq!(error, ModalError::Lines(LineError::Empty { response: 0 }));
    let error = refused(&frf[..14].to_vec(), Settings::default());
    assert_eq!(error, ModalError::Fit(RationalError::TooFew { lines: 14, unknowns: 5, needed: 15 }));
    let mut mixed = frf;
    mixed[4].variance = 0.0;
    let error = refused(&mixed, Settings::default());
    assert!(matches!(error, ModalError::Lines(LineError::Variance { line: 4, .. })), "{error}");
}
