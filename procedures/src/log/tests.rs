//! The log as a whole: what is written is read, by us and by others, and damage is found and named.

use std::io::Cursor;

use proptest::prelude::*;

use super::*;
use crate::axis::Axes;

mod damage;

/// Two axes and the bench, with every width and padding between fields.
fn topics() -> Vec<Topic> {
    let channel = |(name, unit, width): (&str, &str, Width)| Channel {
        name: name.to_owned(),
        unit: unit.to_owned(),
        width,
    };
    let topic = |name: &str, message: &str, channels: &[(&str, &str, Width)]| Topic {
        name: name.to_owned(),
        message: message.to_owned(),
        channels: channels.iter().copied().map(channel).collect(),
    };
    let axis = [
        ("position_rad", "rad", Width::F64),
        ("torque_nm", "N*m", Width::F64),
        ("temperature_degc", "degC", Width::F32),
        ("position_count", "count", Width::I32),
        ("status_word", "", Width::U16),
        ("mode", "", Width::I8),
    ];
    let bench = [("mode", "", Width::I8), ("cycle_count", "count", Width::U32), ("late_s", "s", Width::F64)];
    vec![
        topic("/az", "bench_msgs/msg/Axis", &axis),
        topic("/el", "bench_msgs/msg/Axis", &axis),
        topic("/bench", "bench_msgs/msg/Bench", &bench),
    ]
}

fn plan() -> Plan {
    Plan {
        schema: PLAN_SCHEMA,
        procedure: "AZ-FRICTION".to_owned(),
        axis: "az".to_owned(),
        seed: 0xFFFF_FFFF_FFFF_FFFF,
        loop_rate_hz: 4000.0,
        log_rate_hz: 1000.0,
        command_delay_ticks: 1,
        axes: Axes::default(),
        cases: Vec::new(),
        mode: "simulated".to_owned(),
    }
}

fn procedure() -> Attachment {
    Attachment { name: "procedure.toml".to_owned(), text: "id = \"AZ-FRICTION\" # µ\n".to_owned() }
}

/// Values that every width of `/az` holds exactly.
fn axis_row(k: u32) -> [f64; 6] {
    let k = f64::from(k);
    [0.1 * k, -200.0 / (k + 1.0), 31.25, 1000.0 * k - 7.0, 567.0, -3.0]
}

const MS: u64 = 1_000_000;

/// Writes one point: 1 kHz, two segments, the second ended by its condition; rows before and after belong to no point.
fn write_point(
    log: &mut LogWriter<Cursor<Vec<u8>>>,
    point: usize,
    start_ns: u64,
    rows: u32,
) -> Result<(), LogError> {
    let half_ns = start_ns + u64::from(rows / 2) * MS;
    let end_ns = start_ns + u64::from(rows) * MS;
    log.row(0, start_ns, &axis_row(9999))?;
    log.event(start_ns, &Event::PointStarted { point })?;
    log.event(start_ns, &Event::SegmentStarted { point, segment: 0, position_rad: 0.25 })?;
    for k in 0..rows {
        let now_ns = start_ns + u64::from(k) * MS;
        if now_ns == half_ns {
            log.event(now_ns, &Event::SegmentEnded { point, segment: 0, by: EndedBy::Completed })?;
            log.event(now_ns, &Event::SegmentStarted { point, segment: 1, position_rad: 0.1 + 0.2 })?;
        }
        log.row(0, now_ns, &axis_row(k))?;
        log.row(1, now_ns, &axis_row(k + 1))?;
        if k % 10 == 0 {
            log.row(2, now_ns, &[1.0, f64::from(k), 1e-6])?;
        }
    }
    log.event(end_ns, &Event::SegmentEnded { point, segment: 1, by: EndedBy::Condition })?;
    log.event(end_ns, &Event::PointEnded { point, status: PointStatus::Completed })?;
    log.row(0, end_ns, &axis_row(9999))
}

fn started() -> LogWriter<Cursor<Vec<u8>>> {
    LogWriter::new(Cursor::new(Vec::new()), &plan(), &topics(), &[procedure()])
        .expect("memory takes everything")
}

fn finished(log: LogWriter<Cursor<Vec<u8>>>) -> Vec<u8> {
    log.finish().expect("memory takes everything").into_inner()
}

