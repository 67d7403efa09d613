//! Records that are right, and every way in which one can be wrong.

use std::f64::consts::TAU;

use analysis::frf::C64;

use super::KIND;
use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds::Experiment;
use crate::log::Window;
use crate::measurement::{Conclusion, Measurement};
use crate::synthetic;
use crate::table::read_file;

const RATE_HZ: f64 = 1000.0;
const PERIODS: usize = 5;
const KEYS: &str = r#"source = "periodic"
at = ["20 Hz"]
[record]
period = "1 s"
input = "current_a"
reference = "current_command_a"
from = "5 Hz"
to = "99 Hz"
step = "2 Hz"
detection = "5 Hz .. 99 Hz"
[[response]]
name = "angle"
output = "position_rad"
derivative = 1
"#;

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "procedure.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

/// Torque to angle of two masses: anti-resonance 40.3 Hz, resonance 60.7 Hz.
fn plant(hz: f64) -> C64 {
    let s = C64::new(0.0, TAU * hz);
    let pair = |hz: f64, damping: f64| s * s / (TAU * hz).powi(2) + s * (2.0 * damping / (TAU * hz)) + 1.0;
    pair(40.3, 0.02) / (pair(60.7, 0.02) * s * s) * 1000.0
}

/// Repeatable scatter of uneven size, uniform in −1 … 1 (Weyl sequence).
fn scatter(k: usize, channel: f64) -> f64 {
    2.0 * (k as f64 * 0.618_033_988_749_895 * channel).fract() - 1.0
}

/// A channel of the record: its name and samples.
type Column = (&'static str, Vec<f64>);

/// Five periods of command, current and angle.
fn record() -> (Vec<f64>, Vec<Column>) {
    let count = PERIODS * RATE_HZ as usize;
    let lines: Vec<f64> = (0..48).map(|k| 5.0 + 2.0 * f64::from(k)).collect();
    let sum = |i: usize, gain: &dyn Fn(f64) -> C64| -> f64 {
        let t_s = (i % 1000) as f64 / RATE_HZ;
        let one = |(k, hz): (usize, &f64)| {
            (gain(*hz) * C64::from_polar(1.0, TAU * hz * t_s + 0.13 * (k * k) as f64)).re
        };
        lines.iter().enumerate().map(one).sum()
    };
    let one = C64::new(1.0, 0.0);
    let command: Vec<f64> = (0..1000).map(|i| sum(i, &|_| one)).collect();
    let angle: Vec<f64> = (0..1000).map(|i| sum(i, &plant)).collect();
    let whole = |values: &[f64], noise: f64, channel: f64| -> Vec<f64> {
        (0..count).map(|i| values[i % 1000] + noise * scatter(i + 1, channel)).collect()
    };
    let time_s = (0..count).map(|i| 1.0 + i as f64 / RATE_HZ).collect();
    let columns = vec![
        ("current_command_a", whole(&command, 0.0, 1.0)),
        ("current_a", whole(&command, 1e-3, 1.37)),
        ("position_rad", whole(&angle, 1e-5, 2.71)),
    ];
    (time_s, columns)
}

fn window(time_s: Vec<f64>, columns: Vec<Column>) -> Window {
    let end_s = time_s.last().map_or(1.0, |t| t + 1e-3);
    let rows = synthetic::rows("/motor", &time_s, columns);
    Window::completed(vec![rows], vec![synthetic::span(0, 1.0, end_s)])
}

fn judge(keys: &str, window: &Window) -> Conclusion {
    let experiment = read(keys).expect("the keys are right");
    let case = Case { point: "record".to_owned(), axis: "motor".to_owned(), ..Case::default() };
    let axes = Axes::default();
    let point = experiment.analyse(&case, window, &axes);
    experiment.conclude(std::slice::from_ref(&case), &[point], &axes)
}

fn find<'a>(conclusion: &'a Conclusion, name: &str) -> &'a Measurement {
    let found = conclusion.measurements.iter().find(|m| m.measurand == name);
    found.unwrap_or_else(|| panic!("no {name} in {:?}", conclusion.measurements))
}

