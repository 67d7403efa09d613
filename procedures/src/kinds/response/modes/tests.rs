use std::f64::consts::TAU;

use analysis::frf::{C64, Frf, Line};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::assign::{Expected, Place};
use super::fit::{self, Fitted, fit, participation};
use super::point;
use crate::axis::Axes;
use crate::diagnostic::SourceFile;
use crate::measurement::{Condition, Measurement, PointResult};
use crate::procedure::Procedure;

const DEGREE: f64 = TAU / 360.0;
const INERTIA: f64 = 985.0;
const DELAY_S: f64 = 2.9e-3;
/// Noise of friction, which both sensors see, and of each sensor, over their responses.
const COMMON: f64 = 2e-3;
const OWN: f64 = 2e-4;

/// A mode of the truth: frequency, damping ratio, c in the gyro and in the encoder, 1/(kg·m²).
type True = (f64, f64, f64, f64);

/// Elevation at 45 deg, as modes.md has it.
const TORSIONAL: [True; 3] =
    [(17.896, 0.035, -1.17e-4, 1.22e-4), (20.702, 0.03, 1.10e-4, 1.38e-4), (48.7, 0.03, 1.54e-4, 1.92e-4)];
const BENDING: True = (10.994, 0.1, 1e-5, 0.0);

struct Gauss(ChaCha8Rng);

