use super::*;

/// Number part of a default, with the few prefixes and scales that occur.
fn si(text: &str) -> f64 {
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    let number: f64 = number.parse().expect("defaults begin with a number");
    match unit {
        "deg" => number.to_radians(),
        "deg/h" => number.to_radians() / 3600.0,
        "deg/sqrt(h)" => number.to_radians() / 60.0,
        "m/s/sqrt(h)" => number / 60.0,
        "%" => number / 100.0,
        "ms" | "mm" | "mrad" => number / 1000.0,
        "us" | "um" | "urad" | "urad/s" | "urad/V" | "uF" | "ppm" => number / 1.0e6,
        "kHz" | "kohm" => number * 1000.0,
        "mg" => number * 9.806_65e-3,
        "ug" => number * 9.806_65e-6,
        _ => number,
    }
}

#[test]
fn the_default_unit_is_what_the_table_says() {
    let unit = UnitSettings::default();
    for parameter in PARAMETERS.iter() {
        let found = parameter.get(&unit);
        let expected = si(parameter.default);
        assert!(
            (found - expected).abs() <= 1e-12 * expected.abs(),
            "{}: {found} is not {expected}",
            parameter.key
        );
        assert!(parameter.allows(found), "{} out of range", parameter.key);
    }
}

#[test]
fn every_setting_reaches_its_own_field_and_no_other() {
    for (k, parameter) in PARAMETERS.iter().enumerate() {
        let mut unit = UnitSettings::default();
        parameter.set(&mut unit, 0.123_456);
        for (other_k, other) in PARAMETERS.iter().enumerate() {
            assert_eq!(
                other.get(&unit) == 0.123_456,
                k == other_k,
                "{} against {}",
                parameter.key,
                other.key
            );
        }
    }
}

#[test]
fn keys_are_unique_and_kebab_case() {
    let mut keys: Vec<&str> = PARAMETERS.iter().map(|parameter| parameter.key).collect();
    assert!(keys.iter().all(|key| key.chars().all(|c| c.is_ascii_lowercase() || c == '-' || c == '.')));
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), PARAMETERS.len());
}

/// Dotted keys of a unit file with their texts.
fn listed(text: &str) -> Vec<(String, String)> {
    let mut table = "";
    let mut listed = Vec::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            table = name;
        } else if let Some((key, rest)) = line.split_once(" = \"") {
            let value = rest.split('"').next().unwrap_or_default();
            let key = if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") };
            listed.push((key, value.to_owned()));
        }
    }
    listed
}

/// The file is what people copy from, so it must spell out every default.
#[test]
fn the_shipped_nominal_file_lists_every_setting_with_its_default() {
    let listed = listed(include_str!("../../units/nominal.toml"));
    for parameter in PARAMETERS.iter() {
        let entry = (parameter.key.to_owned(), parameter.default.to_owned());
        assert!(listed.contains(&entry), "{entry:?} is not in units/nominal.toml");
    }
}

#[test]
fn the_retainer_defect_follows_the_line_15_omega_plus_380() {
    let text = include_str!("../../units/defects/azimuth-retainer.toml");
    let value = |key: &str| {
        let line = text.lines().find(|line| line.starts_with(key)).expect("the defect names this key");
        si(line.split('"').nth(1).expect("values are quoted"))
    };
    assert_eq!(value("coulomb-torque"), value("static-torque"));
    for (deg_per_s, nm) in [(3.5_f64, 432.0), (10.0, 530.0), (20.0, 680.0)] {
        let torque = value("coulomb-torque") + value("viscous-damping") * deg_per_s.to_radians();
        assert!((torque - nm).abs() < 1.0, "{torque} at {deg_per_s} deg/s");
    }
}

#[test]
fn the_table_built_in_is_what_its_lists_say() {
    let table = TableSettings::with_axes(&["table"]);
    for parameter in TABLE_PARAMETERS.iter() {
        let found = parameter.get(&table);
        let expected = si(parameter.default);
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{}: {found}", parameter.key);
        assert!(parameter.allows(found), "{} out of range", parameter.key);
    }
    for parameter in AXIS_PARAMETERS.iter() {
        let found = parameter.get(&table.axes[0].settings);
        let expected = si(parameter.default);
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{}: {found}", parameter.key);
        assert!(parameter.allows(found), "{} out of range", parameter.key);
    }
}

#[test]
fn every_setting_of_a_table_reaches_its_own_field_and_no_other() {
    for (k, parameter) in TABLE_PARAMETERS.iter().enumerate() {
        let mut table = TableSettings::without_axes();
        parameter.set(&mut table, 0.123_456);
        for (other_k, other) in TABLE_PARAMETERS.iter().enumerate() {
            assert_eq!(other.get(&table) == 0.123_456, k == other_k, "{}, {}", parameter.key, other.key);
        }
    }
    for (k, parameter) in AXIS_PARAMETERS.iter().enumerate() {
        let mut axis = TableAxis::new("table").settings;
        parameter.set(&mut axis, 0.123_456);
        for (other_k, other) in AXIS_PARAMETERS.iter().enumerate() {
            assert_eq!(other.get(&axis) == 0.123_456, k == other_k, "{}, {}", parameter.key, other.key);
        }
    }
}

/// The file is what people copy from, so it must spell out every default.
#[test]
fn the_shipped_table_file_lists_every_setting_with_its_default() {
    let listed = listed(include_str!("../../units/table.toml"));
    let whole = TABLE_PARAMETERS.iter().map(|p| (p.key.to_owned(), p.default.to_owned()));
    let axis = AXIS_PARAMETERS.iter().map(|p| (format!("axis.table.{}", p.key), p.default.to_owned()));
    for entry in whole.chain(axis) {
        assert!(listed.contains(&entry), "{entry:?} is not in units/table.toml");
    }
}