/// Two points of this many rows.
fn two_points(rows: u32) -> Vec<u8> {
    let mut log = started();
    write_point(&mut log, 0, 1000 * MS, rows).expect("memory takes everything");
    write_point(&mut log, 1, 5000 * MS, rows).expect("memory takes everything");
    finished(log)
}

fn open(bytes: &[u8]) -> Result<LogReader, LogError> {
    LogReader::from_source("a.mcap".to_owned(), Box::new(Cursor::new(bytes.to_vec())), bytes.len() as u64)
}

fn windows(bytes: &[u8]) -> (Vec<Window>, Option<String>) {
    let mut log = open(bytes).expect("the log begins as it should");
    let windows = std::iter::from_fn(|| log.next_window()).collect();
    (windows, log.damage().map(ToString::to_string))
}

#[test]
fn what_is_written_is_read() {
    let bytes = two_points(600);
    let log = open(&bytes).expect("the log is whole");
    assert_eq!(log.plan(), &plan());
    assert_eq!(log.attachments()[0].name, "plan.json");
    assert_eq!(log.attachments()[1..], [procedure()]);
    let (windows, damage) = windows(&bytes);
    assert_eq!(damage, None);
    assert_eq!(
        windows.iter().map(|w| (w.point, w.status)).collect::<Vec<_>>(),
        [(0, PointStatus::Completed), (1, PointStatus::Completed)]
    );
    let second = &windows[1];
    assert_eq!(second.topics.iter().map(|r| r.topic.clone()).collect::<Vec<_>>(), topics());
    assert_eq!(second.topics.iter().map(|r| r.time_s.len()).collect::<Vec<_>>(), [600, 600, 60]);
    let az = second.rows("/az").expect("the topic was written");
    assert_eq!(az.time_s[599], 5.599);
    for (channel, column) in az.columns.iter().enumerate() {
        assert!((0..600).all(|k| column[k as usize] == axis_row(k)[channel]), "channel {channel}");
    }
    let late = second.rows("/bench").and_then(|r| r.column("late_s")).expect("the channel was written");
    assert!(late.iter().all(|&v| v == 1e-6));
}

#[test]
fn segments_lie_where_their_events_stand() {
    let (windows, _) = windows(&two_points(600));
    let start_position_rad = 0.1 + 0.2;
    let ended_by = EndedBy::Condition;
    let second = SegmentSpan { segment: 1, start_s: 1.3, end_s: 1.6, start_position_rad, ended_by };
    assert_eq!(windows[0].segments.len(), 2);
    assert_eq!(windows[0].segments[1], second);
    let az = windows[0].rows("/az").expect("the topic was written");
    assert_eq!(az.range(second.start_s, second.end_s), 300..600);
}

#[test]
fn a_segment_without_end_ends_with_the_last_row() {
    let mut log = started();
    let tripped = "expected |v| <= 1 rad/s, found 1.2 rad/s".to_owned();
    let events = [
        Event::PointStarted { point: 4 },
        Event::SegmentStarted { point: 4, segment: 0, position_rad: 0.0 },
        Event::Tripped { point: 4, interlock: "velocity".to_owned(), reason: tripped },
        Event::PointEnded { point: 4, status: PointStatus::Aborted },
    ];
    for (k, event) in events.iter().enumerate() {
        log.event(k as u64 * 10 * MS, event).expect("memory takes everything");
        log.row(0, (k as u64 * 10 + 5) * MS, &axis_row(0)).expect("memory takes everything");
    }
    let (windows, damage) = windows(&finished(log));
    assert_eq!(damage, None);
    assert_eq!(windows[0].status, PointStatus::Aborted);
    assert_eq!(windows[0].trips, ["velocity: expected |v| <= 1 rad/s, found 1.2 rad/s"]);
    assert_eq!(windows[0].segments[0].ended_by, EndedBy::Stopped);
    assert_eq!((windows[0].segments[0].start_s, windows[0].segments[0].end_s), (0.010, 0.025));
}

#[test]
fn the_same_rows_give_the_same_bytes_and_one_changed_sample_does_not() {
    let bytes = two_points(600);
    assert!(bytes == two_points(600));
    let changed = |value: f64| {
        let mut log = started();
        log.row(0, 0, &[value, 0.0, 0.0, 0.0, 0.0, 0.0]).expect("memory takes everything");
        finished(log)
    };
    assert!(changed(1.0) != changed(1.0_f64.next_up()));
}

