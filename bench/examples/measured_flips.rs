//! Every defect against what it must and may turn, by runs of the program: as a customer would see them.
//!
//! `cargo run --release -p bench --example measured_flips [-- [--whole] [--campaign NAME] [--program PATH] [DEFECT…]]`: by
//! default each defect runs what verifies the requirements that it must or may turn; with `--whole` the whole campaign, so
//! that what it turns beside them shows, too. Ends with 1 where a claim does not hold. `tests/defects.rs` does the first.

#![allow(clippy::print_stdout, reason = "it is a program that prints a table")]

#[path = "measured_flips/runs.rs"]
mod runs;

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use runs::{Asked, HEAD, measured};

fn main() -> ExitCode {
    let mut asked =
        Asked { whole: false, campaign: "quick".to_owned(), program: PathBuf::new(), defects: Vec::new() };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--whole" => asked.whole = true,
            "--campaign" => asked.campaign = words.next().unwrap_or(asked.campaign),
            "--program" => asked.program = words.next().map_or(asked.program, PathBuf::from),
            _ => asked.defects.push(word),
        }
    }
    if asked.program.as_os_str().is_empty() {
        asked.program = built();
    }
    println!("{HEAD}");
    let mut broken = 0;
    let count = measured(&asked, |row| {
        broken += row.broken.len();
        println!("{}", row.line());
    });
    println!("{count} defects, {broken} broken claims");
    if broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// This checkout's program, built as this one is: it lies one folder above the examples.
fn built() -> PathBuf {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "-p", "bench", "--bin", "bench"]);
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    assert!(cargo.status().is_ok_and(|status| status.success()), "the program builds");
    let own = std::env::current_exe().expect("a program knows where it lies");
    own.parent().and_then(|examples| examples.parent()).expect("below the target's folder").join("bench")
}
