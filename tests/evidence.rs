//! What becomes of a run folder that somebody changed: it is found, told on every document, and ends with 65.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use ::bench::record::evidence::check;
use ::bench::record::journal::{self, Entry};
use reports::record::{EvidenceRecord, EvidenceState};

use crate::bench::{Said, folder, run_in, write};

const FRICTION: &str = "schema = 1\nid = \"AZ-FRICTION\"\ntitle = \"Friction\"\nkind = \"hysteresis\"\naxis = \"az\"\n\
                        log-rate = \"500 Hz\"\n[sweep]\nvelocity = [\"20 deg/s\"]\n\
                        span = \"-60 deg .. 60 deg\"\ncycles = 1\n";
const CAMPAIGN: &str = "schema = 1\nid = \"mine\"\ntitle = \"Mine\"\nrequirements = \"r.toml\"\n\
                        must-measure = [\"FRC-AZ\"]\n[[procedure]]\nfile = \"friction.toml\"\n[[procedure]]\n\
                        file = \"later.toml\"\n";
const REQUIREMENTS: &str = "schema = 1\n[[requirement]]\nid = \"FRC-AZ\"\ntext = \"Friction\"\nsource = \"test\"\n\
                            method = \"test\"\nmeasurand = [\"friction-torque\"]\naxis = \"az\"\n\
                            limit = \"<= 400 N*m\"\n";

/// One run of each unit for all tests: `nominal` and `as-measured`.
fn runs() -> &'static Path {
    static RUNS: OnceLock<tempfile::TempDir> = OnceLock::new();
    let made = RUNS.get_or_init(|| {
        let folder = folder();
        write(folder.path(), "friction.toml", FRICTION);
        write(
            folder.path(),
            "later.toml",
            &FRICTION.replace("AZ-FRICTION", "AZ-LATER").replace("20 deg", "30 deg"),
        );
        write(folder.path(), "r.toml", REQUIREMENTS);
        write(folder.path(), "c.toml", CAMPAIGN);
        for unit in ["nominal", "as-measured"] {
            let said =
                run_in(folder.path(), &["run", "c.toml", "--unit", unit, "--out", unit, "--non-interactive"]);
            assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        }
        folder
    });
    made.path()
}

/// A copy of the run on `nominal`, with this done to it.
fn altered(alter: impl FnOnce(&Path)) -> (tempfile::TempDir, PathBuf) {
    let folder = folder();
    let run = folder.path().join("run");
    std::fs::create_dir(&run).expect("a fresh folder");
    for file in std::fs::read_dir(runs().join("nominal")).expect("a run").flatten() {
        std::fs::copy(file.path(), run.join(file.file_name())).expect("a writable folder");
    }
    alter(&run);
    (folder, run)
}

/// Changes a text file of a run folder.
fn edit(run: &Path, file: &str, change: impl FnOnce(&str) -> String) {
    let path = run.join(file);
    let before = std::fs::read_to_string(&path).expect("a text");
    let after = change(&before);
    assert_ne!(before, after, "{file} is changed");
    std::fs::write(path, after).expect("writable");
}

/// Puts a file of the run on another unit in its place.
fn from_other(run: &Path, from: &str, to: &str) {
    std::fs::copy(runs().join("as-measured").join(from), run.join(to)).expect("both runs have it");
}

fn swap(run: &Path, one: &str, other: &str) {
    std::fs::rename(run.join(one), run.join("between")).expect("renamed");
    std::fs::rename(run.join(other), run.join(one)).expect("renamed");
    std::fs::rename(run.join("between"), run.join(other)).expect("renamed");
}

fn cut(run: &Path, file: &str, share: u64) {
    let log = std::fs::OpenOptions::new().write(true).open(run.join(file)).expect("a log");
    let length = log.metadata().expect("a file").len();
    log.set_len(length * share / 100).expect("writable");
}

