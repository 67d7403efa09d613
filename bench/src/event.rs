//! What the runner tells its listeners. The runner knows none of them.

use serde::Serialize;

mod json;
mod lines;
mod progress;

pub use json::JsonLines;
pub use lines::PlainLines;
pub use progress::Progress;

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
    /// The run is over.
    RunEnded {
        /// Overall verdict.
        overall: String,
        /// Exit code.
        exit_code: u8,
    },
}

/// Takes events.
pub trait Listener: Send {
    /// One event, in order.
    fn hear(&mut self, event: &RunEvent);
}
