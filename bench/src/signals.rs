//! Signals: SIGINT, SIGTERM and SIGHUP order a controlled stop; a second SIGINT a quick stop at once. The loop looks at
//! a flag every tick.

use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use crate::exit;

/// Bits of the flag that hold the exit code of the first signal; 0 while there was none.
pub const CODE: u16 = 0x00FF;
/// Bit of the flag that a second SIGINT sets: no controlled stop, quick stop now.
pub const AT_ONCE: u16 = 0x0100;

/// The flag that signals set.
///
/// # Errors
/// When the operating system does not let the handlers be installed.
pub fn listen() -> std::io::Result<Arc<AtomicU16>> {
    let stop = Arc::new(AtomicU16::new(0));
    let told = Arc::clone(&stop);
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    // A thread that sleeps until a signal comes; it ends with the process.
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in signals.forever() {
            take(&told, signal);
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
    let first = stop.compare_exchange(0, u16::from(code), Ordering::Relaxed, Ordering::Relaxed);
    if first.is_err() && signal == SIGINT {
        stop.fetch_or(AT_ONCE, Ordering::Relaxed);
    }
}

/// Orders a controlled stop because a part of the bench itself failed; a signal that came before stays the cause.
pub fn order_stop(stop: &AtomicU16) {
    let _ = stop.compare_exchange(0, u16::from(exit::INTERNAL), Ordering::Relaxed, Ordering::Relaxed);
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
    fn the_first_signal_names_the_exit_and_a_second_sigint_stops_at_once() {
        let stop = AtomicU16::new(0);
        take(&stop, SIGTERM);
        assert_eq!((exit_code(&stop), stop.load(Ordering::Relaxed) & AT_ONCE), (exit::SIGTERM, 0));
        take(&stop, SIGINT);
        assert_eq!((exit_code(&stop), stop.load(Ordering::Relaxed) & AT_ONCE), (exit::SIGTERM, AT_ONCE));
    }
}