/// The chain computed anew over lines that somebody has changed: whoever can do that needs no old digest.
fn rechained(text: &str, change: impl Fn(&mut serde_json::Value) -> bool) -> String {
    let mut previous = "0".repeat(64);
    let mut out = String::new();
    let mut n = 0;
    for line in text.lines() {
        let mut value: serde_json::Value = serde_json::from_str(line).expect("a line");
        if !change(&mut value) {
            continue;
        }
        value["n"] = n.into();
        value["previous_sha256"] = previous.into();
        if value["entry"] == "closed" {
            value["entries"] = (n + 1).into();
        }
        let line = value.to_string();
        previous = journal::sha256(line.as_bytes());
        out += &format!("{line}\n");
        n += 1;
    }
    out
}

/// The folder as a version left it that kept no digests: no index, nothing on record.
fn as_of_an_older_version(run: &Path) {
    edit(run, journal::FILE, |text| rechained(text, |line| line["entry"] != "kept"));
    std::fs::remove_file(run.join("SHA256SUMS")).expect("an index");
}

fn found_altered(run: &Path, expected: &str, name: &str) {
    let EvidenceRecord { state, reasons, .. } = check(run);
    let reasons = reasons.join("\n");
    assert_eq!(state, EvidenceState::Altered, "{name}: {reasons}");
    assert!(reasons.contains(expected), "{name}: {expected:?} is not in {reasons}");
}

fn rejudged(run: &Path) -> Said {
    run_in(run.parent().expect("a parent"), &["rejudge", "run"])
}

#[test]
fn a_run_that_nobody_touched_is_intact_for_us_and_for_sha256sum() {
    let run = runs().join("nominal");
    let found = check(&run);
    assert_eq!((found.state, found.reasons.len()), (EvidenceState::Intact, 0), "{:?}", found.reasons);
    let sums =
        Command::new("sha256sum").args(["--check", "--strict", "SHA256SUMS"]).current_dir(&run).output();
    let sums = sums.expect("coreutils");
    assert!(sums.status.success(), "{}", String::from_utf8_lossy(&sums.stdout));
    let listed = String::from_utf8_lossy(&sums.stdout).lines().count();
    assert_eq!(listed, found.files.len(), "journal, title page, results and every log");
    for (document, text) in [
        ("report.html", "<strong>Evidence: </strong>intact: "),
        ("report.md", "Evidence: intact: "),
        ("junit.xml", "<system-out>intact: "),
        ("results.csv", ",intact\r\n"),
    ] {
        let written = std::fs::read_to_string(run.join(document)).expect("a document");
        assert!(written.contains(text), "{document} does not say {text:?}");
    }
    let html = std::fs::read_to_string(run.join("report.html")).expect("a report");
    let journal = std::fs::read(run.join(journal::FILE)).expect("a journal");
    assert!(
        html.contains(&journal::sha256(&journal)),
        "the digest in the index is that of the closed journal"
    );
}

#[test]
fn a_forged_verdict_is_told_on_every_document_and_ends_with_65() {
    let (folder, run) = altered(|run| {
        edit(run, "results.json", |text| text.replace("\"overall\": \"pass\"", "\"overall\": \"fail\""));
    });
    let formats = ["report", "run", "--format", "html,md,junit,csv,json", "--out", "told"];
    let said = run_in(folder.path(), &formats);
    assert_eq!(said.code, 65, "{}{}", said.out, said.err);
    assert!(
        said.err.contains("results.json differs from the file that the journal has on record"),
        "{}",
        said.err
    );
    for (document, text) in [
        ("report.html", ">EVIDENCE ALTERED<"),
        ("report.md", "**Evidence: ALTERED: results"),
        ("junit.xml", "<error type=\"bench\" message=\"ALTERED: "),
        ("results.csv", ",ALTERED\r\n"),
        ("results.json", "\"state\": \"altered\""),
    ] {
        let written = std::fs::read_to_string(folder.path().join("told").join(document)).expect("a document");
        assert!(written.contains(text), "{document} does not say {text:?}");
    }
    let said = rejudged(&run);
    assert_eq!(said.code, 65, "{}{}", said.out, said.err);
    assert!(said.out.contains("findings differ"), "{}", said.out);
}

