//! A law in a process of its own, stepped through shared memory.

use std::ffi::OsStr;
use std::io::Read as _;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::Path;
use std::process::{Child as Process, Command, Stdio};
use std::time::Duration;

use external_law::Description;
use external_law::rows::{LawInput, LawOutput, LawSetup};
use external_law::shared::Mapping;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::thread::sched_yield;

use super::Law;
use crate::clock::Stopwatch;
use crate::cycle::velocity_loop::LawFault;

/// In virtual time the process is looked at this often while it does not answer.
const LOOKED_AT_EVERY: Duration = Duration::from_millis(20);
/// Longest time for loading a library and making a law.
const MADE_WITHIN: Duration = Duration::from_secs(10);
/// Longest answer of a process that makes or describes a law.
const MOST_BYTES: usize = 1 << 20;

/// What the process says once its law can be stepped.
pub(crate) const READY: &str = "ready";

/// A description as the process of a law writes it.
pub(crate) fn describe(description: &Description) -> String {
    serde_json::to_string(description).expect("texts and numbers")
}

/// What a library says of itself, read in a process of its own.
pub(super) fn description(program: &Path, file: &Path, sha256: &str) -> Result<Description, String> {
    let arguments = ["--describe".as_ref(), file.as_os_str(), sha256.as_ref()];
    let mut process = spawned(program, &arguments, Stdio::null(), file)?;
    let said = line(&mut process, file, "described");
    ended(&mut process);
    let said = said?;
    serde_json::from_str(&said).map_err(|_| said)
}

/// Starts `bench host-controller`.
fn spawned(program: &Path, arguments: &[&OsStr], input: Stdio, file: &Path) -> Result<Process, String> {
    Command::new(program)
        .arg("host-controller")
        .args(arguments)
        .stdin(input)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        // Signals of the terminal are for the bench, which stops the axis with or without the law.
        .process_group(0)
        .spawn()
        .map_err(|error| format!("{}: cannot start its process: {error}", file.display()))
}

/// The line that the process of a law says, within [`MADE_WITHIN`].
fn line(process: &mut Process, file: &Path, done: &str) -> Result<String, String> {
    let Some(output) = &mut process.stdout else { return Err("no standard output".to_owned()) };
    let watch = Stopwatch::start();
    let mut said = Vec::new();
    while !said.contains(&b'\n') && said.len() < MOST_BYTES {
        let left_s = MADE_WITHIN.as_secs_f64() - watch.elapsed_s();
        if left_s <= 0.0 {
            let within_s = MADE_WITHIN.as_secs();
            return Err(format!(
                "{}: its process has not {done} the law within {within_s} s",
                file.display()
            ));
        }
        let left = Timespec { tv_sec: left_s as i64, tv_nsec: (left_s.fract() * 1e9) as i64 };
        let is_ready = poll(&mut [PollFd::new(&*output, PollFlags::IN)], Some(&left)).is_ok_and(|n| n > 0);
        let mut bytes = [0; 4096];
        match is_ready.then(|| output.read(&mut bytes)) {
            // An interrupted wait is begun again.
            None => {}
            Some(Ok(0) | Err(_)) => break,
            Some(Ok(count)) => said.extend_from_slice(&bytes[..count]),
        }
    }
    let said = String::from_utf8_lossy(&said).trim().to_owned();
    if said.is_empty() {
        return Err(format!("{}: its process ended before it had {done} the law", file.display()));
    }
    Ok(said)
}

fn ended(process: &mut Process) {
    // It holds nothing that would have to be put in order.
    let _ = process.kill();
    let _ = process.wait();
}

/// The process of a law.
#[derive(Debug)]
pub(in crate::cycle) struct Child {
    process: Process,
    rows: Mapping,
    deadline: Option<Duration>,
    /// How long the answers of this tick were waited for so far, s.
    waited_s: f64,
}

impl Child {
    /// Starts `bench host-controller` and waits until it has made the law.
    pub(super) fn start(
        program: &Path,
        law: &Law,
        setup: &LawSetup,
        values_si: &[f64],
        deadline: Option<Duration>,
        ticks_on: Option<usize>,
    ) -> Result<Self, String> {
        let (rows, memory) = Mapping::create(setup, values_si)
            .map_err(|error| format!("no memory to share with its process: {error}"))?;
        let file = Path::new(&law.file);
        let mut arguments = vec![file.as_os_str(), law.sha256.as_ref()];
        let ticks_on = ticks_on.map(|processor| format!("--keep-off={processor}"));
        arguments.extend(deadline.map(|_| OsStr::new("--real-time")));
        arguments.extend(ticks_on.as_ref().map(OsStr::new));
        let process = spawned(program, &arguments, Stdio::from(memory), file)?;
        let mut child = Self { process, rows, deadline, waited_s: 0.0 };
        match line(&mut child.process, file, "made")?.as_str() {
            READY => Ok(child),
            why => Err(why.to_owned()),
        }
    }

    /// The next answer has the whole deadline again.
    pub(super) fn end_tick(&mut self) {
        self.waited_s = 0.0;
    }

    pub(super) fn step(&mut self, input: &LawInput) -> Result<LawOutput, LawFault> {
        self.rows.ask(input);
        match self.deadline {
            None => self.wait(),
            Some(deadline) => self.wait_for(deadline),
        }
    }

    /// Real time: looks again and again, so that no answer in time is seen too late. It gives way where both processes must
    /// share a processor; a thread with a real-time priority keeps its own.
    fn wait_for(&mut self, deadline: Duration) -> Result<LawOutput, LawFault> {
        let watch = Stopwatch::start();
        loop {
            // First of all: an answer that lies there after a pause of this thread is too late as well.
            let after_s = self.waited_s + watch.elapsed_s();
            if after_s > deadline.as_secs_f64() {
                let limit_us = 1e6 * deadline.as_secs_f64();
                return Err(self.fault().unwrap_or(LawFault::Late { after_us: 1e6 * after_s, limit_us }));
            }
            if let Some(output) = self.rows.answer() {
                self.waited_s = after_s;
                return Ok(output);
            }
            sched_yield();
        }
    }

    /// Virtual time waits for as long as the process lives.
    fn wait(&mut self) -> Result<LawOutput, LawFault> {
        loop {
            if let Some(output) = self.rows.answer() {
                return Ok(output);
            }
            self.rows.sleep_until_answered(LOOKED_AT_EVERY);
            if self.rows.answer().is_none()
                && let Some(fault) = self.fault()
            {
                return Err(fault);
            }
        }
    }

    fn fault(&mut self) -> Option<LawFault> {
        let status = self.process.try_wait().ok()??;
        let code = status.code().or(status.signal().map(|signal| -signal));
        Some(LawFault::Ended { code: code.unwrap_or_default() })
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        ended(&mut self.process);
    }
}
