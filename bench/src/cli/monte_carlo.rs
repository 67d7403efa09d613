//! `bench monte-carlo`: what stored runs of drawn units say of their family.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use procedures::diagnostic::SourceFile;
use procedures::population::{Draws, MeasuredUnit, Reading, evaluate};
use reports::population::{PopulationReport, Title};
use reports::record::{EvidenceState, Findings};

use super::{folders, output, results};
use crate::exit;
use crate::files::family::LEAST_RANDOMISATIONS;
use crate::files::unit::{DrawnFrom, Method, read_drawn};
use crate::record::durable;
use crate::record::evidence;
use crate::record::page::Page;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folders, one for each unit that `bench draw` wrote
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Folder for `population.md` and `population.json`
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// A run of a drawn unit.
struct DrawnRun {
    folder: PathBuf,
    from: DrawnFrom,
    campaign: String,
    /// What must be the same in all runs: digests of campaign and requirements.
    judged_by: [Option<String>; 2],
    unit: MeasuredUnit,
}

pub(super) fn run(args: &Args) -> u8 {
    match monte_carlo(args) {
        Ok(code) | Err(code) => code,
    }
}

fn monte_carlo(args: &Args) -> Result<u8, u8> {
    let mut code = exit::PASS;
    let mut runs = Vec::with_capacity(args.runs.len());
    for folder in &args.runs {
        let evidence = evidence::check(folder);
        // Of a thousand runs only those that were altered are told.
        if evidence.state == EvidenceState::Altered {
            code = exit::worse(code, results::tell(folder, &evidence));
        }
        runs.push(read(folder)?);
    }
    runs.sort_by_key(|run| run.from.number);
    check(&runs)?;
    let report = report(runs)?;
    if let Some(folder) = &args.out {
        write(folder, &report)?;
    }
    if args.json {
        output::say(reports::population::json(&report).trim_end());
    } else {
        output::say(&reports::population::text(&report));
    }
    Ok(code)
}

/// A run with the unit file that it kept.
fn read(folder: &Path) -> Result<DrawnRun, u8> {
    let findings = results::read_with_waivers(folder)?.findings;
    let page = Page::read(folder).map_err(|message| {
        output::error(&message);
        results::unusable(folder)
    })?;
    let help = "units of a population are written by `bench draw`";
    let Some(file) = page.unit_files.first() else {
        return Err(output::mistake(&format!("{}: the run kept no unit file; {help}", folder.display())));
    };
    let source = SourceFile::new(format!("{}: {}", folder.display(), file.name), file.text.clone());
    let drawn = read_drawn(source).map_err(|mistakes| output::mistakes(&mistakes))?;
    let Some(drawn) = drawn else {
        let message =
            format!("{}: unit `{}` was not drawn from a family; {help}", folder.display(), findings.unit);
        return Err(output::mistake(&message));
    };
    let set = drawn.from.randomisation() as usize;
    let readings = readings(&findings);
    Ok(DrawnRun {
        folder: folder.to_owned(),
        campaign: findings.campaign.id,
        judged_by: [findings.campaign.sha256, findings.campaign.requirements_sha256],
        unit: MeasuredUnit { id: drawn.id, set, settings_si: drawn.values_si, readings },
        from: drawn.from,
    })
}

/// The deciding measurement of each requirement and measurand.
fn readings(findings: &Findings) -> Vec<Reading> {
    let mut readings = Vec::new();
    for outcome in &findings.outcomes {
        for one in &outcome.by_measurand {
            let Some((_, measurement, judgement)) = findings.deciding(&one.decided_by) else { continue };
            readings.push(Reading {
                requirement: outcome.requirement.clone(),
                measurand: one
                    .band
                    .as_ref()
                    .map_or_else(|| one.measurand.clone(), |band| format!("{} ({band})", one.measurand)),
                kind: measurement.kind,
                value_si: measurement.value,
                verdict: judgement.verdict,
            });
        }
    }
    readings
}

