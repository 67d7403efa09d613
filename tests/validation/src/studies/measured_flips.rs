//! Every defect against what it must and may turn, by runs of the program: as a customer would see them.
//!
//! `cargo run --release -p validation -- measured_flips [[--whole] [--campaign NAME] [--program PATH] [DEFECT…]]`: by
//! default each defect runs what verifies the requirements that it must or may turn; with `--whole` the whole campaign, so
//! that what it turns beside them shows, too. Ends with 1 where a claim does not hold. `tests/defects.rs` does the first.

use std::path::PathBuf;
use std::process::ExitCode;

use validation::measured_flips::{Asked, HEAD, measured};
use validation::program::built;

pub(crate) fn study() -> ExitCode {
    let mut asked =
        Asked { whole: false, campaign: "quick".to_owned(), program: PathBuf::new(), defects: Vec::new() };
    let mut words = crate::arguments();
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
