//! Real devices, locks, prompts, lost runs: what is refused, and how a rig is released again.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::bench::{Said, folder, run_in, write};

const RIG: &str = include_str!("../bench/rigs/sim.toml");
const FRICTION: &str = include_str!("../procedures/quick/az-friction.toml");
const POLARITY: &str = include_str!("../procedures/polarity.toml");

/// A rig of its own name, so that tests do not lock each other out, and a unit whose drives claim a real maker.
fn real_rig(folder: &Path) {
    let name = folder.file_name().expect("a name").to_string_lossy().replace('.', "");
    // With a real device no instrument is declared simulated.
    let certified = "maker = \"M\"\nmodel = \"1\"\nserial-number = \"7\"\ncertificate = \"C\"\ncalibrated = \"2020-01-01\"\ndue = \"2999-12-31\"\n";
    let rig = RIG.replace("simulated = true\n", certified);
    write(folder, "rig.toml", &rig.replacen("id = \"sim\"", &format!("id = \"sim-{name}\""), 1));
    let unit = "schema = 1\nid = \"claims\"\ntitle = \"Claims to be real\"\nbase = \"nominal\"\n[wiring]\nvendor = \"154\"\n";
    write(folder, "unit.toml", unit);
}

/// A campaign in which nobody is asked anything, so that it runs without a terminal.
fn unattended(folder: &Path, name: &str, procedure: &str) {
    let polarity = POLARITY.split("[[prompt]]").next().expect("text before the question");
    write(folder, "polarity.toml", polarity);
    write(folder, "requirements.toml", include_str!("../procedures/requirements.toml"));
    let files =
        ["polarity.toml", procedure].map(|file| format!("[[procedure]]\nfile = \"{file}\"\n")).concat();
    let head = format!(
        "schema = 1\nid = \"{name}\"\ntitle = \"{name}\"\nrequirements = \"requirements.toml\"\nmust-measure = []\n"
    );
    write(folder, &format!("{name}.toml"), &format!("{head}{files}"));
}

fn run(folder: &Path, more: &[&str]) -> Said {
    let all = [&["run", "--rig", "./rig.toml", "--unit", "./unit.toml"], more].concat();
    run_in(folder, &all)
}

fn refused(said: &Said, because: &str) {
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.err.contains("refused before motion: ") && said.err.contains(because), "{}", said.err);
}

#[test]
fn with_real_devices_a_planted_defect_and_parallel_jobs_are_refused() {
    let folder = folder();
    real_rig(folder.path());
    refused(
        &run(folder.path(), &["quick/az-friction", "--jobs", "2"]),
        "--jobs 2: az-drive is real, and real axes run one procedure at a time",
    );
    let defect = "schema = 1\nid = \"bad\"\ntitle = \"Bad\"\nbase = \"unit.toml\"\nmust-trip = \"polarity\"\nreason = \"Planted.\"\n[az]\nencoder-sign = \"-1\"\n";
    write(folder.path(), "defect.toml", defect);
    let said = run_in(
        folder.path(),
        &["run", "quick/az-friction", "--rig", "./rig.toml", "--unit", "./defect.toml"],
    );
    refused(&said, "unit `bad` is a planted defect, but az-drive is real");
}

fn with_prompt(folder: &Path, class: &str) {
    let prompt = format!(
        "\n[[prompt]]\nid = \"area-clear\"\nclass = \"{class}\"\ntext = \"Is nobody inside the fence?\"\n"
    );
    write(folder, "p.toml", &format!("{FRICTION}{prompt}"));
}

#[test]
fn with_real_devices_a_safety_prompt_wants_somebody_at_a_terminal() {
    let folder = folder();
    real_rig(folder.path());
    with_prompt(folder.path(), "safety");
    unattended(folder.path(), "asking", "p.toml");
    write(folder.path(), "answers.toml", "schema = 1\n[answers]\narea-clear = \"yes\"\n");
    for (more, because) in [
        (&["--yes"][..], "--yes: safety prompt `area-clear` must be answered by a person at the rig"),
        (&["--non-interactive"], "--non-interactive: safety prompt `area-clear`"),
        (&["--answers", "answers.toml"], "--answers: safety prompt `area-clear`"),
        (&[], "safety prompt `area-clear` must be answered at a terminal"),
    ] {
        refused(&run(folder.path(), &[&["./asking.toml"], more].concat()), because);
    }
    // The first motion asks whether the axes stand where they are read.
    let alone = run(folder.path(), &["quick/az-friction"]);
    refused(&alone, "safety prompt `axes-at-pose` must be answered at a terminal");
}

