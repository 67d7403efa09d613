//! What a tracker latency procedure says, and how it is read.

use crate::kinds::ReadKeys;
use crate::kinds::optics::frames;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default(
        "tracker",
        Shape::Choice(&["fine", "coarse"]),
        "fine",
        "Tracker to measure; the mirror moves for the fine tracker, the axis for the coarse one.",
    ),
    Field::default(
        "frequency",
        Shape::Quantities(Q::Frequency),
        "2 Hz, 5 Hz, 11 Hz, 17 Hz, 23 Hz, 31 Hz",
        "Frequencies of the sines: multiples of 1/period below half the frame rate, at least five.",
    ),
    Field::default("period", Shape::Quantity(Q::Time), "1 s", "After this time the motion repeats."),
    Field::default(
        "periods",
        Shape::Integer,
        "12",
        "Evaluated periods, at least six; one more precedes them.",
    ),
    Field::default(
        "amplitude",
        Shape::Quantity(Q::Angle),
        "40 urad",
        "Amplitude of each sine of the mirror.",
    ),
    Field::default(
        "rate",
        Shape::Quantity(Q::AngularVelocity),
        "4 mrad/s",
        "Amplitude of each sine of the axis.",
    ),
    Field::optional(
        "frame-rate",
        Shape::Quantity(Q::Frequency),
        "Frame rate: the fine camera runs at it (default: that of the rig file), the coarse camera must be found to run at it \
         (default: any).",
    ),
    Field::default(
        "moved-delay",
        Shape::Quantity(Q::Time),
        "0 s",
        "Delay in the log of the angle that moves; for an encoder the return part of LAT-RT.",
    ),
    Field::default(
        "moved-delay-u",
        Shape::Quantity(Q::Time),
        "0.1 ms",
        "Standard uncertainty of `moved-delay`.",
    ),
    frames::AZIMUTH,
    frames::ELEVATION,
];

/// Fewest sines of a slope.
pub(super) const LEAST_LINES: usize = 5;
/// Fewest periods that have a scatter.
const LEAST_PERIODS: i64 = 6;

/// A tracker latency procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) is_fine: bool,
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) period_s: f64,
    pub(super) periods: u32,
    pub(super) amplitude_rad: f64,
    pub(super) rate_rad_per_s: f64,
    pub(super) frame_rate_hz: Option<f64>,
    pub(super) moved_delay_s: f64,
    pub(super) moved_delay_u_s: f64,
    /// Azimuth, elevation.
    pub(super) pose_rad: [f64; 2],
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let tracker = table.text("tracker");
        let frequencies_hz = table.quantities("frequency");
        let period_s = table.positive("period");
        let periods = table.count("periods", LEAST_PERIODS);
        let frame_rate_hz = table.has("frame-rate").then(|| table.positive("frame-rate")).flatten();
        if let (Some(all), Some(period_s)) = (&frequencies_hz, period_s) {
            let orders: Vec<f64> = all.iter().map(|f| f * period_s).collect();
            let rises = orders.windows(2).all(|pair| pair[0] < pair[1]);
            if orders.iter().any(|o| *o < 0.5 || (o - o.round()).abs() > 1e-6) || !rises {
                let message = "every `frequency` must be a multiple of 1/period, larger than the one before";
                table.mistake("frequency", message, None);
            }
            if orders.len() < LEAST_LINES {
                let message = format!("{} sines, but a slope needs at least five", orders.len());
                table.mistake("frequency", message, None);
            }
            if let (Some(rate_hz), Some(last)) = (frame_rate_hz, all.last())
                && *last > 0.45 * rate_hz
            {
                table.mistake("frequency", "sines must stay below half the frame rate", None);
            }
        }
        let amplitude = table.positive("amplitude");
        let rate = table.positive("rate");
        let delay = table.quantity("moved-delay");
        let delay_u = table.quantity("moved-delay-u");
        let pose_rad = frames::pose_rad(table);
        Some(Self {
            is_fine: tracker? == "fine",
            frequencies_hz: frequencies_hz?,
            period_s: period_s?,
            periods: periods?,
            amplitude_rad: amplitude?,
            rate_rad_per_s: rate?,
            frame_rate_hz,
            moved_delay_s: delay?,
            moved_delay_u_s: delay_u?.abs(),
            pose_rad: pose_rad?,
        })
    }
}

impl Keys {
    /// Word for the tracker.
    pub(super) fn tracker(&self) -> &'static str {
        if self.is_fine { "fine" } else { "coarse" }
    }
}
