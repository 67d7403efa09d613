//! How long calls of the system take.

use std::cell::Cell;
use std::time::Duration;

use super::clock;

/// How long an exchange spent in calls of the system.
#[derive(Default)]
pub(crate) struct Meter {
    /// In those that wait for the interface.
    pub(crate) waited: Cell<Duration>,
    /// In those that send and receive without waiting.
    pub(crate) called: Cell<Duration>,
}

impl Meter {
    /// Forgets what was measured.
    pub(crate) fn reset(&self) {
        self.waited.set(Duration::ZERO);
        self.called.set(Duration::ZERO);
    }
}

/// Adds the time of a call to `sum`.
pub(crate) fn measured<T>(sum: &Cell<Duration>, call: impl FnOnce() -> T) -> T {
    let begun = clock::now();
    let done = call();
    sum.set(sum.get() + clock::now().saturating_sub(begun));
    done
}
