//! The states of a point.

use procedures::procedure::PromptClass;

use super::segment::Running;

/// Where the sequencer is.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would be an allocation in the tick")]
pub enum State<'c> {
    /// Waiting for the first valid inputs; gates are checked.
    SafeOp,
    /// Asked for OP.
    OpRequest,
    /// Resetting faults that drives had before the point.
    FaultReset,
    /// Waiting for the operator: safety questions without torque, others while the axes are held.
    Asking(PromptClass),
    /// Bringing all drives to operation enabled.
    Enabling,
    /// Bringing the axes slowly to where the plan begins.
    Homing,
    /// A segment runs.
    Running(Running<'c>),
    /// Bringing the axis to rest between segments; then the segment of this index starts.
    Arresting {
        /// Next segment.
        next: usize,
    },
    /// Bringing the axes slowly to where they may be released.
    Parking,
    /// Taking the torque from the axes that are released.
    Disabling,
    /// Controlled stop after a trip or an order to stop.
    Stopping,
    /// Nothing more to do here; `make_safe` takes over.
    Finished,
}

impl State<'_> {
    /// Number in the log's `state` channel.
    pub fn number(&self) -> u16 {
        match self {
            Self::SafeOp => 0,
            Self::OpRequest => 1,
            Self::Enabling => 2,
            Self::Running(_) => 3,
            Self::Arresting { .. } => 4,
            Self::Stopping => 5,
            Self::Finished => 6,
            // 7 is `make_safe`.
            Self::FaultReset => 8,
            Self::Asking(_) => 9,
            Self::Homing => 10,
            Self::Parking => 11,
            Self::Disabling => 12,
        }
    }

    /// Whether the drives must be in operation.
    pub(super) fn is_powered(&self) -> bool {
        matches!(
            self,
            Self::Asking(PromptClass::Info)
                | Self::Homing
                | Self::Running(_)
                | Self::Arresting { .. }
                | Self::Parking
                | Self::Stopping
        )
    }

    /// Whether nobody can plan how long it takes.
    pub(super) fn is_off_plan(&self) -> bool {
        matches!(self, Self::Asking(_) | Self::Homing | Self::Parking)
    }
}
