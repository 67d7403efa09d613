//! Some mutated files of every sort, read by the program: the example `mutations` tries ten thousand of them.

use std::path::Path;

#[path = "../bench/examples/mutations/bed.rs"]
#[allow(dead_code, reason = "only the example keeps a mutated file")]
mod bed;
#[path = "../bench/examples/mutations/child.rs"]
mod child;
#[path = "../bench/examples/mutations/log.rs"]
mod log;
#[path = "../bench/examples/mutations/sorts.rs"]
mod sorts;
#[path = "../bench/examples/mutations/text.rs"]
mod text;
#[path = "../bench/examples/mutations/trial.rs"]
#[allow(dead_code, reason = "only the example prints how a file was mutated")]
mod trial;

/// Seeds: a dozen of each sort.
const SEEDS: std::ops::Range<u64> = 1000..1200;

#[test]
fn no_mutated_file_makes_the_program_panic_hang_or_take_much_memory() {
    let folder = crate::bench::folder();
    let bed = bed::Bed::make(Path::new(env!("CARGO_BIN_EXE_bench")), folder.path(), false)
        .expect("a run and imports");
    let trials = trial::all(&bed, SEEDS, None);
    assert_eq!(trials.len() as u64, SEEDS.end - SEEDS.start);
    let findings: Vec<String> = trials
        .iter()
        .filter(|trial| !trial.findings.is_empty())
        .map(|trial| format!("seed {}: {}: {}", trial.seed, trial.sort, trial.findings.join("; ")))
        .collect();
    assert!(findings.is_empty(), "{}\n{}", findings.join("\n"), trial::table(&trials));
    let taken = trials.iter().filter(|trial| trial.accepted).count();
    assert!(taken > 10, "mutated files that are taken are part of it: {taken}");
}
