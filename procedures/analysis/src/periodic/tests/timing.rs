//! Hold, delays, integrals.

use std::f64::consts::TAU;

use super::plant::Mode;
use crate::frf::{C64, Frf, Line};
use crate::periodic::{PeriodicError, Timing, times_jw};

const MODE: Mode = Mode { natural_hz: 20.0, zeta: 0.1 };
const RATE_HZ: f64 = 4000.0;

fn frf(of: impl Fn(f64) -> C64) -> Frf {
    let line = |k: i32| {
        let f = 2.0 * f64::from(k);
        Line { variance: 0.01, dof: 7.0, ..Line::exact(f, of(f)) }
    };
    (1..50).map(line).collect()
}

#[test]
fn hold_and_half_a_sample_turn_the_sampled_plant_into_the_continuous_one() {
    let sampled = frf(|f| MODE.sampled_at(f, RATE_HZ));
    let timing = Timing { hold_s: 1.0 / RATE_HZ, command_delay_s: 0.0, sensor_delay_s: 0.0 };
    let continuous = timing.removed(&sampled).expect("far below the sample rate");
    for line in &continuous {
        let truth = MODE.at(line.frequency_hz);
        // What folds back: about (f/f_s)² of what a plant of slope −2 has at f.
        let ratio = line.value / truth;
        assert!((ratio - 1.0).norm() < 2.0 * (line.frequency_hz / RATE_HZ).powi(2), "{line:?}");
    }
    let uncorrected = sampled.last().expect("lines");
    assert!((uncorrected.value / MODE.at(uncorrected.frequency_hz) - 1.0).norm() > 0.07);
}

#[test]
fn what_is_taken_out_can_be_put_back_and_the_variance_goes_along() {
    let timing = Timing { hold_s: 2e-3, command_delay_s: 1e-3, sensor_delay_s: 0.5e-3 };
    let before = frf(|f| MODE.at(f));
    let there = timing.applied(&before);
    let factor = timing.response(there[48].frequency_hz);
    assert!((there[48].variance / (0.01 * factor.norm_sqr()) - 1.0).abs() < 1e-12);
    let back = timing.removed(&there).expect("no zero of the hold");
    for (a, b) in before.iter().zip(&back) {
        assert!((a.value - b.value).norm() < 1e-12 && (a.variance - b.variance).abs() < 1e-14);
    }
}

#[test]
fn a_pure_delay_turns_the_phase_and_nothing_else() {
    let timing = Timing { hold_s: 0.0, command_delay_s: 1.5e-3, sensor_delay_s: 1e-3 };
    let factor = timing.response(50.0);
    assert!((factor - C64::from_polar(1.0, -TAU * 50.0 * 2.5e-3)).norm() < 1e-12);
}

#[test]
fn at_the_zero_of_the_hold_nothing_can_be_divided_out() {
    let timing = Timing { hold_s: 0.1, command_delay_s: 0.0, sensor_delay_s: 0.0 };
    let refused = timing.removed(&frf(|f| MODE.at(f)));
    assert_eq!(refused, Err(PeriodicError::HoldZero { frequency_hz: 10.0, hold_s: 0.1 }));
}

#[test]
fn a_derivative_of_an_integral_is_the_response_itself() {
    let lines = frf(|f| MODE.at(f));
    let rate = times_jw(&lines, 1).expect("derivative");
    assert!((rate[0].value / lines[0].value - C64::new(0.0, TAU * 2.0)).norm() < 1e-9);
    assert!((rate[0].variance / 0.01 - (TAU * 2.0).powi(2)).abs() < 1e-9);
    let back = times_jw(&times_jw(&lines, -2).expect("integral"), 2).expect("derivative");
    assert!(lines.iter().zip(&back).all(|(a, b)| (a.value - b.value).norm() < 1e-12));
    assert!(times_jw(&[Line::exact(0.0, C64::new(1.0, 0.0))], -1).is_err());
}
