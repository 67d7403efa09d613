use super::*;

fn prior(value: f64, u: f64) -> Prior {
    Prior { value, u, range: [-1e9, 1e9], is_fixed: false }
}

fn observation(value: f64, u: f64, series: usize, parameters: &[usize]) -> Observation {
    Observation { value, u, dof: f64::INFINITY, series, parameters: parameters.to_vec() }
}

#[test]
fn values_of_one_parameter_are_weighted_by_their_inverse_variances() {
    let observations = [observation(10.0, 1.0, 0, &[0]), observation(13.0, 2.0, 1, &[0])];
    let found = Posterior::new(&[prior(0.0, 1e4)], &observations, &|_, x| x[0]);
    let one = &found.parameters[0];
    assert!((one.value - 10.6).abs() < 1e-5, "{one:?}");
    assert!((one.spread.u - 0.8_f64.sqrt()).abs() < 1e-6 && one.prior_ratio < 1e-3, "{one:?}");
    assert_eq!(one.shares.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [0, 1]);
    assert!((one.shares[0].1 - 0.8).abs() < 1e-6, "{one:?}");
    assert!((found.residuals_u[1] - 1.2).abs() < 1e-5, "{found:?}");
}

#[test]
fn values_of_one_series_are_no_better_together_than_one_of_them() {
    let of_series = |series: [usize; 4]| {
        let observations = series.map(|series| observation(5.0, 1.0, series, &[0]));
        Posterior::new(&[prior(0.0, 1e4)], &observations, &|_, x| x[0]).parameters[0].spread.u
    };
    assert!((of_series([0; 4]) - 1.0).abs() < 1e-6);
    assert!((of_series([0, 1, 2, 3]) - 0.5).abs() < 1e-6);
}

#[test]
fn a_sum_moves_both_parts_and_determines_neither() {
    let observations = [observation(2.4e-3, 1e-6, 0, &[0, 1])];
    let priors = [prior(0.9e-3, 2e-4), prior(1.1e-3, 2e-4)];
    let found = Posterior::new(&priors, &observations, &|_, x| x[0] + x[1]);
    let [a, b] = [&found.parameters[0], &found.parameters[1]];
    assert!((a.value - 1.1e-3).abs() < 1e-7 && (b.value - 1.3e-3).abs() < 1e-7, "{found:?}");
    assert!((a.prior_ratio - 0.5_f64.sqrt()).abs() < 1e-3, "{found:?}");
}

#[test]
fn a_parameter_without_a_value_keeps_its_prior_and_a_fixed_one_stays() {
    let observations = [observation(7.0, 0.1, 0, &[1, 2])];
    let fixed = Prior { is_fixed: true, ..prior(4.0, 1.0) };
    let found =
        Posterior::new(&[prior(3.0, 1.0), prior(0.0, 100.0), fixed], &observations, &|_, x| x[1] + x[2]);
    assert_eq!((found.parameters[0].value, found.parameters[0].prior_ratio), (3.0, 1.0));
    assert!((found.parameters[1].value - 3.0).abs() < 1e-4 && found.parameters[2].value == 4.0, "{found:?}");
}

#[test]
fn what_is_not_linear_is_solved_and_what_lies_beyond_a_range_stays_at_its_end() {
    let observations = [observation(9.0, 1e-3, 0, &[0]), observation(-2.0, 0.1, 1, &[1])];
    let bounded = Prior { range: [0.0, 10.0], ..prior(1.0, 5.0) };
    let predicted = |i: usize, x: &[f64]| if i == 0 { x[0] * x[0] } else { x[1] };
    let found = Posterior::new(&[bounded, bounded], &observations, &predicted);
    assert!((found.parameters[0].value - 3.0).abs() < 1e-3 && !found.parameters[0].is_at_end, "{found:?}");
    assert!(found.parameters[1].value == 0.0 && found.parameters[1].is_at_end, "{found:?}");
}

#[test]
fn a_parameter_at_the_end_of_its_range_leaves_the_others_to_explain_the_values() {
    let observations = [observation(1.0, 1e-3, 0, &[0, 1])];
    let bounded = Prior { range: [0.0, 1e9], ..prior(0.0, 10.0) };
    let found = Posterior::new(&[prior(3.0, 1.0), bounded], &observations, &|_, x| x[0] + x[1]);
    assert!((found.parameters[0].value - 1.0).abs() < 1e-4, "{found:?}");
    assert!(found.parameters[1].value == 0.0 && found.parameters[1].is_at_end, "{found:?}");
}

#[test]
fn what_was_counted_is_taken_as_it_is() {
    let found = Posterior::new(&[prior(24.0, 2.0)], &[observation(26.0, 0.0, 0, &[0])], &|_, x| x[0]);
    assert!((found.parameters[0].value - 26.0).abs() < 1e-6, "{found:?}");
}

/// The components of a magnitude that is known to a part in a hundred lie in a narrow ring; the priors draw along it.
#[test]
fn a_ring_is_followed_to_the_place_that_the_priors_prefer() {
    let observations = [observation(2.0, 0.002, 0, &[0, 1])];
    let priors = [prior(0.3, 0.1), prior(-2.9, 0.3)];
    let found = Posterior::new(&priors, &observations, &|_, x| x[0].hypot(x[1]));
    let cost = |x: f64, y: f64| ((x - 0.3) / 0.1).powi(2) + ((y + 2.9) / 0.3).powi(2);
    let [x, y] = [found.parameters[0].value, found.parameters[1].value];
    assert!((x.hypot(y) - 2.0).abs() < 0.01, "{found:?}");
    for turn in [-0.05_f64, 0.05] {
        let (sin, cos) = turn.sin_cos();
        assert!(cost(cos * x - sin * y, sin * x + cos * y) > cost(x, y), "{found:?}");
    }
}
