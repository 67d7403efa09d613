//! The STIM300 inertial measurement unit on its serial line.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::stim300::{Content, ForceUnit, GyroUnit, Input, Opening, SampleRate, Stim300, Stim300Settings};
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::inertial::{self, CROSS_AXIS_ERROR, DATA_RATE, Means, rate_bias};
use crate::model::device::DeviceEntry;
use crate::rig::device::{Device, Group, RateSample, RateSensor};
use crate::rig::driver::{Driver, Made, Misfit, PortField};
use crate::rig::hearing::{Hearing, Losses, STALE_PERIODS};
use crate::rig::wires::Ports;

/// Name of the driver in rig files.
pub(crate) const NAME: &str = "stim300";

/// Time allowed for an answer: the listing at the begin of service mode takes 60 ms at the slowest bit rate.
const ANSWER_TIMEOUT_S: f64 = 0.2;
/// Slowest bit rate of the list of the datasheet.
const SLOWEST_BAUD: i64 = 374_400;
/// Range of the gyros, ±400 °/s (TS1524).
const RANGE_RAD_PER_S: f64 = 400.0 * std::f64::consts::PI / 180.0;

/// Driver of the STIM300.
pub(super) const DRIVER: Driver = Driver {
    name: NAME,
    doc: "Inertial measurement unit STIM300 on the frame that carries the payload. It sends by its own clock.",
    role: Some(DeviceRole::InertialUnit),
    certified_as: None,
    rate_range_rad_per_s: Some(RANGE_RAD_PER_S),
    ports: &[PortField::line("Serial line, RS-422.")],
    has_profile: false,
    fields: &[
        Field::default(
            "baud",
            Shape::Integer,
            "1843200",
            "Bit rate of the line, as it is stored in the unit; 2 kHz needs at least 921600.",
        ),
        Field::default(
            DATA_RATE,
            Shape::Quantity(K::Frequency),
            "2 kHz",
            "Measurements per second: 125, 250, 500, 1000 or 2000 Hz.",
        ),
        Field::default(
            "datagram",
            Shape::Choice(&["91h", "A5h"]),
            "91h",
            "Measurement datagram: 91h has rates and accelerations, A5h also temperatures.",
        ),
        Field::default(
            "configuration",
            Shape::Choice(&["change", "keep"]),
            "change",
            "What happens to a unit with another rate or datagram: it is changed until it is switched off, or refused.",
        ),
        CROSS_AXIS_ERROR,
        rate_bias("150 urad/s"),
    ],
    check,
    make: |entry, _| Made::InTheTick(Box::new(Imu::closed(entry))),
};

/// What a measurement carries.
fn content(entry: &DeviceEntry) -> Content {
    Content {
        accelerometers: true,
        inclinometers: false,
        temperatures: entry.text("datagram") == "A5h",
        input: Input::None,
    }
}

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let mut all = inertial::check_baud(entry, SLOWEST_BAUD);
    if all.is_empty()
        && let Err(DeviceError::Setting { setting, allowed, .. }) = Opening::new(settings(entry))
    {
        let key = if setting.starts_with("bit rate") { "baud" } else { DATA_RATE };
        all.push(Misfit { key, message: format!("`{key}` does not fit: {allowed}"), help: None });
    }
    all.extend(inertial::check_errors(entry));
    all
}

fn settings(entry: &DeviceEntry) -> Stim300Settings {
    Stim300Settings {
        name: entry.name.clone(),
        bit_rate: u32::try_from(entry.integer("baud")).unwrap_or(u32::MAX),
        content: content(entry),
        // A rate that is no whole number is none of the unit's either.
        sample_rate: SampleRate::Internal(entry.number(DATA_RATE).round() as u32),
        gyro_unit: GyroUnit::Rate,
        accelerometer_unit: ForceUnit::Acceleration,
        may_change_unit: entry.text("configuration") == "change",
        answer_timeout_s: ANSWER_TIMEOUT_S,
    }
}

/// The unit, and what it measured since the last row.
pub(super) struct Imu {
    settings: Stim300Settings,
    port: String,
    line: usize,
    opening: Option<Opening>,
    unit: Option<Stim300>,
    message_rate_hz: f64,
    cross_axis_ratio: f64,
    bias_rad_per_s: f64,
    means: Means,
    measurements_count: u64,
}

