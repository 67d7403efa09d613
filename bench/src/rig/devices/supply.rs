//! The DC supply of auxiliary circuits or of the bus: one output, recorded while a run goes on.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::scpi::Identity;
use drivers::supply::{OUTPUTS, SetPoints, Supply, SupplySettings};
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::on_line::ANSWER_TIMEOUT_S;
use crate::model::device::DeviceEntry;
use crate::rig::device::{Device, Group};
use crate::rig::driver::{Driver, Made, Misfit, PortField, not_above_zero};
use crate::rig::wires::Ports;

/// Name of the driver in rig files.
pub(crate) const NAME: &str = "e36300";

/// Driver of DC supplies.
pub(super) const DRIVER: Driver = Driver {
    name: NAME,
    doc: "DC power supply, one output of it, recorded during runs and never switched (Keysight E36300 command set).",
    role: None,
    certified_as: None,
    rate_range_rad_per_s: None,
    ports: &[PortField::line("SCPI line, TCP port 5025 of the instrument.")],
    has_profile: false,
    fields: &[
        Field::default("output", Shape::Integer, "1", "Output that is read, 1 to 3."),
        Field::optional(
            SET_POINTS[0],
            Shape::Quantity(K::Voltage),
            "Voltage that the output must be set to; not looked at if left out.",
        ),
        Field::optional(
            SET_POINTS[1],
            Shape::Quantity(K::Current),
            "Current limit that the output must be set to; not looked at if left out.",
        ),
        Field::optional(
            SET_POINTS[2],
            Shape::Quantity(K::Voltage),
            "Level that its over-voltage protection must be set to; not looked at if left out.",
        ),
        Field::default(
            "set-points",
            Shape::Choice(&["compare", "write"]),
            "compare",
            "Whether these set points are compared with those of the instrument, or written to it while the output is off and \
             read back. The output itself is switched by people only.",
        ),
        Field::default("period", Shape::Quantity(K::Time), "200 ms", "From reading to reading."),
    ],
    check,
    make: |entry, _| Made::InTheTick(Box::new(DcSupply::closed(entry))),
};

/// Keys of the set points: voltage, current limit, over-voltage protection.
const SET_POINTS: [&str; 3] = ["voltage", "current-limit", "over-voltage"];

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let mut all = not_above_zero(entry, &SET_POINTS);
    all.extend(not_above_zero(entry, &["period"]));
    let output = entry.integer("output");
    if !(1..=i64::from(OUTPUTS)).contains(&output) {
        let message = format!("`output` must be from 1 to {OUTPUTS}, found {output}");
        all.push(Misfit { key: "output", message, help: None });
    }
    let [voltage_v, _, over_voltage_v] = SET_POINTS.map(|key| entry.optional_number(key));
    if let (Some(voltage_v), Some(level_v)) = (voltage_v, over_voltage_v)
        && level_v <= voltage_v
    {
        let message = format!("`over-voltage`, {level_v} V, must be above `voltage`, {voltage_v} V");
        all.push(Misfit { key: SET_POINTS[2], message, help: None });
    }
    all
}

fn settings(entry: &DeviceEntry) -> SupplySettings {
    let [voltage_v, current_limit_a, over_voltage_v] = SET_POINTS.map(|key| entry.optional_number(key));
    SupplySettings {
        name: entry.name.clone(),
        output: u8::try_from(entry.integer("output")).expect("checked: 1 to 3"),
        set_points: SetPoints { voltage_v, current_limit_a, over_voltage_v },
        writes_set_points: entry.text("set-points") == "write",
        period_s: entry.number("period"),
        reply_timeout_s: ANSWER_TIMEOUT_S,
    }
}

/// A supply on its line.
struct DcSupply {
    settings: SupplySettings,
    port: String,
    line: usize,
    driver: Option<Supply>,
    identity: Option<Identity>,
}

impl DcSupply {
    /// On a line that is not open yet.
    fn closed(entry: &DeviceEntry) -> Self {
        let port = entry.port("line").to_owned();
        Self { settings: settings(entry), port, line: 0, driver: None, identity: None }
    }
}

impl Device for DcSupply {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        let driver = match &mut self.driver {
            Some(driver) => driver,
            None => {
                self.line = ports.find_line(&self.settings.name, &self.port)?;
                self.driver.insert(Supply::new(self.settings.clone())?)
            }
        };
        self.identity = driver.open(ports.line(self.line), now)?;
        Ok(self.identity.as_ref().map(|_| ()))
    }

    fn identity(&self) -> Option<String> {
        self.identity.as_ref().map(Identity::to_string)
    }

    fn configuration(&self) -> Option<String> {
        let SupplySettings { output, set_points, period_s, writes_set_points, .. } = &self.settings;
        let text =
            |value: Option<f64>, unit| value.map_or("any".to_owned(), |value| format!("{value} {unit}"));
        let how = if *writes_set_points { "written" } else { "compared" };
        Some(format!(
            "output {output} every {period_s} s, set points {how}: {}, {}, over-voltage protection {}",
            text(set_points.voltage_v, "V"),
            text(set_points.current_limit_a, "A"),
            text(set_points.over_voltage_v, "V")
        ))
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        self.driver.iter().map(|driver| ("readings", u64::from(driver.readings_count()))).collect()
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let Some(driver) = &mut self.driver else { return Ok(()) };
        driver.poll(ports.line(self.line), now).map(|_| ())
    }

    fn group(&self) -> Group {
        Group { topic: "dc_supply", message: "DcSupply", channels: Supply::CHANNELS }
    }

    fn row(&mut self, row: &mut [f64]) {
        let Some(driver) = &self.driver else { return };
        let values = driver.row();
        row[..values.len()].copy_from_slice(&values);
    }
}
