//! `bench import`: a log that another tool recorded.

use std::path::PathBuf;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::procedure::Procedure;

use super::{folders, output};
use crate::exit;
use crate::files::import_map::read_map;
use crate::files::shipped::{self, Folder};
use crate::import::map::ImportMap;
use crate::import::{ImportError, import};
use crate::record::durable;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Import map (TOML)
    map: PathBuf,
    /// Folder for the log
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn run(args: &Args) -> u8 {
    let map = match shipped::read(&args.map).and_then(read_map) {
        Ok(map) => map,
        Err(found) => return output::mistakes(&found),
    };
    if let Err(code) = folders::must_be_free(&args.out) {
        return code;
    }
    if let Err(error) = std::fs::create_dir_all(&args.out) {
        output::error(&format!("--out {}: {error}; {}", args.out.display(), durable::OUTPUT_HELP));
        return exit::BENCH;
    }
    let found = beside(&map);
    let written = found
        .map_err(ImportError::Mistakes)
        .and_then(|(procedure, requirements)| import(&map, &procedure, &requirements, &args.out));
    match written {
        Ok(path) => {
            output::say(&path.display().to_string());
            output::note(&format!("judge it with `bench rejudge {}`", path.display()));
            exit::PASS
        }
        Err(ImportError::Mistakes(found)) => output::mistakes(&found),
        Err(ImportError::Output(error)) => {
            output::error(&format!("{error}; {}", durable::OUTPUT_HELP));
            exit::BENCH
        }
    }
}

/// The procedure that judges the log and the requirements that travel with it, as the map names them.
fn beside(map: &ImportMap) -> Result<(Procedure, SourceFile), Vec<Diagnostic>> {
    let find = |folder, name: &str| shipped::find(folder, name, Some(&map.source.name));
    let procedure = Procedure::parse(find(Folder::Procedures, &map.procedure)?)?;
    Ok((procedure, find(Folder::Requirements, &map.requirements)?))
}
