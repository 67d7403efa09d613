//! What an atmosphere procedure says, and how it is read.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default("closed", Shape::Quantity(Q::Time), "60 s", "Time with the fine loop closed."),
    Field::default("open", Shape::Quantity(Q::Time), "60 s", "Time with the fine loop open."),
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
        "Where the rejection is stated.",
    ),
    Field::default("frame-rate", Shape::Quantity(Q::Frequency), "200 Hz", "Frame rate of the fine camera."),
    Field::default(
        "amplitude",
        Shape::Quantity(Q::Angle),
        "300 urad",
        "Amplitude of the mirror's sine that shows what the tracker makes of a mirror angle.",
    ),
    Field::default(
        "timing-u",
        Shape::Quantity(Q::Time),
        "0.1 ms",
        "Standard uncertainty of the time between the mirror's angle and an exposure in the log, rows not counted.",
    ),
    Field::default(
        "azimuth",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Where the azimuth axis holds: on the target.",
    ),
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Where the elevation axis holds."),
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

impl Keys {
    /// Reads the kind's keys; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let closed_s = table.positive("closed");
        let open_s = table.positive("open");
        let segment_s = table.positive("segment");
        for (key, time_s) in [("closed", closed_s), ("open", open_s)] {
            if let (Some(time_s), Some(segment_s)) = (time_s, segment_s)
                && 2.0 * time_s / segment_s < LEAST_SEGMENTS + 1.0
            {
                let help = format!("at least {}", Q::Time.format(0.5 * (LEAST_SEGMENTS + 1.0) * segment_s));
                table.mistake(key, format!("`{key}` holds fewer than five segments"), Some(help));
            }
        }
        let frequencies_hz = table.quantities("frequency");
        let frame_rate_hz = table.positive("frame-rate");
        if let (Some(all), Some(segment_s), Some(rate_hz)) = (&frequencies_hz, segment_s, frame_rate_hz) {
            let lowest_hz = LEAST_LINES / segment_s;
            if all.is_empty() || all.iter().any(|f| *f < lowest_hz || *f > 0.35 * rate_hz) {
                let message =
                    "every `frequency` needs three lines below it and a frame rate of three times itself";
                let low = Q::Frequency.format(lowest_hz);
                let high = Q::Frequency.format(0.35 * rate_hz);
                table.mistake("frequency", message, Some(format!("between {low} and {high}")));
            }
        }
        let amplitude = table.positive("amplitude");
        let timing_u = table.quantity("timing-u");
        let azimuth = table.quantity("azimuth");
        let elevation = table.quantity("elevation");
        Some(Self {
            closed_s: closed_s?,
            open_s: open_s?,
            segment_s: segment_s?,
            frequencies_hz: frequencies_hz?,
            frame_rate_hz: frame_rate_hz?,
            amplitude_rad: amplitude?,
            timing_u_s: timing_u?.abs(),
            pose_rad: [azimuth?, elevation?],
        })
    }
}
