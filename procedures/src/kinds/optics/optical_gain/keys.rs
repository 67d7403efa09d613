//! What an optical gain procedure says, and how it is read.

use crate::kinds::optics::frames::MIRROR_AXES;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default(
        "frame-rate",
        Shape::Quantities(Q::Frequency),
        "100 Hz, 200 Hz",
        "Frame rates of the fine camera.",
    ),
    Field::default(
        "amplitude",
        Shape::Quantities(Q::Angle),
        "100 urad, 500 urad",
        "Amplitudes of the mirror's sine.",
    ),
    Field::default("frequency", Shape::Quantity(Q::Frequency), "2 Hz", "Frequency of the mirror's sine."),
    Field::default(
        "duration",
        Shape::Quantity(Q::Time),
        "8 s",
        "Time of each sine that counts, at least five blocks of two periods.",
    ),
    Field::default(
        "gain-az",
        Shape::Quantity(Q::Ratio),
        "3.5355",
        "Gain of azimuth that the fine loop is built for.",
    ),
    Field::default(
        "gain-el",
        Shape::Quantity(Q::Ratio),
        "2.5",
        "Gain of elevation that the fine loop is built for.",
    ),
    Field::default(
        "scale-u",
        Shape::Quantity(Q::Ratio),
        "0.5 %",
        "Relative standard uncertainty of the angle of a pixel in the rig file.",
    ),
    Field::default(
        "azimuth",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Where the azimuth axis holds: on the target.",
    ),
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Where the elevation axis holds."),
];

/// Periods of a block.
pub(super) const BLOCK_PERIODS: f64 = 2.0;
/// Fewest blocks that have a scatter.
const LEAST_BLOCKS: f64 = 5.0;

/// An optical gain procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) frame_rates_hz: Vec<f64>,
    pub(super) amplitudes_rad: Vec<f64>,
    pub(super) frequency_hz: f64,
    pub(super) duration_s: f64,
    /// In the order of the mirror's axes.
    pub(super) gains_ratio: [f64; MIRROR_AXES.len()],
    pub(super) scale_u_ratio: f64,
    /// Azimuth, elevation.
    pub(super) pose_rad: [f64; 2],
}

impl Keys {
    /// Reads the kind's keys; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let frame_rates_hz = positive(table, "frame-rate");
        let amplitudes_rad = positive(table, "amplitude");
        let frequency_hz = table.positive("frequency");
        let duration_s = table.positive("duration");
        let az = table.quantity("gain-az");
        let el = table.quantity("gain-el");
        for (key, gain) in [("gain-az", az), ("gain-el", el)] {
            if gain == Some(0.0) {
                table.mistake(key, format!("`{key}` must not be zero"), None);
            }
        }
        if let (Some(frequency_hz), Some(duration_s)) = (frequency_hz, duration_s)
            && duration_s * frequency_hz < LEAST_BLOCKS * BLOCK_PERIODS
        {
            let message = "`duration` holds fewer than five blocks of two periods";
            let help = format!("at least {}", Q::Time.format(LEAST_BLOCKS * BLOCK_PERIODS / frequency_hz));
            table.mistake("duration", message, Some(help));
        }
        if let (Some(rates), Some(frequency_hz)) = (&frame_rates_hz, frequency_hz)
            && rates.iter().any(|rate_hz| *rate_hz < 5.0 * frequency_hz)
        {
            table.mistake("frame-rate", "every period needs at least five frames", None);
        }
        let scale_u_ratio = table.quantity("scale-u");
        let azimuth = table.quantity("azimuth");
        let elevation = table.quantity("elevation");
        Some(Self {
            frame_rates_hz: frame_rates_hz?,
            amplitudes_rad: amplitudes_rad?,
            frequency_hz: frequency_hz?,
            duration_s: duration_s?,
            gains_ratio: [az?, el?],
            scale_u_ratio: scale_u_ratio?.abs(),
            pose_rad: [azimuth?, elevation?],
        })
    }
}

fn positive(table: &mut TableReader<'_>, key: &'static str) -> Option<Vec<f64>> {
    let values = table.quantities(key)?;
    if values.is_empty() || values.iter().any(|v| *v <= 0.0) {
        table.mistake(key, format!("`{key}` needs values greater than zero"), None);
    }
    Some(values)
}
