//! `bench import`: a log that another tool recorded.

use std::path::PathBuf;

use super::output;
use crate::exit;
use crate::files::import_map::ImportMap;
use crate::files::shipped;
use crate::import::{ImportError, import};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Import map (TOML)
    map: PathBuf,
    /// Folder for the log
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn run(args: &Args) -> u8 {
    let map = match shipped::read(&args.map).and_then(ImportMap::parse) {
        Ok(map) => map,
        Err(found) => return output::mistakes(&found),
    };
    if std::fs::read_dir(&args.out).is_ok_and(|mut inside| inside.next().is_some()) {
        output::error(&format!("--out {}: the folder is not empty; choose a new one", args.out.display()));
        return exit::USAGE;
    }
    if let Err(error) = std::fs::create_dir_all(&args.out) {
        output::error(&format!("--out {}: {error}; {}", args.out.display(), crate::campaign::OUTPUT_HELP));
        return exit::BENCH;
    }
    match import(&map, &args.out) {
        Ok(path) => {
            output::say(&path.display().to_string());
            output::note(&format!("judge it with `bench rejudge {}`", path.display()));
            exit::PASS
        }
        Err(ImportError::Mistakes(found)) => output::mistakes(&found),
        Err(ImportError::Output(error)) => {
            output::error(&format!("{error}; {}", crate::campaign::OUTPUT_HELP));
            exit::BENCH
        }
    }
}
