//! Units drawn from declared distributions: findings beside what was drawn.
//!
//! `cargo run --release -p validation -- blind [--units N] [--first K] [--campaign NAME] [--program PATH] [PROCEDURE…]`: as many
//! units at a time as there are processors; shards are ranges of numbers. Ends with 1 where a measurand is wrong, a unit
//! trips, or a verdict is false by more than its uncertainty. `--print K` prints the file of a unit, for a run by hand.

use std::path::PathBuf;
use std::process::ExitCode;

use rayon::prelude::*;
use validation::blind::{Asked, Scored, Unit, draw, measured, score};
use validation::program::built;

pub(crate) fn study() -> ExitCode {
    let mut asked = Asked { program: PathBuf::new(), campaign: "quick".to_owned(), select: Vec::new() };
    let mut units = 60_u32;
    let mut first = 1_u32;
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
            "--campaign" => asked.campaign = words.next().unwrap_or(asked.campaign),
            "--program" => {
                let path = words.next().expect("a path");
                // Each run has a working folder of its own.
                asked.program = std::path::absolute(path).expect("the path is not empty");
            }
            _ => asked.select.push(word),
        }
    }
    if asked.program.as_os_str().is_empty() {
        asked.program = built();
    }
    let numbers: Vec<u32> = (first..first + units).collect();
    let all: Vec<Unit> = numbers.par_iter().map(|number| measured(&asked, *number)).collect();
    report(&numbers, &all)
}

fn report(numbers: &[u32], all: &[Unit]) -> ExitCode {
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
    let expected: f64 = scored.iter().filter_map(|one| one.probability_outside).sum();
    println!(
        "\n{} false passes, {} false fails; {expected:.2} outside by the printed probabilities",
        passes.len(),
        fails.len()
    );
    passes.iter().chain(&fails).for_each(|one| println!("- {}", one.text()));
    println!("\nTroubles:");
    for (number, unit) in numbers.iter().zip(all) {
        unit.troubles.iter().for_each(|trouble| println!("- unit {number}: {trouble}"));
        if !unit.failed.is_empty() {
            println!("- unit {number} fails {}", unit.failed.join(", "));
        }
    }
    let far = |one: &&&Scored| one.error_in_u().abs() > 1.0;
    let is_wrong = lines.iter().any(|line| line.is_wrong) || passes.iter().any(|one| far(&one));
    if is_wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
