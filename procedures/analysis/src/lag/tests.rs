use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

const PERIOD_S: f64 = 250e-6;

fn gauss(random: &mut ChaCha8Rng) -> f64 {
    let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
    (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
}

fn measured(
    seed: u64,
    delay_s: f64,
    corner_hz: f64,
    damping: Option<f64>,
    period_s: f64,
    to_hz: f64,
) -> Vec<Line> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..60)
        .map(|k| {
            let hz = 5.0 + (to_hz - 5.0) * f64::from(k) / 59.0;
            let value = 0.98 * sampled_response(hz, period_s, corner_hz, damping, delay_s);
            let sd = 0.01 * value.norm();
            let noise = C64::new(gauss(&mut random), gauss(&mut random)) * (sd * 0.5_f64.sqrt());
            Line { variance: sd * sd, ..Line::exact(hz, value + noise) }
        })
        .collect()
}

fn settings(order: Order) -> Settings {
    Settings { period_s: PERIOD_S, order, most_delay_s: 0.01 }
}

/// The closed form against the definition: a held sine through the lag, solved exactly from period to period.
#[test]
fn sampled_response_is_that_of_a_simulated_staircase() {
    let hz = 730.0;
    let corner_hz = 900.0;
    let delay_s = 2.83e-3;
    let angle = TAU * hz * PERIOD_S;
    let pole = TAU * corner_hz;
    // Current at tick k of the complex command e^{jωk·Ts}: the hold's value that acts changes ε before each tick.
    let whole = (delay_s / PERIOD_S).ceil();
    let rest = whole * PERIOD_S - delay_s;
    let command = |k: f64| C64::from_polar(1.0, angle * k);
    let mut current = C64::default();
    for k in 0..200 {
        let k = f64::from(k);
        let before = command(k - whole - 1.0)
            + (current - command(k - whole - 1.0)) * (-pole * (PERIOD_S - rest)).exp();
        current = command(k - whole) + (before - command(k - whole)) * (-pole * rest).exp();
    }
    let expected = current / command(199.0);
    let found = sampled_response(hz, PERIOD_S, corner_hz, None, delay_s);
    assert!((found - expected).norm() < 1e-9, "{found} against {expected}");
}

#[test]
fn a_critically_damped_loop_and_a_fast_pole_have_their_limits() {
    let [one, beside] = [1.0, 1.00001].map(|z| sampled_response(400.0, PERIOD_S, 900.0, Some(z), 2.9e-3));
    assert!((one - beside).norm() < 1e-5 && one.norm().is_finite());
    let first = sampled_response(400.0, PERIOD_S, 900.0, None, 2.9e-3);
    let overdamped = sampled_response(400.0, PERIOD_S, 900.0, Some(200.0), 2.9e-3);
    assert!((first - overdamped).norm() < 1e-3, "two far apart poles act as one: {first} {overdamped}");
}

#[test]
fn corner_and_delay_are_found_for_whole_and_broken_delays() {
    for (seed, (delay_s, corner_hz)) in
        [(2.5e-3, 700.0), (2.71e-3, 1000.0), (2.95e-3, 1000.0), (3.1e-3, 900.0)].into_iter().enumerate()
    {
        let lines = measured(seed as u64, delay_s, corner_hz, None, PERIOD_S, 1500.0);
        let fit = current_loop(&lines, &settings(Order::First)).expect("determined");
        assert!((fit.corner_hz / corner_hz - 1.0).abs() < 0.02, "{fit:?}");
        assert!(
            (fit.corner_hz - corner_hz).abs() < 4.0 * fit.corner_u_hz && fit.corner_u_hz < 0.01 * corner_hz,
            "{fit:?}"
        );
        assert!(
            (fit.transport_s - delay_s).abs() < 4.0 * fit.transport_u_s && fit.transport_u_s < 2e-6,
            "{fit:?}"
        );
        assert!(!fit.misfit && fit.hold_s == 125e-6, "{fit:?}");
        assert!((fit.lag_s * TAU * fit.corner_hz - 1.0).abs() < 1e-12);
    }
}

