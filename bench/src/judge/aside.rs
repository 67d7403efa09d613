//! The judge in a process of its own, while axes are held: its memory is not locked, it gives way to everything else, and the
//! kernel ends it before the loop where memory runs out.

use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use super::attempt::{Tried, Trouble, unjudged};
use super::{Known, judge_log, try_log};
use crate::clock;
use crate::realtime::privileges;
use crate::record::page::{Page, PlannedLog};

/// The hidden verb of the program that [`judge_aside`] calls; a run folder and the index of a procedure follow.
pub const VERB: &str = "judge-aside";
/// Of two processes the kernel ends the one with the higher figure first, −1000 … 1000.
const ENDED_FIRST: &str = "500";

/// Lets a process of its own judge the log of a planned procedure, by what the run folder says of it. `seed` is that of the run.
///
/// A signal that the terminal sends to the run does not reach it.
pub fn judge_aside(program: &Path, folder: &Path, index: usize, planned: &PlannedLog, seed: u64) -> Tried {
    let mut command = Command::new(program);
    command.arg(VERB).arg(folder).arg(index.to_string());
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).process_group(0);
    let lost = match command.output().map(|output| (read(&output), output)) {
        Ok((Ok(tried), _)) => return tried,
        Ok((Err(unread), output)) => format!("{}{}", ended(&output), unread),
        Err(error) => format!("could not be started: {error}"),
    };
    let reason = format!("the process that judges {lost}; `bench rejudge` judges the log again");
    Tried { log: unjudged(planned, seed, reason.clone()), trouble: Some(Trouble::Panicked(reason)) }
}

fn read(output: &Output) -> Result<Tried, String> {
    serde_json::from_slice(&output.stdout).map_err(|error| match output.status.success() {
        true => format!(", and what it wrote cannot be read: {error}"),
        false => String::new(),
    })
}

fn ended(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().last().map(|line| format!(" after it said: {line}")).unwrap_or_default();
    match (output.status.signal(), output.status.code()) {
        (Some(signal), _) => format!("was ended by signal {signal}{last}"),
        (None, code) => format!("ended with exit code {}{last}", code.unwrap_or_default()),
    }
}

/// What that process does: judges and gives what it found as JSON.
///
/// # Errors
/// Why there is nothing to judge.
pub fn serve(folder: &Path, index: usize) -> Result<String, String> {
    privileges::give_up();
    clock::give_way();
    // Where that is refused, memory runs out for whoever takes most.
    let _ = std::fs::write("/proc/self/oom_score_adj", ENDED_FIRST);
    let page = Page::read(folder)?;
    let planned = page
        .procedures
        .get(index)
        .ok_or_else(|| format!("{}: no procedure {index} in its title page", folder.display()))?;
    let requirements = procedures::requirement::Requirements::parse(&page.requirements.source())
        .map_err(|mistakes| mistakes.iter().map(|m| m.message.as_str()).collect::<Vec<_>>().join("; "))?;
    let path = folder.join(&planned.log);
    let tried = try_log(judge_log, &path, planned, &requirements, &Known::default(), page.seed);
    serde_json::to_string(&tried).map_err(|error| error.to_string())
}
