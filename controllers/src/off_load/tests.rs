use std::f64::consts::TAU;

use super::*;
use crate::complex::Complex;
use crate::linearise::{Probe, frequency_response};
use crate::parameter::tests::shipped_gains;

const PERIOD_S: f64 = 0.5e-3;
const OPTICAL_GAIN: f64 = 2.5;
/// Of the fine loop.
const FINE_GAIN_PER_S: f64 = 48.0;

fn gains() -> OffLoadGains {
    shipped_gains().off_load
}

fn off_load(gains: &OffLoadGains) -> OffLoad {
    OffLoad::new(gains, OPTICAL_GAIN, PERIOD_S).expect("valid")
}

#[test]
fn law_is_pi_behind_the_low_pass() {
    let gains = OffLoadGains { integral_time_s: 1.5, ..gains() };
    let probe =
        Probe { period_s: PERIOD_S, operating_point: 0.0, amplitude: 1e-6, settle_s: 4.0, measure_s: 20.0 };
    for frequency_hz in [0.1, 1.0, 2.0, 30.0] {
        let mut law = off_load(&gains);
        let measured = frequency_response(|m| law.update(m), &probe, frequency_hz).expect("finite");
        let z = Complex::unit(TAU * frequency_hz * PERIOD_S);
        let integral = z / (z - Complex::ONE) * (PERIOD_S / 1.5);
        let warped = (TAU * frequency_hz * PERIOD_S / 2.0).tan() / (TAU * 2.0 * PERIOD_S / 2.0).tan();
        let low_pass = Complex::ONE / Complex::new(1.0, warped);
        let expected = (Complex::ONE + integral) * low_pass * (gains.gain_per_s / OPTICAL_GAIN);
        let error = (measured - expected).magnitude() / expected.magnitude();
        assert!(error < 1e-6, "{frequency_hz} Hz: {error}");
    }
}

/// Mirror angles while the gimbal (an integrator) is off-loaded; the fine loop is an integrator with 11 ms of delay.
fn mirror_angles(mut law: OffLoad, seconds: f64, target: impl Fn(f64) -> f64) -> std::vec::Vec<f64> {
    const LATE: usize = 22;
    let mut gimbal_rad = 0.0;
    let mut mirror_rad = 0.0;
    let mut late = [0.0; LATE];
    (0..(seconds / PERIOD_S) as usize)
        .map(|k| {
            let seen = target(k as f64 * PERIOD_S) - gimbal_rad - mirror_rad / OPTICAL_GAIN;
            mirror_rad +=
                OPTICAL_GAIN * FINE_GAIN_PER_S * PERIOD_S * std::mem::replace(&mut late[k % LATE], seen);
            gimbal_rad += law.update(mirror_rad) * PERIOD_S;
            mirror_rad
        })
        .collect()
}

#[test]
fn gimbal_takes_over_a_constant_angle_with_the_time_constant_of_the_gain() {
    let angles = mirror_angles(off_load(&gains()), 12.0, |_| 200e-6);
    let peak = angles.iter().fold(0.0, |peak: f64, angle| peak.max(*angle));
    assert!(peak < 1.3 * OPTICAL_GAIN * 200e-6, "{peak}");
    let at = |t: f64| angles[(t / PERIOD_S) as usize];
    // Second order of gain 1 1/s and filter 2 Hz: the slow pole of s² + 12.57 s + 12.57 is 1.096 1/s.
    assert!((at(4.0) / at(3.0) - (-1.096_f64).exp()).abs() < 0.01, "{}", at(4.0) / at(3.0));
    assert!(at(11.9).abs() < 0.005 * peak);
    assert!(angles.iter().all(|angle| *angle > -0.01 * peak), "no swing to the other side");
}

#[test]
fn target_rate_leaves_v_over_k_without_an_integral_and_nothing_with_it() {
    let rate = 100e-6;
    let last = *mirror_angles(off_load(&gains()), 15.0, |t| rate * t).last().expect("not empty");
    assert!((last / OPTICAL_GAIN - rate / gains().gain_per_s).abs() < 1e-9, "{last}");
    let with = OffLoadGains { gain_per_s: 2.0, integral_time_s: 1.5, ..gains() };
    let last = *mirror_angles(off_load(&with), 15.0, |t| 118e-4 * t).last().expect("not empty");
    assert!(last.abs() < 1e-7, "{last}");
}

#[test]
fn rate_is_limited_and_does_not_wind_up() {
    let with = OffLoadGains { integral_time_s: 1.5, rate_limit_rad_per_s: 1e-3, ..gains() };
    let mut law = off_load(&with);
    for _ in 0..100_000 {
        assert!(law.update(10e-3) <= 1e-3);
    }
    let mut ticks = 0;
    while law.update(-1e-3) > 0.0 {
        ticks += 1;
    }
    // The filter forgets 4 mrad in some of its time constants of 80 ms.
    assert!(f64::from(ticks) * PERIOD_S < 0.4, "{ticks}");
}

#[test]
fn reset_goes_on_with_the_gimbals_rate() {
    let with = OffLoadGains { integral_time_s: 1.5, ..gains() };
    let mut law = off_load(&with);
    law.update(1e-3);
    law.reset(0.01);
    assert!((law.update(0.0) - 0.01).abs() < 1e-15);
    let mut law = off_load(&gains());
    law.update(1e-3);
    law.reset(0.01);
    assert_eq!(law.update(0.0), 0.0, "without an integral there is nothing to go on with");
}

#[test]
fn broken_angle_counts_as_the_centre_and_senseless_settings_are_refused() {
    let mut law = off_load(&gains());
    assert_eq!(law.update(f64::NAN), 0.0);
    assert_eq!(OffLoad::new(&gains(), 0.0, PERIOD_S), None);
    assert_eq!(OffLoad::new(&OffLoadGains { filter_hz: 1000.0, ..gains() }, 2.5, PERIOD_S), None);
}