#[test]
fn at_a_slow_rate_the_corner_is_refused() {
    let slow = Settings { period_s: 1e-3, ..settings(Order::First) };
    for (seed, delay_s) in [(0, 2.5e-3), (1, 2.8e-3), (2, 3.0e-3)] {
        let found = current_loop(&measured(seed, delay_s, 1000.0, None, 1e-3, 400.0), &slow);
        assert!(matches!(found, Err(LagError::NotDetermined { .. })), "{found:?}");
    }
}

#[test]
fn a_loop_of_second_order_is_flagged_and_then_fitted() {
    let lines = measured(4, 2.8e-3, 1000.0, Some(0.5), PERIOD_S, 1500.0);
    let first = current_loop(&lines, &settings(Order::First));
    assert!(first.is_ok_and(|fit| fit.misfit), "{first:?}");
    let second = current_loop(&lines, &settings(Order::Second)).expect("determined");
    let [zeta, u] = second.damping.expect("second order");
    assert!(!second.misfit && (zeta - 0.5).abs() < 4.0 * u && u < 0.1, "{second:?}");
    assert!((second.corner_hz - 1000.0).abs() < 4.0 * second.corner_u_hz, "{second:?}");
}

/// Lines whose variances are those of three windows, two complex degrees of freedom each.
fn of_three_windows(seed: u64, delay_s: f64, corner_hz: f64, damping: Option<f64>) -> Vec<Line> {
    let exact = measured(seed, delay_s, corner_hz, damping, PERIOD_S, 1500.0);
    let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
    let estimated = |line: Line| {
        let squares: f64 = (0..4).map(|_| gauss(&mut random).powi(2)).sum();
        Line { variance: line.variance * squares / 4.0, dof: 2.0, ..line }
    };
    exact.into_iter().map(estimated).collect()
}

/// 200 seeds: 190 within 2 u are expected; fewer than 180 have a probability of one in a thousand. Of a misfit by chance,
/// one in a thousand each, two have a probability of 2 %.
#[test]
fn three_windows_neither_make_a_first_order_loop_a_misfit_nor_its_delay_too_certain() {
    let fits: Vec<LagFit> = (0..200)
        .map(|seed| of_three_windows(seed, 2.4e-3, 941.0, None))
        .map(|lines| current_loop(&lines, &settings(Order::First)).expect("determined"))
        .collect();
    let misfits = fits.iter().filter(|fit| fit.misfit).count();
    assert!(misfits <= 1, "{misfits} of 200 taken for no loop of first order");
    let within =
        fits.iter().filter(|fit| (fit.transport_s - 2.4e-3).abs() <= 2.0 * fit.transport_u_s).count();
    assert!((180..=199).contains(&within), "{within} of 200 within 2 u");
}

/// A second pole that is fitted to noise takes its lag from the delay: twelve seeds of a loop of first order.
#[test]
fn a_second_pole_is_taken_only_where_it_makes_the_fit_clearly_better() {
    for seed in 0..12 {
        let lines = of_three_windows(seed, 2.4e-3, 941.0, None);
        let first = current_loop(&lines, &settings(Order::First)).expect("determined");
        let second = current_loop(&lines, &settings(Order::Second));
        assert!(!second.is_ok_and(|second| second.is_clearly_better_than(&first)), "seed {seed}");
    }
    let lines = of_three_windows(0, 2.8e-3, 1000.0, Some(0.5));
    let [first, second] = [Order::First, Order::Second].map(|order| current_loop(&lines, &settings(order)));
    let [first, second] = [first.expect("a corner"), second.expect("determined")];
    assert!(second.is_clearly_better_than(&first), "{first:?} {second:?}");
}

#[test]
fn bad_input_is_refused() {
    let good = measured(0, 2.8e-3, 1000.0, None, PERIOD_S, 1500.0);
    let mut bad = good.clone();
    bad[5].variance = f64::NAN;
    let first = settings(Order::First);
    assert_eq!(current_loop(&bad, &first), Err(InputError::NotFinite { index: 5 }.into()));
    assert_eq!(current_loop(&good[..3], &first), Err(InputError::TooFew { found: 3, least: 5 }.into()));
    let slow = Settings { period_s: 1e-3, ..first };
    assert!(matches!(current_loop(&good, &slow), Err(LagError::Input(InputError::Setting { .. }))));
}