impl Imu {
    /// On a line that is not open yet.
    fn closed(entry: &DeviceEntry) -> Self {
        Self {
            settings: settings(entry),
            port: entry.port("line").to_owned(),
            line: 0,
            opening: None,
            unit: None,
            message_rate_hz: entry.number(DATA_RATE),
            cross_axis_ratio: entry.number("cross-axis-error"),
            bias_rad_per_s: entry.number("rate-bias"),
            means: Means::default(),
            measurements_count: 0,
        }
    }
}

impl Device for Imu {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        let opening = match &mut self.opening {
            Some(opening) => opening,
            None => {
                self.line = ports.find_line(&self.settings.name, &self.port)?;
                self.opening.insert(Opening::new(self.settings.clone())?)
            }
        };
        self.unit = opening.poll(ports.line(self.line), now)?;
        Ok(self.unit.is_some().then_some(()))
    }

    fn identity(&self) -> Option<String> {
        let identity = self.unit.as_ref()?.identity();
        Some(format!("STIM300, part {}, serial {}", identity.part_number, identity.serial))
    }

    fn configuration(&self) -> Option<String> {
        let configuration = &self.unit.as_ref()?.identity().configuration;
        Some(format!(
            "firmware {}, sample rate {:?}, {:?}",
            configuration.firmware, configuration.sample_rate, configuration.content
        ))
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Some(unit) = &self.unit else { return Vec::new() };
        let tally = unit.tally();
        vec![
            ("measurements", self.measurements_count),
            ("lost", unit.missed_count()),
            ("bad_checksums", tally.bad_checksums_count),
            ("skipped_bytes", tally.skipped_bytes_count),
        ]
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let Some(unit) = &mut self.unit else { return Ok(()) };
        let measurements_count = unit.poll(ports.line(self.line), now)?;
        self.measurements_count += u64::from(measurements_count);
        if let (true, Some(sample)) = (measurements_count > 0, unit.sample()) {
            self.means.take(&unit.mean_rates_rad_per_s(), &sample.acceleration_m_per_s2);
        }
        Ok(())
    }

    fn group(&self) -> Group {
        let channels = match self.settings.content.temperatures {
            true => Stim300::CHANNELS,
            false => Stim300::CHANNELS_WITHOUT_TEMPERATURE,
        };
        Group { topic: "imu", message: "Imu", channels }
    }

    fn row(&mut self, row: &mut [f64]) {
        let Some(unit) = &self.unit else { return };
        let mut values = unit.row();
        // The temperature stands first.
        self.means.give(&mut values[1..7]);
        let own = if self.settings.content.temperatures { &values[..] } else { &values[1..] };
        row[..own.len()].copy_from_slice(own);
    }

    fn hearing(&self, now: Duration) -> Option<Hearing> {
        let unit = self.unit.as_ref()?;
        let tally = unit.tally();
        let period_s = 1.0 / self.message_rate_hz;
        Some(Hearing {
            period_s,
            silent_s: unit.silent_s(now),
            stale_s: STALE_PERIODS * period_s,
            losses: Losses {
                messages_count: unit.missed_count(),
                rejected_count: tally.bad_checksums_count,
                skipped_bytes_count: tally.skipped_bytes_count,
            },
        })
    }

    fn invalid(&self) -> Option<DeviceError> {
        self.unit.as_ref()?.valid_sample().err()
    }

    fn rate_sensor(&self) -> Option<RateSensor> {
        let unit = self.unit.as_ref()?;
        let newest = unit.sample().map(|sample| RateSample {
            rate_rad_per_s: unit.mean_rates_rad_per_s(),
            is_valid: sample.valid[..3] == [true; 3],
            sequence: sample.sequence,
        });
        Some(RateSensor {
            newest,
            age_ticks: unit.age_ticks(),
            new_count: unit.new_count(),
            message_rate_hz: self.message_rate_hz,
            cross_axis_ratio: self.cross_axis_ratio,
            bias_rad_per_s: self.bias_rad_per_s,
        })
    }
}