#[test]
fn a_journal_that_was_edited_removed_linked_or_is_of_another_run_is_found() {
    type Alter = fn(&Path);
    let cases: [(&str, Alter, &str); 8] = [
        (
            "an edited word",
            |run| edit(run, journal::FILE, |t| t.replacen("completed", "aborted", 1)),
            "the hash chain is broken",
        ),
        (
            "the closing entry edited",
            |run| edit(run, journal::FILE, |t| t.replace("\"exit_code\":0", "\"exit_code\":1")),
            "journal.jsonl does not match its digest in SHA256SUMS",
        ),
        ("another run's journal", |run| from_other(run, journal::FILE, journal::FILE), "to another run"),
        (
            "another run's title page",
            |run| from_other(run, "run.json", "run.json"),
            "run.json differs from the file that the journal",
        ),
        (
            "the chain computed anew",
            |run| {
                edit(run, journal::FILE, |t| {
                    rechained(t, |l| {
                        l["entry"] != "answered" && {
                            l["utc"] = "then".into();
                            true
                        }
                    })
                })
            },
            "journal.jsonl does not match its digest in SHA256SUMS",
        ),
        (
            "no journal",
            |run| std::fs::remove_file(run.join(journal::FILE)).expect("removed"),
            "journal.jsonl",
        ),
        (
            "no title page",
            |run| std::fs::remove_file(run.join("run.json")).expect("removed"),
            "run.json is missing",
        ),
        (
            "a link",
            |run| {
                std::fs::rename(run.join(journal::FILE), run.join("elsewhere")).expect("renamed");
                std::os::unix::fs::symlink("elsewhere", run.join(journal::FILE)).expect("a link");
            },
            "journal.jsonl is a symbolic link",
        ),
    ];
    for (name, alter, expected) in cases {
        let (_folder, run) = altered(alter);
        found_altered(&run, expected, name);
    }
}

#[test]
fn a_journal_without_one_of_its_lines_or_with_two_in_the_wrong_order_is_found() {
    let lines = |text: &str, take: &dyn Fn(&mut Vec<&str>)| {
        let mut lines: Vec<&str> = text.lines().collect();
        take(&mut lines);
        lines.join("\n") + "\n"
    };
    let shortened =
        |take: &dyn Fn(&mut Vec<&str>)| altered(|run| edit(run, journal::FILE, |t| lines(t, take)));
    let (_folder, run) = shortened(&|lines| lines.truncate(lines.len() - 1));
    found_altered(&run, "no closing entry", "the last line dropped");
    let (_folder, run) = shortened(&|lines| {
        lines.remove(3);
    });
    found_altered(&run, "the hash chain is broken", "a line dropped");
    let (_folder, run) = shortened(&|lines| lines.swap(3, 4));
    found_altered(&run, "the hash chain is broken", "two lines swapped");
    assert_eq!(rejudged(&run).code, 65);
}

#[test]
fn a_log_that_was_added_removed_swapped_cut_off_emptied_or_replaced_by_a_link_is_found() {
    type Alter = fn(&Path);
    const LOG: &str = "AZ-FRICTION.mcap";
    let cases: [(&str, Alter, &str); 8] = [
        (
            "another unit's",
            |run| from_other(run, LOG, LOG),
            "AZ-FRICTION.mcap belongs to another run than the title page (differing: unit)",
        ),
        (
            "an extra one",
            |run| from_other(run, LOG, "AZ-FRICTION.2.mcap"),
            "AZ-FRICTION.2.mcap does not belong to any procedure",
        ),
        ("none", |run| std::fs::remove_file(run.join(LOG)).expect("removed"), "AZ-FRICTION.mcap is missing"),
        ("two swapped", |run| swap(run, LOG, "AZ-LATER.mcap"), "AZ-LATER.mcap differs from the file"),
        ("cut off", |run| cut(run, LOG, 60), "AZ-FRICTION.mcap differs from the file"),
        ("empty", |run| cut(run, LOG, 0), "AZ-FRICTION.mcap differs from the file"),
        (
            "a link",
            |run| {
                std::fs::rename(run.join(LOG), run.join("elsewhere")).expect("renamed");
                std::os::unix::fs::symlink("elsewhere", run.join(LOG)).expect("a link");
            },
            "AZ-FRICTION.mcap is a symbolic link",
        ),
        (
            "a folder",
            |run| {
                std::fs::remove_file(run.join(LOG)).expect("removed");
                std::fs::create_dir(run.join(LOG)).expect("a folder");
            },
            "AZ-FRICTION.mcap is not a regular file",
        ),
    ];
    for (name, alter, expected) in cases {
        let (_folder, run) = altered(alter);
        found_altered(&run, expected, name);
    }
}

