//! `bench judge-aside`: judges one log for the process that holds the axes.

use std::path::PathBuf;

use super::output;
use crate::exit;
use crate::judge;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folder
    folder: PathBuf,
    /// Index of the procedure in its title page
    index: usize,
}

pub(super) fn run(args: &Args) -> u8 {
    match judge::serve_aside(&args.folder, args.index) {
        Ok(found) => {
            output::say(&found);
            exit::PASS
        }
        Err(why) => {
            output::error(&why);
            exit::BENCH
        }
    }
}
