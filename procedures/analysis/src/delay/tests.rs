use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;
use crate::frf::{C64, Frf, Line};

const DELAY_S: f64 = 1.25e-3;

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0
}

fn gauss(random: &mut ChaCha8Rng) -> f64 {
    (-2.0 * uniform(random).ln()).sqrt() * (TAU * uniform(random)).cos()
}

/// 490 lines, 10 to 500 Hz.
fn lines(seed: u64, ratio: f64, plant: impl Fn(C64) -> C64) -> Frf {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..490)
        .map(|k| {
            let hz = 10.0 + 490.0 * f64::from(k) / 489.0;
            let s = C64::new(0.0, TAU * hz);
            let value = (-s * DELAY_S).exp() * plant(s);
            let sd = ratio * value.norm();
            let noise = C64::new(gauss(&mut random), gauss(&mut random)) * (sd * 0.5_f64.sqrt());
            Line { variance: sd * sd, ..Line::exact(hz, value + noise) }
        })
        .collect()
}

#[test]
fn phase_slope_meets_its_bound() {
    const RUNS: u64 = 60;
    // σ_φ/√Σ(ω − ω̄)²: 0.0071 rad on 490 lines over 490 Hz.
    let bound = 0.36e-6;
    let fits: Vec<PhaseSlope> =
        (0..RUNS).map(|seed| phase_slope(&lines(seed, 0.01, |_| C64::from(1.0))).expect("lines")).collect();
    let rms = (fits.iter().map(|f| (f.delay_s - DELAY_S).powi(2)).sum::<f64>() / RUNS as f64).sqrt();
    assert!(rms < 1.25 * bound && rms > 0.75 * bound, "{rms}");
    assert!(fits.iter().all(|f| (f.u_s / bound - 1.0).abs() < 0.15));
    assert!(fits.iter().filter(|f| (f.delay_s - DELAY_S).abs() < 1.96 * f.u_s).count() >= 53);
}

#[test]
fn a_joint_fit_takes_the_plant_out_of_the_delay() {
    let plant = |s: C64| 1.0 / ((s / (TAU * 322.0)).powi(2) + 0.72 * s / (TAU * 322.0) + 1.0);
    let noisy = lines(1, 0.01, plant);
    let raw = phase_slope(&noisy);
    assert!(matches!(raw, Err(DelayError::Hopeless(_))), "a phase that bends is no delay: {raw:?}");
    let found = joint(&noisy, Dynamics { lag: false, second_order: true }, 5e-3, 0.99).expect("separable");
    assert!((found.delay_s - DELAY_S).abs() < 4.0 * found.u_s && found.u_s < 2e-6, "{found:?}");
    let [hz, u] = found.natural_hz.expect("asked for");
    assert!((hz - 322.0).abs() < 4.0 * u);
}

#[test]
fn a_lag_that_acts_like_delay_is_not_separated() {
    let low: Frf = lines(1, 0.01, |s| 1.0 / (1.0 + s * 159e-6)).into_iter().take(50).collect();
    let found = joint(&low, Dynamics { lag: true, second_order: false }, 5e-3, 0.99);
    assert!(matches!(found, Err(DelayError::NotSeparable { .. })), "{found:?}");
    let whole = joint(
        &lines(1, 0.01, |s| 1.0 / (1.0 + s * 159e-6)),
        Dynamics { lag: true, second_order: false },
        5e-3,
        0.995,
    );
    let whole = whole.expect("separable to 500 Hz");
    let [lag, u] = whole.lag_s.expect("asked for");
    assert!(
        (lag - 159e-6).abs() < 4.0 * u && whole.lag_correlation.expect("asked for").abs() > 0.8,
        "{whole:?}"
    );
}

/// A sum of tones below 1 kHz, sampled with noise of 1 %, one record later by a part of a sample.
#[test]
fn cross_correlation_finds_parts_of_a_sample_and_the_sign() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let tones: Vec<[f64; 2]> =
        (0..150).map(|_| [20.0 + 950.0 * uniform(&mut random), TAU * uniform(&mut random)]).collect();
    let signal = |t: f64| tones.iter().map(|[f, p]| (TAU * f * t + p).cos()).sum::<f64>();
    let mut record = |delay_s: f64, sign: f64| -> Vec<f64> {
        (0..8000).map(|k| sign * signal(f64::from(k) / 4000.0 - delay_s) + 0.1 * gauss(&mut random)).collect()
    };
    let first = record(0.0, 1.0);
    let band = Band { from_hz: 10.0, to_hz: 1000.0 };
    for (delay_s, sign) in [(1.333e-3, 1.0), (-0.41e-3, 1.0), (2.0e-3, -1.0)] {
        let found = cross_correlation(&first, &record(delay_s, sign), 4000.0, band, 0.01).expect("alike");
        assert!((found.delay_s - delay_s).abs() < 0.5e-6, "{found:?}");
        assert!(
            found.correlation.signum() == sign && (found.delay_s - delay_s).abs() < 4.0 * found.u_s,
            "{found:?}"
        );
    }
    let noise: Vec<f64> = (0..8000).map(|_| gauss(&mut random)).collect();
    assert!(matches!(cross_correlation(&first, &noise, 4000.0, band, 0.01), Err(DelayError::Unlike { .. })));
}

