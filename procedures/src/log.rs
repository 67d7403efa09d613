//! THE DOOR: the MCAP file between running and judging.
//!
//! Writing and reading live here together, so that what one writes the other understands.

use serde::{Deserialize, Serialize};

use crate::axis::Axes;
use crate::case::Case;
use crate::missing::Missing;

mod broken;
mod cdr;
mod file;
mod lateness;
mod message;
mod read;
mod record;
mod window;
mod write;

pub use lateness::{LATENESS_BINS, LatenessHistogram, Stall};
pub use read::{LogError, LogReader};
pub use write::LogWriter;

/// Version of [`Plan`] that this code writes and reads.
pub const PLAN_SCHEMA: u32 = 1;

/// Attachment that makes an MCAP file one of ours.
const PLAN_FILE: &str = "plan.json";

/// Header text of our files: no version, so that the same content gives the same bytes.
const LIBRARY: &str = "bench";

/// JSON Schema of a message on topic `/events`; every log carries it as an attachment. The channel itself has no schema record:
/// readers of ROS 2 bags refuse a file with schemas of another language.
pub const EVENTS_SCHEMA: &str = include_str!("log/events.schema.json");

/// Attachment with [`EVENTS_SCHEMA`].
const EVENTS_SCHEMA_FILE: &str = "events.schema.json";

/// Ending of the topic with the rows of an axis of every tick of a stop, `/az/stop` beside `/az`, which keeps the rate of the log. A
/// window has them as rows of the axis, in the place of those of the lower rate.
pub const STOP_SUFFIX: &str = "/stop";

/// Largest record and largest uncompressed chunk that a reader takes: a lying length must not ask for more memory.
const MAX_RECORD_BYTES: usize = 64 << 20;

/// Native width of a channel in the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Width {
    F64,
    F32,
    I32,
    U32,
    U16,
    I8,
}

/// One channel of a topic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Channel {
    /// Name with unit, a valid ROS 2 field name, e.g. `position_rad`.
    pub name: String,
    /// Unit, for reading people.
    pub unit: String,
    /// Width in the log; values are `f64` in memory.
    pub width: Width,
}

/// One topic: a device group with its channels, widest first (CDR alignment).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Topic {
    /// E.g. `/az`.
    pub name: String,
    /// ROS 2 message type name, e.g. `bench_msgs/msg/Axis`.
    pub message: String,
    /// Channels in order of a row's values.
    pub channels: Vec<Channel>,
}

/// What stands in a log beside the rows: enough to judge it alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version of this structure: [`PLAN_SCHEMA`].
    pub schema: u32,
    /// Id of the procedure.
    pub procedure: String,
    /// Axis of the procedure.
    pub axis: String,
    /// Seed of the run.
    pub seed: u64,
    /// Loop rate.
    pub loop_rate_hz: f64,
    /// Rows per second in the log.
    pub log_rate_hz: f64,
    /// Ticks between the row that computed a command and the exchange that sends it.
    pub command_delay_ticks: u32,
    /// Axes of the rig.
    pub axes: Axes,
    /// Planned points.
    pub cases: Vec<Case>,
    /// `simulated`, `real`, `mixed` or `imported`.
    pub mode: String,
}

/// A text that travels with the log, e.g. `procedure.toml`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// File name.
    pub name: String,
    /// Content.
    pub text: String,
}

/// Something that happened, on topic `/events` as JSON. Times are on the log's time axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "event")]
pub enum Event {
    /// A point began.
    PointStarted {
        /// Index in the plan.
        point: usize,
    },
    /// A segment began; its stimulus counts from here.
    SegmentStarted {
        /// Index of the point.
        point: usize,
        /// Index of the segment in the case.
        segment: usize,
        /// Where the axis was.
        position_rad: f64,
    },
    /// A segment ended.
    SegmentEnded {
        /// Index of the point.
        point: usize,
        /// Index of the segment.
        segment: usize,
        /// Why.
        by: EndedBy,
    },
    /// An interlock tripped.
    Tripped {
        /// Index of the point.
        point: usize,
        /// Name of the interlock.
        interlock: String,
        /// What it saw, with numbers and limits.
        reason: String,
    },
    /// An axis was stopped, as ordered or by itself.
    Stopped(StopRecord),
    /// How an axis was left.
    Left(FinalState),
    /// The ring to the log's writer is half full: the disk is slower than the loop.
    RingHalfFull {
        /// Index of the point.
        point: usize,
    },
    /// A tick came so late that it missed periods. Only a loop in real time has such ticks.
    Stall {
        /// Index of the point.
        point: usize,
        /// How late it came.
        #[serde(flatten)]
        stall: Stall,
    },
    /// A station of the fieldbus said something by itself: an emergency message, or that it refused or left a state.
    Notice {
        /// Index of the point.
        point: usize,
        /// Station.
        station: u16,
        /// What it said, with its code and what that means.
        what: String,
    },
    /// A device that hangs on a line of its own failed, fell silent, was heard again, or has lost messages.
    DeviceNotice {
        /// Index of the point.
        point: usize,
        /// Device, field, what was expected, what was found, and what to do.
        what: String,
    },
    /// How late the ticks of a point came, as it ends. Only a loop in real time tells it.
    Lateness {
        /// Index of the point.
        point: usize,
        /// All its ticks.
        #[serde(flatten)]
        histogram: Box<LatenessHistogram>,
    },
    /// A point ended.
    PointEnded {
        /// Index of the point.
        point: usize,
        /// Whether all its segments ran.
        status: PointStatus,
    },
}

