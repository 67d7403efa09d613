//! What a run keeps: its folder, results, reports, and the last lines on the terminal.

use std::path::{Path, PathBuf};

use reports::record::Results;

use super::output;
use crate::campaign::RunResult;
use crate::cli::{folders, record};
use crate::clock::Stopwatch;
use crate::exit;
use crate::judge::{Fold, fold};
use crate::plan::CampaignPlan;
use crate::record::durable::{self, OUTPUT_HELP};
use crate::record::evidence;
use crate::record::journal::{Entry, Journal, sha256};

/// The run folder, made and empty.
pub(super) fn folder(wanted: Option<&Path>) -> Result<PathBuf, u8> {
    if let Some(folder) = wanted.filter(|folder| folder.to_str().is_none()) {
        let shown = folder.display();
        output::error(&format!(
            "--out {shown}: the path is not UTF-8, which journal and locks require; choose another folder"
        ));
        return Err(exit::USAGE);
    }
    let Some(folder) = wanted else { return folders::next_number(Path::new("runs")) };
    if folder.exists() {
        let mut inside = std::fs::read_dir(folder).map_err(|error| folders::unwritable(folder, &error))?;
        if inside.next().is_some() {
            output::error(&format!(
                "--out {}: the folder is not empty; a run never overwrites another, choose a new folder",
                folder.display()
            ));
            return Err(exit::USAGE);
        }
    }
    std::fs::create_dir_all(folder).map_err(|error| folders::unwritable(folder, &error))?;
    Ok(folder.to_owned())
}

/// Findings and record of a run.
pub(super) fn results(result: &RunResult, plan: &CampaignPlan, folder: &Path, watch: &Stopwatch) -> Results {
    let page = &result.page;
    let by = Fold {
        page,
        requirements: &plan.requirements,
        requirements_text: &plan.requirements_source.text,
        folder,
    };
    let findings = fold(&by, &result.judged);
    Results::new(findings, record::of_run(result, folder, watch))
}

/// Writes the results and puts them on record in the journal: from then on they stay as they are.
pub(super) fn results_file(results: &Results, folder: &Path, journal: &mut Journal) -> Result<(), String> {
    let path = folder.join(evidence::RESULTS);
    let failed = |error: std::io::Error| format!("{}: {error}; {OUTPUT_HELP}", path.display());
    let text = reports::json::render(results);
    durable::write(&path, text.as_bytes()).map_err(failed)?;
    let sha256 = sha256(text.as_bytes());
    let size_bytes = text.len() as u64;
    journal.write(Entry::Kept { file: evidence::RESULTS.to_owned(), sha256, size_bytes }).map_err(failed)
}

/// Writes every document into the run folder; what does not fit leaves no half file behind.
///
/// The first failure is given after all formats were tried: on a full disk the small ones may still fit.
pub(super) fn documents(results: &Results, folder: &Path) -> Result<(), String> {
    let mut outcome = Ok(());
    for format in reports::FORMATS.iter().filter(|format| format.file != evidence::RESULTS) {
        let path = folder.join(format.file);
        if let Err(error) = durable::write(&path, &(format.render)(results)) {
            outcome = outcome.and(Err(format!("{}: {error}; {OUTPUT_HELP}", path.display())));
        }
    }
    outcome
}

/// Why somebody must look at the rig, if anybody must, and what to do then.
pub(super) fn warning(must_look: &[String], locked: bool, folder: &Path) -> Option<String> {
    if must_look.is_empty() {
        return None;
    }
    let mut lines: Vec<String> = must_look.iter().map(|why| format!("  inspect the rig: {why}")).collect();
    if locked {
        lines.push(format!("  the rig stays locked until `bench inspect {}`", folder.display()));
    }
    Some(lines.join("\n"))
}
