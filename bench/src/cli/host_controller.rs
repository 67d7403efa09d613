//! `bench host-controller`: steps an external law for the process that runs the axes.
//!
//! Its standard input is the shared memory, its standard output a pipe to that process.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use external_law::shared::Mapping;
use external_law::{Instance, Library};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Signal, set_parent_process_death_signal};

use crate::clock;
use crate::cycle::laws::{READY, describe};
use crate::exit;
use crate::realtime::privileges;

/// So often it looks whether the process that runs the axes still lives.
const LOOKED_AT_EVERY: Duration = Duration::from_millis(500);

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Shared library
    file: PathBuf,
    /// Its SHA-256
    sha256: String,
    /// Say what the library says of itself, and step nothing
    #[arg(long)]
    describe: bool,
}

pub(super) fn run(args: &Args) -> u8 {
    // The code of others gets none of the rights that the program may have been given, and does not outlive it.
    privileges::give_up();
    // A system that refuses leaves a law that ends when it next looks for its bench.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    clock::give_way_a_little();
    if args.describe {
        let described = Library::load(&args.file, &args.sha256);
        let said = described.map_or_else(|why| why.to_string(), |library| describe(library.description()));
        return if say(&said) { exit::PASS } else { exit::BENCH };
    }
    match make(&args.file, &args.sha256) {
        Ok((rows, law)) if say(READY) => {
            serve(&rows, law);
            exit::PASS
        }
        Ok(_) => exit::BENCH,
        Err(why) => {
            say(&why);
            exit::BENCH
        }
    }
}

/// Says a line to the process that runs the axes; whether it could.
fn say(line: &str) -> bool {
    let mut output = std::io::stdout();
    writeln!(output, "{line}").and_then(|()| output.flush()).is_ok()
}

fn make(file: &Path, sha256: &str) -> Result<(Mapping, Instance), String> {
    let rows = Mapping::of(&std::io::stdin()).map_err(|error| format!("standard input: {error}"))?;
    let library = Library::load(file, sha256).map_err(|error| error.to_string())?;
    let (setup, values_si) = rows.setup();
    let law = library.create(&setup, &values_si).map_err(|error| error.to_string())?;
    Ok((rows, law))
}

/// Steps the law once for each request, until nobody is there to ask.
fn serve(rows: &Mapping, mut law: Instance) {
    let mut answered = 0;
    loop {
        match rows.next(answered, LOOKED_AT_EVERY) {
            Some((number, input)) => {
                rows.reply(number, &law.step(&input));
                answered = number;
            }
            None if is_alone() => return,
            None => {}
        }
    }
}

/// Whether nobody reads the standard output any more.
fn is_alone() -> bool {
    let output = std::io::stdout();
    let mut fds = [PollFd::new(&output, PollFlags::empty())];
    let now = Timespec { tv_sec: 0, tv_nsec: 0 };
    let polled = poll(&mut fds, Some(&now));
    polled.is_ok() && fds[0].revents().intersects(PollFlags::ERR | PollFlags::HUP)
}