#[test]
fn resonance_and_antiresonance_lie_between_the_lines_of_the_record() {
    let (time_s, columns) = record();
    let found = judge(KEYS, &window(time_s, columns));
    for (name, truth_hz) in [("resonance-frequency", 60.7), ("antiresonance-frequency", 40.3)] {
        let m = find(&found, name);
        assert_eq!(m.inconclusive, None, "{m:?}");
        let off_hz = (m.value.expect("a peak") - truth_hz).abs();
        assert!(off_hz < 0.02 && off_hz < 5.0 * m.u + 1e-3, "{name}: {m:?}");
    }
    let gain_db = find(&found, "response-gain");
    assert_eq!(gain_db.inconclusive.as_deref(), Some("no line at 20 Hz"), "lines are odd: {gain_db:?}");
    let deviation = find(&found, "relative-deviation");
    assert!(deviation.value.is_some_and(|v| v > 0.0 && v < 0.1) && deviation.u > 0.0, "{deviation:?}");
}

#[test]
fn a_reversed_output_turns_the_phase_by_half_a_turn() {
    let (time_s, columns) = record();
    let window = window(time_s, columns);
    let keys = KEYS.replace("20 Hz", "21 Hz");
    let phase = |keys: &str| find(&judge(keys, &window), "response-phase").value.expect("a line");
    let turned = phase(&format!("{keys}reversed = true\n")) - phase(&keys);
    assert!((turned.abs() - std::f64::consts::PI).abs() < 1e-9, "{turned}");
}

#[test]
fn one_wrong_sample_of_the_reference_is_listed_and_does_not_count() {
    let (time_s, mut columns) = record();
    *columns[0].1.last_mut().expect("samples") = 0.0;
    let keys = KEYS.replace("input = \"current_a\"", "input = \"current_command_a\"");
    let found = judge(&keys, &window(time_s.clone(), columns));
    let excluded = &find(&found, "resonance-frequency").excluded;
    assert!(
        excluded.iter().any(|e| e.count == 1 && e.reason.starts_with("current_command_a")),
        "{excluded:?}"
    );
    let clean = judge(&keys, &window(time_s, record().1));
    assert_eq!(find(&found, "resonance-frequency").value, find(&clean, "resonance-frequency").value);
}

#[test]
fn even_and_odd_distortion_come_back_from_lines_left_out() {
    let (time_s, mut columns) = record();
    let amplitude = |hz: f64, part: f64| part * (plant(61.0) * TAU * 61.0).norm() / (TAU * hz);
    for (i, v) in columns[2].1.iter_mut().enumerate() {
        let t_s = i as f64 / RATE_HZ;
        *v += amplitude(50.0, 0.1) * (TAU * 50.0 * t_s).cos();
    }
    let found = judge(KEYS, &window(time_s, columns));
    assert!(find(&found, "odd-distortion").inconclusive.is_some(), "every odd line is excited");
    let even = find(&found, "even-distortion");
    // One of 47 even lines, against 48 excited ones.
    let excited: f64 =
        (0..48).map(|k| 5.0 + 2.0 * f64::from(k)).map(|f| (plant(f) * TAU * f).norm_sqr()).sum();
    let level = amplitude(50.0, 0.1) * TAU * 50.0;
    let expected = ((level * level / 47.0) / (excited / 48.0)).sqrt();
    assert!((even.value.expect("even") / expected - 1.0).abs() < 0.02, "{even:?}, expected {expected}");
}

/// What is done to a record, and what the reason must say.
type Damage = (&'static str, fn(&mut Vec<f64>, &mut Vec<Column>), &'static str);

const DAMAGED: &[Damage] = &[
    ("constant output", |_, c| c[2].1.fill(0.25), "position_rad"),
    ("constant input", |_, c| c[1].1.fill(0.25), "current_a"),
    ("not a number", |_, c| c[2].1[2500] = f64::NAN, "expected a finite number"),
    ("infinite reference", |_, c| c[0].1[2500] = f64::INFINITY, "expected a finite number"),
    ("too short", |t, c| cut(t, c, 3999), "record too short"),
    ("one row", |t, c| cut(t, c, 1), "expected a record"),
    ("no input", |_, c| drop(c.remove(1)), "has no channel current_a"),
    ("no reference", |_, c| drop(c.remove(0)), "has no channel current_command_a"),
    ("a gap", |t, _| t[3000..].iter_mut().for_each(|t| *t += 0.05), "not evenly spaced"),
    ("jitter", |t, _| t[3000] += 4e-4, "not evenly spaced"),
    (
        "another rate",
        |t, _| t.iter_mut().for_each(|t| *t = 1.0 + (*t - 1.0) * 1.0005),
        "whole number of samples",
    ),
    ("a reference that is noise", |_, c| noise(&mut c[0].1), "differ from period to period"),
    ("an input that is noise", |_, c| noise(&mut c[1].1), "not a line of the excitation"),
];

