//! Verdicts of the quick campaign: the nominal unit passes, a planted defect fails, and only where it must.

use crate::bench::{folder, run_in, verdict};

const MUST_MEASURE: [&str; 13] = [
    "FRC-AZ", "FRC-EL", "UNB-AZ", "UNB-EL", "SPR-AZ", "SPR-EL", "HOLD-EL", "COG-AZ", "COG-EL", "FSM-BW",
    "FSM-STR", "FSM-MODE", "FSM-CH",
];

#[test]
fn nominal_unit_passes_the_quick_campaign() {
    let folder = folder();
    let said = run_in(folder.path(), &["run", "--out", "run", "--non-interactive"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    let run = folder.path().join("run");
    for id in MUST_MEASURE {
        assert_eq!(verdict(&run, id), "pass", "{id}\n{}", said.out);
    }
    for file in
        ["run.json", "journal.jsonl", "results.json", "report.html", "junit.xml", "results.csv", "report.md"]
    {
        assert!(run.join(file).is_file(), "{file} is missing");
    }
}

#[test]
fn azimuth_retainer_fails_frc_az_and_only_what_its_friction_costs() {
    let folder = folder();
    let said =
        run_in(folder.path(), &["run", "--unit", "azimuth-retainer", "--out", "run", "--non-interactive"]);
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "FRC-AZ"), "fail", "{}", said.out);
    // `may-flip` of its file: 1280 N*m of friction at 60 deg/s.
    let may = ["MOT-CUR-AZ", "MOT-ACC", "MOT-CUE", "MOT-DUTY", "PWR-BUS"];
    for id in MUST_MEASURE.into_iter().filter(|id| *id != "FRC-AZ" && !may.contains(id)) {
        assert_eq!(verdict(&run, id), "pass", "{id}\n{}", said.out);
    }
}

#[test]
fn as_measured_unit_passes_what_quick_measures() {
    let folder = folder();
    let said = run_in(folder.path(), &["run", "--unit", "as-measured", "--out", "run", "--non-interactive"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
}