/// How an axis was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopManner {
    /// Decelerated by the bench within its limits.
    Controlled,
    /// By the drive's own quick stop.
    QuickStop,
    /// By the bench, but only as far as that does not feed a DC link that is full: friction alone at the worst.
    LinkLimited,
    /// Without torque: friction alone.
    TorqueOff,
}

/// How an axis was left at the end of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinalState {
    /// Index of the point.
    pub point: usize,
    /// Axis.
    pub axis: String,
    /// Power state of its drive, in words of CiA 402.
    pub state: String,
    /// Whether its torque holds it.
    pub held: bool,
    /// Where it stood.
    pub position_rad: f64,
    /// Where it goes if its torque is lost there (computed); `None` where friction keeps it.
    pub swing_to_rad: Option<f64>,
    /// Largest speed on that way.
    pub swing_rad_per_s: Option<f64>,
}

/// A stop: what was computed when it began, what was reached. `P` is how the point is named: by its index in a log, by
/// its name in findings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StopRecord<P = usize> {
    /// The point.
    pub point: P,
    /// Axis.
    pub axis: String,
    /// The least controlled manner that it came to.
    pub manner: StopManner,
    /// Where the axis was when the stop began.
    pub from_rad: f64,
    /// Rate of the axis when the stop began.
    pub from_rad_per_s: f64,
    /// Angle that the stop may take at the worst.
    pub computed_angle_rad: f64,
    /// Time that it may take at the worst; `None` where no torque brakes.
    pub computed_s: Option<f64>,
    /// Largest angle that it took in the direction of motion.
    pub reached_angle_rad: f64,
    /// Time until the axis was slow for good.
    pub took_s: f64,
    /// Where the axis was in the end.
    pub to_rad: f64,
    /// Angle to the end of travel from the place that was reached; below 0 beyond it.
    pub room_rad: f64,
    /// Whether it stood still in the end.
    pub standstill: bool,
}

impl<P> StopRecord<P> {
    /// The same stop, its point named in another way.
    pub fn of_point<Q>(self, point: Q) -> StopRecord<Q> {
        let Self { axis, manner, from_rad, from_rad_per_s, computed_angle_rad, computed_s, .. } = self;
        let Self { reached_angle_rad, took_s, to_rad, room_rad, standstill, .. } = self;
        StopRecord {
            point,
            axis,
            manner,
            from_rad,
            from_rad_per_s,
            computed_angle_rad,
            computed_s,
            reached_angle_rad,
            took_s,
            to_rad,
            room_rad,
            standstill,
        }
    }

    /// Whether the axis was beyond the end of its travel: it may have met its end stop, and what it took was cut short
    /// there.
    pub fn left_the_travel(&self) -> bool {
        self.room_rad < 0.0
    }

    /// Whether it took more than was computed, left the travel, or did not come to rest: a finding of its own.
    pub fn exceeds(&self) -> bool {
        self.reached_angle_rad > self.computed_angle_rad
            || self.computed_s.is_some_and(|computed_s| self.took_s > computed_s)
            || self.left_the_travel()
            || !self.standstill
    }
}

/// Why a segment ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndedBy {
    /// The stimulus was over.
    Completed,
    /// The condition of the segment became true.
    Condition,
    /// The condition of the segment did not become true in time.
    Timeout,
    /// An interlock or the operator stopped it.
    Stopped,
}

/// How a point ended. Status is never verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PointStatus {
    /// All segments ran.
    Completed,
    /// An interlock tripped or the operator stopped it.
    Aborted,
    /// The bench failed.
    Errored,
    /// The log breaks off inside it.
    Lost,
}

/// Where a segment lies in its window.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentSpan {
    /// Index in the case.
    pub segment: usize,
    /// Start on the window's time axis, s.
    pub start_s: f64,
    /// End on the window's time axis, s.
    pub end_s: f64,
    /// Where the axis was at the start.
    pub start_position_rad: f64,
    /// Why it ended.
    pub ended_by: EndedBy,
}

/// The rows of one topic inside a window, by column.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// The topic.
    pub topic: Topic,
    /// Time of each row on the log's time axis, s: nanoseconds / 10⁹, correctly rounded. The step between neighbours
    /// of this type is 1 ns up to 97 days after the log's zero, and 0.24 µs at present Unix times.
    pub time_s: Vec<f64>,
    /// One column a channel, each as long as `time_s`.
    pub columns: Vec<Vec<f64>>,
}

