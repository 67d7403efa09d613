//! Units drawn from declared distributions: findings beside what was drawn.
//!
//! `cargo run --release -p validation -- blind [--units N] [--first K] [--campaign NAME] [--program PATH] [--verifying]
//! [PROCEDURE…]`: as many units at a time as there are processors. Shards are ranges of numbers: `--save FILE` keeps what
//! they found, `--load FILE` (any number of times) reports what shards kept, without a run. Ends with 1 where a measurand is
//! wrong, less than 92 % of all findings lie within U, a verdict is false by more than its uncertainty, or more are false
//! than their printed probabilities explain. `--print K` prints the file of a unit, for a run by hand. `--keep FOLDER` keeps
//! the runs, one folder a unit; with `--again` they are judged by the program as it is now, without a run: for a change of an
//! estimator; with `--score` what they found is scored, and nothing else: for a change of a truth. With `--verifying` (and
//! `--campaign fat`) only those procedures run that verify what `quick` covers in part. With `--in-service` the units have play,
//! slip, wear, jitter and drifts, too (family `in-service`). With `--on-limits` the truths of the units are put on limits: of
//! those findings as many may pass as the rules promise, and half by simple acceptance. With `--unit ID` all are that shipped
//! unit, and only their seeds differ: for how often intervals hold the truth where nothing but noise changes.

use std::path::PathBuf;
use std::process::ExitCode;

use rayon::prelude::*;
use validation::blind::{
    Asked, Scored, Unit, Units, draw, judged_again, measured, measured_in, on_limits, score, scored_again,
};
use validation::program::built;

/// Procedures of `fat` that verify what `quick` covers in part only, and whose truths are known; with the gauges and the sensors
/// that these rest on.
const VERIFYING: [&str; 20] = [
    "AZ-VELOCITY-LOOP",
    "EL-VELOCITY-LOOP",
    "AZ-MODES",
    "EL-MODES",
    "AZ-FRICTION",
    "EL-FRICTION",
    "AZ-CURRENT",
    "EL-CURRENT",
    "AZ-LATENCY",
    "EL-LATENCY",
    "IMU-CONSISTENCY",
    "IMU-NOISE",
    "AZ-TORQUE-CONSTANT",
    "EL-TORQUE-CONSTANT",
    "AZ-COARSE-LATENCY",
    "EL-COARSE-LATENCY",
    "FINE-LATENCY",
    "OPTICAL-GAIN",
    "AZ-COGGING",
    "EL-COGGING",
];

/// What the command line asks for.
struct Call {
    asked: Asked,
    units: u32,
    first: u32,
    /// The unit whose file is to be printed.
    print: Option<u32>,
    save: Option<PathBuf>,
    /// Files of shards.
    load: Vec<String>,
    keep: Option<PathBuf>,
    only: Option<String>,
}

impl Call {
    fn read(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let asked = Asked {
            program: PathBuf::new(),
            campaign: "quick".to_owned(),
            select: Vec::new(),
            units: Units::Drawn,
        };
        let mut call = Self {
            asked,
            units: 60,
            first: 1,
            print: None,
            save: None,
            load: Vec::new(),
            keep: None,
            only: None,
        };
        while let Some(word) = words.next() {
            let mut next = || words.next().ok_or(format!("a value is missing behind {word}"));
            let number = |text: String| text.parse().map_err(|_| format!("{word} {text}: expected a number"));
            match word.as_str() {
                "--units" => call.units = number(next()?)?,
                "--first" => call.first = number(next()?)?,
                "--print" => call.print = Some(number(next()?)?),
                "--in-service" => call.asked.units = Units::InService,
                "--on-limits" => call.asked.units = Units::OnLimits,
                "--unit" => call.asked.units = Units::Shipped(next()?),
                "--keep" => call.keep = Some(next()?.into()),
                "--again" | "--score" => call.only = Some(word),
                "--save" => call.save = Some(next()?.into()),
                "--load" => call.load.push(next()?),
                "--campaign" => call.asked.campaign = next()?,
                "--verifying" => call.asked.select = VERIFYING.map(str::to_owned).into(),
                "--program" => {
                    // Each run has a working folder of its own.
                    let path = next()?;
                    call.asked.program =
                        std::path::absolute(&path).map_err(|error| format!("--program {path}: {error}"))?;
                }
                other if other.starts_with('-') => return Err(format!("there is no option {other}")),
                _ => call.asked.select.push(word),
            }
        }
        Ok(call)
    }
}

