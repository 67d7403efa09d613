use std::f64::consts::{PI, TAU};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn wanted(kind: Kind, spacing: Spacing) -> Selection {
    Selection { band_hz: 1.0..=30.0, kind, spacing, forbidden_hz: vec![] }
}

fn grid(offset: Offset, selection: &Selection) -> Grid {
    Grid::new(2.0, offset, 100.0, selection, &mut uniform(3)).expect("a sound grid")
}

#[test]
fn a_full_grid_leaves_out_the_cogging_line_and_its_neighbours() {
    let mut selection = wanted(Kind::Full, Spacing::Every);
    selection.forbidden_hz = vec![4.7..=5.3, 9.7..=10.3];
    let found = grid(Offset::Half, &selection);
    let frequencies = found.frequencies_hz();
    assert_eq!(frequencies[..4], [1.25, 1.75, 2.25, 2.75]);
    assert!(frequencies.iter().all(|f| (f - 5.0).abs() > 0.3 && (f - 10.0).abs() > 0.3));
    // 58 lines 1.25…29.75 less those at 4.75, 5.25, 9.75, 10.25.
    assert_eq!(frequencies.len(), 54);
    assert!((found.repeats_after_s() - 4.0).abs() < 1e-12);
}

#[test]
fn an_odd_random_grid_leaves_one_of_each_four_odd_lines_to_detect() {
    let found = grid(Offset::Zero, &wanted(Kind::OddRandom, Spacing::Every));
    let mut odd: Vec<u32> = found.orders.iter().chain(&found.odd_detection).copied().collect();
    odd.sort_unstable();
    assert_eq!(odd, (3..60).step_by(2).collect::<Vec<u32>>());
    for (group, &left_out) in odd.chunks_exact(4).zip(&found.odd_detection) {
        assert!(group.contains(&left_out), "{group:?} {left_out}");
    }
    assert_eq!(found.odd_detection.len(), 7);
    let first = found.orders[0];
    let last = *found.orders.last().expect("lines");
    assert_eq!(found.even_detection, (first..=last).filter(|m| m % 2 == 0).collect::<Vec<u32>>());
    let other =
        Grid::new(2.0, Offset::Zero, 100.0, &wanted(Kind::OddRandom, Spacing::Every), &mut uniform(4));
    assert_ne!(found.odd_detection, other.expect("a sound grid").odd_detection);
}

#[test]
fn with_half_an_offset_every_line_is_odd_and_no_even_one_lies_on_the_window() {
    let found = grid(Offset::Half, &wanted(Kind::OddRandom, Spacing::Every));
    assert!(found.orders.iter().any(|m| m % 2 == 0), "{:?}", found.orders);
    assert!(!found.odd_detection.is_empty() && found.even_detection.is_empty());
    assert!(grid(Offset::Quarter, &wanted(Kind::OddRandom, Spacing::Every)).odd_detection.is_empty());
}

#[test]
fn log_spaced_lines_are_the_nearest_of_the_grid_to_equal_ratios() {
    let found = grid(Offset::Zero, &wanted(Kind::Full, Spacing::Logarithmic(6)));
    assert_eq!(found.orders, [2, 4, 8, 15, 30, 60]);
    let even_steps = grid(Offset::Zero, &wanted(Kind::Full, Spacing::Linear(3)));
    assert_eq!(even_steps.orders, [2, 31, 60]);
}

/// A flat multisine of the lines 1…60.
fn flat(phases: Phases<'_>) -> Multisine {
    let selection =
        Selection { band_hz: 1.0..=60.0, kind: Kind::Full, spacing: Spacing::Every, forbidden_hz: vec![] };
    let grid = Grid::new(1.0, Offset::Zero, 1000.0, &selection, &mut || 0.0).expect("a sound grid");
    Multisine::new(&grid, &|_| 1.0, phases).expect("weights of 1")
}

#[test]
fn clipping_brings_the_crest_of_sixty_flat_lines_below_that_of_schroeder() {
    let schroeder = flat(Phases::Schroeder).crest_factor();
    let compressed = flat(Phases::Compressed).crest_factor();
    let random = flat(Phases::Random(&mut uniform(1))).crest_factor();
    assert!(schroeder < 1.9 && random > 2.2, "{schroeder} {random}");
    assert!(compressed <= 1.6, "{compressed}");
}

#[test]
fn clipping_helps_sparse_lines_between_the_grid_too() {
    let selection = wanted(Kind::Full, Spacing::Logarithmic(20));
    let grid = grid(Offset::Quarter, &selection);
    let crest = |phases| Multisine::new(&grid, &|f| 1.0 / f, phases).expect("weights").crest_factor();
    let schroeder = crest(Phases::Schroeder);
    let compressed = crest(Phases::Compressed);
    assert!(compressed < 0.95 * schroeder, "{compressed} {schroeder}");
}

#[test]
fn values_repeat_after_four_windows_of_a_quarter_offset_and_fill_the_asked_range() {
    let grid = grid(Offset::Quarter, &wanted(Kind::Full, Spacing::Every));
    let multisine = Multisine::new(&grid, &|f| 1.0 / f, Phases::Schroeder).expect("weights");
    let multisine = multisine.scaled_to(3.0).expect("a positive range");
    assert!((multisine.at(0.37) - multisine.at(8.37)).abs() < 1e-9);
    assert!((multisine.at(0.37) - multisine.at(2.37)).abs() > 1e-3);
    let values: Vec<f64> = (0..80_000).map(|i| multisine.at(f64::from(i) * 1e-4)).collect();
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!((high - low - 3.0).abs() < 0.015, "{low} {high}");
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / 80_000.0).sqrt();
    assert!((rms / multisine.rms() - 1.0).abs() < 1e-6);
}

