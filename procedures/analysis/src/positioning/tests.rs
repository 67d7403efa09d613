//! Tables worked by hand, and refusals.

use super::*;

/// Deviations in µrad.
fn target(deg: f64, up: &[f64], down: &[f64]) -> Target {
    let rad = |all: &[f64]| all.iter().map(|x| x * 1e-6).collect();
    Target { target_rad: deg.to_radians(), up_rad: rad(up), down_rad: rad(down) }
}

fn same(found_rad: f64, expected_urad: f64) {
    assert!(
        (found_rad * 1e6 - expected_urad).abs() < 1e-12 * expected_urad.abs().max(1.0),
        "{found_rad:e}, {expected_urad}"
    );
}

/// Squares of the deviations from the means are whole numbers: 40 → s² = 10, 10 → 2.5, 0, 16 → 4.
fn table() -> Vec<Target> {
    vec![
        // Means 10 and 4; s = √10 and √2.5.
        target(0.0, &[6.0, 8.0, 10.0, 12.0, 14.0], &[2.0, 3.0, 4.0, 5.0, 6.0]),
        // Means −7 and −7; s = 0 and 2.
        target(40.0, &[-7.0; 5], &[-9.0, -9.0, -7.0, -5.0, -5.0]),
        // Means 20 and 29; s = 2 and 0.
        target(80.0, &[18.0, 18.0, 20.0, 22.0, 22.0], &[29.0; 5]),
    ]
}

#[test]
fn a_table_worked_by_hand_comes_out_to_twelve_digits() {
    let found = positioning(&table()).expect("five runs at three targets");
    let root_10 = 10.0_f64.sqrt();
    let root_2_5 = 2.5_f64.sqrt();
    let [first, second, third] = found.targets.as_slice() else { panic!("three targets") };
    same(first.up.deviation_rad, root_10);
    same(first.down.deviation_rad, root_2_5);
    same(first.mean_rad, 7.0);
    same(first.reversal_rad, 6.0);
    same(first.repeatability_rad, 2.0 * root_10 + 2.0 * root_2_5 + 6.0);
    same(second.reversal_rad, 0.0);
    // Here 4s of one direction is more than 2s of both.
    same(second.repeatability_rad, 8.0);
    same(third.repeatability_rad, 4.0 + 9.0);
    same(found.reversal_rad, 9.0);
    same(found.mean_reversal_rad, -1.0);
    same(found.one_way_repeatability_rad[0], 4.0 * root_10);
    same(found.one_way_repeatability_rad[1], 8.0);
    same(found.repeatability_rad, 2.0 * root_10 + 2.0 * root_2_5 + 6.0);
    same(found.one_way_systematic_rad[0], 27.0);
    same(found.one_way_systematic_rad[1], 36.0);
    same(found.systematic_rad, 36.0);
    same(found.mean_range_rad, 31.5);
    // Up: 20 + 4 − (−7); down: 29 − (−7 − 4).
    same(found.one_way_accuracy_rad[0], 31.0);
    same(found.one_way_accuracy_rad[1], 40.0);
    same(found.accuracy_rad, 40.0);
}

#[test]
fn uncertainties_follow_from_runs_and_instrument() {
    let found = positioning(&table()).expect("five runs at three targets");
    // The ends of A are 29 with s = 0 and −7 − 2·2 with s = 2, the instrument counts at both.
    let accuracy = found.accuracy(3e-6);
    same(accuracy.u, (4.0 * (0.2 + 0.5) + 18.0_f64).sqrt());
    assert_eq!(accuracy.n, 30);
    let repeatability = found.repeatability(0.0);
    same(repeatability.u, ((4.0 / 8.0 + 0.2) * 12.5_f64).sqrt());
    same(found.systematic(3e-6).u, (4.0 / 5.0 + 18.0_f64).sqrt());
}

#[test]
fn a_pose_worked_by_hand_comes_out_to_twelve_digits() {
    // Mean 3, distances 2 1 0 1 2: mean 1.2, squares about it 0.64 + 0.04 + 1.44 + 0.04 + 0.64 = 2.8, S = √0.7.
    let runs: Vec<f64> = [1.0, 2.0, 3.0, 4.0, 5.0].iter().map(|x| x * -1e-6).collect();
    let found = pose(0.0, &runs, 2e-6).expect("five cycles");
    same(found.accuracy.value, 3.0);
    same(found.accuracy.u, (0.5 + 4.0_f64).sqrt());
    same(found.repeatability.value, 1.2 + 3.0 * 0.7_f64.sqrt());
}

#[test]
fn one_run_and_four_runs_are_refused_with_what_is_needed() {
    for runs in [1, 4] {
        let mut few = table();
        few[1].down_rad.truncate(runs);
        let error = positioning(&few).expect_err("too few");
        let words = error.to_string();
        assert!(
            words.contains(&format!("{runs} runs downwards at target 40")) && words.contains("at least 5"),
            "{words}"
        );
        assert!(pose(0.0, &few[0].up_rad[..runs], 0.0).is_err());
    }
}

#[test]
fn a_longer_travel_needs_more_targets() {
    assert_eq!(
        [60.0, 90.0, 90.1, 180.0, 181.0, 318.0].map(|deg: f64| targets_needed(deg.to_radians())),
        [3, 3, 5, 5, 8, 8]
    );
    let mut wide = table();
    wide[2].target_rad = 200_f64.to_radians();
    let error = positioning(&wide).expect_err("three targets over 200 deg");
    assert!(matches!(error, PositioningError::FewTargets { found: 3, needed: 8, .. }), "{error}");
    assert!(matches!(positioning(&[]), Err(PositioningError::FewTargets { found: 0, needed: 3, .. })));
}

#[test]
fn targets_out_of_order_and_broken_values_are_refused() {
    let mut mixed = table();
    mixed.swap(0, 1);
    assert!(matches!(positioning(&mixed), Err(PositioningError::NotAscending { .. })));
    let mut broken = table();
    broken[0].up_rad[2] = f64::NAN;
    assert!(matches!(positioning(&broken), Err(PositioningError::NotANumber { .. })));
    assert!(pose(0.0, &[f64::NAN; 6], 0.0).is_err());
}
