//! Events of a run and the interface through which listeners receive them. The runner does not depend on any listener.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};

use procedures::verdict::Verdict;
use serde::Serialize;

use crate::people::signals;

mod bar;
mod listeners;
pub mod schema;

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
    /// A point begins.
    PointStarted {
        /// Procedure id.
        procedure: String,
        /// Name of the point.
        point: String,
        /// Its number in the procedure, from 1.
        number: usize,
        /// Points of the procedure.
        points: usize,
        /// Planned duration of this point, s.
        planned_s: f64,
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
        /// Status, or why it was skipped.
        status: String,
        /// Planned duration of all its points, s.
        planned_s: f64,
        /// The worst verdict of each requirement that its log was judged by, before logs that know more of each other.
        verdicts: Vec<FirstVerdict>,
    },
    /// Something the operator should know.
    Notice {
        /// Text.
        text: String,
    },
    /// The result for a person.
    Result {
        /// Its text, in parts.
        parts: Vec<Part>,
    },
    /// Something that the operator is asked.
    Question {
        /// Text.
        text: String,
        /// To be set by the listener that shows the question to the operator.
        #[serde(skip)]
        shown: Shown,
    },
    /// A question was answered.
    Answered {
        /// Procedure or stage that asked.
        asked_by: String,
        /// Id of the question.
        prompt: String,
        /// The answer.
        answer: String,
        /// Who answered, and how.
        by: String,
    },
    /// The run is over.
    RunEnded {
        /// Overall verdict.
        overall: String,
        /// Exit code.
        exit_code: u8,
        /// Requirements by verdict, as text.
        counts: String,
        /// What stands in the way of a pass.
        shortfalls: Vec<Shortfall>,
        /// Path of the report, if it was written.
        report: Option<String>,
    },
}

/// Text in one colour.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Part {
    /// Text.
    pub text: String,
    /// The verdict in whose colour it stands.
    pub verdict: Option<Verdict>,
}

impl Part {
    /// Without colour.
    pub fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), verdict: None }
    }

    /// In the colour of a verdict.
    pub fn coloured(text: impl Into<String>, verdict: Verdict) -> Self {
        Self { text: text.into(), verdict: Some(verdict) }
    }
}

/// What a procedure's own log says of a requirement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FirstVerdict {
    /// Requirement id.
    pub requirement: String,
    /// `pass`, `fail`, …
    pub verdict: String,
}

/// A limit of a requirement that was not simply met.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Shortfall {
    /// Requirement id.
    pub requirement: String,
    /// `fail`, `inconclusive`, `not measured`, …
    pub verdict: String,
    /// Value, expanded uncertainty, limit and margin, or the reason for no verdict.
    pub why: String,
    /// Procedure and point that decided.
    pub place: String,
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

    /// Called several times a second while nothing happens.
    fn tick(&mut self) {}
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

    /// Lets time pass for the listener unless it has panicked before.
    pub fn tick(&mut self) {
        let Some(listener) = &mut self.listener else { return };
        if catch_unwind(AssertUnwindSafe(|| listener.tick())).is_err() {
            self.listener = None;
            signals::order_stop(self.stop);
        }
    }

    /// Whether the listener has panicked.
    pub fn is_lost(&self) -> bool {
        self.listener.is_none()
    }
}
