//! A rotary table as a unit: its files, its pages, and a variant with three axes that is files only.

use std::time::Duration;

use drivers::wire::SdoRequest;
use std::path::Path;

use bench::files::unit::load_unit;
use bench::site::unit::{Unit, World};
use sim_devices::rig::{SeedAddress, SimulatedTable};
use sim_devices::unit::{AXIS_PARAMETERS, TABLE_PARAMETERS, TableSettings};

use crate::bench::{folder, run_in, verdict, write};

const HEAD: &str = "schema = 1\nid = \"mine\"\ntitle = \"Mine\"\nworld = \"table\"\n";

/// A flight motion simulator: three axes of different size, which no code knows of.
const THREE_AXES: &str = r#"
schema = 1
id = "motion-simulator"
title = "Three axes, the innermost the lightest"
world = "table"

[axis.yaw]
inertia = "60 kg*m^2"
coulomb-torque = "20 N*m"
static-torque = "24 N*m"
torque-constant = "15 N*m/A"
rated-torque = "30 N*m"

[axis.pitch]
inertia = "25 kg*m^2"
unbalance = "3 N*m"

[axis.roll]
inertia = "4 kg*m^2"
lower-stop = "-175 deg"
upper-stop = "175 deg"

[supply]
continuous-current = "40 A"
"#;

fn settings(unit: &Unit) -> &TableSettings {
    match &unit.world {
        World::Table(settings) => settings,
        World::Director(_) => panic!("{} is a director", unit.id),
    }
}

/// What `bench explain` says of the unit `unit.toml` of this folder.
fn explained(folder: &Path) -> String {
    let said = run_in(folder, &["explain", "./unit.toml"]);
    format!("exit {}\n{}{}", said.code, said.out, said.err)
}

/// What is said of a table with these lines.
fn refused(lines: &str) -> String {
    let folder = folder();
    write(folder.path(), "unit.toml", &format!("{HEAD}{lines}"));
    explained(folder.path())
}

#[test]
fn the_shipped_table_has_one_axis_and_meets_the_settings_built_in() {
    let unit = load_unit("table").expect("a shipped unit");
    let built_in = TableSettings::with_axes(&["table"]);
    let found = settings(&unit);
    assert_eq!(found.axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), ["table"]);
    for p in AXIS_PARAMETERS.iter() {
        let [value, expected] = [found, &built_in].map(|table| p.get(&table.axes[0].settings));
        // Unit conversions round in the last digit.
        assert!((value - expected).abs() <= 1e-12 * expected.abs(), "{}: {value}, not {expected}", p.key);
    }
    assert!(unit.director().is_none());
}

#[test]
fn the_planted_fault_lies_over_the_table_and_changes_friction_only() {
    let sound = load_unit("table");
    let faulty = load_unit("table-friction");
    let sound = sound.expect("a shipped unit");
    let faulty = faulty.expect("a shipped defect");
    let [sound_axis, faulty_axis] = [&sound, &faulty].map(|unit| &settings(unit).axes[0].settings);
    let changed: Vec<&str> =
        AXIS_PARAMETERS.iter().filter(|p| p.get(sound_axis) != p.get(faulty_axis)).map(|p| p.key).collect();
    assert_eq!(changed, ["coulomb-torque", "static-torque", "viscous-damping"]);
    for p in AXIS_PARAMETERS.iter().filter(|p| changed.contains(&p.key)) {
        assert!((p.get(faulty_axis) / p.get(sound_axis) - 1.3).abs() < 1e-12, "{}", p.key);
    }
    assert!(faulty.is_defect());
    assert_eq!(faulty.must_flip, ["TAB-FRC"]);
}

#[test]
fn mistakes_in_the_tables_of_axes_come_at_once_with_the_nearest_key() {
    insta::assert_snapshot!(refused(
        "step-rate = \"1 kHz\"\n[axis.table]\ninertai = \"12 kg*m^2\"\ncoulomb-torque = \"-5 N*m\"\nencoder-bits = \"26 deg\"\n[az]\ninertia = \"3 kg*m^2\"\n"
    ));
}

