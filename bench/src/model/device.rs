//! A device of a rig as its file describes it: which driver, on which ports, with which settings.

use std::collections::BTreeMap;
use std::sync::Arc;

use drivers::reader::ReaderProfile;
use drivers::wire::lines::LineAddress;
use procedures::device::DeviceRole;

use super::address::Address;

/// A setting of a device, SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A quantity.
    Number(f64),
    /// Several quantities.
    Numbers(Vec<f64>),
    /// A whole number.
    Integer(i64),
    /// A text, or one of a few words.
    Text(String),
}

/// A device of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceEntry {
    /// Name in messages and reports.
    pub name: String,
    /// Name of its driver.
    pub driver: &'static str,
    /// What it is to procedures; `None` for one that only logs.
    pub role: Option<DeviceRole>,
    /// Addresses of its ports, e.g. `line` → `sim:imu`.
    pub ports: BTreeMap<String, String>,
    /// Settings of the device; those that were left out and have no default are missing.
    pub settings: BTreeMap<&'static str, Setting>,
    /// What its lines look like, for an instrument that sends its readings as text.
    pub profile: Option<Arc<ReaderProfile>>,
}

/// Why a getter may rely on a setting.
const READ: &str = "the reader of rig files leaves no key of the driver's out that has a default or is required, and \
                    gives each the shape of its field";

impl DeviceEntry {
    /// Where it is reached, all its ports in one text.
    pub fn addresses(&self) -> String {
        self.ports.values().map(String::as_str).collect::<Vec<_>>().join(", ")
    }

    /// Addresses of its ports that are serial ports, TCP connections or UDP ports.
    pub fn lines(&self) -> impl Iterator<Item = LineAddress> {
        self.ports.values().filter_map(|text| match Address::parse(text) {
            Ok(Address::Line(line)) => Some(line),
            _ => None,
        })
    }

    /// Address of one of its ports.
    ///
    /// # Panics
    /// For a port that the driver does not declare.
    pub fn port(&self, key: &str) -> &str {
        self.ports.get(key).expect("the reader of rig files refuses a device that lacks a port of its driver")
    }

    /// A quantity.
    ///
    /// # Panics
    /// For a key that the driver does not declare as a required quantity or one with a default.
    pub fn number(&self, key: &str) -> f64 {
        self.optional_number(key).expect(READ)
    }

    /// A quantity that may have been left out.
    pub fn optional_number(&self, key: &str) -> Option<f64> {
        match self.settings.get(key) {
            Some(Setting::Number(number)) => Some(*number),
            _ => None,
        }
    }

    /// Several quantities.
    ///
    /// # Panics
    /// For a key that the driver does not declare as a required list or one with a default.
    pub fn numbers(&self, key: &str) -> &[f64] {
        match self.settings.get(key) {
            Some(Setting::Numbers(numbers)) => Some(numbers),
            _ => None,
        }
        .expect(READ)
    }

    /// Several quantities that may have been left out; empty then.
    pub fn optional_numbers(&self, key: &str) -> &[f64] {
        match self.settings.get(key) {
            Some(Setting::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }

    /// A whole number.
    ///
    /// # Panics
    /// For a key that the driver does not declare as a required whole number or one with a default.
    pub fn integer(&self, key: &str) -> i64 {
        match self.settings.get(key) {
            Some(Setting::Integer(number)) => Some(*number),
            _ => None,
        }
        .expect(READ)
    }

    /// A channel of an analog card or of an instrument: a whole number that the driver's check has found in range.
    ///
    /// # Panics
    /// As [`DeviceEntry::integer`], and for a number below 0.
    pub fn channel(&self, key: &str) -> usize {
        usize::try_from(self.integer(key)).expect("the driver's check refuses channels below 0")
    }

    /// A text.
    ///
    /// # Panics
    /// For a key that the driver does not declare as a required text or one with a default.
    pub fn text(&self, key: &str) -> &str {
        match self.settings.get(key) {
            Some(Setting::Text(text)) => Some(text.as_str()),
            _ => None,
        }
        .expect(READ)
    }
}
