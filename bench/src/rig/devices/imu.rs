//! The inertial measurement unit on its serial line.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::kvh::{Format, Kvh, KvhSettings, Opening, Synchronisation};
use drivers::wire::lines::LineAddress;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use crate::model::device::DeviceEntry;
use crate::rig::device::{Device, Group, RateSensor};
use crate::rig::driver::{Driver, Made, Misfit, PortField, not_above_zero};
use crate::rig::wires::Ports;

/// Time allowed for an answer on the line.
const ANSWER_TIMEOUT_S: f64 = 0.2;
/// Slowest bit rate that the unit knows.
const SLOWEST_BAUD: i64 = 9600;

/// Beyond this share of the other axis' motion the gyros could no longer tell a frozen encoder from a moving axis.
const MOST_CROSS_AXIS_RATIO: f64 = 0.1;
/// Beyond this bias they could not, either: 50 ms of it are 50 urad.
const MOST_BIAS_RAD_PER_S: f64 = 1e-3;

/// Driver of the KVH 1775.
pub(super) const DRIVER: Driver = Driver {
    name: "kvh-1775",
    doc: "Inertial measurement unit KVH 1775 on the frame that carries the payload.",
    role: Some(DeviceRole::InertialUnit),
    certified_as: None,
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
            "data-rate",
            Shape::Quantity(K::Frequency),
            "The unit's own message rate, for a tick that is faster than its line; without it each tick \
             triggers one message.",
        ),
        Field::default(
            "cross-axis-error",
            Shape::Quantity(K::Ratio),
            "4 %",
            "Share of the motion of one axis that the unit may show as motion of the other, from errors of \
             mount and scale. An encoder counts as frozen only beyond it.",
        ),
        Field::default(
            "rate-bias",
            Shape::Quantity(K::AngularVelocity),
            "100 urad/s",
            "Rate that the unit may show at rest, without that of the Earth. An encoder counts as frozen only beyond it.",
        ),
    ],
    check,
    make: |entry, loop_rate_hz| Made::InTheTick(Box::new(Imu::closed(entry, loop_rate_hz))),
};

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let baud = entry.integer("baud");
    let mut all = not_above_zero(entry, &["data-rate"]);
    if !(SLOWEST_BAUD..=i64::from(u32::MAX)).contains(&baud) {
        let message = format!("`baud` must be at least {SLOWEST_BAUD}, found {baud}");
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

fn settings(entry: &DeviceEntry, loop_rate_hz: f64) -> KvhSettings {
    let own_rate_hz = entry.optional_number("data-rate");
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
    /// Rates and accelerations since the last row, and how many messages they are.
    sums: [f64; 6],
    sums_count: u32,
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
            sums: [0.0; 6],
            sums_count: 0,
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
            let values = sample.rate_rad_per_s.iter().chain(&sample.acceleration_m_per_s2);
            self.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            self.sums_count += 1;
        }
        Ok(())
    }

    fn group(&self) -> Group {
        Group { topic: "imu", message: "Imu", channels: Kvh::CHANNELS }
    }

    /// Rates and accelerations are means since the row before: picking every n-th message would fold its noise.
    fn row(&mut self, row: &mut [f64]) {
        let Some(unit) = &self.unit else { return };
        let mut values = unit.row();
        if self.sums_count > 0 {
            let count = f64::from(self.sums_count);
            values.iter_mut().zip(self.sums).for_each(|(value, sum)| *value = sum / count);
        }
        row[..values.len()].copy_from_slice(&values);
        (self.sums, self.sums_count) = ([0.0; 6], 0);
    }

    fn rate_sensor(&self) -> Option<RateSensor<'_>> {
        let &Self { cross_axis_ratio, bias_rad_per_s, .. } = self;
        self.unit.as_ref().map(|unit| RateSensor { unit, cross_axis_ratio, bias_rad_per_s })
    }
}