#[test]
fn settings_of_an_axis_that_contradict_each_other_are_pointed_at() {
    insta::assert_snapshot!(refused(
        "[axis.first]\nlower-stop = \"175 deg\"\nencoder-bits = \"20.5\"\n[axis.second]\nstatic-torque = \"4 N*m\"\nmotor-sign = \"0\"\n[wiring]\nvendor = \"1.5\"\n"
    ));
}

#[test]
fn a_table_without_axes_and_one_with_five_are_refused() {
    let five: String = (1..=5).map(|k| format!("[axis.a{k}]\ninertia = \"2 kg*m^2\"\n")).collect();
    insta::assert_snapshot!(format!("{}\n{}", refused(""), refused(&five)));
}

#[test]
fn a_name_that_cannot_stand_in_a_log_is_refused() {
    insta::assert_snapshot!(refused("[axis.Yaw]\n[axis.\"roll axis\"]\n[axis]\npitch = 3\n"));
}

#[test]
fn an_axis_too_many_over_a_base_is_pointed_at_where_it_is_added() {
    let folder = folder();
    let of_base: String = (1..=3).map(|k| format!("[axis.a{k}]\n")).collect();
    write(folder.path(), "below.toml", &format!("{HEAD}{of_base}"));
    let more = "base = \"below.toml\"\n[axis.a2]\ninertia = \"2 kg*m^2\"\n[axis.b1]\n[axis.b2]\n";
    write(folder.path(), "unit.toml", &format!("{HEAD}{more}"));
    insta::assert_snapshot!(explained(folder.path()));
}

#[test]
fn a_table_over_a_director_is_refused_and_so_is_a_director_over_a_table() {
    let of_table = refused("base = \"nominal\"\n[axis.table]\n");
    let folder = folder();
    write(folder.path(), "unit.toml", "schema = 1\nid = \"mine\"\ntitle = \"Mine\"\nbase = \"table\"\n");
    insta::assert_snapshot!(format!("{of_table}\n{}", explained(folder.path())));
}

#[test]
fn a_world_that_nobody_knows_is_answered_with_those_that_there_are() {
    let folder = folder();
    write(folder.path(), "unit.toml", &HEAD.replace("\"table\"", "\"turntable\""));
    insta::assert_snapshot!(explained(folder.path()));
}

#[test]
fn the_settings_of_a_base_hold_where_the_file_above_is_silent() {
    let folder = folder();
    write(folder.path(), "below.toml", THREE_AXES);
    let text = format!("{HEAD}base = \"below.toml\"\n[axis.roll]\ninertia = \"5 kg*m^2\"\n");
    let path = write(folder.path(), "unit.toml", &text);
    let unit = load_unit(&path.display().to_string()).expect("it fits");
    let axes = &settings(&unit).axes;
    assert_eq!(axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), ["yaw", "pitch", "roll"]);
    let inertias: Vec<f64> = axes.iter().map(|axis| axis.settings.inertia_kg_m2).collect();
    assert_eq!(inertias, [60.0, 25.0, 5.0]);
    assert!((axes[2].settings.upper_stop_rad - 175.0_f64.to_radians()).abs() < 1e-12);
    assert_eq!(settings(&unit).supply.continuous_current_a, 40.0);
}

#[test]
fn three_axes_are_files_only_and_answer_on_three_stations() {
    let folder = folder();
    let path = write(folder.path(), "unit.toml", THREE_AXES);
    let unit = load_unit(&path.display().to_string()).expect("it fits");
    let address = SeedAddress { seed: 1, procedure: "TEST".to_owned(), point: "1".to_owned() };
    let poses = [("pitch".to_owned(), 0.5)].into_iter().collect();
    let rig = SimulatedTable::new(settings(&unit), &address, &poses);
    let mut bus = rig.bus();
    assert_eq!(bus.stations(), [1, 2, 3]);
    let rated_mnm = |bus: &mut dyn drivers::wire::Fieldbus, station: u16| {
        let mut bytes = Vec::new();
        bus.start(Duration::ZERO, &SdoRequest { station, index: 0x6076, sub: 0, write: None });
        assert_eq!(bus.poll(Duration::ZERO, &mut bytes), Ok(true), "a simulated mailbox answers at once");
        u32::from_le_bytes(bytes.try_into().expect("32 bits"))
    };
    let rated: Vec<u32> = (1..=3).map(|station| rated_mnm(&mut *bus, station)).collect();
    assert_eq!(rated, [30_000, 12_000, 12_000]);
    let angles: Vec<f64> = rig.truth_of_axes().iter().map(|axis| axis.angle_rad).collect();
    assert_eq!(angles, [0.0, 0.5, 0.0]);
}

