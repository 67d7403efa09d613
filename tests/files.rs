//! Bad input: each mistake gets a clear message, the right exit code, and loses nothing.

use std::path::Path;

use crate::bench::{Said, folder, run_in, write};

const FRICTION: &str = include_str!("../procedures/quick/az-friction.toml");
const RIG: &str = include_str!("../bench/rigs/sim.toml");

/// Message with the temporary folder's name taken out, and the exit code.
fn told(folder: &Path, said: &Said) -> String {
    let at = folder.display().to_string();
    format!("exit {}\n{}{}", said.code, said.out, said.err).replace(&format!("{at}/"), "").replace(&at, ".")
}

/// Runs a verb on a procedure that differs from a shipped one by this replacement.
fn with_change(verb: &[&str], from: &str, to: &str) -> String {
    let changed = FRICTION.replacen(from, to, 1);
    assert_ne!(FRICTION, changed, "the shipped procedure no longer says `{from}`");
    with_text(verb, &changed)
}

fn with_text(verb: &[&str], text: &str) -> String {
    let folder = folder();
    write(folder.path(), "p.toml", text);
    let arguments: Vec<&str> = verb.iter().chain(["p.toml"].iter()).copied().collect();
    told(folder.path(), &run_in(folder.path(), &arguments))
}

#[test]
fn a_misspelt_key_names_the_nearest_word() {
    insta::assert_snapshot!(with_change(&["check"], "velocity =", "velocty ="));
}

#[test]
fn several_mistakes_come_at_once() {
    let text = FRICTION.replacen("axis = \"az\"", "axes = \"az\"", 1).replacen("deg/s", "Hz", 1).replacen(
        "cycles = ",
        "cycles = -",
        1,
    );
    insta::assert_snapshot!(with_text(&["check"], &text));
}

#[test]
fn a_unit_of_the_wrong_kind_names_both_kinds() {
    insta::assert_snapshot!(with_change(&["check"], "deg/s\"", "Hz\""));
}

#[test]
fn an_empty_sweep_is_a_mistake() {
    let line = FRICTION.lines().find(|l| l.starts_with("velocity = [")).expect("a sweep of velocities");
    insta::assert_snapshot!(with_change(&["check"], line, "velocity = []"));
}

#[test]
fn crossed_limits_are_a_mistake() {
    let line = FRICTION.lines().find(|l| l.starts_with("span = ")).expect("a span");
    insta::assert_snapshot!(with_change(&["check"], line, "span = \"60 deg .. -60 deg\""));
}

#[test]
fn travel_beyond_the_rig_is_2_in_check_and_6_in_run() {
    let line = FRICTION.lines().find(|l| l.starts_with("span = ")).expect("a span");
    let check = with_change(&["check"], line, "span = \"-170 deg .. 170 deg\"");
    let run = with_change(&["run"], line, "span = \"-170 deg .. 170 deg\"");
    assert!(check.starts_with("exit 2"), "{check}");
    assert!(run.starts_with("exit 6"), "{run}");
    insta::assert_snapshot!(run);
}

#[test]
fn toml_that_does_not_parse_points_at_the_place() {
    insta::assert_snapshot!(with_change(&["check"], "[sweep]", "[sweep"));
}

#[test]
fn an_unknown_kind_names_the_nearest() {
    insta::assert_snapshot!(with_change(&["check"], "kind = \"hysteresis\"", "kind = \"histeresis\""));
}

fn campaign(changed: &str, must_measure: &str) -> String {
    let folder = folder();
    write(folder.path(), "requirements.toml", include_str!("../procedures/requirements.toml"));
    write(folder.path(), "az-friction.toml", FRICTION);
    let text = format!(
        "schema = 1\nid = \"mine\"\ntitle = \"Mine\"\nrequirements = \"requirements.toml\"\nmust-measure = [{must_measure}]\n\n[[procedure]]\nfile = \"{changed}\"\n"
    );
    write(folder.path(), "mine.toml", &text);
    told(folder.path(), &run_in(folder.path(), &["check", "mine.toml"]))
}

#[test]
fn an_unknown_requirement_in_a_campaign_names_the_nearest() {
    insta::assert_snapshot!(campaign("az-friction.toml", "\"FRC-AS\""));
}

#[test]
fn a_measurand_that_no_procedure_of_the_campaign_yields_is_refused() {
    insta::assert_snapshot!(campaign("az-friction.toml", "\"FRC-AZ\", \"HOLD-EL\""));
}

