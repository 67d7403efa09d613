//! Input that is too large, too long or too extreme is refused before it costs time or memory, and what `check` accepts a
//! run does not refuse.

use std::fmt::Write;

use crate::bench::{IMPORT_MAP, Said, folder, import_csv, run_in, write};

const FRICTION: &str = include_str!("../procedures/quick/az-friction.toml");
const BREAKAWAY: &str = include_str!("../procedures/quick/az-breakaway.toml");
const STEP: &str = include_str!("../procedures/quick/az-step.toml");
const RIG: &str = include_str!("../bench/rigs/sim.toml");

/// Checks a procedure.
fn checked(text: &str) -> Said {
    let folder = folder();
    write(folder.path(), "p.toml", text);
    run_in(folder.path(), &["check", "p.toml"])
}

#[test]
fn a_multisine_whose_period_is_days_is_refused_at_its_lowest_frequency() {
    for from in ["1e-5 Hz", "1e-13 Hz"] {
        let text = BREAKAWAY.replacen("from = \"0.2 Hz\"", &format!("from = \"{from}\""), 1);
        assert_ne!(BREAKAWAY, text);
        let said = checked(&text);
        assert!(said.code == 2 && said.err.contains("times `lines`, must be at most"), "{}", said.err);
        assert!(said.err.contains("p.toml:18:8"), "{}", said.err);
    }
}

#[test]
fn lists_and_repeats_that_multiply_to_millions_are_refused_before_they_are_planned() {
    let many = format!("elevation = [{}]", "\"20 deg\", ".repeat(900));
    let text =
        STEP.replacen("elevation = [\"20 deg\"]", &many, 1).replacen("repeats = 5", "repeats = 10000", 1);
    assert!(text.contains(&many) && text.contains("10000"));
    let said = checked(&text);
    assert!(said.code == 2 && said.err.contains("steps; expected at most 10000"), "{}", said.err);
}

#[test]
fn a_file_that_nobody_wrote_is_refused_by_its_size() {
    let text = (0..200_000).fold(String::from("schema = 1\n"), |mut text, k| {
        let _ = writeln!(text, "key{k} = 1");
        text
    });
    let said = checked(&text);
    assert!(said.code == 2 && said.err.contains("expected at most 1048576"), "{}", said.err);
    assert!(said.err.lines().count() < 5, "{}", said.err);
}

#[test]
fn of_thousands_of_unknown_keys_the_first_are_told_and_the_rest_counted() {
    let keys = (0..80_000).fold(String::new(), |mut text, k| {
        let _ = writeln!(text, "key{k} = 1");
        text
    });
    let said = checked(&format!("{keys}{FRICTION}"));
    assert_eq!(said.code, 2);
    assert!(
        said.err.contains("and 79900 more mistakes in this file"),
        "{}",
        &said.err[said.err.len() - 300..]
    );
    assert_eq!(said.err.matches("unknown key").count() + said.err.matches("must be").count(), 100);
}

#[test]
fn a_loop_rate_that_no_drive_can_be_told_is_refused_by_check_as_by_run() {
    let folder = folder();
    write(folder.path(), "rig.toml", &RIG.replacen("loop-rate = \"4 kHz\"", "loop-rate = \"3 kHz\"", 1));
    for verb in [&["check"][..], &["plan"], &["run", "--out", "run"]] {
        let arguments: Vec<&str> =
            verb.iter().chain(&["quick/self-check-open", "--rig", "./rig.toml"]).copied().collect();
        let said = run_in(folder.path(), &arguments);
        assert!(
            said.code == 2 && said.err.contains("rig.toml:5:13") && said.err.contains("60C2h"),
            "{}",
            said.err
        );
    }
}

#[test]
fn what_a_device_refuses_when_it_is_opened_check_and_plan_say_before() {
    let folder = folder();
    write(
        folder.path(),
        "rig.toml",
        &RIG.replacen("rated-torque = \"120 N*m\"", "rated-torque = \"130 N*m\"", 1),
    );
    for verb in ["check", "plan"] {
        let said = run_in(folder.path(), &[verb, "quick/self-check-open", "--rig", "./rig.toml"]);
        assert!(said.code == 2 && said.err.contains("after opening its devices"), "{verb}: {}", said.err);
    }
    write(
        folder.path(),
        "rig.toml",
        &RIG.replacen("parameters = \"director\"", "parameters = \"directer\"", 1),
    );
    let said = run_in(folder.path(), &["check", "quick/self-check-open", "--rig", "./rig.toml"]);
    assert!(said.code == 2 && said.err.contains("did you mean `director`"), "{}", said.err);
}

#[test]
fn values_and_times_that_no_log_holds_are_refused_with_their_line() {
    let rows = "t,angle,i\n0,1,0\n1,2,0\n2,3,0\n";
    let scaled = IMPORT_MAP.replacen("\"deg\"", "\"deg\"\nscale = \"3.6e302\"", 1);
    let rated = IMPORT_MAP.replacen("\"column\"\ntime-column = \"t\"", "\"rate\"\nrate = \"1e-12 Hz\"", 1);
    for (map, csv, expected) in [
        (
            scaled.as_str(),
            rows,
            "d.csv:2: column `angle`: expected at most 1e30 in SI units, found 1e0 times",
        ),
        (IMPORT_MAP, "t,angle,i\n0,1,0\n1e12,2,0\n", "d.csv:3: expected a segment of at most"),
        (
            IMPORT_MAP,
            "t,angle,i\n0,1,0\n1e-12,2,0\n",
            "d.csv:3: expected at least 0.000000001 s from row to row",
        ),
        (rated.as_str(), rows, "d.csv:3: expected a segment of at most"),
    ] {
        let folder = folder();
        let said = import_csv(folder.path(), map, csv);
        assert!(said.code == 2 && said.err.contains(expected), "{}: {}", said.code, said.err);
    }
}

#[test]
fn a_line_that_is_no_row_of_numbers_is_refused_before_it_is_gathered() {
    let folder = folder();
    let said =
        import_csv(folder.path(), IMPORT_MAP, &format!("t,angle,i\n0,1,0\n{}\n", "1,".repeat(100_000)));
    assert!(said.code == 2 && said.err.contains("line 3 has more than 65536 bytes"), "{}", said.err);
}

#[test]
fn a_slow_record_is_no_chunk_a_row() {
    let folder = folder();
    let rows = (0..20_000).fold(String::from("t,angle,i\n"), |mut rows, k| {
        let _ = writeln!(rows, "{k},{},0", k % 7);
        rows
    });
    let said = import_csv(folder.path(), IMPORT_MAP, &rows);
    assert_eq!(said.code, 0, "{}", said.err);
    let log = std::fs::metadata(folder.path().join("log/ODRIVE-COGGING.mcap")).expect("a log");
    assert!(log.len() < 4 * rows.len() as u64, "{} bytes of {}", log.len(), rows.len());
}
