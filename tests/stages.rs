//! Stages, build states, calibration, masks: what keeps a campaign from going on, and what is measured but not judged.

use std::path::Path;

use crate::bench::{Said, findings, folder, run_in, verdict, write};

const RIG: &str = include_str!("../bench/rigs/sim.toml");
const BREAKAWAY: &str = include_str!("../procedures/quick/az-breakaway.toml");

/// Friction of azimuth at two speeds: the shortest closed loop there is.
const FRICTION: &str = "schema = 1\nid = \"AZ-FRICTION\"\ntitle = \"Friction\"\nkind = \"hysteresis\"\naxis = \"az\"\n\
                        log-rate = \"500 Hz\"\n[sweep]\nvelocity = [\"10 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\ncycles = 1\n";

const HEAD: &str =
    "schema = 1\nid = \"mine\"\ntitle = \"Mine\"\nrequirements = \"r.toml\"\nmust-measure = [\"FRC-AZ\"]\n";

/// Friction may be this large; the simulated unit has about 220 N*m at 10 deg/s.
fn requirements(folder: &Path, limit_nm: f64) {
    let text = format!(
        "schema = 1\n[[requirement]]\nid = \"FRC-AZ\"\ntext = \"Friction\"\nsource = \"test\"\nmethod = \"test\"\n\
         measurand = [\"friction-torque\"]\naxis = \"az\"\nlimit = \"<= {limit_nm} N*m\"\n"
    );
    write(folder, "r.toml", &text);
}

fn stage(id: &str, more: &str, file: &str) -> String {
    format!(
        "[[stage]]\nid = \"{id}\"\ntitle = \"T\"\n{more}\n[[procedure]]\nfile = \"{file}\"\nstage = \"{id}\"\n"
    )
}

/// Friction, then breakaway, which needs it.
fn two_stages(folder: &Path, needs: &str) {
    write(folder, "friction.toml", FRICTION);
    write(folder, "later.toml", &FRICTION.replace("AZ-FRICTION", "LATER").replace("10 deg/s", "20 deg/s"));
    let text =
        format!("{HEAD}{}{}", stage("friction", "", "friction.toml"), stage("later", needs, "later.toml"));
    write(folder, "c.toml", &text);
}

fn run(folder: &Path, more: &[&str]) -> Said {
    run_in(folder, &[&["run", "c.toml", "--non-interactive"], more].concat())
}

fn procedure(run: &Path, id: &str) -> serde_json::Value {
    let all: serde_json::Value = serde_json::from_str(&findings(run)).expect("JSON");
    let found = all["procedures"].as_array().expect("a list").iter().find(|p| p["id"] == id).cloned();
    found.expect("a procedure of the campaign")
}

#[test]
fn a_stage_whose_need_failed_is_skipped_with_the_reason_whatever_the_number_of_jobs() {
    let folder = folder();
    let at = folder.path();
    two_stages(at, "needs = [\"friction\"]\nneeds-pass = [\"FRC-AZ\"]");
    requirements(at, 100.0);
    let mut same = Vec::new();
    for jobs in ["1", "2"] {
        let said = run(at, &["--jobs", jobs, "--out", jobs]);
        assert_eq!(said.code, 1, "FRC-AZ failed: {}{}", said.out, said.err);
        let later = procedure(&at.join(jobs), "LATER");
        assert_eq!(later["status"], "skipped");
        assert_eq!(later["remarks"][0], "stage `later` needs requirement FRC-AZ to pass: it failed");
        assert!(!at.join(jobs).join("LATER.mcap").exists());
        same.push(findings(&at.join(jobs)));
    }
    assert_eq!(same[0], same[1]);
    let again = run_in(at, &["rejudge", "1"]);
    assert!(again.out.contains("findings are identical byte for byte"), "{}{}", again.out, again.err);
    let report = std::fs::read_to_string(at.join("1/report.html")).expect("a report");
    assert!(report.contains("needs requirement FRC-AZ to pass"), "the report says why");
}

