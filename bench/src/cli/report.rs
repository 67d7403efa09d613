//! `bench report`: the report of a run in other formats.

use std::path::{Path, PathBuf};

use procedures::diagnostic::nearest;
use reports::record::Results;

use super::output;
use super::results::{WAIVERS, read_with_waivers, tell};
use crate::exit;
use crate::files::{shipped, waivers};
use crate::record::durable;
use crate::record::evidence;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folder
    run: PathBuf,
    /// Formats, separated by commas: html, json, junit, csv, requirements-csv, md
    #[arg(long, value_name = "LIST", default_value = "html", value_delimiter = ',')]
    format: Vec<String>,
    /// Output folder; the run folder if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// File with waivers for this unit (`[[waiver]]`); with `--format html,json` they are also kept for later reports
    #[arg(long, value_name = "F")]
    waivers: Option<PathBuf>,
}

/// The results with the waivers of this file in the place of those that they had.
fn with_waivers(mut results: Results, file: Option<&Path>) -> Result<Results, u8> {
    let Some(file) = file else { return Ok(results) };
    let ids: Vec<&str> = results.findings.requirements.iter().map(|r| r.id.as_str()).collect();
    let read = shipped::read(file).and_then(|source| waivers::read(&source, &ids));
    results.record.waivers = read.map_err(|found| output::mistakes(&found))?;
    Ok(results)
}

pub(super) fn run(args: &Args) -> u8 {
    write(args).unwrap_or_else(|code| code)
}

fn write(args: &Args) -> Result<u8, u8> {
    let results = with_waivers(read_with_waivers(&args.run)?, args.waivers.as_deref())?;
    let results = results.with_evidence(evidence::check(&args.run));
    let known: Vec<&str> = reports::FORMATS.iter().map(|f| f.name).collect();
    if let Some(unknown) = args.format.iter().find(|name| reports::format(name).is_none()) {
        // Too far from its short name for the nearest word.
        let near = if unknown == "markdown" { Some("md") } else { nearest(unknown, known.iter().copied()) };
        let help = near.map_or(String::new(), |name| format!("; did you mean `{name}`?"));
        output::error(&format!("--format {unknown}: expected one of {}{help}", known.join(", ")));
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
        output::note(&format!(
            "{}: kept as the run wrote it; use --out DIR to write another",
            path.display()
        ));
        return Ok(());
    }
    let (name, content) = if beside {
        // A list of plain texts is always JSON.
        let waivers = serde_json::to_string_pretty(&results.record.waivers).unwrap_or_default();
        (WAIVERS, (waivers + "\n").into_bytes())
    } else {
        (format.file, (format.render)(results))
    };
    let path = folder.join(name);
    let written = std::fs::create_dir_all(folder).and_then(|()| durable::write(&path, &content));
    written.map_err(|error| {
        output::error(&format!("{}: {error}; {}", path.display(), durable::OUTPUT_HELP));
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
