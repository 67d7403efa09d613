//! Import: a table that another tool recorded becomes a log that `rejudge` takes.

use std::collections::BTreeMap;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use procedures::axis::{Axes, AxisLimits};
use procedures::case::{Case, Mode, Request, Segment, Then};
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::log::{Channel, EndedBy, Event, LogError, LogWriter, Plan, PointStatus, Topic, Width};
use procedures::procedure::Procedure;
use procedures::quantity::QuantityKind;
use procedures::stimulus::Stimulus;

use crate::record::log::{self, IMPORTED, attachment};

mod columns;
pub(crate) mod map;
mod table;

use columns::Columns;
use map::{ImportMap, TimeSource};

/// Log time of the first row: see the runner's epoch.
const LOG_EPOCH_S: f64 = 1.0;
/// Time between two segments, whose own clocks are unrelated.
const GAP_S: f64 = 1.0;

/// Why an import failed.
#[derive(Debug)]
pub(crate) enum ImportError {
    /// Mistakes in the map, the procedure or a table: exit 2.
    Mistakes(Vec<Diagnostic>),
    /// The log cannot be written: exit 4.
    Output(LogError),
}

impl From<Vec<Diagnostic>> for ImportError {
    fn from(found: Vec<Diagnostic>) -> Self {
        Self::Mistakes(found)
    }
}

impl From<LogError> for ImportError {
    fn from(error: LogError) -> Self {
        Self::Output(error)
    }
}

/// Reads the tables that `map` names and writes the log into `folder`, with the procedure that judges it and its
/// requirements; returns its path.
///
/// # Errors
/// See [`ImportError`]. Nothing is written before everything was read.
pub(crate) fn import(
    map: &ImportMap,
    procedure: &Procedure,
    requirements: &SourceFile,
    folder: &Path,
) -> Result<PathBuf, ImportError> {
    let tables = read_tables(map)?;
    let plan = plan(map, procedure, &tables);
    let attachments = [
        attachment(log::PROCEDURE, &procedure.source.text),
        attachment(log::REQUIREMENTS, &requirements.text),
        attachment("import.toml", &map.source.text),
    ];
    let path = folder.join(format!("{}.mcap", procedure.id));
    let file = std::fs::File::create_new(&path)
        .map_err(|source| LogError::Io { file: path.display().to_string(), source })?;
    let topics = [topic(&procedure.axis, map)];
    let mut writer = LogWriter::new(BufWriter::new(file), &plan, &topics, &attachments)?.in_large_chunks();
    write(&mut writer, map, &plan, &tables)?;
    writer.finish()?;
    Ok(path)
}

fn read_tables(map: &ImportMap) -> Result<Vec<Columns>, Vec<Diagnostic>> {
    let mut tables = Vec::new();
    let mut mistakes = Vec::new();
    let mut taken = columns::Taken::default();
    for segment in &map.segments {
        match columns::read(map, segment, &mut taken) {
            Ok(columns) => tables.push(columns),
            Err(mistake) => mistakes.push(*mistake),
        }
    }
    if mistakes.is_empty() { Ok(tables) } else { Err(mistakes) }
}

fn topic(axis: &str, map: &ImportMap) -> Topic {
    let channel =
        |name: &str| Channel { name: name.to_owned(), unit: unit(name).to_owned(), width: Width::F64 };
    Topic {
        name: format!("/{axis}"),
        message: "bench_msgs/msg/Imported".to_owned(),
        channels: map.channels.iter().map(|c| channel(&c.channel)).collect(),
    }
}

fn unit(channel: &str) -> &'static str {
    match channel {
        "current_a" | "current_command_a" => "A",
        "velocity_rad_per_s" | "load_velocity_rad_per_s" => "rad/s",
        "frequency_hz" => "Hz",
        "response_real" | "response_imag" | "coherence" => "1",
        "torque_nm" | "torque_command_nm" => "N*m",
        _ => "rad",
    }
}

/// Points in order of their first segment.
fn points(map: &ImportMap) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for segment in &map.segments {
        if !names.contains(&segment.point.as_str()) {
            names.push(&segment.point);
        }
    }
    names
}