#[test]
fn a_log_that_cannot_be_read_costs_its_own_procedure_and_no_other() {
    for (share, reason) in [(0, "the log cannot be judged: not an MCAP file"), (60, "")] {
        let (folder, run) = altered(|run| cut(run, "AZ-LATER.mcap", share));
        let said = run_in(folder.path(), &["rejudge", "run", "--out", "again"]);
        assert_eq!(said.code, 65, "{}{}", said.out, said.err);
        assert!(said.err.contains("AZ-LATER.mcap"), "{}", said.err);
        let text =
            std::fs::read_to_string(folder.path().join("again/results.json")).expect("results are written");
        let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let all = found["findings"]["procedures"].as_array().expect("a list");
        let of = |id: &str| all.iter().find(|p| p["id"] == id).expect("a place in the findings");
        assert!(!of("AZ-FRICTION")["measurements"].as_array().expect("a list").is_empty());
        assert_eq!(of("AZ-FRICTION")["status"], "completed");
        assert_ne!(of("AZ-LATER")["status"], "completed");
        if share == 0 {
            assert_eq!(of("AZ-LATER")["status"], "errored");
            assert!(of("AZ-LATER")["remarks"][0].as_str().is_some_and(|r| r.starts_with(reason)), "{text}");
        }
        drop(run);
    }
}

