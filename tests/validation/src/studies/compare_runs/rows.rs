//! Rows and events of two logs of one procedure.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use mcap::MessageStream;

/// Topic whose messages are JSON.
const EVENTS: &str = "/events";
/// Differing events that are shown.
const EVENTS_SHOWN: usize = 5;

/// What came of one log.
#[derive(Default)]
pub(crate) struct Compared {
    /// Rows and events in the log after.
    pub(crate) rows: usize,
    /// One line a difference.
    pub(crate) differences: Vec<String>,
}

/// One message.
struct Message {
    log_time_ns: u64,
    payload: Vec<u8>,
}

/// What a log holds of one topic.
#[derive(Default)]
struct Summary {
    schema: String,
    rows: usize,
    hasher: DefaultHasher,
}

/// Compares two logs topic by topic; what a topic's rows differ in is told once, for all of them.
///
/// # Errors
/// When a log cannot be read to its end.
pub(crate) fn compare(before: &Path, after: &Path) -> Result<Compared, String> {
    let old = read(before)?;
    let new = read(after)?;
    let old_topics = summaries(&old, before)?;
    let new_topics = summaries(&new, after)?;
    let names: BTreeSet<&String> = old_topics.keys().chain(new_topics.keys()).collect();
    let mut compared = Compared::default();
    for name in names {
        let (Some(was), Some(is)) = (old_topics.get(name), new_topics.get(name)) else {
            let side = if new_topics.contains_key(name) { "after" } else { "before" };
            compared.differences.push(format!("{name} stands only in the log {side}"));
            continue;
        };
        compared.rows += is.rows;
        if was.schema != is.schema {
            compared.differences.push(format!("{name}: other channels"));
        }
        if was.rows != is.rows {
            compared.differences.push(format!("{name}: {} rows, {} before", is.rows, was.rows));
        }
        if was.hasher.finish() != is.hasher.finish() {
            let rows_before = of_topic(&old, before, name)?;
            let rows_after = of_topic(&new, after, name)?;
            compared.differences.extend(if name == EVENTS {
                differing_events(&rows_before, &rows_after)
            } else {
                differing_rows(name, &is.schema, &rows_before, &rows_after)
            });
        }
    }
    Ok(compared)
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn summaries(log: &[u8], path: &Path) -> Result<BTreeMap<String, Summary>, String> {
    let unreadable = |e: mcap::McapError| format!("{}: {e}", path.display());
    let mut topics: BTreeMap<String, Summary> = BTreeMap::new();
    for message in MessageStream::new(log).map_err(unreadable)? {
        let message = message.map_err(unreadable)?;
        if !topics.contains_key(&message.channel.topic) {
            topics.insert(message.channel.topic.clone(), Summary::default());
        }
        let topic = topics.get_mut(&message.channel.topic).expect("it was inserted if it was missing");
        if topic.rows == 0 {
            let schema = message.channel.schema.as_ref();
            topic.schema = schema.map_or(String::new(), |s| String::from_utf8_lossy(&s.data).into_owned());
        }
        topic.rows += 1;
        (message.log_time, &*message.data).hash(&mut topic.hasher);
    }
    Ok(topics)
}

fn of_topic(log: &[u8], path: &Path, topic: &str) -> Result<Vec<Message>, String> {
    let unreadable = |e: mcap::McapError| format!("{}: {e}", path.display());
    let mut rows = Vec::new();
    for message in MessageStream::new(log).map_err(unreadable)? {
        let message = message.map_err(unreadable)?;
        if message.channel.topic == topic {
            rows.push(Message { log_time_ns: message.log_time, payload: message.data.into_owned() });
        }
    }
    Ok(rows)
}

fn differing_events(before: &[Message], after: &[Message]) -> Vec<String> {
    let pairs = before.iter().zip(after).enumerate();
    let differing: Vec<String> = pairs
        .filter(|(_, (was, is))| was.log_time_ns != is.log_time_ns || was.payload != is.payload)
        .map(|(k, (was, is))| format!("event {k}: {}, before: {}", event(is), event(was)))
        .collect();
    let more = differing.len().saturating_sub(EVENTS_SHOWN);
    let mut lines: Vec<String> = differing.into_iter().take(EVENTS_SHOWN).collect();
    if more > 0 {
        lines.push(format!("{more} more events differ"));
    }
    lines
}

fn event(message: &Message) -> String {
    format!("{} ns {}", message.log_time_ns, String::from_utf8_lossy(&message.payload))
}

/// One line for the log times and one a channel: how many rows differ, from which on, and by how much at the most.
fn differing_rows(topic: &str, schema: &str, before: &[Message], after: &[Message]) -> Vec<String> {
    let mut lines = Vec::new();
    let pairs = || before.iter().zip(after);
    let times = pairs().filter(|(was, is)| was.log_time_ns != is.log_time_ns).count();
    if times > 0 {
        lines.push(format!("{topic}: {times} of {} log times differ", after.len()));
    }
    for field in fields(schema) {
        let values =
            pairs().map(|(was, is)| (is.log_time_ns, field.value(&was.payload), field.value(&is.payload)));
        let differing: Vec<(u64, f64, f64)> =
            values.filter(|(_, was, is)| was.to_bits() != is.to_bits()).collect();
        let Some((first_ns, was, is)) = differing.first() else { continue };
        let largest = differing.iter().map(|(_, was, is)| (is - was).abs()).fold(0.0, f64::max);
        lines.push(format!(
            "{topic} {}: {} of {} rows differ by up to {largest:e}, the first at {first_ns} ns: {is:?}, before {was:?}",
            field.name,
            differing.len(),
            after.len()
        ));
    }
    lines
}

/// A field of a ROS 2 message of scalars, and where it stands in the payload.
struct Field {
    name: String,
    kind: String,
    at: usize,
}

impl Field {
    /// NaN where the payload ends before it.
    fn value(&self, payload: &[u8]) -> f64 {
        let bytes = |count: usize| payload.get(self.at..self.at + count).unwrap_or(&[]);
        let value = match self.kind.as_str() {
            "float64" => bytes(8).try_into().map(f64::from_le_bytes),
            "float32" => bytes(4).try_into().map(f32::from_le_bytes).map(f64::from),
            "int32" => bytes(4).try_into().map(i32::from_le_bytes).map(f64::from),
            "uint32" => bytes(4).try_into().map(u32::from_le_bytes).map(f64::from),
            "uint16" => bytes(2).try_into().map(u16::from_le_bytes).map(f64::from),
            _ => bytes(1).try_into().map(i8::from_le_bytes).map(f64::from),
        };
        value.unwrap_or(f64::NAN)
    }
}

/// The fields of a message definition, `float64 position_rad # rad` a line, behind the four bytes of CDR's encapsulation.
fn fields(schema: &str) -> Vec<Field> {
    const ENCAPSULATION_BYTES: usize = 4;
    let mut end = 0_usize;
    let mut fields = Vec::new();
    for line in schema.lines() {
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else { continue };
        let size = match kind {
            "float64" => 8,
            "float32" | "int32" | "uint32" => 4,
            "uint16" => 2,
            _ => 1,
        };
        let start = end.next_multiple_of(size);
        fields.push(Field { name: name.to_owned(), kind: kind.to_owned(), at: ENCAPSULATION_BYTES + start });
        end = start + size;
    }
    fields
}
