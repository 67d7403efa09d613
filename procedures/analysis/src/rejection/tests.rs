use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

/// 1/(1 + K·e^(−jωτ)/jω) on lines 0.25 Hz apart.
fn integrator(gain_per_s: f64, delay_s: f64) -> Vec<Line> {
    let line = |k: u32| {
        let frequency_hz = 0.25 * f64::from(k);
        let omega = TAU * frequency_hz;
        let open = C64::from_polar(gain_per_s / omega, -omega * delay_s - TAU / 4.0);
        Line::exact(frequency_hz, (open + 1.0).inv())
    };
    (1..=300).map(line).collect()
}

/// Standard complex normals, variance `variance` in all.
fn noisy(lines: &[Line], variance: f64, dof: f64, seed: u64) -> Vec<Line> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = move || (f64::from(rng.next_u32()) + 0.5) / 4_294_967_296.0;
    let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos();
    let mut add = |l: &Line| {
        let size = (0.5 * variance).sqrt();
        let value = l.value + C64::new(size * normal(), size * normal());
        Line { value, variance, dof, ..*l }
    };
    lines.iter().map(&mut add).collect()
}

/// Closed forms of the loop K/s·e^(−sτ): |S| = 1 at K = 2ω·sin ωτ; |S|² = ω²/(ω² + K² − 2Kω·sin ωτ).
#[test]
fn an_integrator_behind_a_delay_has_the_rejection_and_the_crossing_of_its_closed_form() {
    let gain = 50.0;
    let delay_s = 10e-3;
    let lines = integrator(gain, delay_s);
    let exact_db = |hz: f64| {
        let omega = TAU * hz;
        let left = omega * omega + gain * gain - 2.0 * gain * omega * (omega * delay_s).sin();
        10.0 * (omega * omega / left).log10()
    };
    for hz in [1.0, 1.5, 3.0, 5.0, 9.0, 20.0] {
        let found = rejected(&lines, hz).expect("lines around it");
        assert!((found.db() - exact_db(hz)).abs() < 0.02, "{hz} Hz: {} {}", found.db(), exact_db(hz));
    }
    let curve = smoothed(&lines, 60.0);
    let (at, _) = crossing(&lines, &curve).expect("it crosses");
    let omega = TAU * at.frequency_hz;
    assert!((2.0 * omega * (omega * delay_s).sin() / gain - 1.0).abs() < 2e-3, "{} Hz", at.frequency_hz);
    let most = peak(&curve).expect("a peak");
    let fine = (1..6000).map(|k| exact_db(0.01 * f64::from(k))).fold(f64::MIN, f64::max);
    assert!((most.db() - fine).abs() < 0.03, "{} {fine}", most.db());
}

#[test]
fn stated_scatter_is_the_scatter_of_many_trials() {
    let exact = integrator(50.0, 10e-3);
    let truth = rejected(&exact, 3.0).expect("lines").db();
    let trials: Vec<Rejected> =
        (0..300).map(|seed| rejected(&noisy(&exact, 4e-4, 17.0, seed), 3.0).expect("lines")).collect();
    let square = trials.iter().map(|t| (t.db() - truth).powi(2)).sum::<f64>() / trials.len() as f64;
    let stated = trials.iter().map(|t| t.scatter_db.u.powi(2)).sum::<f64>() / trials.len() as f64;
    // The noise here is independent from line to line, that of a Hann window is not: HANN_FACTOR is on top.
    let ratio = stated / square / HANN_FACTOR;
    assert!((0.8..1.5).contains(&ratio), "{ratio}");
}

#[test]
fn without_lines_or_a_crossing_there_is_a_reason_and_a_loop_that_does_nothing_crosses_at_once() {
    let lines = integrator(50.0, 10e-3);
    assert!(matches!(rejected(&lines, 0.3), Err(RejectionError::TooFew { .. })));
    assert!(matches!(rejected(&[], 1.0), Err(RejectionError::TooFew { found: 0, .. })));
    let low: Vec<Line> = lines[..20].to_vec();
    let curve = smoothed(&low, 60.0);
    assert!(matches!(crossing(&low, &curve), Err(RejectionError::NoCrossing { .. })));
    let idle: Vec<Line> = lines.iter().map(|l| Line::exact(l.frequency_hz, C64::new(1.0, 0.0))).collect();
    let (at, _) = crossing(&idle, &smoothed(&idle, 60.0)).expect("an upper bound");
    assert!(at.frequency_hz < 1.0);
}
