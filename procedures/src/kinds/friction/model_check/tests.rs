//! The whole kind, from keys to measurements, on an axis made of formulas.

extern crate self as procedures;

use super::*;
use crate::diagnostic::SourceFile;
use crate::kinds::friction::hysteresis::tests::synthetic_axis::{Truth, azimuth, elevation, rig};
use crate::measurement::Measurement;
use crate::table::read_file;

const AZIMUTH: &str = r#"
span = "-30 deg .. 30 deg"
cycles = 1
[model]
coulomb = "167.75 N*m"
static = "210 N*m"
stribeck-velocity = "0.12 rad/s"
stribeck-shape = "2.5"
viscous = "273.6 N*m*s/rad"
"#;

const ELEVATION: &str = r#"
span = "-5 deg .. 85 deg"
cycles = 1
[model]
coulomb = "34.5 N*m"
static = "43.125 N*m"
stribeck-velocity = "0.012 rad/s"
stribeck-shape = "0.85"
viscous = "68.4 N*m*s/rad"
unbalance = "14 N*m"
spring = "54 N*m/rad"
spring-rest = "40 deg"
"#;

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "procedure.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

fn run(text: &str, truth: &Truth) -> Vec<Measurement> {
    let experiment = read(text).expect("the keys are right");
    let axes = rig(&[truth]);
    let cases = experiment.plan(truth.name, &axes).expect("the axis can do it");
    assert_eq!(cases.len(), 1);
    let point = experiment.analyse(&cases[0], &truth.run(&cases[0], 1000.0, 5), &axes);
    assert_eq!((point.inconclusive.as_ref(), point.plots.len()), (None, 1));
    experiment.conclude(&cases, &[point], &axes).measurements
}

/// Mean of growing, then of falling angle.
fn means(all: &[Measurement]) -> [f64; 2] {
    let is_mean = |m: &&Measurement| m.measurand == MEAN;
    let values: Vec<f64> = all.iter().filter(is_mean).filter_map(|m| m.value).collect();
    values.try_into().expect("both directions")
}

#[test]
fn a_model_that_is_true_misses_only_the_cogging() {
    for (text, truth, ripple) in [(AZIMUTH, azimuth(), 8.45), (ELEVATION, elevation(), 5.07)] {
        let found = run(text, &truth);
        for mean in found.iter().filter(|m| m.measurand == MEAN) {
            let value = mean.value.expect("a mean");
            assert!(value.abs() < 3.0 * mean.u && mean.u < 0.01 * truth.friction_nm(0.26), "{mean:?}");
            let velocity = &mean.conditions[0];
            assert!((velocity.achieved.expect("reached") / velocity.requested - 1.0).abs() < 0.01);
        }
        for rms in found.iter().filter(|m| m.measurand == RMS) {
            let value = rms.value.expect("a root mean square");
            let expected = ripple / 2_f64.sqrt();
            assert!((value / expected - 1.0).abs() < 0.05, "{value}, {expected}");
        }
    }
}

#[test]
fn friction_that_the_model_lacks_shows_against_the_motion_and_unbalance_along_one_way() {
    let rougher = Truth { coulomb_nm: 187.75, static_nm: 230.0, ..azimuth() };
    let [growing, falling] = means(&run(AZIMUTH, &rougher));
    assert!((growing - 20.0).abs() < 1.0 && (falling + 20.0).abs() < 1.0, "{growing} {falling}");
    let heavier = Truth { unbalance_nm: 34.0, ..elevation() };
    let [growing, falling] = means(&run(ELEVATION, &heavier));
    // 20 N·m·cos θ, mean over −5 … 85 deg less the ramps: 14 N·m less in both directions.
    assert!((growing + 13.8).abs() < 0.6 && (falling - growing).abs() < 0.5, "{growing} {falling}");
}

#[test]
fn a_span_too_short_is_refused_and_a_log_without_the_axis_is_inconclusive_with_a_reason() {
    let truth = azimuth();
    let axes = rig(&[&truth]);
    let short = read(&AZIMUTH.replace("-30 deg .. 30 deg", "-5 deg .. 5 deg")).expect("the keys are right");
    let refused = short.plan("az", &axes).expect_err("no period fits");
    assert!(refused[0].message.contains("is too short for velocity"), "{refused:?}");
    let experiment = read(AZIMUTH).expect("the keys are right");
    let cases = experiment.plan("az", &axes).expect("the axis can do it");
    let mut bare = truth.run(&cases[0], 1000.0, 5);
    bare.topics.clear();
    let found = experiment.analyse(&cases[0], &bare, &axes);
    assert!(found.inconclusive.as_ref().is_some_and(|r| r.to_string().contains("no topic /az")), "{found:?}");
    assert!(found.measurements.len() == 4 && found.measurements.iter().all(|m| m.value.is_none()));
}

#[test]
fn a_model_that_cannot_be_and_strokes_beyond_the_axis_are_refused() {
    let wrong = AZIMUTH.replace("static = \"210 N*m\"", "static = \"100 N*m\"");
    let mistakes = read(&wrong).expect_err("static below Coulomb");
    assert!(mistakes[0].message.contains("must not be below `coulomb`"), "{mistakes:?}");
    let far = read(&AZIMUTH.replace("-30 deg", "-200 deg")).expect("the keys are right");
    let refused = far.plan("az", &rig(&[&azimuth()])).expect_err("outside the travel");
    assert!(refused[0].message.contains("exceeds the axis' soft limits"), "{refused:?}");
}
