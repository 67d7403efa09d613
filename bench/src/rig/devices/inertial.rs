//! What inertial units of all makes have in common: the errors that the rig file declares, and the device in the tick.

use std::time::Duration;

use drivers::device::{Channel, DeviceError};
use drivers::kvh::{STALE_PERIODS, Tally};
use drivers::wire::ByteLine;
use drivers::wire::lines::LineAddress;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use crate::model::device::DeviceEntry;
use crate::rig::device::{Device, Group, RateSample, RateSensor};
use crate::rig::driver::Misfit;
use crate::rig::hearing::{Hearing, Losses};
use crate::rig::wires::Ports;

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

/// A make of inertial unit, open on its line.
pub(super) trait InertialUnit: Sized {
    /// What it must know of the unit.
    type Settings: Clone;
    /// The dialogue that opens it.
    type Opening;
    /// What one of its messages is called where they are counted.
    const MESSAGES: &'static str;

    /// Begins the dialogue that opens it.
    fn begin(settings: Self::Settings) -> Result<Self::Opening, DeviceError>;

    /// Goes on with that dialogue; the unit once it is done.
    fn go_on(
        opening: &mut Self::Opening,
        line: &mut dyn ByteLine,
        now: Duration,
    ) -> Result<Option<Self>, DeviceError>;

    /// Channels of its rows.
    fn channels(settings: &Self::Settings) -> &'static [Channel];

    /// Who it is.
    fn identity(&self) -> String;

    /// How it is set up, as it answered.
    fn configuration(&self) -> String;

    /// Takes what has arrived: how many messages.
    fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<u32, DeviceError>;

    /// The newest message, with the rates that the loop takes; `None` before the first.
    fn newest(&self) -> Option<RateSample>;

    /// Accelerations of that message.
    fn acceleration_m_per_s2(&self) -> [f64; 3];

    /// Why that message is no rate to be used.
    fn invalid(&self) -> Option<DeviceError>;

    /// Puts its values into the head of a row, with the means since the row before.
    fn row(&self, settings: &Self::Settings, means: &mut Means, row: &mut [f64]);

    /// How it is received.
    fn reception(&self) -> Reception;

    /// How long no message has come, s; 0 before the first.
    fn silent_s(&self, now: Duration) -> f64;
}

/// How an inertial unit is received.
pub(super) struct Reception {
    /// Ticks since the newest message.
    pub(super) age_ticks: u16,
    /// Messages that came with the last poll.
    pub(super) new_count: u32,
    /// Messages that never came.
    pub(super) missed_count: u64,
    /// What was thrown away.
    pub(super) tally: Tally,
}

/// An inertial unit in the tick, and what it measured since the last row.
pub(super) struct Imu<U: InertialUnit> {
    name: String,
    settings: U::Settings,
    port: String,
    line: usize,
    opening: Option<U::Opening>,
    unit: Option<U>,
    message_rate_hz: f64,
    cross_axis_ratio: f64,
    bias_rad_per_s: f64,
    means: Means,
    messages_count: u64,
}

impl<U: InertialUnit> Imu<U> {
    /// On a line that is not open yet.
    pub(super) fn closed(entry: &DeviceEntry, settings: U::Settings, message_rate_hz: f64) -> Self {
        Self {
            name: entry.name.clone(),
            settings,
            port: entry.port("line").to_owned(),
            line: 0,
            opening: None,
            unit: None,
            message_rate_hz,
            cross_axis_ratio: entry.number("cross-axis-error"),
            bias_rad_per_s: entry.number("rate-bias"),
            means: Means::default(),
            messages_count: 0,
        }
    }
}

impl<U: InertialUnit> Device for Imu<U> {
    fn name(&self) -> &str {
        &self.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        let opening = match &mut self.opening {
            Some(opening) => opening,
            None => {
                self.line = ports.find_line(&self.name, &self.port)?;
                self.opening.insert(U::begin(self.settings.clone())?)
            }
        };
        self.unit = U::go_on(opening, ports.line(self.line), now)?;
        Ok(self.unit.is_some().then_some(()))
    }

    fn identity(&self) -> Option<String> {
        self.unit.as_ref().map(U::identity)
    }

    fn configuration(&self) -> Option<String> {
        self.unit.as_ref().map(U::configuration)
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Some(unit) = &self.unit else { return Vec::new() };
        let Reception { missed_count, tally, .. } = unit.reception();
        vec![
            (U::MESSAGES, self.messages_count),
            ("lost", missed_count),
            ("bad_checksums", tally.bad_checksums_count),
            ("skipped_bytes", tally.skipped_bytes_count),
        ]
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let Some(unit) = &mut self.unit else { return Ok(()) };
        let messages_count = unit.poll(ports.line(self.line), now)?;
        self.messages_count += u64::from(messages_count);
        if let (true, Some(sample)) = (messages_count > 0, unit.newest()) {
            self.means.take(&sample.rate_rad_per_s, &unit.acceleration_m_per_s2());
        }
        Ok(())
    }

    fn group(&self) -> Group {
        Group { topic: "imu", message: "Imu", channels: U::channels(&self.settings) }
    }

    fn row(&mut self, row: &mut [f64]) {
        if let Some(unit) = &self.unit {
            unit.row(&self.settings, &mut self.means, row);
        }
    }

    fn hearing(&self, now: Duration) -> Option<Hearing> {
        let unit = self.unit.as_ref()?;
        let Reception { missed_count, tally, .. } = unit.reception();
        let period_s = 1.0 / self.message_rate_hz;
        Some(Hearing {
            period_s,
            silent_s: unit.silent_s(now),
            stale_s: STALE_PERIODS * period_s,
            losses: Losses {
                messages_count: missed_count,
                rejected_count: tally.bad_checksums_count,
                skipped_bytes_count: tally.skipped_bytes_count,
            },
        })
    }

    fn invalid(&self) -> Option<DeviceError> {
        self.unit.as_ref()?.invalid()
    }

    fn rate_sensor(&self) -> Option<RateSensor> {
        let unit = self.unit.as_ref()?;
        let Reception { age_ticks, new_count, .. } = unit.reception();
        Some(RateSensor {
            newest: unit.newest(),
            age_ticks,
            new_count,
            message_rate_hz: self.message_rate_hz,
            cross_axis_ratio: self.cross_axis_ratio,
            bias_rad_per_s: self.bias_rad_per_s,
        })
    }
}
