//! What a rig file says of the devices on the gimbal: inertial unit, mirror, trackers.

use drivers::kvh::{Format, KvhSettings, Synchronisation};
use drivers::mirror::{MirrorSettings, Path};
use drivers::tracker::{Source, TrackerSettings};
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Need, Shape, TableReader};

/// Time allowed for an answer on a serial line.
const ANSWER_TIMEOUT_S: f64 = 0.2;

/// Devices on the gimbal; those that a rig lacks are `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PayloadSettings {
    /// Inertial measurement unit.
    pub imu: Option<KvhSettings>,
    /// Fast steering mirror.
    pub mirror: Option<MirrorSettings>,
    /// Coarse tracker.
    pub coarse: Option<TrackerSettings>,
    /// Fine tracker.
    pub fine: Option<TrackerSettings>,
}

const fn with_default(key: &'static str, shape: Shape, default: &'static str, doc: &'static str) -> Field {
    Field { key, shape, need: Need::Default(default), doc }
}

/// Keys of `[imu]`.
pub(super) const IMU_FIELDS: &[Field] = &[
    with_default("baud", Shape::Integer, "4147200", "Bit rate of the line; 4 kHz messages need 4147200."),
    with_default(
        "format",
        Shape::Choice(&["A", "B", "C"]),
        "A",
        "Output format: B adds the unit's own time, C the magnetic field.",
    ),
];

/// Keys of `[mirror]`.
pub(super) const MIRROR_FIELDS: &[Field] = &[
    with_default("command", Shape::Choice(&["analog", "serial"]), "analog", "Way of the commands."),
    with_default("scale", Shape::Quantity(K::AngleScale), "500 urad/V", "Mirror angle per volt, both ways."),
    with_default(
        "stroke",
        Shape::Quantity(K::Angle),
        "1.05 mrad",
        "Commands stay within plus and minus this.",
    ),
];

/// Keys of `[tracker.coarse]` and `[tracker.fine]`.
const TRACKER_FIELDS: &[Field] = &[
    Field {
        key: "ifov-x",
        shape: Shape::Quantity(K::Angle),
        need: Need::Required,
        doc: "Angle of a pixel along x.",
    },
    Field {
        key: "ifov-y",
        shape: Shape::Quantity(K::Angle),
        need: Need::Required,
        doc: "Angle of a pixel along y.",
    },
    with_default(
        "x-is",
        Shape::Choice(&["cross-elevation", "elevation"]),
        "cross-elevation",
        "Which angle moves the image along x; y is the other one (erratum E26: the coarse camera is rotated).",
    ),
];

/// Keys of `[tracker]`.
pub(super) const TRACKERS_FIELDS: &[Field] = &[
    Field {
        key: "coarse",
        shape: Shape::Table(TRACKER_FIELDS),
        need: Need::Optional,
        doc: "Infrared camera.",
    },
    Field {
        key: "fine",
        shape: Shape::Table(TRACKER_FIELDS),
        need: Need::Optional,
        doc: "CCD behind the mirror.",
    },
];

/// Reads the devices' tables.
pub(super) fn read(t: &mut TableReader<'_>, loop_rate_hz: f64) -> PayloadSettings {
    let imu = t.has("imu").then(|| t.table("imu", |t| read_imu(t, loop_rate_hz))).flatten();
    let mirror = t.has("mirror").then(|| t.table("mirror", read_mirror)).flatten();
    let mut payload = PayloadSettings { imu, mirror, ..PayloadSettings::default() };
    if t.has("tracker") {
        t.table("tracker", |t| {
            payload.coarse = read_tracker(t, "coarse", Source::Coarse);
            payload.fine = read_tracker(t, "fine", Source::Fine);
            Some(())
        });
    }
    payload
}

fn read_imu(t: &mut TableReader<'_>, loop_rate_hz: f64) -> Option<KvhSettings> {
    let (baud, format) = (t.integer("baud", 9600), t.text("format"));
    Some(KvhSettings {
        name: "imu".to_owned(),
        baud: u32::try_from(baud?).ok()?,
        format: match format?.as_str() {
            "B" => Format::B,
            "C" => Format::C,
            _ => Format::A,
        },
        // One message per tick: the loop's own pulse makes it.
        synchronisation: Synchronisation::External,
        message_rate_hz: loop_rate_hz,
        rate_output: true,
        answer_timeout_s: ANSWER_TIMEOUT_S,
    })
}

fn read_mirror(t: &mut TableReader<'_>) -> Option<MirrorSettings> {
    let (command, scale, stroke) = (t.text("command"), t.positive("scale"), t.positive("stroke"));
    Some(MirrorSettings {
        name: "fsm".to_owned(),
        scale_rad_per_v: [scale?; 2],
        stroke_rad: [stroke?; 2],
        command: if command? == "serial" { Path::Serial } else { Path::Analog },
        feedback: Path::Analog,
        command_outputs: [0, 1],
        feedback_inputs: [0, 1],
        reply_timeout_s: ANSWER_TIMEOUT_S,
    })
}

fn read_tracker(t: &mut TableReader<'_>, key: &'static str, source: Source) -> Option<TrackerSettings> {
    if !t.has(key) {
        return None;
    }
    t.table(key, |t| {
        let (x, y, x_is) = (t.positive("ifov-x"), t.positive("ifov-y"), t.text("x-is"));
        let map = if x_is? == "elevation" { [[0.0, 1.0], [1.0, 0.0]] } else { [[1.0, 0.0], [0.0, 1.0]] };
        Some(TrackerSettings { name: key.to_owned(), source, ifov_rad: [x?, y?], map })
    })
}
