use std::f64::consts::TAU;

use analysis::frf::C64;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::super::plant::*;

/// A response with complex normal errors of each line, times a factor.
fn lines(seed: u64, relative_sd: f64, factor: f64) -> Vec<Line> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
    let mut line = |k: u32| {
        let hz = 1.3_f64.powi(k as i32);
        // |error|² of a complex normal number is exponential.
        let error = C64::from_polar(relative_sd * (-uniform().ln()).sqrt(), TAU * uniform());
        let value = C64::new(0.0, -1.0 / hz) * (factor * (1.0 + error));
        Line { variance: (relative_sd * value.norm()).powi(2), ..Line::exact(hz, value) }
    };
    (0..16).map(&mut line).collect()
}

#[test]
fn a_response_that_does_not_care_for_the_gains_departs_by_no_more_than_its_noise() {
    // Of 40 pairs, as many as chance lets through at 2 u.
    let stands_out = |seed: &u64| {
        let (estimate, _) =
            departure(&lines(*seed, 0.01, 1.0), &lines(1000 + seed, 0.01, 1.0)).expect("lines");
        assert!(estimate.u < 0.01, "{estimate:?}");
        estimate.value > 2.5 * estimate.u
    };
    assert!((0..40).filter(stands_out).count() <= 2);
}

#[test]
fn one_that_does_departs_by_what_it_cares() {
    let (estimate, flags) = departure(&lines(1, 0.001, 1.0), &lines(2, 0.001, 1.05)).expect("lines");
    assert!((estimate.value - 0.05).abs() < 2.0 * estimate.u.max(5e-4), "{estimate:?}");
    assert!(flags[1].starts_with("most at"), "{flags:?}");
}

#[test]
fn few_common_lines_give_no_number() {
    assert!(departure(&lines(1, 0.01, 1.0)[..4], &lines(2, 0.01, 1.0)).is_none());
    assert!(departure(&[], &[]).is_none());
}

/// Lines of a free inertia of 1000 kg·m², each known to 0.1 %, whose sizes are off by this share in turns.
fn lines_of_inertia(off_ratio: f64) -> Vec<Line> {
    let one = |k: u32| {
        let frequency_hz = 1.0 + 0.25 * f64::from(k);
        let off = if k.is_multiple_of(2) { off_ratio } else { -off_ratio };
        let shown_kg_m2 = 1000.0 * (1.0 + off) * (1.0 + 0.015 * (frequency_hz / STIFF_HZ).powi(2));
        let value = C64::new(-1.0 / (shown_kg_m2 * (TAU * frequency_hz).powi(2)), 0.0);
        let variance = (1e-3 * value.norm()).powi(2);
        Line { frequency_hz, value, variance, dof: 40.0, coherence: None }
    };
    (0..17).map(one).collect()
}

#[test]
fn lines_of_an_inertia_that_scatter_beyond_their_noise_widen_it_say_so_and_contradict_it_in_the_end() {
    let found = |off_ratio: f64| inertia("az", &lines_of_inertia(off_ratio));
    let quiet = found(0.0).expect("an inertia");
    assert_eq!(quiet.flags, Vec::<String>::new());
    assert!((quiet.value.expect("a value") - 1000.0).abs() < 3.0 * quiet.u + 1.0, "{quiet:?}");
    let wide = found(0.02).expect("an inertia");
    assert!(wide.flags.iter().any(|flag| flag.contains("chi2/dof")), "{wide:?}");
    assert!(wide.u > 5.0 * quiet.u, "{} {}", wide.u, quiet.u);
    let none = found(0.4).expect_err("a contradiction").to_string();
    assert!(none.contains("does not describe"), "{none}");
}