/// One point of the log, in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Index of the point in the plan.
    pub point: usize,
    /// How the point ended.
    pub status: PointStatus,
    /// Segments that ran.
    pub segments: Vec<SegmentSpan>,
    /// Trips, as `interlock: reason`.
    pub trips: Vec<String>,
    /// Stops of the axes.
    pub stops: Vec<StopRecord>,
    /// How the axes were left.
    pub left: Vec<FinalState>,
    /// Ticks that came so late that they missed periods.
    pub stalls: Vec<Stall>,
    /// What stations of the fieldbus said by themselves, as `station 1: …`.
    pub notices: Vec<String>,
    /// How late the ticks came; `None` where time was virtual.
    pub lateness: Option<LatenessHistogram>,
    /// Rows by topic.
    pub topics: Vec<Rows>,
}

impl Rows {
    /// No rows yet, with room for `rows` of them: columns that grow by doubling copy every sample twice.
    fn empty(topic: Topic, rows: usize) -> Self {
        let columns = topic.channels.iter().map(|_| Vec::with_capacity(rows)).collect();
        Self { topic, time_s: Vec::with_capacity(rows), columns }
    }

    /// The rows together with those of every tick, which take the place of means that end at the same time.
    fn with_every_tick(self, every: &Self) -> Self {
        if every.time_s.is_empty() || every.columns.len() != self.columns.len() {
            return self;
        }
        let mut all = Self::empty(self.topic.clone(), self.time_s.len() + every.time_s.len());
        let [mut mean, mut tick] = [0, 0];
        while mean < self.time_s.len() || tick < every.time_s.len() {
            let [mean_s, tick_s] = [(&self, mean), (every, tick)]
                .map(|(rows, k)| rows.time_s.get(k).copied().unwrap_or(f64::INFINITY));
            let (rows, row) = if tick_s <= mean_s { (every, tick) } else { (&self, mean) };
            all.time_s.push(rows.time_s[row]);
            for (to, from) in all.columns.iter_mut().zip(&rows.columns) {
                to.push(from[row]);
            }
            mean += usize::from(mean_s <= tick_s);
            tick += usize::from(tick_s <= mean_s);
        }
        all
    }

    /// The column of this name.
    pub fn column(&self, channel: &str) -> Option<&[f64]> {
        let index = self.topic.channels.iter().position(|c| c.name == channel)?;
        Some(&self.columns[index])
    }

    /// The column of this name.
    ///
    /// # Errors
    /// [`Missing::Channel`].
    pub fn channel(&self, channel: &str) -> Result<&[f64], Missing> {
        let missing = || Missing::Channel { topic: self.topic.name.clone(), channel: channel.to_owned() };
        self.column(channel).ok_or_else(missing)
    }

    /// The column of this name, every value of it a finite number.
    ///
    /// # Errors
    /// [`Missing::Channel`], [`Missing::Number`].
    pub fn finite_channel(&self, channel: &str) -> Result<&[f64], Missing> {
        let values = self.channel(channel)?;
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(row) => {
                Err(Missing::Number { topic: self.topic.name.clone(), channel: channel.to_owned(), row })
            }
        }
    }

    /// Indices of the rows with `start_s <= t < end_s`.
    pub fn range(&self, start_s: f64, end_s: f64) -> std::ops::Range<usize> {
        let from = self.time_s.partition_point(|&t| t < start_s);
        let to = self.time_s.partition_point(|&t| t < end_s);
        from..to
    }
}

impl Window {
    /// A point that ran to its end, with these rows and segments.
    pub fn completed(topics: Vec<Rows>, segments: Vec<SegmentSpan>) -> Self {
        Self {
            point: 0,
            status: PointStatus::Completed,
            segments,
            trips: Vec::new(),
            stops: Vec::new(),
            left: Vec::new(),
            stalls: Vec::new(),
            notices: Vec::new(),
            lateness: None,
            topics,
        }
    }

    /// The rows of this topic.
    pub fn rows(&self, topic: &str) -> Option<&Rows> {
        self.topics.iter().find(|r| r.topic.name == topic)
    }

    /// The rows of this topic.
    ///
    /// # Errors
    /// [`Missing::Topic`].
    pub fn topic(&self, topic: &str) -> Result<&Rows, Missing> {
        self.rows(topic).ok_or_else(|| Missing::Topic { topic: topic.to_owned() })
    }

    /// The rows of this topic, at least one of them.
    ///
    /// # Errors
    /// [`Missing::Topic`], [`Missing::Rows`].
    pub fn topic_with_rows(&self, topic: &str) -> Result<&Rows, Missing> {
        let rows = self.topic(topic)?;
        if rows.time_s.is_empty() { Err(Missing::Rows { topic: topic.to_owned() }) } else { Ok(rows) }
    }

    /// When the first segment with this label ran.
    ///
    /// # Errors
    /// [`Missing::Segment`].
    pub fn segment(&self, case: &Case, label: &str) -> Result<&SegmentSpan, Missing> {
        let index = case.segments.iter().position(|segment| segment.label == label);
        let span = self.segments.iter().find(|span| Some(span.segment) == index);
        span.ok_or_else(|| Missing::Segment { label: label.to_owned() })
    }
}

#[cfg(test)]
mod tests;
