//! What the runner tells its listeners. The runner knows none of them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};

use serde::Serialize;

use crate::people::signals;

mod listeners;

pub use listeners::{JsonLines, PlainLines, Progress};

/// Something that happened in a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "event")]
pub enum RunEvent {
    /// The run begins.
    RunStarted {
        /// Campaign.
        campaign: String,
        /// Rig and unit.
        rig: String,
        /// Unit under test.
        unit: String,
        /// How many procedures.
        procedures: usize,
        /// Planned simulated or real seconds over all points.
        planned_s: f64,
        /// Run folder.
        folder: String,
    },
    /// A procedure begins.
    ProcedureStarted {
        /// Id.
        procedure: String,
        /// How many points.
        points: usize,
    },
    /// A point ended.
    PointEnded {
        /// Procedure id.
        procedure: String,
        /// Name of the point.
        point: String,
        /// `completed`, `aborted`, …
        status: String,
        /// Planned seconds that are done with it.
        planned_s: f64,
        /// The trip or error, if any.
        reason: Option<String>,
    },
    /// A procedure ended and was judged.
    ProcedureEnded {
        /// Id.
        procedure: String,
        /// Status.
        status: String,
    },
    /// Something the operator should know.
    Notice {
        /// Text.
        text: String,
    },
    /// Something that the operator is asked.
    Question {
        /// Text.
        text: String,
        /// Set by whoever has put it before the operator's eyes.
        #[serde(skip)]
        shown: Shown,
    },
    /// The run is over.
    RunEnded {
        /// Overall verdict.
        overall: String,
        /// Exit code.
        exit_code: u8,
    },
}

/// Whether a question was shown: what is typed before that is no answer to it.
#[derive(Clone, Debug, Default)]
pub struct Shown(Arc<AtomicBool>);

impl Shown {
    /// Remembers that the note was shown.
    pub fn set(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Whether it was.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }

    /// Whether nobody can show it any more: who asks is the only one left that knows of it.
    pub fn is_lost(&self) -> bool {
        Arc::strong_count(&self.0) == 1 && !self.is_set()
    }
}

/// A question is its text, whoever has seen it.
impl PartialEq for Shown {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Takes events.
pub trait Listener: Send {
    /// One event, in order.
    fn hear(&mut self, event: &RunEvent);
}

/// A listener that cannot take the run with it: when it panics, it hears nothing more, and the run is stopped.
pub struct Guarded<'a> {
    listener: Option<&'a mut dyn Listener>,
    stop: &'a AtomicU16,
}

impl<'a> Guarded<'a> {
    /// Guards a listener; `stop` is the flag by which a controlled stop is ordered.
    pub fn new(listener: &'a mut dyn Listener, stop: &'a AtomicU16) -> Self {
        Self { listener: Some(listener), stop }
    }

    /// One event, unless the listener is lost.
    pub fn hear(&mut self, event: &RunEvent) {
        let Some(listener) = &mut self.listener else { return };
        if catch_unwind(AssertUnwindSafe(|| listener.hear(event))).is_err() {
            self.listener = None;
            signals::order_stop(self.stop);
        }
    }

    /// Whether it panicked.
    pub fn is_lost(&self) -> bool {
        self.listener.is_none()
    }
}
