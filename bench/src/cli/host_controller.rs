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
use rustix::thread::sched_yield;

use crate::clock::{self, Stopwatch};
use crate::cycle::laws::{READY, describe};
use crate::exit;
use crate::realtime::{keep_off, privileges};

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
    /// Never sleep, because the time for an answer is real and short
    #[arg(long)]
    real_time: bool,
    /// Keep off this processor, which the thread that runs the axes has for itself
    #[arg(long)]
    keep_off: Option<usize>,
}

pub(super) fn run(args: &Args) -> u8 {
    // The code of others gets none of the rights that the program may have been given, and does not outlive it.
    privileges::give_up();
    // A system that refuses leaves a law that ends when it next looks for its bench.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    clock::give_way_a_little();
    args.keep_off.iter().copied().for_each(keep_off);
    if args.describe {
        let described = Library::load(&args.file, &args.sha256);
        let said = described.map_or_else(|why| why.to_string(), |library| describe(library.description()));
        return if say(&said) { exit::PASS } else { exit::BENCH };
    }
    match make(&args.file, &args.sha256) {
        Ok((rows, law)) if say(READY) => {
            serve(&rows, law, args.real_time);
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

/// Steps the law once for each request, until nobody is there to ask. Where time is real it never sleeps: the first request after
/// a pause has the same deadline as all others, and waking up can take longer than that.
fn serve(rows: &Mapping, mut law: Instance, is_real_time: bool) {
    let mut answered = 0;
    let mut looked = Stopwatch::start();
    loop {
        if let Some((number, input)) = rows.request(answered) {
            rows.reply(number, &law.step(&input));
            answered = number;
        } else if is_real_time {
            // Laws of two axes may have to share a processor.
            sched_yield();
        } else if rows.sleep_until_asked(answered, LOOKED_AT_EVERY) {
            continue;
        }
        if looked.elapsed_s() >= LOOKED_AT_EVERY.as_secs_f64() {
            if is_alone() {
                return;
            }
            looked = Stopwatch::start();
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
