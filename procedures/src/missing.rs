//! What a log or its rig lacks for a kind to say anything: every such sentence stands here.

/// Something that a kind needs and the log does not hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Missing {
    /// An axis of the rig.
    #[error("the rig of the log has no axis `{axis}`")]
    Axis {
        /// Name of the axis.
        axis: String,
    },
    /// Two axes, one carrying the other.
    #[error(transparent)]
    Gimbal(#[from] crate::axis::NoGimbal),
    /// A topic.
    #[error("the log has no topic {topic}")]
    Topic {
        /// Name of the topic, with its slash.
        topic: String,
    },
    /// A topic without a row in the point.
    #[error("the log has no rows of {topic} in the point")]
    Rows {
        /// Name of the topic, with its slash.
        topic: String,
    },
    /// A channel of a topic.
    #[error("{topic} has no channel {channel}")]
    Channel {
        /// Name of the topic, with its slash.
        topic: String,
        /// Name of the channel.
        channel: String,
    },
    /// Numbers in a channel: a value is infinite or NaN.
    #[error("{topic} {channel} is not a number in row {row} of the point")]
    Number {
        /// Name of the topic, with its slash.
        topic: String,
        /// Name of the channel.
        channel: String,
        /// First such row, from 0.
        row: usize,
    },
    /// A planned segment.
    #[error("the segment `{label}` did not run")]
    Segment {
        /// Label of the segment in the plan.
        label: String,
    },
}
