//! The program under test as a process of its own, within limits.

use std::io::Read;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Processor time that a file may cost, s.
const MOST_CPU_S: f64 = 5.0;
/// Time that a call may take on a machine that is busy with others.
const MOST_LOOKS: u32 = 3000;
/// What is kept of stdout, bytes.
const MOST_OUT_BYTES: u64 = 4096;
/// Time between two looks at it.
const LOOK: Duration = Duration::from_millis(20);
/// Memory beside eight times the input.
const MEMORY_BYTES: u64 = 256 << 20;
const MEMORY_FACTOR: u64 = 8;

/// What a call came to.
#[derive(Clone, Debug, Default)]
pub(super) struct Said {
    /// Exit code; `None` where a signal or this watch ended it.
    pub code: Option<i32>,
    /// Largest resident memory that was seen, bytes.
    pub memory_bytes: u64,
    /// Processor time, s.
    pub cpu_s: f64,
    /// The beginning of what it said on stdout.
    pub out: String,
    /// The end of what it said on stderr.
    pub err: String,
    /// What it must not do, if it did.
    pub finding: Option<String>,
}

/// Runs the program in `folder`; `input_bytes` is the size of what it reads.
pub(super) fn call(program: &Path, folder: &Path, arguments: &[String], input_bytes: u64) -> Said {
    let most_bytes = MEMORY_FACTOR * input_bytes + MEMORY_BYTES;
    let mut child = Command::new("prlimit")
        .arg(format!("--data={most_bytes}"))
        .arg("--core=0")
        .arg(program)
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program under test starts, under prlimit of util-linux");
    let (done, ended) = channel();
    let mut stdout = child.stdout.take().expect("stdout is a pipe");
    let mut stderr = child.stderr.take().expect("stderr is a pipe");
    let out = std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = stdout.by_ref().take(MOST_OUT_BYTES).read_to_end(&mut text);
        let _ = std::io::copy(&mut stdout, &mut std::io::sink());
        text
    });
    let err = std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = stderr.read_to_end(&mut text);
        let _ = done.send(());
        text
    });
    let mut said = Said::default();
    let mut late = true;
    for _ in 0..MOST_LOOKS {
        let over = ended.recv_timeout(LOOK);
        look(child.id(), &mut said);
        late = said.cpu_s > MOST_CPU_S;
        if late || !matches!(over, Err(RecvTimeoutError::Timeout)) {
            break;
        }
        late = true;
    }
    if late {
        let _ = child.kill();
        said.finding = Some(format!("it hangs: {:.1} s of processor time", said.cpu_s));
    }
    let status = child.wait().expect("a child that was started can be waited for");
    said.out = String::from_utf8_lossy(&out.join().unwrap_or_default()).into_owned();
    let text = err.join().unwrap_or_default();
    said.err = String::from_utf8_lossy(&text[text.len().saturating_sub(2000)..]).into_owned();
    if !late {
        said.finding = broken(status, &said.err, most_bytes);
        said.code = status.code();
    }
    said
}

/// What an exit status says that no input may bring about.
fn broken(status: ExitStatus, err: &str, most_bytes: u64) -> Option<String> {
    let last = err.lines().find(|l| l.contains("panicked")).or(err.lines().last()).unwrap_or_default();
    match status.code() {
        Some(70 | 101) => Some(format!("it panics: {last}")),
        Some(_) if err.contains("panicked at") => Some(format!("a part of it panics: {last}")),
        Some(_) => None,
        None if err.contains("memory allocation") => Some(format!("more than {most_bytes} bytes: {last}")),
        None => Some(format!("it is killed ({status}): {last}")),
    }
}

/// Memory and processor time so far.
fn look(pid: u32, said: &mut Said) {
    let read = |name: &str| std::fs::read_to_string(format!("/proc/{pid}/{name}")).unwrap_or_default();
    let status = read("status");
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = peak.and_then(|text| text.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    said.memory_bytes = said.memory_bytes.max(kib.unwrap_or(0) << 10);
    let stat = read("stat");
    let ticks = stat.rsplit_once(')').map(|(_, rest)| rest.split_whitespace().skip(11).take(2));
    let ticks: f64 = ticks.into_iter().flatten().filter_map(|t| t.parse::<f64>().ok()).sum();
    // `USER_HZ` is 100 on every architecture that Rust and Linux share.
    said.cpu_s = said.cpu_s.max(ticks / 100.0);
}
