//! Import maps: how a table that another tool recorded becomes a log of ours.

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Need, Shape, TableReader, read_file};

use crate::import::map::{ChannelMap, ImportMap, SegmentMap, TimeSource};

const CHANNELS: &[&str] = &[
    "position_rad",
    "velocity_rad_per_s",
    "current_a",
    "torque_nm",
    "torque_command_nm",
    "position_setpoint_rad",
    "current_command_a",
    "load_position_rad",
    "load_velocity_rad_per_s",
    "frequency_hz",
    "response_real",
    "response_imag",
    "coherence",
];

/// Channels of a response that an analyser computed; the first three come together.
const RESPONSE: [&str; 3] = ["frequency_hz", "response_real", "response_imag"];

/// Keys of an import map.
pub(crate) const FIELDS: &[Field] = &[
    field("schema", Shape::Integer, Need::Required, "Version of the format: 1."),
    field("procedure", Shape::Text, Need::Required, "Procedure file that judges the log."),
    field(
        "requirements",
        Shape::Text,
        Need::Default("shipped:requirements.toml"),
        "Requirements that are stored with the log.",
    ),
    field(
        "time",
        Shape::Choice(&["column", "rate", "none"]),
        Need::Required,
        "Where the time of a row comes from.",
    ),
    field("time-column", Shape::Text, Need::Optional, "Column of the time, for `time = \"column\"`."),
    field("time-unit", Shape::Choice(&["s", "ms", "us"]), Need::Default("s"), "Unit of that column."),
    field("rate", Shape::Quantity(K::Frequency), Need::Optional, "Rows per second, for `time = \"rate\"`."),
    field("channel", Shape::Tables(CHANNEL), Need::Required, "Channels of the log, each from one column."),
    field(
        "segment",
        Shape::Tables(SEGMENT),
        Need::Required,
        "Segments of the record in order, each from rows of a table.",
    ),
    field("axis", Shape::Table(AXIS), Need::Optional, "Known data of the axis."),
];

const CHANNEL: &[Field] = &[
    field("channel", Shape::Choice(CHANNELS), Need::Required, "Channel of the log."),
    field("column", Shape::Text, Need::Required, "Column of the table."),
    field(
        "unit",
        Shape::Text,
        Need::Required,
        "Unit of the column, e.g. `rev`, `deg`, `A`, `mA`, `N*m`, `Hz`; `1` for ratios and responses.",
    ),
    field(
        "scale",
        Shape::Quantity(K::Ratio),
        Need::Default("1"),
        "Factor from the number in the column to its unit.",
    ),
];

const SEGMENT: &[Field] = &[
    field("file", Shape::Text, Need::Required, "CSV file with one header line, beside the map."),
    field(
        "beside",
        Shape::Text,
        Need::Optional,
        "A second CSV file with the same rows, whose columns are added to those of the first.",
    ),
    field("point", Shape::Text, Need::Required, "Name of the point."),
    field(
        "branch",
        Shape::Text,
        Need::Required,
        "Label of the segment: `forward`, `reverse`, or `record` for `imported-response`.",
    ),
    field("rows", Shape::Text, Need::Optional, "Data rows to take, 1-based, e.g. `1 .. 512`."),
    field("from", Shape::Quantity(K::Time), Need::Optional, "Rows before this time are left out."),
    field("velocity", Shape::Quantity(K::AngularVelocity), Need::Optional, "Velocity that was commanded."),
];

const AXIS: &[Field] = &[
    field(
        "torque-constant",
        Shape::Quantity(K::TorqueConstant),
        Need::Optional,
        "Torque constant, which converts current into torque.",
    ),
    field("inertia", Shape::Quantity(K::Inertia), Need::Optional, "Inertia, for the J·α term."),
    field(
        "cogging-order",
        Shape::Quantity(K::SpatialOrder),
        Need::Optional,
        "Expected periods per revolution.",
    ),
];

const fn field(key: &'static str, shape: Shape, need: Need, doc: &'static str) -> Field {
    Field { key, shape, need, doc }
}

/// Reads an import map.
///
/// # Errors
/// All mistakes at once.
pub(crate) fn read_map(source: SourceFile) -> Result<ImportMap, Vec<Diagnostic>> {
    let mut map = read_file(&source, FIELDS, read)?;
    map.source = source;
    Ok(map)
}

#[derive(Default)]
struct KnownAxis {
    torque_constant: Option<f64>,
    inertia: Option<f64>,
    order: Option<f64>,
}

