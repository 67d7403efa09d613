//! Mutations of logs: of the records of the file, and of what stands in them with every checksum right.

use procedures::log::{Attachment, EndedBy, Event, LogReader, LogWriter, PointStatus, Topic, Window};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::RngCore;

use super::text::{self, BYTES, TEXT, below, one};

/// Bytes of the magic at either end, and of opcode and length before a record.
const MAGIC_BYTES: usize = 8;
const HEAD_BYTES: usize = 9;
/// Opcodes.
const CHUNK: u8 = 0x06;
const ATTACHMENT: u8 = 0x09;
const DATA_END: u8 = 0x0F;

/// A mutated log and how it was made.
pub(super) fn mutated(original: &[u8], random: &mut ChaCha8Rng) -> (Vec<u8>, &'static str) {
    match below(random, 10) {
        0..=2 => {
            let way = one(random, BYTES);
            ((way.apply)(original.to_vec(), random), way.name)
        }
        3..=4 => (records(original, random), "records"),
        5..=6 => (attachment(original, random), "an attachment"),
        _ => (rewritten(original, random), "rewritten"),
    }
}

/// Where the outer records stand: opcode, start and end.
fn outer(bytes: &[u8]) -> Vec<(u8, usize, usize)> {
    let mut found = Vec::new();
    let mut at = MAGIC_BYTES;
    while let Some(head) = bytes.get(at..at + HEAD_BYTES) {
        let length = u64::from_le_bytes(head[1..].try_into().expect("nine bytes less one are eight"));
        let Some(end) = usize::try_from(length).ok().and_then(|l| (at + HEAD_BYTES).checked_add(l)) else {
            break;
        };
        if end > bytes.len() {
            break;
        }
        found.push((head[0], at, end));
        at = end;
    }
    found
}

/// Records missing, twice, exchanged, or with lengths that lie.
fn records(original: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = original.to_vec();
    let all = outer(original);
    let chunks: Vec<_> = all.iter().filter(|(op, ..)| *op == CHUNK).collect();
    if all.is_empty() {
        return bytes;
    }
    let &(_, from, to) = one(random, &all);
    let record = original[from..to].to_vec();
    let lie = *one(random, &[0_u64, 1, 100, 1 << 20, 60 << 20, 1 << 31, 1 << 40, u64::MAX, u64::MAX - 100]);
    match below(random, 6) {
        0 => {
            bytes.drain(from..to);
        }
        1 => {
            bytes.splice(from..from, record);
        }
        2 => {
            let &(_, other, _) = one(random, &all);
            bytes.splice(other..other, record);
        }
        3 => bytes[from + 1..from + HEAD_BYTES].copy_from_slice(&lie.to_le_bytes()),
        4 if !chunks.is_empty() => {
            // Start and end time, then the uncompressed size; then its checksum, which zero switches off.
            let &&(_, chunk, _) = one(random, &chunks);
            let size = chunk + HEAD_BYTES + 16;
            bytes[size..size + 8].copy_from_slice(&lie.to_le_bytes());
            bytes[size + 8..size + 12].fill(0);
        }
        _ => bytes[from] = (random.next_u32() % 20) as u8,
    }
    bytes
}

/// The text of an attachment mutated, its lengths right and its checksum left out.
fn attachment(original: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = original.to_vec();
    let all = outer(original);
    for &(_, from, to) in all.iter().filter(|(op, ..)| *op == DATA_END) {
        bytes[from + HEAD_BYTES..to].fill(0);
    }
    let attached: Vec<_> = all.iter().filter(|(op, ..)| *op == ATTACHMENT).collect();
    if attached.is_empty() {
        return bytes;
    }
    let &&(_, from, to) = one(random, &attached);
    let body = &original[from + HEAD_BYTES..to];
    let length =
        |at: usize| body.get(at..at + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let name_end = 16 + 4 + length(16);
    let type_end = name_end + 4 + length(name_end);
    let text = body[type_end + 8..body.len() - 4].to_vec();
    let way = one(random, TEXT);
    let text = (way.apply)(text, random);
    let mut changed = body[..type_end].to_vec();
    changed.extend((text.len() as u64).to_le_bytes());
    changed.extend(text);
    changed.extend([0; 4]);
    let mut record = vec![ATTACHMENT];
    record.extend((changed.len() as u64).to_le_bytes());
    record.extend(changed);
    bytes.splice(from..to, record);
    bytes
}

/// A message on its way into the new log.
#[derive(Clone)]
enum Item {
    Event(Event),
    Row(usize, Vec<f64>),
}

/// The same log written anew with other rows, events or points: every checksum is right.
fn rewritten(original: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("original.mcap");
    std::fs::write(&path, original).expect("a writable folder");
    let mut reader = LogReader::open(&path).expect("the original is whole");
    let mut windows: Vec<Window> = std::iter::from_fn(|| reader.next_window()).collect();
    let topics: Vec<Topic> =
        windows.first().map(|w| w.topics.iter().map(|r| r.topic.clone()).collect()).unwrap_or_default();
    for _ in 0..1 + below(random, 2) {
        spoil(&mut windows, random);
    }
    let mut items: Vec<(u64, Item)> = windows.iter().flat_map(messages).collect();
    reorder(&mut items, random);
    let attachments: Vec<Attachment> =
        reader.attachments().iter().filter(|a| a.name != "plan.json").cloned().collect();
    let target = folder.path().join("mutated.mcap");
    let file = std::fs::File::create(&target).expect("a writable folder");
    let mut writer =
        LogWriter::new(file, reader.plan(), &topics, &attachments).expect("what was read is writable");
    for (at_ns, item) in &items {
        // What a log cannot hold is left out.
        let _ = match item {
            Item::Event(event) => writer.event(*at_ns, event),
            Item::Row(topic, values) => writer.row(*topic, *at_ns, values),
        };
    }
    drop(writer.finish());
    std::fs::read(&target).expect("it was written")
}

const VALUES: &[f64] =
    &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, 1e300, -1e300, 1e-300, 1e18, 65535.0, -1.0, 0.5];

