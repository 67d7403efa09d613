//! What is stored in the unit's flash: it decides what the unit sends. The configuration datagram says it (TS1524, table 5-16).

use drivers::stim300::{AccelerometerRange, Content, ForceUnit, GyroUnit, Input, SampleRate};

/// Configuration of a simulated unit. All axes are active, and all filters at 262 Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stim300Setup {
    /// When a measurement is sent.
    pub sample_rate: SampleRate,
    /// What a measurement carries.
    pub content: Content,
    /// Whether CR LF follows each datagram.
    pub line_end: bool,
    /// Bit rate of the line, bit/s. One that is not in the list of the datasheet counts as defined by the user.
    pub bit_rate: u32,
    /// What the gyro fields are.
    pub gyro_unit: GyroUnit,
    /// Whether the unit says that its gyros are delayed by 4 ms. The delay itself is not simulated.
    pub is_gyro_delayed: bool,
    /// What the accelerometer fields are.
    pub accelerometer_unit: ForceUnit,
    /// Range of all accelerometers.
    pub accelerometer_range: AccelerometerRange,
    /// Whether the bias trim datagram is sent at start-up.
    pub sends_bias_trim: bool,
    /// Whether the unit terminates the line.
    pub is_terminated: bool,
}

impl Default for Stim300Setup {
    /// The unit whose listing the datasheet prints (TS1524, figure 8-1).
    fn default() -> Self {
        Self {
            sample_rate: SampleRate::Internal(2000),
            content: Content {
                accelerometers: true,
                inclinometers: true,
                temperatures: false,
                input: Input::None,
            },
            line_end: false,
            bit_rate: 1_843_200,
            gyro_unit: GyroUnit::Rate,
            is_gyro_delayed: true,
            accelerometer_unit: ForceUnit::Acceleration,
            accelerometer_range: AccelerometerRange::G10,
            sends_bias_trim: false,
            is_terminated: true,
        }
    }
}

/// Internal samples in a second.
const INTERNAL_RATE_HZ: u32 = 2000;
/// Sample rates in the order of their codes.
const RATES_HZ: [u32; 5] = [125, 250, 500, 1000, 2000];
const BIT_RATES: [u32; 4] = [374_400, 460_800, 921_600, 1_843_200];

impl Stim300Setup {
    /// Internal samples between two measurements; `None` with an external trigger.
    pub(super) fn samples_per_measurement(&self) -> Option<u32> {
        match self.sample_rate {
            SampleRate::Internal(rate_hz) => Some(INTERNAL_RATE_HZ / rate_hz.clamp(1, INTERNAL_RATE_HZ)),
            SampleRate::External => None,
        }
    }

    /// Sets the sample rate by its code; `None` if there is no such code.
    pub(super) fn set_rate(&mut self, code: usize) -> Option<()> {
        self.sample_rate = match code {
            5 => SampleRate::External,
            _ => SampleRate::Internal(*RATES_HZ.get(code)?),
        };
        Some(())
    }

    /// Whether the measurements fit on the line (TS1524, equation 12).
    pub(super) fn fits(&self) -> bool {
        let SampleRate::Internal(rate_hz) = self.sample_rate else { return true };
        let bytes = super::datagram::length(self.content) + if self.line_end { 2 } else { 0 };
        1.1 * 10.0 * bytes as f64 * f64::from(rate_hz) <= f64::from(self.bit_rate)
    }

    /// The 21 bytes between identifier and checksum.
    pub(super) fn payload(&self) -> [u8; 21] {
        let rate_code = match self.sample_rate {
            SampleRate::Internal(rate_hz) => RATES_HZ.iter().position(|known| *known == rate_hz).unwrap_or(4),
            SampleRate::External => 5,
        };
        let bit_rate_code = BIT_RATES.iter().position(|known| *known == self.bit_rate).unwrap_or(15);
        let has_input = self.content.input != Input::None;
        let has_pps = self.content.input != Input::Aux;
        let range = match self.accelerometer_range {
            AccelerometerRange::G10 => 0,
            AccelerometerRange::G5 => 3,
            AccelerometerRange::G30 => 4,
            AccelerometerRange::G80 => 6,
        };
        let all_axes = 0x70;
        let mut bytes = [0; 21];
        bytes[0] = b'S';
        bytes[1] = 1;
        bytes[2] = (rate_code as u8) << 5
            | u8::from(has_input) << 4
            | u8::from(self.content.temperatures) << 3
            | u8::from(self.content.inclinometers) << 2
            | u8::from(self.content.accelerometers) << 1
            | u8::from(self.line_end);
        bytes[3] = (bit_rate_code as u8) << 4 | u8::from(self.is_terminated);
        bytes[4] = all_axes | u8::from(self.is_gyro_delayed) << 3 | gyro_code(self.gyro_unit);
        // Codes of 262 Hz.
        bytes[5..7].copy_from_slice(&[0x44, 0x40]);
        bytes[7] = all_axes | force_code(self.accelerometer_unit);
        bytes[8..10].copy_from_slice(&[0x44, 0x40]);
        bytes[10] = all_axes;
        // PPS: time since the input was found high.
        bytes[11..13].copy_from_slice(&[0x44, 0x43]);
        bytes[13] = u8::from(has_pps) << 3 | 4;
        bytes[16] = range << 4 | range;
        bytes[17] = range << 4;
        bytes[20] = u8::from(self.sends_bias_trim) << 1;
        bytes
    }
}

pub(super) fn gyro_code(unit: GyroUnit) -> u8 {
    match unit {
        GyroUnit::Rate => 0,
        GyroUnit::IncrementalAngle => 1,
        GyroUnit::AverageRate => 2,
        GyroUnit::IntegratedAngle => 3,
    }
}

pub(super) fn force_code(unit: ForceUnit) -> u8 {
    match unit {
        ForceUnit::Acceleration => 0,
        ForceUnit::IncrementalVelocity => 1,
        ForceUnit::AverageAcceleration => 2,
        ForceUnit::IntegratedVelocityGs => 3,
        ForceUnit::IntegratedVelocity => 4,
    }
}