impl Gauss {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Circular, E|x|² = 1 (Box and Muller).
    fn next(&mut self) -> C64 {
        let mut uniform = || (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0;
        C64::from_polar((-uniform().ln()).sqrt(), TAU * uniform())
    }
}

/// Both sensors under torque on a shaft that slides: bristles that lag behind the rate at 8 Hz bend the responses by
/// some 0.5 % around 10 Hz.
fn sensors(modes: &[True], hz: f64) -> [C64; 2] {
    let s = C64::new(0.0, TAU * hz);
    let free = |share: &dyn Fn(&True) -> f64| {
        let modal = modes.iter().map(|m| {
            let w = TAU * m.0;
            s * share(m) / (s * s + s * (2.0 * m.1 * w) + w * w)
        });
        (s * INERTIA).inv() + modal.sum::<C64>()
    };
    let gyro = free(&|m| m.2);
    let encoder = free(&|m| m.3);
    let friction = s / (s + 51.0) * -350.0 + 68.4;
    let turn = C64::from_polar(1.0, -TAU * hz * DELAY_S) / (encoder * friction + 1.0);
    [gyro * turn, encoder * turn]
}

/// Lines of a record with noise, twelve complex degrees of freedom each; variances are the true ones.
fn measured(modes: &[True], own: f64, seed: u64) -> fit::Responses {
    let mut random = Gauss::new(seed);
    let mut gyro = Frf::new();
    let mut encoder = Frf::new();
    let mut ratio = Frf::new();
    for k in 12..=124 {
        let hz = 0.5 * f64::from(k);
        let [g, e] = sensors(modes, hz);
        let line = |value: C64, noise: f64| Line {
            variance: (noise * value.norm()).powi(2),
            dof: 12.0,
            ..Line::exact(hz, value)
        };
        let shared = random.next() * COMMON + 1.0;
        let q = g / e * (random.next() * own + 1.0);
        let seen = e * shared * (random.next() * own + 1.0);
        gyro.push(line(seen * q, COMMON.hypot(own)));
        encoder.push(line(seen, COMMON.hypot(own)));
        ratio.push(line(q, own));
    }
    fit::judged([gyro, encoder], &ratio).expect("all lines count")
}

fn curve(mode: usize, hz: [f64; 3], gyro_only: bool) -> Expected {
    let nodes = [0.0, 45.0 * DEGREE, 90.0 * DEGREE].into_iter().zip(hz);
    Expected { mode, place: Place::Curve(nodes.collect()), gyro_only }
}

fn expected() -> Vec<Expected> {
    vec![
        curve(1, [10.0, 11.0, 11.9], true),
        curve(2, [16.6, 18.3, 18.1], false),
        curve(3, [17.4, 20.7, 23.9], false),
    ]
}

fn fitted(modes: &[True], own: f64, seed: u64) -> Fitted {
    fit(&measured(modes, own, seed), &expected(), 45.0 * DEGREE).expect("it fits")
}

fn all_modes() -> Vec<True> {
    [BENDING].into_iter().chain(TORSIONAL).collect()
}

fn measurement(fitted: &Fitted, name: &str) -> Measurement {
    let all = point::measurements("el", &expected(), fitted, 45.0 * DEGREE);
    all.into_iter().find(|m| m.measurand == name).expect("it is yielded")
}

#[test]
fn every_mode_is_found_the_small_one_in_the_gyro_too() {
    let truth = all_modes();
    for seed in 0..5 {
        let fitted = fitted(&truth, OWN, seed);
        for (k, pair) in fitted.pairs.iter().enumerate() {
            let mode = &fitted.modal.modes[pair.unwrap_or_else(|| panic!("mode {} at seed {seed}", k + 1))];
            let away = mode.frequency_hz / truth[k].0 - 1.0;
            assert!(away.abs() < 0.005, "mode {} departs by {away}", k + 1);
        }
        let bending = participation(&fitted.modal, fitted.pairs[0].expect("found above"), 0, fitted.apart);
        assert!((bending.value - BENDING.2 * INERTIA).abs() < 4.0 * bending.u, "{bending:?}");
    }
}

#[test]
fn of_two_modes_of_which_one_is_visible_neither_has_a_frequency() {
    let one = fitted(&[BENDING, (19.4, 0.035, -1.2e-4, 1.9e-4), TORSIONAL[2]], OWN, 1);
    let reasons = ["mode-2-departure", "mode-3-departure"].map(|name| measurement(&one, name).inconclusive);
    let [second, third] = reasons.map(|reason| reason.unwrap_or_default());
    assert!([&second, &third].iter().any(|reason| reason.contains("not visible")), "{second}; {third}");
    let either = "may be mode 2 or mode 3: only one of the two is visible";
    let swapped = "may be mode 3 or mode 2: only one of the two is visible";
    assert!([&second, &third].iter().any(|r| r.contains(either) || r.contains(swapped)), "{second}; {third}");
    assert!(measurement(&one, "mode-1-departure").value.is_some());
}

#[test]
fn a_large_mode_is_visible_though_two_modes_close_together_leave_the_delay_open() {
    let close = [(17.43, 0.038, -1.17e-4, 1.22e-4), (17.58, 0.028, 1.1e-4, 1.38e-4)];
    let all = [BENDING, close[0], close[1], (46.39, 0.0295, 1.54e-4, 1.92e-4)];
    let mut most_u_s: f64 = 0.0;
    for seed in 0..20 {
        let fitted = fitted(&all, OWN, seed);
        let hz = |k: &usize| fitted.modal.modes[*k].frequency_hz;
        let shown: Vec<f64> = fitted.visible.iter().map(hz).collect();
        assert!(shown.iter().any(|hz| (hz - 46.39).abs() < 0.1), "seed {seed}: {shown:?}");
        most_u_s = most_u_s.max(fitted.modal.fit.delay_u_s);
        let others: Vec<&f64> =
            shown.iter().filter(|hz| !all.iter().any(|mode| (**hz / mode.0 - 1.0).abs() < 0.02)).collect();
        assert!(others.is_empty(), "seed {seed}: {others:?} beside the true modes");
        for (name, expected_hz) in [("mode-2-departure", 18.3), ("mode-3-departure", 20.7)] {
            let found = measurement(&fitted, name);
            let Some(value) = found.value else { continue };
            let away_hz = close.map(|mode| (value + 1.0) * expected_hz - mode.0).map(f64::abs);
            let most_hz = 4.0 * found.u * expected_hz;
            assert!(
                away_hz.iter().any(|hz| *hz < most_hz),
                "seed {seed}, {name}: {away_hz:?} Hz, U {most_hz}"
            );
        }
    }
    let turned_rad = TAU * 46.39 * most_u_s;
    assert!(
        turned_rad > 0.25,
        "u of phase is {turned_rad} rad at the most: above 1/4 no residue exceeds 4 u"
    );
}

#[test]
fn a_departure_is_of_the_calculation_at_the_elevation_that_was_reached() {
    let fitted = fitted(&all_modes(), OWN, 7);
    let found = measurement(&fitted, "mode-2-departure");
    let value = found.value.expect("it was found");
    assert!((value - (17.896 / 18.3 - 1.0)).abs() < 4.0 * found.u, "{value} with {}", found.u);
    let hz = expected()[1].range_hz(22.5 * DEGREE)[0];
    assert!((hz - 17.45).abs() < 1e-9, "half way between 16.6 and 18.3 Hz: {hz}");
    assert!((expected()[1].range_hz(-5.0 * DEGREE)[0] - 16.6).abs() < 1e-12);
}

#[test]
fn a_mode_beside_every_band_is_one_that_nobody_expected() {
    let band = Expected { mode: 4, place: Place::Band([43.0, 54.0]), gyro_only: false };
    let expected: Vec<Expected> = expected().into_iter().chain([band]).collect();
    let share = |fourth_hz: f64| {
        let mut modes = all_modes();
        modes[3].0 = fourth_hz;
        let fitted = fit(&measured(&modes, OWN, 7), &expected, 45.0 * DEGREE).expect("it fits");
        let all = point::measurements("el", &expected, &fitted, 45.0 * DEGREE);
        all.into_iter().find(|m| m.measurand == "unexpected-mode-participation").expect("it is yielded")
    };
    assert_eq!(share(48.7).value, Some(0.0));
    let found = share(40.0);
    let value = found.value.expect("it was found");
    assert!(
        (value - 1.92e-4 * INERTIA).abs() < 4.0 * found.u && found.flags[0].starts_with("40.0"),
        "{found:?}"
    );
}

#[test]
fn a_bending_mode_that_is_not_there_is_not_invented() {
    for seed in 0..5 {
        let fitted = fitted(&TORSIONAL, OWN, seed);
        assert_eq!(fitted.pairs[0], None, "seed {seed}");
        assert!(fitted.pairs[1].is_some() && fitted.pairs[2].is_some());
        let none = measurement(&fitted, "mode-1-departure");
        assert_eq!(none.value, None);
        assert!(none.inconclusive.is_some_and(|reason| reason.contains("mode 1 not visible")));
    }
}

#[test]
fn a_bending_mode_below_the_noise_is_not_visible_and_the_large_ones_are() {
    let fitted = fitted(&all_modes(), 0.03, 3);
    assert_eq!(fitted.pairs[0], None);
    assert!(fitted.pairs[1].is_some() && fitted.pairs[2].is_some());
}

/// Neighbouring lines that differ by half of their value, while each repeats to 0.02 %: no modes make such a response.
#[test]
fn lines_that_no_structure_makes_have_no_modes_to_judge() {
    let mut responses = measured(&all_modes(), OWN, 4);
    // The difference of the sensors is a small part of what each of them shows.
    for (k, line) in responses.difference.iter_mut().enumerate() {
        line.value *= if k % 2 == 0 { 1.25 } else { 0.75 };
    }
    let fitted = fit(&responses, &expected(), 45.0 * DEGREE).expect("modes of a sort");
    assert!(fitted.goodness.check().is_err(), "{:?}", fitted.goodness);
    assert!(self::fitted(&all_modes(), OWN, 4).goodness.check().is_ok());
    let all = point::measurements("el", &expected(), &fitted, 45.0 * DEGREE);
    for m in all.iter().filter(|m| m.value.is_some()) {
        let reason = m.inconclusive.as_deref().unwrap_or_default();
        assert!(reason.contains("does not describe the record"), "{m:?}");
    }
}

#[test]
fn a_mode_fifteen_percent_low_keeps_its_number_and_departs() {
    let mut truth = all_modes();
    truth[1].0 *= 0.85;
    let fitted = fitted(&truth, OWN, 1);
    let value = measurement(&fitted, "mode-2-departure").value.expect("it was found");
    assert!((value - (0.85 * 17.896 / 18.3 - 1.0)).abs() < 1e-3, "{value}");
}

#[test]
fn modes_without_a_number_stay_visible() {
    let fitted = fitted(&all_modes(), OWN, 2);
    let strange: Vec<f64> = fitted
        .visible
        .iter()
        .filter(|k| !fitted.pairs.contains(&Some(**k)))
        .map(|k| fitted.modal.modes[*k].frequency_hz)
        .collect();
    assert_eq!(strange.len(), 1, "{strange:?}");
    assert!((strange[0] - 48.7).abs() < 0.1, "{strange:?}");
}

#[test]
fn what_is_judged_is_drawn_with_the_limits_of_its_requirement_and_none_of_our_own() {
    let mut measurements =
        point::measurements("el", &expected(), &fitted(&all_modes(), OWN, 0), 45.0 * DEGREE);
    for m in &mut measurements {
        let name = "elevation".to_owned();
        let value = 45.0 * DEGREE;
        let kind = crate::quantity::QuantityKind::Angle;
        m.conditions = vec![Condition { name, requested: value, achieved: Some(value), kind }];
    }
    let departure = measurements.iter().find(|m| m.measurand == "mode-2-departure").and_then(|m| m.value);
    let point = PointResult { measurements, ..PointResult::default() };
    let procedure = parsed(include_str!("../../../../fat/el-modes.toml")).expect("a shipped file");
    let plots = procedure.experiment.conclude(&[], &[point], &Axes::default()).plots;
    for mode in 1..=3 {
        let measurand = format!("mode-{mode}-departure");
        let plot =
            plots.iter().find(|p| p.limits_of.as_ref() == Some(&measurand)).expect("a picture of its own");
        assert_eq!((plot.series[0].x.len(), plot.limits.len()), (1, 0), "the judge draws the limits");
    }
    let second = plots.iter().find(|p| p.id == "mode-2-departure-over-elevation").expect("found above");
    let percent = 100.0 * departure.expect("it was found");
    assert!((second.series[0].y[0] - percent).abs() < 1e-9 && second.y.unit == "%", "{second:?}");
}

fn parsed(text: &str) -> Result<Procedure, String> {
    let source = SourceFile { name: "x.toml".to_owned(), text: text.to_owned() };
    Procedure::parse(source).map_err(|all| all.iter().map(|d| format!("{d}\n")).collect())
}

#[test]
fn shipped_files_yield_what_the_requirements_ask_for() {
    let yields = |text: &str| parsed(text).unwrap_or_else(|e| panic!("{e}")).yields;
    let departures = ["mode-1-departure", "mode-2-departure", "mode-3-departure"];
    for text in
        [include_str!("../../../../fat/el-modes.toml"), include_str!("../../../../quick/el-modes.toml")]
    {
        assert!(departures.iter().all(|name| yields(text).contains(name)));
    }
    let azimuth = yields(include_str!("../../../../fat/az-modes.toml"));
    assert!(["first-mode-frequency", "second-mode-frequency"].iter().all(|name| azimuth.contains(name)));
}

#[test]
fn expectations_that_contradict_themselves_are_refused_with_the_reason() {
    let shipped = include_str!("../../../../fat/el-modes.toml");
    let with = |from: &str, to: &str| {
        assert!(shipped.contains(from), "{from}");
        parsed(&shipped.replacen(from, to, 1)).err().unwrap_or_default()
    };
    for (from, to, message) in [
        ("mode = 2", "mode = 9", "mode 9 is out of range"),
        ("mode = 2", "mode = 1", "ascending order of their numbers"),
        ("\"10.0 Hz\", ", "", "2 frequencies at 3 elevations"),
        ("mode = 4\nband", "mode = 4\nelevation = [\"0 deg\"]\nband", "cannot be given together"),
        ("band = \"43 Hz .. 54 Hz\"", "", "the expected frequency of the mode is missing"),
        ("\"10.0 Hz\"", "\"-1 Hz\"", "give a positive frequency"),
    ] {
        let found = with(from, to);
        assert!(found.contains(message), "{to}: {found}");
    }
}