fn plan(map: &ImportMap, procedure: &Procedure, tables: &[Columns]) -> Plan {
    let cases = points(map).into_iter().map(|point| case(map, &procedure.axis, point, tables)).collect();
    let rate_hz = match map.time {
        TimeSource::Rate { rate_hz } => rate_hz,
        TimeSource::Column { .. } | TimeSource::None => 1.0 / columns::median_step_s(tables),
    };
    Plan {
        schema: 1,
        procedure: procedure.id.clone(),
        axis: procedure.axis.clone(),
        seed: 0,
        loop_rate_hz: rate_hz,
        log_rate_hz: rate_hz,
        command_delay_ticks: 0,
        axes: Axes::stacked([(procedure.axis.clone(), limits(map, tables))]),
        cases,
        mode: IMPORTED.to_owned(),
    }
}

fn case(map: &ImportMap, axis: &str, point: &str, tables: &[Columns]) -> Case {
    let own = || map.segments.iter().zip(tables).filter(|(s, _)| s.point == point);
    let segments = own().map(|(s, t)| Segment {
        label: s.branch.clone(),
        mode: Mode::Position,
        stimulus: Stimulus::Hold { torque_nm: 0.0 },
        until: None,
        at_most_s: t.duration_s(),
        then: Then::Next,
        dithered: false,
        ..Segment::default()
    });
    let velocity = own().find_map(|(s, _)| s.velocity_rad_per_s);
    let request = |value| Request { name: "velocity".to_owned(), value, kind: QuantityKind::AngularVelocity };
    Case {
        point: point.to_owned(),
        axis: axis.to_owned(),
        requested: velocity.map(request).into_iter().collect(),
        start_pose_rad: BTreeMap::new(),
        segments: segments.collect(),
        ..Case::default()
    }
}

/// What is known of the axis; limits are as wide as the record, because nothing is going to move.
fn limits(map: &ImportMap, tables: &[Columns]) -> AxisLimits {
    let travel_rad = columns::span(map, tables, "position_rad");
    AxisLimits {
        travel_rad,
        soft_limits_rad: travel_rad,
        max_velocity_rad_per_s: 1e6,
        max_acceleration_rad_per_s2: 1e6,
        max_jerk_rad_per_s3: 1e6,
        max_torque_nm: 1e6,
        torque_constant_nm_per_a: map.torque_constant_nm_per_a,
        torque_constant_u_ratio: 0.0,
        inertia_kg_m2: map.inertia_kg_m2,
        torque_quantum_nm: 0.0,
        encoder_quantum_rad: 0.0,
        expected_static_friction_nm: 0.0,
        expected_presliding_stiffness_nm_per_rad: 0.0,
        polarity_torque_nm: 0.0,
        zero_tolerance_rad: 0.0,
        loop_rate_hz: 0.0,
        log_rate_hz: 0.0,
        cogging_orders_per_rev: map.cogging_orders_per_rev,
        reference: None,
    }
}

fn write<W: std::io::Write + std::io::Seek>(
    writer: &mut LogWriter<W>,
    map: &ImportMap,
    plan: &Plan,
    tables: &[Columns],
) -> Result<(), LogError> {
    let mut start_s = LOG_EPOCH_S;
    let ns = |t_s: f64| (t_s * 1e9).round() as u64;
    for (point, case) in plan.cases.iter().enumerate() {
        writer.event(ns(start_s), &Event::PointStarted { point })?;
        let own = map.segments.iter().zip(tables).filter(|(s, _)| s.point == case.point);
        for (segment, (_, table)) in own.enumerate() {
            let position_rad = table.first("position_rad", map);
            writer.event(ns(start_s), &Event::SegmentStarted { point, segment, position_rad })?;
            for (row, t_s) in table.time_s.iter().enumerate() {
                writer.row(0, ns(start_s + t_s), &table.row(row))?;
            }
            // One step beyond the last row, so that the segment holds it.
            start_s += table.duration_s();
            writer.event(ns(start_s), &Event::SegmentEnded { point, segment, by: EndedBy::Completed })?;
            start_s += GAP_S;
        }
        writer.event(ns(start_s), &Event::PointEnded { point, status: PointStatus::Completed })?;
        start_s += GAP_S;
    }
    Ok(())
}
