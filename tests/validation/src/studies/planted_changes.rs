//! How often a comparison of controllers calls planted changes rightly.
//!
//! For each change a pilot of eight units tells the scatter of the shifts; the number of units is the one that calls the
//! effect of the model rightly with a probability of 0.999, if the scatter is at its upper bound of 90 %. Then the comparison is
//! repeated on fresh units.
//!
//! `cargo run --release -p validation -- planted_changes [--repetitions N] [--keep FOLDER] [--figure FILE] [CHANGE …]`: with
//! `--repetitions 0` only the effects by the model are printed; with
//! `--keep` the records of runs stay there, and a study that was broken off goes on from them; remove them when the program changes.
//! `--figure` draws the probability of the right call against the number of units (SVG).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use analysis::paired::{Plan, PlannedCall, scatter_at_most};
use procedures::regression::{ArmRecord, Call, Look};
use procedures::trace::{Plot, Scale, Series, Style};
use reports::plot::{Figure, svg};
use validation::planted::{Bed, Planted, append, groups, outcome};

const PILOT_UNITS: u32 = 8;
const POWER: f64 = 0.999;
/// First number of the units of repetitions; the pilot has those before.
const FIRST: u32 = 10_001;
/// Fewest units of a comparison.
const FEWEST: u64 = 4;
/// Units whose records are kept together.
const AT_ONCE: u32 = 20;
/// Numbers of units in the figure.
const SHOWN: std::ops::RangeInclusive<usize> = 2..=12;

struct Options {
    repetitions: u32,
    keep: Option<PathBuf>,
    figure: Option<PathBuf>,
    only: Vec<String>,
}

fn options(mut words: impl Iterator<Item = String>) -> Result<Options, String> {
    let mut options = Options { repetitions: 100, keep: None, figure: None, only: Vec::new() };
    while let Some(word) = words.next() {
        let mut next = || words.next().ok_or(format!("a value is missing behind {word}"));
        match word.as_str() {
            "--repetitions" => {
                let text = next()?;
                options.repetitions =
                    text.parse().map_err(|_| format!("{word} {text}: expected a number"))?;
            }
            "--keep" => options.keep = Some(next()?.into()),
            "--figure" => options.figure = Some(next()?.into()),
            other if other.starts_with('-') => return Err(format!("there is no option {other}")),
            _ => options.only.push(word),
        }
    }
    Ok(options)
}

