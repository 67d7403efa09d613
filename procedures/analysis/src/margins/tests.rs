use std::f64::consts::{PI, TAU};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

const REFERENCE: &str = include_str!("../../../../tests/data/margins/reference.csv");

fn gauss(random: &mut ChaCha8Rng) -> f64 {
    let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
    (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
}

/// Lines with a relative standard deviation; exact for 0.
fn lines(grid: &[f64], ratio: f64, seed: u64, open: impl Fn(C64) -> C64) -> Frf {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let line = |&hz: &f64| {
        let value = open(C64::new(0.0, TAU * hz));
        let sd = ratio * value.norm();
        let noise = C64::new(gauss(&mut random), gauss(&mut random)) * (sd * 0.5_f64.sqrt());
        Line { variance: sd * sd, ..Line::exact(hz, value + noise) }
    };
    grid.iter().map(line).collect()
}

fn log_grid(from: f64, to: f64, n: i32) -> Vec<f64> {
    (0..n).map(|k| from * (to / from).powf(f64::from(k) / f64::from(n - 1))).collect()
}

/// 20·e^(−τs)/s: crossover 20 rad/s, margin 90° − 20τ, −180° at π/(2τ).
fn integrator(delay_s: f64) -> impl Fn(C64) -> C64 {
    move |s| 20.0 * (-s * delay_s).exp() / s
}

/// Elevation axis at 0° (velocity loop, PI, 3.125 ms, two overlapping modes at 17 to 18 Hz).
fn elevation(s: C64) -> C64 {
    let mode = |f: f64, zeta: f64, c: f64| c * s / (s * s + 2.0 * zeta * TAU * f * s + (TAU * f).powi(2));
    let modes = mode(17.25, 0.035, -2.0714e-4) + mode(18.0, 0.03, 9.2308e-5) + mode(46.0, 0.03, 1.5385e-4);
    (18_250.0 + 361_400.0 / s) * (-s * 0.003125).exp() * (1.0 / (1018.49 * s + 68.4) + modes)
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(';').filter(|t| !t.is_empty()).map(|t| t.parse().expect("a number")).collect()
}

fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() < tolerance, "{what}: found {found}, expected {expected}");
}

#[test]
fn four_loops_have_the_margins_that_python_control_gives_them() {
    for row in REFERENCE.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let [above, below] = [numbers(cells[1]), numbers(cells[2])];
        let polynomial = |p: &[f64], s: C64| p.iter().fold(C64::default(), |sum, c| sum * s + c);
        let open =
            lines(&log_grid(0.02, 200.0, 280), 0.0, 0, |s| polynomial(&above, s) / polynomial(&below, s));
        let integrators_count = below.iter().rev().take_while(|c| **c == 0.0).count() as u32;
        let unstable_poles_count = u32::from(cells[0] == "unstable_pole");
        let settings = Settings { integrators_count, unstable_poles_count, ..Settings::default() };
        let found = margins(&open, &settings).expect(cells[0]);
        let cell = |k: usize| numbers(cells[k]);
        assert_eq!(found.gain_crossings.len(), cell(6).len(), "{}: {:?}", cells[0], found.gain_crossings);
        for (c, (hz, deg)) in found.gain_crossings.iter().zip(cell(6).into_iter().zip(cell(5))) {
            near(c.frequency_hz / hz, 1.0, 2e-4, cells[0]);
            near(c.phase_margin_rad.to_degrees(), deg, 0.02, cells[0]);
        }
        let gains: Vec<(f64, f64)> = cell(4).into_iter().zip(cell(3)).filter(|(hz, _)| *hz < 200.0).collect();
        assert_eq!(found.phase_crossings.len(), gains.len(), "{}: {:?}", cells[0], found.phase_crossings);
        for (c, (hz, db)) in found.phase_crossings.iter().zip(gains) {
            near(c.frequency_hz / hz, 1.0, 2e-4, cells[0]);
            near(c.gain_margin_db, db, 0.01, cells[0]);
        }
        near(found.modulus.value / cell(7)[0], 1.0, 1e-3, cells[0]);
        near(found.disk.alpha.value / cell(9)[0], 1.0, 1e-3, cells[0]);
        near(found.disk.gain_margin_db / cell(10)[0], 1.0, 2e-3, cells[0]);
        near(found.disk.phase_margin_rad.to_degrees() / cell(11)[0], 1.0, 2e-3, cells[0]);
    }
}

