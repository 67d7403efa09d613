//! The gains in use, from the defaults of their table: what `params/director.toml` says.

use controllers::DirectorGains;
use controllers::parameter::PARAMETERS;

/// Gains of the director.
pub(crate) fn director_gains() -> DirectorGains {
    let mut gains = DirectorGains::default();
    PARAMETERS.iter().for_each(|parameter| (parameter.set)(&mut gains, si(parameter.default)));
    gains
}

/// Number part of a default, with the few prefixes and scales that occur.
fn si(text: &str) -> f64 {
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    let number: f64 = number.parse().expect("defaults begin with a number");
    match unit {
        "deg" | "deg/s" | "deg/s^2" => number.to_radians(),
        "ms" | "mrad" | "mrad/s" => number / 1000.0,
        "%" => number / 100.0,
        _ => number,
    }
}
