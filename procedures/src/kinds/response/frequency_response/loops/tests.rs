use std::f64::consts::TAU;

use analysis::frf::{C64, Line};

use super::super::loops::*;
use crate::measurement::Bound;

/// 20·e^(−0.01·s)/(s·(1 + s/40)): 0 dB at 2.9 Hz, −180° at 7.6 Hz.
fn lines(relative_sd: f64) -> Vec<Line> {
    let line = |k: u32| {
        let hz = 0.5 * f64::from(k);
        let s = C64::new(0.0, TAU * 0.5 * f64::from(k));
        let value = 20.0 * (-s * 0.01).exp() / (s * (1.0 + s / 40.0));
        Line { variance: (relative_sd * value.norm()).powi(2), dof: 10.0, ..Line::exact(hz, value) }
    };
    (1..80).map(line).collect()
}

/// What touches bandwidth, gain and phase margin of a loop.
fn touching(judged: &Judged) -> [Vec<String>; 3] {
    let found = margins(&judged.lines, &Settings::default()).expect("margins");
    let all = numbers(judged, &found);
    [0, 1, 2].map(|k| doubts(judged, &found, k == 0, all[k].1).0)
}

#[test]
fn a_number_read_across_a_line_that_does_not_count_is_not_certified_and_others_are() {
    let (hollow, counting) = lines(1e-3).into_iter().partition(|l| (l.frequency_hz - 3.0).abs() < 0.3);
    let judged = Judged { lines: counting, hollow, ..Judged::default() };
    let [bandwidth, gain, phase] = touching(&judged);
    assert!(bandwidth[0].contains("across the line at 3.00 Hz"), "{bandwidth:?}");
    assert_eq!(phase, bandwidth);
    assert_eq!(gain, [""; 0]);
}

#[test]
fn a_circle_that_reaches_minus_one_takes_every_margin_but_not_the_bandwidth() {
    let judged = Judged { lines: lines(0.5), ..Judged::default() };
    let [bandwidth, gain, phase] = touching(&judged);
    assert_eq!(bandwidth, [""; 0]);
    for margin in [gain, phase] {
        assert!(margin.iter().any(|doubt| doubt.contains("reaches")), "{margin:?}");
    }
}

#[test]
fn a_clean_loop_is_certified() {
    let judged = Judged { lines: lines(1e-3), ..Judged::default() };
    assert_eq!(touching(&judged).concat(), [""; 0]);
}

/// It crosses somewhere below 6 Hz: at 2.9 Hz, and a limit of 4 Hz would be neither met nor missed.
#[test]
fn bandwidth_of_a_loop_that_is_below_0_db_from_its_first_line_on_is_a_bound() {
    let from_six = lines(1e-3).into_iter().filter(|l| l.frequency_hz >= 6.0).collect();
    let judged = Judged { lines: from_six, ..Judged::default() };
    let (estimate, bound) = at_most(&judged, 0).expect("a bound");
    assert_eq!(estimate.value, 6.0);
    assert_eq!(bound, Bound::AtMost("the loop is below 0 dB at its lowest line".to_owned()));
    let whole = Judged { lines: lines(1e-3), ..Judged::default() };
    assert_eq!(at_most(&whole, 0), None);
    assert_eq!(at_most(&judged, 1), None, "a margin is not bounded by it");
}
