//! Schemas: what ships meets them, and an editor that uses them finds mistakes.

use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, SchemaIndex, Schemas, ValidationError};
use procedures::quantity::QuantityKind;
use serde_json::{Value, json};

use crate::bench::{folder, run_in};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

struct Judge {
    schemas: Schemas,
    index: SchemaIndex,
}

impl Judge {
    fn new(schema: Value) -> Self {
        let mut schemas = Schemas::new();
        let mut compiler = Compiler::new();
        compiler.add_resource("schema.json", schema).expect("a schema");
        let index = compiler.compile("schema.json", &mut schemas).expect("a schema without mistakes");
        Self { schemas, index }
    }

    /// Where the value does not meet the schema, the deepest place first.
    fn mistakes(&self, value: &Value) -> Vec<String> {
        fn places(error: &ValidationError<'_, '_>, all: &mut Vec<String>) {
            if error.causes.is_empty() {
                all.push(format!("{}", error.instance_location));
            }
            error.causes.iter().for_each(|cause| places(cause, all));
        }
        let mut all = Vec::new();
        if let Err(error) = self.schemas.validate(value, self.index) {
            places(&error, &mut all);
        }
        all.sort_by_key(|place| (std::cmp::Reverse(place.matches('/').count()), place.clone()));
        all.dedup();
        all
    }
}

fn printed(arguments: &[&str]) -> Value {
    let folder = folder();
    let said = run_in(folder.path(), arguments);
    assert_eq!(said.code, 0, "{}", said.err);
    serde_json::from_str(&said.out).expect("JSON")
}

fn toml_files(below: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(below).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut all: Vec<PathBuf> = entries
        .flat_map(|path| if path.is_dir() { toml_files(&path) } else { vec![path] })
        .filter(|path| path.extension().is_some_and(|e| e == "toml") && !path.ends_with("Cargo.toml"))
        .collect();
    all.sort();
    all
}

fn read(text: &str) -> Option<Value> {
    toml::from_str(text).ok()
}

/// The sort of a shipped file, by what it holds.
fn sort_of(file: &Value) -> &'static str {
    let sorts = [
        ("kind", "procedure"),
        ("requirement", "requirements"),
        ("procedure", "campaign"),
        ("tier", "rig"),
        ("process-data", "profile"),
        ("pattern", "reader"),
        ("criterion", "criteria"),
        ("setting", "family"),
    ];
    sorts.iter().find(|(key, _)| file.get(key).is_some()).map_or("unit", |(_, sort)| sort)
}

#[test]
fn every_shipped_file_meets_the_schema_of_its_sort() {
    let all = printed(&["schema", "--rig", "sim"]);
    let judges =
        ["procedure", "campaign", "requirements", "rig", "unit", "family", "profile", "reader", "criteria"];
    let judges = judges.map(|sort| (sort, Judge::new(all[sort].clone())));
    let mut judged = 0;
    for folder in [
        "procedures/fat",
        "procedures/quick",
        "procedures/levels",
        "procedures",
        "bench/rigs",
        "sim-devices/units",
        "sim-devices/units/families",
        "drivers/profiles",
        "drivers/readers",
    ] {
        for path in toml_files(&Path::new(ROOT).join(folder)) {
            // Files of the one-axis table ask for axes of another rig.
            if path.to_string_lossy().contains("table") {
                continue;
            }
            let file = read(&fs::read_to_string(&path).expect("a shipped file")).expect("TOML");
            let sort = sort_of(&file);
            let judge = judges.iter().find(|(name, _)| *name == sort).expect("a sort");
            assert_eq!(judge.1.mistakes(&file), Vec::<String>::new(), "{}, a {sort}", path.display());
            judged += 1;
        }
    }
    assert!(judged > 150, "{judged}");
}

