//! `bench rtcheck`: whatever this computer is like, it is measured and said.

use crate::bench::{folder, run_in};

#[test]
fn rtcheck_measures_this_computer_and_its_exit_code_is_its_verdict() {
    let folder = folder();
    let said = run_in(folder.path(), &["rtcheck", "--rate", "1kHz", "--seconds", "0.1"]);
    let verdict = match said.code {
        0 => "1 kHz is held",
        3 => "1 kHz is NOT held",
        other => panic!("exit code {other}: {}", said.err),
    };
    assert!(said.out.trim_end().ends_with(verdict), "{}", said.out);
    for part in ["real-time priority", "locked memory", "clocksource", "Lateness of ticks", "8 kHz"] {
        assert!(said.out.contains(part), "{part}: {}", said.out);
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 0, "it writes no file");
}

#[test]
fn rtcheck_as_json_has_rights_facts_and_every_loop() {
    let folder = folder();
    let args = ["rtcheck", "--rate", "500 Hz", "--seconds", "0.05", "--interface", "no-such-0", "--json"];
    let said = run_in(folder.path(), &args);
    let value: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(said.code, if value["holds"] == true { 0 } else { 3 }, "{}", said.err);
    assert_eq!(value["measured"].as_array().map(Vec::len), Some(10), "five rates, empty and with work");
    assert_eq!(value["facts"]["interface"]["exists"], false);
    assert_eq!(value["grants"].as_array().map(Vec::len), Some(5));
    assert!(value["advice"].to_string().contains("no-such-0"), "{}", value["advice"]);
}

#[test]
fn rtcheck_refuses_what_cannot_be_measured() {
    let folder = folder();
    for args in [["--rate", "4"], ["--rate", "1 MHz"], ["--seconds", "0"], ["--seconds", "soon"]] {
        let said = run_in(folder.path(), &["rtcheck", args[0], args[1]]);
        assert_eq!(said.code, 2, "{args:?}: {}", said.err);
        assert!(said.err.contains("expected"), "{}", said.err);
    }
}