#[test]
fn chunks_reach_the_sink_every_quarter_second_of_log_time() {
    let mut log = started();
    for k in 0..1000 {
        log.row(0, 7000 * MS + k * MS, &axis_row(k as u32)).expect("memory takes everything");
    }
    let bytes = finished(log);
    let summary = mcap::Summary::read(&bytes).expect("the summary is whole").expect("there is a summary");
    let spans: Vec<u64> =
        summary.chunk_indexes.iter().map(|c| c.message_end_time - c.message_start_time).collect();
    assert_eq!(spans, [249 * MS; 4]);
    assert_eq!(summary.chunk_indexes[0].compression, "zstd");
}

#[test]
fn rows_without_time_close_chunks_by_size() {
    let mut log = started();
    for k in 0..200_000 {
        log.row(0, 0, &axis_row(k)).expect("memory takes everything");
    }
    let bytes = finished(log);
    let summary = mcap::Summary::read(&bytes).expect("the summary is whole").expect("there is a summary");
    assert!(summary.chunk_indexes.len() > 1);
    assert!(summary.chunk_indexes.iter().all(|c| c.uncompressed_size < (9 << 20)));
}

#[test]
fn slow_rows_in_large_chunks_are_no_chunk_each() {
    let mut log = started().in_large_chunks();
    for k in 0..1000 {
        log.row(0, k * 1000 * MS, &axis_row(k as u32)).expect("memory takes everything");
    }
    let bytes = finished(log);
    let summary = mcap::Summary::read(&bytes).expect("the summary is whole").expect("there is a summary");
    assert_eq!(summary.chunk_indexes.len(), 1);
}

