use super::*;

/// A response with a relative error of each line, from its index, times a factor.
fn lines(seed: f64, relative_sd: f64, factor: f64) -> Vec<Line> {
    let at = |k: u32| {
        let (hz, seed) = (1.3_f64.powi(k as i32), seed * f64::from(k + 1));
        let error = C64::from_polar(relative_sd, 2.4 * seed * seed);
        let value = C64::new(0.0, -1.0 / hz) * (factor * (1.0 + error));
        Line { variance: (relative_sd * value.norm()).powi(2), ..Line::exact(hz, value) }
    };
    (0..16).map(at).collect()
}

#[test]
fn a_response_that_does_not_care_for_the_gains_departs_by_no_more_than_its_noise() {
    let (estimate, flags) = departure(&lines(1.0, 0.01, 1.0), &lines(1.7, 0.01, 1.0)).expect("lines");
    assert!(estimate.value < 2.0 * estimate.u && estimate.u < 0.01, "{estimate:?} {flags:?}");
}

#[test]
fn one_that_does_departs_by_what_it_cares() {
    let (estimate, flags) = departure(&lines(1.0, 0.001, 1.0), &lines(1.7, 0.001, 1.05)).expect("lines");
    assert!((estimate.value - 0.05).abs() < 2.0 * estimate.u.max(5e-4), "{estimate:?}");
    assert!(flags[1].starts_with("most at"), "{flags:?}");
}

#[test]
fn few_common_lines_give_no_number() {
    assert!(departure(&lines(1.0, 0.01, 1.0)[..4], &lines(1.7, 0.01, 1.0)).is_none());
    assert!(departure(&[], &[]).is_none());
}