fn cut(time_s: &mut Vec<f64>, columns: &mut [Column], rows: usize) {
    time_s.truncate(rows);
    columns.iter_mut().for_each(|(_, c)| c.truncate(rows));
}

fn noise(values: &mut [f64]) {
    values.iter_mut().enumerate().for_each(|(i, v)| *v = scatter(i * i % 7919 + i, 0.73));
}

#[test]
fn a_damaged_record_gives_a_reason_and_no_number() {
    for (what, damage, reason) in DAMAGED {
        let (mut time_s, mut columns) = record();
        damage(&mut time_s, &mut columns);
        let found = judge(KEYS, &window(time_s, columns));
        assert!(!found.measurements.is_empty(), "{what}");
        for m in &found.measurements {
            assert_eq!(m.value, None, "{what}: {m:?}");
            assert!(m.inconclusive.as_deref().is_some_and(|r| r.contains(reason)), "{what}: {m:?}");
        }
    }
}

#[test]
fn keys_that_do_not_fit_the_record_give_a_reason_and_no_number() {
    for (what, from, to, reason) in [
        ("period of 0.9995 s", "period = \"1 s\"", "period = \"0.9995 s\"", "whole number of samples"),
        ("period of another signal", "period = \"1 s\"", "period = \"0.6 s\"", "whole multiple of 1/period"),
        ("lines off the grid", "from = \"5 Hz\"", "from = \"5.3 Hz\"", "whole multiple of 1/period"),
        ("lines above 0.4 of the rate", "to = \"99 Hz\"", "to = \"401 Hz\"", "0.4 of the sample rate"),
        ("lines that nobody excited", "step = \"2 Hz\"", "step = \"1 Hz\"", "not a line of the excitation"),
        (
            "all periods dropped",
            "period = \"1 s\"",
            "period = \"1 s\"\ndropped-periods = 5",
            "record too short",
        ),
    ] {
        let (time_s, columns) = record();
        let found = judge(&KEYS.replacen(from, to, 1), &window(time_s, columns));
        for m in &found.measurements {
            assert_eq!(m.value, None, "{what}: {m:?}");
            assert!(m.inconclusive.as_deref().is_some_and(|r| r.contains(reason)), "{what}: {m:?}");
        }
    }
}

/// An analyser's lines of one mode at 30.1 Hz: frequency, real, imaginary, coherence.
fn analysed() -> Vec<[f64; 4]> {
    let mode = |hz: f64| {
        let s = C64::new(0.0, TAU * hz);
        (s * s + s * (2.0 * 0.02 * TAU * 30.1) + (TAU * 30.1).powi(2)).inv() * 1e4
    };
    (0..120).map(|k| 0.5 * f64::from(k)).map(|hz| [hz, mode(hz).re, mode(hz).im, 0.95]).collect()
}

fn analyse(keys: &str, rows: &[[f64; 4]]) -> Conclusion {
    let column = |c: usize| rows.iter().map(|r| r[c]).collect();
    let names = ["frequency_hz", "response_real", "response_imag", "coherence"];
    let columns = names.into_iter().enumerate().map(|(c, name)| (name, column(c))).collect();
    judge(keys, &window((0..rows.len()).map(|k| 1.0 + 1e-3 * k as f64).collect(), columns))
}

const ANALYSER: &str = "source = \"analyser\"\nfind = \"resonances\"\nat = [\"30 Hz\"]\n";

