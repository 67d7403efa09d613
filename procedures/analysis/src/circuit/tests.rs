use std::f64::consts::{LN_10, PI, TAU};

use super::super::frf::C64;
use super::super::rational::tests::Noise;
use super::*;

/// Stack of 30.2 µF with k² = 0.1 at 322 Hz and a dielectric of ten Debye relaxations, two per decade from 2 Hz on,
/// that lose 2 %: a ladder, not the element that is fitted.
fn ladder(hz: f64, coupling: f64) -> C64 {
    let s = C64::new(0.0, TAU * hz);
    let motional = coupling * 30.2e-6;
    let clamped = (1.0 - coupling) * 30.2e-6;
    let share = 0.02 * clamped * LN_10 / 2.0 * 2.0 / PI;
    let corner = |k: i32| 2.0 * 10_f64.powf(f64::from(k) / 2.0);
    let settled: f64 = (0..10).map(|k| share / (1.0 + (20.0 / corner(k)).powi(2))).sum();
    let relaxing: C64 =
        (0..10).map(|k| s * share / C64::new(1.0, hz / corner(k))).sum::<C64>() + s * (clamped - settled);
    let x = hz / 322.0;
    (relaxing + s * motional / C64::new(1.0 - x * x, 0.04 * x)).inv() + 0.1
}

fn measured(coupling: f64, share: f64, seed: u64) -> Vec<Line> {
    let mut noise = Noise::new(seed);
    let line = |k: u32| {
        let hz = 20.0 * 100_f64.powf(f64::from(k) / 199.0);
        let z = ladder(hz, coupling);
        Line {
            variance: share * share * z.norm_sqr(),
            ..Line::exact(hz, z + noise.next() * share * z.norm())
        }
    };
    (0..200).map(line).collect()
}

#[test]
fn the_stack_of_the_mirror_shows_its_mode_and_its_coupling() {
    for seed in 0..3 {
        let fit = CircuitFit::new(&measured(0.1, 0.005, seed), 20.0).expect("a circuit");
        let r = fit.resonance.expect("a resonance");
        assert!((r.series_hz.value / 322.0 - 1.0).abs() < 5e-4, "{r:?}");
        assert!((r.damping.value / 0.02 - 1.0).abs() < 0.02, "{r:?}");
        // The dielectric falls by 3.5 % from 20 to 322 Hz: k² of 0.1 at 20 Hz is more there.
        let whole_f = (ladder(322.0, 0.0) - 0.1).inv().im / (TAU * 322.0);
        let expected = 3.02e-6 / (3.02e-6 + 0.9 * whole_f);
        assert!((r.coupling.value - expected).abs() < 0.0005, "{r:?}, expected {expected}");
        assert!((r.coupling.value - 1.0 + (r.series_hz.value / r.parallel_hz.value).powi(2)).abs() < 1e-9);
        assert!((fit.capacitance_f.value / 27.18e-6 - 1.0).abs() < 0.005, "{fit:?}");
        assert!((fit.loss_tangent.value - 0.02).abs() < 0.002, "{fit:?}");
        assert!((fit.series_ohm.value - 0.1).abs() < 5.0 * fit.series_ohm.u + 0.01, "{fit:?}");
        assert!((fit.at(322.0) - ladder(322.0, 0.1)).norm() < 0.02 * ladder(322.0, 0.1).norm());
    }
}

#[test]
fn stated_uncertainties_are_those_that_repeats_show() {
    let found: Vec<Resonance> = (0..30)
        .map(|seed| {
            let fit = CircuitFit::new(&measured(0.1, 0.01, 100 + seed), 322.0).expect("a circuit");
            fit.resonance.expect("a resonance")
        })
        .collect();
    let estimates = |f: fn(&Resonance) -> Estimate| {
        let mean = found.iter().map(|r| f(r).value).sum::<f64>() / 30.0;
        let scatter = found.iter().map(|r| (f(r).value - mean).powi(2)).sum::<f64>() / 29.0;
        found.iter().map(|r| f(r).u.powi(2)).sum::<f64>() / 30.0 / scatter
    };
    // χ² of 29: 0.55 … 1.58 times its mean in 95 %.
    for ratio in [
        estimates(|r| r.series_hz),
        estimates(|r| r.parallel_hz),
        estimates(|r| r.damping),
        estimates(|r| r.coupling),
    ] {
        assert!((0.5..2.0).contains(&ratio), "stated variance over scatter {ratio}");
    }
}

