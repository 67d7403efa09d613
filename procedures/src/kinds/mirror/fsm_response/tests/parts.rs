//! Pieces: design, spectra, parabola, support.

use std::f64::consts::TAU;

use analysis::frf::{C64, Line};

use super::keys;
use crate::excitation::{Excitation, Injection, Signal};
use crate::kinds::mirror::fsm_response::lines;
use crate::kinds::mirror::fsm_response::response::{bandwidth_hz, gain_at};
use crate::kinds::mirror::fsm_response::spectra::{LineQuality, MirrorLine, amplitudes, find_reaction};

/// Lines of H at these frequencies, each with a relative scatter.
fn response(
    frequencies_hz: impl IntoIterator<Item = f64>,
    relative: f64,
    h: impl Fn(f64) -> C64,
) -> Vec<MirrorLine> {
    let judged = |frequency_hz: f64| {
        let value = h(frequency_hz);
        let variance = 2.0 * (relative * value.norm()).powi(2);
        let line = Line { frequency_hz, value, variance, dof: 5.0, coherence: None };
        MirrorLine { line, quality: LineQuality::Counts }
    };
    frequencies_hz.into_iter().map(judged).collect()
}

fn grid() -> impl Iterator<Item = f64> {
    (1..400).map(|k| 2.0 * f64::from(k))
}

/// A butter-like second order of 200 Hz.
fn second_order(f: f64) -> C64 {
    let r = f / 200.0;
    C64::new(1.0 - r * r, std::f64::consts::SQRT_2 * r).inv()
}

#[test]
fn the_multisine_spans_one_and_holds_every_multiple_where_a_support_may_be() {
    let keys = keys().multisine;
    let lines = lines(&keys);
    let signal = Signal::Multisine { period_s: keys.period_s, lines: lines.clone() };
    let played = Excitation { into: Injection::MirrorAz, signal, fade_s: 0.0, every_ticks: 1 };
    let values: Vec<f64> = (0..20_000).map(|k| played.at(f64::from(k) * 0.25 / 20_000.0)).collect();
    let (low, high) = values.iter().fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!((high - low - 1.0).abs() < 0.01, "{low} {high}");
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    assert!(high.max(-low) / rms < 3.0, "crest factor {}", high.max(-low) / rms);
    for k in 15..=62 {
        assert!(lines.iter().any(|l| (l.frequency_hz - 4.0 * f64::from(k)).abs() < 1e-9), "{k}");
    }
    assert!(lines.iter().all(|l| (l.frequency_hz * 0.25).fract() < 1e-9));
}

#[test]
fn amplitudes_of_whole_periods_are_exact_beside_an_offset_and_other_lines() {
    let samples: Vec<f64> = (0..400)
        .map(|k| {
            7.0 + (TAU * 3.0 * f64::from(k) / 400.0 + 0.4).cos()
                + 2.0 * (TAU * 9.0 * f64::from(k) / 400.0).sin()
        })
        .collect();
    let found = amplitudes(&samples, &[3, 9, 5]);
    assert!((found[0] - C64::from_polar(1.0, 0.4)).norm() < 1e-12);
    assert!((found[1] - C64::new(0.0, -2.0)).norm() < 1e-12);
    assert!(found[2].norm() < 1e-12);
}

#[test]
fn readings_are_those_of_the_closed_form_and_lines_that_do_not_count_are_not_read() {
    let mut lines = response(grid(), 1e-3, second_order);
    let found = bandwidth_hz(&lines, 0.0).expect("it falls");
    assert!((found.value - 200.0).abs() < 0.01, "{found:?}");
    let gain = gain_at(&lines, 100.0, 0.0).expect("inside");
    assert!((gain.value - 20.0 * second_order(100.0).norm().log10()).abs() < 1e-4, "{gain:?}");
    assert!((gain_at(&lines, 100.0, 0.01).expect("inside").u - 0.0869).abs() < 1e-3);
    // A spoilt line near 100 Hz that does not count changes nothing.
    lines[49].line.value *= 2.0;
    lines[49].quality = LineQuality::Reaction;
    let without = gain_at(&lines, 100.0, 0.0).expect("inside");
    assert!((without.value - gain.value).abs() < 1e-3);
    assert!(gain_at(&lines, 1000.0, 0.0).is_err());
    let flat = response(grid(), 1e-3, |_| C64::new(1.0, 0.0));
    assert!(bandwidth_hz(&flat, 0.0).expect_err("no fall").to_string().contains("798 Hz"));
    let lame = response(grid(), 1e-3, |_| C64::new(0.1, 0.0));
    assert_eq!(bandwidth_hz(&lame, 0.0).expect("an upper bound").value, 2.0);
    // An oscillation: one line far up stands out by chance, and must not pass for a bandwidth.
    let mut swinging = response(grid(), 1e-3, |_| C64::new(0.1, 0.0));
    swinging[..60].iter_mut().for_each(|l| l.quality = LineQuality::Noise);
    assert!(bandwidth_hz(&swinging, 0.0).expect_err("no number").to_string().contains("oscillate"));
}

#[test]
fn a_support_is_found_at_its_frequency_with_its_size_and_a_smooth_loop_has_none() {
    assert_eq!(find_reaction(&response(grid(), 1e-3, second_order), [60.0, 250.0]), None);
    for (hz, damping, size) in [(90.0, 0.02, 0.02), (141.3, 0.02, 0.05), (200.0, 0.01, 0.1)] {
        let shaken = |f: f64| {
            let r = f / hz;
            let damped = C64::new(0.0, 2.0 * damping * r);
            second_order(f) * (1.0 + size * damped / (C64::new(1.0 - r * r, 0.0) + damped))
        };
        let found = find_reaction(&response(grid(), 1e-3, shaken), [60.0, 250.0]).expect("visible");
        assert!((found.frequency_hz - hz).abs() < 2.5 * found.u_hz, "{found:?}");
        let size_db = 20.0 * (1.0_f64 + size).log10();
        assert!((found.size_db - size_db).abs() < 0.2 * size_db, "{found:?} {size_db}");
    }
}
