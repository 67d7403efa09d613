use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::super::frf::Line;
use super::*;

/// Circular complex normal numbers with E|x|² = 1.
pub(crate) struct Noise(ChaCha8Rng);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn next(&mut self) -> C64 {
        let mut uniform = || (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0;
        C64::from_polar((-uniform().ln()).sqrt(), TAU * uniform())
    }
}

/// `count` lines of `at` from 1 to `most_hz`, with noise of a share of each value.
pub(crate) fn measured(at: impl Fn(f64) -> C64, most_hz: f64, count: usize, share: f64, seed: u64) -> Frf {
    let mut noise = Noise::new(seed);
    let line = |k: usize| {
        let hz = 1.0 + (most_hz - 1.0) * k as f64 / (count - 1) as f64;
        let variance = share * share * at(hz).norm_sqr();
        Line { variance, ..Line::exact(hz, at(hz) + noise.next() * variance.sqrt()) }
    };
    (0..count).map(line).collect()
}

/// Torque to gyro rate of the azimuth axis at 20° with its velocity controller and 3 ms of delay.
fn open_loop(hz: f64) -> C64 {
    const MODES: [[f64; 2]; 3] = [[40.851, -4.1771e-4], [53.733, 2.0833e-4], [85.527, 1.6667e-4]];
    let s = C64::new(0.0, TAU * hz);
    let mode = |[own, c]: [f64; 2]| {
        let omega = TAU * own;
        s * c / (s * (s + 0.06 * omega) + omega * omega)
    };
    let plant = (s * 1138.95 + 273.6).inv() + MODES.into_iter().map(mode).sum::<C64>();
    plant * (s.inv() * 447_500.0 + 23_600.0) * (-s * 0.003).exp()
}

fn known(poles: usize, terms: &[i32], delay_s: f64) -> Settings {
    Settings { poles, terms: terms.to_vec(), delay: Delay::Known(delay_s), stable: true }
}

/// Data, shape and first poles of a fit of the open loop.
fn prepared(frfs: &[Frf], poles: usize) -> (Data, Shape, Vec<f64>) {
    let data = Data::new(frfs, 0.003).expect("good lines");
    let shape = Shape { pairs: poles / 2, singles: poles % 2, terms: vec![0], delay: false };
    let start = relocation::first_poles(&data, poles, &[0], true).expect("poles");
    (data, shape, start)
}

fn departure_db(fit: &RationalFit, at: impl Fn(f64) -> C64, hz: f64) -> f64 {
    20.0 * (fit.at(hz).norm() / at(hz).norm()).log10()
}

#[test]
fn an_open_loop_without_noise_is_found_exactly() {
    let frf = measured(open_loop, 100.0, 100, 0.0, 0);
    let fit = RationalFit::new(&[frf], &known(8, &[], 0.003)).expect("eight poles");
    for hz in [1.3, 4.11, 39.7, 40.85, 60.5, 99.5] {
        assert!(departure_db(&fit, open_loop, hz).abs() < 1e-5, "{hz} Hz");
    }
    let slowest = fit.poles.iter().map(|p| p.norm()).fold(f64::INFINITY, f64::min);
    assert!(slowest < 1e-3, "the integrator: {slowest} rad/s");
}

#[test]
fn a_noisy_open_loop_is_interpolated_within_what_noise_allows() {
    let mut squares = 0.0;
    for seed in 0..5 {
        let frf = measured(open_loop, 100.0, 397, 0.01, seed);
        let fit = RationalFit::select(&frf, &known(4, &[0], 0.003), 12).expect("a fit");
        let ratio = fit.misfit_ratio();
        assert!((0.8..1.2).contains(&ratio), "seed {seed}: {ratio}");
        for hz in [4.11, 39.7] {
            let error = (fit.at(hz) - open_loop(hz)).norm_sqr() / fit.variance_at(hz);
            squares += error / 10.0;
            assert!(departure_db(&fit, open_loop, hz).abs() < 0.05, "seed {seed}, {hz} Hz");
        }
    }
    assert!((0.2..2.5).contains(&squares), "error² over stated variance {squares}");
}

#[test]
fn eight_modes_over_sixty_decibels_are_followed() {
    let response = |hz: f64| -> C64 {
        let s = C64::new(0.0, TAU * hz);
        let mode = |k: i32| {
            let omega = TAU * 8.0 * 1.35_f64.powi(k);
            C64::new(if k % 2 == 0 { 50.0 } else { -40.0 }, 0.0) / (s * (s + 0.03 * omega) + omega * omega)
        };
        (s.inv() + (0..8).map(mode).sum::<C64>()) * (-s * 0.003).exp()
    };
    let frf = measured(response, 100.0, 200, 0.001, 3);
    let sizes: Vec<f64> = frf.iter().map(Line::gain_db).collect();
    let range =
        sizes.iter().copied().fold(f64::MIN, f64::max) - sizes.iter().copied().fold(f64::MAX, f64::min);
    let fit = RationalFit::new(&[frf], &known(17, &[], 0.003)).expect("17 poles");
    assert!(range > 45.0 && fit.misfit_ratio() < 1.3, "{range} dB, misfit {}", fit.misfit_ratio());
    for k in 0..180 {
        let hz = 2.0 + 0.53 * f64::from(k);
        let bound = 5.0 * fit.variance_at(hz).sqrt();
        assert!((fit.at(hz) - response(hz)).norm() < bound, "{hz} Hz");
    }
}

