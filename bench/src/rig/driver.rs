//! What a driver is to rig files: its ports, its settings with their checks, and the device that it makes of them.

use procedures::device::DeviceRole;
use procedures::table::Field;

use super::device::Device;
use super::instruments::Instrument;
use crate::model::device::{DeviceEntry, Setting};

/// Sort of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortSort {
    /// Bytes in order.
    Line,
    /// Analog inputs and outputs.
    Card,
    /// Datagrams.
    Socket,
}

/// A port that a device hangs on.
#[derive(Clone, Copy, Debug)]
pub struct PortField {
    /// Key in `ports`.
    pub key: &'static str,
    /// Sort of the port.
    pub sort: PortSort,
    /// What it is, one sentence.
    pub doc: &'static str,
}

impl PortField {
    /// The key of a byte line is `line`.
    pub const fn line(doc: &'static str) -> Self {
        Self { key: "line", sort: PortSort::Line, doc }
    }

    /// The key of an analog card is `card`; several devices may share one.
    pub const fn card(doc: &'static str) -> Self {
        Self { key: "card", sort: PortSort::Card, doc }
    }

    /// The key of a datagram port is `socket`.
    pub const fn socket(doc: &'static str) -> Self {
        Self { key: "socket", sort: PortSort::Socket, doc }
    }
}

/// What a driver makes of a device's settings.
pub enum Made {
    /// A device that is polled once a tick.
    InTheTick(Box<dyn Device>),
    /// An instrument that is given tasks.
    Instrument(Box<dyn Instrument>),
}

/// A setting that cannot be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misfit {
    /// Key of the setting.
    pub key: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
}

/// A driver of devices.
pub struct Driver {
    /// Name in rig files, e.g. `kvh-1775`.
    pub name: &'static str,
    /// What it drives, one sentence.
    pub doc: &'static str,
    /// What its device is to procedures; `None` for one that only logs.
    pub role: Option<DeviceRole>,
    /// Role of the `[[instrument]]` whose certificate vouches for its readings; `None` where the device belongs to the unit.
    pub certified_as: Option<&'static str>,
    /// Largest rate that its gyros measure; `None` for what has none.
    pub rate_range_rad_per_s: Option<f64>,
    /// Ports that the device hangs on.
    pub ports: &'static [PortField],
    /// Whether its key `profile` names a reader profile, which then says what its device is to procedures.
    pub has_profile: bool,
    /// Keys of its settings. Their shapes are quantities, lists of quantities, whole numbers, texts and choices.
    pub fields: &'static [Field],
    /// Settings that cannot be, beyond what their shapes say.
    pub check: fn(&DeviceEntry) -> Vec<Misfit>,
    /// Makes the device, closed; `f64` is the rate of the tick in Hz.
    pub make: fn(&DeviceEntry, f64) -> Made,
}

/// Settings of `keys` that are quantities and not above zero.
pub(crate) fn not_above_zero(entry: &DeviceEntry, keys: &[&'static str]) -> Vec<Misfit> {
    let wrong = |key: &&&'static str| entry.optional_number(key).is_some_and(|number| number <= 0.0);
    let misfit =
        |key: &&'static str| Misfit { key, message: format!("`{key}` must be above zero"), help: None };
    keys.iter().filter(wrong).map(misfit).collect()
}

/// Settings of `keys` that are no channel number.
pub(crate) fn no_channels(entry: &DeviceEntry, keys: &[&'static str]) -> Vec<Misfit> {
    /// More channels than any card has.
    const MOST: i64 = 255;
    let out = |key: &&&'static str| matches!(entry.settings.get(**key), Some(Setting::Integer(n)) if !(0..=MOST).contains(n));
    let misfit = |key: &&'static str| {
        let message = format!("`{key}` must be a channel from 0 to {MOST}, found {}", entry.integer(key));
        Misfit { key, message, help: None }
    };
    keys.iter().filter(out).map(misfit).collect()
}
