//! Some mutated files of every sort, read by the program: the example `mutations` tries ten thousand of them.

use std::path::Path;

use validation::mutations::{self, Bed};

/// Seeds: a dozen of each sort.
const SEEDS: std::ops::Range<u64> = 1000..1200;

#[test]
fn no_mutated_file_makes_the_program_panic_hang_or_take_much_memory() {
    let folder = crate::bench::folder();
    let bed =
        Bed::make(Path::new(env!("CARGO_BIN_EXE_bench")), folder.path(), false).expect("a run and imports");
    let trials = mutations::all(&bed, SEEDS, None);
    assert_eq!(trials.len() as u64, SEEDS.end - SEEDS.start);
    let findings: Vec<String> = trials
        .iter()
        .filter(|trial| !trial.findings.is_empty())
        .map(|trial| format!("seed {}: {}: {}", trial.seed, trial.sort, trial.findings.join("; ")))
        .collect();
    assert!(findings.is_empty(), "{}\n{}", findings.join("\n"), mutations::table(&trials));
    let taken = trials.iter().filter(|trial| trial.accepted).count();
    assert!(taken > 10, "mutated files that are taken are part of it: {taken}");
}
