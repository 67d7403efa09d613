//! Answer to `*IDN?` (IEEE 488.2, 10.14): maker, model, serial number, firmware.

use std::fmt;

use super::{FormatError, number};

/// Who an instrument says it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// Maker.
    pub maker: String,
    /// Model.
    pub model: String,
    /// Serial number.
    pub serial: String,
    /// Firmware.
    pub firmware: String,
}

impl Identity {
    /// Reads the four fields.
    ///
    /// # Errors
    /// [`FormatError::Text`] where there are not four.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let text = String::from_utf8_lossy(number::trimmed(bytes)).into_owned();
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let &[maker, model, serial, firmware] = &fields[..] else {
            return Err(FormatError::Text { expected: "`maker,model,serial,firmware`", found: text });
        };
        Ok(Self {
            maker: maker.to_owned(),
            model: model.to_owned(),
            serial: serial.to_owned(),
            firmware: firmware.to_owned(),
        })
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { maker, model, serial, firmware } = self;
        write!(f, "{maker} {model}, serial {serial}, firmware {firmware}")
    }
}
