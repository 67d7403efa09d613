//! A director whose axes have other names is the same director: nothing in the program knows an axis by its name.

use std::path::Path;

use serde_json::Value;

use crate::bench::{folder, run_in, write};

/// What azimuth and elevation are called in the shipped files, and in the renamed ones.
const NAMES: [[&str; 2]; 2] = [["az", "outer"], ["el", "inner"]];
/// Keys whose values are words of the mirror and no names of axes.
const OF_THE_MIRROR: [&str; 2] = ["mirror-axis", "expected-mode"];

/// A shipped procedure or requirements file with the other names.
fn renamed(text: &str) -> String {
    let rename = |line: &str| {
        if OF_THE_MIRROR.iter().any(|key| line.starts_with(key)) {
            return line.to_owned();
        }
        let mut line = line.to_owned();
        for [shipped, other] in NAMES {
            line = line.replace(&format!("\"{shipped}\""), &format!("\"{other}\""));
        }
        line
    };
    text.lines().map(|line| rename(line) + "\n").collect()
}

/// The shipped rig with the other names; gains stay in the sections of the shipped parameters.
fn renamed_rig(text: &str) -> String {
    let mut text = renamed(text);
    for [shipped, other] in NAMES {
        text =
            text.replace(&format!("[axis.{shipped}]\n"), &format!("[axis.{other}]\ngains = \"{shipped}\"\n"));
        text = text.replace(&format!("[axis.{shipped}."), &format!("[axis.{other}."));
    }
    text
}

/// Runs a campaign of a folder on a rig of that folder; gives its findings.
fn findings(folder: &Path, campaign: &str) -> Value {
    let arguments = ["run", campaign, "--rig", "rig.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder, &arguments);
    assert!([0, 1, 3].contains(&said.code), "exit {}\n{}\n{}", said.code, said.out, said.err);
    let text = std::fs::read_to_string(folder.join("run/results.json")).expect("results of the run");
    serde_json::from_str::<Value>(&text).expect("results are JSON")["findings"].take()
}

/// The same findings with the shipped names wherever one of the other names is a word of a text, and without hashes of logs,
/// which hold the rig file.
fn with_shipped_names(findings: Value) -> Value {
    let word = |word: &str| {
        let name = NAMES.iter().find(|[_, other]| *other == word);
        name.map_or(word, |[shipped, _]| *shipped).to_owned()
    };
    match findings {
        Value::String(text) => {
            let words = text.split_inclusive(|c: char| !c.is_ascii_alphanumeric());
            let renamed = words.map(|piece| {
                let end = piece.trim_end_matches(|c: char| !c.is_ascii_alphanumeric()).len();
                word(&piece[..end]) + &piece[end..]
            });
            Value::String(renamed.collect())
        }
        Value::Array(all) => all.into_iter().map(with_shipped_names).collect(),
        Value::Object(all) => all.into_iter().map(|(key, value)| (key, with_shipped_names(value))).collect(),
        other => other,
    }
}

/// The shipped files of these names, and the campaign, in a folder; `rename` changes procedures and requirements.
fn lay_out(folder: &Path, files: &[&str], campaign: &str, rename: fn(&str) -> String) {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../procedures");
    for file in files {
        let text = std::fs::read_to_string(shipped.join(file)).expect("a shipped file");
        write(folder, file, &rename(&text));
    }
    write(folder, "mine.toml", campaign);
}

/// Procedures of both runs that differ, by id, and outcomes that do.
fn differences(shipped: &Value, other: &Value) -> Vec<String> {
    let list = |findings: &Value, key: &str| findings[key].as_array().cloned().unwrap_or_default();
    let mut all = Vec::new();
    for (key, id) in [("procedures", "id"), ("outcomes", "requirement")] {
        let ours = list(shipped, key);
        let theirs = list(other, key);
        assert_eq!(ours.len(), theirs.len(), "as many {key}");
        let pairs = ours.iter().zip(&theirs).filter(|(ours, theirs)| ours != theirs);
        all.extend(pairs.map(|(ours, _)| ours[id].as_str().unwrap_or_default().to_owned()));
    }
    all
}

fn both(files: &[&str], campaign: &str) -> [Value; 2] {
    let rig = include_str!("../bench/rigs/sim.toml");
    let as_shipped = folder();
    let other = folder();
    lay_out(as_shipped.path(), files, campaign, str::to_owned);
    write(as_shipped.path(), "rig.toml", rig);
    lay_out(other.path(), files, campaign, renamed);
    write(other.path(), "rig.toml", &renamed_rig(rig));
    let shipped = findings(as_shipped.path(), "mine.toml");
    [shipped, findings(other.path(), "mine.toml")].map(with_shipped_names)
}

/// A velocity loop on the gyro, friction, a track loop, a mirror: to the last bit.
#[test]
#[ignore = "takes the better part of a minute; `.ci/run` runs it after the others"]
fn a_director_with_other_names_for_its_axes_gives_the_same_findings() {
    let procedures = [
        "quick/az-velocity-loop.toml",
        "quick/el-friction.toml",
        "quick/el-track-loop.toml",
        "quick/fsm-impedance.toml",
    ];
    let head = "schema = 1\nid = \"mine\"\ntitle = \"Few\"\nrequirements = \"requirements.toml\"\nmust-measure = []\n";
    let file = |name: &&str| format!("\n[[procedure]]\nfile = \"{name}\"\n");
    let campaign = head.to_owned() + &procedures.iter().map(file).collect::<String>();
    let files: Vec<&str> = procedures.into_iter().chain(["requirements.toml"]).collect();
    let [shipped, other] = both(&files, &campaign);
    assert_eq!(
        differences(&shipped, &other),
        ["POLARITY"],
        "the noise of its points is drawn by their names"
    );
    let yields = |p: &Value| {
        p["measurements"].as_array().is_some_and(|all| all.iter().any(|m| m["value"].is_number()))
    };
    assert!(
        other["procedures"].as_array().is_some_and(|all| all.iter().all(yields)),
        "all of them say something"
    );
}

/// The whole of `quick`. The noise of a point is drawn by its name; where that holds the name of an axis, numbers differ as
/// between two seeds: in the check of polarity, and in the creeps of the encoders.
#[test]
#[ignore = "it takes three minutes"]
fn the_whole_quick_look_gives_the_same_findings_under_other_names() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../procedures");
    let quick = std::fs::read_dir(shipped.join("quick")).expect("a folder of procedures");
    let names = quick.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let quick: Vec<String> = names.map(|name| format!("quick/{name}")).collect();
    let mut files: Vec<&str> = quick.iter().map(String::as_str).collect();
    files.extend(["polarity.toml", "requirements.toml"]);
    let [shipped, other] = both(&files, include_str!("../procedures/quick.toml"));
    let drawn_anew = ["POLARITY", "IMU-NOISE"];
    let differing = differences(&shipped, &other);
    assert!(differing.iter().all(|id| drawn_anew.contains(&id.as_str())), "{differing:?}");
    assert_eq!(shipped["overall"], other["overall"]);
}