#[test]
fn what_cannot_be_written_is_refused_in_words() {
    let refused = |result: Result<(), LogError>| result.expect_err("this has a mistake").to_string();
    let new = |plan: &Plan, topics: &[Topic], attachments: &[Attachment]| {
        LogWriter::new(Cursor::new(Vec::new()), plan, topics, attachments).map(drop)
    };
    let endless = Plan { loop_rate_hz: f64::INFINITY, ..plan() };
    let twice = [topics()[0].clone(), topics()[0].clone()];
    let nowhere = Event::SegmentStarted { point: 0, segment: 0, position_rad: f64::NAN };
    let messages = [
        refused(new(&endless, &topics(), &[])),
        refused(new(&plan(), &twice, &[])),
        refused(new(&plan(), &topics(), &[procedure(), procedure()])),
        refused(started().row(3, 0, &[])),
        refused(started().row(0, 0, &[1.0])),
        refused(started().event(0, &nowhere)),
    ];
    insta::assert_snapshot!(messages.join("\n"), @r#"
    AZ-FRICTION.mcap: a number that JSON does not know: invalid type: null, expected f64 at line 1 column 97: `{"schema":1,"procedure":"AZ-FRICTION","axis":"az","seed":18446744073709551615,"loop_rate_hz":null`
    AZ-FRICTION.mcap: two topics `/az`
    AZ-FRICTION.mcap: two attachments `procedure.toml`
    AZ-FRICTION.mcap: expected a topic below 3, found 3
    AZ-FRICTION.mcap: topic 0: expected 6 values a row, found 1
    AZ-FRICTION.mcap: a number that JSON does not know: invalid type: null, expected f64: `{"event":"segment-started","point":0,"segment":0,"position_rad":null}`
    "#);
}

/// Every value as the reader gives it, in the words of `print.py`.
fn printed(rows: &Rows) -> Vec<String> {
    let value = |k: usize, channel: usize| {
        let time = rows.time_s[k].to_bits();
        let value = rows.columns[channel][k].to_bits();
        format!("{} {} {time:016x} {value:016x}", rows.topic.name, rows.topic.channels[channel].name)
    };
    let channels = rows.columns.len();
    (0..rows.time_s.len())
        .flat_map(|k| (0..channels).map(move |c| (k, c)))
        .map(|(k, c)| value(k, c))
        .collect()
}

/// The snapshot was given to Python's `mcap` 1.6.0 and `mcap-ros2-support` 0.6.0 with checksums on, which printed
/// `written.txt` (by `tests/data/log/print.py`, where the command stands). When the snapshot changes, do that again.
#[test]
fn python_decodes_the_very_bits_that_the_reader_gives() {
    let mut log = started();
    log.event(MS, &Event::PointStarted { point: 0 }).expect("memory takes everything");
    for k in 0..3 {
        log.row(0, (300 * u64::from(k) + 1) * MS, &axis_row(k)).expect("memory takes everything");
        log.row(2, (300 * u64::from(k) + 2) * MS, &[-1.0, 4e9, 1e-6]).expect("memory takes everything");
    }
    log.event(700 * MS, &Event::PointEnded { point: 0, status: PointStatus::Completed })
        .expect("memory takes it");
    let bytes = finished(log);
    let (windows, damage) = windows(&bytes);
    assert_eq!(damage, None);
    insta::assert_binary_snapshot!("written.mcap", bytes);
    let python = include_str!("../../../tests/data/log/written.txt");
    let (rows, others): (Vec<&str>, Vec<&str>) = python.lines().partition(|l| l.split(' ').count() == 5);
    let rows: Vec<String> =
        rows.iter().filter_map(|l| l.rsplit_once(' ')).map(|(l, _)| l.to_owned()).collect();
    let of =
        |topic: &str| rows.iter().filter(|l| l.split(' ').next() == Some(topic)).cloned().collect::<Vec<_>>();
    for topic in &windows[0].topics {
        assert_eq!(printed(topic), of(&topic.topic.name));
    }
    assert_eq!(rows.len(), 3 * (6 + 3));
    insta::assert_snapshot!(others.join("\n"), @r"
    attachment plan.json application/json
    attachment procedure.toml application/toml
    /events point-started
    /events point-ended
    ");
}

#[test]
fn a_writer_moves_to_a_recorder_thread() {
    fn is_send<T: Send>(_: &T) {}
    is_send(&started());
    is_send(&open(&two_points(10)).expect("the log is whole"));
}

proptest! {
    #[test]
    fn rows_of_any_values_come_back(values in prop::collection::vec(any::<f64>(), 6), time_ns in 0_u64..1 << 60) {
        let mut log = started();
        log.event(time_ns, &Event::PointStarted { point: 0 }).expect("memory takes everything");
        log.row(1, time_ns, &values).expect("memory takes everything");
        log.event(time_ns, &Event::PointEnded { point: 0, status: PointStatus::Completed }).expect("memory takes everything");
        let (windows, damage) = windows(&finished(log));
        prop_assert_eq!(damage, None);
        let rows = &windows[0].topics[1];
        prop_assert_eq!(rows.time_s[0], time_ns as f64 / 1e9);
        prop_assert_eq!(rows.columns[0][0].to_bits(), values[0].to_bits());
        prop_assert_eq!(rows.columns[2][0], f64::from(values[2] as f32));
        prop_assert_eq!(rows.columns[5][0], f64::from(values[5].round() as i8));
    }
}

/// Whether a value is of the types and has the fields that our schema of events says.
fn fits(value: &serde_json::Value, schema: &serde_json::Value, root: &serde_json::Value) -> bool {
    if let Some(place) = schema["$ref"].as_str() {
        let at = place.strip_prefix('#').expect("in this file");
        return fits(value, root.pointer(at).expect("a definition"), root);
    }
    if let Some(constant) = schema.get("const") {
        return value == constant;
    }
    if let Some(all) = schema["enum"].as_array() {
        return all.contains(value);
    }
    let named = |name: &str| match name {
        "string" => value.is_string(),
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64(),
        "number" => value.is_number(),
        "object" => value.as_object().is_some_and(|fields| {
            let known = schema["properties"].as_object().expect("an object has properties");
            let required = schema["required"].as_array().expect("and says which must be there");
            fields.len() == known.len()
                && required.len() == known.len()
                && known.iter().all(|(key, of)| fields.get(key).is_some_and(|value| fits(value, of, root)))
        }),
        "array" => value.as_array().is_some_and(|items| {
            items.len() as u64 == schema["maxItems"].as_u64().expect("an array has its length")
                && items.iter().all(|item| fits(item, &schema["items"], root))
        }),
        other => panic!("no type `{other}`"),
    };
    match &schema["type"] {
        serde_json::Value::Array(names) => names.iter().filter_map(serde_json::Value::as_str).any(named),
        one => named(one.as_str().expect("a type")),
    }
}

fn one_of_each_event() -> Vec<Event> {
    let stop = StopRecord {
        point: 0,
        axis: "az".to_owned(),
        manner: StopManner::LinkLimited,
        from_rad: 0.1,
        from_rad_per_s: 1.0,
        computed_angle_rad: 0.5,
        computed_s: None,
        reached_angle_rad: 0.4,
        took_s: 0.7,
        to_rad: 0.5,
        room_rad: 2.0,
        standstill: true,
    };
    let left = FinalState {
        point: 0,
        axis: "el".to_owned(),
        state: "switch on disabled".to_owned(),
        held: false,
        position_rad: 0.2,
        swing_to_rad: Some(0.1),
        swing_rad_per_s: None,
    };
    vec![
        Event::PointStarted { point: 0 },
        Event::SegmentStarted { point: 0, segment: 1, position_rad: 0.1 },
        Event::SegmentEnded { point: 0, segment: 1, by: EndedBy::Timeout },
        Event::Tripped { point: 0, interlock: "position".to_owned(), reason: "az".to_owned() },
        Event::Stopped(stop),
        Event::Left(left),
        Event::RingHalfFull { point: 0 },
        Event::Stall { point: 0, stall: Stall { length_s: 0.0126, missed_periods: 50 } },
        Event::Notice { point: 0, station: 1, what: "emergency 2310h, over-current".to_owned() },
        Event::DeviceNotice { point: 0, what: "imu: messages: heard again after 300.00 ms".to_owned() },
        Event::Lateness { point: 0, histogram: Box::default() },
        Event::PointEnded { point: 0, status: PointStatus::Lost },
    ]
}

#[test]
fn every_event_fits_its_part_of_the_schema_that_the_log_carries() {
    let schema: serde_json::Value = serde_json::from_str(EVENTS_SCHEMA).expect("the constant is JSON");
    let parts = schema["oneOf"].as_array().expect("one part an event");
    let events = one_of_each_event();
    assert_eq!(events.len(), parts.len());
    for (event, part) in events.iter().zip(parts) {
        let mut value = serde_json::to_value(event).expect("an event has a JSON form");
        assert!(fits(&value, part, &schema), "{value} {part}");
        assert_eq!(parts.iter().filter(|part| fits(&value, part, &schema)).count(), 1, "{value}");
        value["more"] = serde_json::json!(1);
        assert!(!fits(&value, part, &schema), "a field that the schema does not know");
    }
}

#[test]
fn rows_of_every_tick_of_a_stop_take_the_place_of_means_that_end_with_them() {
    let topic = |name: &str| Topic {
        name: name.to_owned(),
        message: "bench_msgs/msg/Axis".to_owned(),
        channels: vec![Channel {
            name: "position_rad".to_owned(),
            unit: "rad".to_owned(),
            width: Width::F64,
        }],
    };
    let topics = [topic("/az"), topic("/az/stop")];
    let mut writer = LogWriter::new(Cursor::new(Vec::new()), &plan(), &topics, &[]).expect("a log in memory");
    writer.event(0, &Event::PointStarted { point: 0 }).expect("it is written");
    // Means over four ticks of 1 ms, and every tick from 9 to 13 ms.
    for ms in 1..=20_u64 {
        if (9..=13).contains(&ms) {
            writer.row(1, ms * 1_000_000, &[100.0 + ms as f64]).expect("it is written");
        }
        if ms % 4 == 0 {
            writer.row(0, ms * 1_000_000, &[ms as f64]).expect("it is written");
        }
    }
    writer
        .event(21_000_000, &Event::PointEnded { point: 0, status: PointStatus::Completed })
        .expect("it is written");
    let bytes = writer.finish().expect("it is whole").into_inner();
    let size = bytes.len() as u64;
    let mut log =
        LogReader::from_source("a.mcap".to_owned(), Box::new(Cursor::new(bytes)), size).expect("a log");
    let window = log.next_window().expect("a point");
    assert!(log.next_window().is_none() && log.damage().is_none());
    assert_eq!(window.topics.len(), 1, "an axis has one topic in a window");
    let rows = window.rows("/az").expect("the axis");
    assert_eq!(rows.columns[0], [4.0, 8.0, 109.0, 110.0, 111.0, 112.0, 113.0, 16.0, 20.0]);
    assert!(rows.time_s.is_sorted());
}
