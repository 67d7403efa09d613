//! Signals: SIGINT, SIGTERM and SIGHUP order a controlled stop; the loop looks at a flag every tick.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use crate::exit;

/// A flag that the first signal sets to the exit code it stands for; 0 while there was none.
///
/// # Errors
/// When the operating system does not let the handlers be installed.
pub fn listen() -> std::io::Result<Arc<AtomicU8>> {
    let stop = Arc::new(AtomicU8::new(0));
    let told = Arc::clone(&stop);
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    // A thread that sleeps until a signal comes; it ends with the process.
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in signals.forever() {
            let code = match signal {
                SIGINT => exit::SIGINT,
                SIGTERM => exit::SIGTERM,
                _ => exit::SIGHUP,
            };
            let _ = told.compare_exchange(0, code, Ordering::Relaxed, Ordering::Relaxed);
        }
    })?;
    Ok(stop)
}