#[test]
fn what_cannot_be_excited_is_refused_with_the_number_at_fault() {
    let selection = wanted(Kind::Full, Spacing::Every);
    let refused = |window_s, rate_hz, selection: &Selection| {
        Grid::new(window_s, Offset::Zero, rate_hz, selection, &mut || 0.0).expect_err("must be refused")
    };
    let too_fast = ExcitationError::TooFast { frequency_hz: 30.0, limit_hz: 20.0 };
    assert_eq!(refused(2.0, 50.0, &selection), too_fast);
    assert!(matches!(refused(2.005, 100.0, &selection), ExcitationError::Window { .. }));
    assert!(matches!(refused(-1.0, 100.0, &selection), ExcitationError::NotPositive { .. }));
    assert!(matches!(refused(2.0, f64::NAN, &selection), ExcitationError::NotPositive { .. }));
    let narrow = Selection { band_hz: 1.1..=1.4, ..selection.clone() };
    assert_eq!(refused(2.0, 100.0, &narrow), ExcitationError::Empty { from_hz: 1.1, to_hz: 1.4 });
    let reversed = Selection { band_hz: 5.0..=f64::NAN, ..selection.clone() };
    assert!(matches!(refused(2.0, 100.0, &reversed), ExcitationError::Band { .. }));
    let grid = grid(Offset::Zero, &selection);
    let weight = Multisine::new(&grid, &|f| f - 10.0, Phases::Schroeder);
    assert_eq!(weight, Err(ExcitationError::Weight { frequency_hz: 1.0, found: -9.0 }));
    assert!(too_fast.to_string().contains("30 Hz") && too_fast.to_string().contains("20 Hz"));
}

const SWEEP: Sweep = Sweep { from_hz: 5.0, to_hz: 80.0, duration_s: 10.0, law: Law::Linear, amplitude: 2.0 };

#[test]
fn the_slope_of_a_sweeps_phase_is_its_frequency() {
    for sweep in
        [SWEEP, Sweep { law: Law::Logarithmic, ..SWEEP }, Sweep { from_hz: 80.0, to_hz: 5.0, ..SWEEP }]
    {
        for t in [1.0, 4.0, 9.0] {
            let slope = |t: f64| (sweep.phase_rad(t + 1e-5) - sweep.phase_rad(t - 1e-5)) / 2e-5 / TAU;
            let part = t / sweep.duration_s;
            let frequency_hz = match sweep.law {
                Law::Linear => sweep.from_hz + (sweep.to_hz - sweep.from_hz) * part,
                Law::Logarithmic => sweep.from_hz * (sweep.to_hz / sweep.from_hz).powf(part),
            };
            assert!((slope(t) / frequency_hz - 1.0).abs() < 1e-6, "{sweep:?} {t}");
            let rate = (slope(t + 1e-2) - slope(t - 1e-2)) / 2e-2;
            assert!((rate.abs() / sweep.rate_hz_per_s(frequency_hz) - 1.0).abs() < 1e-4, "{sweep:?} {t}");
        }
        assert_eq!(sweep.at(-0.1), 0.0);
        assert_eq!(sweep.at(10.1), 0.0);
    }
}

#[test]
fn the_limits_of_the_standard_are_one_speed_past_a_mode() {
    let zeta = 0.005;
    let natural_hz = 50.0;
    let linear = iso_linear_limit_hz_per_min(zeta, natural_hz) / 60.0;
    let at_limit = Sweep { duration_s: 75.0 / linear, ..SWEEP };
    assert!((at_limit.eta(zeta, natural_hz) - 1.8 / PI).abs() < 1e-12);
    let octaves = iso_logarithmic_limit_oct_per_min(zeta, natural_hz) / 60.0;
    let log = Sweep { duration_s: (16.0_f64).log2() / octaves, law: Law::Logarithmic, ..SWEEP };
    assert!((log.eta(zeta, natural_hz) / (1.8 / PI) - 1.0).abs() < 2e-3, "78·ln 2 = 54.07 beside 54");
    assert!(Sweep { duration_s: log.duration_s * 1.01, ..log }.within_iso_limit(zeta, natural_hz));
    assert!(!Sweep { duration_s: at_limit.duration_s * 0.99, ..at_limit }.within_iso_limit(zeta, natural_hz));
}

#[test]
fn the_expected_error_of_a_peak_runs_through_the_table_and_ends_with_it() {
    assert_eq!(expected_peak_error(0.1), Some(-0.006));
    let between = expected_peak_error(0.375).expect("within the table");
    assert!((between + 0.0355).abs() < 1e-12);
    assert_eq!(expected_peak_error(1.01), None);
    assert_eq!(expected_peak_error(f64::NAN), None);
}

#[test]
fn a_sweep_beyond_the_sample_rate_or_without_a_span_is_refused() {
    assert_eq!(SWEEP.check(200.0), Ok(()));
    assert!(matches!(SWEEP.check(199.0), Err(ExcitationError::TooFast { .. })));
    assert!(matches!(Sweep { to_hz: 5.0, ..SWEEP }.check(200.0), Err(ExcitationError::Band { .. })));
    assert!(matches!(
        Sweep { duration_s: 0.0, ..SWEEP }.check(200.0),
        Err(ExcitationError::NotPositive { .. })
    ));
}
