//! The whole kind, from keys to measurements, on an axis made of formulas.

extern crate self as procedures;

#[path = "../../../../examples/recovery_hysteresis/synthetic_axis.rs"]
pub(in crate::kinds) mod synthetic_axis;

mod imported;
mod keys;
mod recovery;

use super::KIND;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds::Experiment;
use crate::log::Window;
use crate::measurement::{Conclusion, Measurement, PointResult};
use crate::table::read_file;
use synthetic_axis::{Truth, rig};

/// Reads the kind's own keys as a file of their own.
fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "procedure.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

/// Plans, runs and judges.
fn run(text: &str, truth: &Truth, rate_hz: f64, seed: u64) -> Conclusion {
    run_spoiled(text, truth, rate_hz, seed, |_| {})
}

/// As [`run`], with windows that something happened to.
fn run_spoiled(
    text: &str,
    truth: &Truth,
    rate_hz: f64,
    seed: u64,
    spoil: impl Fn(&mut Window),
) -> Conclusion {
    let experiment = read(text).expect("the keys are right");
    let axes = rig(&[truth]);
    let cases = experiment.plan(truth.name, &axes).expect("the axis can do it");
    let points: Vec<_> = cases
        .iter()
        .zip(0..)
        .map(|(case, k)| {
            let mut window = truth.run(case, rate_hz, 1000 * seed + k);
            spoil(&mut window);
            experiment.analyse(case, &window, &axes)
        })
        .collect();
    experiment.conclude(&cases, &points, &axes)
}

/// The first measurement of this name.
fn find<'a>(conclusion: &'a Conclusion, name: &str) -> &'a Measurement {
    let found = conclusion.measurements.iter().find(|m| m.measurand == name);
    found.unwrap_or_else(|| panic!("no {name} in {:?}", conclusion.measurements))
}

/// Asserts a value within a ratio of the truth and within 4 u of it.
fn near(measurement: &Measurement, truth: f64, ratio: f64) {
    let value = measurement.value.unwrap_or_else(|| panic!("{:?}", measurement.inconclusive));
    let off = (value - truth).abs();
    assert!(off <= ratio * truth.abs(), "{}: {value}, truth {truth}", measurement.measurand);
    assert!(
        off <= 4.0 * measurement.u,
        "{}: {value} ± {}, truth {truth}",
        measurement.measurand,
        measurement.u
    );
}
