//! The studies: what the simulator and the estimators are compared with, over many seeds.
//!
//! `cargo run --release -p validation -- <study> [arguments]`; without a study: the list of them.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints tables")]
#![allow(clippy::unit_arg, reason = "a study that only prints succeeds")]

use std::process::{ExitCode, Termination};

mod studies;

use studies::*;

/// A study by name.
struct Study {
    name: &'static str,
    about: &'static str,
    run: fn() -> ExitCode,
}

const fn study(name: &'static str, about: &'static str, run: fn() -> ExitCode) -> Study {
    Study { name, about, run }
}

#[rustfmt::skip]
const STUDIES: [Study; 22] = [
    study("blind", "units drawn from declared distributions: findings beside what was drawn", || blind::study().report()),
    study("compare_runs", "rows, events and findings of two runs of one campaign", || compare_runs::study().report()),
    study("current_limits", "every moving procedure on drives that give less than the rig file says", || current_limits::study().report()),
    study("expected_results", "what every unit and defect is expected to show, from the model", || expected_results::study().report()),
    study("loop_margins", "measured velocity loops beside the model, all elevations", || loop_margins::study().report()),
    study("measured_flips", "every defect against what it must and may fail, by whole runs", || measured_flips::study().report()),
    study("mode_map", "measured modes beside the unit's own, all elevations", || mode_map::study().report()),
    study("mutations", "mutated files of every sort: no panic, no hang, bounded memory", || mutations::study().report()),
    study("planted_changes", "how often planted changes of a controller are called rightly", || planted_changes::study().report()),
    study("polarity", "every wrong sign and scale caught, no false alarm", || polarity::study().report()),
    study("published_tables", "tables 4.1 to 4.5 of the study beside model and simulation", || published_tables::study().report()),
    study("recovery_allan", "noises of a gyro from an hour's record", || recovery_allan::study().report()),
    study("recovery_chain", "the whole chain against the unit's own parameters, both axes", || recovery_chain::study().report()),
    study("recovery_margins", "margins, delays, current loop", || recovery_margins::study().report()),
    study("recovery_modes", "modes and circuits", || recovery_modes::study().report()),
    study("recovery_tracking", "root mean squares of track errors: coverage", || recovery_tracking::study().report()),
    study("signals", "runs that get signals at random instants, with readers that stall", || signals::study().report()),
    study("track_margins", "measured coarse track loops beside the model", || track_margins::study().report()),
    study("tracking", "rail and drone tracked by the whole director, mirror against turbulence", || tracking::study().report()),
    study("trips", "random trips compared with the computed stops", || trips::study().report()),
    study("twins", "drawn units run, identified and run again as their twins", || twins::study().report()),
    study("wired_scatter", "a run over real wires beside the scatter of virtual runs", || wired_scatter::study().report()),
];

/// Arguments after the name of the study.
fn arguments() -> impl Iterator<Item = String> {
    std::env::args().skip(2)
}

fn main() -> ExitCode {
    let asked = std::env::args().nth(1).unwrap_or_default();
    if let Some(study) = STUDIES.iter().find(|study| study.name == asked) {
        return (study.run)();
    }
    if !asked.is_empty() {
        eprintln!("error: there is no study `{asked}`");
    }
    for study in &STUDIES {
        eprintln!("{:<18} {}", study.name, study.about);
    }
    ExitCode::from(2)
}
