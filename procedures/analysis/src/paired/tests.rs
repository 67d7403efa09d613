use proptest::prelude::*;

use super::*;
use crate::synthetic_noise::gaussian;

fn is_near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

const DIFFERENCES: [f64; 8] = [0.12, -0.05, 0.33, 0.21, 0.08, 0.17, -0.02, 0.26];

/// By scipy 1.17.1: d = DIFFERENCES; u = d.std(ddof=1) / sqrt(8); ends d.mean() -+ t.ppf(0.5 + level / 2, 7) u;
/// p = t.sf((d.mean() - bound) / u, 7).
#[test]
fn mean_interval_and_p_of_eight_differences_agree_with_scipy() {
    let found = mean(&DIFFERENCES).expect("eight numbers");
    assert!(is_near(found.value, 0.1375, 1e-14) && is_near(found.u, 0.046665603729391214, 1e-13));
    assert_eq!((found.dof, found.n), (7.0, 8));
    let expected = [
        (0.9, 0.04908834558068702, 0.225911654419313),
        (0.968, 0.012903150630033444, 0.2620968493699666),
        (0.95, 0.027153381706262886, 0.24784661829373714),
    ];
    for (level, low, high) in expected {
        let ends = interval(&found, level);
        assert!(is_near(ends[0], low, 1e-9) && is_near(ends[1], high, 1e-9), "{level}: {ends:?}");
    }
    for (bound, p) in [(0.0, 0.010756857513262602), (0.1, 0.22402887524177642), (0.3, 0.9948822443301725)] {
        assert!(is_near(p_not_above(&found, bound), p, 1e-9), "{bound}: {}", p_not_above(&found, bound));
    }
}

/// By scipy 1.17.1: t.ppf(0.5 + level / 2, dof) for the levels 0.9, 0.968 and 0.99.
#[test]
fn quantiles_agree_with_scipy_from_one_degree_of_freedom_to_a_thousand() {
    let expected = [
        (1.0, [6.313751514675037, 19.877609902728256, 63.656741162871526]),
        (2.0, [2.9199855803537242, 5.4551012897379625, 9.924843200918287]),
        (4.0, [2.1318467863266495, 3.2291938387709678, 4.604094871349992]),
        (9.0, [1.833112932656237, 2.5344664651646887, 3.249835541592126]),
        (19.0, [1.7291328115213682, 2.314298382064074, 2.8609346064649794]),
        (39.0, [1.6848751217112248, 2.2241187682586774, 2.707913183517662]),
        (1000.0, [1.6463788172854643, 2.147416066498563, 2.580754698065951]),
    ];
    for (dof, row) in expected {
        for (level, quantile) in [0.9, 0.968, 0.99].into_iter().zip(row) {
            let found = t_quantile(level, dof);
            assert!(is_near(found, quantile, 1e-9), "{dof} {level}: {found}, expected {quantile}");
        }
    }
    assert!((t_quantile(0.9, 2e6) - 1.644_854).abs() < 1e-5, "as the normal distribution");
}

#[test]
fn equal_differences_have_an_interval_without_width_and_a_p_of_nought_or_one() {
    let found = mean(&[0.25; 4]).expect("four numbers");
    assert_eq!(interval(&found, 0.9), [0.25, 0.25]);
    assert_eq!([p_not_above(&found, 0.0), p_not_above(&found, 0.25)], [0.0, 1.0]);
    assert_eq!(pairs_to_decide(&found, 0.1, 0.9), Some(2));
    assert!(interval(&mean(&DIFFERENCES).expect("eight numbers"), 1.0).iter().all(|end| end.is_infinite()));
}

#[test]
fn one_difference_and_one_that_is_no_number_are_refused() {
    assert_eq!(mean(&[0.1]), Err(PairedError::TooFew { found: 1 }));
    assert_eq!(mean(&[]), Err(PairedError::TooFew { found: 0 }));
    let refused = mean(&[0.1, f64::INFINITY]).expect_err("no number");
    assert_eq!(refused.to_string(), "difference 1 is inf, expected a finite number");
}

