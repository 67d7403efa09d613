//! Many tests at once: p values adjusted so that the probability of any false rejection among them stays below a level.

/// p values adjusted by Holm's step-down procedure, in the order given.
///
/// Rejecting every hypothesis whose adjusted value is at most α keeps the probability of rejecting any true one at most α,
/// however the tests depend on each other (Holm, *Scand. J. Statist.* 6, 65, 1979). Equal values are adjusted alike, and the order of
/// the tests does not matter. What is no number counts as 1: a test that says nothing still belongs to the family.
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let p_values: Vec<f64> =
        p_values.iter().map(|p| if p.is_nan() { 1.0 } else { p.clamp(0.0, 1.0) }).collect();
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|a, b| p_values[*a].total_cmp(&p_values[*b]));
    let mut adjusted = vec![1.0; p_values.len()];
    let mut largest: f64 = 0.0;
    for (rank, index) in order.into_iter().enumerate() {
        let remaining = (p_values.len() - rank) as f64;
        largest = largest.max(remaining * p_values[index]).min(1.0);
        adjusted[index] = largest;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn adjusted_values_are_those_of_the_step_down_by_hand() {
        // Four tests, ascending 0.005, 0.01, 0.03, 0.04: times 4, 3, 2, 1, and never below the one before.
        let adjusted = holm(&[0.01, 0.04, 0.03, 0.005]);
        let expected = [0.03, 0.06, 0.06, 0.02];
        for (found, expected) in adjusted.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{adjusted:?}");
        }
    }

    #[test]
    fn a_test_that_says_nothing_makes_the_family_larger_and_is_never_rejected() {
        let adjusted = holm(&[0.02, f64::NAN]);
        assert_eq!(adjusted, [0.04, 1.0]);
        assert!(holm(&[]).is_empty());
        assert_eq!(holm(&[0.7, 2.0, -1.0]), [1.0, 1.0, 0.0]);
    }

    proptest! {
        #[test]
        fn the_order_of_the_tests_does_not_matter(p in prop::collection::vec(0.0..=1.0_f64, 0..12), turn in 0..12_usize) {
            let mut turned = p.clone();
            let turn = turn.min(p.len());
            turned.rotate_left(turn);
            let mut expected = holm(&p);
            expected.rotate_left(turn);
            prop_assert_eq!(holm(&turned), expected);
        }

        #[test]
        fn an_adjusted_value_lies_between_its_own_and_that_of_bonferroni(p in prop::collection::vec(0.0..=1.0_f64, 1..12)) {
            for (own, adjusted) in p.iter().zip(holm(&p)) {
                prop_assert!(adjusted >= *own && adjusted <= 1.0);
            }
            let least = p.iter().copied().fold(1.0, f64::min);
            let least_adjusted = holm(&p).into_iter().fold(1.0, f64::min);
            prop_assert!((least_adjusted - (least * p.len() as f64).min(1.0)).abs() < 1e-15);
        }
    }
}
