//! Monte Carlo of the breakaway kind: accuracy and coverage against a LuGre plant whose contact ages.
//!
//! `cargo run --release -p procedures --example recovery_breakaway [seeds [axis]]`, 400 seeds on both axes unless said.
//! Noise: white, 1 % of the Coulomb torque on every 4 kHz torque sample; 26-bit encoder. Torque constant and inertia
//! are exact, so the uncertainty that is tested is that of the estimators.

#![allow(clippy::print_stdout)]

use statrs::distribution::{ContinuousCDF, StudentsT};

#[path = "recovery_breakaway/bench.rs"]
mod bench;
#[path = "recovery_breakaway/plant.rs"]
mod plant;
#[path = "recovery_breakaway/study.rs"]
mod study;

/// What the support files call the library.
mod procedures {
    pub(crate) use ::procedures::{axis, case, kinds, log, measurement, stimulus};
}

use ::procedures::diagnostic::SourceFile;
use ::procedures::kinds::{Experiment, kind};
use ::procedures::table::read_file;
use study::{Recovered, Study};

/// Keys of the study, but for pose and displacement.
const KEYS: &str = "\
[map]
[[ramp]]
rate = [\"1 A/s\"]
dwell = [\"1 s\", \"3 s\", \"10 s\", \"30 s\", \"100 s\"]
repeats = 5
[[ramp]]
rate = [\"0.3 A/s\", \"3 A/s\"]
dwell = [\"1 s\"]
repeats = 5
[multisine]
level = \"0.1\"
";

fn experiment(head: &str) -> Box<dyn Experiment> {
    let kind = kind("breakaway").expect("the kind is in the list");
    let source = SourceFile { name: "study.toml".to_owned(), text: format!("{head}{KEYS}") };
    read_file(&source, kind.fields, kind.read).expect("the study's keys are right")
}

fn row(all: &[Recovered], name: &str, truth: f64, allowed_ratio: f64) -> String {
    let own: Vec<&Recovered> = all.iter().filter(|r| r.name == name).collect();
    let n = own.len() as f64;
    let error = |r: &Recovered| r.value / r.truth - 1.0;
    let bias = own.iter().map(|r| error(r)).sum::<f64>() / n;
    let rms = (own.iter().map(|r| error(r).powi(2)).sum::<f64>() / n).sqrt();
    let u = own.iter().map(|r| r.u / r.truth).sum::<f64>() / n;
    let covered = own.iter().filter(|r| (r.value - r.truth).abs() <= coverage_factor(r.dof) * r.u).count();
    let verdict = if rms <= allowed_ratio && !own.is_empty() { "ok" } else { "MISSED" };
    format!(
        "{name:<28} {:>5} {truth:>11.3} {:>8.3} {:>8.3} {:>8.3} {:>8.1} {:>9.1}  {verdict}",
        own.len(),
        100.0 * bias,
        100.0 * rms,
        100.0 * u,
        100.0 * allowed_ratio,
        100.0 * covered as f64 / n,
    )
}

/// 95 % two-sided; the library's inverse of t no longer converges for millions of degrees of freedom.
fn coverage_factor(dof: f64) -> f64 {
    if dof > 1e5 {
        return 1.96;
    }
    StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |t| t.inverse_cdf(0.975))
}

fn allowed_ratio(name: &str) -> f64 {
    match name {
        "stiffness, ramps" | "stiffness, multisine" => 0.05,
        "damping, multisine" | "dwell slope" => 0.10,
        _ => 0.03,
    }
}

fn main() {
    let seeds = std::env::args().nth(1).and_then(|s| s.parse().ok()).unwrap_or(400);
    let axes = [
        ("azimuth", plant::AZIMUTH, 60.0, "pose = \"0 deg\"\ndisplacement = \"1.6 deg\"\n"),
        ("elevation", plant::ELEVATION, 52.0, "pose = \"60 deg\"\ndisplacement = \"0.6 deg\"\n"),
    ];
    let only = std::env::args().nth(2);
    for (axis, plant, torque_constant, head) in axes {
        if only.as_deref().is_some_and(|o| o != axis) {
            continue;
        }
        let study = Study::new(experiment(head), plant, torque_constant);
        let truths = study.truths();
        let all: Vec<Recovered> = (1..=seeds).flat_map(|seed| study.recover(&truths, seed)).collect();
        println!("{axis}, {seeds} seeds");
        println!(
            "{:<28} {:>5} {:>11} {:>8} {:>8} {:>8} {:>8} {:>9}",
            "", "n", "truth", "bias %", "rms %", "u %", "allow %", "cover %"
        );
        for (name, truth) in &truths {
            println!("{}", row(&all, name, *truth, allowed_ratio(name)));
        }
    }
}
