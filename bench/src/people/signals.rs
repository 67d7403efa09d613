//! Signals: what each of them does to a run, in one table, [`SIGNALS`].
//!
//! No handler runs: all threads of a run block what the table names, and one thread waits for it. That thread sets a
//! flag, at which the loop looks in every tick, and hands sentences to the console, which takes them without waiting.
//!
//! Two sorts are left to the drives' own watchdogs (process data and SM2: 20 ms, then the quick stop): SIGKILL and
//! SIGSTOP, which the system lets nobody block, and those by which the processor or the program itself says that it
//! cannot go on (SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGSYS, SIGTRAP, SIGABRT). SIGPIPE is ignored: a reader that went away
//! shows in the result of a write. SIGCHLD, SIGCONT, SIGURG and SIGWINCH do nothing by themselves.

use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};

use nix::sys::signal::{SigSet, Signal};

use crate::cycle::run::{STOP_AT_ONCE, STOP_CODE};
use crate::exit;

/// What a signal does to a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Does {
    /// Orders a controlled stop; a second SIGINT orders the quick stop. The program ends with this code.
    Stops(u8),
    /// Orders the quick stop at once.
    StopsAtOnce(u8),
    /// Nothing, and the operator is told why.
    HeldOff,
    /// Nothing.
    Nothing,
}

/// A signal and what it does.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The signal.
    pub signal: Signal,
    /// What it does.
    pub does: Does,
    /// Where it comes from, and why it does that.
    pub why: &'static str,
}

const fn row(signal: Signal, does: Does, why: &'static str) -> Row {
    Row { signal, does, why }
}

/// Every signal that is blocked and waited for. Real-time signals are blocked too and do nothing.
pub const SIGNALS: &[Row] = &[
    row(Signal::SIGINT, Does::Stops(exit::SIGINT), "Ctrl-C; a second one orders a quick stop"),
    row(
        Signal::SIGTERM,
        Does::Stops(exit::SIGTERM),
        "request to end the program, from a person or the system",
    ),
    row(Signal::SIGHUP, Does::Stops(exit::SIGHUP), "the terminal was closed"),
    row(Signal::SIGQUIT, Does::StopsAtOnce(exit::SIGQUIT), "Ctrl-\\"),
    row(Signal::SIGXCPU, Does::Stops(exit::SIGXCPU), "limit of processor time reached; SIGKILL follows"),
    row(Signal::SIGTSTP, Does::HeldOff, "Ctrl-Z: a suspended program cannot stop an axis"),
    row(Signal::SIGTTIN, Does::Nothing, "read from the background: it fails, so a prompt gets no answer"),
    row(
        Signal::SIGTTOU,
        Does::Nothing,
        "write from the background: the output of the run is shown nevertheless",
    ),
    row(
        Signal::SIGXFSZ,
        Does::Nothing,
        "limit of file size reached: the write fails, and that stops the run (exit 4)",
    ),
    row(Signal::SIGUSR1, Does::Nothing, "no effect on a run"),
    row(Signal::SIGUSR2, Does::Nothing, "no effect on a run"),
    row(Signal::SIGALRM, Does::Nothing, "no effect on a run"),
    row(Signal::SIGVTALRM, Does::Nothing, "no effect on a run"),
    row(Signal::SIGPROF, Does::Nothing, "no effect on a run"),
    row(Signal::SIGIO, Does::Nothing, "no effect on a run"),
    row(Signal::SIGSTKFLT, Does::Nothing, "no effect on a run"),
    row(Signal::SIGPWR, Does::Nothing, "no effect on a run"),
];

/// What must reach the program, or does nothing anyway.
const NOT_BLOCKED: [Signal; 12] = [
    Signal::SIGSEGV,
    Signal::SIGBUS,
    Signal::SIGILL,
    Signal::SIGFPE,
    Signal::SIGSYS,
    Signal::SIGTRAP,
    Signal::SIGABRT,
    Signal::SIGPIPE,
    Signal::SIGCHLD,
    Signal::SIGCONT,
    Signal::SIGURG,
    Signal::SIGWINCH,
];

/// Why Ctrl-Z does nothing.
const HELD_OFF: &str = "Ctrl-Z is ignored during a run, because a suspended program cannot stop an axis; \
                        press Ctrl-C to stop the run";

/// Bit of the flag that says that the run has begun: before it, a signal ends the program.
const BEGUN: u16 = 0x0200;

/// Blocks the signals of [`SIGNALS`] and takes them from now on; gives the flag that they set. `say` must not wait.
/// To be called before the program starts any other thread: each inherits what is blocked.
///
/// # Errors
/// When the operating system refuses the mask or the thread.
pub fn listen(say: fn(&str)) -> std::io::Result<Arc<AtomicU16>> {
    let mut blocked = SigSet::all();
    NOT_BLOCKED.iter().for_each(|&signal| blocked.remove(signal));
    blocked.thread_block()?;
    let awaited: SigSet = SIGNALS.iter().map(|row| row.signal).collect();
    let stop = Arc::new(AtomicU16::new(0));
    let told = Arc::clone(&stop);
    // A thread that sleeps until a signal comes; it ends with the process.
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        loop {
            // Nothing but an interruption by a debugger makes it fail.
            let Ok(signal) = awaited.wait() else { continue };
            match SIGNALS.iter().find(|row| row.signal == signal).map(|row| row.does) {
                Some(Does::HeldOff) => say(HELD_OFF),
                Some(does) => match take(&told, does) {
                    Taken::Ends(code) => std::process::exit(i32::from(code)),
                    Taken::Ordered(sentence) => say(sentence),
                    Taken::Nothing => {}
                },
                None => {}
            }
        }
    })?;
    Ok(stop)
}

