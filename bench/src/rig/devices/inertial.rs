//! What inertial units of all makes have in common: the errors that the rig file declares, and means between two rows.

use drivers::wire::lines::LineAddress;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use crate::model::device::DeviceEntry;
use crate::rig::driver::Misfit;

/// Key of the rate of messages that the unit sends by its own clock.
pub(crate) const DATA_RATE: &str = "data-rate";

/// Beyond this share of the other axis' motion the gyros could no longer tell a frozen encoder from a moving axis.
const MOST_CROSS_AXIS_RATIO: f64 = 0.1;
/// Beyond this bias they could not, either: 50 ms of it are 50 urad.
const MOST_BIAS_RAD_PER_S: f64 = 1e-3;

/// Share of the motion of one axis that shows as motion of another.
pub(super) const CROSS_AXIS_ERROR: Field = Field::default(
    "cross-axis-error",
    Shape::Quantity(K::Ratio),
    "4 %",
    "Share of the motion of one axis that the unit may show as motion of the other, from errors of \
     mount and scale. An encoder counts as frozen only beyond it.",
);

/// Rate at rest.
pub(super) const fn rate_bias(default: &'static str) -> Field {
    Field::default(
        "rate-bias",
        Shape::Quantity(K::AngularVelocity),
        default,
        "Rate that the unit may show at rest, without that of the Earth. An encoder counts as frozen only beyond it.",
    )
}

/// Errors that are too large for the interlocks.
pub(super) fn check_errors(entry: &DeviceEntry) -> Vec<Misfit> {
    let mut all = Vec::new();
    let cross_axis_ratio = entry.number("cross-axis-error");
    if !(0.0..=MOST_CROSS_AXIS_RATIO).contains(&cross_axis_ratio) {
        let most = K::Ratio.format(MOST_CROSS_AXIS_RATIO);
        let message = format!(
            "`cross-axis-error` must be from 0 to {most}, found {}",
            K::Ratio.format(cross_axis_ratio)
        );
        let help = "realign a unit with a larger error: with it the encoders could not be monitored";
        all.push(Misfit { key: "cross-axis-error", message, help: Some(help.to_owned()) });
    }
    let bias_rad_per_s = entry.number("rate-bias");
    if !(0.0..=MOST_BIAS_RAD_PER_S).contains(&bias_rad_per_s) {
        let most = K::AngularVelocity.format(MOST_BIAS_RAD_PER_S);
        let found = K::AngularVelocity.format(bias_rad_per_s);
        let message = format!("`rate-bias` must be from 0 to {most}, found {found}");
        all.push(Misfit { key: "rate-bias", message, help: None });
    }
    all
}

/// A bit rate below the slowest of the unit, or other than that of its serial port.
pub(super) fn check_baud(entry: &DeviceEntry, slowest: i64) -> Vec<Misfit> {
    let baud = entry.integer("baud");
    let mut all = Vec::new();
    if !(slowest..=i64::from(u32::MAX)).contains(&baud) {
        let message = format!("`baud` must be at least {slowest}, found {baud}");
        all.push(Misfit { key: "baud", message, help: None });
    }
    let on_line = entry.lines().find_map(|line| match line {
        LineAddress::Serial { baud, .. } => Some(i64::from(baud)),
        _ => None,
    });
    if let Some(on_line) = on_line.filter(|&on_line| on_line != baud) {
        let message = format!("`baud` must be the bit rate of the line, {on_line}, found {baud}");
        let help = "correct `baud`, or the bit rate in the address of the port `line`";
        all.push(Misfit { key: "baud", message, help: Some(help.to_owned()) });
    }
    all
}

/// Rates and accelerations since the last row. Picking every n-th message would fold its noise, so rows hold means.
#[derive(Default)]
pub(super) struct Means {
    sums: [f64; 6],
    count: u32,
}

impl Means {
    /// A new message.
    pub(super) fn take(&mut self, rate_rad_per_s: &[f64; 3], acceleration_m_per_s2: &[f64; 3]) {
        let values = rate_rad_per_s.iter().chain(acceleration_m_per_s2);
        self.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        self.count += 1;
    }

    /// Puts the means into the six values; without a message since the row before they stay. What is summed begins anew.
    pub(super) fn give(&mut self, values: &mut [f64]) {
        if self.count > 0 {
            let count = f64::from(self.count);
            values.iter_mut().zip(self.sums).for_each(|(value, sum)| *value = sum / count);
        }
        *self = Self::default();
    }
}
