//! What an optical gain procedure says, and the points: each axis of the mirror at each frame rate and amplitude.

use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment};
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
        "Evaluated time of each sine, at least five blocks of two periods.",
    ),
    Field::default(
        "gain-az",
        Shape::Quantity(Q::Ratio),
        "3.5355",
        "Gain of azimuth that the fine loop assumes.",
    ),
    Field::default(
        "gain-el",
        Shape::Quantity(Q::Ratio),
        "2.5",
        "Gain of elevation that the fine loop assumes.",
    ),
    Field::default(
        "scale-u",
        Shape::Quantity(Q::Ratio),
        "0.5 %",
        "Relative standard uncertainty of the pixel angle in the rig file.",
    ),
    frames::AZIMUTH,
    frames::ELEVATION,
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

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
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
            let message = "`duration` is shorter than five blocks of two periods";
            let help = format!("at least {}", Q::Time.format(LEAST_BLOCKS * BLOCK_PERIODS / frequency_hz));
            table.mistake("duration", message, Some(help));
        }
        if let (Some(rates), Some(frequency_hz)) = (&frame_rates_hz, frequency_hz)
            && rates.iter().any(|rate_hz| *rate_hz < 5.0 * frequency_hz)
        {
            table.mistake("frame-rate", "every period needs at least five frames", None);
        }
        let scale_u_ratio = table.quantity("scale-u");
        let pose_rad = frames::pose_rad(table);
        Some(Self {
            frame_rates_hz: frame_rates_hz?,
            amplitudes_rad: amplitudes_rad?,
            frequency_hz: frequency_hz?,
            duration_s: duration_s?,
            gains_ratio: [az?, el?],
            scale_u_ratio: scale_u_ratio?.abs(),
            pose_rad: pose_rad?,
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

/// Label of the sine.
pub(super) const SINE: &str = "sine";
const SETTLE: &str = "settle";
/// Rest before the sine: the gimbal comes to rest, the tracker finds its target.
const SETTLE_S: f64 = 0.5;
/// The sine grows in this time; it does not count.
pub(super) const LEAD_S: f64 = 0.5;

/// All points, or why the rig does not allow them.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    positioned::check_axes("optical-gain", axis, axes)?;
    let mut cases = Vec::new();
    for mirror_axis in 0..MIRROR_AXES.len() {
        for &frame_rate_hz in &keys.frame_rates_hz {
            for &amplitude_rad in &keys.amplitudes_rad {
                let asked = [frame_rate_hz, amplitude_rad];
                cases.push(Case {
                    axis: axis.to_owned(),
                    start_pose_rad: positioned::poses(axes, keys.pose_rad),
                    ..case(keys, mirror_axis, asked)
                });
            }
        }
    }
    Ok(cases)
}

fn case(keys: &Keys, mirror_axis: usize, [frame_rate_hz, amplitude_rad]: [f64; 2]) -> Case {
    let request = |name: &str, value, kind| Request { name: name.to_owned(), value, kind };
    let sine = Segment { excited: Some(0), ..Segment::hold(SINE, Mode::Position, LEAD_S + keys.duration_s) };
    Case {
        point: format!(
            "{} {} {}",
            MIRROR_AXES[mirror_axis],
            Q::Frequency.format(frame_rate_hz),
            format_args!("{:.0} urad", 1e6 * amplitude_rad)
        ),
        requested: vec![
            request("frame-rate", frame_rate_hz, Q::Frequency),
            request("amplitude", amplitude_rad, Q::Angle),
        ],
        segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), sine],
        excitations: vec![frames::mirror_sine(mirror_axis, keys.frequency_hz, amplitude_rad, LEAD_S)],
        logs_payload_fully: true,
        target: Some(frames::star(keys.pose_rad)),
        fine_frame_rate_hz: Some(frame_rate_hz),
        ..Case::default()
    }
}