#[test]
fn a_procedure_file_that_is_not_there_is_pointed_at() {
    insta::assert_snapshot!(campaign("az-fricton.toml", "\"FRC-AZ\""));
}

#[test]
fn an_unknown_measurand_in_the_requirements_names_the_nearest() {
    let folder = folder();
    let text =
        include_str!("../procedures/requirements.toml").replacen("unbalance-torque", "unballance-torque", 1);
    write(folder.path(), "r.toml", &text);
    let said = run_in(folder.path(), &["check", "--requirements", "r.toml"]);
    insta::assert_snapshot!(told(folder.path(), &said));
}

#[test]
fn an_unknown_gate_channel_names_the_nearest() {
    insta::assert_snapshot!(with_change(&["check"], "heat-sink =", "heat-snik ="));
}

#[test]
fn unknown_names_of_files_and_units_name_the_nearest() {
    let folder = folder();
    let mut all = String::new();
    for arguments in [
        &["run", "quik"][..],
        &["run", "--unit", "nominel"],
        &["run", "--rig", "sin"],
        &["check", "nowhere/at-all.toml"],
        &["explain", "histeresis"],
        &["run", "--select", "FRC-XX"],
    ] {
        let said = run_in(folder.path(), arguments);
        all.push_str(&format!("$ bench {}\n{}\n", arguments.join(" "), told(folder.path(), &said)));
    }
    insta::assert_snapshot!(all);
}

#[test]
fn a_rig_whose_soft_limits_leave_the_travel_is_refused() {
    let folder = folder();
    let text = RIG.replacen("-159 deg .. 159 deg", "-165 deg .. 165 deg", 1);
    assert_ne!(RIG, text);
    write(folder.path(), "rig.toml", &text);
    let said = run_in(folder.path(), &["check", "--rig", "./rig.toml"]);
    insta::assert_snapshot!(told(folder.path(), &said));
}

#[test]
fn a_drive_that_reads_back_another_scale_refuses_to_arm() {
    let folder = folder();
    let text = RIG.replacen("rated-torque = \"120 N*m\"", "rated-torque = \"130 N*m\"", 1);
    assert_ne!(RIG, text);
    write(folder.path(), "rig.toml", &text);
    let said = run_in(folder.path(), &["run", "--rig", "./rig.toml", "--out", "run"]);
    insta::assert_snapshot!(told(folder.path(), &said));
}

#[test]
fn a_folder_that_is_not_empty_is_not_written_to() {
    let folder = folder();
    let kept = write(folder.path(), "run/precious.txt", "data");
    let said = run_in(folder.path(), &["run", "--out", "run"]);
    assert_eq!(std::fs::read_to_string(kept).expect("still there"), "data");
    insta::assert_snapshot!(told(folder.path(), &said));
}

#[test]
fn an_output_folder_that_cannot_be_made_says_so() {
    let folder = folder();
    write(folder.path(), "file", "not a folder");
    let said = run_in(folder.path(), &["run", "--out", "file/run"]);
    insta::assert_snapshot!(told(folder.path(), &said));
}

#[test]
fn a_foreign_file_is_usage_and_a_truncated_log_is_damage() {
    let folder = folder();
    write(folder.path(), "foreign.mcap", "this is no log");
    let foreign = run_in(folder.path(), &["rejudge", "foreign.mcap"]);
    assert_eq!(foreign.code, 2, "{}", foreign.err);
    let ran = run_in(folder.path(), &["run", "quick/el-breakaway", "--out", "run", "--non-interactive"]);
    assert!(matches!(ran.code, 0 | 3), "{}", ran.err);
    let log = folder.path().join("run/EL-BREAKAWAY.mcap");
    let bytes = std::fs::read(&log).expect("a log");
    std::fs::write(&log, &bytes[..bytes.len() / 2]).expect("a writable log");
    let cut = run_in(folder.path(), &["rejudge", "run", "--out", "again"]);
    assert_eq!(cut.code, 65, "{}\n{}", cut.out, cut.err);
    assert!(folder.path().join("again/report.html").is_file(), "results are written from what is whole");
    assert!(cut.err.contains("damaged"), "{}", cut.err);
    insta::assert_snapshot!(told(folder.path(), &foreign));
}

#[test]
fn usage_that_makes_no_sense_is_2() {
    let folder = folder();
    for arguments in [&["fly"][..], &["run", "--seed", "x"], &["report", "nowhere"], &["rejudge", "nowhere"]]
    {
        let said = run_in(folder.path(), arguments);
        assert_eq!(said.code, 2, "bench {}: {}", arguments.join(" "), said.err);
        assert!(!said.err.is_empty());
    }
}
