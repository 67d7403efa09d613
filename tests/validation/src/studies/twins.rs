//! Twins of drawn units: what `bench identify` finds beside what was drawn, and the runs of unit and twin beside each other.
//!
//! `cargo run --release -p validation -- twins [--units N] [--first K] [--program BENCH] [--keep FOLDER] [--save FILE]
//! [--load FILE …] [--once] [ID …]`: N units (10) from number K (901) go through campaign `quick`, or through what the ids select of
//! it; with `--once` the twins are not run. `--save` and `--load` divide the units between calls.
//!
//! At least 93 % of the settings that were determined must be within U of what was drawn, every verdict must be the same whose
//! margin exceeds 3 U, and 90 % of the points of measured curves must lie within the uncertainty of their difference.

use std::path::PathBuf;
use std::process::ExitCode;

use validation::blind::{Asked, Units};
use validation::program::built;
use validation::twins::{Setting, Twin, twin};

/// Least share of determined settings within U, in percent.
const LEAST_COVERED: f64 = 93.0;
/// Least share of points of curves within the band of their difference, in percent.
const LEAST_INSIDE: f64 = 90.0;

struct Call {
    asked: Asked,
    units: u32,
    first: u32,
    keep: Option<PathBuf>,
    save: Option<PathBuf>,
    load: Vec<PathBuf>,
    once: bool,
}

fn call(mut words: impl Iterator<Item = String>) -> Result<Call, String> {
    let asked = Asked {
        program: PathBuf::new(),
        campaign: "quick".to_owned(),
        select: Vec::new(),
        units: Units::Drawn,
    };
    let mut call =
        Call { asked, units: 10, first: 901, keep: None, save: None, load: Vec::new(), once: false };
    while let Some(word) = words.next() {
        let mut next = || words.next().ok_or(format!("a value is missing behind {word}"));
        let number = |text: String| text.parse().map_err(|_| format!("{word} {text}: expected a number"));
        let path =
            |text: String| std::path::absolute(&text).map_err(|error| format!("{word} {text}: {error}"));
        match word.as_str() {
            "--units" => call.units = number(next()?)?,
            "--first" => call.first = number(next()?)?,
            "--program" => call.asked.program = path(next()?)?,
            "--keep" => call.keep = Some(path(next()?)?),
            "--save" => call.save = Some(path(next()?)?),
            "--load" => call.load.push(path(next()?)?),
            "--once" => call.once = true,
            other if other.starts_with('-') => return Err(format!("there is no option {other}")),
            _ => call.asked.select.push(word),
        }
    }
    Ok(call)
}

pub(crate) fn study() -> ExitCode {
    let mut call = match call(crate::arguments()) {
        Ok(call) => call,
        Err(mistake) => {
            eprintln!(
                "error: {mistake}; the head of tests/validation/src/studies/twins.rs lists all options"
            );
            return ExitCode::from(2);
        }
    };
    if !call.load.is_empty() {
        return report(&call.load.iter().flat_map(load).collect::<Vec<_>>());
    }
    if call.asked.program.as_os_str().is_empty() {
        call.asked.program = built();
    }
    let all: Vec<Twin> = (call.first..call.first + call.units).map(|number| one(&call, number)).collect();
    if let Some(path) = &call.save {
        let text = serde_json::to_string(&all).expect("plain numbers");
        std::fs::write(path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    report(&all)
}

fn one(call: &Call, number: u32) -> Twin {
    match &call.keep {
        Some(keep) => twin(&call.asked, number, &keep.join(format!("unit-{number}")), !call.once),
        None => {
            let folder = tempfile::tempdir().expect("a folder for runs");
            twin(&call.asked, number, folder.path(), !call.once)
        }
    }
}

fn load(path: &PathBuf) -> Vec<Twin> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

fn report(all: &[Twin]) -> ExitCode {
    let covered = report_settings(all);
    let verdicts: Vec<_> = all.iter().flat_map(|twin| twin.verdicts.iter().map(move |v| (twin, v))).collect();
    let differ: Vec<_> = verdicts.iter().filter(|(_, v)| v.verdicts[0] != v.verdicts[1]).collect();
    println!("\n{} verdicts with a clear margin, {} differ:", verdicts.len(), differ.len());
    for (twin, v) in &differ {
        let [unit, twins] = &v.verdicts;
        println!(
            "- unit {} {}: {unit}, twin {twins}, margin {:.1} U",
            twin.number, v.requirement, v.margin_in_u
        );
    }
    let curves: Vec<_> = all.iter().flat_map(|twin| twin.curves.iter().map(move |c| (twin, c))).collect();
    let points: usize = curves.iter().map(|(_, c)| c.points).sum();
    let inside: usize = curves.iter().map(|(_, c)| c.inside).sum();
    println!(
        "\n{} curves, {points} points, {:.1} % inside; below 90 %:",
        curves.len(),
        percent(inside, points)
    );
    for (twin, c) in curves.iter().filter(|(_, c)| percent(c.inside, c.points) < LEAST_INSIDE) {
        println!("- unit {} {}: {} of {} points inside", twin.number, c.name, c.inside, c.points);
    }
    println!("\nSaid:");
    all.iter().for_each(|twin| twin.said.iter().for_each(|line| println!("- unit {}: {line}", twin.number)));
    let good = covered >= LEAST_COVERED && differ.is_empty();
    let good = good && (points == 0 || percent(inside, points) >= LEAST_INSIDE);
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// A row for each setting; the share of determined settings within U, in percent.
fn report_settings(all: &[Twin]) -> f64 {
    let mut keys: Vec<&str> = Vec::new();
    for setting in all.iter().flat_map(|twin| &twin.settings) {
        if !keys.contains(&setting.key.as_str()) {
            keys.push(&setting.key);
        }
    }
    println!(
        "| setting | n | within U | mean, U | largest, U | |\n| --- | ---: | ---: | ---: | ---: | --- |"
    );
    for key in keys {
        let own: Vec<&Setting> =
            all.iter().flat_map(|twin| &twin.settings).filter(|setting| setting.key == key).collect();
        let covered = own.iter().filter(|setting| setting.is_covered()).count();
        let mean = own.iter().map(|setting| setting.error_in_u()).sum::<f64>() / own.len() as f64;
        let largest = own.iter().map(|setting| setting.error_in_u().abs()).fold(0.0, f64::max);
        let in_part = own.iter().filter(|setting| !setting.is_measured).count();
        let words = if in_part > 0 { format!("{in_part} in part") } else { String::new() };
        println!("| {key} | {} | {covered} | {mean:+.2} | {largest:.1} | {words} |", own.len());
    }
    let determined: Vec<&Setting> =
        all.iter().flat_map(|twin| &twin.settings).filter(|setting| setting.is_measured).collect();
    let covered = determined.iter().filter(|setting| setting.is_covered()).count();
    let share = percent(covered, determined.len());
    println!(
        "\n{} units, {} determined settings, {share:.1} % within U; outside:",
        all.len(),
        determined.len()
    );
    for twin in all {
        for s in twin.settings.iter().filter(|s| s.is_measured && !s.is_covered()) {
            let [value, u, truth] = [s.value, s.expanded_u, s.truth];
            println!(
                "- unit {} {}: {value:.6e} ± {u:.1e}, drawn {truth:.6e}: {:+.1} U",
                twin.number,
                s.key,
                s.error_in_u()
            );
        }
    }
    share
}
