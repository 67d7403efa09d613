//! The STIM300 inertial measurement unit on its serial line.

use std::time::Duration;

use drivers::device::{Channel, DeviceError};
use drivers::stim300::{Content, ForceUnit, GyroUnit, Input, Opening, SampleRate, Stim300, Stim300Settings};
use drivers::wire::ByteLine;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::inertial::{self, CROSS_AXIS_ERROR, DATA_RATE, Imu, InertialUnit, Means, Reception, rate_bias};
use crate::model::device::DeviceEntry;
use crate::rig::device::RateSample;
use crate::rig::driver::{Driver, Made, Misfit, PortField};

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
    make: |entry, _| {
        let imu = Imu::<Stim300>::closed(entry, settings(entry), entry.number(DATA_RATE));
        Made::InTheTick(Box::new(imu))
    },
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

impl InertialUnit for Stim300 {
    type Settings = Stim300Settings;
    type Opening = Opening;
    const MESSAGES: &'static str = "measurements";

    fn begin(settings: Stim300Settings) -> Result<Opening, DeviceError> {
        Opening::new(settings)
    }

    fn go_on(
        opening: &mut Opening,
        line: &mut dyn ByteLine,
        now: Duration,
    ) -> Result<Option<Self>, DeviceError> {
        opening.poll(line, now)
    }

    fn channels(settings: &Stim300Settings) -> &'static [Channel] {
        match settings.content.temperatures {
            true => Self::CHANNELS,
            false => Self::CHANNELS_WITHOUT_TEMPERATURE,
        }
    }

    fn identity(&self) -> String {
        let identity = Self::identity(self);
        format!("STIM300, part {}, serial {}", identity.part_number, identity.serial)
    }

    fn configuration(&self) -> String {
        let configuration = &Self::identity(self).configuration;
        format!(
            "firmware {}, sample rate {:?}, {:?}",
            configuration.firmware, configuration.sample_rate, configuration.content
        )
    }

    fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<u32, DeviceError> {
        Self::poll(self, line, now)
    }

    fn newest(&self) -> Option<RateSample> {
        self.sample().map(|sample| RateSample {
            rate_rad_per_s: self.mean_rates_rad_per_s(),
            is_valid: sample.valid[..3] == [true; 3],
            sequence: sample.sequence,
        })
    }

    fn acceleration_m_per_s2(&self) -> [f64; 3] {
        self.sample().map_or([f64::NAN; 3], |sample| sample.acceleration_m_per_s2)
    }

    fn invalid(&self) -> Option<DeviceError> {
        self.valid_sample().err()
    }

    fn row(&self, settings: &Stim300Settings, means: &mut Means, row: &mut [f64]) {
        let mut values = Self::row(self);
        // The temperature stands first.
        means.give(&mut values[1..7]);
        let own = if settings.content.temperatures { &values[..] } else { &values[1..] };
        row[..own.len()].copy_from_slice(own);
    }

    fn reception(&self) -> Reception {
        Reception {
            age_ticks: self.age_ticks(),
            new_count: self.new_count(),
            missed_count: self.missed_count(),
            tally: self.tally(),
        }
    }

    fn silent_s(&self, now: Duration) -> f64 {
        Self::silent_s(self, now)
    }
}