#[test]
fn a_table_on_the_rig_of_the_director_is_refused_in_words() {
    let folder = folder();
    let said = run_in(folder.path(), &["check", "quick/az-friction", "--unit", "table"]);
    insta::assert_snapshot!(format!("exit {}\n{}{}", said.code, said.out, said.err));
}

#[test]
fn explain_documents_every_setting_of_a_table_and_of_each_axis() {
    let folder = folder();
    write(folder.path(), "unit.toml", THREE_AXES);
    let page = explained(folder.path());
    let sections: Vec<&str> = page.split("\n[").collect();
    let of_axis = |name: &str| {
        let head = format!("axis.{name}]");
        *sections.iter().find(|section| section.starts_with(&head)).expect("a section per axis")
    };
    for name in ["yaw", "pitch", "roll"] {
        for p in AXIS_PARAMETERS.iter() {
            for part in [format!(" {} ", p.key), format!("default {}", p.default)] {
                assert!(of_axis(name).contains(&part), "{name}: no `{part}` in\n{}", of_axis(name));
            }
        }
    }
    for p in TABLE_PARAMETERS.iter() {
        let own = p.key.rsplit('.').next().expect("a key");
        assert!(page.contains(&format!(" {own} ")), "{}", p.key);
    }
    let marked: Vec<&str> = page.lines().filter(|line| line.starts_with("* ")).collect();
    insta::assert_snapshot!(marked.join("\n"));
}

#[test]
fn the_schema_of_tables_knows_every_setting() {
    let folder = folder();
    let said = run_in(folder.path(), &["schema", "unit-table"]);
    let schema: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    for p in TABLE_PARAMETERS.iter() {
        let path = p.key.split('.').fold(String::new(), |path, part| format!("{path}/properties/{part}"));
        assert_eq!(schema.pointer(&path).map(|s| &s["type"]), Some(&"string".into()), "{path}");
    }
    for p in AXIS_PARAMETERS.iter() {
        let path = format!("/properties/axis/additionalProperties/properties/{}", p.key);
        assert_eq!(schema.pointer(&path).map(|s| &s["type"]), Some(&"string".into()), "{path}");
    }
}

#[test]
fn list_shows_the_table_its_planted_fault_and_its_requirements() {
    let folder = folder();
    let units = run_in(folder.path(), &["list", "units"]).out;
    assert!(units.contains("table  ") && units.contains("table-friction  "), "{units}");
    let requirements = run_in(folder.path(), &["list", "requirements"]).out;
    assert!(requirements.contains("TAB-FRC") && requirements.contains("FRC-AZ"), "{requirements}");
    let explained = run_in(folder.path(), &["explain", "TAB-COG"]).out;
    assert!(explained.contains("cogging-order: 83.5 .. 84.5 1/rev"), "{explained}");
}

/// Runs the shipped campaign of the table on a unit; requirements that came out otherwise than `pass`.
fn short_of(unit: &str) -> Vec<(String, String)> {
    let folder = folder();
    let said = run_in(
        folder.path(),
        &["run", "table", "--rig", "table", "--unit", unit, "--out", "run", "--non-interactive"],
    );
    assert!(folder.path().join("run/results.json").is_file(), "{}{}", said.out, said.err);
    let requirements = include_str!("../procedures/table-requirements.toml");
    let ids = requirements.lines().filter_map(|line| line.strip_prefix("id = \"")?.strip_suffix('"'));
    let verdicts = ids.map(|id| (id.to_owned(), verdict(&folder.path().join("run"), id)));
    verdicts.filter(|(_, verdict)| verdict != "pass").collect()
}

