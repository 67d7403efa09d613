use super::*;
use crate::synthetic_noise::uniform as noise;

const PERIOD_S: f64 = 2e-3;
const PITCHES: f64 = 32_768.0;
/// 0.1 deg/s.
const RATE_RAD_PER_S: f64 = 1.745e-3;

/// Angles by an encoder with this error within a pitch, and rates by gyros with noise, scale error and bias, of an axis that
/// creeps and sticks a little.
fn record(samples: usize, first: usize, error: impl Fn(f64) -> f64) -> [Vec<f64>; 2] {
    let angle = |k: usize| {
        let t = k as f64 * PERIOD_S;
        RATE_RAD_PER_S * t + 20e-6 * (TAU * 1.3 * t).sin()
    };
    let count_rad = TAU / (1_u64 << 26) as f64;
    let shown = |k: usize| {
        let true_rad = angle(k);
        ((true_rad + error(TAU * (true_rad * PITCHES / TAU).fract())) / count_rad).round() * count_rad
    };
    let turned = (0..=samples).map(shown).collect();
    // 3 µrad/√s over 2 ms: 67 µrad/s; a uniform number of that deviation.
    let rate = |k: usize| {
        let mean = (angle(k + 1) - angle(k)) / PERIOD_S;
        1.0002 * mean + 2e-6 + 67e-6 * 12_f64.sqrt() * noise(first + k)
    };
    [turned, (0..samples).map(rate).collect()]
}

#[test]
fn an_error_within_the_pitch_is_found_with_its_harmonics() {
    let [turned, rates] = record(10_000, 0, |phase| 1e-6 * phase.sin() + 0.4e-6 * (2.0 * phase + 1.0).cos());
    let found = pitch_error(&turned, &rates, PERIOD_S, PITCHES).expect("a fit");
    let truth = (0..3600).map(|k| {
        let phase = TAU * f64::from(k) / 3600.0;
        (1e-6 * phase.sin() + 0.4e-6 * (2.0 * phase + 1.0).cos()).abs()
    });
    let truth = truth.fold(0.0, f64::max);
    assert!((found.value - truth).abs() < 2.0 * found.u && found.u < 0.05e-6, "{found:?}, true {truth}");
}

/// 400 records of 4 s with an error of 0.5 µrad: the interval of two standard uncertainties holds it in 92 to 98 %.
#[test]
fn the_interval_holds_the_error_as_often_as_it_says() {
    let covered = (0..400)
        .filter(|run| {
            let [turned, rates] = record(2000, 10_000 * (run + 1), |phase| 0.5e-6 * (phase + 0.3).sin());
            let found = pitch_error(&turned, &rates, PERIOD_S, PITCHES).expect("a fit");
            (found.value - 0.5e-6).abs() < 2.0 * found.u
        })
        .count();
    assert!((368..=392).contains(&covered), "{covered} of 400");
}

#[test]
fn a_scale_without_error_shows_none_beyond_the_noise() {
    let [turned, rates] = record(10_000, 77, |_| 0.0);
    let found = pitch_error(&turned, &rates, PERIOD_S, PITCHES).expect("a fit");
    assert!(found.value < 4.0 * found.u && found.u < 0.05e-6, "{found:?}");
}

#[test]
fn what_does_not_tell_it_is_refused() {
    let [turned, rates] = record(10_000, 0, |_| 0.0);
    let refused = |turned: &[f64], rates: &[f64], pitches: f64| {
        pitch_error(turned, rates, PERIOD_S, pitches).expect_err("refused").to_string()
    };
    assert_eq!(refused(&turned, &rates[1..], PITCHES), "expected 10000 rates for 10001 angles, found 9999");
    assert_eq!(
        refused(&turned, &rates, 400.0),
        "the axis turned through 2.2 pitches of its scale, at least 4 are needed"
    );
    assert!(refused(&turned, &rates, 2e6).starts_with("pitches pass at "));
    assert!(refused(&[], &[], PITCHES).starts_with("expected 0 rates for 0 angles"));
}