#[test]
fn a_delay_is_fitted_with_its_uncertainty() {
    let response = |hz: f64| {
        let s = C64::new(0.0, TAU * hz);
        (s / 200.0 + 1.0).inv() * (-s * 0.0021).exp()
    };
    let mut worst: f64 = 0.0;
    for seed in 0..10 {
        let frf = measured(response, 100.0, 100, 0.01, 10 + seed);
        let settings = Settings { delay: Delay::Fitted(0.002), ..known(1, &[], 0.0) };
        let fit = RationalFit::new(&[frf], &settings).expect("a fit");
        assert!(fit.delay_u_s > 1e-7 && fit.delay_u_s < 2e-5, "{}", fit.delay_u_s);
        worst = worst.max((fit.delay_s - 0.0021).abs() / fit.delay_u_s);
    }
    assert!(worst > 0.5 && worst < 4.0, "largest of ten errors over u: {worst}");
}

#[test]
fn a_missing_mode_shows_in_the_cost() {
    let frf = measured(open_loop, 100.0, 200, 0.01, 20);
    let fit = RationalFit::new(&[frf], &known(6, &[], 0.003)).expect("a fit");
    assert!(fit.misfit_ratio() > 2.0, "{}", fit.misfit_ratio());
}

#[test]
fn several_responses_share_their_poles() {
    let other = |hz: f64| open_loop(hz) * -0.3 + 0.02 * C64::from_polar(1.0, -TAU * hz * 0.003);
    let frfs = [measured(open_loop, 100.0, 200, 0.001, 1), measured(other, 100.0, 150, 0.001, 2)];
    let fit = RationalFit::new(&frfs, &known(8, &[0], 0.003)).expect("a fit");
    assert_eq!((fit.poles.len(), fit.residues.len()), (8, 2));
    for hz in [4.0, 41.0] {
        let error = (fit.response_at(1, hz) - other(hz)).norm();
        assert!(error < 5.0 * fit.response_variance_at(1, hz).sqrt(), "{hz} Hz: {error}");
    }
    // Poles and residues say the same as the sections.
    let s = C64::new(0.0, TAU * 41.0);
    let sum: C64 = fit.poles.iter().zip(&fit.residues[1]).map(|(p, r)| r / (s - p)).sum();
    let whole = (sum + fit.terms[1][0]) * (-s * 0.003).exp();
    assert!((whole - fit.response_at(1, 41.0)).norm() < 1e-9 * whole.norm());
}

/// `tests/data/modal_scipy`: minimum, covariance and interpolated values of an independent program.
#[test]
fn the_minimum_and_its_covariance_are_those_of_scipy() {
    let fit = RationalFit::new(&[scipy()], &known(6, &[-1, 0], 0.0015)).expect("a fit");
    assert!((fit.cost - 178.088_003_664_276_53).abs() < 1e-6 && fit.dof == 226, "{} {}", fit.cost, fit.dof);
    let values = [(14.5, -1.628_428_634_696_897, -0.422_775_736_320_176_9, 0.000_143_146_543_723_364_84)];
    let more = [(30.0, 0.072_935_208_447_765_02, -0.186_229_374_179_728_49, 2.159_833_961_719_426_5e-7)];
    for (hz, re, im, variance) in values.into_iter().chain(more) {
        assert!((fit.at(hz) - C64::new(re, im)).norm() < 1e-6, "{hz} Hz: {}", fit.at(hz));
        assert!((fit.variance_at(hz) / variance - 1.0).abs() < 1e-3, "{hz} Hz: {}", fit.variance_at(hz));
    }
}

pub(crate) fn scipy() -> Frf {
    columns(include_str!("../../../../tests/data/modal_scipy/frf.csv"))
        .map(|[hz, re, im, variance]| Line { variance, ..Line::exact(hz, C64::new(re, im)) })
        .collect()
}

pub(crate) fn columns(text: &str) -> impl Iterator<Item = [f64; 4]> {
    text.lines().skip(1).map(|row| {
        let mut cells = row.split(',').map(|cell| cell.parse().expect("a number"));
        std::array::from_fn(|_| cells.next().expect("four columns"))
    })
}

