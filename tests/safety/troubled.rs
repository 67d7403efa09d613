//! A bus on which something happens at one exchange.

use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Duration;

use super::bed::Wrap;
use validation::intercepted::{Intercepted, Interceptor};

/// Lets something happen at one exchange of a bus.
struct Troubled {
    exchanges: u32,
    at: u32,
    trouble: Trouble,
    behind: Duration,
}

#[derive(Clone)]
pub(super) enum Trouble {
    /// The thread of the loop panics.
    Panic,
    /// The thread of the loop stands for this long: no frame goes out, the world goes on.
    Hang(Duration),
    /// Somebody sends a signal with this exit code.
    Order(Arc<AtomicU16>, u16),
}

/// A wrapping for the bus of a bed.
pub(super) fn troubled(at: u32, trouble: Trouble) -> Wrap {
    Box::new(move |bus| {
        let trouble = trouble.clone();
        Intercepted::boxed(bus, Troubled { exchanges: 0, at, trouble, behind: Duration::ZERO })
    })
}

impl Interceptor for Troubled {
    fn before_exchange(&mut self, now: Duration) -> Duration {
        self.exchanges += 1;
        if self.exchanges == self.at {
            match &self.trouble {
                Trouble::Panic => panic!("planned by the test"),
                Trouble::Hang(time) => self.behind = *time,
                Trouble::Order(stop, code) => stop.store(*code, Ordering::Relaxed),
            }
        }
        now + self.behind
    }
}
