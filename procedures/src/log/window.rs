//! Messages become windows: rows belong to the point whose events stand around them in the file.

use std::collections::BTreeMap;

use mcap::records::op;

use super::broken::Broken;
use super::cdr::Layout;
use super::message::{self, EVENTS_TOPIC};
use super::record::{self, Channel, Message, Schema};
use super::{
    EndedBy, Event, FinalState, LatenessHistogram, PointStatus, Rows, STOP_SUFFIX, SegmentSpan, Stall,
    StopRecord, Topic, Window,
};

/// Most schemas, rows' topics and channels of a topic: far more than any rig has.
pub(super) const MOST_SCHEMAS: usize = 256;
pub(super) const MOST_TOPICS: usize = 64;
pub(super) const MOST_CHANNELS: usize = 1024;
/// Longest definition of a message, bytes.
pub(super) const MOST_SCHEMA_BYTES: usize = 1 << 20;
/// Most events of a point.
pub(super) const MOST_EVENTS: usize = 100_000;
/// What the samples of a point may take in memory, bytes: this at least, and this many times the size of the file. A chunk
/// that says little very often unpacks to a thousand times its size.
const MEMORY_BYTES: u64 = 192 << 20;
const MEMORY_FACTOR: u64 = 8;

/// A channel of the file.
#[derive(Clone, Copy)]
struct Source {
    content: Content,
    /// Sequence number of its next message: a gap is a chunk that is missing.
    next_sequence: u32,
}

/// What the messages of a channel are.
#[derive(Clone, Copy)]
enum Content {
    Unknown,
    Events,
    Rows(usize),
}

/// Collects the messages of one point.
#[derive(Default)]
pub(super) struct Assembly {
    schemas: BTreeMap<u16, Schema>,
    /// By channel id.
    sources: Vec<Source>,
    topics: Vec<(Layout, Rows)>,
    open: Option<Open>,
    /// How many samples a point may have.
    most_samples: u64,
}

/// The point that has begun and not ended.
#[derive(Default)]
struct Open {
    point: usize,
    segments: Vec<SegmentSpan>,
    running: Option<SegmentSpan>,
    trips: Vec<String>,
    stops: Vec<StopRecord>,
    left: Vec<FinalState>,
    stalls: Vec<Stall>,
    notices: Vec<String>,
    lateness: Option<LatenessHistogram>,
    last_row_s: f64,
    samples: u64,
    events: usize,
}

impl Open {
    /// A segment whose end nobody wrote down ended with the last row.
    fn stop_running(&mut self) {
        if let Some(segment) = self.running.take() {
            let end_s = self.last_row_s.max(segment.start_s);
            self.segments.push(SegmentSpan { end_s, ended_by: EndedBy::Stopped, ..segment });
        }
    }
}

/// Topics with the rows of every tick of a stop among those of their axes.
fn with_stops(topics: Vec<Rows>) -> Vec<Rows> {
    let (stops, topics): (Vec<Rows>, Vec<Rows>) =
        topics.into_iter().partition(|rows| rows.topic.name.ends_with(STOP_SUFFIX));
    let of_axis = |rows: Rows| {
        let own =
            stops.iter().find(|stop| stop.topic.name.strip_suffix(STOP_SUFFIX) == Some(&rows.topic.name));
        match own {
            Some(stop) => rows.with_every_tick(stop),
            None => rows,
        }
    };
    topics.into_iter().map(of_axis).collect()
}

impl Assembly {
    /// Of a file of this size.
    pub(super) fn of_file(size_bytes: u64) -> Self {
        let most_bytes = MEMORY_BYTES.max(size_bytes.saturating_mul(MEMORY_FACTOR));
        Self { most_samples: most_bytes / size_of::<f64>() as u64, ..Self::default() }
    }

    /// Takes a record; gives the window that it completes.
    ///
    /// # Errors
    /// When the record makes no sense.
    pub(super) fn take(&mut self, opcode: u8, body: &[u8]) -> Result<Option<Window>, Broken> {
        match opcode {
            op::MESSAGE => self.message(&record::message(body).ok_or(Broken::NoHeader)?),
            op::SCHEMA => {
                let schema = record::schema(body).ok_or(Broken::SchemaLengths)?;
                if schema.text.len() > MOST_SCHEMA_BYTES || self.schemas.len() >= MOST_SCHEMAS {
                    return Err(Broken::ManySchemas { bytes: schema.text.len(), others: self.schemas.len() });
                }
                self.schemas.insert(schema.id, schema);
                Ok(None)
            }
            op::CHANNEL => {
                self.channel(record::channel(body).ok_or(Broken::ChannelLengths)?)?;
                Ok(None)
            }
            _ => Ok(None),
        }
    }

    /// The index of the point that has begun and not ended.
    pub(super) fn open_point(&self) -> Option<usize> {
        self.open.as_ref().map(|o| o.point)
    }

    /// Ends the open point, if there is one, with this status.
    pub(super) fn close(&mut self, status: PointStatus) -> Option<Window> {
        let mut open = self.open.take()?;
        open.stop_running();
        let topics = self.topics.iter_mut().map(|(_, rows)| {
            // Points of a procedure are of similar length.
            let empty = Rows::empty(rows.topic.clone(), rows.time_s.len());
            std::mem::replace(rows, empty)
        });
        let topics = with_stops(topics.collect());
        let Open { point, segments, trips, stops, left, stalls, notices, lateness, .. } = open;
        Some(Window { point, status, segments, trips, stops, left, stalls, notices, lateness, topics })
    }