#[test]
fn lines_of_an_analyser_are_gated_by_their_coherence() {
    let mut rows = analysed();
    rows[7][3] = 1.04;
    rows[10][3] = 0.2;
    let found = analyse(&format!("{ANALYSER}averages = 20\n"), &rows);
    let peak = find(&found, "resonance-frequency");
    assert!(peak.inconclusive.is_none() && (peak.value.expect("a peak") - 30.1).abs() < 0.01, "{peak:?}");
    let reasons: Vec<(usize, &str)> = peak.excluded.iter().map(|e| (e.count, e.reason.as_str())).collect();
    assert_eq!(
        reasons,
        [
            (1, "coherence outside 0 … 1, which is impossible: 3.5 Hz (1.040)"),
            (1, "0 Hz has no phase"),
            (1, "coherence, bias-corrected for 20 averages, below 0.9"),
        ]
    );
    let deviation = find(&found, "relative-deviation").value.expect("20 averages");
    assert!((deviation - (0.05_f64 / (0.95 * 20.0)).sqrt()).abs() < 1e-12, "{deviation}");
}

#[test]
fn what_few_averages_make_of_noise_does_not_pass_for_coherent() {
    let passed = |coherence: f64, averages: u32| {
        let mut rows = analysed();
        rows.iter_mut().for_each(|r| r[3] = coherence);
        find(&analyse(&format!("{ANALYSER}averages = {averages}\n"), &rows), "response-gain")
            .inconclusive
            .clone()
    };
    // 0.901 − 0.099²/5 = 0.8990 is below 0.9; with 20 averages 0.9005 is not.
    let biased = passed(0.901, 5).expect("its bias makes it too high");
    assert_eq!(biased, "not certified: coherence 0.8990 at 30 Hz, at least 0.9 is needed");
    assert_eq!(passed(0.901, 20), None);
    // Two averages of mere noise exceed 0.95 in 5 of 100 lines, four exceed 0.9 in 1 of 1000.
    assert!(passed(0.95, 2).is_some_and(|reason| reason.contains("at least 0.999 is needed")));
    assert!(passed(0.95, 4).is_none() && passed(0.9995, 2).is_none());
}

#[test]
fn a_peak_of_poor_coherence_has_a_place_but_no_verdict() {
    let mut rows = analysed();
    rows.iter_mut().for_each(|r| r[3] = 0.42);
    let found = analyse(ANALYSER, &rows);
    let peak = find(&found, "resonance-frequency");
    assert!((peak.value.expect("a place") - 30.1).abs() < 0.01 && peak.u >= 0.5 / 12_f64.sqrt(), "{peak:?}");
    let reason = peak.inconclusive.as_deref();
    assert_eq!(reason, Some("not certified: coherence 0.42 at 30 Hz, at least 0.9 is needed"));
    let deviation = find(&found, "relative-deviation");
    assert!(deviation.value.is_none() && deviation.inconclusive.is_some(), "{deviation:?}");
}

#[test]
fn a_damaged_response_gives_a_reason_and_no_number() {
    type Damage = (&'static str, fn(&mut Vec<[f64; 4]>), &'static str);
    let damaged: [Damage; 5] = [
        ("descending", |r| r.swap(4, 5), "frequencies must ascend"),
        ("not a number", |r| r[3][1] = f64::NAN, "not finite"),
        ("constant", |r| r.iter_mut().for_each(|r| (r[1], r[2]) = (1.0, 0.0)), "the same value on all lines"),
        ("two lines", |r| r.truncate(3), "fewer than three lines"),
        ("impossible", |r| r.iter_mut().for_each(|r| r[3] = 1.5), "no line with a possible coherence"),
    ];
    for (what, damage, reason) in damaged {
        let mut rows = analysed();
        damage(&mut rows);
        for m in &analyse(ANALYSER, &rows).measurements {
            assert_eq!(m.value, None, "{what}: {m:?}");
            assert!(m.inconclusive.as_deref().is_some_and(|r| r.contains(reason)), "{what}: {m:?}");
        }
    }
}

#[test]
fn keys_of_the_other_source_are_refused() {
    for (keys, expected) in [
        ("source = \"periodic\"\n", "needs a table `[record]`"),
        ("source = \"analyser\"\nleast-coherence = \"1.2\"\n", "at most 1"),
        (
            "source = \"analyser\"\n[record]\nperiod = \"1 s\"\ninput = \"a\"\nfrom = \"1 Hz\"\nto = \"2 Hz\"\n",
            "`record` has no meaning",
        ),
    ] {
        let mistakes = read(keys).expect_err("a mistake");
        assert!(mistakes.iter().any(|m| m.message.contains(expected)), "{mistakes:?}");
    }
}
