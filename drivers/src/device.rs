//! What every device has in common: channels and errors.

use crate::answer::FormatError;

/// Native width of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Width {
    F64,
    F32,
    I32,
    U32,
    U16,
    I8,
}

/// A channel that a device publishes into the state row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name with unit, e.g. `position_rad`.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Native width.
    pub width: Width,
}

/// What went wrong with a device: which one, which object, expected and found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DeviceError {
    /// An SDO was refused.
    #[error("{device}: object {index:04X}h:{sub:02X} ({name}): abort {code:08X}h, {meaning}")]
    Abort {
        /// Device.
        device: String,
        /// Object index.
        index: u16,
        /// Sub-index.
        sub: u8,
        /// Name of the object.
        name: &'static str,
        /// Abort code.
        code: u32,
        /// What the code means.
        meaning: &'static str,
    },
    /// An object reads differently from what it must be.
    #[error("{device}: object {index:04X}h:{sub:02X} ({name}): expected {expected}, found {found}; {help}")]
    Mismatch {
        /// Device.
        device: String,
        /// Object index.
        index: u16,
        /// Sub-index.
        sub: u8,
        /// Name of the object.
        name: &'static str,
        /// What it must be.
        expected: String,
        /// What was read.
        found: String,
        /// What to do.
        help: &'static str,
    },
    /// A named entry or field of a device without an object dictionary is not what it must be.
    #[error("{device}: {field}: expected {expected}, found {found}; {help}")]
    Field {
        /// Device.
        device: String,
        /// Name of the entry.
        field: &'static str,
        /// What it must be.
        expected: String,
        /// What was read.
        found: String,
        /// What to do.
        help: &'static str,
    },
    /// A setting that the device cannot be given.
    #[error("{device}: setting {setting} is {value}; {allowed}")]
    Setting {
        /// Device.
        device: String,
        /// Name of the setting, with unit.
        setting: &'static str,
        /// Value that was asked for.
        value: f64,
        /// What would be allowed.
        allowed: String,
    },
    /// The drive is in a fault.
    #[error(
        "{device}: fault {error_code:04X}h, {meaning} (statusword {statusword:04X}h); remove the cause, then reset the fault"
    )]
    Fault {
        /// Device.
        device: String,
        /// Error code (603F).
        error_code: u16,
        /// What the code means.
        meaning: &'static str,
        /// Statusword.
        statusword: u16,
    },
    /// The drive did not reach a state in time.
    #[error(
        "{device}: {from} → {to} not reached within {limit_s} s (statusword {statusword:04X}h, error code {error_code:04X}h)"
    )]
    StateTimeout {
        /// Device.
        device: String,
        /// State it is in.
        from: &'static str,
        /// State that was asked for.
        to: &'static str,
        /// Time allowed.
        limit_s: f64,
        /// Last statusword.
        statusword: u16,
        /// Last error code.
        error_code: u16,
    },
    /// An instrument put an error into its queue.
    #[error("{device}: {command}: the instrument reports {code}, \"{message}\"")]
    Instrument {
        /// Instrument.
        device: String,
        /// What it was told.
        command: String,
        /// Code of SCPI, or of the maker where it is positive.
        code: i32,
        /// The instrument's own words.
        message: String,
    },
    /// An instrument's answer is not what the query demands.
    #[error("{device}: {command}: {source}; {}", source.help())]
    Answer {
        /// Instrument.
        device: String,
        /// What it was asked.
        command: String,
        /// What is wrong with the answer.
        source: FormatError,
    },
    /// The bus failed.
    #[error("{device}: {reason}")]
    Bus {
        /// Bus or device.
        device: String,
        /// What happened.
        reason: String,
    },
}

impl DeviceError {
    /// The error with the name of a device in front of the line or bus that reports it; as it is where it names that device.
    #[must_use]
    pub fn of_device(mut self, name: &str) -> Self {
        let own = match &mut self {
            Self::Abort { device, .. }
            | Self::Mismatch { device, .. }
            | Self::Field { device, .. }
            | Self::Setting { device, .. }
            | Self::Fault { device, .. }
            | Self::StateTimeout { device, .. }
            | Self::Instrument { device, .. }
            | Self::Answer { device, .. }
            | Self::Bus { device, .. } => device,
        };
        let is_named = own.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(" at "));
        if !is_named {
            *own = format!("{name} at {own}");
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_line_gets_the_name_of_its_device_once() {
        let of_line =
            |device: &str| DeviceError::Bus { device: device.to_owned(), reason: "gone".to_owned() };
        let named = of_line("tcp:192.168.1.20:5025").of_device("scope");
        assert_eq!(named.to_string(), "scope at tcp:192.168.1.20:5025: gone");
        assert_eq!(named.clone().of_device("scope"), named);
        assert_eq!(of_line("scope").of_device("scope"), of_line("scope"));
        assert_eq!(of_line("scope2").of_device("scope").to_string(), "scope at scope2: gone");
    }
}
