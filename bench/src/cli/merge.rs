//! `bench merge`: the shards of a comparison to the whole.

use std::path::{Path, PathBuf};

use procedures::regression::{ArmRecord, Criteria, Look, ShardFile, merge};

use super::folders;
use super::output;
use super::regress::{FOLDERS, decided, finish, kept};
use crate::exit;
use crate::regression::{Records, store};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Folders that `bench regress --shard` wrote
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// Folder for the comparison; `regressions/<next number>` if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Accept shards of different programs or processors, whose numbers may differ in their last digits
    #[arg(long)]
    tolerant: bool,
    /// Print the comparison as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> u8 {
    merged(args).unwrap_or_else(|code| code)
}

fn merged(args: &Args) -> Result<u8, u8> {
    let criteria = criteria(&args.shards)?;
    let found = Records { baseline: arm(args, store::BASELINE)?, candidate: arm(args, store::CANDIDATE)? };
    let regression = decided(&criteria, &found, Look::Single)?;
    let folder = folders::chosen(args.out.as_deref(), FOLDERS)?;
    kept(store::write_records(&folder, &found, &criteria))?;
    finish(&folder, &regression, args.json)
}

/// The criteria, which must be the same in all shards.
fn criteria(shards: &[PathBuf]) -> Result<Criteria, u8> {
    let read = |folder: &PathBuf| store::read_criteria(folder).map_err(|message| output::mistake(&message));
    let mut found: Option<(&Path, Criteria)> = None;
    for folder in shards {
        let own = read(folder)?;
        match &found {
            Some((first, criteria)) if *criteria != own => {
                return Err(output::mistake(&format!(
                    "{}: the criteria differ from those of {}; run all shards with one criteria file",
                    folder.display(),
                    first.display()
                )));
            }
            Some(_) => {}
            None => found = Some((folder, own)),
        }
    }
    found.map(|(_, criteria)| criteria).ok_or(exit::USAGE)
}

fn arm(args: &Args, file: &str) -> Result<ArmRecord, u8> {
    let mut shards = Vec::new();
    for folder in &args.shards {
        let record = store::read_any_arm(&folder.join(file)).map_err(|message| output::mistake(&message))?;
        shards.push(ShardFile { name: folder.display().to_string(), record });
    }
    merge(&shards, args.tolerant).map_err(|errors| {
        errors.iter().for_each(|error| output::error(&error.to_string()));
        exit::USAGE
    })
}
