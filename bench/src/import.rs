//! Import: turns tables that another tool recorded into a log that `rejudge` can judge.

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

/// Log time of the first row. It is not zero, because zero means "no time" to some readers.
const LOG_EPOCH_S: f64 = 1.0;
/// Pause between two segments in log time: their own times are unrelated.
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

/// Reads the tables that `map` names and writes the log into `folder`. Returns the path of the log.
///
/// The procedure that judges the log and its requirements are attached to it.
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

/// One table per segment of the map, in the order of the segments; or the mistakes of all tables.
fn read_tables(map: &ImportMap) -> Result<Vec<Columns>, Vec<Diagnostic>> {
    let mut tables = Vec::new();
    let mut mistakes = Vec::new();
    // Limits the values and bytes that all segments together may read.
    let mut taken = columns::Taken::default();
    for segment in &map.segments {
        match columns::read(map, segment, &mut taken) {
            Ok(columns) => tables.push(columns),
            Err(mistake) => mistakes.push(*mistake),
        }
    }
    if mistakes.is_empty() { Ok(tables) } else { Err(mistakes) }
}

/// The only topic of the log: all channels of the map.
fn topic(axis: &str, map: &ImportMap) -> Topic {
    let channel =
        |name: &str| Channel { name: name.to_owned(), unit: unit(name).to_owned(), width: Width::F64 };
    Topic {
        name: format!("/{axis}"),
        message: "bench_msgs/msg/Imported".to_owned(),
        channels: map.channels.iter().map(|c| channel(&c.channel)).collect(),
    }
}

/// SI unit of a channel. Channels that are not listed are angles.
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

/// Names of the points, each once, in the order of their first segments.
fn points(map: &ImportMap) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for segment in &map.segments {
        if !names.contains(&segment.point.as_str()) {
            names.push(&segment.point);
        }
    }
    names
}

/// The plan as if the bench had run the record. Rows without a constant rate get that of the median time step.
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

/// The case of one point. Only labels and durations of its segments are real: what was commanded is not known.
fn case(map: &ImportMap, axis: &str, point: &str, tables: &[Columns]) -> Case {
    let of_point = || map.segments.iter().zip(tables).filter(|(segment, _)| segment.point == point);
    let segments = of_point().map(|(segment, table)| Segment {
        label: segment.branch.clone(),
        mode: Mode::Position,
        stimulus: Stimulus::Hold { torque_nm: 0.0 },
        until: None,
        at_most_s: table.duration_s(),
        then: Then::Next,
        dithered: false,
        ..Segment::default()
    });
    let velocity_rad_per_s = of_point().find_map(|(segment, _)| segment.velocity_rad_per_s);
    let request = |value| Request { name: "velocity".to_owned(), value, kind: QuantityKind::AngularVelocity };
    Case {
        point: point.to_owned(),
        axis: axis.to_owned(),
        requested: velocity_rad_per_s.map(request).into_iter().collect(),
        start_pose_rad: BTreeMap::new(),
        segments: segments.collect(),
        ..Case::default()
    }
}

/// What is known of the axis, for the analysis only: nothing is going to move. The travel is the range of the record; other
/// limits are so wide that they never apply, and what is not known is zero.
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
        measured_constant: None,
        inertia_kg_m2: map.inertia_kg_m2,
        inertia_u_ratio: 0.0,
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

/// Writes all rows and events, point by point. Between segments and between points [`GAP_S`] of log time pass.
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
        let of_point = map.segments.iter().zip(tables).filter(|(segment, _)| segment.point == case.point);
        for (segment, (_, table)) in of_point.enumerate() {
            let position_rad = table.first("position_rad", map);
            writer.event(ns(start_s), &Event::SegmentStarted { point, segment, position_rad })?;
            for (row, t_s) in table.time_s.iter().enumerate() {
                writer.row(0, ns(start_s + t_s), &table.row(row))?;
            }
            // The segment ends one time step after its last row, so that the row lies within it.
            start_s += table.duration_s();
            writer.event(ns(start_s), &Event::SegmentEnded { point, segment, by: EndedBy::Completed })?;
            start_s += GAP_S;
        }
        writer.event(ns(start_s), &Event::PointEnded { point, status: PointStatus::Completed })?;
        start_s += GAP_S;
    }
    Ok(())
}
