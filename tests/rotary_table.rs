//! A rig of one axis, with a drive and an encoder and nothing else: the azimuth of the simulated director, alone.

use serde_json::Value;

use crate::bench::{folder, run_in, write};

/// The azimuth of the shipped rig under another name, its loop closed on the encoder.
fn rig() -> String {
    let (axis, _) = include_str!("../bench/rigs/sim.toml").split_once("[axis.el]").expect("two axes");
    axis.replace("[axis.az]\n", "[axis.table]\ngains = \"az\"\n")
        .replace("[axis.az.", "[axis.table.")
        .replace("velocity-feedback = \"gyro\"", "velocity-feedback = \"encoder\"")
}

/// A shipped procedure on that axis.
fn on_the_table(text: &str) -> String {
    text.replace("axis = \"az\"", "axis = \"table\"")
}

#[test]
fn a_rotary_table_proves_its_signs_and_runs_friction_steps_and_stops() {
    let folder = folder();
    let at = folder.path();
    write(at, "rig.toml", &rig());
    write(at, "requirements.toml", include_str!("../procedures/requirements.toml"));
    write(at, "friction.toml", &on_the_table(include_str!("../procedures/quick/az-friction.toml")));
    write(at, "stop.toml", &on_the_table(include_str!("../procedures/quick/az-stop.toml")));
    write(
        at,
        "step.toml",
        "schema = 1\nid = \"STEP\"\ntitle = \"Steps\"\nkind = \"step\"\naxis = \"table\"\n",
    );
    let head = "schema = 1\nid = \"mine\"\ntitle = \"Table\"\nrequirements = \"requirements.toml\"\nmust-measure = []\n";
    let file = |name: &str| format!("\n[[procedure]]\nfile = \"{name}.toml\"\n");
    write(at, "mine.toml", &(head.to_owned() + &["friction", "step", "stop"].map(file).concat()));
    let said = run_in(at, &["run", "mine.toml", "--rig", "rig.toml", "--out", "run", "--non-interactive"]);
    assert!([0, 3].contains(&said.code), "exit {}\n{}\n{}", said.code, said.out, said.err);
    let text = std::fs::read_to_string(at.join("run/results.json")).expect("results of the run");
    let results: Value = serde_json::from_str(&text).expect("results are JSON");
    let procedures = results["findings"]["procedures"].as_array().expect("a list").clone();
    let ids: Vec<_> = procedures.iter().map(|p| (p["id"].as_str(), p["status"].as_str())).collect();
    let ran = |id: &'static str| (Some(id), Some("completed"));
    assert_eq!(ids, ["POLARITY", "AZ-FRICTION", "STEP", "AZ-STOP"].map(ran));
    let remarks = procedures[0]["remarks"].to_string();
    assert!(remarks.contains("No gyro measures table"), "{remarks}");
    let friction = procedures[1]["measurements"].as_array().expect("a list");
    let found = friction.iter().find(|m| m["measurand"] == "friction-torque").expect("friction");
    assert!(
        found["axis"] == "table" && found["value"].as_f64().is_some_and(|nm| (100.0..400.0).contains(&nm)),
        "{found}"
    );
    let steps = procedures[2]["measurements"].as_array().expect("a list");
    assert!(steps.iter().any(|m| m["value"].is_number()), "{steps:?}");
    let conditions = |m: &Value| m["conditions"].to_string();
    assert!(steps.iter().all(|m| !conditions(m).contains("elevation")), "there is none");
}
