//! Rigs that lack devices: what needs them is refused by name, or left out with what that costs.

use crate::bench::{folder, run_in, write};

const RIG: &str = include_str!("../bench/rigs/sim.toml");

/// The shipped rig without some of its devices.
fn without(names: &[&str]) -> String {
    let mut text = RIG.to_owned();
    for name in names {
        let from = text.find(&format!("[[device]]\nname = \"{name}\"")).expect("a device of the shipped rig");
        let next = |header: &str| text[from + 1..].find(header).map(|at| from + 1 + at);
        let to = next("\n[[device]]").into_iter().chain(next("\n# Measuring instruments")).min();
        text.replace_range(from..to.expect("something follows"), "");
    }
    text
}

/// Words of a check of `quick` on such a rig; the exit code is the first of them.
fn checked(names: &[&str], more: &[&str]) -> String {
    let folder = folder();
    let rig = without(names).replace("velocity-feedback = \"gyro\" ", "velocity-feedback = \"encoder\" ");
    write(folder.path(), "rig.toml", &rig);
    let said = run_in(folder.path(), &[&["check", "--rig", "rig.toml"], more].concat());
    format!("exit {}\n{}{}", said.code, said.out, said.err)
}

#[test]
fn each_missing_device_is_refused_in_its_words() {
    for name in ["imu", "fsm", "coarse", "fine", "force", "analyser"] {
        insta::assert_snapshot!(format!("refused_without_{name}"), checked(&[name], &[]));
    }
    insta::assert_snapshot!("refused_without_scope", checked(&["scope"], &["fat"]));
}

/// Without clamps or polygons the procedures that read them still say the rest.
#[test]
fn what_a_procedure_can_do_without_is_not_refused() {
    assert!(checked(&["supply", "reference"], &[]).starts_with("exit 0\n"));
}

#[test]
fn what_needs_a_missing_device_is_left_out_where_that_is_asked_for_and_its_requirements_are_named() {
    let said = checked(&["fsm", "coarse", "fine", "scope"], &["--skip-missing"]);
    let left_out: Vec<&str> = said.lines().filter(|line| line.contains(" was left out: ")).collect();
    insta::assert_snapshot!(left_out.join("\n"));
    assert!(said.starts_with("exit 0\nquick: "), "{said}");
}

#[test]
fn a_rig_without_mirror_trackers_and_scope_runs_what_it_can_and_is_partial() {
    let folder = folder();
    write(folder.path(), "rig.toml", &without(&["fsm", "coarse", "fine", "scope"]));
    let named =
        ["run", "--rig", "rig.toml", "--select", "AZ-STEP", "FSM-BW", "--out", "run", "--non-interactive"];
    let refused = run_in(folder.path(), &[&named[..], &["--yes"]].concat());
    assert_eq!(refused.code, 6, "{}{}", refused.out, refused.err);
    assert!(!folder.path().join("run").exists(), "a refused run leaves no folder");
    let said = run_in(folder.path(), &[&named[..], &["--yes", "--skip-missing"]].concat());
    // Azimuth alone does not verify POS-OVS, which claims both axes.
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    let left = "FSM-RESPONSE was left out: the rig has no steering mirror; this leaves FSM-BW";
    assert!(said.out.contains("INCONCLUSIVE (PARTIAL)") && said.out.contains(left), "{}", said.out);
    let report = std::fs::read_to_string(folder.path().join("run/report.html")).expect("a report");
    assert!(report.contains(left), "the report names what was left out");
}

/// Gyros that lean by 2 mrad show 0.2 % of azimuth's 60 deg/s as elevation, which friction holds.
#[test]
fn gyros_out_of_square_stop_a_slew_only_where_the_rig_declares_less_than_they_are() {
    let folder = folder();
    let unit = "schema = 1\nid = \"leaning\"\ntitle = \"Gyros lean\"\nbase = \"nominal\"\n[imu]\n\
                misalignment-x = \"2 mrad\"\nmisalignment-y = \"-2 mrad\"\nmisalignment-z = \"2 mrad\"\n";
    write(folder.path(), "leaning.toml", unit);
    let declares_less = RIG.replacen("cross-axis-error = \"4 %\"", "cross-axis-error = \"100 ppm\"", 1);
    assert!(declares_less != RIG, "the shipped rig declares 4 %");
    write(folder.path(), "rig.toml", &declares_less);
    for (rig, trips) in [("sim", false), ("./rig.toml", true)] {
        let out = format!("run-{trips}");
        let asked = [
            "run",
            "quick/az-slew.toml",
            "--unit",
            "./leaning.toml",
            "--rig",
            rig,
            "--non-interactive",
            "--out",
            &out,
        ];
        let said = run_in(folder.path(), &asked);
        let text = format!("{}\n{}", said.out, said.err);
        assert_eq!(text.contains("frozen encoder"), trips, "{rig}: {text}");
        assert_eq!(
            said.code == 0 || said.code == 3,
            !trips || said.code == 3,
            "{rig}: {}\n{text}",
            said.code
        );
    }
}

#[test]
fn errors_of_the_gyros_that_no_encoder_could_be_watched_by_are_refused() {
    let folder = folder();
    let rig = RIG.replacen("cross-axis-error = \"4 %\"", "cross-axis-error = \"30 %\"", 1).replacen(
        "rate-bias = \"100 urad/s\"",
        "rate-bias = \"-1 deg/s\"",
        1,
    );
    write(folder.path(), "rig.toml", &rig);
    let said = run_in(folder.path(), &["check", "--rig", "rig.toml"]);
    assert_eq!(said.code, 2);
    insta::assert_snapshot!(said.err);
}