#[test]
fn a_simulated_rig_takes_answers_from_a_file_and_keeps_them_in_the_journal() {
    let folder = folder();
    with_prompt(folder.path(), "safety");
    let said = run_in(folder.path(), &["run", "p.toml", "--non-interactive", "--out", "none"]);
    refused(&said, "prompt `area-clear` has no answer and cannot be asked");
    write(folder.path(), "yes.toml", "schema = 1\n[answers]\narea-clear = \"yes\"\n");
    let ok = ["run", "p.toml", "--answers", "yes.toml", "--operator", "Ada", "--out", "yes"];
    let said = run_in(folder.path(), &ok);
    assert!(said.code == 0 || said.code == 3, "{}{}", said.out, said.err);
    let journal = std::fs::read_to_string(folder.path().join("yes/journal.jsonl")).expect("a journal");
    let answered = journal.lines().find(|line| line.contains("\"answered\"") && line.contains("area-clear"));
    let answered = answered.expect("on record");
    for part in
        ["\"prompt\":\"area-clear\"", "\"answer\":\"yes\"", "\"by\":\"Ada\"", "\"how\":\"answers file\""]
    {
        assert!(answered.contains(part), "{answered}");
    }
    write(folder.path(), "no.toml", "schema = 1\n[answers]\narea-clear = \"no\"\n");
    let said = run_in(folder.path(), &["run", "p.toml", "--answers", "no.toml", "--out", "no"]);
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.err.contains("prompt `area-clear` was answered with `no`"), "{}", said.err);
    write(folder.path(), "typo.toml", "schema = 1\n[answers]\narea-claer = \"yes\"\n");
    let said = run_in(folder.path(), &["run", "p.toml", "--answers", "typo.toml", "--out", "typo"]);
    assert_eq!(said.code, 2, "{}{}", said.out, said.err);
    assert!(said.err.contains("did you mean `area-clear`?"), "{}", said.err);
}

/// A long run on the rig of this folder, once its journal says that a point has begun.
fn in_motion(folder: &Path) -> Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(["run", "./cogging.toml", "--rig", "./rig.toml", "--unit", "./unit.toml", "--out", "lost"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program under test starts");
    let moves = || {
        let journal = std::fs::read_to_string(folder.join("lost/journal.jsonl")).unwrap_or_default();
        journal.contains("\"procedure\":\"AZ-COGGING\"")
    };
    for _ in 0..600 {
        if moves() {
            return child;
        }
        let _ = Command::new("sleep").arg("0.1").status();
    }
    child.kill().and_then(|()| child.wait()).expect("it was started");
    panic!("the run does not begin");
}

#[test]
fn a_rig_in_use_is_refused_and_one_whose_run_was_lost_must_be_inspected() {
    let folder = folder();
    let at = folder.path();
    real_rig(at);
    unattended(at, "friction", "shipped:quick/az-friction.toml");
    unattended(at, "cogging", "shipped:fat/az-cogging.toml");
    let mut child = in_motion(at);
    let said = run(at, &["./friction.toml", "--out", "second"]);
    refused(&said, "is in use by run ");
    assert!(said.err.contains(&format!("process {}", child.id())), "{}", said.err);
    child.kill().and_then(|()| child.wait()).expect("killed in motion");
    let said = run(at, &["./friction.toml", "--out", "third"]);
    refused(&said, "was lost while armed");
    assert!(said.err.contains("`bench inspect "), "{}", said.err);
    let said = run_in(at, &["inspect", "lost"]);
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.out.contains("lost in AZ-COGGING ["), "{}", said.out);
    assert!(said.err.contains("--operator NAME --found TEXT"), "{}", said.err);
    write(
        at,
        "moved.toml",
        "schema = 1\nid = \"moved\"\ntitle = \"Moved\"\nbase = \"unit.toml\"\n[az]\nencoder-zero = \"1 deg\"\n",
    );
    let look = ["inspect", "lost", "--operator", "Ada", "--found", "nothing broken"];
    let moved = run_in(at, &[&look[..], &["--unit", "./moved.toml"]].concat());
    assert_eq!(moved.code, 6, "{}{}", moved.out, moved.err);
    assert!(moved.err.contains("positions do not agree"), "{}", moved.err);
    refused(&run(at, &["./friction.toml", "--out", "fourth"]), "was lost while armed");
    let said = run_in(at, &look);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let journal = std::fs::read_to_string(at.join("lost/journal.jsonl")).expect("a journal");
    assert!(journal.trim_end().lines().last().expect("lines").contains("\"by\":\"Ada\""), "{journal}");
    let said = run(at, &["./friction.toml", "--out", "fifth"]);
    assert!(said.code == 0 || said.code == 3, "{}{}", said.out, said.err);
    let said = run_in(at, &["inspect", "fifth"]);
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.err.contains("this run ended normally"), "{}", said.err);
}