pub(crate) fn study() -> ExitCode {
    let mut call = match Call::read(crate::arguments()) {
        Ok(call) => call,
        Err(mistake) => {
            eprintln!(
                "error: {mistake}; the head of tests/validation/src/studies/blind.rs lists all options"
            );
            return ExitCode::from(2);
        }
    };
    if let Some(number) = call.print {
        let id = format!("unit-{number}");
        let in_service = call.asked.units == Units::InService;
        print!("{}", if in_service { draw::unit_in_service(&id, number) } else { draw::unit(&id, number) });
        return ExitCode::SUCCESS;
    }
    if !call.load.is_empty() {
        return report(&call.load.iter().flat_map(|path| load(path)).collect::<Vec<_>>());
    }
    if call.asked.units == Units::OnLimits && call.asked.select.is_empty() {
        call.asked.select = on_limits::PROCEDURES.map(str::to_owned).into();
    }
    if call.asked.program.as_os_str().is_empty() {
        call.asked.program = built();
    }
    let numbers: Vec<u32> = (call.first..call.first + call.units).collect();
    let all: Vec<Unit> = numbers.par_iter().map(|number| one(&call, *number)).collect();
    if let Some(path) = call.save {
        let text = serde_json::to_string(&all).expect("plain numbers");
        std::fs::write(&path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    if call.asked.units == Units::OnLimits { report_on_limits(&all) } else { report(&all) }
}

fn one(call: &Call, number: u32) -> Unit {
    let folder = call.keep.as_ref().map(|keep| keep.join(format!("unit-{number}")));
    match (folder, call.only.as_deref()) {
        (None, _) => measured(&call.asked, number),
        (Some(folder), None) => measured_in(&call.asked, number, &folder),
        (Some(folder), Some("--score")) => scored_again(number, &folder),
        (Some(folder), Some(_)) => judged_again(&call.asked.program, number, &folder),
    }
}

/// Level of the test of passes over all limits.
const LEVEL: f64 = 0.05;

fn report_on_limits(all: &[Unit]) -> ExitCode {
    let scored: Vec<Scored> = all.iter().flat_map(|unit| unit.scored.clone()).collect();
    let rows = on_limits::rows(&scored);
    print!("{}", on_limits::table(&rows));
    let guarded: Vec<&on_limits::Row> = rows.iter().filter(|row| row.promised < LEVEL).collect();
    let [findings, passes] = [|row: &on_limits::Row| row.findings, |row: &on_limits::Row| row.passes]
        .map(|count| guarded.iter().map(|row| count(row)).sum::<u64>());
    println!("\nguarded: {passes} of {findings} pass");
    let is_wrong = rows.iter().any(|row| row.p < LEVEL / rows.len() as f64);
    if is_wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Whether an interlock ended a point of a unit of which no requirement fails.
fn trips_in_health(unit: &Unit) -> bool {
    unit.failed.is_empty() && unit.troubles.iter().any(|trouble| trouble.contains(": tripped: "))
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
    let mut scored: Vec<Scored> = all.iter().flat_map(|unit| unit.scored.clone()).collect();
    let lines = score::lines(&scored);
    print!("{}", score::table(&lines));
    let counts = score::counts(&scored);
    println!("\n| counted | n | equal to the truth |\n| --- | ---: | ---: |");
    counts.iter().for_each(|(name, count)| println!("| {name} | {} | {} |", count.findings, count.equal));
    scored.retain(|one| one.u > 0.0);
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
    for one in passes.iter().chain(&fails) {
        println!("- {}; its truth is {:.2} U outside the limit", one.text(), one.outside_in_u);
    }
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
    let is_wrong = share < LEAST_POOLED
        || counts.values().any(|count| count.equal < count.findings)
        || lines.iter().any(|line| line.is_wrong)
        || passes.iter().any(|one| one.outside_in_u > 1.0)
        || passes.len() > most_passes
        || fails.len() > most_fails
        || all.iter().any(trips_in_health);
    if is_wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
