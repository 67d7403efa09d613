//! From counts to SI units, by the configuration that the unit has reported (TS1524 rev. 31, section 7.5.2.2).

use super::configuration::{Configuration, ForceUnit, GyroUnit};
use super::datagram::{Input, Measurement, Triad};
use crate::kvh::STANDARD_GRAVITY_M_PER_S2;

/// Counts per °/s of rates and mean rates.
const COUNTS_PER_DEG_PER_S: f64 = 16_384.0;
/// Counts per ° of increments and integrated angles.
const COUNTS_PER_DEG: f64 = 2_097_152.0;
/// Integrated angles are sent modulo 2²⁴ counts, 8°.
const INTEGRATED_MODULUS: i32 = 1 << 24;
/// Inclinometers: counts per g of accelerations.
const INCLINOMETER_COUNTS_PER_G: f64 = 4_194_304.0;
/// Inclinometers: counts per m/s of velocity increments.
const INCLINOMETER_COUNTS_PER_M_PER_S: f64 = 33_554_432.0;
/// Counts per kelvin.
const COUNTS_PER_DEGC: f64 = 256.0;
/// Volts per count of the AUX input (public drivers of units of earlier revisions; not in the current datasheet).
const AUX_V_PER_COUNT: f64 = 5.0 / 16_777_216.0;

/// Factors from counts to SI units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    gyro_unit: GyroUnit,
    /// rad/s for a rate, rad for an angle.
    gyro: f64,
    accelerometers_increment: bool,
    /// m/s² for an acceleration, m/s for an increment.
    accelerometer: [f64; 3],
    inclinometers_increment: bool,
    inclinometer: f64,
    is_pps_time: bool,
}

impl Scales {
    pub(super) fn new(configuration: &Configuration) -> Self {
        let accelerometers_increment = configuration.accelerometer_unit == ForceUnit::IncrementalVelocity;
        let inclinometers_increment = configuration.inclinometer_unit == ForceUnit::IncrementalVelocity;
        Self {
            gyro_unit: configuration.gyro_unit,
            gyro: match configuration.gyro_unit {
                GyroUnit::Rate | GyroUnit::AverageRate => COUNTS_PER_DEG_PER_S.recip().to_radians(),
                GyroUnit::IncrementalAngle | GyroUnit::IntegratedAngle => COUNTS_PER_DEG.recip().to_radians(),
            },
            accelerometers_increment,
            accelerometer: configuration.accelerometer_range.map(|range| {
                if accelerometers_increment {
                    range.counts_per_m_per_s().recip()
                } else {
                    STANDARD_GRAVITY_M_PER_S2 / range.counts_per_g()
                }
            }),
            inclinometers_increment,
            inclinometer: if inclinometers_increment {
                INCLINOMETER_COUNTS_PER_M_PER_S.recip()
            } else {
                STANDARD_GRAVITY_M_PER_S2 / INCLINOMETER_COUNTS_PER_G
            },
            is_pps_time: configuration.pps_unit.is_time(),
        }
    }

    /// Angular rates, rad/s. `before` are the gyro counts of the measurement before. `interval_s` is the time that an increment
    /// covers, `elapsed_s` that since the measurement before. `None` if a rate cannot be told.
    pub(super) fn rates(
        &self,
        gyros: &Triad,
        before: Option<[i32; 3]>,
        interval_s: Option<f64>,
        elapsed_s: Option<f64>,
    ) -> Option<[f64; 3]> {
        let counts = gyros.counts;
        match self.gyro_unit {
            GyroUnit::Rate | GyroUnit::AverageRate => Some(counts.map(|count| self.gyro * f64::from(count))),
            GyroUnit::IncrementalAngle => {
                let interval_s = interval_s?;
                Some(counts.map(|count| self.gyro * f64::from(count) / interval_s))
            }
            GyroUnit::IntegratedAngle => {
                let (before, elapsed_s) = (before?, elapsed_s?);
                let turned = |axis: usize| self.gyro * f64::from(wrapped(counts[axis] - before[axis]));
                Some([0, 1, 2].map(|axis| turned(axis) / elapsed_s))
            }
        }
    }

    /// Specific forces of the accelerometers, m/s².
    pub(super) fn accelerations(&self, triad: &Triad, interval_s: Option<f64>) -> Option<[f64; 3]> {
        let per_s = if self.accelerometers_increment { interval_s?.recip() } else { 1.0 };
        Some([0, 1, 2].map(|axis| self.accelerometer[axis] * f64::from(triad.counts[axis]) * per_s))
    }

    /// Specific forces of the inclinometers, m/s².
    pub(super) fn inclinations(&self, triad: &Triad, interval_s: Option<f64>) -> Option<[f64; 3]> {
        let per_s = if self.inclinometers_increment { interval_s?.recip() } else { 1.0 };
        Some(triad.counts.map(|count| self.inclinometer * f64::from(count) * per_s))
    }

    /// Mean temperature of the gyros, °C.
    pub(super) fn temperature_degc(&self, measurement: &Measurement) -> Option<f64> {
        let sum: i32 = measurement.temperatures[0].counts.iter().sum();
        measurement.content.temperatures.then(|| f64::from(sum) / (3.0 * COUNTS_PER_DEGC))
    }

    /// Time since the edge of PPS, s.
    pub(super) fn since_pps_s(&self, measurement: &Measurement) -> Option<f64> {
        let is_time = measurement.content.input == Input::Pps && self.is_pps_time;
        (is_time && measurement.input_status == 0).then(|| 1e-6 * f64::from(measurement.input))
    }

    /// Voltage at AUX.
    pub(super) fn aux_v(&self, measurement: &Measurement) -> Option<f64> {
        (measurement.content.input == Input::Aux).then(|| AUX_V_PER_COUNT * f64::from(measurement.input))
    }
}

/// The shorter way between two integrated angles.
fn wrapped(difference: i32) -> i32 {
    (difference + INTEGRATED_MODULUS / 2).rem_euclid(INTEGRATED_MODULUS) - INTEGRATED_MODULUS / 2
}