/// Runs of one population through one campaign, each unit once.
fn check(runs: &[DrawnRun]) -> Result<(), u8> {
    let Some(first) = runs.first() else { return Err(output::mistake("no run")) };
    for run in runs {
        let population = |from: &DrawnFrom| DrawnFrom { number: 1, ..from.clone() };
        let [a, b] = [&first.folder, &run.folder].map(|folder| folder.display());
        if population(&run.from) != population(&first.from) {
            return Err(output::mistake(&format!(
                "{a} and {b}: units `{}` and `{}` are not of one population: family, method, seed and number of units must be the \
                 same",
                first.unit.id, run.unit.id
            )));
        }
        if run.judged_by != first.judged_by {
            return Err(output::mistake(&format!(
                "{a} and {b}: the campaigns or their requirements differ; run all units through one campaign, or judge again with \
                 `bench rejudge --requirements F --out DIR`"
            )));
        }
    }
    for pair in runs.windows(2) {
        if pair[0].from.number == pair[1].from.number {
            let [a, b] = [&pair[0].folder, &pair[1].folder].map(|folder| folder.display());
            let message =
                format!("{a} and {b}: unit `{}` is given twice; give one run of each unit", pair[0].unit.id);
            return Err(output::mistake(&message));
        }
    }
    Ok(())
}

/// The report of checked runs. Of a design only whole randomisations count.
fn report(runs: Vec<DrawnRun>) -> Result<PopulationReport, u8> {
    let Some(DrawnRun { from, campaign, .. }) = runs.first() else { return Err(output::mistake("no run")) };
    let title = Title {
        family: from.family.clone(),
        family_sha256: from.family_sha256.clone(),
        method: from.method.name().to_owned(),
        seed: from.seed,
        campaign: campaign.clone(),
    };
    let given: BTreeSet<u32> = runs.iter().map(|run| run.from.number).collect();
    let last = from.units.or(given.last().copied()).unwrap_or(0);
    let missing: Vec<u32> = (1..=last).filter(|number| !given.contains(number)).collect();
    let design = Some(from.clone()).filter(|from| from.method != Method::Independent);
    let mut units: Vec<MeasuredUnit> = runs.into_iter().map(|run| run.unit).collect();
    let draws = match design {
        None => Draws::Independent,
        Some(from) => whole_sets(&from, &missing, &mut units)?,
    };
    let rows = evaluate(&units, draws);
    Ok(PopulationReport::new(title, units.len(), missing, draws, rows))
}

/// Leaves out randomisations of which a unit is missing, and numbers the others from 0 on.
fn whole_sets(from: &DrawnFrom, missing: &[u32], units: &mut Vec<MeasuredUnit>) -> Result<Draws, u8> {
    let set_of = |number: u32| DrawnFrom { number, ..from.clone() }.randomisation() as usize;
    let broken: BTreeSet<usize> = missing.iter().map(|&number| set_of(number)).collect();
    units.retain(|unit| !broken.contains(&unit.set));
    let whole: BTreeSet<usize> = units.iter().map(|unit| unit.set).collect();
    if whole.len() < LEAST_RANDOMISATIONS as usize {
        let lacking: Vec<String> = missing.iter().take(10).map(u32::to_string).collect();
        return Err(output::mistake(&format!(
            "{} whole randomisations; expected at least {LEAST_RANDOMISATIONS}: run the missing units, the first of them {}",
            whole.len(),
            lacking.join(", ")
        )));
    }
    for unit in units {
        unit.set = whole.range(..unit.set).count();
    }
    Ok(Draws::Randomised { sets: whole.len() })
}

fn write(folder: &Path, report: &PopulationReport) -> Result<(), u8> {
    folders::make(folder)?;
    let markdown = reports::population::markdown(report);
    let data = reports::population::json(report);
    let write = |name: &str, text: &str| durable::write(&folder.join(name), text.as_bytes());
    write("population.md", &markdown)
        .and_then(|()| write("population.json", &data))
        .map_err(|error| folders::unwritable(folder, &error))
}