fn steps(seed: u64, rise: impl Fn(f64) -> f64) -> Vec<Step> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..10)
        .map(|_| {
            let phase = uniform(&mut random);
            let since_command_s: Vec<f64> = (-40..80).map(|k| (f64::from(k) + phase) * 250e-6).collect();
            let value =
                since_command_s.iter().map(|t| 2.0 - rise((t - 1.5e-3).max(0.0)) + 0.01 * gauss(&mut random));
            Step { value: value.collect(), since_command_s }
        })
        .collect()
}

#[test]
fn step_onset_beats_the_threshold_and_the_sampling() {
    let ramp = step_onset(&steps(1, |t| (t / 5e-3).min(1.0)), OnsetShape::Ramp).expect("it moves");
    assert!((ramp.delay_s - 1.5e-3).abs() < 25e-6 && ramp.u_s < 25e-6, "{ramp:?}");
    assert!(ramp.threshold_s > 1.7e-3, "the threshold is late by half a sample and more: {ramp:?}");
    let lag = steps(2, |t| 1.0 - (-t / 159e-6).exp());
    let found = step_onset(&lag, OnsetShape::Exponential { time_constant_s: None }).expect("it moves");
    assert!((found.delay_s - 1.5e-3).abs() < 25e-6, "{found:?}");
    assert!((found.time_constant_s.expect("fitted") / 159e-6 - 1.0).abs() < 0.1, "{found:?}");
    let still = step_onset(&steps(3, |_| 0.0), OnsetShape::Ramp);
    assert_eq!(still, Err(DelayError::NoOnset { repeat: 0 }));
}

/// Noise of 2 % of the rise, and a rest so short that two samples of noise seem to move now and then.
#[test]
fn noise_that_meets_the_threshold_long_before_the_rise_does_not_hide_the_onset() {
    const PERIOD_S: f64 = 250e-6;
    const LAG_S: f64 = 159e-6;
    const ONSET_S: f64 = 2.85e-3;
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut early = 0;
    for k in 0..5000 {
        let since_command_s: Vec<f64> = (-6..20).map(|k| PERIOD_S * f64::from(k)).collect();
        let rise = |t: &f64| if *t > ONSET_S { 1.0 - (-(t - ONSET_S) / LAG_S).exp() } else { 0.0 };
        let value = since_command_s.iter().map(|t| rise(t) + 0.021 * gauss(&mut random)).collect();
        let shape = OnsetShape::Exponential { time_constant_s: Some(LAG_S) };
        let found = step_onset(&[Step { since_command_s, value }], shape).expect("a step");
        assert!((found.delay_s - ONSET_S).abs() < 100e-6, "step {k}: {:e}", found.delay_s);
        early += u32::from(found.threshold_s < ONSET_S - PERIOD_S);
    }
    assert!(early > 5, "{early}: nothing was met before the rise");
}

#[test]
fn two_clocks_are_laid_over_each_other() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let first: Vec<f64> = (0..200).map(f64::from).collect();
    let second: Vec<f64> =
        first.iter().map(|t| 5.0 + t * (1.0 + 40e-6) + 1e-4 * gauss(&mut random)).collect();
    let fit = clock_fit(&first, &second).expect("stamps");
    assert!((fit.skew_ratio - 40e-6).abs() < 4.0 * fit.skew_u_ratio && fit.skew_u_ratio < 2e-7, "{fit:?}");
    let first_s =
        fit.epoch_s + (5.0 + 100.0 * (1.0 + 40e-6) - fit.epoch_s - fit.offset_s) / (1.0 + fit.skew_ratio);
    assert!((first_s - 100.0).abs() < 4.0 * fit.offset_u_s);
    assert!((fit.jitter_s / 1e-4 - 1.0).abs() < 0.2);
}

#[test]
fn bad_input_is_refused() {
    let good = lines(0, 0.01, |_| C64::from(1.0));
    let mut bad = good.clone();
    bad[3].value.im = f64::NAN;
    assert_eq!(phase_slope(&bad), Err(InputError::NotFinite { index: 3 }.into()));
    assert_eq!(phase_slope(&good[..4]), Err(InputError::TooFew { found: 4, least: 5 }.into()));
    bad = good.clone();
    bad.swap(7, 8);
    assert_eq!(phase_slope(&bad), Err(InputError::NotAscending { index: 8 }.into()));
    bad = good;
    bad[2].variance = 0.0;
    let dynamics = Dynamics { lag: false, second_order: false };
    assert_eq!(joint(&bad, dynamics, 5e-3, 0.99), Err(InputError::MixedVariance { index: 2 }.into()));
    assert!(matches!(clock_fit(&[0.0, 1.0, 2.0, 2.0, 3.0], &[0.0; 5]), Err(DelayError::Input(_))));
    let band = Band { from_hz: 10.0, to_hz: 3000.0 };
    let records = vec![1.0; 100];
    assert!(matches!(
        cross_correlation(&records, &records, 4000.0, band, 0.01),
        Err(DelayError::Input(InputError::Setting { name: "to_hz", .. }))
    ));
    let band = Band { from_hz: 10.0, to_hz: 1000.0 };
    let still = cross_correlation(&records, &records, 4000.0, band, 0.01);
    assert!(matches!(still, Err(DelayError::Unlike { .. })), "constant records hold no delay: {still:?}");
    assert!(step_onset(&[], OnsetShape::Ramp).is_err());
}