/// What came of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    /// No run has begun: the program ends with this code.
    Ends(u8),
    /// The run stops, and this is said of it.
    Ordered(&'static str),
    /// Nothing that was not ordered before.
    Nothing,
}

const CONTROLLED: &str = "controlled stop in progress; press Ctrl-C again for a quick stop";
const QUICK: &str = "quick stop ordered: the drives stop as fast as they can";

/// What a signal sets, and what comes of it.
fn take(stop: &AtomicU16, does: Does) -> Taken {
    let (code, at_once) = match does {
        Does::Stops(code) => (code, false),
        Does::StopsAtOnce(code) => (code, true),
        Does::HeldOff | Does::Nothing => return Taken::Nothing,
    };
    let is_first = set_code(stop, code);
    let is_quick = at_once || (!is_first && code == exit::SIGINT);
    let before = if is_quick { stop.fetch_or(STOP_AT_ONCE, Ordering::Relaxed) } else { 0 };
    if stop.load(Ordering::Relaxed) & BEGUN == 0 {
        return Taken::Ends(code);
    }
    match (is_quick, is_first) {
        (true, _) if before & STOP_AT_ONCE == 0 => Taken::Ordered(QUICK),
        (false, true) => Taken::Ordered(CONTROLLED),
        _ => Taken::Nothing,
    }
}

/// The run begins: from now on a signal stops it, and no longer the program.
///
/// # Errors
/// The exit code of a signal that came before.
pub fn begin(stop: &AtomicU16) -> Result<(), u8> {
    let unless_stopped = |flag| (flag & STOP_CODE == 0).then_some(flag | BEGUN);
    let begun = stop.fetch_update(Ordering::Relaxed, Ordering::Relaxed, unless_stopped);
    begun.map(|_| ()).map_err(|flag| (flag & STOP_CODE) as u8)
}

/// Orders a controlled stop because a part of the bench itself failed; a signal that came before stays the cause.
pub fn order_stop(stop: &AtomicU16) {
    set_code(stop, exit::INTERNAL);
}

/// Sets the exit code unless there is one already; whether it was set.
fn set_code(stop: &AtomicU16, code: u8) -> bool {
    let first = |flag| (flag & STOP_CODE == 0).then_some(flag | u16::from(code));
    stop.fetch_update(Ordering::Relaxed, Ordering::Relaxed, first).is_ok()
}

/// Why a run was stopped, by the exit code of its flag.
pub fn cause(code: u8) -> &'static str {
    match code {
        exit::INTERNAL => "stopped: internal error: a listener panicked",
        exit::SIGINT => "stopped by a signal (SIGINT, Ctrl-C)",
        exit::SIGTERM => "stopped by a signal (SIGTERM)",
        exit::SIGHUP => "stopped by a signal (SIGHUP: the terminal was closed)",
        exit::SIGQUIT => "stopped by a signal (SIGQUIT)",
        _ => "stopped by a signal",
    }
}

/// The exit code that a flag stands for; 0 for none.
pub fn exit_code(stop: &AtomicU16) -> u8 {
    (stop.load(Ordering::Relaxed) & STOP_CODE) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_once(stop: &AtomicU16) -> bool {
        stop.load(Ordering::Relaxed) & STOP_AT_ONCE != 0
    }

    #[test]
    fn the_first_signal_names_the_exit_and_a_second_sigint_stops_at_once() {
        let stop = AtomicU16::new(0);
        begin(&stop).expect("no signal yet");
        assert_eq!(take(&stop, Does::Stops(exit::SIGTERM)), Taken::Ordered(CONTROLLED));
        assert_eq!((exit_code(&stop), at_once(&stop)), (exit::SIGTERM, false));
        assert_eq!(take(&stop, Does::Stops(exit::SIGINT)), Taken::Ordered(QUICK));
        assert_eq!((exit_code(&stop), at_once(&stop)), (exit::SIGTERM, true));
        assert_eq!(take(&stop, Does::Stops(exit::SIGINT)), Taken::Nothing, "a third one has nothing to add");
    }

    #[test]
    fn what_means_nothing_to_a_run_changes_nothing_and_sigquit_stops_at_once() {
        let stop = AtomicU16::new(0);
        begin(&stop).expect("no signal yet");
        for does in SIGNALS.iter().map(|row| row.does).filter(|d| matches!(d, Does::HeldOff | Does::Nothing))
        {
            assert_eq!((take(&stop, does), stop.load(Ordering::Relaxed)), (Taken::Nothing, BEGUN));
        }
        assert_eq!(take(&stop, Does::StopsAtOnce(exit::SIGQUIT)), Taken::Ordered(QUICK));
        assert_eq!((exit_code(&stop), at_once(&stop)), (exit::SIGQUIT, true));
    }

    #[test]
    fn a_signal_before_the_run_begins_ends_the_program_and_no_run_begins_after_it() {
        let stop = AtomicU16::new(0);
        assert_eq!(take(&stop, Does::Stops(exit::SIGINT)), Taken::Ends(exit::SIGINT));
        assert_eq!(begin(&stop), Err(exit::SIGINT));
    }
}
