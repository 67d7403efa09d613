//! Table of the gains: reading, range checks, schema and documentation of `params/director.toml` all follow from it.

use crate::DirectorGains;

mod axes;
mod mirror;
mod pointing;
mod tracking;

/// One entry of the table: a value of the settings struct `S`, in SI units.
#[derive(Clone, Copy)]
pub struct Parameter<S> {
    /// Dotted kebab-case key, e.g. `az.velocity-kp`.
    pub key: &'static str,
    /// Name of the quantity kind as it is written in configuration files: `damping`, `stiffness`, `gain`.
    pub quantity: &'static str,
    /// Smallest and largest allowed SI value.
    pub range_si: [f64; 2],
    /// Default with its unit, as in the file, e.g. `"4.5 1/s"`.
    pub default: &'static str,
    /// What the parameter does, in one sentence.
    pub doc: &'static str,
    /// Where the default comes from.
    pub source: &'static str,
    /// Puts an SI value into the settings.
    pub set: fn(&mut S, f64),
    /// Reads the SI value back from the settings.
    pub get: fn(&S) -> f64,
}

pub use axes::AXIS_PARAMETERS;

/// Key in the section of each axis that names the law of its velocity loop, one of [`crate::velocity::LAWS`]. Its value
/// is a word, and the default is the first of the laws.
pub const VELOCITY_LAW: &str = "velocity-law";

/// The tables of the submodules.
const THEMES: [&[Parameter<DirectorGains>]; 4] =
    [axes::AXES, pointing::POINTING, tracking::TRACKING, mirror::MIRROR];

/// Number of all parameters. Loops in constants are written with `while`: constant evaluation has no iterators.
const COUNT: usize = {
    let mut count = 0;
    let mut theme = 0;
    while theme < THEMES.len() {
        count += THEMES[theme].len();
        theme += 1;
    }
    count
};

/// All themes, one after the other.
const ALL: [Parameter<DirectorGains>; COUNT] = {
    // The first entry only fills the array: each place is overwritten below.
    let mut all = [THEMES[0][0]; COUNT];
    let mut next = 0;
    let mut theme = 0;
    while theme < THEMES.len() {
        let mut k = 0;
        while k < THEMES[theme].len() {
            all[next] = THEMES[theme][k];
            next += 1;
            k += 1;
        }
        theme += 1;
    }
    all
};

/// All parameters of `params/director.toml`.
pub const PARAMETERS: &[Parameter<DirectorGains>] = &ALL;

#[cfg(test)]
pub(crate) mod tests {
    use std::collections::BTreeMap;
    use std::string::String;
    use std::{format, vec::Vec};

    use super::*;

    /// Values of the shipped file by dotted key: `velocity-kp` in the table `[az]` becomes `az.velocity-kp`.
    fn shipped() -> BTreeMap<String, String> {
        let mut table = String::new();
        let mut values = BTreeMap::new();
        for line in include_str!("../params/director.toml").lines() {
            if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
                table = format!("{name}.");
            } else if let Some((key, value)) = line.split_once(" = \"") {
                values.insert(format!("{table}{key}"), String::from(value.trim_end_matches('"')));
            }
        }
        values
    }

    #[test]
    fn shipped_file_holds_each_parameter_at_its_default() {
        let mut values = shipped();
        assert_eq!(values.remove("id").as_deref(), Some("director"));
        let expected: Vec<_> = PARAMETERS.iter().map(|parameter| parameter.key).collect();
        let mut keys: Vec<_> = values.keys().map(String::as_str).collect();
        keys.sort_by_key(|key| expected.iter().position(|known| known == key));
        assert_eq!(keys, expected);
        for parameter in PARAMETERS {
            assert_eq!(values[parameter.key], parameter.default, "{}", parameter.key);
        }
    }

    /// SI value of a default such as `4.5 1/s`. Only the units that occur in the table are known.
    fn si(text: &str) -> f64 {
        let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
        let number: f64 = number.parse().expect("defaults begin with a number");
        match unit {
            "deg" | "deg/s" | "deg/s^2" => number.to_radians(),
            "ms" | "mrad" | "mrad/s" => number / 1000.0,
            "" | "s" | "1/s" | "1/s^2" | "Hz" | "N*m*s/rad" | "N*m/rad" => number,
            unknown => panic!("unit {unknown} is not known to this test"),
        }
    }

    /// The gains with all parameters at their defaults, which are those of the shipped file.
    pub(crate) fn shipped_gains() -> DirectorGains {
        let mut gains = DirectorGains::default();
        PARAMETERS.iter().for_each(|parameter| (parameter.set)(&mut gains, si(parameter.default)));
        gains
    }

    #[test]
    fn each_default_is_in_range_and_comes_back() {
        let gains = shipped_gains();
        for parameter in PARAMETERS {
            let value = si(parameter.default);
            let [least, most] = parameter.range_si;
            assert!((least..=most).contains(&value), "{}", parameter.key);
            assert_eq!((parameter.get)(&gains), value, "{}", parameter.key);
        }
        assert_eq!(gains.el.velocity_ki_nm_per_rad, 361_400.0);
        assert_eq!(gains.mirror.double_integral_per_s2, 100_000.0);
    }

    #[test]
    fn each_parameter_sets_its_own_field_and_no_other() {
        for parameter in PARAMETERS {
            let mut gains = DirectorGains::default();
            (parameter.set)(&mut gains, 1.0);
            for other in PARAMETERS {
                let expected = if other.key == parameter.key { 1.0 } else { 0.0 };
                assert_eq!((other.get)(&gains), expected, "{} against {}", parameter.key, other.key);
            }
        }
    }

    #[test]
    fn track_gains_are_the_fit() {
        let gains = shipped_gains();
        assert_eq!((gains.az.track.gain_per_s, gains.el.track.gain_per_s), (4.95, 5.51));
    }

    #[test]
    fn keys_have_one_dot_and_every_value_is_documented() {
        for parameter in PARAMETERS {
            assert_eq!(parameter.key.split('.').count(), 2, "{}", parameter.key);
            assert!(parameter.doc.ends_with('.') && !parameter.source.is_empty(), "{}", parameter.key);
        }
    }
}