#[test]
fn a_stage_whose_need_did_not_complete_is_skipped_and_the_run_is_incomplete() {
    let folder = folder();
    let at = folder.path();
    two_stages(at, "needs = [\"friction\"]");
    requirements(at, 400.0);
    let good = run(at, &["--out", "good"]);
    assert_eq!(good.code, 0, "{}{}", good.out, good.err);
    assert_eq!(procedure(&at.join("good"), "LATER")["status"], "completed");
    assert_eq!(procedure(&at.join("good"), "LATER")["stage"], "later");
    // A gate that is closed: friction does not begin, and what needs it says so.
    write(at, "friction.toml", &format!("{FRICTION}[gate]\nheat-sink = \"< 10 degC\"\n"));
    let said = run(at, &["--out", "run"]);
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    let later = procedure(&at.join("run"), "LATER");
    assert_eq!(later["status"], "skipped");
    assert_eq!(later["remarks"][0], "stage `later` needs stage `friction`: AZ-FRICTION aborted");
    assert_ne!(verdict(&at.join("run"), "FRC-AZ"), "pass");
}

fn early(at: &Path) {
    write(at, "table.toml", &FRICTION.replace("AZ-FRICTION", "TABLE"));
    write(
        at,
        "signs.toml",
        &include_str!("../procedures/polarity.toml").replace("\"POLARITY\"", "\"SIGNS\""),
    );
    write(at, "friction.toml", FRICTION);
    let asks =
        |id: &str| format!("[[stage.prompt]]\nid = \"{id}\"\nclass = \"safety\"\ntext = \"Is it there?\"\n");
    let table = format!("state = \"azimuth-table\"\ninertia = {{ az = \"640 kg*m^2\" }}\n{}", asks("bare"));
    let text = format!(
        "{HEAD}{}{}[[procedure]]\nfile = \"signs.toml\"\nstage = \"table\"\n",
        stage("table", &table, "table.toml"),
        stage("final", &format!("state = \"final\"\n{}", asks("complete")), "friction.toml")
    );
    write(at, "c.toml", &text);
}

#[test]
fn an_earlier_build_state_is_measured_reported_and_not_judged() {
    let folder = folder();
    let at = folder.path();
    early(at);
    requirements(at, 400.0);
    let said = run(at, &["--out", "run"]);
    assert_eq!(said.code, 0, "nobody is asked on simulated devices: {}{}", said.out, said.err);
    let table = procedure(&at.join("run"), "TABLE");
    let built = procedure(&at.join("run"), "AZ-FRICTION");
    assert_eq!((&table["status"], &table["state"]), (&"completed".into(), &"azimuth-table".into()));
    assert!(table["measurements"].as_array().is_some_and(|all| all.iter().any(|m| m["value"].is_f64())));
    assert_eq!(table["judgements"].as_array().map(Vec::len), Some(0));
    assert!(built["judgements"].as_array().is_some_and(|all| !all.is_empty()) && built["state"].is_null());
    let journal = std::fs::read_to_string(at.join("run/journal.jsonl")).expect("a journal");
    assert!(journal.contains("\"how\":\"simulated: state applied\""), "{journal}");
    let report = std::fs::read_to_string(at.join("run/report.html")).expect("a report");
    assert!(report.contains("build state azimuth-table") && report.contains("Build states"));
    let again = run_in(at, &["rejudge", "run"]);
    assert!(again.out.contains("findings are identical byte for byte"), "{}{}", again.out, again.err);
    // Its own log says so, too.
    let alone = run_in(at, &["rejudge", "run/TABLE.mcap"]);
    assert_eq!(alone.code, 0, "{}{}", alone.out, alone.err);
    // The state alone verifies nothing.
    requirements(at, 100.0);
    let early_only = run(at, &["--select", "table", "--out", "early"]);
    assert_ne!(early_only.code, 1, "{}{}", early_only.out, early_only.err);
    assert_eq!(verdict(&at.join("early"), "FRC-AZ"), "none");
}