/// File of a starter folder, what stands there, what somebody writes instead.
struct Planted(&'static str, &'static str, &'static str);

const FRICTION: &str = "quick/az-friction.toml";

#[rustfmt::skip]
const PLANTED: &[Planted] = &[
    Planted(FRICTION, "schema = 1\n", ""),
    Planted(FRICTION, "schema = 1", "schema = 2"),
    Planted(FRICTION, "kind = \"hysteresis\"\n", ""),
    Planted(FRICTION, "\"hysteresis\"", "\"hysterisis\""),
    Planted(FRICTION, "\"hysteresis\"", "\"breakaway\""),
    Planted(FRICTION, "axis = \"az\"", "axis = \"elevation\""),
    Planted(FRICTION, "axis = \"az\"", "axes = \"az\""),
    Planted(FRICTION, "\"2 deg/s\", \"10", "\"2,5 deg/s\", \"10"),
    Planted(FRICTION, "\"2 deg/s\", \"10", "\".5 deg/s\", \"10"),
    Planted(FRICTION, "\"2 deg/s\", \"10", "\"2\", \"10"),
    Planted(FRICTION, "\"2 deg/s\", \"10", "2, \"10"),
    Planted(FRICTION, "\"2 deg/s\", \"10", "\"2 deg\", \"10"),
    Planted(FRICTION, "\"2 deg/s\", \"10", "\"2 degree/s\", \"10"),
    Planted(FRICTION, "\"-60 deg .. 60 deg\"", "\"-60 deg to 60 deg\""),
    Planted(FRICTION, "\"-60 deg .. 60 deg\"", "\"60 deg\""),
    Planted(FRICTION, "cycles = ", "cycles = \"two\" # "),
    Planted(FRICTION, "heat-sink = ", "heatsink = "),
    Planted(FRICTION, "[valid-if]\n", "[valid-if]\ncool-down = \"60 s\"\n"),
    Planted(FRICTION, "log-rate = \"250 Hz\"", "log-rate = \"4 ms\""),
    Planted("quick.toml", "[[stage]]\nid = \"static\"", "[[stage]]\nname = \"static\""),
    Planted("quick.toml", "requirements = ", "requirement = "),
    Planted("requirements.toml", "where = { velocity = \"<= 10 deg/s\" }", "where = { speed = \"<= 10 deg/s\" }"),
    Planted("requirements.toml", "where = { velocity = \"<= 10 deg/s\" }", "where = { velocity = \"<= 10 deg\" }"),
    Planted("requirements.toml", "limit = \"<= 260 N*m\"", "limit = \"260 N*m\""),
    Planted("requirements.toml", "\"friction-torque\", \"breakaway-torque\"]\naxis = \"az\"", "\"friction-torqe\", \"breakaway-torque\"]\naxis = \"az\""),
    Planted("requirements.toml", "method = \"test\"", "method = \"trial\""),
    Planted("requirements.toml", "axes = [\"az\", \"el\"]", "axes = \"az\""),
    Planted("sim.toml", "loop-rate = \"4 kHz\"", "loop-rate = \"250 us\""),
    Planted("sim.toml", "driver = \"kvh-1775\"", "driver = \"kvh-1757\""),
    Planted("nominal.toml", "title = ", "titel = "),
];

#[test]
fn an_editor_with_the_schemas_of_a_starter_folder_finds_planted_mistakes() {
    let folder = folder();
    assert_eq!(run_in(folder.path(), &["init", "mine"]).code, 0);
    let mine = folder.path().join("mine");
    let settings: toml::Table =
        fs::read_to_string(mine.join(".taplo.toml")).expect("settings").parse().expect("TOML");
    let rules = settings["rule"].as_array().expect("rules");
    let judge_of = |file: &str| {
        let covers = |pattern: &toml::Value| {
            let pattern = pattern.as_str().expect("a path");
            pattern == file
                || pattern.strip_suffix("*.toml").is_some_and(|dir| !dir.is_empty() && file.starts_with(dir))
        };
        let includes =
            |rule: &&toml::Value| rule["include"].as_array().is_some_and(|all| all.iter().any(covers));
        let rule = rules.iter().find(includes).unwrap_or_else(|| panic!("{file}: no rule"));
        let path = rule["schema"]["path"].as_str().expect("a path");
        let text = fs::read_to_string(mine.join(path)).expect("a schema");
        Judge::new(serde_json::from_str(&text).expect("JSON"))
    };
    let mut told = String::new();
    for Planted(file, from, to) in PLANTED {
        let judge = judge_of(file);
        let text = fs::read_to_string(mine.join(file)).expect("a starter file");
        assert_eq!(judge.mistakes(&read(&text).expect("TOML")), Vec::<String>::new(), "{file}");
        assert!(text.contains(from), "{file}: {from}");
        let changed = text.replacen(from, to, 1);
        let places = read(&changed).map(|value| judge.mistakes(&value)).expect("TOML");
        let first = places.first().unwrap_or_else(|| panic!("{file}: `{to}` is not found"));
        told += &format!("{file}: {}: at `{first}`\n", to.trim());
    }
    insta::assert_snapshot!(told);
}

#[test]
fn a_pattern_of_a_quantity_takes_every_spelling_that_the_reader_takes_and_no_other_unit() {
    let symbols: Vec<&str> = QuantityKind::ALL.into_iter().flat_map(QuantityKind::symbols).collect();
    let changes = [
        ("", ""),
        ("*", "·"),
        ("*", " "),
        ("*", " * "),
        ("N*m", "Nm"),
        ("u", "µ"),
        ("deg", "°"),
        ("^2", "²"),
        ("/", " / "),
    ];
    for kind in QuantityKind::ALL {
        let judge = Judge::new(json!({ "pattern": kind.pattern() }));
        let ranges = Judge::new(json!({ "pattern": kind.range_pattern() }));
        let limits = Judge::new(json!({ "pattern": kind.limit_pattern() }));
        for symbol in &symbols {
            for unit in changes.map(|(from, to)| symbol.replace(from, to)) {
                for number in ["2", "-2.5", "+1e3", "−1.5e-3", ".5", "2,5", "2.", ""] {
                    let text = format!("{number} {unit}");
                    let read = kind.parse(&text).is_ok();
                    assert_eq!(judge.mistakes(&json!(text)).is_empty(), read, "{kind:?}: `{text}`");
                    let limit = format!("<= {text}");
                    assert_eq!(limits.mistakes(&json!(limit)).is_empty(), read, "{kind:?}: `{limit}`");
                }
                let range = format!("1 .. 2 {unit}");
                let read = kind.parse_range(&range).is_ok();
                assert_eq!(ranges.mistakes(&json!(range)).is_empty(), read, "{kind:?}: `{range}`");
            }
        }
    }
}
