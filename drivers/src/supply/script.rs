//! The dialogues with a supply.

use super::{OUTPUTS, SupplySettings};
use crate::device::DeviceError;
use crate::scpi::Step;

/// What an answer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Want {
    Identity,
    IsOff,
    Complete,
    SetPoint(SetPoint),
    Voltage,
    Current,
    Output,
    Condition,
    OverVoltage,
    OverCurrent,
}

/// A set point of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetPoint {
    Voltage,
    CurrentLimit,
    OverVoltage,
}

/// Set points that an output must have; `None` is not looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPoints {
    /// Voltage.
    pub voltage_v: Option<f64>,
    /// Limit of the current.
    pub current_limit_a: Option<f64>,
    /// Level of the over-voltage protection.
    pub over_voltage_v: Option<f64>,
}

/// Every set point, in the order in which they are written and read back.
const ALL: [SetPoint; 3] = [SetPoint::Voltage, SetPoint::CurrentLimit, SetPoint::OverVoltage];

impl SetPoint {
    /// Its value among these.
    pub(super) fn of(self, all: &SetPoints) -> Option<f64> {
        match self {
            Self::Voltage => all.voltage_v,
            Self::CurrentLimit => all.current_limit_a,
            Self::OverVoltage => all.over_voltage_v,
        }
    }

    /// Name in errors.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Voltage => "voltage set point",
            Self::CurrentLimit => "current limit",
            Self::OverVoltage => "level of the over-voltage protection",
        }
    }

    pub(super) fn unit(self) -> &'static str {
        match self {
            Self::CurrentLimit => "A",
            Self::Voltage | Self::OverVoltage => "V",
        }
    }

    /// Name in [`DeviceError::Setting`].
    fn setting(self) -> &'static str {
        match self {
            Self::Voltage => "voltage_v",
            Self::CurrentLimit => "current_limit_a",
            Self::OverVoltage => "over_voltage_v",
        }
    }

    fn command(self) -> &'static str {
        match self {
            Self::Voltage => ":VOLT",
            Self::CurrentLimit => ":CURR",
            Self::OverVoltage => ":VOLT:PROT",
        }
    }
}

/// Refuses settings that cannot be.
pub(super) fn check(settings: &SupplySettings) -> Result<(), DeviceError> {
    let refused = |setting, value, allowed: String| {
        Err(DeviceError::Setting { device: settings.name.clone(), setting, value, allowed })
    };
    if !(1..=OUTPUTS).contains(&settings.output) {
        return refused("output", f64::from(settings.output), format!("outputs are 1 to {OUTPUTS}"));
    }
    let times = [("period_s", settings.period_s), ("reply_timeout_s", settings.reply_timeout_s)];
    let set_points = ALL.iter().filter_map(|own| Some((own.setting(), own.of(&settings.set_points)?)));
    match times.into_iter().chain(set_points).find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        Some((setting, value)) => refused(setting, value, "it must be finite and above 0".to_owned()),
        None => Ok(()),
    }
}

/// Writes the set points, where that is asked for, and reads them back.
pub(super) fn set_points(settings: &SupplySettings) -> Vec<Step<Want>> {
    let SupplySettings { output, reply_timeout_s: timeout_s, set_points, .. } = *settings;
    let given = || ALL.into_iter().filter_map(|own| Some((own, own.of(&set_points)?)));
    let mut steps = Vec::new();
    if settings.writes_set_points && given().next().is_some() {
        steps.push(Step::query(format!(":OUTP? (@{output})"), Want::IsOff, timeout_s));
        for (own, value) in given() {
            steps.push(Step::command(format!("{} {value},(@{output})", own.command()), timeout_s));
        }
        steps.push(Step::query("*OPC?", Want::Complete, timeout_s));
    }
    for (own, _) in given() {
        let text = format!("{}? (@{output})", own.command());
        steps.push(Step::query(text, Want::SetPoint(own), timeout_s));
    }
    steps
}

/// One reading of the output.
pub(super) fn reading(settings: &SupplySettings) -> Vec<Step<Want>> {
    let SupplySettings { output, reply_timeout_s, .. } = *settings;
    let ask = |text: String, want| Step::query(text, want, reply_timeout_s);
    vec![
        ask(format!(":MEAS:VOLT? (@{output})"), Want::Voltage),
        ask(format!(":MEAS:CURR? (@{output})"), Want::Current),
        ask(format!(":OUTP? (@{output})"), Want::Output),
        ask(format!(":STAT:QUES:INST:ISUM{output}:COND?"), Want::Condition),
        ask(format!(":VOLT:PROT:TRIP? (@{output})"), Want::OverVoltage),
        ask(format!(":CURR:PROT:TRIP? (@{output})"), Want::OverCurrent),
    ]
}
