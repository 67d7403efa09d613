//! `bench host-controller`: steps an external law for the process that runs the axes.
//!
//! Its standard input is the shared memory, its standard output a pipe to that process.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use external_law::shared::Mapping;
use external_law::{Instance, Library};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::clock;
use crate::cycle::laws::READY;
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
}

pub(super) fn run(args: &Args) -> u8 {
    let ready = |made: &Result<(Mapping, Instance), String>| {
        let word = made.as_ref().map_or_else(|why| why.as_str(), |_| READY);
        let mut output = std::io::stdout();
        writeln!(output, "{word}").and_then(|()| output.flush())
    };
    // The code of others gets none of the rights that the program may have been given.
    privileges::give_up();
    clock::give_way_a_little();
    let made = make(&args.file, &args.sha256);
    match (ready(&made), made) {
        (Ok(()), Ok((rows, law))) => {
            serve(&rows, law);
            exit::PASS
        }
        _ => exit::BENCH,
    }
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
