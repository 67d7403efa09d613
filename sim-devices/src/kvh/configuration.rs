//! What the unit's commands set: it decides what the numbers in a message mean.

use crate::unit::ImuSettings;
use drivers::kvh::{Format, STANDARD_GRAVITY_M_PER_S2};

/// Metres in a foot.
const METRES_PER_FOOT: f64 = 0.3048;

/// What `=RSTCFG` and power-up restore, and commands change.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Configuration {
    pub(super) baud: f64,
    pub(super) format: Format,
    pub(super) external: bool,
    pub(super) data_rate_hz: f64,
    pub(super) rates: bool,
    pub(super) degrees: bool,
    /// Velocity increments instead of accelerations in g.
    pub(super) velocity_increments: bool,
    pub(super) feet: bool,
    pub(super) fahrenheit: bool,
    pub(super) hundredths: bool,
    /// Rows of `=AXES`.
    pub(super) axes: [[f64; 3]; 3],
}

impl Configuration {
    /// As delivered. The default quantity and unit of the rotation are not documented; angle increments are what the
    /// public captures show.
    pub(super) fn factory(imu: &ImuSettings) -> Self {
        Self {
            baud: imu.baud_count,
            format: Format::A,
            external: false,
            data_rate_hz: imu.data_rate_hz,
            rates: false,
            degrees: false,
            velocity_increments: false,
            feet: false,
            fahrenheit: false,
            hundredths: false,
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        }
    }

    /// Rotation fields out of mean rates over an interval.
    pub(super) fn rotation(&self, rates_rad_per_s: [f64; 3], interval_s: f64) -> [f32; 3] {
        let unit = if self.degrees { 1.0_f64.to_degrees() } else { 1.0 };
        let factor = if self.rates { unit } else { unit * interval_s };
        self.turned(rates_rad_per_s).map(|value| (value * factor) as f32)
    }

    /// Acceleration fields out of mean specific forces over an interval.
    pub(super) fn acceleration(&self, forces_m_per_s2: [f64; 3], interval_s: f64) -> [f32; 3] {
        let factor = match (self.velocity_increments, self.feet) {
            (false, _) => 1.0 / STANDARD_GRAVITY_M_PER_S2,
            (true, false) => interval_s,
            (true, true) => interval_s / METRES_PER_FOOT,
        };
        self.turned(forces_m_per_s2).map(|value| (value * factor) as f32)
    }

    /// Temperature field.
    pub(super) fn temperature(&self, degc: f64) -> f32 {
        let value = if self.fahrenheit { degc * 1.8 + 32.0 } else { degc };
        (if self.hundredths { value * 100.0 } else { value }) as f32
    }

    fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        self.axes.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }
}
