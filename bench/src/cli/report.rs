//! `bench report`: the report of a run in other formats.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use reports::record::{EvidenceRecord, EvidenceState, Results, WaiverRecord};

use super::output;
use crate::durable;
use crate::evidence;
use crate::exit;
use crate::files::{bounded, shipped, waivers};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folder
    run: PathBuf,
    /// Formats, separated by commas
    #[arg(long, value_name = "LIST", default_value = "html", value_delimiter = ',')]
    format: Vec<String>,
    /// Where to write; the run folder if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Waivers of this unit: a file with `[[waiver]]`; with `--format html,json` they are kept for later reports too
    #[arg(long, value_name = "F")]
    waivers: Option<PathBuf>,
}

/// Reads the results of a run folder.
fn read(run: &Path) -> Result<Results, u8> {
    let path = run.join("results.json");
    let text = bounded::read_to_string(&path, bounded::MOST_RECORD_BYTES).map_err(|e| {
        let help = if run.join(crate::page::FILE).exists() {
            format!(
                "the run did not come to its end; judge what it left with `bench rejudge {} --out DIR`",
                run.display()
            )
        } else {
            "is this a run folder?".to_owned()
        };
        output::error(&format!("{}: cannot be read: {e}; {help}", path.display()));
        exit::USAGE
    })?;
    serde_json::from_str(&text).map_err(|e| {
        output::error(&format!("{}: not results of this program: {e}", path.display()));
        unusable(run)
    })
}

/// Exit code for a folder of which a file cannot be used: it was altered, or it is none of a run.
pub(super) fn unusable(run: &Path) -> u8 {
    match tell(run, &evidence::check(run)) {
        exit::DAMAGED => exit::DAMAGED,
        _ => exit::USAGE,
    }
}

/// The results with the waivers of this file in the place of those that they had.
fn with_waivers(mut results: Results, file: Option<&Path>) -> Result<Results, u8> {
    let Some(file) = file else { return Ok(results) };
    let ids: Vec<&str> = results.findings.requirements.iter().map(|r| r.id.as_str()).collect();
    let read = shipped::read(file).and_then(|source| waivers::read(&source, &ids));
    results.record.waivers = read.map_err(|found| output::mistakes(&found))?;
    Ok(results)
}

/// Waivers of a run, kept beside its results: those are evidence and stay as the run wrote them.
const WAIVERS: &str = "waivers.json";

/// The waivers that an earlier report kept in a run folder.
fn kept_waivers(run: &Path) -> Result<Option<Vec<WaiverRecord>>, u8> {
    let path = run.join(WAIVERS);
    let refused = |error: &dyn std::fmt::Display| {
        let help = "give the waivers again with --waivers F --format json";
        output::error(&format!("{}: {error}; {help}", path.display()));
        exit::USAGE
    };
    match std::fs::read_to_string(&path) {
        Ok(text) => serde_json::from_str(&text).map(Some).map_err(|error| refused(&error)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(refused(&error)),
    }
}

/// Results of a run folder with the waivers that were kept since.
pub(super) fn read_with_waivers(run: &Path) -> Result<Results, u8> {
    let mut results = read(run)?;
    if let Some(waivers) = kept_waivers(run)? {
        results.record.waivers = waivers;
    }
    Ok(results)
}

/// Tells how a run folder stands, and what that means for the exit code.
pub(super) fn tell(run: &Path, found: &EvidenceRecord) -> u8 {
    let line = format!("{}: evidence {}", run.display(), found.sentence());
    if found.state == EvidenceState::Altered {
        output::error(&line);
        return exit::DAMAGED;
    }
    output::note(&line);
    exit::PASS
}

pub(super) fn run(args: &Args) -> u8 {
    write(args).unwrap_or_else(|code| code)
}

fn write(args: &Args) -> Result<u8, u8> {
    let results = with_waivers(read_with_waivers(&args.run)?, args.waivers.as_deref())?;
    let results = results.with_evidence(evidence::check(&args.run));
    let known: Vec<&str> = reports::FORMATS.iter().map(|f| f.name).collect();
    if let Some(unknown) = args.format.iter().find(|name| reports::format(name).is_none()) {
        output::error(&format!("--format {unknown}: expected one of {}", known.join(", ")));
        return Err(exit::USAGE);
    }
    for format in args.format.iter().filter_map(|name| reports::format(name)) {
        write_one(args, format, &results)?;
    }
    Ok(results.evidence.as_ref().map_or(exit::PASS, |found| tell(&args.run, found)))
}

/// Writes one format. In the run folder the place of the results is taken: their waivers are kept beside them.
fn write_one(args: &Args, format: &reports::Format, results: &Results) -> Result<(), u8> {
    let folder = args.out.as_deref().unwrap_or(&args.run);
    let beside = format.file == evidence::RESULTS && same_folder(folder, &args.run);
    if beside && args.waivers.is_none() {
        let path = folder.join(format.file);
        output::note(&format!("{}: stays as the run wrote it; --out DIR writes another", path.display()));
        return Ok(());
    }
    let (name, text) = if beside {
        // A list of plain texts is always JSON.
        (WAIVERS, serde_json::to_string_pretty(&results.record.waivers).unwrap_or_default() + "\n")
    } else {
        (format.file, (format.render)(results))
    };
    let path = folder.join(name);
    let written = std::fs::create_dir_all(folder).and_then(|()| durable::write(&path, text.as_bytes()));
    written.map_err(|error| {
        output::error(&format!("{}: {error}; {}", path.display(), crate::campaign::OUTPUT_HELP));
        exit::BENCH
    })?;
    output::say(&path.display().to_string());
    Ok(())
}

/// Whether two paths lead to one folder.
fn same_folder(a: &Path, b: &Path) -> bool {
    match (std::fs::canonicalize(a), std::fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
