use procedures::requirement::Requirements;
use sim_devices::unit::{CURVES, PARAMETERS, UnitSettings};

use super::*;
use crate::files::settings;
use crate::files::shipped::{self, Folder};

fn load(name: &str) -> Unit {
    load_unit(name).unwrap_or_else(|mistakes| panic!("{name}: {}", mistakes[0]))
}

#[test]
fn the_shipped_nominal_file_is_the_unit_built_in() {
    let unit = load("nominal");
    let built_in = UnitSettings::default();
    let settings = unit.director().expect("a director");
    assert_eq!(settings.az_structure, built_in.az_structure);
    assert_eq!(settings.el_structure, built_in.el_structure);
    for p in PARAMETERS.iter() {
        let found = p.get(settings);
        let expected = p.get(&built_in);
        // Unit conversions round in the last digit.
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{}: {found}, not {expected}", p.key);
    }
    let text = &unit.sources[0].text;
    for curve in CURVES.iter().filter(|c| !c.get(settings).is_empty()) {
        assert!(text.contains(&format!("\n{} = [", curve.key)), "{} is not spelt out", curve.key);
    }
}

/// A file that differs from the unit built in is read, not passed over: every curve is taken from the file.
#[test]
fn each_curve_of_a_file_reaches_its_own_place() {
    for curve in CURVES.iter().filter(|c| !c.ascending) {
        let mut expected = UnitSettings::default();
        let count = expected.az_structure.elevation_rad.len();
        let value = 0.5 * (curve.range_si[0].max(0.0) + curve.range_si[1].min(0.8));
        curve.set(&mut expected, vec![value; count]);
        let kind = settings::quantity_kind(curve.quantity).expect("curves name known kinds");
        let item = format!("\"{value} {}\"", kind.si_unit().trim_start_matches('1').trim());
        let item = if curve.quantity == "inverse-inertia" { format!("\"{value} 1/(kg*m^2)\"") } else { item };
        let text = format!(
            "schema = 1\nid = \"u\"\ntitle = \"U\"\n[{}]\n{} = [{}]\n",
            curve.table,
            curve.key,
            [item.as_str(); 11].join(", ")
        );
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("u.toml");
        std::fs::write(&path, text).expect("a writable folder");
        let found = load_unit(&path.display().to_string());
        let absent = curve.key.starts_with("mode-") && curve.get(&UnitSettings::default()).is_empty();
        match found {
            Ok(unit) => {
                assert!(!absent && unit.director() == Some(&expected), "{} {}", curve.table, curve.key)
            }
            Err(mistakes) => {
                assert!(absent && mistakes[0].message.contains("is incomplete"), "{}", mistakes[0]);
            }
        }
    }
}

#[test]
fn every_shipped_unit_loads_and_every_defect_says_what_it_must_do_and_why() {
    let of_file = |name: &str| {
        shipped::find(Folder::Procedures, name, None)
            .and_then(|source| Requirements::parse(&source))
            .expect("the shipped requirements are valid")
    };
    let of_director = of_file("requirements");
    let of_table = of_file("table-requirements");
    for embedded in shipped::all(Folder::Units) {
        let unit = load(embedded.stem());
        assert_eq!(unit.id, embedded.stem(), "the id is the name of the file");
        let requirements = if unit.director().is_some() { &of_director } else { &of_table };
        let ids: Vec<&str> = requirements.all.iter().map(|r| r.id.as_str()).collect();
        for id in unit.must_flip.iter().chain(&unit.may_flip) {
            assert!(ids.contains(&id.as_str()), "{}: no requirement {id}", unit.id);
        }
        assert!(unit.may_flip.iter().all(|id| !unit.must_flip.contains(id)), "{}: must or may?", unit.id);
        if embedded.path.starts_with("defects/") {
            assert!(unit.must_flip.is_empty() == unit.must_trip.is_some(), "{}: flips or trips", unit.id);
            assert!(unit.reason.is_some_and(|r| r.len() > 20), "{}: no reason", embedded.path);
            let base = match &unit.world {
                World::Director(_) => World::Director(Box::default()),
                World::Table(_) => load("table").world,
            };
            assert_ne!(unit.world, base, "{} changes nothing", embedded.path);
        }
    }
}

/// Director facts §8: c1 of the gyro × 0.8, rigid gain clipped to 0.97…1.06 (azimuth) and 0.98…1.04 (elevation).
#[test]
fn nominal_is_as_measured_with_a_smaller_first_mode_and_a_narrower_gain() {
    let settings = |name: &str| load(name).director().expect("a director").clone();
    let nominal = settings("nominal");
    let measured = settings("as-measured");
    let pairs = [
        (&nominal.az_structure, &measured.az_structure, [0.97, 1.06]),
        (&nominal.el_structure, &measured.el_structure, [0.98, 1.04]),
    ];
    for (ours, theirs, [least, most]) in pairs {
        assert_eq!(ours.elevation_rad, theirs.elevation_rad);
        for (ours, theirs) in ours.rigid_gain_ratio.iter().zip(&theirs.rigid_gain_ratio) {
            assert_eq!(*ours, theirs.clamp(least, most));
        }
        for (ours, theirs) in ours.modes[0].gyro_per_kg_m2.iter().zip(&theirs.modes[0].gyro_per_kg_m2) {
            assert!((ours / theirs - 0.8).abs() < 1e-9, "{ours} against {theirs}");
        }
        assert_eq!(ours.modes[1..], theirs.modes[1..]);
    }
}

/// Whoever adds a switch, a sign or a kind lists what it may be.
#[test]
fn every_switch_and_sign_is_listed_with_what_it_may_be() {
    let begins = ["+1 or -1:", "0 fixed", "1: "];
    for (described, rules) in [
        (described(), values::OF_DIRECTOR),
        (described_table(), values::OF_TABLE),
        (described_axis(), values::OF_TABLE_AXIS),
    ] {
        let listed: Vec<&str> = rules.allowed.iter().map(|(key, _)| *key).collect();
        for d in described.iter().filter(|d| begins.iter().any(|words| d.doc.starts_with(words))) {
            assert!(listed.contains(&d.key), "{}", d.key);
        }
        let ordered = rules.ordered.iter().flat_map(|pair| pair.keys);
        for key in listed.iter().copied().chain(ordered) {
            assert!(described.iter().any(|d| d.key == key), "no setting {key}");
        }
    }
}
