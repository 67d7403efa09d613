//! A law in a process of its own, stepped through shared memory.

use std::io::{BufRead as _, BufReader};
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::Path;
use std::process::{Child as Process, Command, Stdio};
use std::time::Duration;

use external_law::Library;
use external_law::rows::{LawInput, LawOutput, LawSetup};
use external_law::shared::Mapping;
use rustix::thread::sched_yield;

use crate::clock::Stopwatch;
use crate::cycle::velocity_loop::LawFault;

/// In virtual time the process is looked at this often while it does not answer.
const LOOKED_AT_EVERY: Duration = Duration::from_millis(20);

/// What the process says once its law can be stepped.
pub(crate) const READY: &str = "ready";

/// The process of a law.
#[derive(Debug)]
pub(in crate::cycle) struct Child {
    process: Process,
    rows: Mapping,
    deadline: Option<Duration>,
}

impl Child {
    /// Starts `bench host-controller` and waits until it has made the law.
    pub(super) fn start(
        program: &Path,
        library: &Library,
        setup: &LawSetup,
        values_si: &[f64],
        deadline: Option<Duration>,
    ) -> Result<Self, String> {
        let (rows, memory) = Mapping::create(setup, values_si)
            .map_err(|error| format!("no memory to share with its process: {error}"))?;
        let spawned = Command::new(program)
            .args(["host-controller", library.file(), library.sha256()])
            .stdin(Stdio::from(memory))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            // Signals of the terminal are for the bench, which stops the axis with or without the law.
            .process_group(0)
            .spawn();
        let process =
            spawned.map_err(|error| format!("{}: cannot start its process: {error}", library.file()))?;
        let mut child = Self { process, rows, deadline };
        child.wait_until_ready(library)?;
        Ok(child)
    }

    fn wait_until_ready(&mut self, library: &Library) -> Result<(), String> {
        let mut said = String::new();
        if let Some(output) = &mut self.process.stdout {
            // An unreadable answer is one that is not `ready`.
            let _ = BufReader::new(output).read_line(&mut said);
        }
        match said.trim() {
            READY => Ok(()),
            "" => Err(format!("{}: its process ended before the law was made", library.file())),
            why => Err(why.to_owned()),
        }
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
            let after_s = watch.elapsed_s();
            if after_s > deadline.as_secs_f64() {
                let limit_us = 1e6 * deadline.as_secs_f64();
                return Err(self.ended().unwrap_or(LawFault::Late { after_us: 1e6 * after_s, limit_us }));
            }
            if let Some(output) = self.rows.answer() {
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
                && let Some(fault) = self.ended()
            {
                return Err(fault);
            }
        }
    }

    fn ended(&mut self) -> Option<LawFault> {
        let status = self.process.try_wait().ok()??;
        let code = status.code().or(status.signal().map(|signal| -signal));
        Some(LawFault::Ended { code: code.unwrap_or_default() })
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // It holds nothing that would have to be put in order.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
