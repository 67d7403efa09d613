//! What an atmosphere procedure says, and the points: mirror angle to tracker, then the fine loop closed, and open.

use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment, Tracks};
use crate::device::MIRROR_AXES;
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::optics::frames;
use crate::kinds::position::positioned;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default(
        "closed",
        Shape::Quantity(Q::Time),
        "60 s",
        "Duration of the record with the fine loop closed.",
    ),
    Field::default(
        "open",
        Shape::Quantity(Q::Time),
        "60 s",
        "Duration of the record with the fine loop open.",
    ),
    Field::default(
        "segment",
        Shape::Quantity(Q::Time),
        "4 s",
        "Length of the segments of a spectrum: lines are 1/segment apart.",
    ),
    Field::default(
        "frequency",
        Shape::Quantities(Q::Frequency),
        "1 Hz, 1.5 Hz, 2 Hz, 3 Hz, 5 Hz, 8 Hz, 15 Hz",
        "Frequencies at which the rejection is stated.",
    ),
    Field::default("frame-rate", Shape::Quantity(Q::Frequency), "200 Hz", "Frame rate of the fine camera."),
    Field::default(
        "amplitude",
        Shape::Quantity(Q::Angle),
        "300 urad",
        "Amplitude of the mirror's sine that measures the tracker's reading per mirror angle.",
    ),
    Field::default(
        "timing-u",
        Shape::Quantity(Q::Time),
        "0.1 ms",
        "Standard uncertainty of the time between mirror angle and exposure in the log, apart from the \
         spacing of the rows.",
    ),
    frames::AZIMUTH,
    frames::ELEVATION,
];

/// Fewest segments of a spectrum, at half overlap.
const LEAST_SEGMENTS: f64 = 5.0;
/// Spacings of the lines below a frequency that is asked for.
const LEAST_LINES: f64 = 3.0;

/// An atmosphere procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) closed_s: f64,
    pub(super) open_s: f64,
    pub(super) segment_s: f64,
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) frame_rate_hz: f64,
    pub(super) amplitude_rad: f64,
    pub(super) timing_u_s: f64,
    /// Azimuth, elevation.
    pub(super) pose_rad: [f64; 2],
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let closed_s = table.positive("closed");
        let open_s = table.positive("open");
        let segment_s = table.positive("segment");
        for (key, time_s) in [("closed", closed_s), ("open", open_s)] {
            if let (Some(time_s), Some(segment_s)) = (time_s, segment_s)
                && 2.0 * time_s / segment_s < LEAST_SEGMENTS + 1.0
            {
                let help = format!("at least {}", Q::Time.format(0.5 * (LEAST_SEGMENTS + 1.0) * segment_s));
                table.mistake(key, format!("`{key}` is shorter than five segments"), Some(help));
            }
        }
        let frequencies_hz = table.quantities("frequency");
        let frame_rate_hz = table.positive("frame-rate");
        if let (Some(all), Some(segment_s), Some(rate_hz)) = (&frequencies_hz, segment_s, frame_rate_hz) {
            let lowest_hz = LEAST_LINES / segment_s;
            if all.is_empty() || all.iter().any(|f| *f < lowest_hz || *f > 0.35 * rate_hz) {
                let message = "every `frequency` needs three lines below it and a frame rate of at least \
                               three times its value";
                let low = Q::Frequency.format(lowest_hz);
                let high = Q::Frequency.format(0.35 * rate_hz);
                table.mistake("frequency", message, Some(format!("between {low} and {high}")));
            }
        }
        let amplitude = table.positive("amplitude");
        let timing_u = table.quantity("timing-u");
        let pose_rad = frames::pose_rad(table);
        Some(Self {
            closed_s: closed_s?,
            open_s: open_s?,
            segment_s: segment_s?,
            frequencies_hz: frequencies_hz?,
            frame_rate_hz: frame_rate_hz?,
            amplitude_rad: amplitude?,
            timing_u_s: timing_u?.abs(),
            pose_rad: pose_rad?,
        })
    }
}

/// Label of the record.
pub(super) const RECORD: &str = "record";
/// Label of the mirror's sine before the loop is closed.
pub(super) const SINE: &str = "sine";
/// Names of the points.
pub(super) const CLOSED: &str = "closed";
pub(super) const OPEN: &str = "open";

/// Frequency of the mirror's sine: slow against the mirror.
pub(super) const SINE_HZ: f64 = 2.0;
/// Blocks of the sine, of two periods each.
pub(super) const SINE_BLOCKS: usize = 6;
pub(super) const BLOCK_S: f64 = 2.0 / SINE_HZ;
/// The sine grows in this time.
pub(super) const LEAD_S: f64 = 0.5;
/// Rest before a record: the gimbal comes to rest.
const SETTLE_S: f64 = 1.0;
/// The fine loop takes its target up in this time, and its transient is over. Whether it did shows in the record: a loop
/// that loses frames all the time never counts as locked, and what it rejects is asked for all the same.
const ACQUIRE_S: f64 = 2.0;

/// All points, or why the rig does not allow them.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    positioned::check_axes("atmosphere", axis, axes)?;
    let fine = Some(Tracks { fine: true, ..Tracks::default() });
    let acquire = Segment { tracks: fine, ..Segment::hold("acquire", Mode::Position, ACQUIRE_S) };
    let closed = Segment { tracks: fine, ..Segment::hold(RECORD, Mode::Position, keys.closed_s) };
    let open = Segment::hold(RECORD, Mode::Position, keys.open_s);
    let case = |point: &str, segments: Vec<Segment>| Case {
        point: point.to_owned(),
        axis: axis.to_owned(),
        requested: vec![Request {
            name: "frame-rate".to_owned(),
            value: keys.frame_rate_hz,
            kind: Q::Frequency,
        }],
        start_pose_rad: positioned::poses(axes, keys.pose_rad),
        segments: [Segment::hold("settle", Mode::Position, SETTLE_S)].into_iter().chain(segments).collect(),
        logs_payload_fully: true,
        target: Some(frames::star(keys.pose_rad)),
        fine_frame_rate_hz: Some(keys.frame_rate_hz),
        ..Case::default()
    };
    let excitation =
        |mirror_axis: usize| vec![frames::mirror_sine(mirror_axis, SINE_HZ, keys.amplitude_rad, LEAD_S)];
    let sine = |label: &str| {
        let lasts_s = LEAD_S + SINE_BLOCKS as f64 * BLOCK_S;
        Segment { excited: Some(0), ..Segment::hold(label, Mode::Position, lasts_s) }
    };
    let gains = (0..MIRROR_AXES.len()).map(|mirror_axis| {
        let excitations = excitation(mirror_axis);
        Case { excitations, ..case(&gain_point(mirror_axis), vec![sine(RECORD)]) }
    });
    // The sine shows how late the exposures are stated that the loop is closed on.
    let closed = Case { excitations: excitation(0), ..case(CLOSED, vec![sine(SINE), acquire, closed]) };
    Ok(gains.chain([case(OPEN, vec![open]), closed]).collect())
}

/// Name of the point that moves an axis of the mirror.
pub(super) fn gain_point(mirror_axis: usize) -> String {
    format!("mirror {}", MIRROR_AXES[mirror_axis])
}
