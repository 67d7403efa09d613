//! The inertial measurement unit on its serial line.

use std::time::Duration;

use drivers::device::{Channel, DeviceError};
use drivers::kvh::{Format, Kvh, KvhSettings, Opening, Synchronisation};
use drivers::wire::ByteLine;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::inertial::{self, CROSS_AXIS_ERROR, DATA_RATE, Imu, InertialUnit, Means, Reception, rate_bias};
use crate::model::device::DeviceEntry;
use crate::rig::device::RateSample;
use crate::rig::driver::{Driver, Made, Misfit, PortField, not_above_zero};

/// Time allowed for an answer on the line.
const ANSWER_TIMEOUT_S: f64 = 0.2;
/// Slowest bit rate that the unit knows.
const SLOWEST_BAUD: i64 = 9600;

/// Range of the gyros, ±490 °/s (KVH 1775).
const RANGE_RAD_PER_S: f64 = 490.0 * std::f64::consts::PI / 180.0;

/// Driver of the KVH 1775.
pub(super) const DRIVER: Driver = Driver {
    name: "kvh-1775",
    doc: "Inertial measurement unit KVH 1775 on the frame that carries the payload.",
    role: Some(DeviceRole::InertialUnit),
    certified_as: None,
    rate_range_rad_per_s: Some(RANGE_RAD_PER_S),
    ports: &[PortField::line("Serial line, RS-422.")],
    has_profile: false,
    fields: &[
        Field::default(
            "baud",
            Shape::Integer,
            "4147200",
            "Bit rate of the line; 4 kHz messages need 4147200.",
        ),
        Field::default(
            "format",
            Shape::Choice(&["A", "B", "C"]),
            "A",
            "Output format: B adds the unit's own time, C the magnetic field.",
        ),
        Field::optional(
            DATA_RATE,
            Shape::Quantity(K::Frequency),
            "The unit's own message rate, for a tick that is faster than its line; without it each tick \
             triggers one message.",
        ),
        CROSS_AXIS_ERROR,
        rate_bias("100 urad/s"),
    ],
    check,
    make: |entry, loop_rate_hz| {
        let settings = settings(entry, loop_rate_hz);
        let message_rate_hz = settings.message_rate_hz;
        Made::InTheTick(Box::new(Imu::<Kvh>::closed(entry, settings, message_rate_hz)))
    },
};

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let mut all = not_above_zero(entry, &[DATA_RATE]);
    all.extend(inertial::check_baud(entry, SLOWEST_BAUD));
    all.extend(inertial::check_errors(entry));
    all
}

fn settings(entry: &DeviceEntry, loop_rate_hz: f64) -> KvhSettings {
    let own_rate_hz = entry.optional_number(DATA_RATE);
    KvhSettings {
        name: entry.name.clone(),
        baud: u32::try_from(entry.integer("baud")).expect("checked: it fits"),
        format: match entry.text("format") {
            "B" => Format::B,
            "C" => Format::C,
            _ => Format::A,
        },
        // One message per tick: the loop's own pulse makes it, unless that is too fast for the line.
        synchronisation: own_rate_hz
            .map_or(Synchronisation::External, |hz| Synchronisation::Internal(hz.round() as u32)),
        message_rate_hz: own_rate_hz.unwrap_or(loop_rate_hz),
        rate_output: true,
        answer_timeout_s: ANSWER_TIMEOUT_S,
    }
}

impl InertialUnit for Kvh {
    type Settings = KvhSettings;
    type Opening = Opening;
    const MESSAGES: &'static str = "messages";

    fn begin(settings: KvhSettings) -> Result<Opening, DeviceError> {
        Opening::new(settings)
    }

    fn go_on(
        opening: &mut Opening,
        line: &mut dyn ByteLine,
        now: Duration,
    ) -> Result<Option<Self>, DeviceError> {
        opening.poll(line, now)
    }

    fn channels(_settings: &KvhSettings) -> &'static [Channel] {
        Self::CHANNELS
    }

    fn identity(&self) -> String {
        format!("KVH 1775, serial {}", Self::identity(self).serial)
    }

    fn configuration(&self) -> String {
        let entries = Self::identity(self).configuration.iter();
        entries.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
    }

    fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<u32, DeviceError> {
        Self::poll(self, line, now)
    }

    fn newest(&self) -> Option<RateSample> {
        self.sample().map(|sample| RateSample {
            rate_rad_per_s: sample.rate_rad_per_s,
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

    fn row(&self, _settings: &KvhSettings, means: &mut Means, row: &mut [f64]) {
        let mut values = Self::row(self);
        means.give(&mut values[..6]);
        row[..values.len()].copy_from_slice(&values);
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
