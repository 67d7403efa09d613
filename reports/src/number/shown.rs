//! In which unit a quantity is shown: that of the limit it is compared with, else one that suits its size.

use procedures::quantity::QuantityKind;

use super::{pair, typeset};
use crate::record::LimitFindings;

/// Angles below this are read in µrad, times below it in ms (or µs), where no limit says otherwise.
const SMALL_ANGLE_RAD: f64 = 5e-4;
const SMALL_TIME_S: f64 = 0.05;
const TINY_TIME_S: f64 = 5e-5;

/// A unit and what one of it is worth in SI. All kinds are shown without an offset (temperatures are kept in °C).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shown {
    symbol: String,
    si_of_one: f64,
}

impl Shown {
    /// The unit in which people read the kind.
    pub(crate) fn of_kind(kind: QuantityKind) -> Self {
        Self { symbol: kind.display_unit().to_owned(), si_of_one: 1.0 / kind.to_display(1.0) }
    }

    /// The unit in which a person wrote a limit: its last word; that of the kind where this is a bare number.
    pub(crate) fn of_limit(limit: &LimitFindings) -> Self {
        let symbol = limit.text.split_whitespace().next_back().unwrap_or("");
        Self::named(limit.kind, symbol).unwrap_or_else(|| Self::of_kind(limit.kind))
    }

    /// A unit for something as large as this SI number.
    pub(crate) fn of_size(kind: QuantityKind, si: f64) -> Self {
        let symbol = match kind {
            QuantityKind::Angle if si != 0.0 && si.abs() < SMALL_ANGLE_RAD => "urad",
            QuantityKind::Time if si != 0.0 && si.abs() < TINY_TIME_S => "us",
            QuantityKind::Time if si != 0.0 && si.abs() < SMALL_TIME_S => "ms",
            _ => return Self::of_kind(kind),
        };
        Self::named(kind, symbol).unwrap_or_else(|| Self::of_kind(kind))
    }

    fn named(kind: QuantityKind, symbol: &str) -> Option<Self> {
        if symbol.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'))
            && symbol != "1/rev"
        {
            return None;
        }
        let si_of_one = kind.parse(&format!("1 {symbol}")).ok().filter(|si| *si > 0.0)?;
        Some(Self { symbol: symbol.to_owned(), si_of_one })
    }

    /// Symbol of the unit, as in files.
    pub(crate) fn symbol(&self) -> &str {
        &self.symbol
    }

    /// The SI number in this unit, to twelve digits: what conversion adds behind them is noise.
    pub(crate) fn rounded(&self, si: f64) -> f64 {
        let number = self.number(si);
        format!("{number:.11e}").parse().unwrap_or(number)
    }

    /// The SI number in this unit.
    pub(crate) fn number(&self, si: f64) -> f64 {
        si / self.si_of_one
    }

    /// An SI value and its uncertainty, to the place of the uncertainty's second digit.
    pub(crate) fn pair(&self, value: f64, u: f64) -> (String, String) {
        pair(self.number(value), self.number(u).abs())
    }

    /// `number unit`, or the number alone for kinds without a unit.
    pub(crate) fn with_unit(&self, number: &str) -> String {
        match self.symbol.as_str() {
            "" | "1" => number.to_owned(),
            unit => format!("{number} {unit}"),
        }
    }

    /// The number in signs of print.
    pub(crate) fn text(&self, number: &str) -> String {
        typeset(&self.with_unit(number))
    }
}

#[cfg(test)]
mod tests {
    use procedures::quantity::QuantityKind as Q;

    use super::*;

    fn limit(kind: Q, text: &str) -> LimitFindings {
        LimitFindings::from(&kind.parse_limit(text).expect("a limit"))
    }

    #[test]
    fn a_value_is_read_in_the_unit_of_its_limit() {
        for (kind, text, si, shown) in [
            (Q::Angle, "< 75 urad", 56.25e-6, "56.25\u{a0}µrad"),
            (Q::Angle, ">= 1 mrad", 1.25e-3, "1.25\u{a0}mrad"),
            (Q::Time, "<= 3.5 ms", 2.75e-3, "2.75\u{a0}ms"),
            (Q::Frequency, "0.8 kHz .. 1.3 kHz", 1000.0, "1\u{a0}kHz"),
            (Q::SpatialOrder, "143.5 .. 144.5 1/rev", 144.0, "144 1/rev"),
            (Q::Power, "<= 6.7 kW", 6400.0, "6.4\u{a0}kW"),
            (Q::Count, ">= 24", 26.0, "26"),
            (Q::Temperature, "< 80 degC", 61.5, "61.5\u{a0}°C"),
        ] {
            let unit = Shown::of_limit(&limit(kind, text));
            assert_eq!(unit.text(&super::super::short(unit.number(si), 4)), shown, "{text}");
        }
    }

    #[test]
    fn without_a_limit_the_size_decides() {
        let of = |kind, si: f64| Shown::of_size(kind, si).text("1");
        assert_eq!(of(Q::Angle, 3e-6), "1\u{a0}µrad");
        assert_eq!(of(Q::Angle, -0.2), "1\u{a0}°");
        assert_eq!(of(Q::Angle, 0.0), "1\u{a0}°");
        assert_eq!([of(Q::Time, 2e-6), of(Q::Time, 0.0023)], ["1\u{a0}µs", "1\u{a0}ms"]);
        assert_eq!(of(Q::Torque, 1e-6), "1\u{a0}N·m");
    }
}