#[test]
fn a_plan_tells_stages_states_questions_and_instruments() {
    let folder = folder();
    early(folder.path());
    requirements(folder.path(), 400.0);
    let said = run_in(folder.path(), &["plan", "c.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for part in [
        "azimuth-table: not judged",
        "Is it there? (with simulated devices the bench answers)",
        "instruments",
        "complete",
    ] {
        assert!(said.out.contains(part), "{part:?} is not in {}", said.out);
    }
    let none = run_in(folder.path(), &["plan", "c.toml", "--select", "tracker"]);
    assert_eq!(none.code, 5, "`tracker` is no stage: {}", none.err);
}

#[test]
fn a_question_of_a_stage_that_nobody_answers_refuses_at_once() {
    let folder = folder();
    let at = folder.path();
    write(at, "friction.toml", FRICTION);
    requirements(at, 400.0);
    let asks = "[[stage.prompt]]\nid = \"covers-on\"\nclass = \"info\"\ntext = \"Are the covers on?\"\n";
    write(at, "c.toml", &format!("{HEAD}{}", stage("friction", asks, "friction.toml")));
    let said = run(at, &["--out", "run"]);
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.err.contains("prompt `covers-on` has no answer and cannot be asked"), "{}", said.err);
    assert!(!at.join("run/journal.jsonl").exists(), "nothing has begun");
    write(at, "yes.toml", "schema = 1\n[answers]\ncovers-on = \"yes\"\n");
    assert_eq!(run(at, &["--answers", "yes.toml", "--out", "yes"]).code, 0);
}

#[test]
fn an_overdue_calibration_refuses_the_run_and_a_valid_one_stands_in_the_report() {
    let folder = folder();
    let at = folder.path();
    let with_due = |due: &str| {
        let certified = format!(
            "maker = \"Maker\"\nmodel = \"M1\"\nserial-number = \"77\"\ncertificate = \"C-12\"\ncalibrated = \"2020-01-01\"\ndue = \"{due}\"\n"
        );
        write(at, "rig.toml", &RIG.replacen("simulated = true\n", &certified, 1));
        run_in(at, &["run", "quick/az-breakaway", "--rig", "./rig.toml", "--non-interactive", "--out", due])
    };
    let said = with_due("2021-01-01");
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    for part in
        ["Maker M1, serial number 77", "was due on 2021-01-01", "certificate C-12", "have it calibrated"]
    {
        assert!(said.err.contains(part), "{part:?} is not in {}", said.err);
    }
    let said = with_due("2999-12-31");
    assert!(matches!(said.code, 0 | 3), "{}{}", said.out, said.err);
    let report = std::fs::read_to_string(at.join("2999-12-31/report.html")).expect("a report");
    assert!(report.contains("calibrated until 2999-12-31") && report.contains("C-12"));
    let again = run_in(at, &["rejudge", "2999-12-31", "--out", "again"]);
    assert!(again.out.contains("findings are identical byte for byte"), "{}{}", again.out, again.err);
    let report = std::fs::read_to_string(at.join("again/report.html")).expect("a report");
    assert!(report.contains("calibrated until 2999-12-31"), "whoever judges again says what was valid then");
}

#[test]
fn a_mask_over_the_place_where_the_axes_are_parked_names_both() {
    let folder = folder();
    let at = folder.path();
    // Azimuth is parked inside the zone that it is ordered into, while elevation rests in the middle of it.
    let parked = RIG.replacen("safe-state = \"hold\"", "safe-state = \"release\"\nsafe-pose = \"40 deg\"", 1);
    write(at, "rig.toml", &parked);
    for (verb, code) in [("check", 2), ("run", 6)] {
        let said = run_in(at, &[verb, "quick/az-range", "--rig", "./rig.toml"]);
        assert_eq!(said.code, code, "{}{}", said.out, said.err);
        for part in
            ["the restricted zone az ", "covers the place where the axes are parked: az 40 deg, el 0 deg"]
        {
            assert!(said.err.contains(part), "{part:?} is not in {}", said.err);
        }
    }
}

#[test]
fn a_procedure_that_a_campaign_lists_twice_is_a_mistake() {
    let folder = folder();
    let at = folder.path();
    write(at, "breakaway.toml", BREAKAWAY);
    requirements(at, 400.0);
    let twice = "[[procedure]]\nfile = \"breakaway.toml\"\n".repeat(2);
    write(at, "c.toml", &format!("{HEAD}{twice}"));
    let said = run_in(at, &["check", "c.toml"]);
    assert_eq!(said.code, 2, "{}{}", said.out, said.err);
    assert!(said.err.contains("two procedures have the id `AZ-BREAKAWAY`"), "{}", said.err);
}
