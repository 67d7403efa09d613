//! A reader as data; SI units.

use super::{Pattern, Shown};

/// What a value of a reader is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// Angle off the nearest face of the polygon on the first axis.
    Azimuth,
    /// The same of the second axis.
    Elevation,
    /// Force of a gauge.
    Force,
}

impl Measured {
    /// Every value, in the order of their numbers.
    pub const ALL: [Self; 3] = [Self::Azimuth, Self::Elevation, Self::Force];

    /// Name in patterns and profiles.
    pub fn name(self) -> &'static str {
        match self {
            Self::Azimuth => "azimuth",
            Self::Elevation => "elevation",
            Self::Force => "force",
        }
    }
}

/// What ends a line, in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Terminator {
    /// Line feed.
    Lf,
    /// Carriage return.
    Cr,
    /// Carriage return and line feed.
    CrLf,
}

impl Terminator {
    /// Bytes behind a query.
    pub fn bytes(self) -> &'static [u8] {
        match self {
            Self::Lf => b"\n",
            Self::Cr => b"\r",
            Self::CrLf => b"\r\n",
        }
    }

    /// The byte that ends a line.
    pub fn last(self) -> u8 {
        if self == Self::Cr { b'\r' } else { b'\n' }
    }
}

/// What a number in the line is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueScale {
    /// SI value of 1 in the line, rad or N; negative where the instrument counts the other way.
    pub scale_si: f64,
    /// Readings outside this range are none, rad or N.
    pub range_si: [f64; 2],
    /// Standard uncertainty of a reading, rad or N.
    pub u_si: f64,
    /// Places behind the decimal point.
    pub decimals: usize,
}

impl ValueScale {
    /// Smallest step of the number in the line, rad or N.
    pub fn quantum_si(&self) -> f64 {
        self.scale_si.abs() * 0.1_f64.powi(i32::try_from(self.decimals).unwrap_or(i32::MAX))
    }
}

/// Readings, rad or N; `None` where the instrument shows none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings([Option<f64>; Measured::ALL.len()]);

impl Readings {
    /// A value, rad or N.
    pub fn value(&self, which: Measured) -> Option<f64> {
        self.0[which as usize]
    }

    /// With this value.
    #[must_use]
    pub fn with(mut self, which: Measured, value: Option<f64>) -> Self {
        self.0[which as usize] = value;
        self
    }
}

/// A type of reader.
#[derive(Clone, Debug, PartialEq)]
pub struct ReaderProfile {
    /// Name of the profile.
    pub id: String,
    /// Query whose answer says who the instrument is, e.g. `*IDN?`.
    pub identify: Option<String>,
    /// Query for a reading; `None` for an instrument that sends by itself.
    pub query: Option<String>,
    /// What ends a line.
    pub terminator: Terminator,
    /// Shortest time between two queries; for an instrument that sends by itself, the time between two lines.
    pub period_s: f64,
    /// Longest wait for an answer; a reading is stale after this and a period.
    pub timeout_s: f64,
    /// How a line looks.
    pub pattern: Pattern,
    /// What stands in the place of a number where there is no reading.
    pub nothing: String,
    /// What the numbers are worth, in the order of [`Measured::ALL`]; `None` for those that are not in the line.
    pub values: [Option<ValueScale>; Measured::ALL.len()],
}

impl ReaderProfile {
    /// What the number of a value is worth; `None` if it is not in the line.
    pub fn scale(&self, which: Measured) -> Option<&ValueScale> {
        self.values[which as usize].as_ref()
    }

    /// A reading that is older than this is none.
    pub fn stale_s(&self) -> f64 {
        self.period_s + self.timeout_s
    }

    /// Readings that a line shows, and how many were outside their range.
    pub(super) fn scaled(&self, shown: &Shown) -> (Readings, u64) {
        let mut readings = Readings::default();
        let mut out_of_range = 0;
        for which in Measured::ALL {
            let (Some(scale), Some(number)) = (self.scale(which), shown.number(which)) else { continue };
            let value = number * scale.scale_si;
            let [least, most] = scale.range_si;
            let is_inside = (least..=most).contains(&value);
            out_of_range += u64::from(!is_inside);
            readings = readings.with(which, is_inside.then_some(value));
        }
        (readings, out_of_range)
    }

    /// The line, without its terminator, with which an instrument of this type shows these readings, rounded to its decimals.
    pub fn line(&self, readings: &Readings) -> String {
        let mut shown = Shown::default();
        for which in Measured::ALL {
            let number = self.scale(which).and_then(|scale| Some(readings.value(which)? / scale.scale_si));
            shown = shown.with(which, number);
        }
        let decimals = Measured::ALL.map(|which| self.scale(which).map_or(0, |scale| scale.decimals));
        self.pattern.encode(&shown, decimals, &self.nothing)
    }
}