#[test]
fn a_run_of_an_older_version_is_not_verifiable_but_nobody_calls_it_forged() {
    let (folder, run) = altered(as_of_an_older_version);
    let found = check(&run);
    assert_eq!(found.state, EvidenceState::NotVerifiable, "{:?}", found.reasons);
    let said = run_in(folder.path(), &["report", "run", "--format", "md", "--out", "told"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let told = std::fs::read_to_string(folder.path().join("told/report.md")).expect("a report");
    assert!(
        told.contains("Evidence: not verifiable: the run was made by a version that recorded no digests"),
        "{told}"
    );
    let said = rejudged(&run);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    // Its results still name the logs that they were judged from.
    from_other(&run, "AZ-LATER.mcap", "AZ-LATER.mcap");
    found_altered(
        &run,
        "AZ-LATER.mcap differs from the log that results.json was judged from",
        "another log",
    );
}

/// As a run leaves it that is killed in motion: no results, no index, the journal and a log without their ends.
#[test]
fn a_run_that_was_lost_is_not_verifiable_and_what_it_left_is_judged() {
    let (folder, run) = altered(|run| {
        edit(run, journal::FILE, |text| {
            let first_log = text.find("\"file\":\"AZ-").expect("a log on record");
            text[..first_log].to_owned()
        });
        let begun = std::fs::read_to_string(run.join(journal::FILE)).expect("a journal");
        for id in ["AZ-FRICTION", "AZ-LATER"].iter().filter(|id| !begun.contains(&format!("\"{id}\""))) {
            std::fs::remove_file(run.join(format!("{id}.mcap"))).expect("not begun yet");
        }
        for file in ["results.json", "SHA256SUMS"] {
            std::fs::remove_file(run.join(file)).expect("written last");
        }
    });
    let found = check(&run);
    let reasons = found.reasons.join("\n");
    assert_eq!(found.state, EvidenceState::NotVerifiable, "{reasons}");
    assert!(reasons.contains("the run was lost: its journal was never closed"), "{reasons}");
    assert!(reasons.contains(".mcap: the run was lost before this log was whole"), "{reasons}");
    let said = run_in(folder.path(), &["rejudge", "run", "--out", "again"]);
    assert!(said.code != 65 && folder.path().join("again/report.html").is_file(), "{}{}", said.out, said.err);
}

#[test]
fn findings_that_differ_without_a_reason_end_with_3_even_where_nothing_can_be_verified() {
    let (folder, run) = altered(|run| {
        as_of_an_older_version(run);
        edit(run, "results.json", |text| text.replacen("\"seed\": 1", "\"seed\": 2", 1));
    });
    let said = rejudged(&run);
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert!(said.out.contains("findings differ"), "{}", said.out);
    // Other limits are a reason.
    write(folder.path(), "wider.toml", &REQUIREMENTS.replace("400", "500"));
    let said = run_in(folder.path(), &["rejudge", "run", "--requirements", "wider.toml"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
}

#[test]
fn waivers_are_kept_beside_the_results_which_stay_as_the_run_wrote_them() {
    let (folder, run) = altered(|_| {});
    let waiver = "[[waiver]]\nrequirement = \"FRC-AZ\"\nnumber = \"W-1\"\napprover = \"Q\"\nexpiry = \"2999-01-01\"\n\
                  reason = \"r\"\n";
    write(folder.path(), "w.toml", &format!("schema = 1\n{waiver}"));
    let before = std::fs::read(run.join("results.json")).expect("results");
    let said = run_in(folder.path(), &["report", "run", "--format", "html,json", "--waivers", "w.toml"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(before == std::fs::read(run.join("results.json")).expect("results"));
    assert_eq!(check(&run).state, EvidenceState::Intact);
    let said = run_in(folder.path(), &["report", "run", "--format", "html,json", "--out", "later"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    for document in ["report.html", "results.json"] {
        let later = std::fs::read_to_string(folder.path().join("later").join(document)).expect("a document");
        assert!(later.contains("W-1"), "{document} forgets the waiver");
    }
}

#[test]
fn of_two_runs_into_one_folder_one_is_refused_and_touches_nothing() {
    let folder = folder();
    let start = |seed: &str| {
        let arguments = ["run", "quick/el-breakaway", "--out", "run", "--non-interactive", "--seed", seed];
        let mut command = Command::new(env!("CARGO_BIN_EXE_bench"));
        command.args(arguments).current_dir(folder.path()).stdout(std::process::Stdio::null());
        command.stderr(std::process::Stdio::null()).spawn().expect("the program starts")
    };
    let started: Vec<_> = ["1", "2", "3"].into_iter().map(start).collect();
    let codes: Vec<_> = started.into_iter().map(|mut run| run.wait().expect("it ends").code()).collect();
    let refused = codes.iter().filter(|code| **code == Some(2)).count();
    assert_eq!(refused, 2, "{codes:?}");
    let found = check(&folder.path().join("run"));
    assert_eq!(found.state, EvidenceState::Intact, "{:?}", found.reasons);
}

/// Every line that the evidence rests on is there once.
#[test]
fn the_journal_has_title_page_logs_and_results_on_record() {
    let (lines, closed) = journal::read(&runs().join("nominal")).expect("an intact chain");
    assert!(closed);
    let kept: Vec<&str> = lines
        .iter()
        .filter_map(|line| match &line.entry {
            Entry::Kept { file, .. } => Some(file.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!((kept.first(), kept.last()), (Some(&"run.json"), Some(&"results.json")), "{kept:?}");
    for log in ["AZ-FRICTION.mcap", "AZ-LATER.mcap"] {
        assert_eq!(kept.iter().filter(|file| **file == log).count(), 1, "{kept:?}");
    }
}