    fn channel(&mut self, channel: Channel) -> Result<(), Broken> {
        let index = usize::from(channel.id);
        if index >= self.sources.len() {
            self.sources.resize(index + 1, Source { content: Content::Unknown, next_sequence: 0 });
        } else if !matches!(self.sources[index].content, Content::Unknown) {
            return Ok(()); // repeated in the summary
        }
        self.sources[index].content = match self.rows_topic(&channel) {
            Some(topic) if self.topics.len() >= MOST_TOPICS || topic.channels.len() > MOST_CHANNELS => {
                return Err(Broken::ManyTopics { topic: topic.name, channels: topic.channels.len() });
            }
            Some(topic) => {
                self.topics.push((Layout::new(&topic.channels), Rows::empty(topic, 0)));
                Content::Rows(self.topics.len() - 1)
            }
            None if channel.topic == EVENTS_TOPIC && channel.encoding == "json" => Content::Events,
            None => Content::Unknown,
        };
        Ok(())
    }

    fn rows_topic(&self, channel: &Channel) -> Option<Topic> {
        let schema = self.schemas.get(&channel.schema_id)?;
        if channel.encoding != "cdr" || schema.encoding != "ros2msg" {
            return None;
        }
        let channels = message::channels(&schema.text)?;
        Some(Topic { name: channel.topic.clone(), message: schema.name.clone(), channels })
    }

    fn message(&mut self, message: &Message<'_>) -> Result<Option<Window>, Broken> {
        let time_s = message.log_time_ns as f64 / 1e9;
        let source = self.sources.get_mut(usize::from(message.channel_id));
        let source = source.ok_or_else(|| Broken::UnknownChannel { channel: message.channel_id })?;
        if message.sequence != source.next_sequence {
            let expected = source.next_sequence;
            let found = message.sequence;
            return Err(Broken::MessagesMissing { expected, found });
        }
        source.next_sequence = message.sequence.wrapping_add(1);
        match source.content {
            Content::Rows(topic) => self.row(topic, time_s, message.payload).map(|()| None),
            Content::Events => {
                let event = serde_json::from_slice(message.payload).map_err(Broken::Event)?;
                self.event(time_s, event)
            }
            Content::Unknown => Ok(None),
        }
    }

    fn row(&mut self, topic: usize, time_s: f64, payload: &[u8]) -> Result<(), Broken> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let (layout, rows) = &mut self.topics[topic];
        if rows.time_s.last().is_some_and(|&last_s| last_s > time_s) {
            return Err(Broken::TimeGoesBack { topic: rows.topic.name.clone(), at_s: time_s });
        }
        open.samples += layout.channel_count() as u64 + 1;
        if open.samples > self.most_samples {
            let most_bytes = self.most_samples * size_of::<f64>() as u64;
            return Err(Broken::ManySamples { point: open.point, most_bytes });
        }
        layout
            .decode(payload, &mut rows.columns)
            .map_err(|e| Broken::Row { topic: rows.topic.name.clone(), reason: Box::new(e) })?;
        rows.time_s.push(time_s);
        open.last_row_s = open.last_row_s.max(time_s);
        Ok(())
    }

    fn event(&mut self, time_s: f64, event: Event) -> Result<Option<Window>, Broken> {
        if let Some(open) = &mut self.open {
            open.events += 1;
            if open.events > MOST_EVENTS {
                return Err(Broken::ManyEvents { point: open.point });
            }
        }
        match (event, &mut self.open) {
            (Event::PointStarted { point }, None) => {
                self.open = Some(Open { point, last_row_s: time_s, ..Open::default() });
            }
            (Event::SegmentStarted { point, segment, position_rad }, Some(open)) if point == open.point => {
                open.stop_running();
                let ended_by = EndedBy::Stopped;
                let start_s = time_s;
                let end_s = time_s;
                let start_position_rad = position_rad;
                open.running = Some(SegmentSpan { segment, start_s, end_s, start_position_rad, ended_by });
            }
            (Event::SegmentEnded { point, segment, by }, Some(open)) if point == open.point => {
                let running = open.running.take().filter(|r| r.segment == segment);
                let running = running.ok_or(Broken::NotBegun { segment, point })?;
                open.segments.push(SegmentSpan { end_s: time_s, ended_by: by, ..running });
            }
            (Event::Tripped { point, interlock, reason }, Some(open)) if point == open.point => {
                open.trips.push(format!("{interlock}: {reason}"));
            }
            (Event::Stopped(stop), Some(open)) if stop.point == open.point => open.stops.push(stop),
            (Event::Left(state), Some(open)) if state.point == open.point => open.left.push(state),
            (Event::RingHalfFull { point }, Some(open)) if point == open.point => {}
            (Event::Stall { point, stall }, Some(open)) if point == open.point => open.stalls.push(stall),
            (Event::Notice { point, station, what }, Some(open)) if point == open.point => {
                open.notices.push(format!("station {station}: {what}"));
            }
            (Event::DeviceNotice { point, what }, Some(open)) if point == open.point => {
                open.notices.push(what)
            }
            (Event::Lateness { point, histogram }, Some(open)) if point == open.point => {
                open.lateness.get_or_insert_default().add(&histogram);
            }
            (Event::PointEnded { point, status }, Some(open)) if point == open.point => {
                return Ok(self.close(status));
            }
            (event, open) => {
                return Err(Broken::OutOfOrder {
                    open: open.as_ref().map(|o| o.point),
                    event: Box::new(event),
                });
            }
        }
        Ok(None)
    }
}
