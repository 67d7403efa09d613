//! `bench report`: the report of a run in other formats.

use std::path::{Path, PathBuf};

use reports::record::Results;

use super::output;
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
    /// Waivers of this unit: a file with `[[waiver]]`; with `--format html,json` they come into the results too
    #[arg(long, value_name = "F")]
    waivers: Option<PathBuf>,
}

/// Reads the results of a run folder.
pub(super) fn read(run: &Path) -> Result<Results, u8> {
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
        exit::USAGE
    })
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
    let results = match read(&args.run).and_then(|results| with_waivers(results, args.waivers.as_deref())) {
        Ok(results) => results,
        Err(code) => return code,
    };
    let known: Vec<&str> = reports::FORMATS.iter().map(|f| f.name).collect();
    let folder = args.out.as_deref().unwrap_or(&args.run);
    if let Some(unknown) = args.format.iter().find(|name| reports::format(name).is_none()) {
        output::error(&format!("--format {unknown}: expected one of {}", known.join(", ")));
        return exit::USAGE;
    }
    for format in args.format.iter().filter_map(|name| reports::format(name)) {
        let path = folder.join(format.file);
        let written =
            std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, (format.render)(&results)));
        if let Err(error) = written {
            output::error(&format!("{}: {error}; {}", path.display(), crate::campaign::OUTPUT_HELP));
            return exit::BENCH;
        }
        output::say(&path.display().to_string());
    }
    exit::PASS
}
