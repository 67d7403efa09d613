//! Mistakes as people make them on their first day, each with the message that leads to the mend.

use std::path::Path;

use rayon::prelude::*;

use crate::bench::{folder, run_in};

/// A mistake in a file of a starter folder: `from` becomes `to` once.
struct Edit {
    name: &'static str,
    file: &'static str,
    from: &'static str,
    to: &'static str,
}

const fn edit(name: &'static str, file: &'static str, from: &'static str, to: &'static str) -> Edit {
    Edit { name, file, from, to }
}

const FRICTION: &str = "quick/az-friction.toml";
const VELOCITY: &str = "\"2 deg/s\", \"10";
const SPAN: &str = "span = \"-60 deg .. 60 deg\"";

#[rustfmt::skip]
const EDITS: &[Edit] = &[
    edit("an axis by its other name", FRICTION, "axis = \"az\"", "axis = \"elevation\""),
    edit("a decimal comma", FRICTION, VELOCITY, "\"2,5 deg/s\", \"10"),
    edit("a number that begins with a point", FRICTION, VELOCITY, "\".5 deg/s\", \"10"),
    edit("a quantity without unit", FRICTION, VELOCITY, "\"2\", \"10"),
    edit("a quantity without quotes", FRICTION, VELOCITY, "2, \"10"),
    edit("a unit of another kind", FRICTION, VELOCITY, "\"2 deg\", \"10"),
    edit("a unit that nobody knows", FRICTION, VELOCITY, "\"2 degree/s\", \"10"),
    edit("a range with to", FRICTION, SPAN, "span = \"-5 deg to 85 deg\""),
    edit("a range of one number", FRICTION, SPAN, "span = \"60 deg\""),
    edit("a range the wrong way round", FRICTION, SPAN, "span = \"60 deg .. -60 deg\""),
    edit("a range beyond the soft limits", FRICTION, SPAN, "span = \"-200 deg .. 60 deg\""),
    edit("a range without a plateau", FRICTION, SPAN, "span = \"-1 deg .. 1 deg\""),
    edit("a velocity beyond the axis", FRICTION, VELOCITY, "\"90 deg/s\", \"10"),
    edit("a log rate that is no divisor", FRICTION, "log-rate = \"250 Hz\"", "log-rate = \"300 Hz\""),
    edit("a word for a number", FRICTION, "cycles = ", "cycles = \"two\" # "),
    edit("a key of the top behind a table", FRICTION, "[valid-if]\n", "[valid-if]\ncool-down = \"60 s\"\n"),
    edit("a gate with another spelling", FRICTION, "heat-sink = ", "heatsink = "),
    edit("a kind with another spelling", FRICTION, "\"hysteresis\"", "\"hysterisis\""),
    edit("a kind that is missing", FRICTION, "kind = \"hysteresis\"\n", ""),
    edit("a schema that is missing", FRICTION, "schema = 1\n", ""),
    edit("a newer schema", FRICTION, "schema = 1", "schema = 2"),
    edit("a key twice", FRICTION, "axis = \"az\"\n", "axis = \"az\"\naxis = \"az\"\n"),
    edit("a bracket that is missing", FRICTION, "[sweep]", "[sweep"),
    edit("a quote that is missing", FRICTION, "axis = \"az\"", "axis = \"az"),
    edit("a stage with single brackets", "quick.toml", "[[stage]]\nid = \"static\"", "[stage]\nid = \"static\""),
    edit("a procedure with single brackets", "quick.toml", "[[procedure]]\nfile = \"shipped:quick/self-check-open", "[procedure]\nfile = \"shipped:quick/self-check-open"),
    edit("a stage that is none", "quick.toml", "stage = \"polarity\"", "stage = \"polarty\""),
    edit("a file that is not there", "quick.toml", "\"quick/az-friction.toml\"", "\"quick/az-frction.toml\""),
    edit("a file that only a shipped one has the name of", "quick.toml", "\"quick/az-friction.toml\"", "\"fat/az-friction.toml\""),
    edit("a shipped file that is none", "quick.toml", "\"shipped:quick/az-stop.toml\"", "\"shipped:quick/az-stopp.toml\""),
    edit("a rig among the procedures", "quick.toml", "\"quick/az-friction.toml\"", "\"sim.toml\""),
    edit("a procedure for requirements", "quick.toml", "requirements = \"requirements.toml\"", "requirements = \"quick/az-friction.toml\""),
    edit("a requirement with another spelling", "quick.toml", "coverage = \"full\"", "must-measure = [\"FRC-AX\"]"),
    edit("a requirement without limit", "quick.toml", "coverage = \"full\"", "must-measure = [\"TRK-RMS-F\"]"),
    edit("a filter that no point passes", "requirements.toml", "where = { velocity = \"<= 10 deg/s\" }\nlimit = \"<= 260", "where = { velocity = \"<= 1 deg/s\" }\nlimit = \"<= 260"),
    edit("a limit without comparator", "requirements.toml", "limit = \"<= 260 N*m\"", "limit = \"260 N*m\""),
    edit("a measurand with another spelling", "requirements.toml", "\"friction-torque\", \"breakaway-torque\"]\naxis = \"az\"", "\"friction-torqe\", \"breakaway-torque\"]\naxis = \"az\""),
];

