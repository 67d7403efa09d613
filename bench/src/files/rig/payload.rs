//! What a rig file says of the devices on the gimbal (inertial unit, mirror, trackers) and of the instruments.

use drivers::analyser::AnalyserSettings;
use drivers::kvh::{Format, KvhSettings, Synchronisation};
use drivers::mirror::{MirrorSettings, Path};
use drivers::scope::ScopeSettings;
use drivers::tracker::{Source, TrackerSettings};
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Need, Shape, TableReader};

use crate::model::device::{BystanderSettings, ClampSettings, ForceSettings, PayloadSettings};

/// Time allowed for an answer on a serial line.
const ANSWER_TIMEOUT_S: f64 = 0.2;

/// Time allowed for an answer of an instrument on the network.
const INSTRUMENT_TIMEOUT_S: f64 = 2.0;

/// Usual frame rates of the coarse and the fine tracker (study 3.2.4).
const FRAME_RATES_HZ: [f64; 2] = [50.0, 200.0];

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
    Field::optional(
        "data-rate",
        Shape::Quantity(K::Frequency),
        "The unit's own rate of messages, for a tick that is faster than its line; without it each tick makes one.",
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
    with_default(
        "reference-scale",
        Shape::Quantity(K::AngleScale),
        "200 urad/V",
        "Mirror tilt per volt of the autocollimator on analog inputs 2 and 3.",
    ),
];

/// Keys of `[analyser]`.
pub(super) const ANALYSER_FIELDS: &[Field] = &[
    with_default(
        "azimuth-relay",
        Shape::Integer,
        "1",
        "Value of handler port A that connects the azimuth axis of the mirror and disconnects its amplifier.",
    ),
    with_default("elevation-relay", Shape::Integer, "2", "The same for elevation; 0 connects none."),
];

/// Keys of `[supply]`.
pub(super) const SUPPLY_FIELDS: &[Field] = &[with_default(
    "clamp-range",
    Shape::Quantity(K::Current),
    "100 A",
    "Current that the clamps on supply and shunt of the DC link (analog inputs 7 and 8) show as 10 V.",
)];

/// Keys of `[force-gauge]`.
pub(super) const FORCE_FIELDS: &[Field] = &[with_default(
    "range",
    Shape::Quantity(K::Force),
    "2000 N",
    "Pull that the force gauge (analog input 9) shows as 10 V.",
)];