#[test]
fn delay_margin_brings_the_loop_to_its_limit() {
    let open = lines(&log_grid(0.5, 60.0, 80), 0.0, 0, integrator(0.01));
    let found = margins(&open, &Settings::default()).expect("a stable loop");
    let margin = found.delay_margin().expect("it crosses 0 dB");
    near(margin.delay_margin_s, (PI / 2.0 - 0.2) / 20.0, 1e-6, "delay margin");
    let limit = lines(&log_grid(0.5, 60.0, 80), 0.0, 0, integrator(0.01 + margin.delay_margin_s + 1e-3));
    assert_eq!(margins(&limit, &Settings::default()), Err(MarginError::Unstable { poles_count: 2 }));
}

/// Half-power width 1.2 Hz, lines 0.5 Hz apart: what smoothing would cost shows here.
#[test]
fn overlapping_resonances_are_not_smoothed_away() {
    let grid: Vec<f64> = (1..160).map(|k| 0.5 * f64::from(k)).collect();
    let found = margins(&lines(&grid, 0.0, 0, elevation), &Settings::default()).expect("a stable loop");
    let gain = found.gain_margin().expect("a −180° crossing");
    near(gain.gain_margin_db, 6.93, 0.03, "gain margin (continuous twin: +0.02 dB)");
    let phase = found.phase_margin().expect("a 0 dB crossing");
    near(phase.phase_margin_rad.to_degrees(), 45.96, 0.15, "phase margin (continuous twin: −0.10°)");
    near(phase.frequency_hz, 3.75, 0.006, "bandwidth");
}

#[test]
fn noise_of_one_percent_stays_inside_the_demands_and_the_intervals() {
    let grid: Vec<f64> = (1..120).map(|k| 0.5 * f64::from(k)).collect();
    let exact = margins(&lines(&grid, 0.0, 0, elevation), &Settings::default()).expect("a stable loop");
    let [gain, phase] = [
        exact.gain_margin().expect("one").gain_margin_db,
        exact.phase_margin().expect("one").phase_margin_rad,
    ];
    let mut square = [0.0; 2];
    let mut stated = [0.0; 2];
    let mut covered = 0;
    const RUNS: u64 = 12;
    for seed in 0..RUNS {
        let found =
            margins(&lines(&grid, 0.01, seed, elevation), &Settings::default()).expect("a stable loop");
        assert_eq!(found.doubts, []);
        let g = found.gain_margin().expect("one");
        let p = found.phase_margin().expect("one");
        square[0] += (g.gain_margin_db - gain).powi(2) / RUNS as f64;
        square[1] += (p.phase_margin_rad - phase).to_degrees().powi(2) / RUNS as f64;
        stated[0] += g.gain_margin_u_db.powi(2) / RUNS as f64;
        stated[1] += p.phase_margin_u_rad.to_degrees().powi(2) / RUNS as f64;
        covered += u32::from((g.gain_margin_db - gain).abs() < 1.96 * g.gain_margin_u_db);
        covered += u32::from((p.phase_margin_rad - phase).abs() < 1.96 * p.phase_margin_u_rad);
    }
    assert!(square[0].sqrt() < 0.1 && square[1].sqrt() < 0.5, "rms² {square:?}");
    assert!(covered >= 20, "{covered} of 24 intervals hold the truth");
    // The ratio of two such roots of 12 squares scatters by a fifth.
    for (stated, square) in stated.into_iter().zip(square) {
        let wide = (stated / square).sqrt();
        assert!(wide > 0.5 && wide < 2.0, "u is {wide} times the rms error");
    }
}

#[test]
fn open_loop_from_closed_undoes_the_feedback_and_carries_the_variance() {
    let open = lines(&log_grid(0.5, 60.0, 40), 0.0, 0, integrator(0.01));
    let closed: Frf =
        open.iter().map(|l| Line { value: l.value / (1.0 + l.value), variance: 1e-6, ..*l }).collect();
    let again = open_loop_from_closed(&closed).expect("lines");
    for (a, b) in open.iter().zip(&again) {
        assert!((a.value - b.value).norm() < 1e-9 * a.value.norm());
        let expected = 1e-6 * (1.0 + a.value).norm().powi(4);
        assert!((b.variance / expected - 1.0).abs() < 1e-9);
    }
    let one = vec![Line::exact(1.0, C64::from(1.0)); 1];
    assert_eq!(open_loop_from_closed(&one), Err(MarginError::TooFewLines { found: 1 }));
}

