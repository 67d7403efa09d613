//! Records of other tools: a real motor's cogging map, and tables that are broken.

use std::path::Path;

use crate::bench::{Said, fixture, folder, run_in, write};

fn import(folder: &Path, map: &str) -> Said {
    run_in(folder, &["import", map, "--out", "log"])
}

/// All measurements of the first procedure that `rejudge --json` printed.
fn measurements(said: &Said) -> Vec<serde_json::Value> {
    let findings: serde_json::Value = serde_json::from_str(&said.out).expect("findings are JSON");
    findings["procedures"][0]["measurements"].as_array().expect("measurements").clone()
}

/// The value of the measurement with exactly these conditions.
fn value(all: &[serde_json::Value], measurand: &str, conditions: &[(&str, f64)]) -> f64 {
    let meets = |m: &&serde_json::Value| {
        let found = m["conditions"].as_array().expect("conditions");
        let holds = |(name, at): &(&str, f64)| {
            found.iter().any(|c| c["name"] == *name && c["requested"].as_f64() == Some(*at))
        };
        m["measurand"] == measurand && found.len() == conditions.len() && conditions.iter().all(holds)
    };
    let found = all.iter().find(meets).unwrap_or_else(|| panic!("no {measurand} {conditions:?}"));
    found["value"].as_f64().expect("a value")
}

/// Amplitudes in A from the record's README: order, forward map c_16, reverse map e_16r.
const README: [(f64, f64, f64); 6] = [
    (7.0, 1.0385, 1.0413),
    (12.0, 0.2637, 0.2708),
    (14.0, 0.3452, 0.3513),
    (28.0, 0.5611, 0.5614),
    (36.0, 0.2915, 0.301),
    (84.0, 0.1208, 0.1331),
];

#[test]
fn the_real_motors_cogging_and_friction_are_those_of_its_readme() {
    let folder = folder();
    let map = fixture("odrive_cogging/import.toml");
    let said = import(folder.path(), &map.display().to_string());
    assert_eq!(said.code, 0, "{}", said.err);
    let said = run_in(folder.path(), &["rejudge", said.out.trim(), "--json"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    let all = measurements(&said);
    let friction_a = value(&all, "friction-current", &[]);
    assert!((friction_a - 0.171).abs() < 0.0005, "friction {friction_a} A");
    for (order, forward_a, reverse_a) in README {
        for (direction, printed_a) in [(1.0, forward_a), (-1.0, reverse_a)] {
            let conditions = [("order", order), ("direction", direction)];
            let found_a = value(&all, "cogging-harmonic-current", &conditions);
            assert!((found_a - printed_a).abs() < 1e-4, "{conditions:?}: {found_a} A, README {printed_a} A");
        }
    }
    // The eight largest orders, largest first, as the README lists them.
    let mean = |m: &&serde_json::Value| {
        m["measurand"] == "cogging-harmonic-current"
            && m["conditions"].as_array().is_some_and(|c| c.len() == 1)
    };
    let mut lines: Vec<(f64, f64)> = all
        .iter()
        .filter(mean)
        .map(|m| {
            (
                m["value"].as_f64().expect("a value"),
                m["conditions"][0]["requested"].as_f64().expect("an order"),
            )
        })
        .collect();
    lines.sort_by(|a, b| b.0.total_cmp(&a.0));
    let orders: Vec<f64> = lines.iter().take(8).map(|l| l.1).collect();
    assert_eq!(orders, [7.0, 28.0, 14.0, 36.0, 12.0, 84.0, 21.0, 56.0]);
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
