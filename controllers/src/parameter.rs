//! Gains as data: one table drives reading, range checks, schema and documentation of `params/director.toml`.

use crate::DirectorGains;

/// One value of a settings struct `S`; it is SI.
pub struct Parameter<S> {
    /// Dotted kebab-case key, e.g. `az.velocity-kp`.
    pub key: &'static str,
    /// Name of the quantity kind, as in people's files: `damping`, `stiffness`, `gain`.
    pub quantity: &'static str,
    /// Smallest allowed SI value.
    pub min_si: f64,
    /// Largest allowed SI value.
    pub max_si: f64,
    /// Default as a person would write it, e.g. `"4.5 1/s"`.
    pub default: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// Where the figure comes from.
    pub source: &'static str,
    /// Puts a value into the settings.
    pub set: fn(&mut S, f64),
    /// Reads it back.
    pub get: fn(&S) -> f64,
}

const VELOCITY_FIT: &str = "fit of the discrete loop to the published margins, elevation -10 to 90 deg";
const POSITION_FIT: &str = "fit to the published step responses of azimuth";
const KP_DOC: &str = "Torque per velocity error.";
const KI_DOC: &str = "Torque per integrated velocity error; 0 switches the integral off.";
const POSITION_DOC: &str = "Velocity command per position error.";

/// Every value of `params/director.toml`.
pub const PARAMETERS: &[Parameter<DirectorGains>] = &[
    Parameter {
        key: "az.velocity-kp",
        quantity: "damping",
        min_si: 0.0,
        max_si: 1e6,
        default: "23600 N*m*s/rad",
        doc: KP_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.az.velocity_kp_nm_s_per_rad = value,
        get: |gains| gains.az.velocity_kp_nm_s_per_rad,
    },
    Parameter {
        key: "az.velocity-ki",
        quantity: "stiffness",
        min_si: 0.0,
        max_si: 1e8,
        default: "447500 N*m/rad",
        doc: KI_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.az.velocity_ki_nm_per_rad = value,
        get: |gains| gains.az.velocity_ki_nm_per_rad,
    },
    Parameter {
        key: "az.position-gain",
        quantity: "gain",
        min_si: 0.0,
        max_si: 100.0,
        default: "4.5 1/s",
        doc: POSITION_DOC,
        source: POSITION_FIT,
        set: |gains, value| gains.az.position_gain_per_s = value,
        get: |gains| gains.az.position_gain_per_s,
    },
    Parameter {
        key: "el.velocity-kp",
        quantity: "damping",
        min_si: 0.0,
        max_si: 1e6,
        default: "18250 N*m*s/rad",
        doc: KP_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.el.velocity_kp_nm_s_per_rad = value,
        get: |gains| gains.el.velocity_kp_nm_s_per_rad,
    },
    Parameter {
        key: "el.velocity-ki",
        quantity: "stiffness",
        min_si: 0.0,
        max_si: 1e8,
        default: "361400 N*m/rad",
        doc: KI_DOC,
        source: VELOCITY_FIT,
        set: |gains, value| gains.el.velocity_ki_nm_per_rad = value,
        get: |gains| gains.el.velocity_ki_nm_per_rad,
    },
    Parameter {
        key: "el.position-gain",
        quantity: "gain",
        min_si: 0.0,
        max_si: 100.0,
        default: "4.5 1/s",
        doc: POSITION_DOC,
        source: "as azimuth: elevation steps of 0.3 deg settle as azimuth's with it",
        set: |gains, value| gains.el.position_gain_per_s = value,
        get: |gains| gains.el.position_gain_per_s,
    },
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::string::String;
    use std::{format, vec::Vec};

    use super::*;

    /// Key → quoted value of the shipped file, `[az]` in front of its keys.
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

    #[test]
    fn each_parameter_sets_and_reads_its_own_field_and_its_default_is_in_range() {
        let mut gains = DirectorGains::default();
        for parameter in PARAMETERS {
            let number = parameter.default.split(' ').next().expect("split yields at least one piece");
            let value: f64 = number.parse().expect("defaults begin with a number");
            assert!((parameter.min_si..=parameter.max_si).contains(&value));
            assert_eq!((parameter.get)(&gains), 0.0, "{} is set by another parameter", parameter.key);
            (parameter.set)(&mut gains, value);
            assert_eq!((parameter.get)(&gains), value);
        }
        assert_eq!(gains.el.velocity_ki_nm_per_rad, 361_400.0);
    }
}
