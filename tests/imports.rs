//! Records of other tools: a real motor's cogging map, and tables that are broken.

use std::path::Path;

use crate::bench::{Said, fixture, folder, run_in, write};

fn import(folder: &Path, map: &str) -> Said {
    run_in(folder, &["import", map, "--out", "log"])
}

/// A number that `rejudge --json` gives for a measurand, by condition where there are several.
fn measured(said: &Said, measurand: &str, order: Option<f64>) -> f64 {
    let findings: serde_json::Value = serde_json::from_str(&said.out).expect("findings are JSON");
    let all = findings["procedures"][0]["measurements"].as_array().expect("measurements").clone();
    let meets = |m: &serde_json::Value| {
        m["measurand"] == measurand
            && order.is_none_or(|o| {
                let conditions = m["conditions"].as_array().expect("conditions").clone();
                conditions.iter().any(|c| c["requested"].as_f64() == Some(o))
            })
    };
    let found =
        all.iter().find(|m| meets(m)).unwrap_or_else(|| panic!("no {measurand} {order:?} in {all:#?}"));
    found["value"].as_f64().expect("a value")
}

#[test]
fn the_real_motors_cogging_and_friction_are_those_of_its_readme() {
    let folder = folder();
    let map = fixture("odrive_cogging/import.toml");
    let said = import(folder.path(), &map.display().to_string());
    assert_eq!(said.code, 0, "{}", said.err);
    let said = run_in(folder.path(), &["rejudge", said.out.trim(), "--json"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    let friction_a = measured(&said, "friction-current", None);
    assert!((friction_a - 0.171).abs() < 0.0005, "friction {friction_a} A");
    // Amplitudes of the forward map c_16, from the record's README.
    for (order, amplitude_a) in
        [(7.0, 1.0385), (28.0, 0.5611), (36.0, 0.2915), (12.0, 0.2637), (84.0, 0.1208)]
    {
        let found = measured(&said, "cogging-current", Some(order));
        assert!(
            (found - amplitude_a).abs() < 0.05 * amplitude_a,
            "order {order}: {found} A, README {amplitude_a} A"
        );
    }
}

const MAP: &str = r#"schema = 1
procedure = "p.toml"
time = "column"
time-column = "t"
[[channel]]
channel = "position_rad"
column = "angle"
unit = "deg"
[[channel]]
channel = "current_a"
column = "i"
unit = "A"
[[segment]]
file = "d.csv"
point = "map"
branch = "forward"
"#;

fn broken(csv: &str) -> String {
    let folder = folder();
    write(folder.path(), "map.toml", MAP);
    write(folder.path(), "d.csv", csv);
    let procedure = std::fs::read_to_string(fixture("odrive_cogging/cogging.toml")).expect("a fixture");
    write(folder.path(), "p.toml", &procedure);
    let said = import(folder.path(), "map.toml");
    assert!(
        !folder.path().join("log").read_dir().is_ok_and(|mut d| d.next().is_some()),
        "no half log is left"
    );
    format!("exit {}\n{}{}", said.code, said.out, said.err)
}

#[test]
fn a_cell_that_is_no_number_is_pointed_at() {
    insta::assert_snapshot!(broken("t,angle,i\n0,1,2\n1,2,NaN\n2,3,4\n"));
}

#[test]
fn a_ragged_row_is_pointed_at() {
    insta::assert_snapshot!(broken("t,angle,i\n0,1,2\n1,2\n"));
}

#[test]
fn time_that_goes_back_is_pointed_at() {
    insta::assert_snapshot!(broken("t,angle,i\n0,1,2\n1,2,3\n0.5,2,3\n"));
}

#[test]
fn a_column_that_is_not_there_names_the_nearest() {
    insta::assert_snapshot!(broken("t,angel,i\n0,1,2\n1,2,3\n"));
}

#[test]
fn an_unknown_channel_in_a_map_names_those_there_are() {
    let folder = folder();
    write(folder.path(), "map.toml", &MAP.replacen("current_a", "curent_a", 1));
    let said = import(folder.path(), "map.toml");
    insta::assert_snapshot!(format!("exit {}\n{}", said.code, said.err));
}