#[test]
fn the_table_passes_its_campaign_and_its_planted_fault_fails_friction_alone() {
    assert_eq!(short_of("table"), []);
    assert_eq!(short_of("table-friction"), [("TAB-FRC".to_owned(), "fail".to_owned())]);
}

/// The text of a file about one axis `table`, for three axes: its tables `[axis.table…]` once for each.
fn for_three(text: &str) -> String {
    let mut rest = String::new();
    let mut of_axis = String::new();
    let mut is_of_axis = false;
    for line in text.lines() {
        if line.starts_with('[') {
            is_of_axis = line.starts_with("[axis.table");
        }
        let part = if is_of_axis { &mut of_axis } else { &mut rest };
        part.push_str(line);
        part.push('\n');
    }
    let axes = [("yaw", 1), ("pitch", 2), ("roll", 3)];
    let named = axes.map(|(name, station)| {
        let own = of_axis.replace("[axis.table", &format!("[axis.{name}"));
        own.replace("station = 1\n", &format!("station = {station}\n"))
    });
    format!("{rest}\n{}", named.concat())
}

#[test]
fn a_table_of_three_axes_is_files_only_and_runs_on_each_of_them() {
    let folder = folder();
    let parameters = "parameters = \"table\" ";
    let rig = for_three(include_str!("../bench/rigs/table.toml"));
    assert!(rig.contains(parameters), "the rig names its parameters");
    write(folder.path(), "rig.toml", &rig.replace(parameters, "parameters = \"./parameters.toml\" "));
    write(folder.path(), "unit.toml", &for_three(include_str!("../sim-devices/units/table.toml")));
    write(folder.path(), "parameters.toml", &for_three(include_str!("../controllers/params/table.toml")));
    let polarity = include_str!("../procedures/table/polarity.toml").replace("\"table\"", "\"roll\"");
    let refused = write(folder.path(), "polarity.toml", &polarity);
    let files = ["--rig", "rig.toml", "--unit", "unit.toml"];
    let said = run_in(folder.path(), &[&["check", "./polarity.toml"], &files[..]].concat());
    assert!(said.err.contains("the pose of axis `roll` is missing"), "{}", said.err);
    let posed = polarity.replace("\n[[prompt]]", "pose = { roll = \"-30 deg\" }\n\n[[prompt]]");
    std::fs::write(refused, posed).expect("a writable folder");
    let step = include_str!("../procedures/table/step.toml");
    let friction = include_str!("../procedures/table/friction.toml");
    let own =
        |text: &str, axis: &str| text.replace("\"table\"", &format!("\"{axis}\"")).replace("TABLE", axis);
    for axis in ["yaw", "pitch", "roll"] {
        write(folder.path(), &format!("{axis}.toml"), &own(step, axis));
    }
    write(folder.path(), "friction.toml", &own(friction, "roll"));
    let named = ["./polarity.toml", "./yaw.toml", "./pitch.toml", "./roll.toml", "./friction.toml"];
    let run = [&["run"], &named[..], &files[..], &["--out", "run", "--non-interactive"]].concat();
    let said = run_in(folder.path(), &run);
    assert!([0, 3].contains(&said.code), "exit {}\n{}{}", said.code, said.out, said.err);
    let text = std::fs::read_to_string(folder.path().join("run/results.json")).expect("results");
    let results: serde_json::Value = serde_json::from_str(&text).expect("results are JSON");
    let procedures = results["findings"]["procedures"].as_array().expect("a list");
    assert_eq!(procedures.len(), 5);
    assert!(procedures.iter().all(|p| p["status"] == "completed"), "{}{}", said.out, said.err);
    let settled = procedures.iter().flat_map(|p| p["measurements"].as_array().into_iter().flatten());
    let settled = settled.filter(|m| m["measurand"] == "step-settling-time" && m["value"].is_number());
    let axes: std::collections::BTreeSet<_> = settled.map(|m| m["axis"].to_string()).collect();
    assert_eq!(axes.len(), 3, "{axes:?}");
}