#[test]
fn a_log_ratio_needs_values_above_zero() {
    let tenth = log_ratio(2.0, 2.2).expect("both above zero");
    assert!(is_near(tenth, 1.1_f64.ln(), 1e-12));
    assert_eq!(log_ratio(3e-6, 3e-6), Ok(0.0));
    assert!(log_ratio(1e-300, 1e300).is_ok_and(f64::is_finite));
    for (baseline, candidate) in [(0.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
        assert!(matches!(log_ratio(baseline, candidate), Err(PairedError::NotPositive { .. })));
    }
}

#[test]
fn the_pairs_to_decide_make_the_interval_just_narrow_enough() {
    let found = mean(&DIFFERENCES).expect("eight numbers");
    let wanted = pairs_to_decide(&found, 0.2, 0.968).expect("a number");
    let is_decided = |pairs: u64| {
        let n = pairs as f64;
        let half = t_quantile(0.968, n - 1.0) * scatter(&found) / n.sqrt();
        found.value + half <= 0.2 || half < found.value
    };
    assert!(is_decided(wanted) && !is_decided(wanted - 1), "{wanted}");
    // A mean of nothing must come inside of the margins: about (t s / margin)^2.
    let still = Estimate { value: 0.0, u: 0.1, dof: 3.0, n: 4 };
    assert_eq!(pairs_to_decide(&still, 0.1, 0.9), Some(13), "1.782·0.2/√13 = 0.0989, 1.796·0.2/√12 = 0.1037");
    assert_eq!(pairs_to_decide(&still, 1e-9, 0.9), None);
}

/// By scipy 1.17.1: nct.sf(t.ppf(0.5 + level / 2, n - 1), n - 1, effect * sqrt(n) / scatter).
#[test]
fn without_a_margin_the_power_is_that_of_the_noncentral_t_distribution() {
    let expected = [
        (1.0, 1.0, 0.9, 2, 0.17956248755732773),
        (1.0, 1.0, 0.9, 5, 0.5797373588621888),
        (0.5, 1.0, 0.9, 20, 0.6951493382443412),
        (0.8, 1.0, 0.968, 10, 0.5244026980752203),
        (0.3, 2.0, 0.99, 200, 0.31840266427109026),
        (0.0, 1.0, 0.9, 20, 0.05),
        (2.0, 1.0, 0.99, 8, 0.9509202299650695),
    ];
    for (effect, scatter, level, pairs, power) in expected {
        let found = Plan { call: PlannedCall::Worse, effect, margin: 0.0, scatter, level }.probability(pairs);
        assert!((found - power).abs() < 1e-9, "{effect} {pairs}: {found}, expected {power}");
    }
}

/// By scipy 1.17.1: the integrals of the documentation over chi2.pdf with integrate.quad, tolerance 1e-13.
#[test]
fn with_a_margin_the_power_agrees_with_the_integral_by_another_rule() {
    use PlannedCall::{Equivalent, Worse};
    let expected = [
        (Worse, 2.0, 1.5, 12, 0.9961689707634049),
        (Worse, 2.0, 1.5, 40, 0.9999999964965037),
        (Equivalent, 0.0, 1.0, 12, 0.8893810960387016),
        (Equivalent, 1.0 / 3.0, 1.0, 20, 0.8902244613668195),
        (Equivalent, 1.0 / 3.0, 1.0, 5, 0.23925780403483543),
        (Equivalent, 0.0, 1.0, 2, 0.08647427646637458),
    ];
    for (call, effect, scatter, pairs, power) in expected {
        let found = Plan { call, effect, margin: 1.0, scatter, level: 0.9 }.probability(pairs);
        assert!((found - power).abs() < 1e-9, "{call:?} {pairs}: {found}, expected {power}");
    }
}

/// By scipy 1.17.1: the first n whose power by nct.sf, or by the integral, reaches the one that is asked for.
#[test]
fn the_planned_number_of_pairs_is_the_first_that_has_the_power() {
    let worse = |effect, level| Plan { call: PlannedCall::Worse, effect, margin: 0.0, scatter: 1.0, level };
    assert_eq!(worse(1.0, 0.9).pairs(0.999), Some(24));
    assert_eq!(worse(0.5, 0.9).pairs(0.9), Some(36));
    assert_eq!(worse(0.25, 0.99).pairs(0.999), Some(517));
    let equivalent =
        Plan { call: PlannedCall::Equivalent, effect: 1.0 / 3.0, margin: 1.0, scatter: 1.0, level: 0.9 };
    assert_eq!(equivalent.pairs(0.999), Some(52));
    assert_eq!(Plan { effect: 1.0, ..equivalent }.pairs(0.9), None, "on the margin no number suffices");
    assert_eq!(Plan { margin: 2.0, ..worse(1.0, 0.9) }.pairs(0.9), None, "such an effect is equivalent");
    assert_eq!(Plan { scatter: 0.0, ..equivalent }.pairs(0.999), Some(2));
    assert_eq!(equivalent.probability(1), 0.0);
}

/// By scipy 1.17.1: sqrt(dof / chi2.ppf(1 - confidence, dof)).
#[test]
fn the_scatter_of_a_pilot_has_an_upper_limit() {
    let limit = scatter_at_most(2.0, 9.0, 0.9).expect("nine degrees of freedom");
    assert!(is_near(limit, 2.0 * 1.4694307221378702, 1e-9), "{limit}");
    let limit = scatter_at_most(1.0, 19.0, 0.95).expect("nineteen degrees of freedom");
    assert!(is_near(limit, 1.3704103976822324, 1e-9), "{limit}");
    assert_eq!([scatter_at_most(1.0, 0.0, 0.9), scatter_at_most(1.0, 9.0, 1.0)], [None, None]);
}

/// 4000 samples of ten: the number of intervals that hold the true mean is binomial with p = level.
#[test]
fn the_interval_covers_the_true_mean_as_often_as_its_level_says() {
    const SAMPLES: u64 = 4000;
    for (level, seed) in [(0.9, 11), (0.968, 12)] {
        let mut noise = gaussian(seed);
        let covered = (0..SAMPLES).filter(|_| {
            let differences: Vec<f64> = (0..10).map(|_| 0.3 + noise()).collect();
            let [low, high] = interval(&mean(&differences).expect("ten numbers"), level);
            low <= 0.3 && 0.3 <= high
        });
        let covered = covered.count() as u64;
        let tail = |p: Result<f64, crate::proportion::ProportionError>| p.expect("a probability");
        let few = tail(crate::proportion::probability_of_at_most(covered, SAMPLES, level));
        let many = tail(crate::proportion::probability_of_at_least(covered, SAMPLES, level));
        assert!(few > 0.005 && many > 0.005, "{covered} of {SAMPLES} at {level}: {few}, {many}");
    }
}

proptest! {
    #[test]
    fn the_interval_and_the_one_sided_p_decide_alike(differences in prop::collection::vec(-1.0..1.0_f64, 2..20)) {
        let found = mean(&differences).expect("two numbers or more");
        let [low, _] = interval(&found, 0.9);
        let p = p_not_above(&found, 0.0);
        prop_assume!((p - 0.05).abs() > 1e-7);
        prop_assert_eq!(low > 0.0, p < 0.05);
    }

    #[test]
    fn a_mean_moves_and_scales_with_its_differences(differences in prop::collection::vec(-1.0..1.0_f64, 2..20), factor in 0.1..10.0_f64) {
        let found = mean(&differences).expect("two numbers or more");
        let scaled: Vec<f64> = differences.iter().map(|d| factor * d).collect();
        let scaled = mean(&scaled).expect("two numbers or more");
        prop_assert!((scaled.u - factor * found.u).abs() < 1e-12 && (scaled.value - factor * found.value).abs() < 1e-12);
        prop_assert!((p_not_above(&scaled, 0.0) - p_not_above(&found, 0.0)).abs() < 1e-6);
    }
}
