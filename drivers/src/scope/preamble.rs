//! What scales a record: the ten fields of `:WAV:PRE?`.

use crate::scpi::{FormatError, number};

/// Fields of a preamble.
const FIELDS: usize = 10;
/// `format` of words.
const WORD: f64 = 1.0;
/// A sample that was not taken.
const HOLE: u16 = 0;

/// Scale of time and value of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Preamble {
    /// Samples.
    pub points: usize,
    /// Between two samples.
    pub x_increment_s: f64,
    /// Time of the sample `x_reference` after the trigger.
    pub x_origin_s: f64,
    /// Sample that the origin belongs to.
    pub x_reference: f64,
    /// Volts or amperes per code.
    pub y_increment: f64,
    /// Value of the code `y_reference`.
    pub y_origin: f64,
    /// Code that the origin belongs to.
    pub y_reference: f64,
}

impl Preamble {
    /// Reads `format,type,points,count,xinc,xorig,xref,yinc,yorig,yref`; the format must be words.
    ///
    /// # Errors
    /// [`FormatError`] for other than ten numbers, another format, or increments that are no increments.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut values = Vec::with_capacity(FIELDS);
        number::list(bytes, FIELDS, &mut values)?;
        let wrong = |expected| {
            Err(FormatError::Text {
                expected,
                found: String::from_utf8_lossy(number::trimmed(bytes)).into_owned(),
            })
        };
        match () {
            () if values[0] != WORD => return wrong("format 1, WORD, in the first field"),
            () if values[2] < 0.0 || values[2].fract() != 0.0 => {
                return wrong("a number of points in the third field");
            }
            () if values[4] <= 0.0 || values[7] <= 0.0 => {
                return wrong("increments above 0 in fields five and eight");
            }
            () => {}
        }
        Ok(Self {
            points: values[2] as usize,
            x_increment_s: values[4],
            x_origin_s: values[5],
            x_reference: values[6],
            y_increment: values[7],
            y_origin: values[8],
            y_reference: values[9],
        })
    }

    /// Time of a sample after the trigger.
    pub fn time_s(&self, sample: usize) -> f64 {
        (sample as f64 - self.x_reference) * self.x_increment_s + self.x_origin_s
    }

    /// Value of a code, `None` for a hole.
    pub fn value(&self, code: u16) -> Option<f64> {
        (code != HOLE).then(|| (f64::from(code) - self.y_reference) * self.y_increment + self.y_origin)
    }
}