#[test]
fn a_run_that_met_an_end_stop_says_4_names_it_and_stays_locked_until_somebody_has_looked() {
    let folder = folder();
    let at = folder.path();
    real_rig(at);
    unattended(at, "friction", "shipped:quick/az-friction.toml");
    // Something lies in the way of the azimuth, where the rig file knows of free travel.
    let blocked = "schema = 1\nid = \"blocked\"\ntitle = \"Blocked\"\nbase = \"unit.toml\"\n[az]\nupper-stop = \"35 deg\"\n";
    write(at, "blocked.toml", blocked);
    let on = ["run", "./friction.toml", "--rig", "./rig.toml", "--unit", "./blocked.toml", "--out", "hit"];
    let said = run_in(at, &on);
    assert_eq!(said.code, 4, "{}{}", said.out, said.err);
    let named = |line: &&str| line.contains("AZ-FRICTION [") && line.contains("az hit its end stop at ");
    assert!(said.out.lines().any(|line| named(&line)), "the last lines name it: {}", said.out);
    assert!(said.out.contains("the rig stays locked until `bench inspect hit`"), "{}", said.out);
    refused(&run(at, &["./friction.toml", "--out", "second"]), "az hit its end stop at ");
    let said = run_in(at, &["inspect", "hit", "--operator", "Ada", "--found", "a bolt, taken away"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("az hit its end stop at "), "{}", said.out);
    // The rig is free again: what keeps this run is that the unit has changed since then.
    let said = run(at, &["./friction.toml", "--out", "third", "--polarity", "hit"]);
    refused(&said, "its proof is no longer valid");
}

#[test]
fn a_unit_wired_the_wrong_way_moves_nothing_under_a_loop() {
    for unit in ["encoder-sign", "gyro-sign"] {
        let folder = folder();
        let said = run_in(folder.path(), &["run", "quick/az-friction", "--unit", unit, "--out", "run"]);
        assert_eq!(said.code, 3, "{unit}: {}{}", said.out, said.err);
        let journal = std::fs::read_to_string(folder.path().join("run/journal.jsonl")).expect("a journal");
        assert!(journal.contains("\"proven\":false"), "{unit}: {journal}");
        let skipped = journal.lines().find(|line| line.contains("\"skipped\"")).expect("skipped");
        assert!(skipped.contains("\"reason\":\"polarity: "), "{unit}: {skipped}");
        assert!(!folder.path().join("run/AZ-FRICTION.mcap").exists(), "{unit}");
        let again = run_in(folder.path(), &["rejudge", "run"]);
        assert!(again.out.contains("findings are identical byte for byte"), "{}{}", again.out, again.err);
        let report = std::fs::read_to_string(folder.path().join("run/report.html")).expect("a report");
        assert!(report.contains("polarity: "), "{unit}: the report says why");
    }
}

#[test]
fn a_proof_of_polarity_holds_for_a_later_run_until_something_changes() {
    let folder = folder();
    let shipped = include_str!("../procedures/quick/az-friction.toml");
    let all = "velocity = [\"2 deg/s\", \"10 deg/s\", \"20 deg/s\", \"40 deg/s\", \"60 deg/s\"]";
    let one = shipped.replacen(all, "velocity = [\"60 deg/s\"]", 1);
    assert_ne!(shipped, one, "the shipped procedure has five velocities");
    write(folder.path(), "friction.toml", &one);
    let first = run_in(folder.path(), &["run", "./friction.toml", "--out", "first"]);
    assert!(first.code == 0 || first.code == 3, "{}{}", first.out, first.err);
    let later = ["run", "./friction.toml", "--polarity", "first", "--out"];
    let said = run_in(folder.path(), &[&later[..], &["second"]].concat());
    assert_eq!(said.code, first.code, "{}{}", said.out, said.err);
    assert!(!folder.path().join("second/POLARITY.mcap").exists());
    let said = run_in(folder.path(), &[&later[..], &["third", "--unit", "as-measured"]].concat());
    refused(&said, "its proof is no longer valid, because this has changed: the unit file");
}
