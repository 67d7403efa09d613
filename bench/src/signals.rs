//! Signals: SIGINT, SIGTERM and SIGHUP order a controlled stop; a second SIGINT a quick stop at once. The loop looks at
//! a flag every tick. SIGTSTP (Ctrl-Z) is held off while a rig is armed: a stopped loop would leave the axes to the
//! drives' watchdogs.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGTSTP};
use signal_hook::iterator::Signals;

use crate::exit;

/// Bits of the flag that hold the exit code of the first signal; 0 while there was none.
pub const CODE: u16 = 0x00FF;
/// Bit of the flag that a second SIGINT sets: no controlled stop, quick stop now.
pub const AT_ONCE: u16 = 0x0100;
/// The bits above count the rigs that are armed, modulo 128.
const ARMED_ONE: u16 = 0x0200;

/// The flag that signals set.
///
/// # Errors
/// When the operating system does not let the handlers be installed.
pub fn listen() -> std::io::Result<Arc<AtomicU16>> {
    let stop = Arc::new(AtomicU16::new(0));
    let told = Arc::clone(&stop);
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP, SIGTSTP])?;
    // A thread that sleeps until a signal comes; it ends with the process.
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in signals.forever() {
            match signal {
                SIGTSTP => hold_off(&told),
                _ => take(&told, signal),
            }
        }
    })?;
    Ok(stop)
}

fn take(stop: &AtomicU16, signal: i32) {
    let code = match signal {
        SIGINT => exit::SIGINT,
        SIGTERM => exit::SIGTERM,
        _ => exit::SIGHUP,
    };
    if !set_code(stop, code) && signal == SIGINT {
        stop.fetch_or(AT_ONCE, Ordering::Relaxed);
    }
}

/// Orders a controlled stop because a part of the bench itself failed; a signal that came before stays the cause.
pub fn order_stop(stop: &AtomicU16) {
    set_code(stop, exit::INTERNAL);
}

/// Sets the exit code unless there is one already; whether it was set.
fn set_code(stop: &AtomicU16, code: u8) -> bool {
    let first = |flag| (flag & CODE == 0).then_some(flag | u16::from(code));
    stop.fetch_update(Ordering::Relaxed, Ordering::Relaxed, first).is_ok()
}

/// Ctrl-Z: not while something can move.
fn hold_off(stop: &AtomicU16) {
    if is_armed(stop) {
        let why = "Ctrl-Z is held off while the rig is armed: a stopped program cannot stop an axis; Ctrl-C stops the run";
        let _ = writeln!(std::io::stderr(), "{why}");
    } else {
        let _ = signal_hook::low_level::emulate_default_handler(SIGTSTP);
    }
}

/// Whether a rig is armed.
fn is_armed(stop: &AtomicU16) -> bool {
    stop.load(Ordering::Relaxed) >= ARMED_ONE
}

/// A rig is armed for as long as this lives: from before its drives can be enabled to the end of `make_safe`.
pub struct Armed<'a>(&'a AtomicU16);

impl<'a> Armed<'a> {
    /// From now on.
    pub fn new(stop: &'a AtomicU16) -> Self {
        stop.fetch_add(ARMED_ONE, Ordering::Relaxed);
        Self(stop)
    }
}

impl Drop for Armed<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(ARMED_ONE, Ordering::Relaxed);
    }
}

/// Why a run was stopped, by the exit code of its flag.
pub fn cause(code: u8) -> &'static str {
    match code {
        exit::INTERNAL => "stopped: internal error: a listener panicked",
        _ => "stopped by a signal",
    }
}

/// The exit code that a flag stands for; 0 for none.
pub fn exit_code(stop: &AtomicU16) -> u8 {
    (stop.load(Ordering::Relaxed) & CODE) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn armed_rigs_are_counted_beside_the_code_of_a_signal() {
        let stop = AtomicU16::new(0);
        let first = Armed::new(&stop);
        let second = Armed::new(&stop);
        take(&stop, SIGHUP);
        assert_eq!((exit_code(&stop), is_armed(&stop)), (exit::SIGHUP, true));
        drop(first);
        assert!(is_armed(&stop));
        drop(second);
        assert_eq!((exit_code(&stop), is_armed(&stop)), (exit::SIGHUP, false));
    }

    #[test]
    fn the_first_signal_names_the_exit_and_a_second_sigint_stops_at_once() {
        let stop = AtomicU16::new(0);
        take(&stop, SIGTERM);
        assert_eq!((exit_code(&stop), stop.load(Ordering::Relaxed) & AT_ONCE), (exit::SIGTERM, 0));
        take(&stop, SIGINT);
        assert_eq!((exit_code(&stop), stop.load(Ordering::Relaxed) & AT_ONCE), (exit::SIGTERM, AT_ONCE));
    }
}
