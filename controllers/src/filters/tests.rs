use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

const RATE_HZ: f64 = 4000.0;

/// Gain and phase (rad) by driving the filter with a sine and correlating over whole periods.
fn measured(filter: &Biquad, frequency_hz: f64) -> (f64, f64) {
    let mut filter = filter.clone();
    let per_period = (RATE_HZ / frequency_hz) as usize;
    assert_eq!(per_period as f64 * frequency_hz, RATE_HZ, "whole samples per period");
    let settled = 40_000_usize.div_ceil(per_period) * per_period;
    let mut re = 0.0;
    let mut im = 0.0;
    for k in 0..settled + per_period {
        let phase = TAU * (k % per_period) as f64 / per_period as f64;
        let output = filter.update(libm::sin(phase));
        if k >= settled {
            re += output * libm::sin(phase) * 2.0 / per_period as f64;
            im += output * libm::cos(phase) * 2.0 / per_period as f64;
        }
    }
    (libm::hypot(re, im), libm::atan2(im, re))
}

/// What the bilinear transform makes of an analog frequency ratio.
fn warped(frequency_hz: f64, design_hz: f64) -> f64 {
    libm::tan(PI * frequency_hz / RATE_HZ) / libm::tan(PI * design_hz / RATE_HZ)
}

#[test]
fn first_order_low_pass_is_3_db_down_and_45_degrees_late_at_its_cut_off() {
    for cutoff_hz in [2.0, 100.0, 500.0, 1000.0] {
        let filter = Biquad::first_order_low_pass(cutoff_hz, RATE_HZ).expect("below half the rate");
        let (gain, phase_rad) = measured(&filter, cutoff_hz);
        assert!((gain - FRAC_1_SQRT_2).abs() < 1e-9, "{cutoff_hz} Hz: {gain}");
        assert!((phase_rad + PI / 4.0).abs() < 1e-9);
    }
}

#[test]
fn butterworth_low_pass_is_3_db_down_and_falls_with_40_db_per_decade() {
    let filter = Biquad::low_pass(20.0, FRAC_1_SQRT_2, RATE_HZ).expect("below half the rate");
    let (gain, phase_rad) = measured(&filter, 20.0);
    assert!((gain - FRAC_1_SQRT_2).abs() < 1e-9);
    assert!((phase_rad + PI / 2.0).abs() < 1e-9);
    for frequency_hz in [1.0, 100.0, 200.0, 800.0] {
        let ratio = warped(frequency_hz, 20.0);
        let expected = 1.0 / libm::sqrt(1.0 + libm::pow(ratio, 4.0));
        assert!((measured(&filter, frequency_hz).0 - expected).abs() < 1e-9);
    }
}

#[test]
fn notch_reaches_its_depth_at_its_centre_and_leaves_the_rest() {
    for (centre_hz, numerator, denominator) in [(20.0, 0.02, 0.5), (40.0, 0.0, 0.7), (400.0, 0.36, 1.0)] {
        let filter = Biquad::notch(centre_hz, numerator, denominator, RATE_HZ).expect("below half the rate");
        let (depth, _) = measured(&filter, centre_hz);
        assert!((depth - numerator / denominator).abs() < 1e-9, "{centre_hz} Hz: {depth}");
        for frequency_hz in [1.0, 10.0, 50.0, 1000.0] {
            let x = warped(frequency_hz, centre_hz);
            let size = |damping: f64| libm::hypot(1.0 - x * x, 2.0 * damping * x);
            let expected = size(numerator) / size(denominator);
            let (gain, _) = measured(&filter, frequency_hz);
            assert!((gain - expected).abs() < 1e-9, "{frequency_hz} Hz: {gain} against {expected}");
            assert!(gain > depth);
        }
    }
}

#[test]
fn settled_filter_has_no_transient() {
    let mut filters = [
        Biquad::first_order_low_pass(3.0, RATE_HZ).expect("below half the rate"),
        Biquad::low_pass(3.0, 0.3, RATE_HZ).expect("below half the rate"),
        Biquad::notch(17.0, 0.05, 0.5, RATE_HZ).expect("below half the rate"),
    ];
    for filter in &mut filters {
        filter.settle(7.5);
        for _ in 0..100 {
            assert!((filter.update(7.5) - 7.5).abs() < 1e-9);
        }
    }
}

#[test]
fn designs_that_do_not_exist_are_refused() {
    assert_eq!(Biquad::first_order_low_pass(2000.0, RATE_HZ), None);
    assert_eq!(Biquad::first_order_low_pass(f64::NAN, RATE_HZ), None);
    assert_eq!(Biquad::low_pass(0.0, 0.7, RATE_HZ), None);
    assert_eq!(Biquad::low_pass(10.0, 0.0, RATE_HZ), None);
    assert_eq!(Biquad::notch(10.0, -0.1, 0.5, RATE_HZ), None);
    assert_eq!(Biquad::notch(10.0, 0.1, f64::NAN, RATE_HZ), None);
    assert_eq!(Biquad::notch(10.0, 0.1, 0.5, f64::INFINITY), None);
}

#[test]
fn broken_sample_does_not_stay_in_the_filter() {
    let mut filter = Biquad::low_pass(50.0, 0.7, RATE_HZ).expect("below half the rate");
    filter.settle(1.0);
    filter.update(f64::NAN);
    let last = (0..4000).map(|_| filter.update(1.0)).last().expect("4000 samples");
    assert!((last - 1.0).abs() < 1e-9);
}

#[test]
fn rate_limiter_follows_at_its_rate_and_arrives_exactly() {
    let mut limiter = RateLimiter::new(2.0, 0.25, 1.0);
    let outputs: Vec<_> = [3.0, 3.0, 3.0, f64::NAN, 2.25, 2.0].map(|input| limiter.update(input)).into();
    assert_eq!(outputs, [1.5, 2.0, 2.5, 2.5, 2.25, 2.0]);
}

proptest! {
    #[test]
    fn every_design_is_stable_and_obeys_its_difference_equation(
        design_hz in 0.5..1990.0_f64,
        damping in 0.01..2.0_f64,
        depth in 0.0..1.0_f64,
        input in prop::collection::vec(-1.0..1.0_f64, 50),
    ) {
        let designs = [
            Biquad::first_order_low_pass(design_hz, RATE_HZ),
            Biquad::low_pass(design_hz, damping, RATE_HZ),
            Biquad::notch(design_hz, damping * depth, damping, RATE_HZ),
        ];
        for design in designs {
            let mut filter = design.expect("below half the rate");
            let [a1, a2] = filter.a;
            prop_assert!(a2.abs() < 1.0 && a1.abs() < 1.0 + a2, "poles inside the unit circle: {a1} {a2}");
            let mut output = Vec::new();
            for n in 0..input.len() {
                let past = |signal: &[f64], k: usize| if n >= k { signal[n - k] } else { 0.0 };
                let forward: f64 = filter.b.iter().enumerate().map(|(k, b)| b * past(&input, k)).sum();
                let expected = forward - a1 * past(&output, 1) - a2 * past(&output, 2);
                output.push(expected);
                prop_assert!((filter.update(input[n]) - expected).abs() < 1e-9);
            }
        }
    }
}