/// Mistakes on the command line, in a starter folder.
const CALLS: &[&[&str]] = &[
    &["run", "requirements.toml"],
    &["run", "./sim.toml"],
    &["run", "azimuth-retainer"],
    &["run", "."],
    &["run", "hysteresis"],
    &["run", "FRC-AZ"],
    &["run", "AZ-FRICTION"],
    &["run", "quikc"],
    &["run", "./quikc.toml"],
    &["run", "nowhere/quick.toml"],
    &["run", "--requirements", "requirement.toml"],
    &["run", "--rig", "./nominal.toml"],
    &["run", "--rig", "simm"],
    &["run", "--unit", "./sim.toml"],
    &["run", "--unit", "nominl"],
    &["run", "--select", "FRC-AX"],
    &["run", "--select", "hysteresys"],
    &["run", "--jobs", "0"],
    &["explain", "histeresis"],
    &["report", "nothing"],
    &["rejudge", "quick.toml"],
];

fn starter(folder: &Path) {
    assert_eq!(run_in(folder, &["init", "mine"]).code, 0);
}

/// What is said, without the folder's own name.
fn said(folder: &Path, arguments: &[&str]) -> String {
    let said = run_in(&folder.join("mine"), arguments);
    format!("exit {}\n{}{}", said.code, said.out, said.err)
}

#[test]
fn mistakes_in_files_lead_to_their_mend() {
    let told: Vec<String> = EDITS
        .par_iter()
        .map(|one| {
            let folder = folder();
            starter(folder.path());
            let path = folder.path().join("mine").join(one.file);
            let text = std::fs::read_to_string(&path).expect("a starter file");
            let changed = text.replacen(one.from, one.to, 1);
            assert_ne!(text, changed, "{}: {} no longer says `{}`", one.name, one.file, one.from);
            std::fs::write(&path, changed).expect("a writable folder");
            let said = said(folder.path(), &["check", "quick.toml", "--rig", "./sim.toml"]);
            format!("## {}\n{said}", one.name)
        })
        .collect();
    for (one, told) in EDITS.iter().zip(&told) {
        assert!(told.contains("\nexit 2\n"), "{}: {told}", one.name);
    }
    insta::assert_snapshot!(told.join("\n"));
}

#[test]
fn mistakes_on_the_command_line_lead_to_their_mend() {
    let folder = folder();
    starter(folder.path());
    let told: Vec<String> = CALLS
        .par_iter()
        .map(|arguments| format!("## bench {}\n{}", arguments.join(" "), said(folder.path(), arguments)))
        .collect();
    insta::assert_snapshot!(told.join("\n"));
}

#[test]
fn a_starter_folder_is_right_and_names_every_file_that_it_would_use() {
    let folder = folder();
    starter(folder.path());
    let check =
        said(folder.path(), &["check", "quick.toml", "--rig", "./sim.toml", "--unit", "./nominal.toml"]);
    assert!(check.starts_with("exit 0"), "{check}");
    assert!(
        check.contains("files: campaign quick.toml, requirements requirements.toml, rig ./sim.toml"),
        "{check}"
    );
    let plan = said(folder.path(), &["plan", "quick.toml", "--rig", "./sim.toml"]);
    for (id, file) in [("AZ-FRICTION", "quick/az-friction.toml"), ("POLARITY", "shipped:polarity.toml")] {
        let named = plan
            .lines()
            .any(|line| line.starts_with(&format!("{id} ")) && line.ends_with(&format!(" {file}")));
        assert!(named, "{plan}");
    }
}