#[test]
fn bandwidth_of_a_second_order_is_the_textbook_one() {
    let zeta = 0.6_f64;
    let closed = |s: C64| 1.0 / ((s / (TAU * 10.0)).powi(2) + 2.0 * zeta * s / (TAU * 10.0) + 1.0);
    let flat = 1.0 - 2.0 * zeta * zeta;
    let expected = 10.0 * (flat + (flat * flat + 1.0).sqrt()).sqrt();
    let noisy = lines(&log_grid(0.2, 40.0, 80), 0.01, 3, closed);
    let found = bandwidth(&noisy, Some(1.0)).expect("it falls");
    assert!(
        (found.frequency_hz - expected).abs() < 4.0 * found.u_hz && found.u_hz < 0.01 * expected,
        "{found:?}"
    );
    let short = lines(&log_grid(0.2, 4.0, 30), 0.01, 3, closed);
    let none = bandwidth(&short, None).expect_err("it does not fall in the band");
    assert_eq!(none.to_string(), "no −3 dB crossing between 0.2 and 4 Hz");
}

#[test]
fn no_crossing_is_said_and_no_number() {
    let open = lines(&log_grid(0.5, 20.0, 40), 0.0, 0, |s| 0.2 / (1.0 + s / 30.0));
    let settings = Settings { integrators_count: 0, ..Settings::default() };
    let found = margins(&open, &settings).expect("a stable loop");
    assert_eq!((found.gain_crossings.len(), found.phase_crossings.len()), (0, 0));
    let text = found.phase_margin().expect_err("no crossing").to_string();
    assert_eq!(text, "no 0 dB crossing between 0.5 and 20 Hz");
    assert!(found.gain_margin().expect_err("no crossing").to_string().starts_with("no −180° crossing"));
}

#[test]
fn what_is_no_open_loop_is_refused() {
    let good = lines(&log_grid(0.5, 60.0, 40), 0.01, 0, integrator(0.01));
    let refused = |change: &dyn Fn(&mut Frf)| {
        let mut bad = good.clone();
        change(&mut bad);
        margins(&bad, &Settings::default()).expect_err("bad input")
    };
    assert_eq!(refused(&|l| l.truncate(4)), MarginError::TooFewLines { found: 4 });
    assert_eq!(refused(&|l| l[3].value.re = f64::NAN), MarginError::NotFinite { line: 3 });
    assert_eq!(refused(&|l| l[3].variance = -1.0), MarginError::NotFinite { line: 3 });
    assert_eq!(refused(&|l| l[3].dof = f64::NAN), MarginError::NotFinite { line: 3 });
    assert_eq!(refused(&|l| l[3].variance = 0.0), MarginError::MixedVariance { line: 3, found: 0.0 });
    assert_eq!(refused(&|l| l[3].value = C64::default()), MarginError::NoResponse { line: 3 });
    assert!(matches!(refused(&|l| l.swap(3, 4)), MarginError::NotAscending { line: 4, .. }));
    assert!(matches!(refused(&|l| l.truncate(12)), MarginError::BandTooShort { .. }));
    let settings = Settings { probability: 1.0, ..Settings::default() };
    assert!(matches!(margins(&good, &settings), Err(MarginError::Settings { .. })));
}

#[test]
fn an_unstable_loop_has_no_margins() {
    let open = lines(&log_grid(0.5, 100.0, 60), 0.0, 0, integrator(0.1));
    assert_eq!(margins(&open, &Settings::default()), Err(MarginError::Unstable { poles_count: 2 }));
}

#[test]
fn circles_that_reach_the_critical_point_and_low_coherence_take_the_certificate() {
    let grid = log_grid(0.5, 60.0, 60);
    let mut open = lines(&grid, 0.01, 0, integrator(0.06));
    let near = open.iter().position(|l| l.frequency_hz > 3.9).expect("in the grid");
    open[near].variance = 0.2;
    let found = margins(&open, &Settings::default()).expect("a stable loop");
    assert!(matches!(found.doubts[..], [Doubt::CircleReachesCritical { .. }]), "{:?}", found.doubts);
    let mut open = lines(&grid, 0.01, 0, integrator(0.01));
    open.iter_mut().for_each(|l| l.coherence = Some(if l.frequency_hz > 3.0 { 0.5 } else { 0.99 }));
    let found = margins(&open, &Settings::default()).expect("a stable loop");
    assert!(found.doubts.iter().all(|d| matches!(d, Doubt::Coherence { .. })) && !found.doubts.is_empty());
}