fn read(t: &mut TableReader<'_>) -> Option<ImportMap> {
    let procedure = t.text("procedure");
    let requirements = t.text("requirements");
    let time = read_time(t);
    let channels = t.tables("channel", read_channel);
    whole_response(t, channels.as_deref().unwrap_or_default(), time.as_ref());
    let segments = t.tables("segment", read_segment);
    let axis = t
        .table("axis", |t| {
            Some(KnownAxis {
                torque_constant: t.positive("torque-constant"),
                inertia: t.quantity("inertia"),
                order: t.positive("cogging-order"),
            })
        })
        .unwrap_or_default();
    Some(ImportMap {
        procedure: procedure?,
        requirements: requirements?,
        time: time?,
        channels: channels?,
        segments: segments?,
        torque_constant_nm_per_a: axis.torque_constant,
        inertia_kg_m2: axis.inertia.unwrap_or(0.0),
        cogging_orders_per_rev: axis.order.unwrap_or(1.0),
        source: SourceFile { name: String::new(), text: String::new() },
    })
}

fn read_time(t: &mut TableReader<'_>) -> Option<TimeSource> {
    let unit = t.text("time-unit");
    let column = t.text("time-column");
    let rate = t.positive("rate");
    match t.text("time")?.as_str() {
        "column" => {
            let scale_s = match unit.as_deref() {
                Some("ms") => 1e-3,
                Some("us") => 1e-6,
                _ => 1.0,
            };
            if column.is_none() {
                t.mistake("time", "`time = \"column\"` needs `time-column`", None);
            }
            Some(TimeSource::Column { column: column?, scale_s })
        }
        "rate" => {
            if rate.is_none() {
                t.mistake("time", "`time = \"rate\"` needs `rate`", None);
            }
            Some(TimeSource::Rate { rate_hz: rate? })
        }
        _ => Some(TimeSource::None),
    }
}

/// Refuses a response of which a part is missing.
fn whole_response(t: &mut TableReader<'_>, channels: &[ChannelMap], time: Option<&TimeSource>) {
    let has = |name: &str| channels.iter().any(|c| c.channel == name);
    if !has("coherence") && !RESPONSE.iter().any(|name| has(name)) {
        return;
    }
    for missing in RESPONSE.iter().filter(|name| !has(name)) {
        let message =
            format!("a response needs the channels {}, but `{missing}` is missing", RESPONSE.join(", "));
        t.mistake("channel", message, Some("convert gain and phase into real and imaginary part".to_owned()));
    }
    if time.is_some_and(|time| *time != TimeSource::None) {
        let help = "its rows are frequencies: write `time = \"none\"`".to_owned();
        t.mistake("time", "a response has no time", Some(help));
    }
}

fn read_channel(t: &mut TableReader<'_>) -> Option<ChannelMap> {
    let channel = t.text("channel");
    let column = t.text("column");
    let unit = t.text("unit");
    let scale = t.quantity("scale");
    let channel = channel?;
    let unit = unit?;
    let kind = kind_of_channel(&channel);
    // A ratio has no unit to write; that of a response is output over input, whatever they are.
    let written = if kind == K::Ratio && unit == "1" { "" } else { unit.as_str() };
    let Ok(unit_si) = kind.parse(&format!("1 {written}")) else {
        let message =
            format!("`{unit}` is not a unit of {channel}; expected one such as `{}`", kind.si_unit());
        t.mistake("unit", message, None);
        return None;
    };
    Some(ChannelMap { channel, column: column?, scale_factor: unit_si * scale? })
}

fn kind_of_channel(channel: &str) -> K {
    match channel {
        "current_a" | "current_command_a" => K::Current,
        "torque_nm" | "torque_command_nm" => K::Torque,
        "velocity_rad_per_s" | "load_velocity_rad_per_s" => K::AngularVelocity,
        "frequency_hz" => K::Frequency,
        "response_real" | "response_imag" | "coherence" => K::Ratio,
        _ => K::Angle,
    }
}

fn read_segment(t: &mut TableReader<'_>) -> Option<SegmentMap> {
    let file = t.text("file");
    let point = t.text("point");
    let branch = t.text("branch");
    let beside = t.text("beside");
    let from_s = t.quantity("from");
    let velocity_rad_per_s = t.quantity("velocity");
    let rows = match t.text("rows") {
        None => None,
        Some(text) => {
            let parsed = text
                .split_once("..")
                .and_then(|(a, b)| Some([a.trim().parse::<u64>().ok()?, b.trim().parse::<u64>().ok()?]))
                .filter(|[a, b]| *a >= 1 && a <= b);
            if parsed.is_none() {
                t.mistake("rows", format!("expected rows such as `1 .. 512`, found `{text}`"), None);
                return None;
            }
            parsed
        }
    };
    Some(SegmentMap { file: file?, beside, point: point?, branch: branch?, rows, from_s, velocity_rad_per_s })
}
