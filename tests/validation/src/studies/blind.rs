//! Units drawn from declared distributions: findings beside what was drawn.
//!
//! `cargo run --release -p validation -- blind [--units N] [--first K] [--campaign NAME] [--program PATH] [PROCEDURE…]`: as many
//! units at a time as there are processors. Shards are ranges of numbers: `--save FILE` keeps what they found, `--load FILE` (any
//! number of times) reports what shards kept, without a run. Ends with 1 where a measurand is wrong, less than 92 % of all
//! findings lie within U, a verdict is false by more than its uncertainty, or more are false than their printed probabilities
//! explain. `--print K` prints the file of a unit, for a run by hand.

use std::path::PathBuf;
use std::process::ExitCode;

use rayon::prelude::*;
use validation::blind::{Asked, Scored, Unit, draw, measured, score};
use validation::program::built;

pub(crate) fn study() -> ExitCode {
    let mut asked = Asked { program: PathBuf::new(), campaign: "quick".to_owned(), select: Vec::new() };
    let mut units = 60_u32;
    let mut first = 1_u32;
    let mut save: Option<PathBuf> = None;
    let mut kept: Vec<Unit> = Vec::new();
    let mut words = crate::arguments();
    while let Some(word) = words.next() {
        let mut number = || words.next().and_then(|text| text.parse().ok()).expect("a number");
        match word.as_str() {
            "--units" => units = number(),
            "--first" => first = number(),
            "--print" => {
                let number = number();
                print!("{}", draw::unit(&format!("unit-{number}"), number));
                return ExitCode::SUCCESS;
            }
            "--save" => save = words.next().map(PathBuf::from),
            "--load" => kept.extend(load(&words.next().expect("a file of a shard"))),
            "--campaign" => asked.campaign = words.next().unwrap_or(asked.campaign),
            "--program" => {
                let path = words.next().expect("a path");
                // Each run has a working folder of its own.
                asked.program = std::path::absolute(path).expect("the path is not empty");
            }
            _ => asked.select.push(word),
        }
    }
    if !kept.is_empty() {
        return report(&kept);
    }
    if asked.program.as_os_str().is_empty() {
        asked.program = built();
    }
    let numbers: Vec<u32> = (first..first + units).collect();
    let all: Vec<Unit> = numbers.par_iter().map(|number| measured(&asked, *number)).collect();
    if let Some(path) = save {
        let text = serde_json::to_string(&all).expect("plain numbers");
        std::fs::write(&path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    report(&all)
}

/// What a shard kept.
fn load(path: &str) -> Vec<Unit> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Least share of all findings within U: 95 % are promised.
const LEAST_POOLED: f64 = 92.0;
/// Uncertainties that are so many times as large as the errors are listed.
const TOO_CAREFUL: f64 = 2.0;

fn report(all: &[Unit]) -> ExitCode {
    let scored: Vec<Scored> = all.iter().flat_map(|unit| unit.scored.clone()).collect();
    let lines = score::lines(&scored);
    print!("{}", score::table(&lines));
    let covered = scored.iter().filter(|one| one.is_covered()).count();
    let share = 100.0 * covered as f64 / scored.len().max(1) as f64;
    println!("\n{} units, {} findings, {share:.1} % within U", all.len(), scored.len());
    println!("\nFarther than 2 U from the truth:");
    for one in scored.iter().filter(|one| one.error_in_u().abs() > 2.0) {
        println!("- {}", one.text());
    }
    let falsely = |is: fn(&Scored) -> bool| scored.iter().filter(|one| is(one)).collect::<Vec<_>>();
    let (passes, fails) = (falsely(Scored::is_false_pass), falsely(Scored::is_false_fail));
    let outside = |passed: bool| -> Vec<f64> {
        let own = scored.iter().filter(|one| one.is_pass() == passed && one.is_decided());
        own.filter_map(|one| one.probability_outside).map(|p| if passed { p } else { 1.0 - p }).collect()
    };
    let [most_passes, most_fails] = [true, false].map(|passed| score::most_events(&outside(passed)));
    println!(
        "\n{} false passes (99 % of series have at most {most_passes} by the printed probabilities), {} false fails (at most \
         {most_fails})",
        passes.len(),
        fails.len()
    );
    passes.iter().chain(&fails).for_each(|one| println!("- {}", one.text()));
    println!("\nTroubles:");
    for unit in all {
        unit.troubles.iter().for_each(|trouble| println!("- unit {}: {trouble}", unit.number));
        if !unit.failed.is_empty() {
            println!("- unit {} fails {}", unit.number, unit.failed.join(", "));
        }
    }
    println!("\nMore careful than {TOO_CAREFUL} times the errors:");
    for line in lines.iter().filter(|line| line.u_over_rms > TOO_CAREFUL) {
        println!("- {}: {:.1}", line.name, line.u_over_rms);
    }
    let far = |one: &&&Scored| one.error_in_u().abs() > 1.0;
    let is_wrong = share < LEAST_POOLED
        || lines.iter().any(|line| line.is_wrong)
        || passes.iter().any(|one| far(&one))
        || passes.len() > most_passes
        || fails.len() > most_fails;
    if is_wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
