//! The units of the blind test: those of the family `production` with seed 0, and of these with what the family `in-service` adds.

use std::sync::LazyLock;

use bench::files::family::{Family, load_family};
use procedures::quantity::QuantityKind;

static PRODUCTION: LazyLock<Family> = LazyLock::new(|| family("production"));
static IN_SERVICE: LazyLock<Family> = LazyLock::new(|| family("in-service"));
/// Another seed than that of the production: with the same one both families would have one random stream.
const SERVICE_SEED: u64 = 1;

fn family(name: &str) -> Family {
    load_family(name).unwrap_or_else(|mistakes| panic!("{mistakes:?}"))
}

/// The file of a unit.
pub fn unit(id: &str, number: u32) -> String {
    let settings = PRODUCTION.settings(0, number);
    format!("schema = 1\nid = \"{id}\"\ntitle = \"Drawn unit {number}\"\nbase = \"nominal\"\n{settings}")
}

/// The file of a unit in service: the drawn one, with play, slip, wear and drifts.
///
/// # Panics
/// Where both families draw one setting.
pub fn unit_in_service(id: &str, number: u32) -> String {
    let mut file: toml::Table = unit(id, number).parse().expect("a drawn unit");
    let added: toml::Table = IN_SERVICE.settings(SERVICE_SEED, number).parse().expect("a drawn unit");
    for (key, value) in added {
        let toml::Value::Table(settings) = value else {
            assert!(file.insert(key, value).is_none(), "both families draw one setting");
            continue;
        };
        let own = file.entry(key).or_insert_with(|| toml::Table::new().into());
        let own = own.as_table_mut().expect("a table of settings");
        for (key, value) in settings {
            assert!(own.insert(key, value).is_none(), "both families draw one setting");
        }
    }
    file.to_string()
}

/// A value as a person would write it, to six digits: what is read back is the truth.
pub fn text(quantity: &str, value: f64) -> String {
    let name = serde_json::Value::String(quantity.to_owned());
    let kind: QuantityKind = serde_json::from_value(name).expect("settings name kinds of quantity");
    kind.format(value)
}

#[cfg(test)]
mod tests {
    use bench::files::unit::load_unit;
    use bench::record::journal::sha256;

    use super::*;

    /// Units with the SHA-256 of their files. The results in `docs/blind.md` are those of these units.
    #[rustfmt::skip]
    const PUBLISHED: [(u32, &str); 8] = [
        (1, "367e46592ad065028b4a0aac55df71343d347d6a6a150cb7e2dcdd2460e87a0e"),
        (2, "cb7bdb0b99090ce34df4cc7c5d827dd7481abbaf803a54a602169649fd1fde64"),
        (3, "364797d8f0cb80e1625a24880a3bbefa487ea5dd6dcca1559fad2af66c5702a4"),
        (4, "5890a696b146e18eaebeb7f43cdfbc60d5298880f02437f522e4814fb3eb7a3a"),
        (501, "af886ea0e2d279d1ec83ea2b45705fc64a46b71349eed265fab977e3b7701533"),
        (502, "32b36ac80eb26612b41656f6c9559afbcb3928dac79b221456707be6f38cb549"),
        (503, "8da7595a2aed730fd97252b0d000daedb7ab2f6894ccfea7d881ad09eab1acae"),
        (504, "981c196c16c8d4330a4e0f4b2d42964101a638f093a06848445b52bfa0f16b74"),
    ];

    #[test]
    fn the_units_of_the_published_blind_test_are_still_drawn() {
        for (number, digest) in PUBLISHED {
            assert_eq!(sha256(unit(&format!("unit-{number}"), number).as_bytes()), digest, "unit {number}");
        }
    }

    #[test]
    fn every_drawn_unit_is_a_good_file_and_another_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let files: Vec<String> = (1..=4).map(|number| unit("drawn", number)).collect();
        assert!(files.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(unit("drawn", 3), files[2], "the same number is the same unit");
        for (k, text) in files.iter().enumerate() {
            let path = folder.path().join(format!("drawn-{k}.toml"));
            std::fs::write(&path, text).expect("a writable folder");
            let unit = load_unit(path.to_str().expect("a plain path"));
            assert!(unit.is_ok_and(|unit| unit.director().is_some()), "{text}");
        }
    }
}
