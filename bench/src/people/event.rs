//! Events of a run and the interface through which listeners receive them. The runner does not depend on any listener.

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
        /// Campaign id.
        campaign: String,
        /// Rig id.
        rig: String,
        /// Id of the unit under test.
        unit: String,
        /// Number of planned procedures.
        procedures: usize,
        /// Longest planned duration of all points together, s. Simulated time where the rig is simulated.
        planned_s: f64,
        /// Path of the run folder.
        folder: String,
    },
    /// A procedure begins.
    ProcedureStarted {
        /// Id.
        procedure: String,
        /// Number of points.
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
        /// Planned duration of this point, s. A progress bar advances by it.
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
        /// To be set by the listener that shows the question to the operator.
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

/// Whether a question was shown; shared by the asker and the listeners. Input typed before that is not an answer to it.
#[derive(Clone, Debug, Default)]
pub struct Shown(Arc<AtomicBool>);

impl Shown {
    /// Records that the question was shown.
    pub fn set(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Whether the question was shown.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }

    /// Whether nobody can show the question any more: it was not shown, and the asker holds the only remaining handle.
    pub fn is_lost(&self) -> bool {
        Arc::strong_count(&self.0) == 1 && !self.is_set()
    }
}

/// Always equal: two question events are equal if their texts are.
impl PartialEq for Shown {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Receives the events of a run.
pub trait Listener: Send {
    /// Receives one event. Events come in order.
    fn hear(&mut self, event: &RunEvent);
}

/// Protects the run from a panic of its listener. After a panic the listener gets no more events, and a controlled stop
/// is ordered.
pub struct Guarded<'a> {
    listener: Option<&'a mut dyn Listener>,
    stop: &'a AtomicU16,
}

impl<'a> Guarded<'a> {
    /// Guards a listener; `stop` is the flag by which a controlled stop is ordered.
    pub fn new(listener: &'a mut dyn Listener, stop: &'a AtomicU16) -> Self {
        Self { listener: Some(listener), stop }
    }

    /// Passes an event to the listener unless it has panicked before.
    pub fn hear(&mut self, event: &RunEvent) {
        let Some(listener) = &mut self.listener else { return };
        if catch_unwind(AssertUnwindSafe(|| listener.hear(event))).is_err() {
            self.listener = None;
            signals::order_stop(self.stop);
        }
    }

    /// Whether the listener has panicked.
    pub fn is_lost(&self) -> bool {
        self.listener.is_none()
    }
}
