use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

/// Units whose value is twice the first of twenty settings, less the second, with a limit of 1.2.
fn units(count: usize, sets: usize, seed: u64) -> Vec<MeasuredUnit> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    (0..count)
        .map(|k| {
            let settings_si: Vec<(String, f64)> =
                (0..20).map(|s| (format!("setting-{s}"), uniform())).collect();
            let value = 2.0 * settings_si[0].1 - settings_si[1].1;
            let verdict = if value <= 1.2 { Verdict::Pass } else { Verdict::Fail };
            let reading = Reading {
                requirement: "VEL-BW".to_owned(),
                measurand: "velocity-bandwidth".to_owned(),
                kind: QuantityKind::Frequency,
                value_si: Some(value),
                verdict,
            };
            MeasuredUnit {
                id: format!("unit-{k}"),
                set: k * sets / count,
                settings_si,
                readings: vec![reading],
            }
        })
        .collect()
}

/// P(2a − b ≤ 1.2) of independent uniform a and b.
const PASS_PROBABILITY: f64 = 0.84;

#[test]
fn independent_units_have_exact_intervals_and_name_the_settings_that_matter() {
    let rows = evaluate(&units(400, 1, 1), Draws::Independent);
    let [row] = rows.as_slice() else { panic!("{rows:?}") };
    let [Some(low), Some(high)] = row.pass.interval.expect("independent") else { panic!("{row:?}") };
    assert!(low < PASS_PROBABILITY && PASS_PROBABILITY < high && high - low < 0.1, "{low} {high}");
    assert_eq!((row.units, row.inconclusive, row.settings_tested), (400, 0, 20));
    assert!((row.quantiles[1].estimated.value - 0.5).abs() < 0.1);
    assert!(
        row.quantiles
            .iter()
            .all(|q| q.estimated.interval.is_some_and(|ends| ends.iter().all(Option::is_some)))
    );
    let found: Vec<&str> = row.sensitivities.iter().map(|one| one.setting.as_str()).collect();
    assert_eq!(found, ["setting-0", "setting-1"]);
    assert!(row.sensitivities[0].coefficient > 0.8 && row.sensitivities[1].coefficient < -0.3);
}

#[test]
fn the_scatter_of_randomisations_is_that_of_the_estimates() {
    let draws = Draws::Randomised { sets: 20 };
    let rows: Vec<Row> = (0..40).flat_map(|seed| evaluate(&units(400, 20, seed), draws)).collect();
    for estimate in [|row: &Row| row.pass, |row: &Row| row.quantiles[1].estimated] {
        let values: Vec<f64> = rows.iter().map(|row| estimate(row).value).collect();
        let scatter = standard_error(&values).expect("many") * (rows.len() as f64).sqrt();
        let stated = rows.iter().filter_map(|row| estimate(row).u).sum::<f64>() / rows.len() as f64;
        assert!((0.7..1.4).contains(&(stated / scatter)), "{stated} stated, {scatter} found");
    }
    assert!(rows.iter().all(|row| row.pass.interval.is_none()));
    let named = |row: &&Row| row.sensitivities.iter().any(|one| one.setting == "setting-0");
    assert_eq!(rows.iter().filter(named).count(), rows.len());
}

#[test]
fn settings_without_effect_are_named_in_few_populations_only() {
    let mut units: Vec<Vec<MeasuredUnit>> = (0..100).map(|seed| units(40, 1, seed)).collect();
    for unit in units.iter_mut().flatten() {
        unit.settings_si.drain(..2);
    }
    let rows = units.iter().flat_map(|units| evaluate(units, Draws::Independent));
    let wrong = rows.filter(|row| !row.sensitivities.is_empty()).count();
    // 5 % of 100 and three standard deviations.
    assert!(wrong <= 11, "{wrong}");
}

#[test]
fn units_without_a_conclusive_verdict_count_as_no_pass_and_are_told() {
    let mut units = units(20, 1, 2);
    for unit in &mut units[..5] {
        unit.readings[0].value_si = None;
        unit.readings[0].verdict = Verdict::Inconclusive;
    }
    units[19].readings.clear();
    let row = &evaluate(&units, Draws::Independent)[0];
    assert_eq!((row.units, row.inconclusive), (20, 6), "a unit without a reading is no pass");
    assert!(row.passes <= 14 && row.pass.value <= 14.0 / 20.0);
    for unit in &mut units {
        unit.readings.iter_mut().for_each(|reading| reading.value_si = None);
    }
    let row = &evaluate(&units, Draws::Independent)[0];
    assert!(row.quantiles.is_empty() && row.sensitivities.is_empty());
}
