//! What the documents promise is what the program does.

use crate::bench::{folder, run_in};

const README: &str = include_str!("../README.md");

#[test]
fn every_verb_of_the_help_answers_and_the_readme_names_it() {
    let folder = folder();
    let help = run_in(folder.path(), &["--help"]);
    assert_eq!(help.code, 0);
    for verb in [
        "run",
        "check",
        "plan",
        "list",
        "rejudge",
        "compare",
        "report",
        "explain",
        "schema",
        "devices",
        "init",
        "import",
        "rtcheck",
        "monitor",
        "draw",
        "monte-carlo",
    ] {
        assert!(help.out.contains(verb), "{verb} is not in the help");
        assert!(README.contains(verb), "{verb} is not in the README");
        assert_eq!(run_in(folder.path(), &[verb, "--help"]).code, 0, "bench {verb} --help");
    }
}

#[test]
fn a_starter_folder_checks_without_a_mistake() {
    let folder = folder();
    assert_eq!(run_in(folder.path(), &["init", "mine"]).code, 0);
    let said = run_in(
        folder.path(),
        &["check", "mine/quick.toml", "--rig", "mine/sim.toml", "--unit", "mine/nominal.toml"],
    );
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(run_in(folder.path(), &["init", "mine"]).code, 2, "a folder that is not empty is left alone");
}

#[test]
fn both_campaigns_check_and_quick_is_short() {
    let folder = folder();
    for campaign in ["quick", "fat"] {
        let said = run_in(folder.path(), &["check", campaign]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let said = run_in(folder.path(), &["check", "quick"]);
    let planned_s: f64 = said
        .out
        .split_once(" points, ")
        .and_then(|(_, rest)| rest.split(' ').next())
        .and_then(|s| s.parse().ok())
        .unwrap_or_else(|| panic!("no duration in `{}`", said.out));
    // At 60 simulated seconds a second of two cores: under a minute.
    assert!(planned_s <= 3600.0, "quick is planned with {planned_s} s");
}

#[test]
fn explain_knows_every_kind_requirement_unit_and_the_exit_codes() {
    let folder = folder();
    for name in [
        "hysteresis",
        "breakaway",
        "polarity",
        "FRC-AZ",
        "HOLD-EL",
        "TRK-RMS-C",
        "azimuth-retainer",
        "azimuth-table",
        "exit-code",
        "sim",
        "quick",
        "fat/az-friction",
        "units",
        "verdicts",
        "selection",
        "glossary",
        "procedure-file",
        "campaign-file",
        "requirements-file",
        "rig-file",
        "unit-file",
        "import-file",
        "answers-file",
        "waivers-file",
        "published-file",
    ] {
        let said = run_in(folder.path(), &["explain", name]);
        assert_eq!(said.code, 0, "{name}: {}", said.err);
        assert!(said.out.len() > 40, "{name}: {}", said.out);
    }
}

#[test]
fn explain_shows_each_key_as_a_shipped_file_uses_it() {
    let folder = folder();
    let page = |name: &str| run_in(folder.path(), &["explain", name]).out;
    let shown = |page: &str, key: &str, example: &str| {
        let mut lines = page.lines().skip_while(|line| !line.starts_with(&format!("  {key} (")));
        assert!(lines.next().is_some(), "{key}: {page}");
        let own = lines.take_while(|line| line.starts_with("      ")).collect::<Vec<_>>().join("\n");
        assert!(own.contains(example), "{key}: {own}");
    };
    shown(&page("frequency-response"), "background.velocity", "velocity = \"0");
    shown(&page("campaign-file"), "stage.needs", "needs = [\"");
    shown(&page("requirements-file"), "requirement.where", "where = { velocity = \"<= 10 deg/s\" }");
    shown(&page("kvh-1775"), "format", "format = ");
    assert!(page("friction-torque").contains("judged by FRC-AZ, FRC-EL"), "{}", page("friction-torque"));
}

#[test]
fn explain_of_a_unit_begins_with_what_differs_from_its_base() {
    let folder = folder();
    let page = run_in(folder.path(), &["explain", "azimuth-retainer"]).out;
    let (first, _) = page.split_once("* differs from the default").expect("all settings follow");
    let (_, own) = first.split_once("Differs from its base shipped:nominal.toml:\n").expect("what differs");
    insta::assert_snapshot!(own.trim_end(), @r"
  [az] coulomb-torque = 380 N*m (base: 167.75 N*m)
  [az] static-torque = 380 N*m (base: 210 N*m)
  [az] viscous-damping = 859.4 N*m*s/rad (base: 273.6 N*m*s/rad)
");
}

#[test]
fn schemas_are_json_and_know_the_keys() {
    let folder = folder();
    let said = run_in(folder.path(), &["schema"]);
    let all: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    for sort in [
        "hysteresis",
        "breakaway",
        "polarity",
        "campaign",
        "requirements",
        "rig",
        "unit",
        "parameters",
        "import",
    ] {
        assert!(all[sort]["properties"]["schema"].is_object(), "{sort}");
    }
}

#[test]
fn devices_of_the_simulator_are_marked_simulated() {
    let folder = folder();
    let said = run_in(folder.path(), &["devices"]);
    assert_eq!(said.code, 0, "{}", said.err);
    // Two drives, inertial unit, mirror, impedance analyser, oscilloscope.
    assert_eq!(said.out.matches("simulated: ").count(), 6, "{}", said.out);
    assert!(said.out.contains("SIM"), "{}", said.out);
}