pub(crate) fn study() -> ExitCode {
    let options = match options(crate::arguments()) {
        Ok(options) => options,
        Err(mistake) => {
            eprintln!(
                "error: {mistake}; the head of tests/validation/src/studies/planted_changes.rs lists all"
            );
            return ExitCode::from(2);
        }
    };
    println!(
        "| change | measurand | effect by the model | margin | expected | scatter at most | units | planned | right | blocks | mean shift |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut figure = power_figure();
    let asked = |group: &&[Planted]| {
        options.only.is_empty() || options.only.iter().any(|only| group[0].name.contains(only.as_str()))
    };
    let mut is_good = true;
    for group in groups().filter(asked) {
        is_good &= rows(group, &options, &mut figure);
    }
    if let Some(path) = &options.figure {
        let text = svg(&Figure::of(&figure), "power");
        std::fs::write(path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Units of a comparison, and the probability of the right call.
struct Comparison {
    scatter: f64,
    units: u32,
    probability: f64,
}

impl Comparison {
    fn planned(planted: &Planted, pilot: &[ArmRecord; 2]) -> Self {
        let found = outcome(planted, pilot, 0, PILOT_UNITS as usize);
        let scatter = found.scatter.unwrap_or(0.0);
        let scatter = scatter_at_most(scatter, f64::from(PILOT_UNITS - 1), 0.9).unwrap_or(0.0);
        if scatter == 0.0 {
            return Self { scatter, units: FEWEST as u32, probability: 1.0 };
        }
        let plan = plan(planted, planted.effect(), scatter);
        let pairs = plan.pairs(POWER).expect("a test of this crate says that effects are on their side");
        let pairs = pairs.max(FEWEST);
        let units = u32::try_from(pairs).expect("an effect well above or below its margin");
        Self { scatter, units, probability: plan.probability(pairs) }
    }
}

fn plan(planted: &Planted, effect: f64, scatter: f64) -> Plan {
    let call = match planted.expected {
        Call::Worse | Call::Better => PlannedCall::Worse,
        _ => PlannedCall::Equivalent,
    };
    Plan { call, effect: effect.abs(), margin: planted.margin, scatter, level: Look::Single.level() }
}

/// The rows of the changes that the same runs tell; whether all calls were right often enough.
fn rows(group: &[Planted], options: &Options, figure: &mut Plot) -> bool {
    if options.repetitions == 0 {
        for planted in group {
            let [effect, margin] = [planted.effect(), planted.margin].map(|si| planted.kind.format(si));
            println!(
                "| {} | {} | {effect} | {margin} | {:?} |",
                planted.name, planted.measurand, planted.expected
            );
        }
        return true;
    }
    let pilot = run(&group[0], options, 1, PILOT_UNITS);
    let planned: Vec<Comparison> = group.iter().map(|planted| Comparison::planned(planted, &pilot)).collect();
    let most = planned.iter().map(|comparison| comparison.units).max().unwrap_or(0);
    eprintln!("{}: {most} units for each repetition", group[0].name);
    let arms = run(&group[0], options, FIRST, most * options.repetitions);
    let mut is_good = true;
    for (planted, comparison) in group.iter().zip(&planned) {
        is_good &= row(planted, comparison, options.repetitions, &arms);
        show_power(planted, &arms, figure);
    }
    is_good
}

fn row(planted: &Planted, comparison: &Comparison, repetitions: u32, arms: &[ArmRecord; 2]) -> bool {
    let units = comparison.units as usize;
    let found = calls(planted, arms, units, repetitions as usize);
    let right = found.iter().filter(|(call, _)| *call == planted.expected).count();
    let blocks = found.iter().filter(|(_, blocks)| *blocks).count();
    let mean = outcome(planted, arms, 0, arms[0].replicates.len()).shift.unwrap_or(f64::NAN);
    let show = |si: f64| planted.kind.format(si);
    println!(
        "| {} | {} | {} | {} | {:?} | {} | {units} | {:.4} | {right} of {repetitions} | {blocks} | {} |",
        planted.name,
        planted.measurand,
        show(planted.effect()),
        show(planted.margin),
        planted.expected,
        show(comparison.scatter),
        comparison.probability,
        show(mean)
    );
    100 * right >= 99 * repetitions as usize
}

/// Call and block of each of so many comparisons of so many units.
fn calls(planted: &Planted, arms: &[ArmRecord; 2], units: usize, most: usize) -> Vec<(Call, bool)> {
    let count = (arms[0].replicates.len() / units).min(most);
    let one = |k: usize| {
        let found = outcome(planted, arms, k * units, units);
        (found.call, found.blocks)
    };
    (0..count).map(one).collect()
}

/// Records of units from a number on, a part at a time.
fn run(planted: &Planted, options: &Options, first: u32, units: u32) -> [ArmRecord; 2] {
    let parts = (0..units).step_by(AT_ONCE as usize);
    let mut parts = parts.map(|done| run_part(planted, options, first + done, AT_ONCE.min(units - done)));
    let mut all = parts.next().expect("at least one unit");
    parts.for_each(|part| append(&mut all, part));
    all
}

fn run_part(planted: &Planted, options: &Options, first: u32, units: u32) -> [ArmRecord; 2] {
    let words: Vec<&str> =
        planted.name.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
    let name = format!("{}-{first}-{units}.json", words.join("-"));
    let kept = options.keep.as_ref().map(|keep| keep.join(name));
    if let Some(arms) = kept.as_deref().and_then(load) {
        return arms;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let bed = Bed::new(planted, folder.path(), first, units).expect("files without a mistake");
    let arms = bed.run(planted, folder.path(), jobs());
    if let Some(path) = &kept {
        // A part that was not written to its end has another name.
        let unfinished = path.with_extension("part");
        let text = serde_json::to_string(&arms).expect("plain numbers");
        std::fs::write(&unfinished, text)
            .and_then(|()| std::fs::rename(&unfinished, path))
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    arms
}

fn load(path: &Path) -> Option<[ArmRecord; 2]> {
    let text = std::fs::read_to_string(path).ok()?;
    Some(serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

fn jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn power_figure() -> Plot {
    Plot::new(
        "power",
        "Right calls against number of units",
        Scale::linear("Units", ""),
        Scale::linear("Right calls", "%"),
    )
}

/// The share of right calls among comparisons of few and of many units, and the one of the plan with the mean and scatter of all units.
fn show_power(planted: &Planted, arms: &[ArmRecord; 2], figure: &mut Plot) {
    let all = outcome(planted, arms, 0, arms[0].replicates.len());
    let (Some(mean), Some(scatter)) = (all.shift, all.scatter.filter(|scatter| *scatter > 0.0)) else {
        return;
    };
    let plan = plan(planted, mean, scatter);
    let mut shares = BTreeMap::new();
    for units in SHOWN.filter(|units| arms[0].replicates.len() >= *units) {
        let found = calls(planted, arms, units, usize::MAX);
        let right = found.iter().filter(|(call, _)| *call == planted.expected).count();
        shares.insert(
            units,
            [100.0 * right as f64 / found.len() as f64, 100.0 * plan.probability(units as u64)],
        );
    }
    let label = format!("{}: {} ({:?})", planted.name, planted.measurand, planted.expected);
    let x: Vec<f64> = shares.keys().map(|units| *units as f64).collect();
    let column = |k: usize| shares.values().map(|share| share[k]).collect::<Vec<f64>>();
    figure.series.push(Series::new(format!("{label} (plan)"), Style::Line, x.clone(), column(1)));
    figure.series.push(Series::new(label, Style::Markers, x, column(0)));
}