/// Other rows and other points.
fn spoil(windows: &mut Vec<Window>, random: &mut ChaCha8Rng) {
    if windows.is_empty() {
        return;
    }
    let at = below(random, windows.len());
    match below(random, 7) {
        0 => windows.reverse(),
        1 => {
            let again = windows[at].clone();
            windows.push(again);
        }
        2 => {
            windows.remove(at);
        }
        3 => windows[at].point = *one(random, &[0, 1, 7, 1_000_000, usize::MAX]),
        4 => {
            let window = &mut windows[at];
            window.status = *one(random, &[PointStatus::Aborted, PointStatus::Errored, PointStatus::Lost]);
            let kept = below(random, window.segments.len() + 1);
            window.segments.truncate(kept);
        }
        _ => columns(&mut windows[at], random),
    }
}

/// Values of a channel, or of all, replaced; rows left out.
fn columns(window: &mut Window, random: &mut ChaCha8Rng) {
    if window.topics.is_empty() {
        return;
    }
    let topic = below(random, window.topics.len());
    let rows = &mut window.topics[topic];
    let count = rows.time_s.len();
    let value = *one(random, VALUES);
    match below(random, 4) {
        0 => {
            let kept = *one(random, &[0, 1, 2, 3, 10, 100, count / 2]);
            rows.time_s.truncate(kept);
            rows.columns.iter_mut().for_each(|c| c.truncate(kept));
        }
        1 => rows.columns.iter_mut().for_each(|c| c.fill(value)),
        _ => {
            let channel = below(random, rows.columns.len());
            let from = below(random, count + 1);
            let to = below(random, count + 1);
            if let Some(column) = rows.columns.get_mut(channel) {
                column[from.min(to)..from.max(to)].fill(value);
            }
        }
    }
}

/// Events and rows of a point in the order of time.
fn messages(window: &Window) -> Vec<(u64, Item)> {
    let ns = |t_s: f64| (t_s * 1e9).round() as u64;
    let point = window.point;
    let rows = window.topics.iter().enumerate().flat_map(|(topic, rows)| {
        let row = move |k: usize| Item::Row(topic, rows.columns.iter().map(|c| c[k]).collect());
        rows.time_s.iter().enumerate().map(move |(k, t)| (ns(*t), row(k)))
    });
    let mut inside: Vec<(u64, Item)> = rows.collect();
    for span in &window.segments {
        let segment = span.segment;
        let position_rad = span.start_position_rad;
        inside.push((ns(span.start_s), Item::Event(Event::SegmentStarted { point, segment, position_rad })));
        inside.push((ns(span.end_s), Item::Event(Event::SegmentEnded { point, segment, by: span.ended_by })));
    }
    let rank = |item: &Item| match item {
        Item::Event(Event::SegmentEnded { .. }) => 0,
        Item::Event(_) => 1,
        Item::Row(..) => 2,
    };
    inside.sort_by_key(|(at, item)| (*at, rank(item)));
    let first = inside.first().map_or(1_000_000_000, |(at, _)| *at);
    let last = inside.last().map_or(first, |(at, _)| *at);
    let mut all = vec![(first, Item::Event(Event::PointStarted { point }))];
    all.extend(inside);
    all.push((last, Item::Event(Event::PointEnded { point, status: window.status })));
    all
}

/// Events missing, twice, elsewhere or of other segments; other times.
fn reorder(items: &mut Vec<(u64, Item)>, random: &mut ChaCha8Rng) {
    let events: Vec<usize> = (0..items.len()).filter(|&k| matches!(items[k].1, Item::Event(_))).collect();
    if events.is_empty() {
        return;
    }
    let at = *one(random, &events);
    match below(random, 8) {
        0 => {
            items.remove(at);
        }
        1 => {
            let again = items[at].clone();
            items.insert(at, again);
        }
        2 => {
            let moved = items.remove(at);
            items.insert(below(random, items.len() + 1), moved);
        }
        3 => items.iter_mut().for_each(|(t, _)| *t = 0),
        4 => items.iter_mut().for_each(|(t, _)| *t = t.saturating_mul(1_000_000)),
        5 => {
            if let Item::Event(Event::SegmentStarted { segment, .. } | Event::SegmentEnded { segment, .. }) =
                &mut items[at].1
            {
                *segment = *one(random, &[0, 1, 5, 1_000_000, usize::MAX]);
            }
        }
        6 => {
            if let Item::Event(Event::SegmentEnded { by, .. }) = &mut items[at].1 {
                *by = *one(random, &[EndedBy::Timeout, EndedBy::Condition, EndedBy::Stopped]);
            }
        }
        _ => {}
    }
}

/// A table with as many rows as the smallest cells allow.
pub(super) fn dense_table(random: &mut ChaCha8Rng) -> Vec<u8> {
    let rows = *one(random, &[10_usize, 1000, 300_000, 1_500_000]);
    let mut text = String::from("a,b\n");
    (0..rows).for_each(|k| text.push_str(&format!("{k},{}\n", k % 7)));
    let bytes = text.into_bytes();
    if below(random, 3) == 0 { (one(random, text::TEXT).apply)(bytes, random) } else { bytes }
}