/// Keys of `[scope]`.
pub(super) const SCOPE_FIELDS: &[Field] = &[
    with_default(
        "azimuth-channel",
        Shape::Integer,
        "1",
        "Channel of the current probe on the azimuth motor.",
    ),
    with_default(
        "elevation-channel",
        Shape::Integer,
        "3",
        "Channel of the current probe on the elevation motor.",
    ),
    with_default(
        "sync-channel",
        Shape::Integer,
        "2",
        "Channel of the synchronisation signal, analog output 2.",
    ),
    with_default(
        "current-range",
        Shape::Quantity(K::Current),
        "50 A",
        "Motor currents up to plus and minus this are on the screen.",
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
    Field {
        key: "frame-rate",
        shape: Shape::Quantity(K::Frequency),
        need: Need::Optional,
        doc: "Frames per second; 50 Hz (coarse) or 200 Hz (fine) if left out.",
    },
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
    let (mirror, bystanders) = mirror.unzip();
    let analyser = t.has("analyser").then(|| t.table("analyser", read_analyser)).flatten();
    let scope = t.has("scope").then(|| t.table("scope", read_scope)).flatten();
    let clamps = t.has("supply").then(|| t.table("supply", read_clamps)).flatten();
    let force = t.has("force-gauge").then(|| t.table("force-gauge", read_force)).flatten();
    let mut payload = PayloadSettings {
        imu,
        mirror,
        bystanders,
        clamps,
        force,
        analyser,
        scope,
        ..PayloadSettings::default()
    };
    if t.has("tracker") {
        t.table("tracker", |t| {
            let coarse = read_tracker(t, "coarse", Source::Coarse);
            let fine = read_tracker(t, "fine", Source::Fine);
            payload.frame_rates_hz =
                [0, 1].map(|k| [&coarse, &fine][k].as_ref().map_or(0.0, |found| found.1));
            (payload.coarse, payload.fine) = (coarse.map(|found| found.0), fine.map(|found| found.0));
            Some(())
        });
    }
    payload
}

fn read_imu(t: &mut TableReader<'_>, loop_rate_hz: f64) -> Option<KvhSettings> {
    let (baud, format) = (t.integer("baud", 9600), t.text("format"));
    let own_rate_hz = if t.has("data-rate") { Some(t.positive("data-rate")?) } else { None };
    Some(KvhSettings {
        name: "imu".to_owned(),
        baud: u32::try_from(baud?).ok()?,
        format: match format?.as_str() {
            "B" => Format::B,
            "C" => Format::C,
            _ => Format::A,
        },
        // One message per tick: the loop's own pulse makes it, unless that is too fast for the line.
        synchronisation: own_rate_hz
            .map_or(Synchronisation::External, |hz| Synchronisation::Internal(hz.round() as u32)),
        message_rate_hz: own_rate_hz.unwrap_or(loop_rate_hz),
        rate_output: true,
        answer_timeout_s: ANSWER_TIMEOUT_S,
    })
}

/// The mirror, and what hangs on the same analog card.
fn read_mirror(t: &mut TableReader<'_>) -> Option<(MirrorSettings, BystanderSettings)> {
    let (command, scale, stroke) = (t.text("command"), t.positive("scale"), t.positive("stroke"));
    let bystanders = BystanderSettings {
        reference_scale_rad_per_v: t.positive("reference-scale")?,
        reference_inputs: [2, 3],
        sync_output: 2,
        echo_output: 3,
        echo_input: 4,
    };
    let mirror = MirrorSettings {
        name: "fsm".to_owned(),
        scale_rad_per_v: [scale?; 2],
        stroke_rad: [stroke?; 2],
        command: if command? == "serial" { Path::Serial } else { Path::Analog },
        feedback: Path::Analog,
        command_outputs: [0, 1],
        feedback_inputs: [0, 1],
        reply_timeout_s: ANSWER_TIMEOUT_S,
    };
    Some((mirror, bystanders))
}

fn read_clamps(t: &mut TableReader<'_>) -> Option<ClampSettings> {
    const FULL_SCALE_V: f64 = 10.0;
    Some(ClampSettings { inputs: [7, 8], scale_a_per_v: t.positive("clamp-range")? / FULL_SCALE_V })
}

fn read_force(t: &mut TableReader<'_>) -> Option<ForceSettings> {
    const FULL_SCALE_V: f64 = 10.0;
    Some(ForceSettings { input: 9, scale_n_per_v: t.positive("range")? / FULL_SCALE_V })
}

fn read_analyser(t: &mut TableReader<'_>) -> Option<AnalyserSettings> {
    let (az, el) = (t.integer("azimuth-relay", 0), t.integer("elevation-relay", 0));
    let relay = [u8::try_from(az?), u8::try_from(el?)];
    let [Ok(az), Ok(el)] = relay else {
        t.mistake("azimuth-relay", "handler port A has eight bits", Some("values 0 to 255".to_owned()));
        return None;
    };
    Some(AnalyserSettings {
        name: "analyser".to_owned(),
        relay: [az, el],
        reply_timeout_s: INSTRUMENT_TIMEOUT_S,
    })
}

fn read_scope(t: &mut TableReader<'_>) -> Option<ScopeSettings> {
    let (az, el) = (t.integer("azimuth-channel", 1), t.integer("elevation-channel", 1));
    let (sync, range_a) = (t.integer("sync-channel", 1), t.positive("current-range"));
    let channels = [az?, el?, sync?];
    let [az, el, sync] = channels;
    if channels.iter().any(|channel| *channel > 4) || az == el || az == sync || el == sync {
        let help = "channels are 1 to 4, one for each signal".to_owned();
        t.mistake("sync-channel", "the signals do not have a channel each", Some(help));
        return None;
    }
    let channel = |channel: i64| u8::try_from(channel).ok();
    Some(ScopeSettings {
        name: "scope".to_owned(),
        current_channels: [channel(az)?, channel(el)?],
        sync_channel: channel(sync)?,
        current_range_a: range_a?,
        reply_timeout_s: INSTRUMENT_TIMEOUT_S,
    })
}

/// A tracker and its frame rate.
fn read_tracker(
    t: &mut TableReader<'_>,
    key: &'static str,
    source: Source,
) -> Option<(TrackerSettings, f64)> {
    if !t.has(key) {
        return None;
    }
    t.table(key, |t| {
        let (x, y, x_is) = (t.positive("ifov-x"), t.positive("ifov-y"), t.text("x-is"));
        let map = if x_is? == "elevation" { [[0.0, 1.0], [1.0, 0.0]] } else { [[1.0, 0.0], [0.0, 1.0]] };
        let usual_hz = FRAME_RATES_HZ[usize::from(source == Source::Fine)];
        let frame_rate_hz = if t.has("frame-rate") { t.positive("frame-rate")? } else { usual_hz };
        Some((TrackerSettings { name: key.to_owned(), source, ifov_rad: [x?, y?], map }, frame_rate_hz))
    })
}
