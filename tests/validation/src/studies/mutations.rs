//! Mutated files of every sort that people write or a disk gives back, each read by the program itself.
//!
//! `cargo run --release -p validation -- mutations [COUNT] [--from SEED] [--only SORT] [--keep DIR]`
//!
//! Prints a line a sort and one a finding: a panic, an abort, more than five seconds of processor time, more memory than
//! eight times the input and 256 MiB, or a run that refuses what `check` accepted. Exits 1 where there is one. `--keep`
//! leaves the files of the findings there.

use std::path::Path;
use std::process::ExitCode;

use validation::mutations::{self, Bed, Trial};
use validation::program::built;

pub(crate) fn study() -> ExitCode {
    let arguments: Vec<String> = crate::arguments().collect();
    let after = |name: &str| {
        let at = arguments.iter().position(|a| a == name)?;
        arguments.get(at + 1)
    };
    let count = arguments.first().and_then(|t| t.parse::<u64>().ok()).unwrap_or(10_000);
    let from = after("--from").and_then(|t| t.parse::<u64>().ok()).unwrap_or(0);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bed = Bed::make(&built(), folder.path(), true).expect("the program makes what is then mutated");
    let trials = mutations::all(&bed, from..from + count, after("--only").map(String::as_str));
    print!("{}", mutations::table(&trials));
    let findings: Vec<&Trial> = trials.iter().filter(|t| !t.findings.is_empty()).collect();
    for found in &findings {
        println!("seed {}: {} ({}): {}", found.seed, found.sort, found.how, found.findings.join("; "));
        if let Some(keep) = after("--keep") {
            bed.keep(found.seed, &Path::new(keep).join(found.seed.to_string())).expect("a writable folder");
        }
    }
    println!("{} files, {} findings", trials.len(), findings.len());
    if findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