#[test]
fn a_mode_below_the_noise_leaves_the_capacitance() {
    let fit = CircuitFit::new(&measured(1e-5, 0.02, 7), 20.0).expect("a capacitance");
    let reason = fit.resonance.expect_err("not visible");
    assert!(matches!(reason, NoResonance::BelowNoise { .. }), "{reason}");
    assert!((fit.capacitance_f.value / 30.2e-6 - 1.0).abs() < 0.01, "{fit:?}");
}

#[test]
fn without_a_variance_the_residual_tells_the_noise() {
    let lines: Vec<Line> = measured(0.1, 0.01, 8).iter().map(|l| Line { variance: 0.0, ..*l }).collect();
    let fit = CircuitFit::new(&lines, 20.0).expect("a circuit");
    let known = CircuitFit::new(&measured(0.1, 0.01, 8), 20.0).expect("a circuit");
    let r = fit.resonance.expect("a resonance");
    let k = known.resonance.expect("a resonance");
    assert!((r.series_hz.u / k.series_hz.u - 1.0).abs() < 0.2, "{r:?} {k:?}");
}

#[test]
fn lines_that_are_no_capacitance_are_refused() {
    let good = measured(0.1, 0.01, 1);
    let few = CircuitFit::new(&good[..17], 20.0).expect_err("three a piece for six");
    assert_eq!(few, CircuitError::TooFew { lines: 17, unknowns: 6, needed: 18 });
    let coil: Vec<Line> = good.iter().map(|l| Line { value: l.value.conj(), ..*l }).collect();
    assert_eq!(CircuitFit::new(&coil, 20.0).expect_err("a coil"), CircuitError::NoCapacitance);
    assert_eq!(
        CircuitFit::new(&good, 0.0).expect_err("no frequency"),
        CircuitError::Reference { frequency_hz: 0.0 }
    );
    let mut broken = good;
    broken[2].value.im = f64::NAN;
    let error = CircuitFit::new(&broken, 20.0).expect_err("not a number");
    assert_eq!(error, CircuitError::Lines(LineError::NotFinite { response: 0, line: 2 }));
}

#[test]
fn a_circuit_without_noise_is_found_exactly() {
    let truth = Values {
        capacitance_f: 27.18e-6,
        series_ohm: 0.1,
        loss_exponent: 0.0127,
        resonance: Some(model::Motion { motional_f: 3.02e-6, series_hz: 322.0, damping: 0.02 }),
        reference_hz: 322.0,
    };
    let frequency = |k: u32| 20.0 * 100_f64.powf(f64::from(k) / 199.0);
    for share in [0.0, 0.01] {
        let line = |k: u32| {
            let z = truth.impedance(frequency(k));
            Line { variance: (share * z.norm()).powi(2), ..Line::exact(frequency(k), z) }
        };
        let lines: Vec<Line> = (0..200).map(line).collect();
        let fit = CircuitFit::new(&lines, 322.0).expect("a circuit");
        let r = fit.resonance.expect("a resonance");
        let found = [r.series_hz.value, r.damping.value, r.capacitance_f, fit.capacitance_f.value];
        for (found, truth) in found.into_iter().zip([322.0, 0.02, 3.02e-6, 27.18e-6]) {
            assert!((found / truth - 1.0).abs() < 1e-6, "share {share}: {found} for {truth}");
        }
        // Stated noise stays in u although the lines have none; unstated noise is the residual's: none.
        let relative = r.damping.u / r.damping.value;
        let expected = if share > 0.0 { 1e-4..0.02 } else { 0.0..1e-6 };
        assert!(expected.contains(&relative), "share {share}: {relative}");
    }
}
