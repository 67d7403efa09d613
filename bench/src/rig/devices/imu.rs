//! The inertial measurement unit on its serial line.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::kvh::{Format, Kvh, KvhSettings, Opening, Synchronisation};
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::inertial::{self, CROSS_AXIS_ERROR, DATA_RATE, Means, rate_bias};
use crate::model::device::DeviceEntry;
use crate::rig::device::{Device, Group, RateSample, RateSensor};
use crate::rig::driver::{Driver, Made, Misfit, PortField, not_above_zero};
use crate::rig::hearing::{Hearing, Losses, STALE_PERIODS};
use crate::rig::wires::Ports;

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
    make: |entry, loop_rate_hz| Made::InTheTick(Box::new(Imu::closed(entry, loop_rate_hz))),
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

/// The unit, and what it measured since the last row.
pub(super) struct Imu {
    settings: KvhSettings,
    port: String,
    line: usize,
    opening: Option<Opening>,
    unit: Option<Kvh>,
    cross_axis_ratio: f64,
    bias_rad_per_s: f64,
    means: Means,
    messages_count: u64,
}

impl Imu {
    /// On a line that is not open yet.
    fn closed(entry: &DeviceEntry, loop_rate_hz: f64) -> Self {
        let settings = settings(entry, loop_rate_hz);
        let port = entry.port("line").to_owned();
        Self {
            settings,
            port,
            line: 0,
            opening: None,
            unit: None,
            cross_axis_ratio: entry.number("cross-axis-error"),
            bias_rad_per_s: entry.number("rate-bias"),
            means: Means::default(),
            messages_count: 0,
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
        self.unit.as_ref().map(|unit| format!("KVH 1775, serial {}", unit.identity().serial))
    }

    fn configuration(&self) -> Option<String> {
        let entries = self.unit.as_ref()?.identity().configuration.iter();
        Some(entries.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", "))
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Some(unit) = &self.unit else { return Vec::new() };
        let tally = unit.tally();
        vec![
            ("messages", self.messages_count),
            ("lost", unit.missed_count()),
            ("bad_checksums", tally.bad_checksums_count),
            ("skipped_bytes", tally.skipped_bytes_count),
        ]
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let Some(unit) = &mut self.unit else { return Ok(()) };
        let messages_count = unit.poll(ports.line(self.line), now)?;
        self.messages_count += u64::from(messages_count);
        if let (true, Some(sample)) = (messages_count > 0, unit.sample()) {
            self.means.take(&sample.rate_rad_per_s, &sample.acceleration_m_per_s2);
        }
        Ok(())
    }

    fn group(&self) -> Group {
        Group { topic: "imu", message: "Imu", channels: Kvh::CHANNELS }
    }

    fn row(&mut self, row: &mut [f64]) {
        let Some(unit) = &self.unit else { return };
        let mut values = unit.row();
        self.means.give(&mut values[..6]);
        row[..values.len()].copy_from_slice(&values);
    }

    fn hearing(&self, now: Duration) -> Option<Hearing> {
        let unit = self.unit.as_ref()?;
        let tally = unit.tally();
        let period_s = 1.0 / self.settings.message_rate_hz;
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
            rate_rad_per_s: sample.rate_rad_per_s,
            is_valid: sample.valid[..3] == [true; 3],
            sequence: sample.sequence,
        });
        Some(RateSensor {
            newest,
            age_ticks: unit.age_ticks(),
            new_count: unit.new_count(),
            message_rate_hz: self.settings.message_rate_hz,
            cross_axis_ratio: self.cross_axis_ratio,
            bias_rad_per_s: self.bias_rad_per_s,
        })
    }
}