#[test]
fn lines_that_cannot_be_used_are_refused_by_name() {
    let good = measured(open_loop, 100.0, 100, 0.01, 0);
    let spoilt = |change: fn(&mut Frf)| {
        let mut frf = good.clone();
        change(&mut frf);
        RationalFit::new(&[frf], &known(2, &[], 0.0)).expect_err("spoilt")
    };
    let not_finite = spoilt(|f| f[7].value.re = f64::NAN);
    assert_eq!(not_finite, RationalError::Lines(LineError::NotFinite { response: 0, line: 7 }));
    assert!(matches!(
        spoilt(|f| f[3].variance = f64::INFINITY),
        RationalError::Lines(LineError::NotFinite { .. })
    ));
    let twice = spoilt(|f| f[5].frequency_hz = f[4].frequency_hz);
    assert!(matches!(twice, RationalError::Lines(LineError::NotAscending { line: 5, .. })));
    let zero = spoilt(|f| f[0].frequency_hz = 0.0);
    assert!(matches!(zero, RationalError::Lines(LineError::NotAscending { line: 0, .. })));
    let mixed = spoilt(|f| f[9].variance = 0.0);
    assert_eq!(mixed, RationalError::Lines(LineError::Variance { response: 0, line: 9, variance: 0.0 }));
    assert!(matches!(spoilt(Vec::clear), RationalError::Lines(LineError::Empty { response: 0 })));
    let few = spoilt(|f| f.truncate(11));
    assert_eq!(few, RationalError::TooFew { lines: 11, unknowns: 4, needed: 12 });
    let settings = known(2, &[0, 0], 0.0);
    assert_eq!(RationalFit::new(&[good], &settings), Err(RationalError::Settings));
}

#[test]
fn variances_estimated_from_few_periods_widen_the_covariance() {
    let frf = measured(open_loop, 100.0, 200, 0.01, 4);
    let estimated: Frf = frf.iter().map(|l| Line { dof: 7.0, ..*l }).collect();
    let variance =
        |frf: Frf| RationalFit::new(&[frf], &known(8, &[], 0.003)).expect("a fit").variance_at(20.0);
    // ν/(ν − 1) of the weights times (ν − 1)/(ν − 2).
    assert!((variance(estimated) / variance(frf) - 7.0 / 5.0).abs() < 1e-4);
}

#[test]
fn normal_equations_give_the_minimum_and_the_covariance_of_the_qr() {
    let other = |hz: f64| open_loop(hz) * -0.3 + 0.02 * C64::from_polar(1.0, -TAU * hz * 0.003);
    for seed in 0..4 {
        let frfs = [measured(open_loop, 100.0, 200, 0.01, seed), measured(other, 100.0, 150, 0.01, 9 + seed)];
        let (data, shape, start) = prepared(&frfs, 8);
        let search::End::Found(theta, quick) = search::search(&data, &shape, &start) else {
            panic!("seed {seed}: well conditioned")
        };
        let quick = Solution::new(&data, &shape, &theta, *quick).expect("a solution");
        // At the same poles: what the squared condition costs.
        let here = projection::by_qr(&data, &shape, &theta).expect("a solution");
        assert!((quick.cost / here.cost - 1.0).abs() < 1e-11, "{} {}", quick.cost, here.cost);
        for m in 0..2 {
            for (x, y) in quick.c[m].iter().zip(&here.c[m]) {
                assert!((x - y).abs() < 1e-8 * y.abs().max(1e-3), "{x} {y}");
            }
            for k in 0..quick.covariance[m].nrows() {
                let x = quick.covariance[m][(k, k)];
                let y = here.covariance[m][(k, k)];
                assert!((x / y - 1.0).abs() < 1e-5, "response {m}, parameter {k}: {x} {y}");
            }
        }
        // From the same start: the same minimum, to less than noise moves it.
        let far = projection::solve_by_qr(&data, &shape, &start).expect("a solution");
        assert!((quick.cost - far.cost).abs() < 1e-5, "{} {}", quick.cost, far.cost);
        for (k, (x, y)) in quick.theta.iter().zip(&far.theta).enumerate() {
            let u = far.covariance[0][(k, k)].sqrt();
            assert!((x - y).abs() < 0.005 * u, "parameter {k}: {x} {y}, u {u}");
        }
    }
}

#[test]
fn sections_that_coincide_are_left_to_the_qr() {
    let (data, shape, mut start) = prepared(&[measured(open_loop, 100.0, 200, 0.01, 1)], 8);
    start.copy_within(0..2, 2);
    assert!(matches!(search::search(&data, &shape, &start), search::End::Ill(_)));
    let held = projection::evaluate(&data, &shape, &start).expect("the ridge keeps it solvable");
    assert!(held.misfit().is_finite() && held.weight_of_pair(0).is_finite());
    let solution = solve(&data, &shape, &start).expect("they part on the way");
    assert!(solution.cost.is_finite());
}
